"""Margins of each stage of a plan: least friction, and tilt limit.

Plans at several friction coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias, Unpack

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.base.display import rounded_down, rounded_up
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, LongWork, checked_call
from drystone.base.table import Table
from drystone.limits import LimitOptions, limit_friction, limit_tilt
from drystone.model import Model
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.plan_steps import checked_step, falling_words, without_help
from drystone.sequence.plans import Plan
from drystone.sequence.rules import strength
from drystone.sequence.stage_tree import overloads
from drystone.sequence.stages import Stage, StagedModel, mask_of


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
    widths
        Of the brackets of the least friction and of the tilt limit [degrees]. The stages were seen
        to stand at the side that is told.
    """

    plan: Plan
    stages: tuple[Margin, ...]
    widths: tuple[float, float] = (0.01, 0.5)

    def _summary(self) -> str:
        least = rounded_up(self.least_friction)
        return f"{counted(len(self.stages), 'stage')}, least friction {least:g}"

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
        return f"The weakest stage, step {self.weakest + 1}, tilts {rounded_down(tilt):g} degrees"

    def sentences(self) -> Sequence[Sentence]:
        """The weakest stage, and the friction down to which this order works."""
        role = Role.UNSURE if self.stopped or not self.stages else Role.GOOD
        down = ["a stage of this order stands at no friction"]
        if not math.isinf(self.least_friction):
            down = [
                f"this order works down to friction {rounded_up(self.least_friction):g}",
                "found to {:g} of friction and {:g} degrees of tilt".format(*self.widths),
                *self._needier(),
            ]
        return [Sentence(self.title, role), *map(Sentence, down)]

    def _needier(self) -> list[str]:
        """The stage that needs most friction, where it needs more than the whole."""
        need = [one.least_friction for one in self.stages]
        if not need or not need[-1] + self.widths[0] < self.least_friction:
            return []
        step, whole = need.index(self.least_friction) + 1, rounded_up(need[-1])
        return [
            f"step {step} needs more friction than the complete structure, which needs {whole:g}"
        ]

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
    **work: Unpack[LongWork],
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
    clock = Clock.of(work)
    found = list(clock.answers(task, stages, "margins"))
    unknown = [Margin(math.nan, math.nan)] * (len(stages) - len(found))
    within = friction_width, tilt_width
    stopped = clock.reason if unknown else ""
    return Margins(plan, (*found, *unknown), within, stopped=stopped)


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
    if not some.contacts.count:  # it floats: nothing props it
        return Margin(math.inf, 0.0)
    check = structure.check
    least = limit_friction(some, check=check, options=widths[0]).best
    tilt = upper
    for angle in 2.0 * np.pi * np.arange(directions) / directions:
        axis = (-np.sin(angle), np.cos(angle), 0.0)  # only what tilts less than before counts
        found = limit_tilt(some, axis, upper=tilt, check=check, options=widths[1]).best
        tilt = 0.0 if found.stands is None else float(found.stands)
        if not tilt:
            break
    return Margin(np.inf if least.stands is None else float(least.stands), tilt)


PlanAt: TypeAlias = Callable[[Model], Plan]
"""The planner with all arguments except the model."""


