"""A curved joint as plane facets: slivers merged, facets joined or divided, area kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heappop, heappush
from itertools import combinations
from typing import Any

import numpy as np
import shapely

from drystone.base.arrays import Floats, Ints, dot
from drystone.base.ragged import expand
from drystone.geometry import boxes, clip, planar
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.polygon import area_vectors

KEPT = 0.02
"""Facets are joined when the area of their projection differs from the sum of their areas by less
than this share."""
_CREASE = np.cos(np.deg2rad(35.0))
"""Facets with a larger angle at their common edge are a corner of the joint, not a curve."""
_CLOSE = 2e-3
"""Distance, relative to the block size, between the edges of neighbouring facets. Chosen: above the
difference between chords of one curve in their two planes."""
_ALONG = 0.2
"""Neighbours share at least this part of the outline of the smaller one. Chosen: facets that only
meet at a corner are not neighbours."""

STRAIGHT = 1e-6
"""Corners nearer to each other, or to the line between their neighbours, are removed; relative to
the size of a facet."""
_BATCH = 20_000
"""Pairs of facets in one batch. Chosen: bounds the memory to some 100 MB."""

_Joining = Callable[["Facet", "Facet"], float | None]
"""The cost of joining two neighbours; ``None`` where they must stay separate."""


@dataclass(frozen=True)
class Facet:
    """A plane polygon that stands for one or several given ones.

    Attributes
    ----------
    point : (c, 3) [m] counter-clockwise about ``normal``
    normal : (3,) unit
    area : [m2], of the given polygons together
    members
        Positions of the given polygons.
    """

    point: Floats
    normal: Floats
    area: float
    members: tuple[int, ...]

    @property
    def frame(self) -> Floats:
        """Rows n, u, v (3, 3)."""
        frame: Floats = frames_from_normals(self.normal[None])[0]
        return frame

    @cached_property
    def width(self) -> float:
        """Twice the area over the perimeter [m]."""
        edge = np.diff(self.point, axis=0, append=self.point[:1])
        return 2.0 * self.area / float(np.sqrt((edge * edge).sum(axis=1)).sum())


def facets_of(point: Floats, start: Ints) -> list[Facet]:
    """A facet for each polygon of corners (k, 3)."""
    vectors = area_vectors(point, start)
    area = np.sqrt((vectors * vectors).sum(axis=1))
    return [
        Facet(point[start[i] : start[i + 1]], vectors[i] / area[i], float(area[i]), (i,))
        for i in range(len(area))
    ]


def neighbours(facets: Sequence[Facet], size: float) -> dict[tuple[int, int], float]:
    """Length [m] of the common edge of each pair of neighbours (i < j)."""
    low = np.array([f.point.min(axis=0) for f in facets]) - _CLOSE * size
    high = np.array([f.point.max(axis=0) for f in facets]) + _CLOSE * size
    one, other = boxes.overlapping(low, high)
    length = common_edges(facets, one, other, size)
    found = np.flatnonzero(length > 0.0)
    pairs = zip(one[found].tolist(), other[found].tolist(), strict=True)
    return dict(zip(pairs, length[found].tolist(), strict=True))


def common_edges(facets: Sequence[Facet], one: Ints, other: Ints, size: float) -> Floats:
    """Length (q,) [m] of the common edge of pairs of facets, zero if they have none.

    Each pair is seen along its mean normal.
    """
    length = np.zeros(len(one))
    normal = np.array([facet.normal for facet in facets]).reshape(-1, 3)
    corner = np.concatenate([np.zeros((0, 3)), *(facet.point for facet in facets)])
    count = np.array([len(facet.point) for facet in facets], dtype=np.intp)
    start = np.cumsum(count) - count
    smooth = np.flatnonzero(dot(normal[one], normal[other]) >= _CREASE)
    ends = 2.0 * _CLOSE * size  # of the neighbouring edges
    for begin in range(0, len(smooth), _BATCH):
        pair = smooth[begin : begin + _BATCH]
        i, j = one[pair], other[pair]
        mean = normal[i] + normal[j]
        frame = frames_from_normals(mean / np.sqrt(dot(mean, mean))[:, None])
        origin = corner[start[i]]
        first, second = (_seen(corner, start[each], count[each], origin, frame) for each in (i, j))
        least = _ALONG * np.minimum(shapely.length(first), shapely.length(second))
        shared = np.full(len(pair), np.inf)
        for mine, theirs in ((first, second), (second, first)):
            left = np.flatnonzero(shared - ends > least)
            near = shapely.buffer(theirs[left], _CLOSE * size, join_style="mitre")
            common = planar.overlay(shapely.intersection, shapely.boundary(mine[left]), near)
            shared[left] = np.minimum(shared[left], shapely.length(common))
        shared -= ends
        length[pair] = np.where(shared > least, shared, 0.0)
    return length


def _seen(
    corner: Floats, start: Ints, count: Ints, origin: Floats, frame: Floats
) -> planar.Regions:
    """Polygons (q,), each from ``count`` corners, in the planes of frames (q, 3, 3)."""
    row, place = expand(start, count)
    local = corner[place] - origin[row]
    flat = np.einsum("lij,lj->li", frame[row, 1:], local)
    return planar.valid(shapely.polygons(shapely.linearrings(flat, indices=row)))


def _united(facets: Sequence[Facet], given: Sequence[Facet], size: float) -> Facet | None:
    """One facet that replaces several, ``None`` where no plane polygon has their area.

    Parameters
    ----------
    facets
    given
        The polygons that the members of the facets refer to.
    size : [m]
        Size of the block: it sets the width of the gaps that are closed.
    """
    members = tuple(sorted(m for facet in facets for m in facet.members))
    area = sum(given[m].area for m in members)
    normal = np.sum([given[m].area * given[m].normal for m in members], axis=0)
    normal /= np.sqrt(normal @ normal)
    middle = np.sum([given[m].area * given[m].point.mean(axis=0) for m in members], axis=0) / area
    frame = frames_from_normals(normal[None])[0]
    flat = [_flat(given[m].point, middle, frame) for m in members]
    grown = shapely.buffer(flat, _CLOSE * size, join_style="mitre")
    closed = shapely.buffer(shapely.union_all(grown), -_CLOSE * size, join_style="mitre")
    corner, start, _ = planar.pieces_of(planar.valid(np.array([closed], dtype=object)))
    corner, start = clip.cleaned(corner, start, np.full(len(start) - 1, 0.1 * _CLOSE * size))
    if len(start) != 2 or len(corner) < 3:
        return None
    if abs(float(clip.areas(corner, start)[0]) - area) > KEPT * area:
        return None
    return Facet(middle + corner @ frame[1:], normal, area, members)


def join(facets: Sequence[Facet], price: _Joining, size: float, *, until: int = 1) -> list[Facet]:
    """Neighbouring facets joined, lowest cost first, while ``price`` returns a number.

    Parameters
    ----------
    price
        Cost of joining two neighbours.
    until
        Number of facets at which to stop.
    """
    given = list(facets)
    current: dict[int, Facet] = dict(enumerate(given))
    beside: dict[int, set[int]] = {i: set() for i in current}
    offers: list[tuple[float, int, int]] = []

    def offer(i: int, j: int) -> None:
        beside[i].add(j)
        beside[j].add(i)
        cost = price(current[i], current[j])
        if cost is not None:
            heappush(offers, (cost, i, j))

    for i, j in neighbours(given, size):
        offer(i, j)
    number = len(given)
    while len(current) > until and offers:
        _, i, j = heappop(offers)
        if i not in current or j not in current:
            continue
        whole = _united([current[i], current[j]], given, size)
        if whole is None:
            continue
        around = (beside.pop(i) | beside.pop(j)) - {i, j}
        del current[i], current[j]
        current[number], beside[number] = whole, set()
        for k in sorted(around):
            beside[k] -= {i, j}
            offer(k, number)
        number += 1
    return list(current.values())


def merge_slivers(facets: Sequence[Facet], share: float, size: float) -> list[Facet]:
    """Facets narrower than ``share`` of a neighbour's width are merged into the neighbour."""

    def price(one: Facet, other: Facet) -> float | None:
        narrow, wide = sorted((one.width, other.width))
        return narrow / wide if narrow < share * wide else None

    return join(facets, price, size)


