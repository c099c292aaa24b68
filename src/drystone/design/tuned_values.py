"""What is varied, what a trial found, and which trials are best."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, Sentence
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.base.arrays import number
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.table import Table
from drystone.model import Model


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
class Tuned(Answer):
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
    def model(self) -> Model:
        """There is none.

        Raises
        ------
        InputError
        """
        raise InputError("a search has no model", remedy="build one of its front")

    @cached_property
    def asked(self) -> Question:
        """The version, and when."""
        return Question.of_nothing(made=self.when)

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

    def layers(self) -> Scene:
        """There is none.

        Raises
        ------
        InputError
        """
        raise InputError("a search has no drawing of blocks", remedy="see its figure")

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
