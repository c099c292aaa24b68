"""Courses: bed lines across a patch, and the bond of their head joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.errors import InputError
from drystone.shells.patch import Patch, arc_lengths, numbers, refuse_unless_positive

if TYPE_CHECKING:
    from scipy.interpolate import RegularGridInterpolator

_MOST_COURSES = 5_000
"""Largest number of courses of a patch. Chosen: far above any vault."""

SAMPLES = 257
_TABLE_V = 129
"""Samples of the arc-length table. Chosen: linear interpolation moves a bed line by less than 1e-5
of the patch, the same for all blocks along it."""


@dataclass(frozen=True, eq=False)
class Courses:
    """The courses of a patch, bottom to top.

    Attributes
    ----------
    patch
    height : (c,) nominal heights, relative to each other
    start, end : (c,) positions along v between which each course exists
    taper : length in v over which the height of a partial course goes to zero at its tip
    """

    patch: Patch
    height: Floats
    start: Floats
    end: Floats
    taper: float

    @property
    def count(self) -> int:
        """Number of courses, partial ones included."""
        return len(self.height)

    def present(self, v: Floats) -> Bools:
        """Whether each course has a height at the positions ``v`` (k,): (k, c)."""
        full = (self.start <= 0.0) & (self.end >= 1.0)
        inside = (v[:, None] > self.start) & (v[:, None] < self.end)
        at_end = ((v[:, None] <= 0.0) & (self.start <= 0.0)) | (
            (v[:, None] >= 1.0) & (self.end >= 1.0)
        )
        return full | inside | at_end

    def line(self, v: Floats) -> Floats:
        """Position (k, c + 1) of each bed line at ``v``, as a share of the length along u."""
        ramp = np.ones((len(v), self.count))
        left, right = self.start > 0.0, self.end < 1.0
        ramp[:, left] = np.clip((v[:, None] - self.start[left]) / self.taper, 0.0, 1.0)
        ramp[:, right] *= np.clip((self.end[right] - v[:, None]) / self.taper, 0.0, 1.0)
        weight = ramp * self.height
        total = np.cumsum(weight, axis=1)
        return np.concatenate([np.zeros((len(v), 1)), total / total[:, -1:]], axis=1)

    def canonical(self, v: Floats) -> np.ndarray[tuple[int, int], np.dtype[np.intp]]:
        """The lowest bed line (k, c + 1) with which each bed line coincides at ``v``."""
        number = np.arange(1, self.count + 1)
        rising = np.where(self.present(v), number, 0)
        merged = np.maximum.accumulate(rising, axis=1)
        return np.concatenate([np.zeros((len(v), 1), dtype=np.intp), merged], axis=1)

    @cached_property
    def _inverse(self) -> RegularGridInterpolator:
        """Function from (share of the length along u, v) to u."""
        from scipy.interpolate import RegularGridInterpolator  # slow to import

        u, v, points = _table(self.patch)
        length = arc_lengths(points)
        share = length / length[-1]
        table = np.stack([np.interp(u, share[:, j], u) for j in range(_TABLE_V)], axis=1)
        return RegularGridInterpolator((u, v), table)

    def parameter(self, share: Floats, v: Floats) -> Floats:
        """Parameter u (k,) at shares (k,) of the length along u at ``v`` (k,)."""
        along = v % 1.0 if self.patch.closed else v
        return self._inverse(np.stack([np.clip(share, 0.0, 1.0), along], axis=1))

    def middle(self, course: int, v: Floats) -> Floats:
        """Points (k, 3) [m] half-way up a course at the positions ``v`` (k,)."""
        lines = self.line(v)
        share = 0.5 * (lines[:, course] + lines[:, course + 1])
        return self.patch.point(self.parameter(share, v), v)


@lru_cache(maxsize=4)
def _table(patch: Patch) -> tuple[Floats, Floats, Floats]:
    """Samples along u and v, and the points (p, q, 3) [m] there; courses are laid several times."""
    u, v = np.linspace(0.0, 1.0, SAMPLES), np.linspace(0.0, 1.0, _TABLE_V)
    return u, v, patch.point(u[:, None], v[None, :])


def lay_courses(
    patch: Patch,
    *,
    count: int | None = None,
    height: float | None = None,
    heights: Sequence[float] | None = None,
    partial: int | None = 0,
) -> Courses:
    """Divide a patch into courses.

    Parameters
    ----------
    patch
    count
        Number of full courses, of equal height at every v.
    height : [m]
        Or: the target height; the shorter side gives the number of full courses.
    heights
        Or: one relative height per full course.
    partial
        Number of courses that start on the longer side and end inside the patch. None: the number
        that makes the heights on both sides most equal.

    Raises
    ------
    InputError
        None or several of count, height and heights; a number below one; a height that is not
        positive.
    """
    where = f"patch '{patch.name}'"
    if sum(value is not None for value in (count, height, heights)) != 1:
        raise InputError("give one of count, height and heights", where=where)
    _, v, points = _table(patch)
    length = arc_lengths(points)[-1]
    if heights is not None:
        relative = np.atleast_1d(numbers(heights, "heights of courses", where)).ravel()
        count = len(relative)
    elif height is not None:
        refuse_unless_positive(where, course_height=height)
        count = max(1, round(min(float(length.min()) / height, _MOST_COURSES + 1.0)))
        relative = np.ones(count)
    else:
        relative = (
            np.ones(min(int(count), _MOST_COURSES + 1))
            if count is not None and count >= 1
            else np.zeros(0)
        )
    if len(relative) < 1 or not (np.isfinite(relative) & (relative > 0.0)).all():
        raise InputError(
            "there must be one or more courses, each with a height above zero", where=where
        )
    full = len(relative)
    if full > _MOST_COURSES:
        raise InputError(
            f"there are more than {_MOST_COURSES:,} courses", where=where, remedy="make them higher"
        )
    nominal = float(length.min()) / full
    wanted = np.maximum(length / nominal, full)
    extra = round(float(wanted.max())) - full if partial is None else int(partial)
    if extra < 0:
        raise InputError(
            f"the number of partial courses is {partial}", where=where, remedy="give 0 or more"
        )
    if extra and patch.closed:
        raise InputError("a closed patch has no longer side", where=where, remedy="partial=0")
    start, end = np.zeros(full + extra), np.ones(full + extra)
    order = np.ones(full + extra)
    across = float(arc_lengths(points[SAMPLES // 2])[-1])
    taper = max(nominal / across, 0.02)
    slots = _spread(full, extra)
    order[np.setdiff1d(np.arange(full + extra), slots)] = relative
    order[slots] = relative.mean()
    for k, slot in enumerate(slots):
        start[slot], end[slot] = _extent(wanted, v, full, k, extra, taper, where)
    return Courses(patch, order, start, end, taper)


def _spread(full: int, extra: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Positions of the partial courses among all courses: spread, none at the bottom or top."""
    if extra and full < 2:
        raise InputError("a partial course needs a full one below and above", remedy="partial=0")
    after = np.round(np.arange(1, extra + 1) * full / (extra + 1)).astype(np.intp)
    return np.clip(after, 1, full - 1) + np.arange(extra)


