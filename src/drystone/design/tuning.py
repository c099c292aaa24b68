"""The search for parameters: what is varied, what a trial found, and which are best.

Source: the tree-structured Parzen estimator, Bergstra et al. 2011, as Optuna has it.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import isnan
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from drystone.answer import Role, Sentence
from drystone.answer.answer import WithoutModel
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.base.arrays import number
from drystone.base.display import OneLine
from drystone.base.errors import FormatError, InputError, counted, refuse_unknown, require
from drystone.base.journal import Journal, exactly
from drystone.base.settings import Clock, LongWork, Options, checked_call
from drystone.base.table import Table
from drystone.base.version import version
from drystone.base.workers import WorkerPool
from drystone.design.margin import DesignMargin
from drystone.io.opening import How, as_model
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


FALLS = "falls"


@dataclass(frozen=True)
class TuneOptions(Options):
    """Options of :func:`tune`.

    Attributes
    ----------
    trials : >= 1
        Structures that are built and checked, those of an earlier run included.
    batch : >= 1
        Trials that are asked for together. The answer depends on it, and not on an executor.
    seed : >= 0
        The same seed gives the same search.
    margin
        Margin with which it has to stand: ``tilt=2deg`` to each side, ``load=1.2`` times the load,
        ``friction=0.9x``, or ``sensitive``, where STABLE after settling is enough.
    props : >= 0
        Largest number of blocks that need a prop while it is built course by course. Left out, no
        structure is planned unless a goal needs its plan.
    """

    trials: int = 100
    batch: int = 8
    seed: int = 0
    margin: DesignMargin = field(default_factory=DesignMargin)
    props: int | None = None


@checked_call
def tune(
    build: Callable[..., Any],
    parameters: Sequence[Parameter],
    *,
    goals: Sequence[str] = ("volume",),
    how: Mapping[str, Any] | None = None,
    store: str | Path | None = None,
    options: TuneOptions | None = None,
    **work: Unpack[LongWork],
) -> Tuned:
    """Search for the parameters with which a structure stands and is best.

    Parameters
    ----------
    build
        Makes a model, an assembly or a shell of the parameters, by their names. With worker
        processes it must be a function that another process can import.
    parameters
    goals
        What is to be least: ``volume`` [m3], ``blocks``, ``height`` or ``reach`` along x [m] of the
        free blocks; ``props`` or ``held``, the blocks that need a prop or a hand while it is built;
        or a parameter. With a minus before it, what is to be most. Several give a Pareto front.
    how
        Of an assembly: friction, supports and so on, as :func:`drystone.check` takes them.
    store
        File that keeps the trials: a search that was ended goes on where it was.
    options

    Raises
    ------
    InputError
        A goal or an option is unknown, a parameter is given twice, or the store is of another
        search.
    MissingDependency
        Optuna is not installed.

    Examples
    --------
    >>> from drystone.models import tower
    >>> edge, count = Parameter("edge", 0.5, 2.0), Parameter("count", choices=(2, 3))
    >>> found = tune(tower, [edge, count], options=TuneOptions(trials=8))
    >>> len(found.trials), found.front[0].values["edge"] < 1.5
    (8, True)
    """
    chosen = TuneOptions.of(options)
    asked = tuple(goals)
    refuse_goals(asked, parameters)
    refuse_unknown(how or {}, [*How.__annotations__])
    clock = Clock.of(work)
    given = dict(how or {})
    evaluate = partial(outcome_of, build, given, asked, chosen.margin, chosen.props, clock=clock)
    built = exactly(partial(build, **given))
    with WorkerPool(clock.workers) as pool:
        return _ValueSearch(parameters, asked, evaluate, built, store, chosen, pool, clock).run()


class _ValueSearch:
    """One search: trials are asked for in batches, evaluated anywhere, and told in order."""

    def __init__(
        self,
        parameters: Sequence[Parameter],
        goals: tuple[str, ...],
        evaluate: Callable[[Mapping[str, Any]], Outcome | None],
        built: str,
        store: str | Path | None,
        options: TuneOptions,
        pool: WorkerPool,
        clock: Clock,
    ) -> None:
        require("optuna", "tune", "the search for parameters")
        import optuna

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self.optuna: Any = optuna
        self.parameters, self.goals, self.evaluate = parameters, goals, evaluate
        self.options, self.pool, self.clock, self.built = options, pool, clock, built
        self.journal = None if store is None else Journal(store, self.asked(), self.known)
        self.kept = [] if self.journal is None else list(self.journal.records)
        self.told: list[TuneTrial] = []
        self.study = optuna.create_study(
            sampler=self.sampler(options.seed),
            directions=["maximize" if goal.startswith("-") else "minimize" for goal in goals],
        )

    def asked(self) -> dict[str, Any]:
        """What is searched for: trials of another search are of no use."""
        options = self.options
        return {
            "format": "drystone-trials",
            "version": version(),
            "version of Optuna": self.optuna.__version__,
            "parameters": [[one.name, *map(str, self.range_of(one))] for one in self.parameters],
            "goals": self.goals,
            "structures": self.built,
            "margin": exactly(options.margin),
            "number of props": options.props,
            "seed": options.seed,
            "batch": options.batch,
        }

    def known(self, record: Any) -> tuple[dict[str, Any], Outcome]:
        """The values of a trial, and what came of it."""
        params, values, stands, message = record
        goals = tuple(map(float, values))
        if len(goals) not in (0, len(self.goals)) or any(map(isnan, goals)):
            raise ValueError("it has other goals")
        return dict(params), (goals, bool(stands), str(message))

    @staticmethod
    def range_of(one: Parameter) -> list[Any]:
        return [*one.choices] if one.choices else [one.low, one.high, one.whole]

    def run(self) -> Tuned:
        """Ask for trials batch by batch; those of a run that was ended are asked for again."""
        most, batch = self.options.trials, self.options.batch
        for first in range(0, most, batch):
            asked = (
                []
                if self.clock.late()
                else list(map(self.ask, range(first, min(first + batch, most))))
            )
            self.answer(asked)
            if len(self.told) < first + len(asked) or not asked:
                break
        return Tuned(self.goals, tuple(self.told))

    def sampler(self, seed: int) -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", self.optuna.exceptions.ExperimentalWarning)
            return self.optuna.samplers.TPESampler(seed=seed, constant_liar=True)

    def ask(self, number: int) -> Any:
        """Ask for the values of a trial; they depend on its number and on what is known."""
        self.study.sampler = self.sampler(1_000_003 * self.options.seed + number)
        trial = self.study.ask()
        for one in self.parameters:
            if one.choices:
                trial.suggest_categorical(one.name, list(one.choices))
            elif one.whole:
                trial.suggest_int(one.name, int(one.low), int(one.high))
            else:
                trial.suggest_float(one.name, one.low, one.high)
        return trial

    def answer(self, batch: list[Any]) -> None:
        """Evaluate trials, and tell what came of them in the order of their numbers."""
        values = [one.params for one in batch if one.number >= len(self.kept)]
        answers = self.pool.answers(self.evaluate, values, self.clock.late, failed=_failed)
        for trial in batch:
            known = trial.number < len(self.kept)
            outcome = self.outcome(trial) if known else next(answers, None)
            if outcome is None:  # ended before its answer was known: the next run evaluates it
                break
            goals, stands, message = outcome
            if self.journal is not None and not known:
                self.journal.add([[trial.params, goals, stands, message]])
            trial.set_constraint(FALLS, 0.0 if stands else 1.0)
            if goals:
                self.study.tell(trial, list(goals))
            else:
                self.study.tell(trial, state=self.optuna.trial.TrialState.FAIL)
            self.told.append(TuneTrial(trial.number, trial.params, goals, stands, message))
            self.clock.tell("trials", trial.number + 1, self.options.trials)

    def outcome(self, trial: Any) -> Outcome:
        """What came of a trial in the run that was ended."""
        params, outcome = self.kept[trial.number]
        if params != trial.params:
            raise FormatError(
                f"trial {trial.number} had other values than it gets now",
                where=str(self.journal.path if self.journal else ""),
                remedy="go on where it was begun, or name another file",
            )
        return outcome


def _failed(_: Mapping[str, Any]) -> Outcome:
    """The outcome of a trial that ended its worker twice."""
    return (), False, "its worker ended twice"
