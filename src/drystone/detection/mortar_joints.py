"""Joints of mortar: a thickness that nearly all pairs of blocks are apart.

Joints of warped faces, which are taken as fans of triangles about the middle of their corners.

Two faces with the same corners have the same fan, wherever their loops begin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Bools, Floats, Ints, cross
from drystone.base.ragged import Ragged, first_linked
from drystone.detection.candidates import facing_patches, near_blocks
from drystone.detection.face_overlaps import negligible, projections
from drystone.detection.interfaces import Interfaces, from_pieces, joined
from drystone.detection.misses import Error, Inexact, compared, face_contacts, inexact_pairs
from drystone.detection.patches import EXACT, Patches, patches_of
from drystone.detection.planes import NEGLIGIBLE, Pieces, Planes, tidy, uncovered
from drystone.detection.tolerances import DetectionOptions, Missed, Reason
from drystone.geometry import planar

THICKEST = 0.2
"""The thickest mortar, by the size of a block. Chosen: 15 mm between bricks of 65 mm is 0.14."""
FEWEST = 4
"""Pairs that have to be apart. Chosen: of fewer, nobody can say that they are alike."""
ALIKE = 0.2
"""Thicknesses within this share of their median are the same. Chosen: 10 mm, give or take 2."""
NEARLY_ALL = 0.9
"""Share of the pairs that have to show it, chosen."""


def join_by_mortar(
    patches: Patches, found: Interfaces, options: DetectionOptions
) -> tuple[Interfaces, list[Inexact]]:
    """The interfaces with those across mortar, if nearly all pairs are apart by one thickness.

    Only blocks that are not connected by contacts already are looked at.
    """
    count = len(patches.size)
    label = first_linked(found.block_a, found.block_b, count)
    if label.max(initial=0) == 0:
        return found, []
    wide = replace(options, search=max(options.search, THICKEST))
    a, b = near_blocks(patches, wide)
    apart = label[a] != label[b]
    if np.count_nonzero(apart) < FEWEST:
        return found, []
    f, g = facing_patches(patches, (a[apart], b[apart]), wide)
    checked = compared(patches, f, g, options)
    planes, shared = checked.planes, checked.shared
    gap = Ragged(shared.start).mean(planes.gap_at(shared.corner, shared.corner_row))
    keep = ~(checked.too_steep | checked.too_warped) & ~negligible(patches, planes, shared)
    keep &= (shared.width > NEGLIGIBLE * planes.size[shared.row]) & (gap > 0.0)
    keep &= gap <= THICKEST * planes.size[shared.row]
    pieces, _ = uncovered(patches, planes, shared.select(keep))
    gap = Ragged(pieces.start).mean(planes.gap_at(pieces.corner, pieces.corner_row))
    pair = patches.owner[planes.f[pieces.row]] * count + patches.owner[planes.g[pieces.row]]
    alike = _one_thickness(pair, gap, len(np.unique(found.block_a * count + found.block_b)))
    if not alike.any():
        return found, []
    whole = np.zeros(len(planes.f), dtype=bool)
    spread = _spread(patches, planes, pieces.select(alike), 0.5 * float(np.median(gap[alike])))
    new = from_pieces(patches, planes, spread, whole)
    return joined([found, new]), inexact_pairs(pair, alike, gap, Error.MORTAR, count)


def _spread(patches: Patches, planes: Planes, pieces: Pieces, by: float) -> Pieces:
    """The joints with the mortar beside them, which fills half of the joints at the edges.

    Joints stay within the hull of the two faces. So two bricks of one length in running bond share
    half of it, as they do where they are drawn without joints.
    """
    rows = np.unique(pieces.row)
    one, other = projections(patches, planes, rows)
    hull = shapely.convex_hull(shapely.union(one, other))
    shapes = planar.overlay(
        shapely.intersection,
        *(shapely.buffer(shape, by, join_style="mitre") for shape in (one, other)),
    )
    corner, start, source = planar.pieces_of(planar.overlay(shapely.intersection, shapes, hull))
    return tidy(Pieces(corner, start, rows[source]), planes)


def _one_thickness(pair: Ints, gap: Floats, touching: int) -> Bools:
    """The pieces (s,) as thick as nearly all pairs are apart; none where they are not alike."""
    keys, place = np.unique(pair, return_inverse=True)
    least = np.full(len(keys), np.inf)
    np.minimum.at(least, place, gap)
    none = np.zeros(len(gap), dtype=bool)
    if len(keys) < max(FEWEST, touching):
        return none
    typical = float(np.median(least))
    same = np.abs(least - typical) <= ALIKE * typical
    if same.mean() < NEARLY_ALL:
        return none
    return same[place] & (np.abs(gap - typical) <= ALIKE * typical)


def join_warped(
    assembly: Assembly,
    patches: Patches,
    found: Interfaces,
    missed: Sequence[Missed],
    options: DetectionOptions,
) -> tuple[Interfaces, list[Inexact]]:
    """The interfaces with those of the pairs of faces that are too warped for one plane."""
    wanted = {
        (miss.block_a, miss.block_b, miss.face_a, miss.face_b)
        for miss in missed
        if miss.reason is Reason.WARP
    }
    if not wanted:
        return found, []
    chosen = np.unique([block for each in wanted for block in each[:2]]).astype(np.intp)
    blocks, faces = [], []
    for block in chosen.tolist():
        mine = slice(patches.first_patch[block], patches.first_patch[block + 1])
        warped = patches.warp[mine] > EXACT * patches.size[block]
        made, face = _fanned(assembly.blocks[block], set(patches.face[mine][warped].tolist()))
        blocks.append(made)
        faces.append(face)
    part = Assembly(tuple(blocks))
    facets = patches_of(part)
    new, _, _ = face_contacts(facets, near_blocks(facets, options), options)
    new = replace(
        new,
        face_a=_numbered(faces, new.block_a, new.face_a),
        face_b=_numbered(faces, new.block_b, new.face_b),
        block_a=chosen[new.block_a],
        block_b=chosen[new.block_b],
        point=new.point + (facets.origin - patches.origin),
    )
    four = list(
        zip(
            new.block_a.tolist(),
            new.block_b.tolist(),
            new.face_a.tolist(),
            new.face_b.tolist(),
            strict=True,
        )
    )
    keep = np.array([each in wanted for each in four], dtype=bool)
    new = new.take(np.flatnonzero(keep))
    off = {each[:2]: 0.0 for each in four if each in wanted}
    for a, b, f, g in set(four) & wanted:
        warp = max(_warp_of(patches, a, f), _warp_of(patches, b, g))
        off[a, b] = max(off[a, b], warp)
    told = [Inexact(a, b, Error.WARP, warp) for (a, b), warp in sorted(off.items())]
    return joined([found, new]), told


def _fanned(block: Block, warped: set[int]) -> tuple[Block, Ints]:
    """The block with some faces as fans, and the number of the face (f,) that each comes from."""
    vertices, number = [block.vertices], []
    faces: list[tuple[int, ...]] = []
    count = len(block.vertices)
    for i, face in enumerate(block.faces):
        corner = block.vertices[list(face)]
        middle = corner.mean(axis=0)
        if i in warped and _sees_all(corner, middle):
            after = [*face[1:], face[0]]
            faces += [(p, q, count) for p, q in zip(face, after, strict=True)]
            number += [i] * len(face)
            vertices.append(middle[None])
            count += 1
        else:
            faces.append(tuple(face))
            number.append(i)
    made = Block(np.concatenate(vertices), tuple(faces), block.name, density=block.density)
    return made, np.array(number, dtype=np.intp)


def _sees_all(corner: Floats, middle: Floats) -> bool:
    """Whether all triangles of the fan look to the same side."""
    area = cross(corner - middle, np.roll(corner, -1, axis=0) - middle)
    return bool((area @ area.sum(axis=0) > 0.0).all())


def _numbered(faces: Sequence[Ints], block: Ints, face: Ints) -> Ints:
    """The numbers of faces in the blocks as they were."""
    return np.array(
        [faces[b][f] for b, f in zip(block.tolist(), face.tolist(), strict=True)], dtype=np.intp
    )


def _warp_of(patches: Patches, block: int, face: int) -> float:
    mine = slice(patches.first_patch[block], patches.first_patch[block + 1])
    return float(patches.warp[mine][patches.face[mine] == face].max(initial=0.0))
