"""Bond: positions of the head joints of each course, staggered against the course below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.shells.courses import Courses
from drystone.shells.lengths import arc_lengths, refuse_unless_positive

SAMPLES = 257
"""Samples along a course for its length."""

LEAST_LAP = 0.2
"""Smallest distance between head joints of neighbouring courses, relative to the width of a block.
Chosen: the usual least lap of masonry is a quarter of the block's length; here a little less, for
courses with different numbers of blocks."""

MOST_BLOCKS = 10_000
"""Largest number of blocks in a course. Chosen: far above any vault; the calculation takes
minutes."""


def lay_bond(
    courses: Courses,
    *,
    blocks: int | Sequence[int] | None = None,
    width: float | None = None,
    staggered: bool = True,
) -> tuple[Courses, tuple[Floats, ...]]:
    """Place the head joints of every course.

    Parameters
    ----------
    courses
    blocks
        Blocks in each course, one number for all or one per course. In a staggered open course two
        half blocks replace one block.
    width : [m]
        Or: the target width of a block.
    staggered
        Whether every other course starts with a half block.

    Returns
    -------
    courses
        Tips of partial courses are moved away from head joints.
    joints
        Per course the positions along v of its head joints, ascending. For an open course the first
        and last value are its ends. A closed course with n blocks has n + 1 values; the last is the
        first plus 1.

    Raises
    ------
    InputError
        Neither or both of blocks and width, too few blocks, or a list of another length.
    """
    where = f"patch '{courses.patch.name}'"
    if (blocks is None) == (width is None):
        raise InputError("give one of blocks and width", where=where)
    if width is not None:
        refuse_unless_positive(where, block_width=width)
    closed = courses.patch.closed
    least = 3 if closed else 1
    given = None if blocks is None else _numbers(blocks, courses.count, where)
    below: Floats = np.zeros(0)
    joints: list[Floats] = []
    for course in range(courses.count):
        if staggered:
            courses = _tips_apart(courses, course, below)
        v, share, length = _along(courses, course)
        number = max(least, round(length / width)) if given is None and width else 0
        number = int(given[course]) if given is not None else number
        _refuse_count(number, least, f"{where}, course {course}")
        tips = (bool(courses.start[course] > 0.0), bool(courses.end[course] < 1.0))
        candidates = [_even(number, half, closed, tips) for half in (False, True)]
        if not staggered:
            candidates = candidates[:1]
        elif course % 2:
            candidates.reverse()
        placed = [np.interp(c, share, v) for c in candidates]
        chosen = max(placed, key=lambda x: round(_lap(x, below, closed), 3))
        chosen = _moved(chosen, below, closed, staggered)
        joints.append(np.concatenate([chosen, chosen[:1] + 1.0]) if closed else chosen)
        outside = (below < courses.start[course]) | (below > courses.end[course])
        below = np.sort(np.concatenate([chosen, below[outside]]))
    return courses, tuple(joints)


def _refuse_count(number: int, least: int, where: str) -> None:
    """Refuse too few or too many blocks in a course."""
    if not least <= number <= MOST_BLOCKS:
        few = number < least
        raise InputError(
            f"{number:,} block{' ' if number == 1 else 's '}in a course "
            f"{'is' if number == 1 else 'are'} too {'few' if few else 'many'}",
            where=where,
            remedy=f"give {least} or more" if few else f"give {MOST_BLOCKS:,} or fewer",
        )


def _tips_apart(courses: Courses, course: int, below: Floats) -> Courses:
    """Move the tips of a partial course away from the head joints of the courses below."""
    least = 2.0 * LEAST_LAP * courses.taper
    for name in ("start", "end"):
        ends = getattr(courses, name)
        if len(below) and 0.0 < ends[course] < 1.0:
            near = below[np.argmin(np.abs(below - ends[course]))]
            if abs(ends[course] - near) < least and 0.0 < near < 1.0:
                moved = ends.copy()
                moved[course] = np.clip(near + (least if name == "start" else -least), 0.01, 0.99)
                courses = replace(courses, **{name: moved})
    return courses


def _numbers(blocks: int | Sequence[int], count: int, where: str) -> list[int]:
    numbers = np.atleast_1d(np.asarray(blocks, dtype=np.intp)).tolist()
    if np.ndim(blocks) == 0:
        return numbers * count
    if len(numbers) != count:
        raise InputError(f"{len(numbers)} numbers of blocks for {count} courses", where=where)
    return numbers


def _along(courses: Courses, course: int) -> tuple[Floats, Floats, float]:
    """v, share of the course's length, and the length [m]; closed courses extend by half a turn."""
    end = 1.5 if courses.patch.closed else float(courses.end[course])
    v = np.linspace(float(courses.start[course]), end, SAMPLES)
    length = arc_lengths(courses.middle(course, v))
    total = float(np.interp(1.0, v, length)) if courses.patch.closed else float(length[-1])
    return v, length / total, total


def _even(number: int, half: bool, closed: bool, tips: tuple[bool, bool]) -> Floats:
    """Shares of the course's length; half blocks at its ends, but not at a tip."""
    if closed:
        return (np.arange(number) + 0.5 * half) / number
    left, right = (half and not tip for tip in tips)
    inner = np.arange(1.0, number)
    inner = np.concatenate([[0.5], inner - 0.5, [number - 0.5]]) if left or right else inner
    inner = inner[1:] if left < right else inner
    cuts = np.unique(np.concatenate([[0.0], inner, [float(number)]]))
    if left != right:  # only one half block: the block at the other end is longer
        cuts = np.delete(cuts, -2 if left else 1) if number > 1 else cuts
    shares: Floats = cuts / number
    return shares


def _gap(joints: Floats, below: Floats, closed: bool) -> Floats:
    """Signed distance from each joint to the nearest one below."""
    if len(below) == 0:
        return np.full(len(joints), np.inf)
    other = np.concatenate([below - 1.0, below, below + 1.0]) if closed else below
    signed = joints[:, None] - other[None]
    nearest = np.argmin(np.abs(signed), axis=1)
    gap: Floats = signed[np.arange(len(joints)), nearest]
    return gap


def _lap(joints: Floats, below: Floats, closed: bool) -> float:
    inner = joints if closed else joints[1:-1]
    return float(np.abs(_gap(inner, below, closed)).mean()) if len(inner) else np.inf


def _narrower(joints: Floats, closed: bool) -> Floats:
    """Width of the narrower block beside each inner joint."""
    width = np.diff(np.concatenate([joints, joints[:1] + 1.0]) if closed else joints)
    after, before = (width, np.roll(width, 1)) if closed else (width[1:], width[:-1])
    narrower: Floats = np.minimum(after, before)
    return narrower


def _moved(joints: Floats, below: Floats, closed: bool, staggered: bool) -> Floats:
    """Joints moved away from those below, to at least the least lap.

    Where they are not staggered, onto those that they nearly meet: a small offset leaves a sliver.
    """
    inner = joints if closed else joints[1:-1]
    if len(inner) == 0 or len(below) == 0:
        return joints
    gap = _gap(inner, below, closed)
    least = LEAST_LAP * _narrower(joints, closed)
    wanted = np.where(gap < 0.0, -least, least) if staggered else 0.0
    moved = inner + np.where(np.abs(gap) < least, wanted - gap, 0.0)
    return moved if closed else np.concatenate([joints[:1], moved, joints[-1:]])
