"""How deep polyhedra stand in each other: all pairs at once, concave ones too."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from drystone.arrays import Bools, Floats, Ints, dot
from drystone.geometry import boxes
from drystone.geometry.body import solid
from drystone.geometry.body.polyhedron import Faces
from drystone.geometry.plane.polygon import following
from drystone.geometry.plane.triangulate import triangulate

BATCH = 500_000
"""Rows of a point or an edge and a triangle worked on at a time, chosen: bounds the memory to some
200 MB."""


@dataclass(frozen=True, eq=False)
class _Bodies:
    """Bodies by their edges and triangles; each range of a body starts at ``first_*[body]``."""

    point: Floats  # (v, 3)
    corner: Ints  # (c,) vertices that faces have, body after body
    edge: Ints  # (e, 2) vertices
    triangle: Floats  # (t, 3, 3)
    first_corner: Ints  # (n + 1,)
    first_edge: Ints
    first_triangle: Ints


@dataclass(frozen=True, eq=False)
class _Sides:
    """Ordered pairs: what of ``body`` lies in ``other``, deeper than ``least``."""

    body: Ints  # (s,)
    other: Ints  # (s,)
    least: Floats  # (s,) [m]
    direction: Floats  # (s, 3)


def depths(
    faces: Faces,
    a: Ints,
    b: Ints,
    least: Floats,
    direction: Floats,
    *,
    edges_only: Bools | None = None,
) -> Floats:
    """How far the deepest point on an edge of the one lies below the surface of the other.

    Parameters
    ----------
    faces
        Of all bodies, outwards; a warped face counts as its triangles.
    a, b : (p,)
        Pairs of bodies, by the owners in ``faces``.
    least : (p,) [m]
        Depths up to this are no depth.
    direction : (p, 3) unit
        Along which the two overlap by little: edges that do not get that far are passed over, so
        that this decides the time taken and nothing else.
    edges_only : (p,), optional
        Pairs that cannot share a space with all its corners on both surfaces: none is looked for.

    Returns
    -------
    depth : (p,) [m], 0 where it is no more than ``least``

    Notes
    -----
    Along every edge the points looked at are its ends and the middles of its stretches between the
    places where it passes through the other's surface. Bodies of which no such point is inside the
    other can still share a space whose corners lie on both surfaces, as a body and its copy do:
    of those the mean of the corners on the other's surface is looked at, and it counts by the
    smaller of its depths in the two.

    Examples
    --------
    >>> from drystone.models import box
    >>> from drystone.assembly import Assembly
    >>> pair = Assembly((box((1, 1, 1), name="a"), box((1, 1, 1), (0.5, 0.25, 0.9), name="b")))
    >>> depths(pair.faces, np.array([0]), np.array([1]), np.array([1e-6]),
    ...        np.array([[0.0, 0.0, 1.0]])).round(6).tolist()
    [0.1]
    """
    depth = np.zeros(len(a))
    if len(a) == 0:
        return depth
    bodies = _bodies(faces, np.union1d(a, b))
    for one, other in ((a, b), (b, a)):
        edges = np.diff(bodies.first_edge)[one]
        for part in _batches(edges):
            sides = _Sides(one[part], other[part], least[part], direction[part])
            side, point = _candidates(bodies, sides)
            deep = _depth_of_points(bodies, sides, side, point)
            np.maximum.at(depth, part[side], deep)
    left = np.flatnonzero(depth <= least if edges_only is None else (depth <= least) & ~edges_only)
    depth[left] = _middle_depth(bodies, _Sides(a[left], b[left], least[left], direction[left]))
    return np.where(depth > least, depth, 0.0)


def _middle_depth(bodies: _Bodies, sides: _Sides) -> Floats:
    """(s,) [m] depth in both bodies of the mean of the points that lie on both surfaces."""
    turned = _Sides(sides.other, sides.body, sides.least, sides.direction)
    total, count = np.zeros((len(sides.body), 3)), np.zeros(len(sides.body))
    for each in (sides, turned):
        side, point = _on_surface(bodies, each)
        np.add.at(total, side, point)
        count += np.bincount(side, minlength=len(count))
    several = np.flatnonzero(count >= 4)  # fewer have no volume
    mean = total[several] / count[several, None]
    depth = np.zeros(len(count))
    depth[several] = np.minimum(
        _depth_of_points(bodies, sides, several, mean),
        _depth_of_points(bodies, turned, several, mean),
    )
    return depth


def _on_surface(bodies: _Bodies, sides: _Sides) -> tuple[Ints, Floats]:
    """Side and place of corners, and of points on edges, that lie on the other's surface."""
    count = np.diff(bodies.first_triangle)
    low, high = bodies.triangle.min(axis=1), bodies.triangle.max(axis=1)
    side, corner = _of_range(bodies.first_corner, sides.body)
    place = bodies.point[bodies.corner[corner]]
    on = np.zeros(len(side), dtype=bool)
    for part in _batches(count[sides.other[side]]):
        row, triangle = _of_range(bodies.first_triangle, sides.other[side[part]])
        row = part[row]
        margin = sides.least[side[row], None]
        near = boxes.touching(
            place[row] - margin, place[row] + margin, low[triangle], high[triangle]
        )
        row, triangle = row[near], triangle[near]
        square = solid.squared_distance(place[row], bodies.triangle[triangle])
        on[row[square <= sides.least[side[row]] ** 2]] = True
    edge_side, edge = _of_range(bodies.first_edge, sides.body)
    ends = bodies.point[bodies.edge[edge]]
    crossed, share = _crossings(bodies, sides, edge_side, ends)
    through = ends[crossed, 0] + share[:, None] * (ends[crossed, 1] - ends[crossed, 0])
    return np.concatenate([side[on], edge_side[crossed]]), np.concatenate([place[on], through])


