"""Wedge: shift of the corners of bed joints towards the neighbouring course."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Real
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import InputError
from drystone.shells.courses import Courses
from drystone.shells.patch import line_curvatures, numbers

Wedge: TypeAlias = float | Sequence[float] | Callable[[Floats, Floats], Floats]
"""Shift of bed-joint corners towards the neighbouring course, relative to its height: one value,
one per bed line between two courses, or a function of (u, v)."""

_FLAT_WEDGE = 0.4
"""Largest wedge from the curvatures. Chosen: a little below the largest possible one."""

LARGEST_WEDGE = 0.45
"""Largest wedge. Chosen: at half the height of a course head joints have no length."""


def wedge_amount(
    courses: Courses, wedge: Wedge | None, lines: Floats, v: Floats, line: Ints
) -> Floats:
    """Wedge (p,) at each vertex, relative to the height of the course.

    Parameters
    ----------
    courses
    wedge
        None: the wedge of planar cells.
    lines : (p, c + 1) position of every bed line at each vertex, relative to the length along u
    v, line : (p,) position and bed line of each vertex

    Raises
    ------
    InputError
        Not finite, too large, or of another length.
    """
    if wedge is None:
        return _flat_wedge(courses, lines, v, line)
    share = lines[np.arange(len(v)), line]
    where = f"patch '{courses.patch.name}'"
    if callable(wedge):
        amount = numbers(wedge(courses.parameter(share, v), v), "wedges", where)
        if amount.shape != v.shape:
            raise InputError(f"the wedge function gave shape {amount.shape} for {len(v)} corners")
    elif isinstance(wedge, Real):
        amount = np.full(len(v), float(wedge))
    else:
        values = numbers(wedge, "wedges", where)
        if values.shape != (courses.count - 1,):
            raise InputError(
                f"{values.size} wedges for {courses.count - 1} bed lines between courses"
            )
        amount = np.concatenate([[0.0], values, [0.0]])[line]
    if not np.isfinite(amount).all():
        raise InputError(
            f"the wedge is {amount[~np.isfinite(amount)][0]}",
            where=where,
            remedy=f"give numbers from -{LARGEST_WEDGE} to {LARGEST_WEDGE}",
        )
    bad = np.abs(amount) > LARGEST_WEDGE
    if bad.any():
        k = int(np.flatnonzero(bad)[0])
        raise InputError(
            f"the wedge {amount[k]:.3g} of a course's height turns blocks inside out",
            where=f"block 'c{int(min(line[k], courses.count - 1)):02d}-b00' and its neighbours",
            remedy=f"stay within -{LARGEST_WEDGE} and {LARGEST_WEDGE}",
        )
    return amount


def _flat_wedge(courses: Courses, lines: Floats, v: Floats, line: Ints) -> Floats:
    """Wedge (p,) of planar cells on a surface with these curvatures, at most the largest.

    The tangent planes at the middles of the cells intersect in the edges of a power diagram of
    these middles, with lengths along u and v scaled by the root of the curvatures. In a bond of
    width w and height h the corners are shifted by ``k_v w^2 / (8 k_u h^2)`` of the height. Source
    (tangent planes of a paraboloid): Aurenhammer 1987, Power diagrams.
    """
    row = np.arange(len(v))
    at_u = [
        courses.parameter(lines[row, np.clip(line + step, 0, courses.count)], v)
        for step in (-1, 0, 1)
    ]
    low, here, high = (courses.patch.point(u, v) for u in at_u)
    height = 0.5 * (np.linalg.norm(high - here, axis=1) + np.linalg.norm(here - low, axis=1))
    width = np.zeros(len(v))
    for level in np.unique(line):
        on = np.flatnonzero(line == level)
        on = on[np.argsort(v[on], kind="stable")]
        gap = np.diff(v[on], append=v[on[:1]] + 1.0)
        width[on] = gap + np.roll(gap, 1)
    along = np.linalg.norm(courses.patch.tangents(at_u[1], v)[1], axis=1)
    across, around = line_curvatures(courses.patch, at_u[1], v)
    wanted = around * (width * along) ** 2
    given = 8.0 * across * height**2
    given = np.where(np.abs(given) > 1e-12 * np.abs(wanted), given, 1e-12 * np.abs(wanted) + 1e-300)
    return np.clip(wanted / given, -_FLAT_WEDGE, _FLAT_WEDGE)


def eased_share(v: Floats, line: Ints, direction: Floats, *, closed: bool) -> Floats:
    """Share (p,) of the wedge at each vertex: smaller where joints above and below are close.

    The share is 2 d / D. D is the distance between the previous and the next vertex with the
    opposite shift; d is the distance to the nearer of them. It is 1 in a regular bond, so no bed
    joint is steeper than there.
    """
    share = np.ones(len(v))
    for level in np.unique(line):
        on = np.flatnonzero(line == level)
        on = on[np.argsort(v[on], kind="stable")]
        if len(on) < 3:
            continue
        gap = np.diff(v[on], append=v[on[:1]] + 1.0)
        turn = direction[on] != direction[np.roll(on, -1)]
        left, right = np.roll(gap, 1), gap
        nearer = np.minimum(np.where(np.roll(turn, 1), left, np.inf), np.where(turn, right, np.inf))
        eased = np.minimum(1.0, 2.0 * nearer / (left + right))
        share[on] = eased
        if not closed:
            share[on[[0, -1]]] = 1.0
    return share
