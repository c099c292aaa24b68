"""Plane sections: moments of polygons and the kern.

A normal force within the kern puts the whole section in compression. A section is a polygon (three
or more corners, any sense of rotation), a line (two) or a point (one). A line is the limit of a
thin rectangle.

Sources: Hally 1987, Calculation of the moments of polygons (moments); Young and Budynas 2002,
Roark's formulas for stress and strain, section 8.10 (kern).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.ragged import Ragged


@dataclass(frozen=True, eq=False)
class Sections:
    """Moments of m plane sections.

    Attributes
    ----------
    area : (m,) [m2]; zero for lines and points
    centroid : (m, 2) [m]
    inertia : (m, 2, 2) [m2]
        Second moments about the centroid, divided by the area: the mean of ``x x'``.
    inverse : (m, 2, 2) [1/m2]
        Of the inertia; its pseudo-inverse for a line, zero for a point.
    """

    area: Floats
    centroid: Floats
    inertia: Floats
    inverse: Floats


def sections(corners: Floats, start: Ints | Ragged) -> Sections:
    """Moments of sections.

    Parameters
    ----------
    corners : (k, 2) [m]
        Corners, section after section.
    start : (m + 1,)
        Section i has the corners ``start[i]`` to ``start[i + 1]``, one or more; or these as rows.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> made = sections(square, np.array([0, 4]))
    >>> float(made.area[0]), made.centroid[0].tolist()
    (4.0, [1.0, 1.0])
    """
    loops = Ragged.over(start)
    mean = loops.mean(corners)
    a = corners - mean[loops.owner]
    (x, y), (u, v) = a.T, a[loops.following].T
    cross, s, t = x * v - y * u, x + u, y + v
    # integral of x x' over the triangle (0, a, b): cross / 24 (s s' + a a' + b b'), s = a + b
    outer = np.array([s * s + x * x + u * u, s * t + x * y + u * v, t * t + y * y + v * v])
    moments = np.array([cross, s * cross, t * cross, *(outer * cross), x * x, x * y, y * y])
    total = loops.sum(moments.T).T
    signed = 0.5 * total[0]
    flat = np.abs(signed) <= 1e-14 * (total[6] + total[8])
    safe = np.where(flat, 1.0, signed)
    shift = np.where(flat, 0.0, total[1:3] / (6.0 * safe))
    second = total[3:6] / (24.0 * safe) - shift[[0, 0, 1]] * shift[[0, 1, 1]]
    # a line: uniform between its two ends
    xx, xy, yy = inertia = np.where(flat, total[6:] / (3.0 * loops.counts), second)
    # of rank one, the pseudo-inverse is the matrix by the square of its trace
    trace = xx + yy
    rank_one = inertia / np.where(trace > 0.0, trace, 1.0) ** 2
    adjugate = np.array([yy, -xy, xx]) / np.where(flat, 1.0, xx * yy - xy * xy)
    inverse = np.where(flat, rank_one, adjugate)
    area = np.where(flat, 0.0, np.abs(signed))
    return Sections(area, mean + shift.T, _symmetric(inertia), _symmetric(inverse))


def _symmetric(parts: Floats) -> Floats:
    """Matrices (m, 2, 2) of their numbers xx, xy and yy (3, m)."""
    return parts[[0, 1, 1, 2]].T.reshape(-1, 2, 2)


def level_hull(points: Floats) -> Floats:
    """Corners (h, 3) of the convex hull, seen from above, of points (p, 3) of one height."""
    flat = convex_hull(points[:, :2])
    return np.column_stack([flat, np.full(len(flat), points[0, 2])])


def convex_hull(points: Floats) -> Floats:
    """Corners (h, 2) of the convex hull, counter-clockwise, without those on straight edges.

    Source: Andrew 1979, the monotone chain.
    """
    ordered = sorted({(x, y) for x, y in points.tolist()})
    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)
    size = max(ordered[-1][0] - ordered[0][0], float(np.ptp(points[:, 1])))
    least = 1e-12 * size**2

    def chain(row: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for x, y in row:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2], kept[-1]
                if (bx - ax) * (y - by) - (by - ay) * (x - bx) > least:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def kern(corners: Floats) -> Floats:
    """The kern (h, 2) [m] of one section, counter-clockwise.

    A concave section has the moments of its own shape and the neutral axes of its convex hull.
    Corner i of the kern is the pole of edge i of the hull: a force there causes zero pressure at
    that edge. It lies at ``c - J n / d``, with the centroid c, the unit normal n of the edge, its
    distance d from c, and the second moments J divided by the area.

    Parameters
    ----------
    corners : (c, 2) [m]

    Examples
    --------
    >>> kern(np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [0.0, 3.0]])).round(9).tolist()
    [[3.0, 2.0], [2.0, 1.5], [3.0, 1.0], [4.0, 1.5]]
    """
    made = sections(corners, np.array([0, len(corners)]))
    centroid, inertia = made.centroid[0], made.inertia[0]
    hull = convex_hull(corners)
    if made.area[0] == 0.0:
        return centroid + (hull - hull.mean(axis=0)) / 3.0
    edge = np.roll(hull, -1, axis=0) - hull
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
    reach = ((hull - centroid) * normal).sum(axis=1)
    return centroid - (normal / reach[:, None]) @ inertia


def kern_ratio(made: Sections, corners: Floats, start: Ints, position: Floats) -> Floats:
    """Eccentricity (m,) relative to the boundary of the kern: above 1 the section opens.

    Parameters
    ----------
    made, corners, start
        As for :func:`sections`.
    position : (m, 2) [m]
        Where the normal force of each section acts.
    """
    if len(start) < 2:
        return np.zeros(0)
    slope = np.einsum("mij,mj->mi", made.inverse, position - made.centroid)
    loops = Ragged(start)
    arm = corners - loops.spread(made.centroid)
    relief = -(arm * loops.spread(slope)).sum(axis=1)
    return np.maximum(0.0, loops.max(relief))


@lru_cache(maxsize=10_000)
def _hull(corners: bytes) -> tuple[Floats, Floats]:
    """The hull of corners, and the normals of its edges: each answer asks again for each joint."""
    hull = convex_hull(np.frombuffer(corners).reshape(-1, 2))
    edge = np.concatenate([hull[1:], hull[:1]]) - hull
    return hull, np.stack([edge[:, 1], -edge[:, 0]], axis=1)


def edge_ratio(made: Sections, corners: Floats, start: Ints | Ragged, position: Floats) -> Floats:
    """Eccentricity (m,) relative to the boundary of the convex hull: 1 is a hinge.

    Parameters as for :func:`kern_ratio`.
    """
    loops = Ragged.over(start)
    owner, after = loops.owner, loops.following
    local = corners - made.centroid[owner]
    x, y = local.T
    along, up = (corners[after] - corners).T
    reach = x * up - y * along
    inwards = up * along[after] - along * up[after]
    square = along * along + up * up
    rounding = 1e-12 * loops.max(square)
    # the hull of a convex loop is the loop, unless corners are the same but for rounding
    convex = (loops.max(inwards) <= rounding) & (loops.min(square) > rounding)
    convex &= loops.min(reach) > 0.0
    at, beside = (position - made.centroid)[owner].T
    share = up * at - along * beside
    far = loops.max(share / np.where(reach > 0.0, reach, 1.0))
    out = np.where(convex, np.maximum(0.0, far), 0.0)
    for i in np.flatnonzero(~convex).tolist():
        hull, normal = _hull(corners[loops[i]].tobytes())
        away = position[i] - made.centroid[i]
        if len(hull) < 3:
            half = 0.5 * float(np.linalg.norm(np.ptp(hull, axis=0)))
            out[i] = float(np.linalg.norm(away)) / half if half > 0.0 else 0.0
            continue
        reach = ((hull - made.centroid[i]) * normal).sum(axis=1)
        out[i] = max(0.0, float((normal @ away / reach).max()))
    return out
