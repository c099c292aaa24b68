"""Points and segments against triangles: solid angle, distance, crossing."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import ROUNDING, Bools, Floats, cross, dot
from drystone.base.ragged import BATCH
from drystone.geometry import boxes

_FAR = 1000
"""Points of which the distance is found at once, those that may be farthest first. Chosen."""


def solid_angles(points: Floats, triangles: Floats) -> Floats:
    """Signed solid angle (...,) [sr] of triangles (..., 3, 3) seen from points (..., 3).

    The angles of a closed surface, oriented outwards, sum to 4 pi inside and to 0 outside. Within
    rounding of the surface the sum is arbitrary. Source: Van Oosterom, Strackee 1983.

    Examples
    --------
    >>> corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = corner[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]
    >>> points = np.array([[0.1, 0.1, 0.1], [1.0, 1.0, 1.0]])
    >>> turns = solid_angles(points[:, None], faces).sum(axis=1) / (4.0 * np.pi)
    >>> abs(turns.round(12)).tolist()
    [1.0, 0.0]
    """
    a, b, c = (triangles[..., j, :] - points for j in range(3))
    x, y, z = (np.sqrt(dot(v, v)) for v in (a, b, c))
    volume = dot(a, cross(b, c))
    rest = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y
    return 2.0 * np.arctan2(volume, rest)


def winding_number(points: Floats, triangles: Floats) -> Floats:
    """How often closed surfaces go around points (p, 3): 1 inside, 0 outside, -1 if inside out.

    Parameters
    ----------
    points : (p, 3) [m]
    triangles : (t, 3, 3) [m]
    """
    turns = np.zeros(len(points))
    step = max(BATCH // max(len(triangles), 1), 1)
    for i in range(0, len(points), step):
        turns[i : i + step] = solid_angles(points[i : i + step, None], triangles).sum(axis=1)
    return turns / (4.0 * np.pi)


def outside_distance(points: Floats, triangles: Floats, least: float = 0.0) -> Floats:
    """Distance (p,) [m] of points (p, 3) from a closed solid; zero inside it and on its surface.

    Parameters
    ----------
    points : (p, 3) [m]
    triangles : (t, 3, 3) [m]
        Oriented outwards. None may lie outside its face, as triangles of a fan can.
    least : [m]
        Up to it a point is on the surface.
    """
    away: Floats = distance(points, triangles)
    off = away > least
    off[off] = winding_number(points[off], triangles) <= 0.5
    return np.where(off, away, 0.0)


def distance(points: Floats, triangles: Floats) -> Floats:
    """Distance (p,) [m] of points (p, 3) from the nearest of the triangles (t, 3, 3)."""
    nearest = np.full(len(points), np.inf)
    step = max(BATCH // max(len(triangles), 1), 1)
    for i in range(0, len(points), step):
        part = points[i : i + step, None]
        square = squared_distance(part, triangles[None])
        nearest[i : i + step] = np.sqrt(square.min(axis=1, initial=np.inf))
    return nearest


def farthest(points: Floats, triangles: Floats, least: float) -> float:
    """Largest distance [m] of any of some points from the nearest triangle; 0 up to ``least``.

    Parameters
    ----------
    points : (p, 3) [m]
    triangles : (t, 3, 3) [m]
    least : [m]

    Notes
    -----
    Boxes in a tree find the triangles near each point. The nearest corner bounds the distance of a
    point from above; the search ends where no bound exceeds the largest distance found.

    Examples
    --------
    >>> floor = np.array([[[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]]])
    >>> farthest(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]]), floor, 0.1)
    2.0
    """
    from scipy.spatial import cKDTree  # slow to import, and few models need it

    tree = boxes.BoxTree(triangles.min(axis=1), triangles.max(axis=1))
    near = np.zeros(len(points), dtype=bool)
    for i, j in tree.overlapped_by(points - least, points + least):
        near[i[squared_distance(points[i], triangles[j]) <= least**2]] = True
    left = np.flatnonzero(~near)
    if len(left) == 0:
        return 0.0
    nearest = cKDTree(triangles.reshape(-1, 3)).query(points[left])[0]
    bound = (1.0 + ROUNDING) * np.asarray(nearest)
    order = np.argsort(-bound, kind="stable")
    deepest = 0.0
    for begin in range(0, len(left), _FAR):
        some = order[begin : begin + _FAR]
        if bound[some[0]] <= deepest:
            break
        place, reach = points[left[some]], bound[some, None]
        square = np.full(len(some), np.inf)
        for i, j in tree.overlapped_by(place - reach, place + reach):
            np.minimum.at(square, i, squared_distance(place[i], triangles[j]))
        deepest = max(deepest, float(np.sqrt(square.max())))
    return deepest


def squared_distance(points: Floats, triangles: Floats) -> Floats:
    """Squared distance (...,) [m2] of points (..., 3) from triangles (..., 3, 3).

    Source: Ericson 2005, Real-time collision detection, section 5.1.
    """
    a, b, c = triangles[..., 0, :], triangles[..., 1, :], triangles[..., 2, :]
    best = np.minimum(
        _from_segment(points, a, b),
        np.minimum(_from_segment(points, b, c), _from_segment(points, c, a)),
    )
    normal = cross(b - a, c - a)
    square = dot(normal, normal)
    safe = np.where(square > 0.0, square, 1.0)
    over = square > 0.0
    for start, end in ((a, b), (b, c), (c, a)):
        over = over & (dot(cross(end - start, points - start), normal) >= 0.0)
    height = dot(points - a, normal) ** 2 / safe
    return np.where(over, height, best)


def _from_segment(points: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    square = dot(along, along)
    share = dot(points - start, along) / np.where(square > 0.0, square, 1.0)
    offset = points - start - np.clip(share, 0.0, 1.0)[..., None] * along
    return dot(offset, offset)


def crossings(start: Floats, end: Floats, triangles: Floats) -> tuple[Bools, Floats]:
    """Whether and where segments (..., 3) pass through triangles (..., 3, 3).

    Returns
    -------
    hit : (...,)
    share : (...,) position along the segment, 0 to 1 where it is hit

    Notes
    -----
    Source: Moeller, Trumbore 1997. Segments in the plane of a triangle do not cross it. Those
    through an edge cross both triangles there, however these numbers are rounded.
    """
    ray = end - start
    corner = triangles[..., 0, :]
    one, two = triangles[..., 1, :] - corner, triangles[..., 2, :] - corner
    off = start - corner
    side = cross(*np.broadcast_arrays(ray, two))
    volume = dot(side, one)
    flat = np.abs(volume) <= 1e-14 * np.sqrt(dot(ray, ray) * dot(one, one) * dot(two, two))
    safe = np.where(flat, 1.0, volume)
    u = dot(side, off) / safe
    turned = cross(*np.broadcast_arrays(off, one))
    v = dot(turned, ray) / safe
    share: Floats = dot(turned, two) / safe
    within = np.minimum(np.minimum(u, v), 1.0 - u - v) >= -ROUNDING
    hit: Bools = ~flat & within & (share >= 0) & (share <= 1)
    return hit, share
