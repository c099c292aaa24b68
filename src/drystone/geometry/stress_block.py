"""Stress blocks: parts of a face under one pressure, and the forces that they carry.

A face whose pressure lies between zero and a strength f carries the normal forces and moments
``(N, M) = integral(p (1, x, y))``. They form a convex set. Its extreme points are parts beyond a
line under f: ``f A' (1, x', y')`` with the area A' and the centroid of the part.
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats, Ints, dot, plane_cross
from drystone.base.ragged import Ragged

_STEPS = 200
"""Largest number of Newton steps. A force at 1e-9 of the size from the rim takes about 50."""


def cut_off(corners: Floats, start: Ints, plane: Floats) -> Floats:
    """Area and first moments (m, 3) of the part of each polygon where a plane is positive.

    Parameters
    ----------
    corners : (k, 2) [m]
        Polygon after polygon, counter-clockwise; they need not be convex.
    start : (m + 1,)
        Polygon i has the corners ``start[i]`` to ``start[i + 1] - 1``.
    plane : (m, 3)
        Positive where ``plane[0] + plane[1] x + plane[2] y > 0``.

    Examples
    --------
    The right half of a square:

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> cut_off(square, np.array([0, 4]), np.array([[-0.5, 1.0, 0.0]])).tolist()
    [[0.5, 0.375, 0.25]]
    """
    loops = Ragged(start)
    owner, after = loops.owner, loops.following
    height = plane[owner, 0] + dot(corners, plane[owner, 1:])
    inside = height > 0.0
    crosses = inside != inside[after]
    share = height / np.where(crosses, height - height[after], 1.0)
    crossing = corners + share[:, None] * (corners[after] - corners)
    one = np.where((crosses & ~inside)[:, None], crossing, corners)
    other = np.where((crosses & inside)[:, None], crossing, corners[after])
    # each clipped edge spans a triangle with a point of the line: those along the line are empty
    apex = corners[loops.first]
    apex[owner[crosses]] = crossing[crosses]
    one, other = one - apex[owner], other - apex[owner]
    area = np.where(inside | crosses, plane_cross(one, other), 0.0) / 2.0
    whole = loops.sum(area)
    moment = loops.sum(area[:, None] * (one + other)) / 3.0 + whole[:, None] * apex
    return np.column_stack([whole, moment])


def stress_block(corners: Floats, start: Ints, position: Floats) -> tuple[Floats, Floats]:
    """Area (m,) [m2] of the part beyond a line whose centroid is a given point, and the line.

    No other part of the face centred there is larger: a normal force N at the point needs the
    strength ``N / area``.

    Parameters
    ----------
    corners, start
        As for :func:`cut_off`.
    position : (m, 2) [m]
        Zero area on or outside the rim of the convex hull, and of lines and points.

    Returns
    -------
    area : (m,)
    plane : (m, 3)
        Positive over the part; see :func:`cut_off`.

    Notes
    -----
    With the point at the origin it is the minimum over b of the convex function
    ``integral(max(0, 1 + b . x))``. The gradient is the first moment of the part; the Hessian is
    an integral along the line.

    Examples
    --------
    At a quarter of the height half of a wall is pressed:

    >>> wall = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [0.0, 3.0]])
    >>> stress_block(wall, np.array([0, 4]), np.array([[0.5, 0.75]]))[0].round(9).tolist()
    [1.5]
    """
    loops = Ragged(start)
    everywhere = np.tile([1.0, 0.0, 0.0], (len(loops), 1))
    plane = everywhere.copy()
    full = cut_off(corners, start, everywhere)
    area = np.maximum(full[:, 0], 0.0)
    size = np.sqrt(np.where(area > 0.0, area, 1.0))
    away = full[:, 1:] / np.where(area > 0.0, area, 1.0)[:, None] - position
    off = np.hypot(away[:, 0], away[:, 1]) / size
    search = np.flatnonzero((area > 0.0) & (off > 1e-12))
    if len(search):
        part, row = loops.take(search)
        local = (corners[row] - part.spread(position[search])) / part.spread(size[search])[:, None]
        outward = -away[search] / (off * size)[search, None]
        share, slope = _least(local, part, outward)
        area[search] *= share
        slope /= size[search, None]
        plane[search] = np.column_stack([1.0 - dot(slope, position[search]), slope])
    return area, plane


def _least(corners: Floats, loops: Ragged, outward: Floats) -> tuple[Floats, Floats]:
    """Least ``integral(max(0, 1 + b . x))`` (m,) and its b (m, 2), of polygons of unit area.

    ``outward`` (m, 2) is the direction from the centroid to the origin.
    """
    reach = loops.max(dot(corners, loops.spread(outward)))
    slope = outward / np.maximum(reach, 1e-12)[:, None]
    value, step, promised = _newton(corners, loops, slope)
    share = np.ones(len(value))
    for _ in range(_STEPS):
        active = (promised > 1e-15 * value) & (value > 1e-15)
        if not active.any():
            break
        moved = slope + np.where(active, share, 0.0)[:, None] * step
        lower, onward, more = _newton(corners, loops, moved)
        good = active & (lower <= value * (1.0 + 1e-15) - 1e-4 * share * promised)
        slope = np.where(good[:, None], moved, slope)
        step = np.where(good[:, None], onward, step)
        value, promised = np.where(good, lower, value), np.where(good, more, promised)
        share = np.where(good, 1.0, np.where(active, 0.5 * share, share))
        promised = np.where(share < 1e-12, 0.0, promised)  # rounding hides what is left
    return value, slope


def _newton(corners: Floats, loops: Ragged, slope: Floats) -> tuple[Floats, Floats, Floats]:
    """Value (m,), Newton step (m, 2) and the decrease that it promises (m,) at slopes (m, 2)."""
    after = loops.following
    plane = np.column_stack([np.ones(len(slope)), slope])
    found = cut_off(corners, loops.start, plane)
    value, gradient = dot(found, plane), found[:, 1:]
    steepness = np.hypot(slope[:, 0], slope[:, 1])
    across = slope / steepness[:, None]
    along = np.stack([-across[:, 1], across[:, 0]], axis=1)
    height = 1.0 + dot(corners, loops.spread(slope))
    place = dot(corners, loops.spread(along))
    inside = height > 0.0
    crosses = inside != inside[after]
    share = height / np.where(crosses, height - height[after], 1.0)
    sign = np.where(crosses, np.where(inside, 1.0, -1.0), 0.0)
    t = place + share * (place[after] - place)
    width, first, second = (loops.sum(sign * t**n / n) for n in (1, 2, 3))
    foot = -1.0 / steepness  # of the line, by the direction across it
    hessian = np.empty((len(slope), 2, 2))
    hessian[:, 0, 0], hessian[:, 1, 1] = foot**2 * width, second
    hessian[:, 0, 1] = hessian[:, 1, 0] = foot * first
    hessian /= steepness[:, None, None]
    turned = np.stack([dot(gradient, across), dot(gradient, along)], axis=1)
    determinant = hessian[:, 0, 0] * hessian[:, 1, 1] - hessian[:, 0, 1] ** 2
    known = determinant > 1e-12 * hessian[:, 0, 0] * np.abs(hessian[:, 1, 1])
    safe = np.where(known, determinant, 1.0)
    newton = np.stack(
        [
            hessian[:, 0, 1] * turned[:, 1] - hessian[:, 1, 1] * turned[:, 0],
            hessian[:, 0, 1] * turned[:, 0] - hessian[:, 0, 0] * turned[:, 1],
        ],
        axis=1,
    ) / safe[:, None]  # fmt: skip
    # where the line leaves the whole polygon on one side the function is linear
    size = np.hypot(turned[:, 0], turned[:, 1])
    steep = -turned * (0.5 * steepness / np.where(size > 0.0, size, 1.0))[:, None]
    chosen = np.where(known[:, None], newton, steep)
    # near the centroid the first line cuts so little that the step is 1e8 times too long
    length = np.hypot(chosen[:, 0], chosen[:, 1])
    chosen *= np.minimum(1.0, steepness / np.where(length > 0.0, length, 1.0))[:, None]
    step = chosen[:, :1] * across + chosen[:, 1:] * along
    return value, step, -dot(turned, chosen)