@dataclass(frozen=True, eq=False)
class FrictionSweep(Answer):
    """Plans of one structure at several friction coefficients.

    A search may end at another order at more friction. Where a plan needs
    more help than the best one at less friction, the steps of that one are checked at the present
    friction, and taken if every stage stands.

    Attributes
    ----------
    friction : coefficients, ascending
    plans
    why_more
        Per coefficient, why it needs more help than a smaller one: the first stage of the best plan
        at a smaller one that does not stand. Empty if it needs no more.
    """

    friction: tuple[float, ...]
    plans: tuple[Plan, ...]
    why_more: tuple[str, ...]

    @property
    def model(self) -> Model:
        """The model at the largest coefficient."""
        return self.plans[-1].model.model

    @property
    def title(self) -> str:
        """How many coefficients were planned at."""
        return f"Planned at {counted(len(self.plans), 'friction coefficient')}"

    def sentences(self) -> Sequence[Sentence]:
        """The help that is needed at each coefficient."""
        stand = all(plan.complete.stands for plan in self.plans)
        said = [Sentence(self.title, Role.GOOD if stand else Role.BAD)]
        for value, plan, why in zip(self.friction, self.plans, self.why_more, strict=True):
            kinds = ", ".join(f"{plan.counts[kind]} {kind}" for kind in ("free", "held", "propped"))
            words = kinds if plan.complete.stands else "does not stand when complete"
            said.append(Sentence(f"friction {value:g}: {words}{f' ({why})' if why else ''}"))
        return said

    def numbers(self) -> Mapping[str, Any]:
        """The plan at each coefficient."""
        return {"plans": [plan.numbers() for plan in self.plans]}

    def layers(self) -> Scene:
        """The plan at the largest coefficient."""
        return self.plans[-1].layers()

    def tables(self) -> Sequence[Table]:
        """Counts at each coefficient; None where the complete structure does not stand."""
        counts = [plan.counts if plan.steps else {} for plan in self.plans]
        columns = {
            "friction": self.friction,
            "stands": [plan.complete.stands for plan in self.plans],
            **{kind: [one.get(kind) for one in counts] for kind in ("free", "held", "propped")},
            "why_more": self.why_more,
        }
        return [Table("plans by friction", columns)]


@checked_call
def sweep_friction(
    model: Model,
    frictions: Sequence[float],
    plan_at: PlanAt,
    **work: Unpack[LongWork],
) -> FrictionSweep:
    """Plan at several friction coefficients, each the same for all joints.

    Parameters
    ----------
    model
    frictions
        Coefficients, one or more, in any order.
    plan_at
        A function that gives the plan of a model, such as :func:`drystone.plan` with its options.
    """
    if not len(frictions):
        raise InputError("no friction coefficient", where="sweep", remedy="give one or more")
    values = tuple(sorted(float(f) for f in frictions))
    clock = Clock.of(work)
    models = [model.with_friction(value) for value in values]
    plans, reasons = [], []
    best: tuple[float, Plan] | None = None
    found = clock.answers(plan_at, models, "friction")
    for value, plan in zip(values, found, strict=False):
        if plan.stopped:
            break
        why, kept = "", plan
        if best is not None and plan.steps and best[1].help < plan.help:
            other, failure = at_other_friction(best[1], plan)
            if other is not None:
                kept = other
            else:
                why = f"with the order of friction {best[0]:g}, {failure}"
        if kept.steps and (best is None or kept.help <= best[1].help):
            best = value, kept
        plans.append(kept)
        reasons.append(why)
    return FrictionSweep(values[: len(plans)], tuple(plans), tuple(reasons))


def at_other_friction(plan: Plan, other: Plan) -> tuple[Plan | None, str]:
    """The steps of a plan in the model of another one; if a stage fails, None and the reason.

    Parameters
    ----------
    plan
    other
        Plan of the same blocks and joints at another friction.
    """
    if set(plan.impossible) != set(other.impossible):
        return None, "other blocks cannot be inserted"
    steps = []
    limit = strength(plan.rules, other.model)[1]
    with Evaluator(other.model) as evaluator:
        for number, old in enumerate(plan.steps):
            before = plan.before(number)
            standing = mask_of(plan.steps[number - 1].props if number else ())
            step = checked_step(evaluator, before, old.blocks, old.motion, standing, old.props)
            bad = next((one for one in (*step.during, step.answer) if not one.stands), None)
            if bad is not None:
                words = falling_words(bad, other.model.assembly.names)
                return None, f"stage {number + 1} does not stand: {words}{bad.message}"
            if any(overloads(one, step.blocks, limit, other.model) for one in step.during):
                return None, f"at stage {number + 1} a hand carries more than its payload"
            steps.append(replace(step, why=without_help(evaluator, step, standing)))
        return replace(
            other,
            steps=tuple(steps),
            impossible=plan.impossible,
            message="every stage stands, in the order of less friction",
            proved=False,
            solved=other.solved + evaluator.solved,
            solve_s=other.solve_s + evaluator.solve_s,
        ), ""
