"""Walls of rectangular blocks."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.models.simple import box
from drystone.models.solids import prism, require

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
    courses, length : >= 1
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


def ferris_wall(number: Literal[1, 2] = 1) -> Assembly:
    """Wall 1 (6 courses, 33 blocks) or 2 (10 courses, 55 blocks) of Ferris and Tin-Loi 2001.

    Blocks of 0.4 x 0.175 m on a fixed ground, half blocks at the ends of the first, third, ...
    course, friction 0.65, a horizontal body load along x in proportion to the weight. Associative
    limit factors: 0.64286 and 0.58000.
    """
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
    rests = abs(corbel) < float(size[1])
    require(rests, "a course does not rest on the one below", "reduce the step of each course")
    return wall(courses, length, size, corbel=corbel)


def buttressed_wall(
    bays: int = 2,
    spacing: float = 3.0,
    courses: int = 10,
    course: float = 0.3,
    thickness: float = 0.5,
    *,
    buttress_width: float = 0.6,
    buttress_depth: float = 0.8,
    stones: int = 2,
) -> Assembly:
    """A straight wall along x with buttresses on its side towards +y, bonded into it.

    In every other course a buttress is one stone through the wall, with wings into it; in those
    between it is cut at the wall. Without bays it is one pier of depth b. A push H at the height h
    over its lowest joint overturns it when ``H h > W b / 2 - w (b - thickness / 2)``: of the free
    weight W the lowest stone of the wall, w, is not lifted.

    Parameters
    ----------
    bays
        Between buttresses, of which there is one more; 0: one buttress with its part of the wall.
    spacing : [m]
        Of the buttresses, from axis to axis.
    courses
        The lowest is fixed.
    course : [m]
        Height of a course.
    thickness : [m]
        Of the wall.
    buttress_width, buttress_depth : [m]
        Along the wall, and from its face.
    stones
        Between the wings of two buttresses, in running bond.

    Returns
    -------
    Assembly
        Course by course ``c00-w0`` along the wall and ``c00-b0`` the buttresses.

    Examples
    --------
    >>> buttressed_wall(1, courses=2, stones=1).names
    ('c00-w0', 'c00-b0', 'c00-b1', 'c01-w0', 'c01-w1', 'c01-b0', 'c01-b1')
    """
    require(bays >= 0 and courses > 0 and stones > 0, "too few blocks", "bays 0 or more, others 1")
    require(spacing > buttress_width, "the buttresses leave no wall", "increase the spacing")
    step = (spacing - buttress_width) / (stones + 1)
    feet = spacing * np.arange(bays + 1)
    end, back = feet[-1] + buttress_width, thickness + buttress_depth
    inner = (feet[:-1, None] + buttress_width + step * np.arange(1, stones + 1)).ravel()
    whole = list(pairwise([0.0, *inner, end]))
    halves = list(zip(inner - 0.5 * step, inner + 0.5 * step, strict=True))
    blocks: list[Block] = []
    for row in range(courses):
        name, level = f"c{row:02d}", (row * course, (row + 1) * course)
        for i, (left, right) in enumerate(whole if row % 2 else halves):
            size = (right - left, thickness, course)
            blocks.append(box(size, (left, 0.0, level[0]), f"{name}-w{i}"))
        for i, (left, right) in enumerate(zip(feet, feet + buttress_width, strict=True)):
            plan = [(right, thickness), (right, back), (left, back), (left, thickness)]
            if row % 2 == 0:
                wings = max(left - 0.5 * step, 0.0), min(right + 0.5 * step, end)
                plan += [(wings[0], thickness), (wings[0], 0.0)]
                plan += [(wings[1], 0.0), (wings[1], thickness)]
            blocks.append(_upright(list(dict.fromkeys(plan)), level, f"{name}-b{i}"))
    return Assembly(tuple(blocks), np.arange(len(blocks)) < bays * stones + bays + 1)


def _upright(plan: Sequence[tuple[float, float]], level: Sequence[float], name: str) -> Block:
    """A plan (x, y) from level to level."""
    turned = [(x, -y) for x, y in plan]
    return prism(turned, level, name).transformed([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
