"""Verdicts or limits over a table of parameters, into a file that can be continued."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice, product
from typing import Any, TypeAlias, Unpack

import numpy as np

from drystone.answer.chart import Chart, HeatMap, MarkKind, Marks
from drystone.base.arrays import of_type
from drystone.base.declared import COEFFICIENT, declared
from drystone.base.display import OneLine, digits_apart, rounded_down, rounded_up, shortened
from drystone.base.errors import DrystoneError, InputError, quoted
from drystone.base.files import PathLike
from drystone.base.journal import Journal, add_answers, exactly
from drystone.base.settings import Clock, Stop, checked_call
from drystone.base.table import Table
from drystone.base.version import version
from drystone.io import read
from drystone.io.opening import Given, How, LongHow, content_of, supported_model
from drystone.limits import ThrustBounds
from drystone.limits.bounds import tilt_margin
from drystone.model import Model
from drystone.results import Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability import CheckOptions, check
from drystone.studies.limit_words import TURNED, UNSURE, limit_of_words, measured, measures

Parameters: TypeAlias = Mapping[str, Sequence[Any]] | Iterable[Mapping[str, Any]]
"""Values of each parameter, in all their combinations; or rows."""


@dataclass(frozen=True, eq=False)
class _Task(OneLine):
    """One row: its number and inputs, and what is asked."""

    number: int
    inputs: Mapping[str, Any]
    build: Any
    limit: str
    options: CheckOptions
    each_s: float
    how: Mapping[str, Any]

    @property
    def model(self) -> Model:
        """The model of the row."""
        own = {name: value for name, value in self.inputs.items() if name not in _READING}
        try:
            given = self.build(**own) if callable(self.build) else self.build
        except DrystoneError:
            raise
        except Exception as error:  # a family is the caller's: any of its errors ends its row
            what = f"{type(error).__name__}: {error}"
            raise InputError(what, where="its function", remedy="leave the value out") from error
        reading = {name: value for name, value in self.inputs.items() if name in _READING}
        return supported_model(given, **{**self.how, **reading})

    def row(self, *found: Any) -> list[Any]:
        """The row of what was found."""
        return [_plain(one) for one in (self.number, *self.inputs.values(), *found)]

    def without(self, word: str, why: str, time_s: float = 0.0) -> list[Any]:
        """The row of what was not found."""
        return self.row(word, *(None for _ in _columns(self.limit)), "", why, time_s)


_SIDES = ("stands", "falls")
_UNBALANCED = "unbalanced"
_READING = frozenset(How.__annotations__)


@checked_call
@one_blas_thread()
def study(
    build: Callable[..., Given] | Given,
    parameters: Parameters,
    *,
    limit: str = "",
    out: PathLike | None = None,
    options: CheckOptions | None = None,
    each_s: float = float("inf"),
    **how: Unpack[LongHow],
) -> Table:
    """The verdict, or a limit, for each row of a table of parameters.

    Parameters
    ----------
    build
        Function from parameters to an assembly, a model or a file, such as a family of
        ``drystone.models``; or one model for all rows.
    parameters
        Values of each by name, computed in all their combinations; or rows, such as a
        ``Table``. What :func:`drystone.read` knows (``friction``, ``load``, ``seismic`` and
        others) is an option of reading, everything else an argument of ``build``.
    limit
        As behind ``drystone limit``, such as ``tilt --axis y``; when left out, models are checked.
    out
        A file that keeps each row as soon as it is known. Rows that it has are not computed again;
        it is refused where models, files that are named, or the text of ``build`` have changed.
        Not seen is what ``build`` calls or opens by itself.
    options
        Of every check.
    each_s : [s]
        Time limit of every row.

    Returns
    -------
    Table
        A row for each: number and inputs; of a check the verdict and ``tilt_margin``, [deg] up
        to which forces balance the loads; of a limit the last value at which it stands and the
        first one at which it falls (with ``--robust`` for every stiffness tried), and the ranges
        where it is ``sensitive`` to stiffness or ``undecided``, or what else it finds, such as both
        bounds of a thrust; of both tilts about which axis it was ``turned``; the blocks that move,
        a message, and the time [s]. ``refused`` stands where there is no model, ``unbalanced``
        where no forces bound a thrust, ``failed`` where a worker ended twice.

    Raises
    ------
    InputError
        No row, rows with other parameters, a parameter that is called like another column, a limit
        that is not known, or a file of another study.

    Examples
    --------
    >>> from drystone.models import arch
    >>> found = study(arch, {"thickness_ratio": [0.15, 0.2]}, limit="tilt --axis y", friction=0.7)
    >>> found["stands"].round(1).tolist()
    [8.2, 15.8]
    """
    rows = _rows(parameters)
    found = ("verdict", *_columns(limit), "mechanism", "message", "time_s")
    _require(rows[0], found, build)
    _require_taken(rows[0], build)
    chosen, clock = CheckOptions.of(options), Clock.of(how)
    about = {
        "format": "drystone-study", "version": version(), "limit": exactly(limit),
        "each_s": repr(each_s), "options": exactly(chosen), "parameters": sorted(rows[0]),
        "build": getattr(build, "__qualname__", None) or quoted(build, 120),
        "content": content_of(build) or _text_of(build),
        "inputs": _contents(rows, [*limit.split(), *how.values()]),
        **{name: exactly(value) for name, value in sorted(how.items())},
    }  # fmt: skip
    names = ("number", *rows[0], *found)
    journal = None if out is None else Journal(out, about, partial(_listed, names, _columns(limit)))
    done: list[list[Any]] = [] if journal is None else journal.records[: len(rows)]
    _require_same(done, rows, out)
    tasks = (_Task(number, inputs, build, limit, chosen, each_s, how)
             for number, inputs in enumerate(rows))  # fmt: skip
    # what is asked to stop in this process is heard inside a row too, which is not kept then
    answered = _answered if clock.workers is not None else partial(_answered, stop=clock.wish)
    add_answers(
        done, journal, clock.workers, answered, islice(tasks, len(done), None), failed=_failed,
        late=clock.late, tell=lambda count: clock.tell("studying", count, len(rows)),
    )  # fmt: skip
    columns = {name: [row[i] for row in done] for i, name in enumerate(names)}
    for name in _columns(limit).keys() - {TURNED}:
        known = [np.nan if one is None else one for one in columns[name]]
        columns[name] = np.array(known, dtype=float)  # type: ignore[assignment]
    units = {name: unit for name, unit in _columns(limit).items() if unit}
    bounds = dict.fromkeys({"tilt_margin", "factor"} & set(_columns(limit)), False)
    if "stands" in _columns(limit):
        falls_below = bool((np.array(columns["falls"]) < np.array(columns["stands"])).any())
        bounds |= {"stands": falls_below, "falls": not falls_below}
    units |= {"time_s": "s", **_units_of(build, rows[0])}
    return Table(limit or "verdicts", columns, units, bounds, _hidden(columns))


def study_told(table: Table) -> Table:
    """A study for people: both sides of a limit with the digits of the limit's title.

    They are rounded away from the limit: what is told to stand stands, what falls falls.

    Parameters
    ----------
    table
        Rows of a study, as ``Study.table`` has them.
    """
    sides = _sides(table)
    bounds = {name: up for name, up in table.bounds.items() if name not in sides}
    return Table(table.title, {**table.columns, **sides}, table.units, bounds, table.hidden)


def _sides(table: Table) -> dict[str, list[str]]:
    """The columns of both sides of a limit in words; none where a study is of none."""
    told: dict[str, list[str]] = {one: [] for one in _SIDES if one in table.bounds}
    for row in zip(*(table[one].tolist() for one in told), strict=True):
        digits = digits_apart(*filter(np.isfinite, row))
        for name, value in zip(told, row, strict=True):
            if np.isfinite(value):
                value = (rounded_up if table.bounds[name] else rounded_down)(value, digits)
            told[name].append(f"{value:.{digits}g}".replace("nan", "-"))
    return told


def study_chart(table: Table, across: str = "", by: str = "", up: str = "") -> Chart:
    """A study as curves over one parameter, one curve for each value of another.

    Parameters
    ----------
    table
        Of :func:`study`.
    across, by
        Parameters; when left out, the first one and the second one, if there is one.
    up
        Column; when left out, the limit or the margin of tilt.

    Raises
    ------
    InputError
        There is no such column, it has no numbers, or there are more than two parameters and
        neither is named.

    Examples
    --------
    >>> from drystone.models import arch
    >>> found = study(arch, {"thickness_ratio": [0.15, 0.2]}, friction=0.7)
    >>> study_chart(found).across
    'thickness ratio'
    """
    across, by = _parameters(table, across, by)
    up = up or _first_found(table)
    x, y = (_numbers(table, one) for one in (across, up))
    marks = _curves(table, x, y, by)
    if up == _first_found(table):
        marks += _fallen(table, x, y)
    units = table.units.get(across, ""), table.units.get(up, "")
    words = _axis(table, across), _axis(table, up)
    told = "; ".join(filter(None, (study_fixed(table), _beyond(table, up))))
    return Chart(table.title, tuple(marks), *words, units, told)


def _beyond(table: Table, up: str) -> str:
    """How far from the points of a chart of what stands it falls: too little to be drawn."""
    if up != "stands" or "falls" not in table.columns:
        return ""
    gaps = np.abs(table["falls"] - table["stands"])
    most = rounded_up(float(gaps[np.isfinite(gaps)].max(initial=0.0)), 2)
    told = f"{most:.2g} {table.units.get(up, '')}".rstrip()
    return f"it stands at each point, and falls at most {told} beyond" if most else ""


def study_map(table: Table, across: str = "", by: str = "", value: str = "") -> HeatMap:
    """A study of two parameters as a map, whose cells have the limit or the margin of tilt.

    Parameters
    ----------
    table
        Of :func:`study`.
    across, by
        Parameters; when left out, the first one and the second one.
    value
        Column; when left out, the limit or the margin of tilt.

    Raises
    ------
    InputError
        There is no such column, it has no numbers, or there are not two parameters and neither is
        named, or several rows have the same two values.

    Examples
    --------
    >>> from drystone.models import arch
    >>> asked = {"thickness_ratio": [0.15, 0.2], "friction": [0.4, 0.7]}
    >>> study_map(study(arch, asked, limit="tilt --axis y")).values.round(1).tolist()
    [[3.0, 5.6], [8.2, 15.8]]
    """
    across, by = _parameters(table, across, by)
    if not by:
        raise InputError("a map is of two parameters", where="by", remedy="draw one as a chart")
    value = value or _first_found(table)
    found = _told_numbers(table, value)
    x, y = (sorted(set(table[one])) for one in (across, by))
    cells = np.full((len(y), len(x)), np.nan)
    taken = set()
    for one, other, number in zip(table[across], table[by], found, strict=True):
        place = y.index(other), x.index(one)
        if place in taken:
            said = f"several rows have {across} {one} and {by} {other}"
            raise InputError(said, where="map", remedy="take rows that differ in these two only")
        taken.add(place)
        cells[place] = number
    names = [_with_unit(table, one) for one in (across, by, value)]
    columns, rows = (
        tuple(f"{one:.4g}" if isinstance(one, float) else str(one) for one in ends)
        for ends in (x, y)
    )
    head = f"{table.title}; {study_fixed(table)}".removesuffix("; ")
    return HeatMap(head, names[0], names[1], columns, rows, cells, names[2])


def _with_unit(table: Table, name: str) -> str:
    unit = table.units.get(name, "")
    return f"{_axis(table, name)} [{unit}]" if unit else _axis(table, name)


def _told_numbers(table: Table, name: str) -> Any:
    """A column of numbers as it is told."""
    told = _sides(table).get(name)
    if told is None:
        return _numbers(table, name)
    return np.array(["nan" if one == "-" else one for one in told], dtype=float)


def _axis(table: Table, name: str) -> str:
    """The name of a column in words; of a side of a limit with what is limited."""
    if name not in _SIDES:
        return name.replace("_", " ")
    limited = table.title.partition(" ")[0].replace("-", " ")
    axes = dict.fromkeys(one for one in table.columns.get(TURNED, ()) if one)
    limited = f"{limited} {' or '.join(axes)}".strip()
    said = {"stands": "down to" if table.bounds["stands"] else "up to", "falls": "at"}
    return f"{name} {said[name]} {'load factor' if limited == 'load' else limited}"


def study_fixed(table: Table) -> str:
    """Parameters with one value where others have several, in words."""
    names = list(table.columns)
    inputs = names[1 : names.index("verdict")] if len(table) > 1 else []
    return ", ".join(
        f"{one.replace('_', ' ')} {table[one][0]} {table.units.get(one, '')}".strip()
        for one in inputs
        if len(set(table[one])) == 1
    )


def _units_of(build: Any, names: Iterable[str]) -> dict[str, str]:
    """Units of parameters as the documentation of a function, or of what is read, tells them."""
    known = dict(declared(read))
    if callable(build):
        with suppress(TypeError, ValueError, NameError):  # what Python cannot look into
            known |= declared(build)
    units = {one: known[one].unit for one in names if one in known}
    return {one: unit for one, unit in units.items() if unit not in ("", COEFFICIENT)}


def _first_found(table: Table) -> str:
    """The column behind the verdict: the limit or the margin of tilt."""
    names = list(table.columns)
    return names[names.index("verdict") + 1]


def _numbers(table: Table, name: str) -> Any:
    """A column of numbers."""
    values = np.asarray(table[name])
    if not len(values):
        raise InputError("there is no picture: there is no row")
    if values.dtype.kind not in "iuf":
        raise InputError("has no numbers", where=name, remedy="choose another column")
    return values


def _parameters(table: Table, across: str, by: str) -> tuple[str, str]:
    """The parameters of a chart: those named, else of those that vary the first and the second."""
    names = list(table.columns)
    inputs = names[1 : names.index("verdict")]
    inputs = [one for one in inputs if len(set(table[one])) > 1] or inputs
    if not across and len(inputs) > 2:
        remedy = f"name two of {', '.join(inputs)}"
        raise InputError(f"there are {len(inputs)} parameters", where="across", remedy=remedy)
    across = across or next(one for one in inputs if one != by)
    by = by or next((one for one in inputs if one != across and len(inputs) == 2), "")
    return across, by


def _hidden(columns: Mapping[str, Sequence[Any]]) -> frozenset[str]:
    """Columns that say nothing to people: what is the same in all rows, and what is for programs.

    Messages are told where a row has no answer.
    """
    inputs = [*columns][1 : [*columns].index("verdict")]
    varied = [one for one in inputs if len({*map(str, columns[one])}) > 1]
    hidden = {"number", "time_s", *inputs} - {*(varied or inputs)}
    hidden |= {one for one in UNSURE if one in columns and not np.isfinite(columns[one]).any()}
    answered = {"found", _UNBALANCED, *(one.value for one in Verdict)}
    return frozenset(hidden if {*columns["verdict"]} - answered else {*hidden, "message"})


def _curves(table: Table, x: Any, y: Any, by: str) -> list[Marks]:
    """Lines and their points, one line for each value of a parameter."""
    groups = [""] if not by else list(dict.fromkeys(table[by].tolist()))
    inks, marks = ("accent", "bad", "good", "unsure", "ink"), []
    shapes = (MarkKind.DISC, MarkKind.RING, MarkKind.DIAMOND)
    for number, value in enumerate(groups):
        mine = np.flatnonzero(np.isfinite(y) & ((table[by] == value) if by else True))
        order = mine[np.argsort(x[mine], kind="stable")]
        unit = table.units.get(by, "")
        ink = inks[number % len(inks)]
        label = f"{by.replace('_', ' ')} {value} {unit}".strip() if by else ""
        line = MarkKind.DASHED if number % 2 else MarkKind.LINE  # one below another is seen
        marks.append(Marks(line, x[order].astype(float), y[order], ink, label))
        shape = shapes[number % len(shapes)]
        marks.append(Marks(shape, x[order].astype(float), y[order], ink))
    return marks


def _fallen(table: Table, x: Any, y: Any) -> list[Marks]:
    """Crosses where rows have no limit since they fall: at the value at which they do."""
    unstable = np.where(table["verdict"] == Verdict.UNSTABLE.value, 0.0, np.nan)
    at = table["falls"] if "falls" in table.columns else unstable
    some = np.isnan(y) & np.isfinite(at)
    if not some.any():
        return []
    return [Marks(MarkKind.CROSS, x[some].astype(float), at[some], "ink", "falls from the start")]


def _columns(limit: str) -> Mapping[str, str]:
    """The columns of what is found, with their units."""
    return measures(limit) if limit else {"tilt_margin": "deg", TURNED: ""}


def _require(names: Iterable[str], taken: Sequence[str], build: Any) -> None:
    """Refuse parameters that are columns of the answer, or that nothing takes."""
    for name in names:
        if name in ("number", *taken):
            raise InputError("is a column of the answer", where=name, remedy="rename it")
        if name not in _READING and not callable(build):
            remedy = "give a function of it in place of the model"
            raise InputError("is no option of reading", where=name, remedy=remedy)


def _require_taken(names: Iterable[str], build: Any) -> None:
    """Refuse parameters that a function does not take, or that it takes besides."""
    if not callable(build):
        return
    try:
        inspect.signature(build).bind(**{name: 0 for name in names if name not in _READING})
    except TypeError as error:
        who = getattr(build, "__name__", "the function")
        remedy = "give each of its parameters, by its name"
        raise InputError(f"{who} {error}", where="parameters", remedy=remedy) from error


def _require_same(
    done: Sequence[Sequence[Any]], rows: Sequence[Mapping[str, Any]], out: PathLike | None
) -> None:
    """Refuse rows of a file that are others than those that are asked for."""
    for number, (row, inputs) in enumerate(zip(done, rows, strict=False)):
        if row[: 1 + len(inputs)] != [number, *(_plain(one) for one in inputs.values())]:
            remedy = "give the same rows in the same order, or another file"
            raise InputError(f"row {number} has other inputs", where=str(out), remedy=remedy)


def _rows(parameters: Any) -> list[dict[str, Any]]:
    """The rows of parameters."""
    if hasattr(parameters, "columns") and not isinstance(parameters, Table):  # a data frame
        parameters = parameters.to_dict("records")
    if isinstance(parameters, Mapping):
        values = [list(of_type(one, Iterable, name, "give a list"))  # type: ignore[type-abstract]
                  for name, one in parameters.items()]  # fmt: skip
        rows = [dict(zip(parameters, each, strict=True)) for each in product(*values)]
    else:
        rows = [dict(of_type(one, Mapping, "a row", "give a dictionary"))  # type: ignore[type-abstract]
                for one in parameters]  # fmt: skip
    if not any(rows[:1]):
        raise InputError("there is no row", where="parameters", remedy="give values of each")
    for number, row in enumerate(rows):
        if list(row) != list(rows[0]):
            remedy = f"give {shortened(', '.join(map(str, rows[0])), 60)}"
            raise InputError(f"row {number} has other parameters", remedy=remedy)
    return rows


@one_blas_thread()
def _answered(task: _Task, stop: Stop | None = None) -> list[Any] | None:
    """The row of a task; ``None`` where the caller asked to stop before it was known."""
    clock = Clock(task.each_s, stop)
    row = _row(task, clock)
    return None if stop is not None and stop() else row


def _row(task: _Task, clock: Clock) -> list[Any]:
    try:
        model = task.model
        if task.limit:
            answer = limit_of_words(task.limit, model)(model, {"stop": clock.late})
            values, moves = measured(answer)
            word = "stopped" if getattr(answer, "stopped", "") else "found"
            if isinstance(answer, ThrustBounds) and np.isnan(answer.least):
                word = _UNBALANCED
            message = "; ".join((answer.title, *getattr(answer, "remarks", ())))
            return task.row(
                word, *map(_without_noise, values), " ".join(moves), message, clock.elapsed_s
            )
        result = check(model, options=task.options, stop=clock.late)
        margin, about = tilt_margin(model, stop=clock.late) if result.stable else (None, "")
        about = f"about {about}" if about else ""
    except DrystoneError as error:
        return task.without("refused", str(error), clock.elapsed_s)
    moves = result.falling_names
    return task.row(
        result.verdict.value, margin, about, " ".join(moves), result.message, clock.elapsed_s
    )  # fmt: skip


def _without_noise(value: float | str | None) -> float | str | None:
    return value if value is None or isinstance(value, str) else float(f"{value:.12g}")


def _failed(task: _Task) -> list[Any]:
    """The row of a task that ended its worker twice."""
    return task.without("failed", "its worker was ended twice")


def _listed(names: Sequence[str], found: Mapping[str, str], record: Any) -> list[Any]:
    """The row of a record, with a value for each column."""
    row = dict(zip(names, record, strict=True))
    for name in found.keys() - {TURNED}:
        row[name] = None if row[name] is None else float(row[name])
    if not isinstance(row["number"], int) or {list, dict} & {*map(type, row.values())}:
        raise TypeError("it is no row")
    return [*row.values()]


def _contents(rows: Iterable[Mapping[str, Any]], beside: Iterable[Any]) -> list[str]:
    """What inputs have beside what the rows say: arrays, and the content of files."""
    inputs = [one for row in rows for one in row.values()]
    files = {content_of(one) for one in (*inputs, *beside)} - {""}
    return sorted({*map(exactly, inputs)} - {repr(_plain(one)) for one in inputs} | files)


def _text_of(build: Any) -> str:
    """The text of a function; empty where there is none."""
    while isinstance(build, partial):
        build = build.func
    try:
        return inspect.getsource(build)
    except (OSError, TypeError):
        return ""


def _plain(value: Any) -> Any:
    """A value that JSON gives back as it was; others as text."""
    if isinstance(value, np.generic):
        value = value.item()
    plain = value is None or isinstance(value, bool | int | float | str)
    return value if plain else quoted(value, 120)
