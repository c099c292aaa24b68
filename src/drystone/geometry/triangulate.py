"""Triangles of polygon faces, by a fan or by a constrained triangulation."""

from __future__ import annotations

import numpy as np
import shapely

from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, cross, marked, plane_cross, unit
from drystone.base.ragged import Ragged
from drystone.geometry.frames import area_vectors, frames_from_normals
from drystone.geometry.polyhedron import Faces

_THIN = 1e-3
"""A fan about the first corner with a triangle below this share of the face is rejected. Chosen.
Where a face is warped, slivers cross other faces."""


def triangulate(corners: Floats, start: Ints) -> tuple[Ints, Ints]:
    """Triangles that cover simple polygons, with their orientation.

    Parameters
    ----------
    corners : (l, 3) [m]
        Corners, polygon after polygon. A warped polygon is triangulated as it appears along its
        area vector.
    start : (f + 1,)
        Polygon i has the corners ``start[i]`` to ``start[i + 1]``, three or more.

    Returns
    -------
    triangle : (t, 3)
        Positions in ``corners``; a polygon of c corners has c - 2 triangles.
    polygon : (t,) ascending

    Notes
    -----
    A convex polygon becomes a fan about its first corner, unless one of its triangles is thin.
    shapely triangulates the others (constrained Delaunay). A loop that crosses itself becomes a
    fan.

    Examples
    --------
    >>> dart = np.array([[2.0, 0, 0], [0.5, 0.5, 0], [0, 2, 0], [0, 0, 0]])
    >>> triangulate(dart, np.array([0, 4]))[0].tolist()
    [[3, 1, 2], [1, 3, 0]]
    """
    count = np.diff(start)
    if len(count) == 0:
        return np.zeros((0, 3), dtype=np.intp), np.zeros(0, dtype=np.intp)
    flat = _flattened(corners, start)
    triangle = _fans(start)
    polygon = np.repeat(np.arange(len(count), dtype=np.intp), count - 2)
    first = Ragged.from_counts(count - 2).start
    convex = _convex(flat, start)
    poor = np.flatnonzero(~convex | _thin(flat, triangle, first))
    for i, found in zip(poor.tolist(), _delaunay(flat, start, poor), strict=True):
        if len(found) == count[i] - 2:
            triangle[first[i] : first[i + 1]] = found
    return triangle, polygon


def _flattened(corners: Floats, start: Ints) -> Floats:
    """Corners (l, 2) seen along each polygon's area vector: counter-clockwise."""
    normal, length = unit(area_vectors(corners, start))
    normal[length == 0.0] = (0.0, 0.0, 1.0)
    frame = frames_from_normals(normal)
    loops = Ragged(start)
    local = corners - loops.spread(loops.mean(corners))
    return np.einsum("lij,lj->li", frame[loops.owner, 1:], local)


def _convex(flat: Floats, start: Ints) -> Bools:
    loops = Ragged(start)
    after = loops.following
    edge = flat[after] - flat
    turn = plane_cross(edge, edge[after])
    area = 0.5 * loops.sum(plane_cross(flat, flat[after]))
    return ~loops.any(turn < -ROUNDING * loops.spread(np.abs(area)))


def _thin(flat: Floats, triangle: Ints, first: Ints) -> Bools:
    """Whether a polygon with more than three corners has a triangle of almost no area."""
    a, b, c = (flat[triangle[:, i]] for i in range(3))
    double = plane_cross(b - a, c - a)
    polygons = Ragged(first)
    return (polygons.min(double) < _THIN * polygons.sum(double)) & (polygons.counts > 1)


def _fans(start: Ints) -> Ints:
    count = np.diff(start) - 2
    base = np.repeat(start[:-1], count)
    step = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return np.stack([base, base + step + 1, base + step + 2], axis=1).astype(np.intp)


def _delaunay(flat: Floats, start: Ints, chosen: Ints) -> list[Ints]:
    """Triangles (t, 3), counter-clockwise, of some polygons; none of a loop that crosses itself."""
    loops = [flat[start[i] : start[i + 1]] for i in chosen]
    polygons = np.array([shapely.Polygon(loop) for loop in loops])
    valid = np.flatnonzero(shapely.is_valid(polygons))
    parts, of = shapely.get_parts(
        shapely.constrained_delaunay_triangles(polygons[valid]), return_index=True
    )
    corners = shapely.get_coordinates(shapely.orient_polygons(parts)).reshape(-1, 4, 2)[:, :3]
    found: list[Ints] = [np.zeros((0, 3), dtype=np.intp)] * len(chosen)
    for i, triangles in zip(
        valid.tolist(), Ragged.from_owners(of, len(valid)).split(corners), strict=True
    ):
        place = {
            tuple(corner): k for k, corner in enumerate(loops[i].tolist(), int(start[chosen[i]]))
        }
        rows = [[place[tuple(corner)] for corner in triangle] for triangle in triangles.tolist()]
        found[i] = np.array(rows, dtype=np.intp).reshape(-1, 3)
    return found


