"""Joints that small errors of a drawing keep apart: overlaps, and gaps as small as these.

An exact drawing has no overlaps. So where blocks overlap, the drawing is off, by the depth of the
overlap, and they are meant to touch. A gap may be meant; it is closed only where overlaps of one of
its blocks, or nearly all joints of the drawing, show that it is off by as much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, lengths, marked
from drystone.base.ragged import BATCH, Ragged
from drystone.detection.candidates import NEAR_BESIDE, Pairs, facing_patches, fits, reach_of_patches
from drystone.detection.edgecontacts import edge_contacts
from drystone.detection.face_overlaps import (
    Overlap,
    block_overlaps,
    joint_width,
    negligible,
    within,
)
from drystone.detection.interfaces import Interfaces, from_pieces, joined
from drystone.detection.misses import (
    EXPLAINED,
    Error,
    Inexact,
    compared,
    inexact_pairs,
    missed_of,
)
from drystone.detection.mortar_joints import join_by_mortar, join_warped
from drystone.detection.patches import EXACT, Patches
from drystone.detection.planes import NEGLIGIBLE, uncovered
from drystone.detection.tolerances import LARGEST, DetectionOptions, EdgeContacts, Missed, Reason

DEEPEST = 0.08
"""Overlaps up to this share of the thinnest dimension of the smaller block are joined. Chosen: a
leg of 40 mm that is 3 mm deep in the floor."""
NOISE = 3.0
"""Gaps up to the largest error near them times this are closed. Measured (benchmarks/perturbed.py):
with 2 one drawing in 30 keeps a gap that its exact model does not have, with 3 one in 100."""
MEANT = 0.5
"""[deg] Faces with a larger angle may be meant so. Chosen: two blocks that are each turned by 0.2
degrees are within."""
ALIKE = 0.9
"""Edges and corners of one pair are joined when the cosine between their normals is larger. Chosen:
where two edges have passed each other it is zero, and nobody can say which face is meant."""


def join_inexact(
    assembly: Assembly,
    patches: Patches,
    found: Interfaces,
    missed: Sequence[Missed],
    overlapping: Sequence[Overlap],
    options: DetectionOptions,
) -> tuple[Interfaces, list[Inexact], list[Missed]]:
    """Join pairs of blocks that overlap a little, and those as little apart.

    Nothing is done unless pairs overlap, are within tolerance on a part only, or miss each other
    narrowly: an exact drawing is not looked at again.

    Parameters
    ----------
    found
        Interfaces within the tolerances.
    missed, overlapping
        What the search found besides.

    Returns
    -------
    found
        With the joints that are added.
    inexact
    missed
        What is still not joined, with the joints that are within tolerance on a part only.
    """
    found, fans = join_warped(assembly, patches, found, missed, options)
    found, near, partly = _join_near(assembly, patches, found, missed, overlapping, options)
    found, mortar = join_by_mortar(patches, found, options)
    told = [*fans, *near, *mortar]
    found = found.ordered()
    return found, told, [*_left(missed, told, found, len(patches.size)), *partly]


def _join_near(
    assembly: Assembly,
    patches: Patches,
    found: Interfaces,
    missed: Sequence[Missed],
    overlapping: Sequence[Overlap],
    options: DetectionOptions,
) -> tuple[Interfaces, list[Inexact], list[Missed]]:
    """The interfaces with those of blocks that overlap, or are apart, a little."""
    count = len(patches.size)
    deep_pairs = np.array([p.block_a * count + p.block_b for p in overlapping], dtype=np.intp)
    near = [
        miss.block_a * count + miss.block_b
        for miss in missed
        if miss.reason in (Reason.GAP, Reason.OVERLAP) and not miss.farther(options.search)
    ]
    clipped = found.block_a[found.clipped] * count + found.block_b[found.clipped]
    keys = np.unique(np.concatenate([deep_pairs, np.array(near, dtype=np.intp), clipped]))
    if len(keys) == 0:
        return found, [], []
    new, inexact, partly = _faces(assembly, patches, found, keys, deep_pairs, options)
    kept = ~np.isin(_keys(found, count), _keys(new, count))
    found = joined([found.take(np.flatnonzero(kept)), new])
    lines = _lines(assembly, patches, found, deep_pairs, options)
    inexact += [
        Inexact(int(a), int(b), Error.OVERLAP, float(-gap))
        for a, b, gap in zip(lines.block_a, lines.block_b, lines.gap, strict=True)
    ]
    return joined([found, lines]), inexact, partly


def thinnest(assembly: Assembly, patches: Patches) -> Floats:
    """The thinnest dimension (n,) [m] of each block: volume by largest face, or 6 V / A if less."""
    largest = patches.of_block.max(patches.area)
    return np.minimum(assembly.volume / largest, patches.size)


def _keys(found: Interfaces, count: int) -> Ints:
    return found.block_a * count + found.block_b


def _faces(
    assembly: Assembly,
    patches: Patches,
    found: Interfaces,
    keys: Ints,
    deep_pairs: Ints,
    options: DetectionOptions,
) -> tuple[Interfaces, list[Inexact], list[Missed]]:
    """All interfaces with an area of inexact pairs; what is within tolerance on a part."""
    count = len(patches.size)
    a, b = np.divmod(keys, count)
    farther = replace(options, search=max(options.search, DEEPEST))
    f, g = facing_patches(patches, (a, b), farther)
    checked = compared(patches, f, g, options)
    planes, shared = checked.planes, checked.shared
    pair = patches.owner[planes.f] * count + patches.owner[planes.g]
    limit = _limits(assembly, patches, keys)[np.searchsorted(keys, pair)] + checked.slack
    limit = np.maximum(limit, checked.tolerance)

    row, corners = shared.row, Ragged(shared.start)
    gap = planes.gap_at(shared.corner, shared.corner_row)
    least, most, mean = corners.min(gap), corners.max(gap), corners.mean(gap)
    good = ~(checked.too_steep | checked.too_warped) & ~negligible(patches, planes, shared)
    deep_facets = fits(patches, planes.f, planes.g) & np.isin(pair, deep_pairs)
    width = joint_width(shared, pair, deep_facets)
    good &= width > NEGLIGIBLE * planes.size[row]
    convex = patches.block_convex
    deep = good & (least < -checked.tolerance[row]) & (mean >= -limit[row])
    deep &= width > -2.0 * mean  # of two faces that a corner has passed, the wider counts
    solid = np.isin(pair, deep_pairs)
    solid |= convex[patches.owner[planes.f]] & convex[patches.owner[planes.g]]
    doubtful = np.unique(pair[row[deep & ~solid[row]]])  # thin parts may lie behind each other
    solid |= np.isin(pair, _sharing_volume(assembly, patches, doubtful))
    deep &= solid[row]
    bare = _covered(patches, found, keys) < EXPLAINED * patches.area
    depth = -mean - checked.slack[row]
    off = _overlap_within(patches, found)
    for side in (planes.f, planes.g):
        np.maximum.at(off, patches.owner[side[row[deep]]], depth[deep])
    open_ones = good & (bare[planes.f] & bare[planes.g])[row]
    open_ones &= mean - checked.slack[row] <= options.search * planes.size[row]
    spread = (most - least)[open_ones]
    tilted = spread > EXACT * planes.size[row[open_ones]]
    tilted &= np.rad2deg(checked.angle[row[open_ones]]) < MEANT
    everywhere = _error_of_all(patches, found, keys, spread, tilted)
    if everywhere > 0.0:
        off[:] = max(everywhere, float(off.max()))
    else:
        off[assembly.fixed] = 0.0  # a block in the ground says nothing of others there
    error = np.maximum(off[patches.owner[planes.f]], off[patches.owner[planes.g]])
    far = np.minimum(NOISE * error, limit - checked.slack) + checked.slack
    loose = open_ones & ~deep & (most > checked.tolerance[row]) & (mean <= far[row])
    loose &= most <= limit[row]

    taken = deep | loose
    of_row = marked(row[taken], len(pair))
    near = within(
        shared.select(taken | (checked.accepted & ~of_row[row])),
        planes,
        np.where(of_row, limit, checked.tolerance),
    )
    wide_enough = near.width > options.sliver * planes.size[near.row]
    near, _ = uncovered(
        patches, planes, near.select(wide_enough & ~negligible(patches, planes, near))
    )
    changed = np.unique(pair[near.row[of_row[near.row]]])
    near = near.select(np.isin(pair[near.row], changed))
    new = from_pieces(patches, planes, near, checked.partial & ~of_row)
    again = np.isin(pair[row], changed)
    inexact = [
        *inexact_pairs(pair[row], deep & again, np.maximum(-least, 0.0), Error.OVERLAP, count),
        *inexact_pairs(pair[row], loose & again, most, Error.GAP, count),
    ]
    clipped = good & checked.accepted & checked.partial[row] & ~np.isin(pair[row], changed)
    reach = reach_of_patches(patches, planes.f, planes.g, options, NEAR_BESIDE)
    clipped &= np.abs(mean) - checked.slack[row] <= reach[row]  # a wide face tilts far
    part = from_pieces(patches, planes, shared.select(clipped), checked.partial)
    needed = ((np.maximum(most, -least) - checked.slack[row]) / planes.size[row])[clipped]
    needed[needed > LARGEST["gap"]] = np.nan
    partly = [
        missed_of(part, i, Reason.PARTLY, float(needed[i]), True, patches.origin)
        for i in range(part.count)
    ]
    return new, inexact, partly


def _limits(assembly: Assembly, patches: Patches, keys: Ints) -> Floats:
    """How deep (p,) [m] the blocks of each pair may be in each other."""
    a, b = np.divmod(keys, len(patches.size))
    thin = thinnest(assembly, patches)
    return DEEPEST * np.minimum(thin[a], thin[b])


def _overlap_within(patches: Patches, found: Interfaces) -> Floats:
    """The deepest overlap (n,) [m] of each block, within the tolerances.

    What warp and curvature explain is no overlap.
    """
    slack = patches.warp + patches.sag
    f = patches.of_faces(found.block_a, found.face_a)
    g = patches.of_faces(found.block_b, found.face_b)
    depth = np.where(found.area > 0.0, -found.gap - slack[f] - slack[g], 0.0)
    deepest = np.zeros(len(patches.size))
    for block in (found.block_a, found.block_b):
        np.maximum.at(deepest, block, depth)
    return deepest


def _error_of_all(
    patches: Patches, found: Interfaces, keys: Ints, spread: Floats, tilted: Bools
) -> float:
    """The largest error [m] of a drawing of which hardly any joint is exact; else zero.

    Parameters
    ----------
    keys
        Pairs that are not exact: their joints count by their faces.
    spread : (s,) [m]
        How much the distance of the faces of these pairs varies.
    tilted : (s,)
        Whether it varies more than in an exact drawing, in which a gap has parallel faces.
    """
    f = patches.of_faces(found.block_a, found.face_a)
    g = patches.of_faces(found.block_b, found.face_b)
    plane = (found.area > 0.0) & ~fits(patches, f, g)
    lean = np.deg2rad(found.angle) * np.sqrt(found.area)
    off = np.maximum(np.abs(found.gap), lean)
    inexact = plane & (np.maximum(off, found.warp) > EXACT * found.size) & (found.angle < MEANT)
    others = plane & ~np.isin(_keys(found, len(patches.size)), keys)
    shown = np.count_nonzero(inexact & others) + np.count_nonzero(tilted)
    if 2 * shown <= np.count_nonzero(others) + len(tilted):
        return 0.0
    slack = patches.warp[f] + patches.warp[g]
    return float(max((off - slack)[inexact].max(initial=0.0), spread[tilted].max(initial=0.0)))


def _sharing_volume(assembly: Assembly, patches: Patches, keys: Ints) -> Ints:
    """Those of some pairs that overlap."""
    a, b = np.divmod(keys, len(patches.size))
    least = EXACT * np.minimum(patches.size[a], patches.size[b])
    nothing = np.zeros(0, dtype=np.intp)
    deep = block_overlaps(assembly, patches, (a, b), nothing, least)
    count = len(patches.size)
    return np.array([pair.block_a * count + pair.block_b for pair in deep], dtype=np.intp)


def _covered(patches: Patches, found: Interfaces, keys: Ints) -> Floats:
    """Area (p,) [m2] of each patch in contact, but for the contacts of some pairs."""
    other = found.take(np.flatnonzero(~np.isin(_keys(found, len(patches.size)), keys)))
    covered = np.zeros(patches.count)
    np.add.at(covered, patches.of_faces(other.block_a, other.face_a), other.area)
    np.add.at(covered, patches.of_faces(other.block_b, other.face_b), other.area)
    return covered


def _lines(
    assembly: Assembly,
    patches: Patches,
    found: Interfaces,
    deep_pairs: Ints,
    options: DetectionOptions,
) -> Interfaces:
    """Edges and corners that are a little deep in a block, of blocks that touch nothing else."""
    count = len(patches.size)
    alone = np.ones(count, dtype=bool)
    alone[found.block_a] = alone[found.block_b] = False
    a, b = np.divmod(deep_pairs, count)
    chosen = np.flatnonzero(alone[a] | alone[b])
    if options.edges is EdgeContacts.NEVER:
        chosen = chosen[:0]
    pairs: Pairs = a[chosen], b[chosen]
    deepest = DEEPEST * np.minimum(patches.size[pairs[0]], patches.size[pairs[1]])
    lines, _ = edge_contacts(assembly, patches, pairs, deepest, options)
    limit = _limits(assembly, patches, deep_pairs)
    order = np.argsort(deep_pairs)
    mine = order[np.searchsorted(deep_pairs[order], _keys(lines, count))]
    normal, key = lines.frame[:, 0], _keys(lines, count)
    unclear = np.zeros(lines.count, dtype=bool)
    for k in np.unique(key):
        here = np.flatnonzero(key == k)
        several = max(BATCH // len(here), 1)
        unclear[here] = any(
            (normal[here[i : i + several]] @ normal[here].T).min() < ALIKE
            for i in range(0, len(here), several)
        )
    keep = (lines.gap < 0.0) & (-lines.gap <= limit[mine]) & ~unclear
    return lines.take(np.flatnonzero(keep))


def strips(found: Interfaces, count: int) -> list[Missed]:
    """The only joints of blocks that are in each other along a strip as narrow as that may be deep.

    Which faces press there is not known: a beam that is sunk deeper than it bears is joined by its
    end, and by its bed it would stand.

    Parameters
    ----------
    found
    count
        Number of blocks.
    """
    within = (-found.gap > EXACT * found.size) & (found.area > 0.0)
    if not within.any():
        return []
    corners = Ragged(found.start)
    half = 0.5 * corners.sum(lengths(found.point[corners.following] - found.point))
    _, number, often = np.unique(_keys(found, count), return_inverse=True, return_counts=True)
    # the wider of two faces counts that a corner has passed, as above
    narrow = found.area <= np.maximum(DEEPEST * found.size, -2.0 * found.gap) * half
    return [
        Missed.overlap(
            int(found.block_a[i]), int(found.block_b[i]), -float(found.gap[i]), joined=True
        )
        for i in np.flatnonzero(within & narrow & (often[number] == 1)).tolist()
    ]


def _left(
    missed: Sequence[Missed], told: Sequence[Inexact], found: Interfaces, count: int
) -> list[Missed]:
    """What is still missed of the faces, and whether their blocks are joined now."""
    four = zip(found.block_a, found.block_b, found.face_a, found.face_b, strict=True)
    faces = {tuple(map(int, each)) for each in four}
    pairs = set(_keys(found, count).tolist())
    new = {(pair.block_a, pair.block_b) for pair in told}
    return [
        replace(miss, joined=miss.joined or miss.block_a * count + miss.block_b in pairs)
        for miss in missed
        if (miss.block_a, miss.block_b) not in new
        or (miss.block_a, miss.block_b, miss.face_a, miss.face_b) not in faces
    ]
