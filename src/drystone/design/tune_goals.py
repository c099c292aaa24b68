"""What a search for parameters asks of each structure, and what came of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock
from drystone.design.margin import DesignMargin
from drystone.design.tuned_values import Parameter
from drystone.io.opening import as_model
from drystone.model import Model
from drystone.results import Verdict
from drystone.sequence import Order, PlanOptions, Rules, plan
from drystone.shells import Shell

MEASURES: dict[str, Callable[[Model], float]] = {
    "volume": lambda model: float(model.assembly.volume[model.assembly.free].sum()),
    "blocks": lambda model: float(len(model.assembly.free)),
    "height": lambda model: float(model.assembly.bounds[:, 1, 2].max()),
    "reach": lambda model: float(model.assembly.bounds[:, 1, 0].max()),
}
"""What can be least or most, beside the parameters themselves: of the free blocks [m3], their
number, the highest point [m], and the farthest one along x [m]."""

PLANNED = {"props": "propped", "held": "held"}
"""Goals that need a plan, and what the plan calls them."""

Outcome = tuple[tuple[float, ...], bool, str]
"""Goals, whether it is good enough, and why not."""


def refuse_goals(goals: Sequence[str], parameters: Sequence[Parameter]) -> None:
    """Refuse goals or parameters that are unknown, missing or given twice."""
    names = [one.name for one in parameters]
    if not names:
        raise InputError("no parameter is varied", remedy="give one or more")
    if len(set(names)) < len(names):
        raise InputError("a parameter is given twice", remedy="give each parameter once")
    known = [*MEASURES, *PLANNED, *(one.name for one in parameters if not one.choices)]
    asked = [goal.removeprefix("-") for goal in goals]
    unknown = sorted(set(asked) - set(known))
    if unknown:
        raise InputError(f"'{unknown[0]}' is no goal", remedy=f"use {', '.join(known)}")
    if len(set(asked)) < max(len(asked), 1):
        raise InputError(
            "the goals contradict each other, or there is none", remedy="name each once"
        )


def outcome_of(
    build: Callable[..., Any],
    how: Mapping[str, Any],
    goals: Sequence[str],
    margin: DesignMargin,
    props: int | None,
    values: Mapping[str, Any],
    clock: Clock | None = None,
) -> Outcome | None:
    """Build one structure, check it, and plan it where a goal needs that.

    ``props`` is the largest number of blocks that need a prop; ``None`` where it does not matter.
    The answer is ``None`` where the time was up before it was known.
    """
    clock = Clock(np.inf) if clock is None else clock
    names = [goal.removeprefix("-") for goal in goals]
    try:
        model = model_of(build(**values), how)
        result = margin.holds(model, clock.late, settle=False)
    except InputError as error:
        return (), False, str(error)
    good = margin.meets(result)
    why = "" if good else result.message
    found = dict(values)
    if not result.stopped and (props is not None or not PLANNED.keys().isdisjoint(names)):
        if good:
            counts, why = planned_counts(model, clock)
            found |= {name: counts[kind] for name, kind in PLANNED.items()}
        if why and not clock.reason:
            return (), False, why
        if props is not None and found.get("props", 0) > props:
            good, why = False, f"{counted(found['props'], 'block')} would need a prop"
    if result.stopped or clock.reason:
        return None
    return tuple(_value(name, found, model) for name in names), good, why


def _value(goal: str, found: Mapping[str, Any], model: Model) -> float:
    """A goal that is a parameter or was planned, else what the model measures."""
    return float(found[goal]) if goal in found else MEASURES[goal](model)


def model_of(made: Any, how: Mapping[str, Any]) -> Model:
    """The model of what a family gives: a model, an assembly or a shell."""
    return as_model(made.model() if isinstance(made, Shell) else made, **how)


def planned_counts(model: Model, clock: Clock | None = None) -> tuple[Mapping[str, int], str]:
    """Blocks by status while a structure is built course by course; else why it cannot be."""
    stop = None if clock is None else clock.late
    made = plan(model, options=PlanOptions(rules=Rules(order=Order.COURSE)), stop=stop)
    if not made.steps or made.counts["impossible"] or made.verdict is not Verdict.STABLE:
        return made.counts, f"it cannot be built: {made.message}"
    return made.counts, ""
