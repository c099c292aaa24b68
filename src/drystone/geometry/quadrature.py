"""Points that stand for a polygon as a pressed face: its corners, and points inside.

The corners of a face carry forces about its edges as the whole face does, but they overstate its
torsion: a square turned under a uniform pressure resists with 0.54 times what its corners would.
Points inside carry it.

A polygon is cut into cells around its centre. Each cell stands at its centroid with its area. The
cells alone have too small a second moment, ``sum a r^2 < integral r^2``. A share of all
areas goes to the corners such that it is that of the polygon. Cells are made smaller until the
torsion ``integral r dA`` is right about the centroid, and about poles half way to the farthest
corner and to the middle of the edge after it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, dot, lengths, plane_cross
from drystone.base.ragged import Ragged
from drystone.geometry.kern import sections
from drystone.geometry.polygon import tributary_areas
from drystone.geometry.triangulate import triangulate

ACCURATE = 0.02
"""Largest error of the torsion of a face, by its own. Chosen."""

FINENESS = (0.7, 1.25, 1.5, 2.0, 3.0, 4.0, 6.0)
"""Cells between the centroid and the farthest corner, from few to many. Chosen: 3 are enough for a
strip of a hundredth of its length. A single ring is enough for a sixth of random polygons, and to
look whether it is takes as long as all that comes after."""

COARSE, EVEN, PRESSED = 0, 1, 3
"""What of these is tried first. The first one is taken as it is: of 700 faces the friction against
a turn is right within 15 %. On a part that is pressed linearly too few are not seen: begun with the
second, it would be up to 9 % too large."""


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


def face_points(corners: Floats, start: Ints, first: Ints | int = EVEN) -> FacePoints:
    """The points that stand for plane polygons.

    Parameters
    ----------
    corners : (l, 2) [m]
        Counter-clockwise, of simple polygons.
    start : (m + 1,)
        Polygon i has the corners ``start[i]`` to ``start[i + 1]``, three or more.
    first : (m,)
        Position in :data:`FINENESS` with which each polygon begins.

    Examples
    --------
    A square of side 1 carries 0.3826 times its area in torsion about its centroid:

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> found = face_points(square, np.array([0, 4]))
    >>> away = np.hypot(*(found.place - 0.5).T)
    >>> len(away), float(found.area.sum().round(6)), float((found.area @ away).round(4))
    (20, 1.0, 0.3882)
    """
    loops = Ragged(start)
    if not len(loops):
        return FacePoints(loops, corners, np.zeros(0))
    made = sections(corners, start)
    area, middle = made.area, made.centroid
    away = lengths(corners - middle[loops.owner])
    far = loops.argmax(away)
    reach = away[far]
    side = 0.5 * (corners[far] + corners[loops.following[far]])
    poles = np.stack([middle, 0.5 * (middle + corners[far]), 0.5 * (middle + side)], axis=1)
    exact = _torsion(corners, loops, poles)
    polar = area * np.trace(made.inertia, axis1=1, axis2=2)
    share = tributary_areas(np.pad(corners, ((0, 0), (0, 1))), start)
    share *= (area / loops.sum(share))[loops.owner]
    pieces = _star_shaped(corners, loops)
    parts: list[tuple[Ints, Floats, Floats]] = []
    first, left = np.broadcast_to(first, len(loops)), np.ones(len(loops), dtype=bool)
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
        here, whole = poles[open_], exact[open_]
        found = mine.sum(rim[:, None] * lengths(corners[row, None] - here[mine.owner]))
        found += cells.sum(inside[:, None] * lengths(place[:, None] - here[cells.owner]))
        done = np.all(np.abs(found - whole) <= ACCURATE * whole, axis=1)
        done |= number in (COARSE, len(FINENESS) - 1)
        for part, points, weights in ((mine, corners[row], rim), (cells, place, inside)):
            taken = done[part.owner]
            parts.append((open_[part.owner[taken]], points[taken], weights[taken]))
        left[open_[done]] = False
    owner, places, areas = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(owner, kind="stable")
    return FacePoints(Ragged.from_owners(owner[order], len(loops)), places[order], areas[order])


def cut_face_points(
    corners: Floats, start: Ints, plane: Floats, exact: Bools | bool = True
) -> FacePoints:
    """The points that stand for polygons, of which ``q + s . x > 0`` is pressed.

    Where nothing presses, the corners stand for the rest.

    Parameters
    ----------
    corners, start
        As for :func:`face_points`.
    plane : (m, 3)
        q, and s [1/m]. A polygon that the line does not divide has the points of the whole.
    exact : (m,)
        Whether a polygon has as many as make its torsion right, or few.
    """
    loops = Ragged(start)
    height = plane[loops.owner, 0] + dot(corners, plane[loops.owner, 1:])
    crossed = (loops.min(height) < 0.0) & (loops.max(height) > 0.0)
    if not crossed.any():
        return face_points(corners, start, np.where(exact, EVEN, COARSE))
    part, row = loops.take(crossed)
    pieces = _star_shaped(corners[row], part)
    of = np.flatnonzero(crossed)[pieces.polygon]
    line = plane[of][pieces.loops.owner]
    height = line[:, 0] + dot(pieces.corner, line[:, 1:])
    kept, kept_corner = _clipped(pieces.loops, pieces.corner, height)
    rest, rest_corner = _clipped(pieces.loops, pieces.corner, -height)
    whole, row = loops.take(~crossed)
    owner = np.concatenate([np.flatnonzero(~crossed), of[kept.counts > 0]])
    points = face_points(
        np.concatenate([corners[row], kept_corner]),
        Ragged.from_counts(np.concatenate([whole.counts, kept.counts[kept.counts > 0]])).start,
        np.where(exact, np.where(crossed, PRESSED, EVEN), COARSE)[owner],
    )
    face = np.concatenate([owner[points.loops.owner], of[rest.owner]])
    order = np.argsort(face, kind="stable")
    area = tributary_areas(np.pad(rest_corner, ((0, 0), (0, 1))), rest.start)
    return FacePoints(
        Ragged.from_owners(face[order], len(loops)),
        np.concatenate([points.place, rest_corner])[order],
        np.concatenate([points.area, area])[order],
    )


def _clipped(loops: Ragged, corner: Floats, height: Floats) -> tuple[Ragged, Floats]:
    """What of convex polygons has a positive height, which is linear over each."""
    after = loops.following
    up = height > 0.0
    crosses = up != up[after]
    share = height / np.where(crosses, height - height[after], 1.0)
    met = corner + share[:, None] * (corner[after] - corner)
    kept = np.stack([up, crosses], axis=1)
    kept &= (loops.sum(kept.sum(axis=1)) > 2)[loops.owner, None]
    owner = np.repeat(loops.owner, kept.sum(axis=1))
    return Ragged.from_owners(owner, len(loops)), np.stack([corner, met], axis=1)[kept]


def _torsion(corners: Floats, loops: Ragged, poles: Floats) -> Floats:
    """(m, r) integrals of the distance to poles (m, r, 2), by edges: ``h^3 / 3 integral sec^3``."""
    local = corners[:, None] - poles[loops.owner]
    after = local[loops.following]
    edge = after - local
    long = np.maximum(lengths(edge), 1e-300)
    height = plane_cross(local, edge) / long
    safe = np.where(height == 0.0, 1.0, np.abs(height))

    def primitive(along: Floats) -> Floats:
        rise = along / safe
        return rise * np.sqrt(1.0 + rise**2) + np.arcsinh(rise)

    ends = (dot(after, edge) / long, dot(local, edge) / long)
    each = height**3 / 6.0 * (primitive(ends[0]) - primitive(ends[1]))
    return np.asarray(loops.sum(np.where(height == 0.0, 0.0, each)))


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
    and the rings along the edge. A cell stands at its centroid.
    """
    position = np.full(len(size), -1)
    position[polygons] = np.arange(len(polygons))
    chosen = np.flatnonzero(position[pieces.polygon] >= 0)
    loops, row = pieces.loops.take(chosen)
    corner = pieces.corner[row]
    middle = loops.mean(corner)[loops.owner]
    owner = position[pieces.polygon[chosen]][loops.owner]
    along, out = corner[loops.following] - corner, corner - middle
    ray = np.maximum(lengths(out), lengths(out + along))
    rings, arcs = (
        np.maximum(np.ceil(way / size[polygons][owner] - 1e-9), 1.0).astype(np.intp)
        for way in (ray, lengths(along))
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
