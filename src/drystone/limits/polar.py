"""Tilt limits in all directions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, Sentence
from drystone.answer.chart import Chart, MarkKind, Marks, ring
from drystone.base.arrays import Floats
from drystone.base.display import rounded_down
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, checked_call
from drystone.base.table import Table
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, LongHow, supported_model
from drystone.limits.inside import Means
from drystone.limits.limit_answer import AT_LEAST, Limit
from drystone.limits.limit_types import Bracket, Check, LimitOptions, Tilt
from drystone.limits.limits import tilt_limit
from drystone.model import Model


@dataclass(frozen=True, eq=False)
class TiltSweep(Answer):
    """Tilt limits about horizontal axes.

    Attributes
    ----------
    azimuth : (d,) [degrees]
        Direction towards which the assembly leans, counter-clockwise from x seen from above.
    limits : (d,)
        The axis of each is the azimuth turned by 90 degrees.
    missing : [degrees]
        Requested directions without a result.
    """

    azimuth: Floats
    limits: tuple[Limit, ...]
    missing: tuple[float, ...] = ()

    def _summary(self) -> str:
        if self.missing or not self.limits:
            return f"{len(self.limits)} of {counted(self._asked, 'direction')}: {self.stopped}"
        least, towards = self.rest[self.weakest], self.azimuth[self.weakest]
        return (
            f"{counted(len(self.limits), 'direction')}, "
            f"least tilt {rounded_down(least):g} degrees towards {towards:g} degrees"
        )

    @property
    def _asked(self) -> int:
        return len(self.limits) + len(self.missing)

    @property
    def equilibrium(self) -> Floats:
        """(d,) [degrees], the largest tilt with an equilibrium; NaN where there is none."""
        return np.array([_stands(limit.equilibrium) for limit in self.limits])

    @property
    def rest(self) -> Floats:
        """(d,) [degrees], the largest tilt at which the full verdict is STABLE."""
        return np.array([_stands(limit.best) for limit in self.limits])

    @property
    def weakest(self) -> int:
        """The direction in which it falls first.

        Raises
        ------
        InputError
            Not all directions are known.
        """
        if self.missing or not self.limits:
            raise InputError(
                f"{len(self.limits)} of {counted(self._asked, 'direction')} are known, "
                "so the weakest one is not",
                remedy="let the sweep run to its end, or look at 'rest'",
            )
        return self.lowest

    @property
    def lowest(self) -> int:
        """The known direction with the least tilt; the weakest one if all are known."""
        if not self.limits:
            raise InputError("no direction is known", remedy="let the sweep go on")
        return int(np.argmin(np.nan_to_num(self.rest, nan=-1.0).round(6)))

    @property
    def rank(self) -> str:
        """The name of the lowest direction in messages."""
        if not self.missing:
            return f"the weakest of {counted(self._asked, 'direction')}"
        return f"the lowest of {len(self.limits)} known directions ({self._asked} requested)"

    @property
    def model(self) -> Model:
        """The model of the lowest known direction."""
        return self.limits[self.lowest].model

    @cached_property
    def asked(self) -> Question:
        """What was asked of every direction."""
        return self.limits[0].asked if self.limits else Question.of_nothing(made=self.when)

    @property
    def title(self) -> str:
        """The least tilt, and where it leads."""
        if not self.limits:
            return "No direction is known"
        angle, towards = self.rest[self.lowest], self.azimuth[self.lowest]
        told = "nowhere" if np.isnan(angle) else f"up to {rounded_down(angle):g} degrees"
        if self.limits[self.lowest].capped:
            return f"Stands {told}{AT_LEAST}, towards each of {len(self.limits)} directions"
        return f"Stands {told} towards {towards:g} degrees, {self.rank}"

    def sentences(self) -> Sequence[Sentence]:
        """The least tilt, and why directions are missing."""
        stands = bool(self.limits) and not np.isnan(self.rest).any()
        role = Role.BAD if not stands else Role.UNSURE if self.missing else Role.GOOD
        said = [Sentence(self.title, role)]
        told = dict.fromkeys(limit.quantity.remark for limit in self.limits)
        said += [Sentence(one, Role.REMARK) for one in told if one]
        if any(limit.remarks for limit in self.limits):
            said.append(Sentence("where joints decide, see --json", Role.REMARK))
        return said + self._unfinished()

    def tables(self) -> Sequence[Table]:
        """The limits by direction."""
        columns = {"azimuth": self.azimuth, "equilibrium": self.equilibrium, "rest": self.rest}
        units = dict.fromkeys(columns, "deg")
        remarks = ["; ".join(limit.remarks) for limit in self.limits]
        more = {"joints_decide": remarks} if any(remarks) else {}
        bounds = {"equilibrium": False, "rest": False}
        return [Table("tilt by direction", {**columns, **more}, units, bounds)]

    def numbers(self) -> Mapping[str, Any]:
        """The limit in each direction."""
        return {
            "parameter": "tilt",
            "unit": "deg",
            "azimuth": self.azimuth,
            "missing": self.missing,
            "weakest_azimuth": None if self.missing else self.azimuth[self.weakest],
            "limits": [limit.numbers() for limit in self.limits],
        }

    def layers(self) -> Scene:
        """The states on either side of the limit in the lowest known direction."""
        lowest = self.lowest
        scene = self.limits[lowest].layers()
        message = f"{self.rank} leans towards {self.azimuth[lowest]:g} degrees"
        stages = tuple(
            replace(
                one, headline=f"{one.headline}: {self.rank}", message=f"{message}; {one.message}"
            )
            for one in scene.stages
        )
        return replace(scene, stages=stages, charts=(self.figure(), *scene.charts))

    def figure(self) -> Chart:
        """The largest tilt towards every direction, by both definitions."""
        closed = not self.missing
        inks = ((self.equilibrium, MarkKind.DASHED, "unsure", "some forces balance the loads"),
                (self.rest, MarkKind.AREA, "accent", ""),
                (self.rest, MarkKind.LINE, "accent", "stands"))  # fmt: skip
        marks = [
            Marks(kind, *ring(self.azimuth, values, closed), ink, label)
            for values, kind, ink, label in inks
        ]
        told = f"{len(self.limits)} of {self._asked} directions are known"
        if closed and np.isfinite(least := float(self.rest[self.weakest])):
            towards = float(self.azimuth[self.weakest])
            spot = np.array([towards]), np.array([least])
            marks.append(Marks(MarkKind.DIAMOND, *spot, "bad", "the weakest"))
            told = f"weakest towards {towards:g} deg: {least:.2f} deg"
        return Chart(
            "Largest tilt towards each direction", tuple(marks), "direction, seen from above, x to "
            "the right", "largest tilt", ("deg", "deg"), told, polar=True,
        )  # fmt: skip


@checked_call
def tilt_sweep(
    given: Given,
    directions: int = 16,
    *,
    upper: float = 180.0,
    check: Check | None = None,
    options: LimitOptions | None = None,
    **how: Unpack[LongHow],
) -> TiltSweep:
    """The tilt limit towards equally spaced directions.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    directions : >= 1
        Number of azimuths, the first along x: the assembly leans towards each of them.
    upper : [degrees] > 0, <= 360
        Largest angle of each search.
    options
        Of each limit: the default width is 0.05 degree.
    """
    azimuth = 360.0 * np.arange(directions) / directions
    angle = np.deg2rad(azimuth)
    axes = np.stack([-np.sin(angle), np.cos(angle), np.zeros(directions)], axis=1)
    clock = Clock.of(how)
    model = supported_model(given, **how)
    means = Means(check, LimitOptions.of(options), Clock(float("inf"), clock.late))
    task = partial(_one, model, upper, means)
    limits: list[Limit] = []
    with WorkerPool(clock.workers) as pool:
        for limit in pool.answers(task, axes, clock.late):
            if limit.stopped:
                break
            limits.append(limit)
            clock.tell("directions", len(limits), directions)
    known = len(limits)
    missing = tuple(azimuth[known:].tolist())
    stopped = ""
    if missing:
        done = ", ".join(f"{a:g}" for a in azimuth[:known]) or "none"
        stopped = f"{clock.reason} after {known} of {directions} directions (degrees: {done})"
    return TiltSweep(azimuth[:known], tuple(limits), missing, stopped=stopped)


def _one(model: Model, upper: float, means: Means, axis: Floats) -> Limit:
    return tilt_limit(Tilt(model, axis), upper, means)


def _stands(bracket: Bracket) -> float:
    return float("nan") if bracket.stands is None else bracket.stands
