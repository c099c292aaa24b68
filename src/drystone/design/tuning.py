"""The search for parameters.

Source: the tree-structured Parzen estimator, Bergstra et al. 2011, as Optuna has it.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from drystone.base.errors import InputError, MissingDependency
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import Options, checked_call
from drystone.base.workers import WorkerPool
from drystone.design.margin import DesignMargin
from drystone.design.tune_goals import Outcome, outcome_of, refuse_goals
from drystone.design.tuned_values import Parameter, Tuned, TuneTrial

SETTINGS = "settings"
FALLS = "falls"


@dataclass(frozen=True)
class TuneOptions(Options):
    """Options of :func:`tune`.

    Attributes
    ----------
    trials
        Structures that are built and checked, those of an earlier run included.
    batch
        Trials that are asked for together. The answer depends on it, and not on an executor.
    seed
    margin
        How far from falling each structure has to stand.
    props
        Largest number of blocks that need a prop while it is built course by course. Left out, no
        structure is planned unless a goal needs its plan.
    """

    trials: int = 100
    batch: int = 8
    seed: int = 0
    margin: DesignMargin = field(default_factory=DesignMargin)
    props: int | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_below(1, "trials", "batch")
        self._refuse_below(0, "seed", "props")


@checked_call
def tune(
    build: Callable[..., Any],
    parameters: Sequence[Parameter],
    *,
    goals: Sequence[str] = ("volume",),
    how: Mapping[str, Any] | None = None,
    store: str | Path | None = None,
    options: TuneOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
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
        A goal is unknown, a parameter is given twice, or the store is of another search.
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
    clock = Clock(time_limit_s, stop, progress)
    given = dict(how or {})
    evaluate = partial(outcome_of, build, given, asked, chosen.margin, chosen.props, clock=clock)
    built = told(partial(build, **given))
    with WorkerPool(executor) as pool:
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
        try:
            import optuna
        except ImportError as error:
            raise MissingDependency(
                "optuna", extra="tune", purpose="the search for parameters"
            ) from error
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self.optuna: Any = optuna
        self.parameters, self.goals, self.evaluate = parameters, goals, evaluate
        self.options, self.pool, self.clock, self.built = options, pool, clock, built
        self.study = self.opened(store)

    def opened(self, store: str | Path | None) -> Any:
        """The study, new or as it was left."""
        optuna = self.optuna
        storage = None
        if store is not None:
            try:
                backend = optuna.storages.journal.JournalFileBackend(str(store))
                storage = optuna.storages.JournalStorage(backend)
            except OSError as error:
                raise InputError(
                    f"cannot be used: {error.strerror}",
                    where=str(store),
                    remedy="name a file in a folder where you may write",
                ) from error
            except ValueError as error:
                raise InputError(
                    "does not have the trials of a search",
                    where=str(store),
                    remedy="name another file",
                ) from error
        study = optuna.create_study(
            storage=storage,
            study_name="drystone",
            sampler=self.sampler(self.options.seed),
            load_if_exists=True,
            directions=["maximize" if goal.startswith("-") else "minimize" for goal in self.goals],
        )
        settings = json.dumps(
            {
                "parameters": [
                    [one.name, *(one.choices or (one.low, one.high, one.whole))]
                    for one in self.parameters
                ],
                "goals": self.goals,
                "build": self.built,
                "margin": str(self.options.margin),
                "props": self.options.props,
                "seed": self.options.seed,
                "batch": self.options.batch,
            },
            default=str,
        )
        before = study.user_attrs.get(SETTINGS, settings)
        if before != settings:
            raise InputError(
                "has the trials of another search: its structures, parameters, goals, seed or "
                "batch differ",
                where=str(store),
                remedy="name another file",
            )
        study.set_user_attr(SETTINGS, settings)
        return study

    def run(self) -> Tuned:
        """Ask and tell, batch by batch, until all trials are known or the time is up."""
        options = self.options
        while not self.clock.late():
            asked, waiting = len(self.study.trials), len(self.waiting)
            whole = options.batch * (1 + (asked - (waiting > 0)) // options.batch)
            for number in range(asked, min(options.trials, whole)):
                self.ask(number)
            if not self.waiting:
                break
            self.answer(self.waiting)
        return Tuned(self.goals, tuple(self.trials()))

    @property
    def waiting(self) -> list[Any]:
        """The trials that were asked for and not told; those of a run that was ended, too."""
        return [one for one in self.study.trials if not one.state.is_finished()]

    def sampler(self, seed: int) -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", self.optuna.exceptions.ExperimentalWarning)
            return self.optuna.samplers.TPESampler(seed=seed, constant_liar=True)

    def ask(self, number: int) -> None:
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

    def answer(self, batch: list[Any]) -> None:
        """Evaluate trials, and tell what came of them in the order of their numbers."""
        values = [one.params for one in batch]
        answers = self.pool.answers(self.evaluate, values, self.clock.late, failed=_failed)
        for frozen, outcome in zip(batch, answers, strict=False):
            if outcome is None:  # ended before its answer was known: the next run evaluates it
                break
            goals, stands, message = outcome
            trial = self.optuna.trial.Trial(self.study, frozen._trial_id)
            if FALLS not in frozen.user_attrs:  # else it was ended before this trial was told
                trial.set_constraint(FALLS, 0.0 if stands else 1.0)
            trial.set_user_attr(FALLS, not stands)
            trial.set_user_attr("message", message)
            if goals:
                self.study.tell(trial, list(goals))
            else:
                self.study.tell(trial, state=self.optuna.trial.TrialState.FAIL)
            most = self.options.trials
            self.clock.tell("trials", min(frozen.number + 1, most), most)

    def trials(self) -> Iterator[TuneTrial]:
        for one in self.study.trials:
            if one.state.is_finished():
                stands = not one.user_attrs.get(FALLS, True)
                goals = tuple(one.values or ())
                yield TuneTrial(
                    one.number, one.params, goals, stands, one.user_attrs.get("message", "")
                )


def told(made: Any) -> str:
    """What builds a structure, in words that are the same in every process."""
    if isinstance(made, partial):
        given = [*made.args, *sorted(made.keywords.items())]
        return f"{told(made.func)}({', '.join(map(told, given))})"
    if isinstance(made, tuple):
        return f"({', '.join(map(told, made))})"
    return str(getattr(made, "__qualname__", made))


def _failed(_: Mapping[str, Any]) -> Outcome:
    """The outcome of a trial that ended its worker twice."""
    return (), False, "its worker ended twice"
