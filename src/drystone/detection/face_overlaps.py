"""The area that two facing patches share, in the plane halfway between them.

Blocks that overlap: pairs, shared volume, depth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, marked, plane_cross
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.ragged import BATCH, Ragged, expand
from drystone.detection.candidates import Pairs
from drystone.detection.patches import Patches
from drystone.detection.planes import NEGLIGIBLE, Pieces, Planes, merged, tidy
from drystone.detection.tolerances import SHOWN, millimetres
from drystone.geometry import clip, planar
from drystone.geometry.shared_volume import shared_volumes

_Rings: TypeAlias = tuple[Floats, Ints, Ints]
"""Corners (l, 2), ring starts (r + 1,) and the row of each ring (r,), ascending."""


def overlaps(patches: Patches, planes: Planes) -> Pieces:
    """Areas that the projections of the two patches of each pair share, without holes.

    Overlaps as narrow as rounding are left out.
    """
    one = _projected(patches, planes, planes.f, reverse=False)
    other = _projected(patches, planes, planes.g, reverse=True)
    convex = patches.convex[planes.f] & patches.convex[planes.g]
    return tidy(_shared(one, other, convex), planes)


def projections(
    patches: Patches, planes: Planes, rows: Ints
) -> tuple[planar.Regions, planar.Regions]:
    """The two patches of some planes (r,), as shapely regions in the plane of each."""
    one = _projected(patches, planes, planes.f, reverse=False)
    other = _projected(patches, planes, planes.g, reverse=True)
    return _regions(one, rows), _regions(other, rows)


def _projected(patches: Patches, planes: Planes, patch: Ints, *, reverse: bool) -> _Rings:
    """Rings of one patch per plane, in the plane, outlines counter-clockwise."""
    rings = np.diff(patches.first_ring)[patch]
    row, ring = expand(patches.first_ring[patch], rings)
    length = np.diff(patches.ring_start)[ring]
    of_corner, corner = expand(patches.ring_start[ring], length)
    start = Ragged.from_counts(length).start
    if reverse:
        corner = corner[(start[:-1] + start[1:] - 1)[of_corner] - np.arange(len(corner))]
    return planes.flat(patches.corner[corner], row[of_corner]), start, row


def _shared(one: _Rings, other: _Rings, convex: Bools) -> Pieces:
    """Intersections of regions, row by row; ``convex`` where both are one convex ring."""
    parts = []
    for size in _size_classes(one, other, convex):
        polygons = clip.intersect_convex(_padded(one, size), _padded(other, size))
        corner, start = clip.flatten(polygons)
        parts.append(Pieces(corner, start, size))
    rest = np.flatnonzero(~convex)
    if len(rest):
        shapes = planar.overlay(shapely.intersection, _regions(one, rest), _regions(other, rest))
        corner, start, row = planar.pieces_of(shapes)
        parts.append(Pieces(corner, start, rest[row]))
    return merged(parts)


def _size_classes(one: _Rings, other: _Rings, convex: Bools) -> list[Ints]:
    """Rows of convex pairs with similar numbers of corners, so that padding stays small."""
    rows = np.flatnonzero(convex)
    if len(rows) == 0:
        return []
    count = np.maximum(_corner_count(one, rows), _corner_count(other, rows))
    grade = np.ceil(np.log2(count)).astype(np.intp)
    classes = []
    for each in np.unique(grade):
        mine = rows[grade == each]
        step = max(BATCH // 2 ** (1 + int(each)), 1)
        classes += [mine[i : i + step] for i in range(0, len(mine), step)]
    return classes


def _corner_count(rings: _Rings, rows: Ints) -> Ints:
    return np.diff(rings[1])[np.searchsorted(rings[2], rows)]


def _padded(rings: _Rings, rows: Ints) -> clip.Padded:
    corner, start, row = rings
    ring = np.searchsorted(row, rows)
    return clip.pad(corner, start[ring], np.diff(start)[ring])


def _regions(rings: _Rings, rows: Ints) -> planar.Regions:
    """Shapely regions of some rows."""
    corner, start, row = rings
    first, last = np.searchsorted(row, rows), np.searchsorted(row, rows, side="right")
    region, ring = expand(first, last - first)
    length = np.diff(start)[ring]
    picked = expand(start[ring], length)[1]
    begin = Ragged.from_counts(length).start
    return planar.regions(corner[picked], begin, region)


def _is_convex(corner: Floats, start: Ints) -> Bools:
    loops = Ragged(start)
    edge = corner[loops.following] - corner
    after = edge[loops.following]
    turn = plane_cross(edge, after)
    return loops.all(turn >= 0.0)


def joint_width(pieces: Pieces, pair: Ints, curved: Bools) -> Floats:
    """Width (s,) [m] of each polygon; of facets of a curved joint, that of the whole joint.

    Parameters
    ----------
    pair, curved : (q,) per plane
    """
    _, place = np.unique(pair[pieces.row], return_inverse=True)
    facet = curved[pieces.row]
    area = np.bincount(place.ravel(), np.where(facet, pieces.area, 0.0))
    return np.where(facet, np.sqrt(area)[place.ravel()], pieces.width)


def negligible(patches: Patches, planes: Planes, pieces: Pieces) -> Bools:
    """Whether each polygon is a sliver beside a wide one of the same patch and the same blocks.

    With rounded coordinates a patch also overlaps the neighbours of its counterpart.
    """
    width = pieces.width
    f, g = planes.f[pieces.row], planes.g[pieces.row]
    widest = np.zeros(pieces.count)
    for patch, other in ((f, patches.owner[g]), (g, patches.owner[f])):
        _, key = np.unique(patch * len(patches.size) + other, return_inverse=True)
        most = np.zeros(pieces.count)
        np.maximum.at(most, key, width)
        widest = np.maximum(widest, most[key])
    return width < NEGLIGIBLE * widest


def within(pieces: Pieces, planes: Planes, tolerance: Floats) -> Pieces:
    """The part of each polygon in which the gap stays within a tolerance.

    Parameters
    ----------
    tolerance : (q,) [m] per plane
    """
    row = pieces.corner_row
    over = np.abs(planes.gap_at(pieces.corner, row)) > tolerance[row]
    piece = np.repeat(np.arange(pieces.count), np.diff(pieces.start))
    beyond = np.bincount(piece, over, minlength=pieces.count) > 0
    if not beyond.any():
        return pieces
    part = pieces.select(beyond)
    band = _bands(part, planes, tolerance)
    clipped = _shared(
        (part.corner, part.start, np.arange(part.count)),
        band,
        _is_convex(part.corner, part.start),
    )
    inside = Pieces(clipped.corner, clipped.start, part.row[clipped.row])
    return tidy(merged([pieces.select(~beyond), inside]), planes)


def _bands(pieces: Pieces, planes: Planes, tolerance: Floats) -> _Rings:
    """A rectangle per polygon that covers all its points with a gap within the tolerance."""
    slope = planes.slope[pieces.row]
    steep = np.hypot(slope[:, 0], slope[:, 1])
    apart = steep * 1e9 * planes.size[pieces.row] < np.abs(planes.gap[pieces.row])
    safe = np.where(apart, 1.0, steep)
    along = np.where(apart[:, None], [1.0, 0.0], slope / safe[:, None])
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    # parallel planes with too large a gap: the band is placed far away
    offset = np.where(apart, 1e9 * planes.size[pieces.row], -planes.gap[pieces.row] / safe)
    half = tolerance[pieces.row] / safe
    piece = np.repeat(np.arange(pieces.count), np.diff(pieces.start))
    far = np.zeros(pieces.count)
    np.maximum.at(far, piece, np.abs(pieces.corner).sum(axis=1))
    near, away = offset - half, offset + half
    corner = np.stack(
        [
            near[:, None] * along - far[:, None] * across,
            away[:, None] * along - far[:, None] * across,
            away[:, None] * along + far[:, None] * across,
            near[:, None] * along + far[:, None] * across,
        ],
        axis=1,
    ).reshape(-1, 2)
    count = np.arange(pieces.count + 1, dtype=np.intp)
    return corner, 4 * count, count[:-1]


_REFUSED = 0.1
"""Models with blocks that share more than this part of the smaller one are refused. Chosen: far
above the overlaps that rounded coordinates and warped faces cause."""


@dataclass(frozen=True)
class Overlap(OneLine):
    """Two blocks that share volume.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    depth : [m]
        For convex blocks: the shortest translation that separates them. Otherwise: the largest
        distance from a surface point of one block, inside the other, to the surface of the other.
    volume : [m3]
        The shared volume.
    share
        The shared volume divided by the volume of the smaller block.
    """

    block_a: int
    block_b: int
    depth: float
    volume: float
    share: float


def block_overlaps(
    assembly: Assembly, patches: Patches, pairs: Pairs, joined: Ints, tolerance: Floats
) -> tuple[Overlap, ...]:
    """Pairs of blocks that overlap deeper than the tolerance.

    Parameters
    ----------
    pairs
        Near blocks, a < b.
    joined : (j,)
        Positions in ``pairs`` of those with a face contact: its plane separates convex blocks.
    tolerance : (p,) [m] per pair
    """
    a, b = pairs
    low, high = patches.boxes
    near = (np.minimum(high[a], high[b]) - np.maximum(low[a], low[b])).min(axis=1) > tolerance
    parted = marked(joined, len(a))
    near &= ~(parted & patches.block_convex[a] & patches.block_convex[b])
    if not near.any():
        return ()
    a, b = a[near], b[near]
    faces = replace(assembly.faces, point=assembly.faces.point - patches.origin)
    found = shared_volumes(faces, a, b, tolerance[near], patches.block_convex)
    a, b = a[found.row], b[found.row]
    share = found.volume / np.minimum(assembly.volume[a], assembly.volume[b])
    columns = (a.tolist(), b.tolist(), found.depth.tolist(), found.volume.tolist(), share.tolist())
    return tuple(Overlap(*each) for each in zip(*columns, strict=True))


def overlap_lines(names: Sequence[str], overlaps: Sequence[Overlap]) -> list[str]:
    """A sentence for each of the first pairs of overlapping blocks, the largest share first."""
    worst = sorted(overlaps, key=lambda pair: (-pair.share, -pair.depth))
    lines = [f"{_named(names, pair)} overlap: they share {_common(pair)}" for pair in worst[:SHOWN]]
    if len(worst) > SHOWN:
        left = len(worst) - SHOWN
        lines.append(counted(left, "more pair of blocks overlaps", "more pairs of blocks overlap"))
    return lines


def require_apart(names: Sequence[str], overlaps: Sequence[Overlap]) -> None:
    """Refuse blocks that share more than a tenth of the smaller one.

    Raises
    ------
    InputError
        There are such blocks; the pair with the largest share is named.
    """
    refused = [pair for pair in overlaps if pair.share > _REFUSED]
    if not refused:
        return
    worst = max(refused, key=lambda pair: (pair.share, pair.depth))
    more = ""
    if len(refused) > 1:
        others = counted(len(refused) - 1, "more pair overlaps", "more pairs overlap")
        more = f"; {others} by more than a tenth"
    raise InputError(
        f"overlap: they share {_common(worst)}{more}",
        where=_named(names, worst),
        remedy="move them apart in the model, or accept them with --anyway (anyway=True in Python)",
    )


def _named(names: Sequence[str], pair: Overlap) -> str:
    return f"blocks '{names[pair.block_a]}' and '{names[pair.block_b]}'"


def _common(pair: Overlap) -> str:
    share = f"{float(f'{100.0 * pair.share:.2g}'):g} % of the smaller one"
    return f"{pair.volume:.3g} m3 ({share}), {millimetres(pair.depth)} mm deep"
