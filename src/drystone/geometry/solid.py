"""Points and segments against triangulated solids: inside, distance, crossings."""

from __future__ import annotations

import numpy as np

from drystone.geometry.arrays import Bools, Floats, Ints, cross

BATCH = 1_000_000
"""Point-triangle pairs worked on at a time, chosen: bounds the memory to some 200 MB."""


def _dot(a: Floats, b: Floats) -> Floats:
    dot: Floats = (a * b).sum(axis=-1)
    return dot


def inside(points: Floats, triangles: Floats) -> Bools:
    """Whether points (p, 3) lie inside the solid that triangles (t, 3, 3) enclose.

    By the winding number, the sum of solid angles; undecided within rounding of the surface.
    Source: Van Oosterom, Strackee 1983.

    Examples
    --------
    >>> corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = corner[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]
    >>> inside(np.array([[0.1, 0.1, 0.1], [1.0, 1.0, 1.0]]), faces).tolist()
    [True, False]
    """
    turns = np.zeros(len(points))
    step = max(BATCH // max(len(triangles), 1), 1)
    for i in range(0, len(points), step):
        a, b, c = (triangles[None, :, j] - points[i : i + step, None] for j in range(3))
        x, y, z = (np.sqrt(_dot(v, v)) for v in (a, b, c))
        volume = _dot(a, cross(b, c))
        rest = x * y * z + _dot(a, b) * z + _dot(b, c) * x + _dot(c, a) * y
        turns[i : i + step] = np.arctan2(volume, rest).sum(axis=1) / (2.0 * np.pi)
    return turns > 0.5


def distance(points: Floats, triangles: Floats) -> Floats:
    """Distance (p,) [m] of points (p, 3) from the nearest of the triangles (t, 3, 3).

    Source: Ericson 2005, Real-time collision detection, section 5.1.
    """
    nearest = np.full(len(points), np.inf)
    step = max(BATCH // max(len(triangles), 1), 1)
    for i in range(0, len(points), step):
        part = points[i : i + step, None]
        nearest[i : i + step] = np.sqrt(_squared(part, triangles[None]).min(axis=1, initial=np.inf))
    return nearest


def _squared(points: Floats, triangles: Floats) -> Floats:
    """Squared distance of points (..., 3) from triangles (..., 3, 3)."""
    a, b, c = triangles[..., 0, :], triangles[..., 1, :], triangles[..., 2, :]
    best = np.minimum(
        _from_segment(points, a, b),
        np.minimum(_from_segment(points, b, c), _from_segment(points, c, a)),
    )
    normal = cross(b - a, c - a)
    square = _dot(normal, normal)
    safe = np.where(square > 0.0, square, 1.0)
    over = square > 0.0
    for start, end in ((a, b), (b, c), (c, a)):
        over = over & (_dot(cross(end - start, points - start), normal) >= 0.0)
    height = _dot(points - a, normal) ** 2 / safe
    squared: Floats = np.where(over, height, best)
    return squared


def _from_segment(points: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    square = _dot(along, along)
    share = _dot(points - start, along) / np.where(square > 0.0, square, 1.0)
    offset = points - start - np.clip(share, 0.0, 1.0)[..., None] * along
    return _dot(offset, offset)


def crossings(start: Floats, end: Floats, triangles: Floats) -> tuple[Ints, Floats]:
    """Where segments (s, 3) pass through triangles (t, 3, 3).

    Returns
    -------
    segment : (c,)
    share : (c,) place along the segment, 0 to 1

    Notes
    -----
    Source: Moeller, Trumbore 1997. Segments in the plane of a triangle do not cross it.
    """
    along = end - start
    segments: list[Ints] = []
    shares: list[Floats] = []
    step = max(BATCH // max(len(triangles), 1), 1)
    one, two = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    for i in range(0, len(start), step):
        ray = along[i : i + step, None]
        off = start[i : i + step, None] - triangles[None, :, 0]
        side = cross(ray, np.broadcast_to(two, (ray.shape[0], *two.shape)))
        volume = _dot(side, one)
        flat = np.abs(volume) <= 1e-14 * np.sqrt(_dot(ray, ray) * _dot(one, one) * _dot(two, two))
        safe = np.where(flat, 1.0, volume)
        u = _dot(side, off) / safe
        turned = cross(off, np.broadcast_to(one, off.shape))
        v = _dot(turned, np.broadcast_to(ray, off.shape)) / safe
        share = _dot(turned, two) / safe
        hit = ~flat & (u >= 0) & (v >= 0) & (u + v <= 1) & (share >= 0) & (share <= 1)
        segment, triangle = np.nonzero(hit)
        segments.append(segment + i)
        shares.append(share[segment, triangle])
    if not segments:
        return np.zeros(0, dtype=np.intp), np.zeros(0)
    return np.concatenate(segments), np.concatenate(shares)


__all__ = ["crossings", "distance", "inside"]
