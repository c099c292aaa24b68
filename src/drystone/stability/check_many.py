"""The verdicts of many models, side by side, into a file that can be continued."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Sized
from contextlib import AbstractContextManager, nullcontext
from io import FileIO, StringIO
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias, Unpack

from drystone.assembly import Assembly
from drystone.base.display import shortened
from drystone.base.errors import DrystoneError, InputError
from drystone.base.files import PathLike, plain_target, read_bytes, unwritable
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.base.workers import WorkerPool
from drystone.formulations.nearest_mechanism import nearest_mechanism
from drystone.io.opening import Given, How, supported_model
from drystone.model import Model
from drystone.results import Result
from drystone.solvers.threads import one_blas_thread
from drystone.stability.asked import Asked
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.verdict import decided

COLUMNS: Mapping[str, Callable[[str], Any]] = {
    "number": int,
    "name": str,
    "verdict": str,
    "stiffnesses_standing": int,
    "stiffnesses_tried": int,
    "falling": str,
    "message": str,
    "time_s": float,
}
Row: TypeAlias = list[Any]
Task: TypeAlias = tuple[int, str, tuple[Any, ...]]
"""Number, name, and the model with its options."""


@checked_call
@one_blas_thread()
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
        A file of comma-separated values. Each answer is added as soon as it is known. Where the
        file has answers already, those models are not checked again: work that was ended goes on
        when it is called again with the same models.
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
        ``models`` is a single model; the file has answers about other models, or cannot be written,
        as on a full disk; or an executor died that cannot be started again.

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
    rows = [] if out is None else _earlier(out)
    opened: AbstractContextManager[FileIO | None]
    opened = nullcontext() if out is None else _opened(out)
    total = len(models) if isinstance(models, Sized) else 0
    with opened as file, WorkerPool(executor) as pool:
        if file is not None and not file.tell():
            _add(file, list(COLUMNS))
        tasks = islice(
            _tasks(models, rows, (CheckOptions.of(options), each_s, how)), len(rows), None
        )
        for row in pool.answers(_answered, tasks, clock.late, failed=_failed):
            rows.append(row)
            if file is not None:
                _add(file, row)
            if progress is not None:
                progress("checking models", len(rows), max(total, len(rows)))
    columns = {name: [row[i] for row in rows] for i, name in enumerate(COLUMNS)}
    return Table("verdicts", columns, {"time_s": "s"})


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
            yield number, name, ()
        else:
            yield number, name, (given, *rest)


@one_blas_thread()
def _answered(task: Task) -> Row:
    """The row of a model; what cannot be made into a model is refused in words.

    Of small models with dry joints the mechanism is looked for first: of many models many fall.
    """
    number, name, (given, options, each_s, how) = task
    found: Result | DrystoneError
    try:
        problem = Problem.build(supported_model(given, **how))
        asked = Asked(problem, options, Clock(each_s))
        if problem.statics.free_count and problem.equilibrium_first:
            asked.nearest = nearest_mechanism(problem.statics)
        found = decided(asked)
    except DrystoneError as error:
        found = error
    return [number, name, *_told(found)]


def _told(found: Result | DrystoneError) -> Row:
    """An answer as the columns after number and name."""
    if isinstance(found, DrystoneError):
        return ["refused", 0, 0, "", _line(str(found)), 0.0]
    tried = found.samples.standing, found.samples.tried
    falling = _line(" ".join(found.falling_names))
    return [found.verdict.value, *tried, falling, _line(found.message), sum(found.time_s.values())]


def _failed(task: Task) -> Row:
    """The row of a model that ended its worker twice."""
    return [*task[:2], "failed", 0, 0, "", "its worker was ended twice", 0.0]


def _earlier(out: PathLike) -> list[Row]:
    """The answers that a file has; half a row at its end, of work that was killed, is removed."""
    path = plain_target(out)
    if not path.exists() or not path.stat().st_size:
        return []
    data = read_bytes(path)
    whole = data.rfind(b"\n") + 1
    lines = list(csv.reader(StringIO(data[:whole].decode("utf-8", "replace"), newline="")))
    try:
        if lines[:1] != [list(COLUMNS)]:
            raise ValueError("other columns")
        kinds = COLUMNS.values()
        rows = [[k(x) for k, x in zip(kinds, line, strict=True)] for line in lines[1:]]
    except ValueError as error:
        raise InputError(
            f"has no verdicts that could be continued: {error}",
            where=str(path),
            remedy="choose another name",
        ) from error
    if whole < len(data):
        os.truncate(path, whole)
    return rows


def _opened(out: PathLike) -> FileIO:
    """The file, to add rows to it."""
    path = plain_target(out)
    try:
        return path.open("ab", buffering=0)
    except OSError as error:
        raise unwritable(path, error) from error


def _add(file: FileIO, row: Row) -> None:
    """One row, on the disk before the next model is answered."""
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerow(row)
    data = text.getvalue().encode("utf-8", "replace")
    try:
        while data:  # the last bytes of a disk are written before it is told to be full
            data = data[file.write(data) :]
    except OSError as error:
        raise unwritable(Path(str(file.name)), error) from error


def _line(text: str | bytes) -> str:
    """Text on one line."""
    return " ".join(os.fsdecode(text).split())
