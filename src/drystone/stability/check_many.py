"""The verdicts of many models, side by side, into a file that can be continued."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from typing import Any, TypeAlias, Unpack

from drystone.assembly import Assembly
from drystone.base.errors import DrystoneError, InputError, quoted
from drystone.base.files import PathLike
from drystone.base.journal import Journal, add_answers, exactly
from drystone.base.settings import Clock, checked_call
from drystone.base.table import Table
from drystone.base.version import version
from drystone.formulations.nearest_mechanism import nearest_mechanism
from drystone.io.opening import Given, LongHow, content_of, supported_model
from drystone.results import Result
from drystone.solvers.threads import one_blas_thread
from drystone.stability.asked import Asked, CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.verdict import decided

COLUMNS = (
    "number", "name", "verdict", "stiffnesses_standing", "stiffnesses_tried", "falling", "message",
    "time_s",
)  # fmt: skip
Row: TypeAlias = list[Any]
Task: TypeAlias = tuple[int, str, str, tuple[Any, ...]]
"""Number, name, a hash of the content for the file, and the model with its options."""


@checked_call
@one_blas_thread()
def check_many(
    models: Iterable[Given],
    *,
    out: PathLike | None = None,
    options: CheckOptions | None = None,
    each_s: float = float("inf"),
    **how: Unpack[LongHow],
) -> Table:
    """The verdict of each of many models.

    Parameters
    ----------
    models
        Models, assemblies or files, such as ``sorted(Path("piles").glob("*.json"))``. They may come
        from a generator.
    out
        A file that keeps each answer as soon as it is known. Models whose answers it has are not
        checked again: work that was ended goes on when it is called again with the same models and
        options.
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
        ``models`` is a single model; there is no such option; the file has answers about other
        models, of other options or of another version, is damaged before its end, or cannot be
        written, as on a full disk; or an executor died that cannot be started again.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import shelf, tower
    >>> found = drystone.check_many([tower(3), shelf()], friction=0.6)
    >>> found["verdict"].tolist()
    ['stable', 'unstable']
    """
    if isinstance(models, Assembly):
        said = f"the models are {quoted(models)}"
        raise InputError(said, remedy="give a list of models, such as [model]")
    clock = Clock.of(how)
    chosen = CheckOptions.of(options)
    journal = None if out is None else Journal(out, _about(chosen, each_s, how), _row)
    kept: list[Row] = [] if journal is None else journal.records
    tasks = _tasks(models, kept, (chosen, each_s, how), out)
    rows = [row for row, _ in zip(kept, tasks, strict=False)]  # of the models that are asked about
    total = len(models) if isinstance(models, Sized) else 0
    add_answers(
        rows, journal, clock.workers, _answered, tasks, failed=_failed, late=clock.late,
        tell=lambda count: clock.tell("checking models", count, max(total, count)),
    )  # fmt: skip
    told = [[*row[:2], *row[3:]] for row in rows]
    columns = {name: [row[i] for row in told] for i, name in enumerate(COLUMNS)}
    return Table("verdicts", columns, {"time_s": "s"})


def _about(options: CheckOptions, each_s: float, how: Mapping[str, Any]) -> dict[str, str]:
    """What the answers depend on beside the models."""
    asked = {name: exactly(one) for name, one in sorted(how.items())}
    asked |= {"options": exactly(options), "each_s": repr(each_s)}
    return {"format": "drystone-verdicts", "version": version(), **asked}


def _row(record: Any) -> Row:
    """The row of a record."""
    *plain, time_s = record
    if [type(one) for one in plain] != [int, str, str, str, int, int, str, str]:
        raise TypeError("it has other types")
    return [*plain, float(time_s)]


def _tasks(
    models: Iterable[Given], earlier: Sequence[Row], rest: tuple[Any, ...], out: PathLike | None
) -> Iterator[Task]:
    """Each model ready to travel; those answered earlier are only compared."""
    for number, given in enumerate(models):
        name = _line(os.fspath(given)) if isinstance(given, str | os.PathLike) else ""
        content = "" if out is None else content_of(given)
        if number < len(earlier):
            if earlier[number][1] != name:
                raise InputError(
                    f"model {number} of the file is '{earlier[number][1]}', not '{name}'",
                    where=str(out),
                    remedy="give the same models in the same order, or another file",
                )
            if earlier[number][2] != content:
                raise InputError(
                    f"model {number} '{name}' has another content than it had",
                    where=str(out),
                    remedy="give another file, or remove this one to start anew",
                )
            yield number, name, content, ()
        else:
            yield number, name, content, (given, *rest)


@one_blas_thread()
def _answered(task: Task) -> Row:
    """The row of a model; what cannot be made into a model is refused in words.

    Of small models with dry joints the mechanism is looked for first: of many models many fall.
    """
    *known, (given, options, each_s, how) = task
    found: Result | DrystoneError
    try:
        problem = Problem.build(supported_model(given, **how))
        asked = Asked(problem, options, Clock(each_s))
        if problem.statics.free_count and problem.equilibrium_first:
            asked.nearest = nearest_mechanism(problem.statics)
        found = decided(asked)
    except DrystoneError as error:
        found = error
    return [*known, *_told(found)]


def _told(found: Result | DrystoneError) -> Row:
    """An answer as the columns after number, name and content."""
    if isinstance(found, DrystoneError):
        return ["refused", 0, 0, "", _line(str(found)), 0.0]
    tried = found.samples.standing, found.samples.tried
    falling = _line(" ".join(found.falling_names))
    return [found.verdict.value, *tried, falling, _line(found.message), sum(found.time_s.values())]


def _failed(task: Task) -> Row:
    """The row of a model that ended its worker twice."""
    return [*task[:3], "failed", 0, 0, "", "its worker was ended twice", 0.0]


def _line(text: str | bytes) -> str:
    """Text on one line."""
    return " ".join(os.fsdecode(text).split())
