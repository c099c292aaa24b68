"""What a search for parameters asks of each structure, and what came of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock
from drystone.design.margin import DesignMargin
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


@dataclass(frozen=True)
class TuneGoals:
    """What is asked of each structure.

    Attributes
    ----------
    goals
    margin
    props
        Largest number of blocks that need a prop; ``None`` where it does not matter.
    """

    goals: tuple[str, ...]
    margin: DesignMargin
    props: int | None

    @property
    def planned(self) -> bool:
        """Whether a plan is needed."""
        asked = {goal.removeprefix("-") for goal in self.goals}
        return self.props is not None or not asked.isdisjoint(PLANNED)


def outcome_of(
    build: Callable[..., Any],
    how: Mapping[str, Any],
    wanted: TuneGoals,
    values: Mapping[str, Any],
    clock: Clock | None = None,
) -> Outcome | None:
    """Build one structure, check it, and plan it where that is asked for.

    ``None`` where the time was up before the answer was known.
    """
    clock = Clock(np.inf) if clock is None else clock
    try:
        model = model_of(build(**values), how)
        result = wanted.margin.holds(model, clock.late, settle=False)
    except InputError as error:
        return (), False, str(error)
    if result.stopped:
        return None
    good = wanted.margin.meets(result)
    why = "" if good else result.message
    counts: Mapping[str, int] = {}
    if wanted.planned:
        if not good:
            return (), False, why
        counts, why = planned_counts(model, clock)
        if clock.reason:
            return None
        if why:
            return (), False, why
        if wanted.props is not None and counts["propped"] > wanted.props:
            good, why = False, f"{counted(counts['propped'], 'block')} would need a prop"
    found = []
    for goal in wanted.goals:
        name = goal.removeprefix("-")
        if name in values:
            found.append(float(values[name]))
        elif name in PLANNED:
            found.append(float(counts[PLANNED[name]]))
        else:
            found.append(MEASURES[name](model))
    return tuple(found), good, why


def model_of(made: Any, how: Mapping[str, Any]) -> Model:
    """The model of what a family gives: itself, or that of an assembly or a shell."""
    if isinstance(made, Shell):
        return made.model(**how)
    return made if isinstance(made, Model) else as_model(made, **how)


def planned_counts(model: Model, clock: Clock | None = None) -> tuple[Mapping[str, int], str]:
    """Blocks by status while a structure is built course by course; else why it cannot be."""
    stop = None if clock is None else clock.late
    made = plan(model, options=PlanOptions(rules=Rules(order=Order.COURSE)), stop=stop)
    if not made.steps or made.counts["impossible"] or made.verdict is not Verdict.STABLE:
        return made.counts, f"it cannot be built: {made.message}"
    return made.counts, ""
