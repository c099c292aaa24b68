"""Triangles of polygon faces: a fan where one corner sees all the others, else ear clipping."""

from __future__ import annotations

import numpy as np

from drystone.arrays import Bools, Floats, Ints
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.plane.polygon import area_vectors, following, loop_means

FLAT_TURN = 1e-9
"""A corner that turns inwards by less than this share of the area of the face counts as straight;
chosen, well above the rounding of coordinates."""

THIN = 1e-3
"""A fan about the first corner with a triangle below this share of the face is not taken where
another corner does better; chosen. Slivers cross other faces where the face is warped."""

MOST_CORNERS = 12
"""Of a face whose corners are tried as the middle of a fan, chosen: beyond it hardly any sees all
the others."""


def triangulate(corners: Floats, start: Ints) -> tuple[Ints, Ints]:
    """Triangles that cover simple polygons, turning the way that the polygons turn.

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
    Source of the ear clipping: Meisters 1975, Polygons have ears.

    Examples
    --------
    >>> dart = np.array([[2.0, 0, 0], [0.5, 0.5, 0], [0, 2, 0], [0, 0, 0]])
    >>> triangulate(dart, np.array([0, 4]))[0].tolist()
    [[1, 2, 3], [1, 3, 0]]
    """
    count = np.diff(start)
    if len(count) == 0:
        return np.zeros((0, 3), dtype=np.intp), np.zeros(0, dtype=np.intp)
    flat = _flattened(corners, start)
    triangle = _fans(start)
    polygon = np.repeat(np.arange(len(count), dtype=np.intp), count - 2)
    first = np.concatenate([[0], np.cumsum(count - 2)])
    convex = _convex(flat, start)
    poor = np.flatnonzero(~convex | _thin(flat, triangle, first))
    for size in np.unique(count[poor][count[poor] <= MOST_CORNERS]):
        same = poor[count[poor] == size]
        corner, seen = _seen_from_one(flat[start[same][:, None] + np.arange(size)])
        rows = first[same[seen], None] + np.arange(size - 2)
        triangle[rows] = start[same[seen], None, None] + corner[seen]
        poor = np.setdiff1d(poor, same[seen], assume_unique=True)
    for i in poor[~convex[poor]]:
        ears = _clip_ears(flat[start[i] : start[i + 1]])
        triangle[first[i] : first[i + 1]] = ears + start[i]
    return triangle, polygon


def _flattened(corners: Floats, start: Ints) -> Floats:
    """Corners (l, 2) seen along each polygon's area vector: counter-clockwise."""
    area = area_vectors(corners, start)
    length = np.linalg.norm(area, axis=1)
    normal = np.where(
        length[:, None] > 0.0, area / np.where(length > 0.0, length, 1.0)[:, None], [0.0, 0.0, 1.0]
    )
    frame = frames_from_normals(normal)
    loop = np.repeat(np.arange(len(start) - 1), np.diff(start))
    local = corners - loop_means(corners, start)[loop]
    flat: Floats = np.einsum("lij,lj->li", frame[loop, 1:], local)
    return flat


def _convex(flat: Floats, start: Ints) -> Bools:
    after = following(start)
    edge = flat[after] - flat
    turn = _cross(edge, edge[after])
    loop = np.repeat(np.arange(len(start) - 1), np.diff(start))
    area = 0.5 * np.add.reduceat(_cross(flat, flat[after]), start[:-1])
    inward = turn < -FLAT_TURN * np.abs(area)[loop]
    return ~np.logical_or.reduceat(inward, start[:-1])


def _thin(flat: Floats, triangle: Ints, first: Ints) -> Bools:
    """Whether a polygon of more than three corners has a triangle that is next to nothing."""
    a, b, c = (flat[triangle[:, i]] for i in range(3))
    double = _cross(b - a, c - a)
    whole = np.add.reduceat(double, first[:-1])
    return (np.minimum.reduceat(double, first[:-1]) < THIN * whole) & (np.diff(first) > 1)


def _fans(start: Ints) -> Ints:
    count = np.diff(start) - 2
    base = np.repeat(start[:-1], count)
    step = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return np.stack([base, base + step + 1, base + step + 2], axis=1).astype(np.intp)


def _seen_from_one(flat: Floats) -> tuple[Ints, Bools]:
    """Fans (m, c - 2, 3) of polygons (m, c, 2) about the corner that sees the others best.

    A fan covers the polygon when all its triangles turn the polygon's way.

    Returns
    -------
    triangle : (m, c - 2, 3) corners
    seen : (m,) whether there is such a corner
    """
    m, c = flat.shape[:2]
    after = flat - flat[:, :1]
    area = 0.5 * _cross(after, np.roll(after, -1, axis=1)).sum(axis=1)
    least = np.empty((m, c))
    for k in range(c):
        spoke = np.roll(flat, -k, axis=1)[:, 1:] - flat[:, k, None]
        least[:, k] = _cross(spoke[:, :-1], spoke[:, 1:]).min(axis=1)
    best = least.argmax(axis=1)
    turned = (best[:, None] + np.arange(c)) % c
    triangle = np.stack(
        [np.repeat(turned[:, :1], c - 2, axis=1), turned[:, 1:-1], turned[:, 2:]], -1
    )
    return triangle.astype(np.intp), least[np.arange(m), best] > FLAT_TURN * np.abs(area)


def _cross(a: Floats, b: Floats) -> Floats:
    cross: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return cross


def _clip_ears(flat: Floats) -> Ints:
    """Triangles (c - 2, 3) of one counter-clockwise simple polygon (c, 2)."""
    left = list(range(len(flat)))
    ears: list[tuple[int, int, int]] = []
    while len(left) > 3:
        ring = np.array(left)
        before, after = np.roll(ring, 1), np.roll(ring, -1)
        turn = _cross(flat[ring] - flat[before], flat[after] - flat[ring])
        position = _find_ear(flat, ring, turn)
        ears.append((int(before[position]), int(ring[position]), int(after[position])))
        del left[position]
    ears.append((left[0], left[1], left[2]))
    return np.array(ears, dtype=np.intp)


def _find_ear(flat: Floats, ring: Ints, turn: Floats) -> int:
    """The first corner that can be cut off; the sharpest where a crossed loop has none."""
    reflex = ring[turn <= 0.0]
    size = len(ring)
    for position in np.flatnonzero(turn > 0.0):
        corner = ring[[position - 1, position, (position + 1) % size]]
        others = reflex[~np.isin(reflex, corner)]
        a, b, c = flat[corner]
        inside = (
            (_cross(b - a, flat[others] - a) >= 0.0)
            & (_cross(c - b, flat[others] - b) >= 0.0)
            & (_cross(a - c, flat[others] - c) >= 0.0)
        )
        if not inside.any():
            return int(position)
    return int(np.argmax(turn))
