"""Margins of each stage of a plan: least friction, and tilt limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.base.errors import counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.base.workers import WorkerPool
from drystone.limits import LimitOptions, limit_friction, tilt_sweep
from drystone.model import Model
from drystone.sequence.plans import Plan
from drystone.sequence.stages import Stage, StagedModel, mask_of

Given = TypeVar("Given")
Found = TypeVar("Found")


@dataclass(frozen=True)
class Margin:
    """The margins of one stage.

    Attributes
    ----------
    least_friction
        Least coefficient, one for all joints, with which it stands; infinity if it does not stand.
    tilt : [degrees]
        Tilt limit in the weakest direction; the largest angle of the search if it stands there.
    """

    least_friction: float
    tilt: float


@dataclass(frozen=True, eq=False)
class Margins(Answer):
    """The margins of all stages of a plan, in the order of its steps.

    Attributes
    ----------
    plan
    stages
    stopped
        Why margins of the last stages are missing; empty if all are known.
    """

    plan: Plan
    stages: tuple[Margin, ...]
    stopped: str = ""

    def _summary(self) -> str:
        return f"{counted(len(self.stages), 'stage')}, least friction {self.least_friction:.3g}"

    @property
    def least_friction(self) -> float:
        """Least coefficient with which every stage stands."""
        known = (one.least_friction for one in self.stages if not math.isnan(one.least_friction))
        return max(known, default=0.0)

    @property
    def weakest(self) -> int:
        """The step after which the tilt limit is smallest."""
        tilts = [math.inf if math.isnan(one.tilt) else one.tilt for one in self.stages]
        return int(np.argmin(tilts))

    @property
    def model(self) -> Model:
        """The complete model."""
        return self.plan.model.model

    @property
    def title(self) -> str:
        """The weakest stage."""
        if self.stopped or not self.stages:
            return f"Margins of some stages are not known: {self.stopped}"
        tilt = self.stages[self.weakest].tilt
        return f"The weakest stage, step {self.weakest + 1}, tilts {tilt:.1f} degrees"

    def sentences(self) -> Sequence[Sentence]:
        """The weakest stage, and the friction down to which this order works."""
        role = Role.UNSURE if self.stopped or not self.stages else Role.GOOD
        down = f"this order works down to friction {self.least_friction:.3g}"
        if math.isinf(self.least_friction):
            down = "a stage of this order stands at no friction"
        return [Sentence(self.title, role), Sentence(down)]

    def tables(self) -> Sequence[Table]:
        """The margins of every stage."""
        known = range(len(self.stages))
        columns = {
            "step": [i + 1 for i in known],
            "least_friction": [one.least_friction for one in self.stages],
            "tilt_deg": [one.tilt for one in self.stages],
        }
        bounds = {"least_friction": True, "tilt_deg": False}
        return [Table("stages", columns, {"tilt_deg": "deg"}, bounds)]

    def numbers(self) -> Mapping[str, Any]:
        """The weakest stage, the least friction."""
        weakest = list(self.tables()[0])[self.weakest] if self.stages else None
        return {
            "weakest": weakest,
            "least_friction": self.least_friction,
            "stopped": self.stopped,
        }

    def layers(self) -> Scene:
        """The plan."""
        return self.plan.layers()

    def table(self) -> Table:
        """The plan's table with the margins of each stage."""
        plan = self.plan.table()
        stage = plan["step"] - 1
        columns = {
            "least_friction": np.array([one.least_friction for one in self.stages])[stage],
            "tilt": np.array([one.tilt for one in self.stages])[stage],
        }
        return Table(plan.title, {**plan.columns, **columns}, {**plan.units, "tilt": "deg"},
                     {"tilt": False, "least_friction": True})  # fmt: skip


@checked_call
def margins(
    plan: Plan,
    *,
    friction_width: float = 0.01,
    tilt_width: float = 0.5,
    tilt_upper: float = 45.0,
    directions: int = 4,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> Margins:
    """Least friction and tilt limit of every stage of a plan, with its props in place.

    Equilibrium gives the bound; inside it the verdict of the plan decides.

    Parameters
    ----------
    plan
    friction_width
        Width of the bracket of the least friction.
    tilt_width, tilt_upper : [degrees]
        Width of the bracket of the tilt limit, and the largest angle of its search.
    directions
        Number of horizontal directions of tilt.
    """
    widths = LimitOptions(width=friction_width, scan=1), LimitOptions(width=tilt_width, scan=2)
    task = partial(_margin_of, plan.model, widths=widths, upper=tilt_upper, directions=directions)
    stages = [Stage(step.placed, mask_of(step.props)) for step in plan.steps]
    clock = Clock(time_limit_s, stop)
    found = list(in_turn(task, stages, "margins", executor, progress, clock))
    unknown = [Margin(math.nan, math.nan)] * (len(stages) - len(found))
    return Margins(plan, (*found, *unknown), clock.reason if unknown else "")


def in_turn(
    task: Callable[[Given], Found],
    values: Sequence[Given],
    name: str,
    executor: Workers | None,
    progress: Progress | None,
    clock: Clock,
) -> Iterator[Found]:
    """Results of a task for several values, in order, until the time limit."""
    with WorkerPool(executor) as pool:
        for number, found in enumerate(pool.answers(task, values, clock.late), start=1):
            yield found
            if progress is not None:
                progress(name, number, len(values))


def _margin_of(
    structure: StagedModel,
    stage: Stage,
    *,
    widths: tuple[LimitOptions, LimitOptions],
    upper: float,
    directions: int,
) -> Margin:
    """Margins of one stage."""
    some, _ = structure.cut_out(Stage(*stage))
    if some.assembly.fixed.all():
        return Margin(0.0, upper)
    some = some.with_contacts(some.contacts.select(some.active))
    if not some.contacts.count:  # it floats: what it would rest on cannot be placed
        return Margin(math.inf, 0.0)
    check = structure.check
    least = limit_friction(some, check=check, options=widths[0]).best
    sweep = tilt_sweep(some, directions, upper=upper, check=check, options=widths[1])
    tilt = min(0.0 if one.best.stands is None else one.best.stands for one in sweep.limits)
    return Margin(np.inf if least.stands is None else float(least.stands), float(tilt))
