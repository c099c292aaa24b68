"""The search for parameters.

Source: the tree-structured Parzen estimator, Bergstra et al. 2011, as Optuna has it.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import isnan
from pathlib import Path
from typing import Any, Unpack

from drystone.base.errors import FormatError, refuse_unknown, require
from drystone.base.journal import Journal, exactly
from drystone.base.progress import Clock, LongWork
from drystone.base.settings import Options, checked_call
from drystone.base.version import version
from drystone.base.workers import WorkerPool
from drystone.design.margin import DesignMargin
from drystone.design.tuned_values import (
    Outcome,
    Parameter,
    Tuned,
    TuneTrial,
    outcome_of,
    refuse_goals,
)
from drystone.io.opening import How

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
