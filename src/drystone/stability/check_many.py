"""The verdicts of many models, side by side, into a file that can be continued."""

from __future__ import annotations

import os
import pickle
from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias, Unpack

from drystone.assembly import Assembly
from drystone.base.display import shortened
from drystone.base.errors import DrystoneError, InputError
from drystone.base.files import PathLike
from drystone.base.journal import Journal
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.base.version import version
from drystone.base.workers import WorkerPool
from drystone.formulations.nearest_mechanism import nearest_mechanisms
from drystone.io.opening import Given, How, supported_model
from drystone.model import Model
from drystone.results import Result
from drystone.solvers.threads import one_blas_thread
from drystone.stability.asked import Asked
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.verdict import check, decided

COLUMNS = (
    "number", "name", "verdict", "stiffnesses_standing", "stiffnesses_tried", "falling", "message",
    "time_s",
)  # fmt: skip
Row: TypeAlias = list[Any]
Task: TypeAlias = tuple[int, str, bytes]
"""Number, name, and the model with its options, ready to travel."""

SIDE_BY_SIDE = 32
"""Models that are checked at once. Measured: with 16 or 96 they take as long, with 4 longer."""

LIGHT = 200_000
"""[bytes] of models that are checked at once, as they travel or as files: small ones only gain."""


