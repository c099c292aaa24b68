"""Courses: bed lines across a patch, with partial courses where one side is longer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from drystone.base.arrays import Bools, Floats
from drystone.base.errors import InputError
from drystone.shells.lengths import arc_lengths, numbers, refuse_unless_positive
from drystone.shells.patch import Patch

_MOST_COURSES = 5_000
"""Largest number of courses of a patch. Chosen: far above any vault."""

_TABLE_U = 257
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
        exists: Bools = full | inside | at_end
        return exists

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
        u, v = np.linspace(0.0, 1.0, _TABLE_U), np.linspace(0.0, 1.0, _TABLE_V)
        points = self.patch.point(u[:, None], v[None, :])
        length = arc_lengths(points)
        share = length / length[-1]
        table = np.stack([np.interp(u, share[:, j], u) for j in range(_TABLE_V)], axis=1)
        return RegularGridInterpolator((u, v), table)

    def parameter(self, share: Floats, v: Floats) -> Floats:
        """Parameter u (k,) at shares (k,) of the length along u at ``v`` (k,)."""
        along = v % 1.0 if self.patch.closed else v
        u: Floats = self._inverse(np.stack([np.clip(share, 0.0, 1.0), along], axis=1))
        return u

    def middle(self, course: int, v: Floats) -> Floats:
        """Points (k, 3) [m] half-way up a course at the positions ``v`` (k,)."""
        lines = self.line(v)
        share = 0.5 * (lines[:, course] + lines[:, course + 1])
        return self.patch.point(self.parameter(share, v), v)


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
    v = np.linspace(0.0, 1.0, _TABLE_V)
    points = patch.point(np.linspace(0.0, 1.0, _TABLE_U)[:, None], v[None, :])
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
    across = float(arc_lengths(points[_TABLE_U // 2])[-1])
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