def _extent(
    wanted: Floats, v: Floats, full: int, k: int, extra: int, taper: float, where: str
) -> tuple[float, float]:
    """Range in v of partial course k: its share of the additional courses is above a half."""
    surplus = wanted - full
    level = (k + 0.5) / extra * float(surplus.max())
    if surplus.max() <= 0.0:
        raise InputError(
            "partial courses were asked for, but no side is longer", where=where, remedy="partial=0"
        )
    inside = surplus >= level
    first, last = int(np.argmax(inside)), len(v) - 1 - int(np.argmax(inside[::-1]))
    start = float(v[first]) if first > 0 else 0.0
    end = float(v[last]) if last < len(v) - 1 else 1.0
    if end - start < 2.0 * taper:
        middle = 0.5 * (start + end)
        start, end = max(0.0, middle - taper), min(1.0, middle + taper)
    return start, end


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
    return cuts / number


def _gap(joints: Floats, below: Floats, closed: bool) -> Floats:
    """Signed distance from each joint to the nearest one below."""
    if len(below) == 0:
        return np.full(len(joints), np.inf)
    other = np.concatenate([below - 1.0, below, below + 1.0]) if closed else below
    signed = joints[:, None] - other[None]
    nearest = np.argmin(np.abs(signed), axis=1)
    return signed[np.arange(len(joints)), nearest]


def _lap(joints: Floats, below: Floats, closed: bool) -> float:
    inner = joints if closed else joints[1:-1]
    return float(np.abs(_gap(inner, below, closed)).mean()) if len(inner) else np.inf


def _narrower(joints: Floats, closed: bool) -> Floats:
    """Width of the narrower block beside each inner joint."""
    width = np.diff(np.concatenate([joints, joints[:1] + 1.0]) if closed else joints)
    after, before = (width, np.roll(width, 1)) if closed else (width[1:], width[:-1])
    return np.minimum(after, before)


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