@checked_call
def check_many(
    models: Iterable[Given],
    *,
    out: PathLike | None = None,
    options: CheckOptions | None = None,
    each_s: float = float("inf"),
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Table:
    """The verdict of each of many models.

    Parameters
    ----------
    models
        Models, assemblies or files, such as ``sorted(Path("piles").glob("*.json"))``. They may come
        from a generator.
    out
        A file that keeps each answer as soon as it is known; small models are answered in groups of
        up to 32, which takes half of the time. Models whose answers it has are not checked again:
        work that was ended goes on when it is called again with the same models and options.
    options
        Of every check.
    each_s : [s]
        Time limit of every check.

    Returns
    -------
    Table
        One row for each model in the order given: verdict, or ``refused`` or ``failed``; the number
        of contact stiffnesses with which it stands and of those tried; names of the blocks that
        fall; message; time [s].

    Raises
    ------
    InputError
        ``models`` is a single model; the file has answers about other models, of other options or
        of another version, is damaged before its end, or cannot be written, as on a full disk; or
        an executor died that cannot be started again.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import shelf, tower
    >>> found = drystone.check_many([tower(3), shelf()], friction=0.6)
    >>> found["verdict"].tolist()
    ['stable', 'unstable']
    """
    one = isinstance(models, str | bytes | os.PathLike | Assembly | Model)
    if one or not isinstance(models, Iterable):
        said = f"the models are {shortened(repr(models), 60)}"
        raise InputError(said, remedy="give a list of models, such as [model]")
    clock = Clock(time_limit_s, stop)
    chosen = CheckOptions.of(options)
    journal = None if out is None else Journal(out, _about(chosen, each_s, how))
    rows: list[Row] = [] if journal is None else list(journal.records)
    total = len(models) if isinstance(models, Sized) else 0
    with WorkerPool(executor) as pool:
        tasks = islice(_tasks(models, rows, (chosen, each_s, how)), len(rows), None)
        most = SIDE_BY_SIDE if each_s == float("inf") else 1
        if executor is not None and total:  # every worker has something to do
            workers = int(getattr(pool.executor, "_max_workers", None) or 1)
            most = max(min(most, (total - len(rows)) // (2 * workers)), 1)
        groups = _groups(tasks, most)
        for found in pool.answers(_answers, groups, clock.late, failed=_failed, parts=_each):
            for row in found:
                rows.append(row)
                if journal is not None:
                    journal.add([row])
                if progress is not None:
                    progress("checking models", len(rows), max(total, len(rows)))
                if clock.late():
                    break
    columns = {name: [row[i] for row in rows] for i, name in enumerate(COLUMNS)}
    return Table("verdicts", columns, {"time_s": "s"})


def _about(options: CheckOptions, each_s: float, how: Mapping[str, Any]) -> dict[str, str]:
    """What the answers depend on beside the models."""
    asked = {"options": repr(options), "each_s": repr(each_s)}
    asked |= {name: repr(how[name]) for name in sorted(how)}
    return {"format": "drystone-verdicts", "version": version(), **asked}


def _tasks(
    models: Iterable[Given], earlier: Sequence[Row], rest: tuple[Any, ...]
) -> Iterator[Task]:
    """Each model ready to travel; those answered earlier are only compared by name."""
    for number, given in enumerate(models):
        name = _line(os.fspath(given)) if isinstance(given, str | os.PathLike) else ""
        if number < len(earlier):
            if earlier[number][1] != name:
                raise InputError(
                    f"model {number} of the file is '{earlier[number][1]}', not '{name}'",
                    remedy="give the same models in the same order, or another file",
                )
            yield number, name, b""
        else:
            yield number, name, pickle.dumps((given, *rest))


def _groups(tasks: Iterable[Task], most: int) -> Iterator[tuple[Task, ...]]:
    """Tasks that are answered at once: ``most`` of them, or fewer where they are heavy."""
    group: list[Task] = []
    weight = 0
    for task in tasks:
        _, name, payload = task
        heavy = len(payload)
        with suppress(OSError):
            heavy += Path(name).stat().st_size if name else 0
        if group and (len(group) >= most or weight + heavy > LIGHT):
            yield tuple(group)
            group, weight = [], 0
        group.append(task)
        weight += heavy
    if group:
        yield tuple(group)


def _each(group: tuple[Task, ...]) -> Iterator[tuple[Task, ...]]:
    """The tasks of a group one by one: which of them ended its worker?"""
    return ((task,) for task in group)


def _answers(group: tuple[Task, ...]) -> list[Row]:
    """The rows of some models; what cannot be made into a model is refused in words."""
    models: list[Model | DrystoneError] = []
    options, each_s = CheckOptions(), float("inf")
    for _, _, payload in group:
        given, options, each_s, how = pickle.loads(payload)
        try:
            models.append(supported_model(given, **how))
        except DrystoneError as error:
            models.append(error)
    ready = [one for one in models if isinstance(one, Model)]
    answers: Iterator[Result | DrystoneError]
    if each_s == float("inf"):
        answers = iter(_side_by_side(ready, options))
    else:
        answers = (_checked(one, options, each_s) for one in ready)
    rows = []
    for (number, name, _), model in zip(group, models, strict=True):
        found = next(answers) if isinstance(model, Model) else model
        rows.append([number, name, *_told(found)])
    return rows


@one_blas_thread()
def _side_by_side(models: Sequence[Model], options: CheckOptions) -> list[Result | DrystoneError]:
    """The result of :func:`drystone.check` of each model, or why it has none.

    Of small models with dry joints the mechanisms are looked for together, before all else.
    """
    clock = Clock(float("inf"))
    problems: list[Problem | DrystoneError] = []
    for model in models:
        try:
            problems.append(Problem.build(model))
        except DrystoneError as error:
            problems.append(error)
    built = [one for one in problems if isinstance(one, Problem)]
    first = [one for one in built if one.statics.free_count and one.equilibrium_first]
    known = nearest_mechanisms([one.system for one in first]) if first else []
    nearest = dict(zip(first, known, strict=True))
    shared_s = clock.elapsed_s / max(len(models), 1)
    found: list[Result | DrystoneError] = []
    for problem in problems:
        if isinstance(problem, Problem):
            own = Clock(float("inf"))
            own.began -= shared_s
            asked = Asked(problem, options, own, None, nearest.get(problem))
            found.append(decided(asked))
        else:
            found.append(problem)
    return found


def _checked(model: Model, options: CheckOptions, each_s: float) -> Result | DrystoneError:
    try:
        return check(model, options=options, time_limit_s=each_s)
    except DrystoneError as error:
        return error


def _told(found: Result | DrystoneError) -> Row:
    """An answer as the columns after number and name."""
    if isinstance(found, DrystoneError):
        return ["refused", 0, 0, "", _line(str(found)), 0.0]
    tried = found.samples.standing, found.samples.tried
    falling = _line(" ".join(found.falling_names))
    return [found.verdict.value, *tried, falling, _line(found.message), sum(found.time_s.values())]


def _failed(group: tuple[Task, ...]) -> list[Row]:
    """The row of a model that ended its worker twice."""
    ((number, name, _),) = group
    return [[number, name, "failed", 0, 0, "", "its worker was ended twice", 0.0]]


def _line(text: str | bytes) -> str:
    """Text on one line."""
    return " ".join(os.fsdecode(text).split())
