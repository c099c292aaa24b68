"""Courses: bed lines across a patch, and the bond of their head joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.shells.patch import Patch, arc_lengths, refuse_unless_positive

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
    count
    """

    patch: Patch
    count: int

    @cached_property
    def share(self) -> Floats:
        """Position (c + 1,) of each bed line, as a share of the length along u."""
        return np.arange(self.count + 1.0) / self.count

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
        share = 0.5 * (self.share[course] + self.share[course + 1])
        return self.patch.point(self.parameter(np.full(len(v), share), v), v)


@lru_cache(maxsize=4)
def _table(patch: Patch) -> tuple[Floats, Floats, Floats]:
    """Samples along u and v, and the points (p, q, 3) [m] there; courses are laid several times."""
    u, v = np.linspace(0.0, 1.0, SAMPLES), np.linspace(0.0, 1.0, _TABLE_V)
    return u, v, patch.point(u[:, None], v[None, :])


def lay_courses(patch: Patch, *, count: int | None = None, height: float | None = None) -> Courses:
    """Divide a patch into courses.

    Parameters
    ----------
    patch
    count
        Number of courses, of equal height at every v.
    height : [m]
        Or: the target height; the shorter side gives the number of courses.

    Raises
    ------
    InputError
        None or both of count and height; a number below one; a height that is not positive.
    """
    where = f"patch '{patch.name}'"
    if (count is None) == (height is None):
        raise InputError("give one of count and height", where=where)
    if height is not None:
        refuse_unless_positive(where, course_height=height)
        shorter = float(arc_lengths(_table(patch)[2])[-1].min())
        count = max(1, round(min(shorter / height, _MOST_COURSES + 1.0)))
    if count is None or count < 1:
        raise InputError("there must be one or more courses", where=where)
    if count > _MOST_COURSES:
        raise InputError(
            f"there are more than {_MOST_COURSES:,} courses", where=where, remedy="make them higher"
        )
    return Courses(patch, int(count))


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
) -> tuple[Floats, ...]:
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
    tuple of (j,)
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
        v, share, length = _along(courses, course)
        number = max(least, round(length / width)) if given is None and width else 0
        number = int(given[course]) if given is not None else number
        _refuse_count(number, least, f"{where}, course {course}")
        candidates = [_even(number, half, closed) for half in (False, True)]
        if not staggered:
            candidates = candidates[:1]
        elif course % 2:
            candidates.reverse()
        placed = [np.interp(c, share, v) for c in candidates]
        chosen = max(placed, key=lambda x: round(_lap(x, below, closed), 3))
        chosen = _moved(chosen, below, closed, staggered)
        joints.append(np.concatenate([chosen, chosen[:1] + 1.0]) if closed else chosen)
        outside = (below < 0.0) | (below > 1.0)
        below = np.sort(np.concatenate([chosen, below[outside]]))
    return tuple(joints)


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


def _numbers(blocks: int | Sequence[int], count: int, where: str) -> list[int]:
    numbers = np.atleast_1d(np.asarray(blocks, dtype=np.intp)).tolist()
    if np.ndim(blocks) == 0:
        return numbers * count
    if len(numbers) != count:
        raise InputError(f"{len(numbers)} numbers of blocks for {count} courses", where=where)
    return numbers


def _along(courses: Courses, course: int) -> tuple[Floats, Floats, float]:
    """v, share of the course's length, and the length [m]; closed courses extend by half a turn."""
    v = np.linspace(0.0, 1.5 if courses.patch.closed else 1.0, SAMPLES)
    length = arc_lengths(courses.middle(course, v))
    total = float(np.interp(1.0, v, length)) if courses.patch.closed else float(length[-1])
    return v, length / total, total


def _even(number: int, half: bool, closed: bool) -> Floats:
    """Shares of the course's length; half blocks at its ends."""
    if closed:
        return (np.arange(number) + 0.5 * half) / number
    inner = np.arange(1.0, number)
    inner = np.concatenate([[0.5], inner - 0.5, [number - 0.5]]) if half else inner
    return np.unique(np.concatenate([[0.0], inner, [float(number)]])) / number


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