def _bodies(faces: Faces, used: Ints) -> _Bodies:
    """Edges and triangles of the bodies used; the others have none."""
    number = int(faces.owner[-1]) + 1
    wanted = np.zeros(number, dtype=bool)
    wanted[used] = True
    chosen = wanted[faces.owner]
    length = np.diff(faces.start)[chosen]
    start = np.concatenate([[0], np.cumsum(length)]).astype(np.intp)
    _, position = boxes.expand(faces.start[:-1][chosen], length)
    loop, owner = faces.loop[position], faces.owner[chosen]
    of_vertex = np.zeros(len(faces.point), dtype=np.intp)
    of_vertex[loop] = np.repeat(owner, length)
    sides = np.sort(np.stack([loop, loop[following(start)]], axis=1), axis=1)
    edge = np.unique(sides[:, 0] * len(faces.point) + sides[:, 1])
    edge = np.stack(np.divmod(edge, len(faces.point)), axis=1)
    corner = np.unique(loop)
    triangle, polygon = triangulate(faces.point[loop], start)
    bodies = np.arange(number + 1)
    return _Bodies(
        point=faces.point,
        corner=corner,
        edge=edge,
        triangle=faces.point[loop[triangle]],
        first_corner=np.searchsorted(of_vertex[corner], bodies),
        first_edge=np.searchsorted(of_vertex[edge[:, 0]], bodies),
        first_triangle=np.searchsorted(owner[polygon], bodies),
    )


def _batches(count: Ints) -> Iterator[Ints]:
    """Positions, in runs whose counts add up to a batch."""
    batch = (np.cumsum(count) - count) // BATCH
    yield from np.split(np.arange(len(count)), np.flatnonzero(np.diff(batch)) + 1)


def _of_range(first: Ints, body: Ints) -> tuple[Ints, Ints]:
    return boxes.expand(first[body], first[body + 1] - first[body])


def _candidates(bodies: _Bodies, sides: _Sides) -> tuple[Ints, Floats]:
    """Side and place of the points on edges that may be deep in the other body."""
    low, high = _inner_box(bodies, sides)
    side, edge = _of_range(bodies.first_edge, sides.body)
    ends = bodies.point[bodies.edge[edge]]
    near = (ends.min(axis=1) <= high[side]).all(axis=1)
    near &= (ends.max(axis=1) >= low[side]).all(axis=1)
    side, edge, ends = side[near], edge[near], ends[near]
    near = _within_slab(bodies, sides, side, ends)
    side, edge, ends = side[near], edge[near], ends[near]
    crossed, share = _crossings(bodies, sides, side, ends)
    number = np.arange(len(side), dtype=np.intp)
    row = np.concatenate([number, number, crossed])
    place = np.concatenate([np.zeros(len(side)), np.ones(len(side)), share])
    order = np.lexsort((place, row))
    row, place = row[order], place[order]
    length = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))
    stretch = np.diff(place) * length[row[:-1]]  # half of it is the most its middle is deep
    between = np.flatnonzero((row[1:] == row[:-1]) & (stretch > 2.0 * sides.least[side[row[:-1]]]))
    middle = 0.5 * (place[between] + place[between + 1])
    row = row[between]
    middles = ends[row, 0] + middle[:, None] * (ends[row, 1] - ends[row, 0])
    key = np.unique((side[:, None] * len(bodies.point) + bodies.edge[edge]).ravel())
    end_side, vertex = np.divmod(key, len(bodies.point))
    side = np.concatenate([end_side, side[row]])
    point = np.concatenate([bodies.point[vertex], middles])
    inner = ((point >= low[side]) & (point <= high[side])).all(axis=1)
    return side[inner], point[inner]


