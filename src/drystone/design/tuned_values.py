"""What is varied, what a trial found, and which trials are best.

What a search for parameters asks of each structure, and what came of it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.answer import Role, Sentence
from drystone.answer.answer import WithoutModel
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.base.arrays import number
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock
from drystone.base.table import Table
from drystone.design.margin import DesignMargin
from drystone.io.opening import as_model
from drystone.model import Model
from drystone.results import Verdict
from drystone.sequence import Order, PlanOptions, Rules, plan
from drystone.shells import Shell


@dataclass(frozen=True)
class Parameter(OneLine):
    """A parameter that is varied: a number within bounds, or one of a few values.

    Attributes
    ----------
    name
    low, high
        Bounds, both included.
    whole
        Whole numbers only.
    choices
        The values to choose from, instead of bounds.
    """

    name: str
    low: float = 0.0
    high: float = 0.0
    whole: bool = False
    choices: tuple[Any, ...] = ()

    def __post_init__(self) -> None:
        where = f"parameter '{self.name}'"
        if self.choices:
            if len(self.choices) < 2:
                raise InputError("has one choice only", where=where, remedy="give two or more")
            return
        if not number(self.low, where) < number(self.high, where):
            raise InputError(
                f"its bounds {self.low:g} to {self.high:g} are empty",
                where=where,
                remedy="give the lower one first, and another one above it",
            )
        if self.whole and (self.low != int(self.low) or self.high != int(self.high)):
            raise InputError("its bounds are not whole", where=where, remedy="give whole numbers")


GOAL_UNITS = {"volume": "m3", "height": "m", "reach": "m"}
"""Of the goals that have one."""


@dataclass(frozen=True, eq=False)
class TuneTrial(OneLine):
    """One set of values, and what came of it.

    Attributes
    ----------
    number
        From 0, in the order in which they were asked for.
    values
        By the names of the parameters.
    goals
        What was to be least or most; empty where the structure could not be built.
    stands
        Whether it stands at the margin.
    message
        Why it does not, or could not be built.
    """

    number: int
    values: Mapping[str, Any]
    goals: tuple[float, ...]
    stands: bool
    message: str = ""


@dataclass(frozen=True, eq=False)
class Tuned(WithoutModel):
    """All trials of a search.

    Attributes
    ----------
    goals
        Names of what was to be least or, with a minus before it, most.
    trials
    """

    goals: tuple[str, ...]
    trials: tuple[TuneTrial, ...]

    def _summary(self) -> str:
        standing = sum(trial.stands for trial in self.trials)
        tried = counted(len(self.trials), "trial")
        if standing or not self.trials:
            stand = "that stands" if standing == 1 else "that stand"
            return f"{tried}, {counted(standing, 'structure')} {stand}"
        why = Counter(trial.message for trial in self.trials).most_common(1)[0][0]
        return f"{tried}, none of which stands: {why}; widen the bounds"

    @property
    def front(self) -> tuple[TuneTrial, ...]:
        """The trials that stand and that no other one beats in every goal (Pareto).

        With one goal, the best one. They are in the order of the first goal.
        """
        signs = [-1.0 if goal.startswith("-") else 1.0 for goal in self.goals]
        cost: dict[tuple[float, ...], TuneTrial] = {}
        for trial in self.trials:
            if trial.stands:
                mine = tuple(s * x for s, x in zip(signs, trial.goals, strict=True))
                cost.setdefault(mine, trial)
        return tuple(
            cost[mine] for mine in sorted(cost)
            if not any(other != mine and np.less_equal(other, mine).all() for other in cost)
        )  # fmt: skip

    @property
    def title(self) -> str:
        """How many were tried, and stand."""
        return self._summary()

    def sentences(self) -> Sequence[Sentence]:
        """How many were tried, and stand."""
        return [Sentence(self.title, Role.GOOD if self.front else Role.BAD)]

    def tables(self) -> Sequence[Table]:
        """The front."""
        front = self.front
        names = list(front[0].values) if front else []
        columns: dict[str, Any] = {
            goal.removeprefix("-"): [one.goals[i] for one in front]
            for i, goal in enumerate(self.goals)
        }
        columns |= {name: [one.values[name] for one in front] for name in names}
        known = {name: unit for name, unit in GOAL_UNITS.items() if name in columns}
        return [Table("best", columns, known)]

    def numbers(self) -> Mapping[str, Any]:
        """All trials, and the front."""
        return {
            "message": self.title,
            "goals": self.goals,
            "front": self.front,
            "trials": self.trials,
        }

    def figure(self) -> Chart:
        """All trials: the first two goals against each other, or one goal by the trial."""
        several = len(self.goals) > 1
        names = self.goals[:2] if several else ("trial", self.goals[0])
        drawn = [one for one in self.trials if one.goals]
        best = "front: no other is better in every goal" if several else "best"
        shown = (
            ([one for one in drawn if not one.stands], MarkKind.CROSS, "ink", "not good enough"),
            ([one for one in drawn if one.stands], MarkKind.DISC, "accent", "stands"),
            (self.front, MarkKind.LINE, "bad", best),
            (self.front, MarkKind.DIAMOND, "bad", ""),
        )
        marks = []
        for some, kind, ink, label in [one for one in shown if one[0]]:
            at = [(one.number, *one.goals)[several : several + 2] for one in some]
            x, y = np.array(at, dtype=float).reshape(-1, 2).T
            marks.append(Marks(kind, x, y, ink, label))
        across, up = map(_goal_name, names)
        units = [GOAL_UNITS.get(name.removeprefix("-"), "") for name in names]
        return Chart("Trials", tuple(marks), across, up, (units[0], units[1]), self.title)


def _goal_name(goal: str) -> str:
    return goal.removeprefix("-") + (", most is best" if goal.startswith("-") else "")


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
