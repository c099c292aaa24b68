"""Walls of rectangular blocks; columns and a corbelled bridge that are built without props.

The latter are sections in a vertical plane, cut by joints and extruded along y. Every block can be
placed on those before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.simple import blocks_between, box, prism, require

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

    Parameters
    ----------
    number
        Which of the two walls.
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
    n free courses when ``(n + 1) * corbel > depth``.

    Parameters
    ----------
    courses
        Number of courses; the lowest is fixed.
    length
        Block lengths per course.
    size : (3,) [m]
        Length, depth and height of a block.
    corbel : [m]
        Shift of each course along +y over the one below, less than the depth.
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


def leaning_column(
    blocks: int = 8,
    lean_deg: float = 8.0,
    width: float = 1.0,
    height: float = 4.0,
    depth: float = 1.0,
) -> Assembly:
    """A column that leans towards +x, cut square to its axis, on a fixed wedge.

    It stands while the centroid of the part above each joint is over that joint. Its blocks do not
    slide while friction exceeds ``tan(lean_deg)``, the slope of the joints.

    Parameters
    ----------
    blocks : >= 1
        Free blocks.
    lean_deg : [degrees] >= 0, < 45
    width, height, depth : [m]
        Across the axis, along the axis of all free blocks, and along y.

    Returns
    -------
    Assembly
        ``base``, fixed, and ``c01`` ... upwards.

    Examples
    --------
    >>> leaning_column(3).names
    ('base', 'c01-block', 'c02-block', 'c03-block')
    """
    lean = np.deg2rad(lean_deg)
    axis, across = np.array([np.sin(lean), np.cos(lean)]), np.array([np.cos(lean), -np.sin(lean)])
    step = height / blocks
    foot = np.array([0.0, width])
    joints = np.array(
        [
            [foot + i * step * axis + s * 0.5 * width * across for s in (-1, 1)]
            for i in range(blocks + 1)
        ]
    )
    return _stacked(joints, depth)


def winding_column(
    blocks: int = 8,
    swing: float = 0.25,
    width: float = 0.8,
    height: float = 4.0,
    depth: float = 0.8,
) -> Assembly:
    """A column whose centre line is one full wave, with joints normal to it.

    Parameters
    ----------
    blocks : >= 2
        Free blocks.
    swing : [m]
        Amplitude of the centre line.
    width, height, depth : [m]
        Across the centre line, of the wave, and along y.

    Returns
    -------
    Assembly
        ``base``, fixed, and ``c01`` ... upwards.
    """
    steepest = 2.0 * np.pi * abs(swing) / height
    require(steepest < 1.0, f"a swing of {swing} m", "less than the height by 2 pi")
    z = np.linspace(0.0, height, blocks + 1)
    phase = 2.0 * np.pi * z / height
    centre = np.column_stack([swing * np.sin(phase), width + z])
    slope = 2.0 * np.pi * swing / height * np.cos(phase)
    across = np.column_stack([np.ones(blocks + 1), -slope]) / np.hypot(1.0, slope)[:, None]
    joints = np.stack([centre - 0.5 * width * across, centre + 0.5 * width * across], axis=1)
    return _stacked(joints, depth)


def corbelled_bridge(
    corbels: int = 3,
    reach: float = 0.45,
    tail: float = 1.2,
    height: float = 0.4,
    gap: float = 1.0,
    batter_deg: float = 12.0,
    depth: float = 0.8,
) -> Assembly:
    """Two corbelled arms and a wedge-shaped key, built without centring.

    Every corbel is longer than the one below on both sides, so that it stands when it is placed.
    The key is placed from above. Its ends lean by ``batter_deg``, so it presses the arms apart;
    friction under the topmost corbels resists.

    Parameters
    ----------
    corbels : >= 1
        In each arm, over a fixed pier.
    reach, tail : [m] > 0
        By how much each corbel projects beyond the one below, and its length behind the face of the
        pier.
    height, depth : [m] > 0
        Of every block.
    gap : [m] > 0
        Length of the key at its bottom.
    batter_deg : [degrees] >= 0, < 45
        Of its ends against the vertical, wider at the top.

    Returns
    -------
    Assembly
        ``pier-left``, ``pier-right``, fixed; ``left-1`` ... upwards, ``right-1`` ..., ``key``.
    """
    half = 0.5 * gap + corbels * reach
    rise = float(np.tan(np.deg2rad(batter_deg))) * height
    require(rise < reach, "the key cuts through the corbels", "less batter, or more reach")
    span = (-0.5 * depth, 0.5 * depth)
    arms: dict[str, list[Block]] = {"left": [], "right": []}
    piers = []
    for name, side in (("left", -1.0), ("right", 1.0)):
        back = half + tail
        pier = np.array([(half, 0.0), (back, 0.0), (back, height), (half, height)])
        piers.append(prism(pier * (side, 1.0), span, f"pier-{name}"))
        for i in range(corbels):
            tip = half - (i + 1) * reach
            low, high = (i + 1) * height, (i + 2) * height
            top = tip + rise if i == corbels - 1 else tip
            arm = np.array([(tip, low), (back, low), (back, high), (top, high)])
            arms[name].append(prism(arm * (side, 1.0), span, f"{name}-{i + 1}"))
    low, high = corbels * height, (corbels + 1) * height
    wide = 0.5 * gap
    key = [(-wide, low), (wide, low), (wide + rise, high), (-wide - rise, high)]
    blocks = (*piers, *arms["left"], *arms["right"], prism(key, span, "key"))
    return Assembly(blocks, np.arange(len(blocks)) < 2)


def _stacked(joints: Floats, depth: float) -> Assembly:
    """Blocks between joints (j, 2, 2), each from left to right, over a base from the ground."""
    left, right = joints[0]
    base = prism([(left[0], 0.0), (right[0], 0.0), right, left], (0.0, depth), "base")
    made = blocks_between(joints, (0.0, depth), "c{:02d}-block", 1)
    return Assembly((base, *made), np.arange(len(made) + 1) == 0)
