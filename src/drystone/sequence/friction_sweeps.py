"""Plans at several friction coefficients."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.model import Model
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.margins import in_turn
from drystone.sequence.plans import Plan
from drystone.sequence.rules import strength
from drystone.sequence.stage_tree import overloads
from drystone.sequence.stages import mask_of
from drystone.sequence.step_checks import checked_step, falling_words, without_help

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

    def tables(self) -> Sequence[Table]:
        """Counts at each coefficient."""
        return [self.table()]

    def numbers(self) -> Mapping[str, Any]:
        """The plan at each coefficient."""
        return {"plans": [plan.numbers() for plan in self.plans]}

    def layers(self) -> Scene:
        """The plan at the largest coefficient."""
        return self.plans[-1].layers()

    def table(self) -> Table:
        """Counts at each coefficient; None where the complete structure does not stand."""
        counts = [plan.counts if plan.steps else {} for plan in self.plans]
        columns = {
            "friction": self.friction,
            "stands": [plan.complete.stands for plan in self.plans],
            **{kind: [one.get(kind) for one in counts] for kind in ("free", "held", "propped")},
            "why_more": self.why_more,
        }
        return Table("plans by friction", columns)


@checked_call
def sweep_friction(
    model: Model,
    frictions: Sequence[float],
    plan_at: PlanAt,
    *,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> FrictionSweep:
    """Plan at several friction coefficients, each the same for all joints.

    Parameters
    ----------
    model
    frictions
    plan_at
    """
    if not frictions:
        raise InputError("no friction coefficient", where="sweep", remedy="give one or more")
    values = tuple(sorted(float(f) for f in frictions))
    clock = Clock(time_limit_s, stop)
    models = [model.with_friction(value) for value in values]
    plans, reasons = [], []
    best: tuple[float, Plan] | None = None
    found = in_turn(plan_at, models, "friction", executor, progress, clock)
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
    limit = strength(plan.rules, other.model)[2]
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