def _inner_box(bodies: _Bodies, sides: _Sides) -> tuple[Floats, Floats]:
    """Box (s, 3) of what lies deeper than tolerated in each other body."""
    side, corner = _of_range(bodies.first_corner, sides.other)
    point = bodies.point[bodies.corner[corner]]
    start = np.searchsorted(side, np.arange(len(sides.body)))
    low: Floats = np.minimum.reduceat(point, start, axis=0) + sides.least[:, None]
    high: Floats = np.maximum.reduceat(point, start, axis=0) - sides.least[:, None]
    return low, high


def _within_slab(bodies: _Bodies, sides: _Sides, side: Ints, ends: Floats) -> Ints:
    """Edges that come between the ends of the other body along the direction."""
    each, corner = _of_range(bodies.first_corner, sides.other)
    along = dot(bodies.point[bodies.corner[corner]], sides.direction[each])
    start = np.searchsorted(each, np.arange(len(sides.body)))
    low = np.minimum.reduceat(along, start) + sides.least
    high = np.maximum.reduceat(along, start) - sides.least
    height = np.einsum("kij,kj->ki", ends, sides.direction[side])
    return np.flatnonzero((height.min(axis=1) <= high[side]) & (height.max(axis=1) >= low[side]))


def _crossings(bodies: _Bodies, sides: _Sides, side: Ints, ends: Floats) -> tuple[Ints, Floats]:
    """Rows of the edges that pass through the other's surface, and where along them."""
    count = np.diff(bodies.first_triangle)
    rows, shares = [np.zeros(0, dtype=np.intp)], [np.zeros(0)]
    low, high = bodies.triangle.min(axis=1), bodies.triangle.max(axis=1)
    lowest, highest = ends.min(axis=1), ends.max(axis=1)
    for part in _batches(count[sides.other[side]]):
        row, triangle = _of_range(bodies.first_triangle, sides.other[side[part]])
        near = boxes.touching(lowest[part[row]], highest[part[row]], low[triangle], high[triangle])
        row, triangle = part[row[near]], triangle[near]
        hit, share = solid.crossings(ends[row, 0], ends[row, 1], bodies.triangle[triangle])
        rows.append(row[hit])
        shares.append(share[hit])
    return np.concatenate(rows), np.concatenate(shares)


def _depth_of_points(bodies: _Bodies, sides: _Sides, side: Ints, point: Floats) -> Floats:
    """(k,) [m] how deep each point lies in the other body of its side; 0 up to the least."""
    depth = np.zeros(len(point))
    normal = np.cross(
        bodies.triangle[:, 1] - bodies.triangle[:, 0], bodies.triangle[:, 2] - bodies.triangle[:, 0]
    )
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    count = np.diff(bodies.first_triangle)[sides.other[side]]
    for part in _batches(count):
        row, triangle = _of_range(bodies.first_triangle, sides.other[side[part]])
        off = point[part[row]] - bodies.triangle[triangle, 0]
        flat = np.abs(dot(off, normal[triangle])) <= sides.least[side[part[row]]]
        close, at = row[flat], triangle[flat]
        square = solid.squared_distance(point[part[close]], bodies.triangle[at])
        on = square <= sides.least[side[part[close]]] ** 2
        free = np.ones(len(part), dtype=bool)
        free[close[on]] = False
        left = free[row]
        row, triangle = row[left], triangle[left]
        angle = solid.solid_angles(point[part[row]], bodies.triangle[triangle])
        turns = np.bincount(row, angle, minlength=len(part)) / (4.0 * np.pi)
        inside = turns[row] > 0.5
        row, triangle = row[inside], triangle[inside]
        square = solid.squared_distance(point[part[row]], bodies.triangle[triangle])
        nearest = np.full(len(part), np.inf)
        np.minimum.at(nearest, row, square)
        depth[part] = np.where(np.isfinite(nearest), np.sqrt(nearest), 0.0)
    return depth


__all__ = ["depths"]
