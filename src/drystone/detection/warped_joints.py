"""Joints of warped faces, which are taken as fans of triangles about the middle of their corners.

Two faces with the same corners have the same fan, wherever their loops begin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, Ints, cross
from drystone.detection.candidates import near_blocks
from drystone.detection.coplanar import PLANAR
from drystone.detection.detection_options import DetectionOptions
from drystone.detection.face_contacts import face_contacts
from drystone.detection.inexact import Error, Inexact
from drystone.detection.interfaces import Interfaces, joined
from drystone.detection.patches import Patches, patches_of
from drystone.detection.reasons import Missed, Reason


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
        warped = patches.warp[mine] > PLANAR * patches.size[block]
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
