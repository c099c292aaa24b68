"""Plane sections: moments of polygons and the kern, and pressure without tension.

A normal force within the kern puts the whole section in compression. A section is a polygon (three
or more corners, any sense of rotation), a line (two) or a point (one). A line is the limit of a
thin rectangle.

Sources: Hally 1987, Calculation of the moments of polygons (moments); Young and Budynas 2002,
Roark's formulas for stress and strain, section 8.10 (kern).

The pressure is linear in the compressed part and zero elsewhere: ``p(x) = max(0, q + s . (x - e))``
with the force N at e. Equilibrium requires ``integral(p) = N`` and ``integral(p (x - e)) = 0``. The
line ``q + s . (x - e) = 0`` is the neutral line.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from drystone.base.arrays import Floats, Ints, dot, lengths, plane_cross
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
    size = float(np.ptp(points, axis=0).max(initial=0.0))
    grid = 1e-9 * size or 1.0  # those of one x but for rounding are in order of y
    ordered = [at for _, at in sorted({(round(x / grid), round(y / grid)): (x, y)
                                       for x, y in points.tolist()}.items())]  # fmt: skip
    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)
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


EDGE = 1e-7
"""A force closer to the rim than this share of the distance from the centroid acts on the rim."""
_CONVERGED = 1e-14
"""Newton decrement divided by the function's value, which is no more exact than that: the pressure
then has about seven correct digits. One quadrilateral of a thousand keeps more than a hundredth of
it by rounding."""
DESCENT = 1e-4
"""Share of the predicted decrease that a step must reach (Nocedal, Wright 2006, eq. 3.4)."""
_MOST_STEPS = 50
"""Largest number of steps. Convex polygons of 3 to 24 sides take 1 to 6, wherever the force acts,
as a rule; one concave one of a thousand, with a needle, is not done by then."""


def peak_pressure(
    made: Sections, corners: Floats, start: Ints, normal: Floats, position: Floats
) -> Floats:
    """Largest pressure (m,) [Pa] on sections that carry no tension.

    Parameters
    ----------
    made, corners, start
        As for :func:`drystone.geometry.kern.sections`.
    normal : (m,) [N]
        Normal force, positive in compression. The pressure is zero where it is not positive.
    position : (m, 2) [m]
        Point of action. The pressure is infinite on or outside the rim of the convex hull.

    Notes
    -----
    Within the kern the whole section is compressed: ``p = N / A (1 + (e - c) . J^-1 (x - c))``.
    Outside the kern, (q, s) minimise the convex function ``1/2 integral(p^2) - N q``. Its gradient
    is the equilibrium condition. Its Hessian holds the moments of the compressed part. Newton's
    method with step halving finds the minimum, for all sections at once.

    Examples
    --------
    A force at a sixth of the height from the edge compresses half of the height:

    >>> from drystone.geometry.kern import sections
    >>> wall = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [0.0, 3.0]])
    >>> one = (sections(wall, np.array([0, 4])), wall, np.array([0, 4]))
    >>> peak_pressure(*one, np.array([6.0]), np.array([[0.5, 0.5]])).round(6).tolist()
    [8.0]
    """
    pressed = normal > 0.0
    loops = Ragged.over(start)
    inside = np.where(pressed[:, None], position, made.centroid)
    plane = linear_pressure(made, corners, loops, inside)
    factor = loops.max(plane[loops.owner, 0] + dot(corners, plane[loops.owner, 1:]))
    area = np.where(made.area > 0.0, made.area, 1.0)
    return np.where(pressed, factor * normal / area, 0.0)


def linear_pressure(
    made: Sections, corners: Floats, start: Ints | Ragged, position: Floats
) -> Floats:
    """The pressures ``max(0, q + s . x)`` of sections that carry no tension, by their mean ones.

    Parameters as for :func:`peak_pressure`. Returns (m, 3): q, and s [1/m]. They are infinite and
    zero for a section without area, or with the force on or outside the rim of the convex hull.
    """
    loops = Ragged.over(start)
    plane = np.empty((len(loops), 3))
    plane[:, 1:] = np.einsum("mij,mj->mi", made.inverse, position - made.centroid)
    plane[:, 0] = 1.0 - dot(plane[:, 1:], made.centroid)
    plane[made.area == 0.0] = [np.inf, 0.0, 0.0]
    each = plane[loops.owner]
    rise = each[:, 0] + dot(corners, each[:, 1:])
    opened = np.flatnonzero(loops.min(rise) < 0.0)
    if len(opened):
        part, row = loops.take(opened)
        some = Sections(*(each[opened] for each in vars(made).values()))
        plane[opened] = _opened(some, corners[row], part, position[opened])
    return plane


def _opened(made: Sections, corners: Floats, loops: Ragged, position: Floats) -> Floats:
    """The planes (m, 3) of :func:`linear_pressure` for sections with the force outside the kern."""
    inside = edge_ratio(made, corners, loops, position) < 1.0 - EDGE
    owner = loops.owner
    size = np.sqrt(made.area)
    local = (corners - position[owner]) / size[owner, None]  # unit area, the force at the origin
    slope = size[:, None] * np.einsum("mij,mj->mi", made.inverse, position - made.centroid)
    plane = _first_guess(local, loops, slope)
    value, decrement, step = _newton(local, loops, plane)
    share = np.ones(len(plane))
    for _ in range(_MOST_STEPS):
        active = inside & (decrement > _CONVERGED * np.abs(value))
        if not active.any():
            break
        moved = plane + np.where(active, share, 0.0)[:, None] * step
        trial = _newton(local, loops, moved)
        allowed = _CONVERGED * np.abs(value) - DESCENT * share * decrement
        good = active & (trial[0] <= value + allowed)
        value, decrement = np.where(good, trial[:2], (value, decrement))
        plane, step = np.where(good[:, None], (moved, trial[2]), (plane, step))
        share = np.where(good, 1.0, 0.5 * share)
    plane[:, 1:] /= size[:, None]
    plane[:, 0] -= dot(plane[:, 1:], position)
    return np.where(inside[:, None], plane, [np.inf, 0.0, 0.0])


def _first_guess(local: Floats, loops: Ragged, slope: Floats) -> Floats:
    """Planes (m, 3) that are 1 at the origin, where the force acts.

    They are right for convex polygons if the force is close to an edge or in a corner. What is
    pressed has the depth ``deep (1 - narrows s)`` at the share s of the nearest edge, in oblique
    axes along it and the next one. The force acts at the mean of s by the square of the depth.
    Others are as in a strip, which is pressed to three times the distance of the force from its
    rim, down the slope (m, 2) that pressure has without an opening.
    """
    after = loops.following
    edge = local[after] - local
    sense = np.sign(loops.sum(plane_cross(local, local[after])))[loops.owner]
    near = loops.argmax(sense * plane_cross(edge, local) / np.maximum(lengths(edge), 1e-300))
    late = dot(local[near] + local[after[near]], edge[near]) < 0.0
    before = np.argsort(after)
    corner, other, third = local[
        np.where(late, [after[near], near, after[after[near]]], [near, after[near], before[near]])
    ]
    along, across = other - corner, third - corner
    spanned = plane_cross(along, across)
    spanned = np.where(spanned == 0.0, 1.0, spanned)
    s = np.clip(plane_cross(across, corner) / spanned, 1e-9, 0.5)
    height = plane_cross(corner, along) / spanned
    rest = 2.0 / 3.0 - s
    root = np.sqrt(np.maximum(rest**2 - (1.0 - s / 0.75) * (0.5 - s), 0.0))
    narrows = np.where(s < 0.25, 0.25 / s, (1.0 - 2.0 * s) / (rest + root))
    end = np.maximum(1.0 - narrows, 0.0)
    deep = 4.0 * height * (1.0 + end + end**2) / ((1.0 + end) * (1.0 + end**2))
    here = (deep * (1.0 - narrows * s) - height) * spanned
    fall = (deep * narrows)[:, None] * across - along
    fall = np.stack([-fall[:, 1], fall[:, 0]], axis=1)
    convex = (loops.min(sense * plane_cross(edge, edge[after])) >= 0.0) & (here != 0.0)
    ahead = np.maximum(loops.max(dot(local, slope[loops.owner])), EDGE)
    strip = slope / (2.0 * ahead[:, None])
    by_edge = fall / np.where(convex, here, 1.0)[:, None]
    return np.column_stack([np.ones(len(slope)), np.where(convex[:, None], by_edge, strip)])


def _newton(local: Floats, loops: Ragged, plane: Floats) -> tuple[Floats, Floats, Floats]:
    """The function, Newton's decrement (m,) and step (m, 3) at planes; unit force and area.

    The function is infinite where nothing is pressed. The decrement is the squared length of the
    step in the metric of the Hessian. Coordinates (h, t) run across and along the neutral line.
    """
    steepness = np.maximum(np.hypot(plane[:, 1], plane[:, 2]), 1e-300)
    u, v = plane[:, 1:].T / steepness
    x, y = local.T
    owner, after = loops.owner, loops.following
    along_x, along_y = u[owner], v[owner]
    height = x * along_x + y * along_y + (plane[:, 0] / steepness)[owner]
    side = y * along_x - x * along_y
    ends, sides = np.array([height, height[after]]), np.array([side, side[after]])
    up = ends > 0.0
    cut = up[0] != up[1]
    share = ends[0] / np.where(cut, ends[0] - ends[1], 1.0)
    crossing = side + share * (sides[1] - side)
    t = np.where(cut & ~up, crossing, sides)
    h = np.maximum(ends, 0.0)
    # Each clipped edge spans a triangle with the point of the neutral line below the force.
    # The edges that clipping adds lie on the neutral line: their triangles are empty.
    sign = np.sign(loops.sum(x * y[after] - y * x[after]))
    twice = (h[0] * t[1] - t[0] * h[1]) * sign[owner]
    (h0, h1), (t0, t1) = h, t
    hs, ts = h0 + h1, t0 + t1
    second = [hs * hs + h0 * h0 + h1 * h1, hs * ts + h0 * t0 + h1 * t1, ts * ts + t0 * t0 + t1 * t1]
    parts = loops.sum((twice * np.array([np.ones_like(side), hs, ts, *second])).T).T
    area = 0.5 * parts[0]
    some = area > 0.0
    safe = np.where(some, area, 1.0)
    h_mean, t_mean = parts[1:3] / (6.0 * safe)
    squared = parts[3] / 24.0
    hh, ht, tt = parts[3:] / (24.0 * safe) - np.array([h_mean**2, h_mean * t_mean, t_mean**2])
    determinant = hh * tt - ht**2
    some &= determinant > 0.0
    # The full Newton step is the linear pressure of the compressed part, with tension allowed.
    h_force, t_force = plane[:, 0] / steepness - h_mean, -t_mean
    scale = safe * np.where(some, determinant, 1.0)
    slope_h = (tt * h_force - ht * t_force) / scale
    slope_t = (hh * t_force - ht * h_force) / scale
    raised = 1.0 / safe - steepness * h_mean
    steeper = slope_h - steepness
    curved = hh * steeper**2 + 2.0 * ht * steeper * slope_t + tt * slope_t**2
    decrement = safe * (raised**2 + curved)
    level = raised + steeper * h_force + slope_t * t_force
    step = np.array([level, steeper * u - slope_t * v, steeper * v + slope_t * u]).T
    value = np.where(some, 0.5 * steepness**2 * squared - plane[:, 0], np.inf)
    return value, np.where(some, decrement, 0.0), step
