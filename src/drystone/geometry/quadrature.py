"""Points that stand for a polygon as a pressed face: its corners, and points inside.

The corners of a face carry forces about its edges as the whole face does, but they overstate its
torsion: a square turned under a uniform pressure resists with 0.54 times what its corners would.
Points inside carry it.

A polygon is cut into cells around its centre. Each cell stands at its centroid with its area. The
cells alone have too small a second moment, ``sum a r^2 < integral r^2``. A share of all
areas goes to the corners such that it is that of the polygon. Cells are made smaller until
``integral p r dA`` is right about the pole of a slip.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats, Ints, dot, lengths, places, plane_cross
from drystone.base.ragged import Ragged
from drystone.geometry.frames import tributary_areas
from drystone.geometry.kern import sections
from drystone.geometry.slipping import clipped, turned
from drystone.geometry.triangulate import triangulate

ACCURATE = 0.01
"""Largest error of the torsion of a face, by its own. Of 700 faces of seven kinds, pressed evenly
or in part, one resists a force and a torque 3 % less than it should, all others within 2 %."""

FINENESS = (1.25, 1.5, 2.0, 3.0, 4.0, 6.0)
"""Cells between the centroid and the farthest corner, from few to many. Chosen: 3 are enough for a
strip of a hundredth of its length. A single ring is enough for a sixth of random polygons, and to
look whether it is takes as long as all that comes after."""

PRESSED = 2
"""What of these is tried first where a part is pressed. Chosen: begun with fewer, twice as many of
700 faces are off by more than 1 %."""


class FacePoints(NamedTuple):
    """Points of m polygons, polygon after polygon: their corners first, then those inside.

    Attributes
    ----------
    loops : Ragged
        Points of each polygon.
    place : (p, 2) [m]
    area : (p,) [m2]
    """

    loops: Ragged
    place: Floats
    area: Floats


def face_points(
    corners: Floats, start: Ints | Ragged, plane: Floats, pole: Floats, first: Ints | int = 0
) -> FacePoints:
    """The points that stand for plane polygons.

    Parameters
    ----------
    corners : (l, 2) [m]
        Counter-clockwise, of simple polygons.
    start : (m + 1,)
        Polygon i has the corners ``start[i]`` to ``start[i + 1]``, three or more.
    plane : (m, 3)
        The pressure ``q + s . x`` on each, which is not negative.
    pole : (m, 2) [m]
        What each slips about.
    first : (m,)
        Position in :data:`FINENESS` with which each begins.

    Examples
    --------
    A square of side 1 carries 0.3826 times its area in torsion about its centroid:

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> even, middle = np.array([[1.0, 0.0, 0.0]]), np.array([[0.5, 0.5]])
    >>> found = face_points(square, np.array([0, 4]), even, middle)
    >>> away = np.hypot(*(found.place - 0.5).T)
    >>> len(away), float(found.area.sum().round(6)), float((found.area @ away).round(4))
    (64, 1.0, 0.3854)
    """
    loops = Ragged.over(start)
    if not len(loops):
        return FacePoints(loops, corners, np.zeros(0))
    made = sections(corners, loops)
    area, middle = made.area, made.centroid
    reach = loops.max(lengths(corners - middle[loops.owner]))
    whole = turned(corners, loops, plane, pole).moment
    polar = area * np.trace(made.inertia, axis1=1, axis2=2)
    share = _corner_areas(corners, loops, area, middle)
    pieces = _star_shaped(corners, loops)
    parts: list[tuple[Ints, Floats, Floats]] = []
    left = np.ones(len(loops), dtype=bool)
    for number, cells_out in enumerate(FINENESS):
        open_ = np.flatnonzero(left & (first <= number))
        if not len(open_):
            continue
        cells, place, weight = _cells(pieces, open_, reach / cells_out)
        mine, row = loops.take(open_)
        offset = corners[row] - middle[open_][mine.owner]
        inner = place - middle[open_][cells.owner]
        of_cells = cells.sum(weight * (inner**2).sum(axis=1))
        of_corners = mine.sum(share[row] * (offset**2).sum(axis=1))
        moved = np.clip((polar[open_] - of_cells) / (of_corners - of_cells), 0.0, 1.0)
        rim, inside = share[row] * moved[mine.owner], weight * (1.0 - moved)[cells.owner]
        here = (plane[open_], pole[open_])
        found = _torsion(mine, corners[row], rim, *here) + _torsion(cells, place, inside, *here)
        done = np.abs(found - whole[open_]) <= ACCURATE * whole[open_]
        done |= number == len(FINENESS) - 1
        for part, points, weights in ((mine, corners[row], rim), (cells, place, inside)):
            taken = done[part.owner]
            parts.append((open_[part.owner[taken]], points[taken], weights[taken]))
        left[open_[done]] = False
    owner, places, areas = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(owner, kind="stable")
    return FacePoints(Ragged.from_owners(owner[order], len(loops)), places[order], areas[order])


def cut_face_points(
    corners: Floats, start: Ints | Ragged, plane: Floats, pole: Floats
) -> FacePoints:
    """The points that stand for polygons, of which ``q + s . x > 0`` is pressed.

    Where nothing presses, the corners stand for the rest.

    Parameters
    ----------
    corners, start
        As for :func:`face_points`.
    plane : (m, 3)
        q, and s [1/m]. A polygon that the line does not divide has the points of the whole.
    pole : (m, 2) [m]
        What each slips about.
    """
    loops = Ragged.over(start)
    height = plane[loops.owner, 0] + dot(corners, plane[loops.owner, 1:])
    crossed = (loops.min(height) < 0.0) & (loops.max(height) > 0.0)
    if not crossed.any():
        return face_points(corners, loops, plane, pole)
    part, row = loops.take(crossed)
    pieces = _star_shaped(corners[row], part)
    of = np.flatnonzero(crossed)[pieces.polygon]
    line = plane[of][pieces.loops.owner]
    height = line[:, 0] + dot(pieces.corner, line[:, 1:])
    kept, kept_corner = clipped(pieces.loops, pieces.corner, height)
    rest, rest_corner = clipped(pieces.loops, pieces.corner, -height)
    whole, row = loops.take(~crossed)
    owner = np.concatenate([np.flatnonzero(~crossed), of[kept.counts > 0]])
    points = face_points(
        np.concatenate([corners[row], kept_corner]),
        Ragged.from_counts(np.concatenate([whole.counts, kept.counts[kept.counts > 0]])),
        plane[owner],
        pole[owner],
        np.where(crossed, PRESSED, 0)[owner],
    )
    face = np.concatenate([owner[points.loops.owner], of[rest.owner]])
    order = np.argsort(face, kind="stable")
    area = tributary_areas(rest_corner, rest)
    return FacePoints(
        Ragged.from_owners(face[order], len(loops)),
        np.concatenate([points.place, rest_corner])[order],
        np.concatenate([points.area, area])[order],
    )


def _corner_areas(corners: Floats, loops: Ragged, area: Floats, middle: Floats) -> Floats:
    """Areas (l,) of corners: those of polygons (m,) in all, with their centroids (m, 2)."""
    share = tributary_areas(corners, loops)
    share *= (area / loops.sum(share))[loops.owner]
    mean = loops.sum(share[:, None] * corners) / area[:, None]
    away = corners - mean[loops.owner]
    second = loops.sum(share[:, None, None] * away[:, :, None] * away[:, None, :])
    second += 1e-9 * np.trace(second, axis1=1, axis2=2)[:, None, None] * np.eye(2)
    lever = np.linalg.solve(second, (area[:, None] * (middle - mean))[:, :, None])[:, :, 0]
    return share * np.maximum(1.0 + dot(away, lever[loops.owner]), 0.0)


def _torsion(loops: Ragged, place: Floats, area: Floats, plane: Floats, pole: Floats) -> Floats:
    """Sums of ``p r`` of points (p, 2) by their areas (p,), for one pressure and pole a polygon."""
    owner = loops.owner
    pressure = plane[owner, 0] + dot(place, plane[owner, 1:])
    return loops.sum(area * pressure * lengths(place - pole[owner]))


class _Pieces(NamedTuple):
    """Star-shaped pieces of polygons.

    Attributes
    ----------
    loops : Ragged
        Corners of each piece.
    corner : (l, 2) [m]
    polygon : (t,) ascending
    """

    loops: Ragged
    corner: Floats
    polygon: Ints


def _star_shaped(corners: Floats, loops: Ragged) -> _Pieces:
    """Convex polygons as they are, others as triangles."""
    local = corners[loops.following] - corners
    turn = plane_cross(local, local[loops.following])
    convex = loops.min(turn) >= 0.0
    whole, row = loops.take(convex)
    if convex.all():
        return _Pieces(whole, corners[row], np.arange(len(loops)))
    bent, bent_row = loops.take(~convex)
    triangle, of = triangulate(np.pad(corners[bent_row], ((0, 0), (0, 1))), bent.start)
    corner = np.concatenate([corners[row], corners[bent_row][triangle.ravel()]])
    polygon = np.concatenate([np.flatnonzero(convex), np.flatnonzero(~convex)[of]])
    counts = np.concatenate([whole.counts, np.full(len(triangle), 3)])
    order = np.argsort(polygon, kind="stable")
    pieces, row = Ragged.from_counts(counts).take(order)
    return _Pieces(pieces, corner[row], polygon[order])


def _cells(pieces: _Pieces, polygons: Ints, size: Floats) -> tuple[Ragged, Floats, Floats]:
    """Cells of some polygons (t,) that are no longer than a size (m,): middles (p, 2), areas (p,).

    Each piece is a fan of triangles about the mean of its corners. These are divided into rings,
    and the rings along the edge, at least in two: a needle is short across. A cell stands at its
    centroid.
    """
    position = places(polygons, len(size))
    chosen = np.flatnonzero(position[pieces.polygon] >= 0)
    loops, row = pieces.loops.take(chosen)
    corner = pieces.corner[row]
    middle = loops.mean(corner)[loops.owner]
    owner = position[pieces.polygon[chosen]][loops.owner]
    along, out = corner[loops.following] - corner, corner - middle
    ray = np.maximum(lengths(out), lengths(out + along))
    rings, arcs = (
        np.maximum(np.ceil(way / size[polygons][owner] - 1e-9), fewest).astype(np.intp)
        for way, fewest in ((ray, 1), (lengths(along), 2))
    )
    parts = Ragged.from_counts(rings * arcs)
    part = parts.owner
    number = np.arange(parts.rows) - parts.first[part]
    begin, end = (
        (number // arcs[part] + step) / rings[part] for step in (0, 1)
    )  # of the way from the mean of the corners to the edge
    grown = end**2 - begin**2
    ring = 2.0 / 3.0 * (end**3 - begin**3) / grown
    arc = (number % arcs[part] + 0.5) / arcs[part]
    place = middle[part] + ring[:, None] * (out[part] + arc[:, None] * along[part])
    area = 0.5 * plane_cross(out, along)[part] * grown / arcs[part]
    return Ragged.from_owners(owner[part], len(polygons)), place, area
