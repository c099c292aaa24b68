"""Walls of rectangular blocks."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.models.simple import box
from drystone.models.solids import require

Bond: TypeAlias = Literal["running", "toothed", "stack"]


def course_ends(length: int, shifted: bool, bond: Bond) -> list[float]:
    """Places of the head joints of one course, ends included, in block lengths.

    Examples
    --------
    >>> course_ends(2, True, "running")
    [0.0, 0.5, 1.5, 2.0]
    >>> course_ends(2, True, "toothed")
    [0.5, 1.5, 2.5]
    """
    whole = [float(i) for i in range(length + 1)]
    if not shifted or bond == "stack":
        return whole
    if bond == "toothed":
        return [x + 0.5 for x in whole]
    return [0.0, *(x + 0.5 for x in whole[:-1]), float(length)]


def wall(
    courses: int = 6,
    length: int = 5,
    size: Sequence[float] = (0.4, 0.2, 0.2),
    *,
    bond: Bond = "running",
    shift_first: bool = False,
    corbel: float = 0.0,
    ground: bool = False,
) -> Assembly:
    """A straight wall along x.

    Parameters
    ----------
    courses, length
        Number of courses, and of block lengths per course.
    size : (3,) [m]
        Length, depth and height of a block.
    bond
        ``running``: every other course is shifted by half a block, with half blocks at its ends.
        ``toothed``: the same shift without half blocks, the ends are stepped; ``courses * length``
        equal blocks with ``courses * (length - 1) + (courses - 1) * (2 * length - 1)`` joints.
        ``stack``: no shift.
    shift_first
        Whether the lowest course is one of the shifted ones; otherwise the second is the first.
    corbel : [m]
        Shift of each course along +y over the one below.
    ground
        Whether the wall stands on a fixed block of its own. Otherwise its lowest course is fixed.

    Returns
    -------
    Assembly
        ``ground`` if asked for, then ``c00-b00`` along x and course by course upwards.

    Examples
    --------
    >>> len(wall(6, 5))
    33
    """
    require(courses > 0 and length > 0, f"a wall of {courses} x {length} blocks", "one or more")
    require(bond in ("running", "toothed", "stack"), f"no bond '{bond}'", "running, toothed, stack")
    dx, dy, dz = (float(s) for s in size)
    blocks: list[Block] = []
    lowest = 1
    if ground:
        blocks.append(box(((length + 1) * dx, 3.0 * dy, dz), (-0.5 * dx, -dy, -dz), "ground"))
    for row in range(courses):
        ends = [x * dx for x in course_ends(length, (row + shift_first) % 2 == 1, bond)]
        blocks += [
            box((right - left, dy, dz), (left, row * corbel, row * dz), f"c{row:02d}-b{i:02d}")
            for i, (left, right) in enumerate(pairwise(ends))
        ]
        if row == 0 and not ground:
            lowest = len(blocks)
    return Assembly(tuple(blocks), np.arange(len(blocks)) < lowest)


def ferris_wall(number: int) -> Assembly:
    """Wall 1 (6 courses, 33 blocks) or 2 (10 courses, 55 blocks) of Ferris and Tin-Loi 2001.

    Blocks of 0.4 x 0.175 m on a fixed ground, half blocks at the ends of the first, third, ...
    course, friction 0.65, a horizontal body load along x in proportion to the weight. Associative
    limit factors: 0.64286 and 0.58000.
    """
    require(number in (1, 2), f"there is no wall {number}", "1 or 2")
    return wall(6 if number == 1 else 10, 5, (0.4, 0.2, 0.175), shift_first=True, ground=True)


def corbelled_wall(
    courses: int = 6,
    length: int = 4,
    size: Sequence[float] = (0.4, 0.3, 0.15),
    corbel: float = 0.04,
) -> Assembly:
    """A wall in running bond in which each course is shifted along +y from the one below.

    It overturns when the centroid of the part above a course is beyond the edge of that course: for
    n free courses when ``(n + 1) * corbel > depth``. Parameters as in :func:`wall`.
    """
    require(
        abs(corbel) < float(size[1]),
        "a course does not rest on the one below",
        "reduce the step of each course",
    )
    return wall(courses, length, size, corbel=corbel)