def join_by_angle(facets: Sequence[Facet], angle: float, size: float) -> list[Facet]:
    """Join neighbours while all members are within ``angle`` [rad] of the mean normal."""
    given = list(facets)

    def price(one: Facet, other: Facet) -> float | None:
        normal = one.area * one.normal + other.area * other.normal
        normal /= np.sqrt(normal @ normal)
        worst = min(float(given[m].normal @ normal) for m in one.members + other.members)
        turn = float(np.arccos(min(worst, 1.0)))
        return turn if turn <= angle else None

    return join(given, price, size)


def join_to_count(facets: Sequence[Facet], count: int, size: float) -> list[Facet]:
    """Neighbours are joined, small ones first, until ``count`` are left or no two can be joined."""
    return join(facets, lambda one, other: one.area + other.area, size, until=count)


def divide_to_count(facets: Sequence[Facet], count: int) -> list[Facet]:
    """The largest facet is cut in half across its length, until there are ``count``."""
    current = list(facets)
    while len(current) < count:
        largest = max(range(len(current)), key=lambda i: current[i].area)
        current[largest : largest + 1] = _halves(current[largest])
    return current


def _halves(facet: Facet) -> list[Facet]:
    """Two facets of the same area, more where the facet is concave there."""
    frame, origin = facet.frame, facet.point[0]
    local = (facet.point - origin) @ frame[1:].T
    spans = [
        (float(((local[i] - local[j]) ** 2).sum()), i, j)
        for i, j in combinations(range(len(local)), 2)
    ]
    edge = np.diff(local, axis=0, append=local[:1])
    length = np.sqrt((edge * edge).sum(axis=1))
    along = edge[int(np.argmax(length))] / length.max()
    place = local @ along
    shape = shapely.polygons(local)
    tiny = STRAIGHT * float(np.sqrt(facet.area))
    low, high = float(place.min()), float(place.max())
    across = np.array([-along[1], along[0]]) * 2.0 * np.sqrt(max(spans)[0])
    for _ in range(50):  # bisection for the line that halves the area
        middle = 0.5 * (low + high)
        part = planar.overlay(
            shapely.intersection, shape, _strip(place.min(), middle, along, across)
        )
        low, high = (middle, high) if shapely.area(part) < 0.5 * facet.area else (low, middle)
    found = []
    for begin, end in ((place.min(), middle), (middle, place.max())):
        part = planar.overlay(shapely.intersection, shape, _strip(begin, end, along, across))
        corner, start, _ = planar.pieces_of(np.array([part], dtype=object))
        corner, start = clip.cleaned(corner, start, np.full(len(start) - 1, tiny))
        start = np.unique(start)
        for i, area in enumerate(clip.areas(corner, start)):
            point = origin + corner[start[i] : start[i + 1]] @ frame[1:]
            found.append(Facet(point, facet.normal, float(area), facet.members))
    return found


def _strip(begin: float, end: float, along: Floats, across: Floats) -> Any:
    return shapely.polygons(
        [begin * along - across, end * along - across, end * along + across, begin * along + across]
    )


def _flat(point: Floats, origin: Floats, frame: Floats) -> Any:
    """A polygon seen in a plane, as a valid shapely polygon."""
    shape = shapely.polygons((point - origin) @ frame[1:].T)
    return planar.valid(np.array([shape], dtype=object))[0]
