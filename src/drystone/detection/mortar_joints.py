"""Joints of mortar: a thickness that nearly all pairs of blocks are apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.ragged import Ragged
from drystone.detection.candidates import facing_patches, near_blocks
from drystone.detection.detection_options import DetectionOptions
from drystone.detection.face_overlaps import negligible, overlaps, projections
from drystone.detection.inexact import Error, Inexact
from drystone.detection.interfaces import Interfaces, from_pieces, joined
from drystone.detection.misses import NOTABLE, compare_with_tolerances
from drystone.detection.nearest import uncovered
from drystone.detection.patches import Patches
from drystone.detection.planes import Pieces, Planes, planes_between, tidy
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
    label = _connected(found, count)
    if label.max(initial=0) == 0:
        return found, []
    wide = replace(options, search=max(options.search, THICKEST))
    a, b = near_blocks(patches, wide)
    apart = label[a] != label[b]
    if np.count_nonzero(apart) < FEWEST:
        return found, []
    f, g = facing_patches(patches, (a[apart], b[apart]), wide)
    order = np.lexsort((g, f, patches.owner[g], patches.owner[f]))
    planes = planes_between(patches, f[order], g[order])
    shared = overlaps(patches, planes)
    checked = compare_with_tolerances(patches, planes, shared, options)
    gap = Ragged(shared.start).mean(planes.gap_at(shared.corner, shared.corner_row))
    keep = ~(checked.too_steep | checked.too_warped) & ~negligible(patches, planes, shared)
    keep &= (shared.width > NOTABLE * planes.size[shared.row]) & (gap > 0.0)
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
    told: dict[int, float] = {}
    for key, off in zip(pair[alike].tolist(), gap[alike].tolist(), strict=True):
        told[key] = max(off, told.get(key, 0.0))
    inexact = [Inexact(*divmod(key, count), Error.MORTAR, off) for key, off in told.items()]
    return joined([found, new]), inexact


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


def _connected(found: Interfaces, count: int) -> Ints:
    """The first block (n,) of the connected group of each block."""
    first = np.arange(count, dtype=np.intp)
    while True:  # every block takes over the number of the lowest one that it touches, and its
        lower = first.copy()
        np.minimum.at(lower, found.block_a, first[found.block_b])
        np.minimum.at(lower, found.block_b, first[found.block_a])
        lower = lower[lower]
        if np.array_equal(lower, first):
            return first
        first = lower


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
    alike: Bools = same[place] & (np.abs(gap - typical) <= ALIKE * typical)
    return alike