def fan_warped(faces: Faces, tolerance: float = ROUNDING) -> Faces:
    """The same bodies, every warped face replaced by its fan about the mean of its corners.

    The volume and the centroid of a body are those of this fan
    (:func:`drystone.geometry.polyhedron.mass_properties`), so the triangles in a file enclose
    the solid of the calculation. Two bodies that share a warped face get the same triangles there.

    Parameters
    ----------
    faces
        Oriented outwards, the points of each body together.
    tolerance
        A face is warped when a corner is farther from its plane, relative to the size of its body.

    Returns
    -------
    Faces
        The points of each body are followed by the middles of its warped faces. Planar faces and
        triangles are unchanged. So are warped faces whose fan would fold over because their mean
        does not see all of their edges.

    Examples
    --------
    >>> saddle = np.array([[0.0, 0, 0.1], [1, 0, 0], [1, 1, 0.1], [0, 1, 0]])
    >>> one = Faces(saddle, np.arange(4), np.array([0, 4]), np.array([0]))
    >>> fan = fan_warped(one, 1e-9)
    >>> fan.point[4].tolist(), fan.loop.reshape(-1, 3).tolist()
    ([0.5, 0.5, 0.05], [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    """
    if faces.count == 0:
        return faces
    body = point_owners(faces)
    corner = faces.point[faces.loop]
    chosen = _warped(faces, body, corner, tolerance) & (faces.corners.counts > 3)
    if not chosen.any():
        return faces
    added = np.flatnonzero(chosen)
    middle = faces.corners.mean(corner)
    order = np.argsort(np.concatenate([body, faces.owner[added]]), kind="stable")
    place = np.argsort(order)
    middle_at = np.full(faces.count, -1, dtype=np.intp)
    middle_at[added] = place[len(body) :]
    face = faces.corners.owner
    fanned = chosen[face]
    row = np.empty((len(face), 3), dtype=np.intp)
    row[:, 0] = place[faces.loop]
    row[:, 1] = row[faces.corners.following, 0]
    row[:, 2] = middle_at[face]
    kept = np.ones((len(face), 3), dtype=bool)
    kept[:, 1:] = fanned[:, None]
    first = marked(faces.start[:-1], len(face))
    begins = np.flatnonzero(first | fanned)
    pieces = Ragged(np.append(begins, len(face)))
    corners = Ragged.from_counts(pieces.sum(kept.sum(axis=1)))
    return Faces(
        np.concatenate([faces.point, middle[added]])[order],
        row[kept],
        corners.start,
        faces.owner[face[begins]],
    )


def point_owners(faces: Faces) -> Ints:
    """(v,) the body that each point belongs to; every point is a corner of a face."""
    owner = np.zeros(len(faces.point), dtype=np.intp)
    owner[faces.loop] = faces.corners.spread(faces.owner)
    return owner


def _warped(faces: Faces, body: Ints, corner: Floats, tolerance: float) -> Bools:
    """(f,) whether a face is warped beyond the tolerance, and its mean sees all of its edges."""
    height, seen = warp_and_view(corner, faces.start)
    count = int(body.max()) + 1
    of_body = Ragged.from_owners(body, count)
    extent = of_body.max(faces.point) - of_body.min(faces.point)
    size = np.linalg.norm(extent, axis=1)[faces.owner]
    return (height > tolerance * size) & seen


def warp_and_view(corners: Floats, start: Ints) -> tuple[Floats, Bools]:
    """How far polygons are from planar, and whether the mean of their corners sees all their edges.

    Parameters
    ----------
    corners : (l, 3) [m]
    start : (f + 1,)

    Returns
    -------
    height : (f,) [m]
        Largest distance of a corner from the plane through the mean, square to the area vector.
    seen : (f,)
        Every triangle of the fan about the mean has the orientation of the polygon.
    """
    loops = Ragged(start)
    normal = loops.spread(unit(area_vectors(corners, start))[0])
    local = corners - loops.spread(loops.mean(corners))
    turn = (cross(local, local[loops.following]) * normal).sum(axis=1)
    height: Floats = loops.max(np.abs((local * normal).sum(axis=1)))
    seen: Bools = loops.min(turn) > 0.0
    return height, seen
