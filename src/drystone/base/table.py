"""Tables: named columns with units."""

from __future__ import annotations

import csv
import html
import io
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.base import units as quantities
from drystone.base.arrays import SAME, Ints, frozen, whole
from drystone.base.display import (
    BOUND,
    NAME,
    OneLine,
    rounded_down,
    rounded_up,
    shortened,
    shown_of,
)
from drystone.base.errors import InputError, counted, require
from drystone.base.files import PathLike, write_text

if TYPE_CHECKING:
    import pandas

SHOWN = 30
"""Largest number of rows in a notebook. Chosen: one screen."""
_WORDS = ("load", "factors", "carries")
"""Columns of words, not of names."""
_PREFIXED = ("N", "N m", "Pa", "m")
"""Units that are shown with a prefix in each cell."""


@dataclass(frozen=True, eq=False)
class Table(OneLine):
    """Rows of plain values under named columns.

    Parameters
    ----------
    title
    columns
        Per name one value for each row, or a vector (3,); kept as read-only arrays.
    units
        Of the columns that have one; ``1`` of shares, which are shown in percent.
    bounds
        Of the columns that are bounds, whether they are rounded up for people: True where more is
        enough as well, False where less is.
    hidden
        Columns that are left out where people read the table.
    asked
        Whether it tells what was asked, of which people read few rows, and not what was found.

    Raises
    ------
    InputError
        Columns differ in length, or a unit has no column.

    Examples
    --------
    >>> table = Table("boxes", {"box": ["a", "b"], "mass": [2.0, 3.5]}, {"mass": "kg"})
    >>> table["mass"].sum(), len(table), list(table)[1]
    (np.float64(5.5), 2, {'box': 'b', 'mass': 3.5})
    >>> table
    Table('boxes', 2 rows: box, mass [kg])
    """

    title: str
    columns: Mapping[str, Any]
    units: Mapping[str, str] = field(default_factory=dict)
    bounds: Mapping[str, bool] = field(default_factory=dict)
    hidden: Collection[str] = ()
    asked: bool = False

    def __post_init__(self) -> None:
        columns = {name: frozen(_column(values)) for name, values in self.columns.items()}
        if len({len(values) for values in columns.values()}) > 1:
            raise InputError(f"the columns of the table '{self.title}' differ in length")
        for name in self.units:
            _known(name, columns)
        object.__setattr__(self, "columns", MappingProxyType(columns))
        object.__setattr__(self, "units", MappingProxyType(dict(self.units)))

    def __reduce__(self) -> tuple[Any, ...]:
        own = self.title, dict(self.columns), dict(self.units), self.bounds, self.hidden, self.asked
        return Table, own

    def _summary(self) -> str:
        return f"'{self.title}', {counted(len(self), 'row')}: {', '.join(self.headings())}"

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __getitem__(self, column: str) -> np.ndarray:
        """The values of one column."""
        return self.columns[_known(column, self.columns)]

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """The rows, each as plain values by name of the column."""
        plain = [values.tolist() for values in self.columns.values()]
        return (dict(zip(self.columns, row, strict=True)) for row in zip(*plain, strict=True))

    @property
    def key(self) -> str:
        """The title as a name for programs."""
        return self.title.replace(" ", "_")

    def headings(self) -> list[str]:
        """Names of the columns with their units, such as ``normal [N]``."""
        return [f"{n} [{self.units[n]}]" if n in self.units else n for n in self.columns]

    def cells(self) -> tuple[list[str], list[list[str]]]:
        """Headings and rows for people: three digits, units with prefixes, shares in percent.

        Examples
        --------
        >>> table = Table("boxes", {"push": [1500.0], "at": [(0.0, 0.0, 2.0)]}, {"push": "N"})
        >>> table.cells()
        (['push', 'at'], [['1.5 kN', '0, 0, 2']])
        """
        heads, columns = [], []
        for name, values in self.columns.items():
            if name in self.hidden:
                continue
            unit = self.units.get(name, "")
            alone = unit in ("", "1") or (unit in _PREFIXED and values.dtype.kind == "f")
            heads.append(name.replace("_", " ") + ("" if alone else f" [{unit}]"))
            if name in self.bounds:
                values = _rounded(values, unit, self.bounds[name])
            columns.append(_shown(values, unit))
        return heads, [list(row) for row in zip(*columns, strict=True)]

    def printed(self) -> tuple[list[str], list[list[str]]]:
        """Headings and rows for paper: words have more room than names."""
        heads, rows = self.cells()
        most = [8 * NAME if name in _WORDS else NAME for name in heads]
        return heads, [list(map(shortened, row, most)) for row in rows]

    def _flat(self) -> dict[str, np.ndarray]:
        """The columns; of vectors one for each axis, its unit with it."""
        flat = {}
        for name, heading in zip(self.columns, self.headings(), strict=True):
            values = self[name]
            if values.ndim == 1:
                flat[heading] = values
            else:
                flat |= {heading.replace(name, f"{name}_{x}", 1): values[:, i]
                         for i, x in enumerate("xyz")}  # fmt: skip
        return flat

    def take(self, rows: Sequence[int] | Ints) -> Table:
        """Some of the rows, in the given order."""
        chosen = np.array([whole(row, "a row") for row in rows], dtype=np.intp)
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return replace(self, columns=columns)

    def to_dict(self) -> dict[str, Any]:
        """Title, units and rows as plain values for JSON; NaN and infinity become None."""
        rows = [
            {
                name: None if isinstance(value, float) and not math.isfinite(value) else value
                for name, value in row.items()
            }
            for row in self
        ]
        return {"title": self.title, "units": dict(self.units), "rows": rows}

    def to_csv(self, path: PathLike) -> None:
        """Write the rows, units in the header, to a temporary name that is then renamed.

        The cell of a number that is not known is empty; one without a bound is ``inf``.

        Raises
        ------
        FormatError
            The file cannot be written.
        """
        text = io.StringIO(newline="")
        writer = csv.writer(text, lineterminator="\n")
        flat = self._flat()
        writer.writerow(flat)
        cells = (map(_cell, values.tolist()) for values in flat.values())
        writer.writerows(zip(*cells, strict=True))
        write_text(path, text.getvalue())

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame; title and units are in its ``attrs``.

        Raises
        ------
        MissingDependency
            pandas is not installed.
        """
        require("pandas", "pandas", "a data frame")
        import pandas  # optional: only for those who work with data frames

        named = {name.partition(" [")[0]: values for name, values in self._flat().items()}
        frame = pandas.DataFrame({name: values.copy() for name, values in named.items()})
        frame.attrs.update(title=self.title, units=dict(self.units))
        return frame

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The rows for polars, pandas, DuckDB and others that read Arrow.

        Raises
        ------
        MissingDependency
            pyarrow is not installed.
        """
        require("pyarrow", "arrow", "Arrow tables")
        import pyarrow  # optional, as above

        flat = {name: values.tolist() for name, values in self._flat().items()}
        return pyarrow.table(flat).__arrow_c_stream__(requested_schema)

    def to_html(self) -> str:
        """All rows for people, below the title."""
        heads, rows = self.printed()
        head = "".join(f"<th>{html.escape(name)}</th>" for name in heads)
        cells = ("".join(f"<td><bdi>{html.escape(one)}</bdi></td>" for one in row) for row in rows)
        body = "".join(f"<tr>{row}</tr>" for row in cells)
        return (
            f"<table><caption>{html.escape(self.title)}</caption>"
            f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        )

    def _repr_html_(self) -> str:
        shown = min(len(self), shown_of(len(self), SHOWN))
        more = f"<div>and {len(self) - shown} more</div>" if len(self) > shown else ""
        return f"<div>{self.take(range(shown)).to_html()}{more}</div>"


def _column(values: Any) -> np.ndarray:
    """An array of numbers, truth values or text; of objects where None is among them."""
    if isinstance(values, np.ndarray):
        return values.copy()
    listed = list(values)
    return np.array(listed, dtype=object if None in listed else None)


def _cell(value: Any) -> Any:
    return "" if isinstance(value, float) and math.isnan(value) else value


def _known(name: str, columns: Mapping[str, Any]) -> str:
    if name not in columns:
        raise InputError(f"there is no column '{name}'", remedy=f"there are {', '.join(columns)}")
    return name


def _rounded(values: np.ndarray, unit: str, up: bool) -> np.ndarray:
    """Bounds (n,) with as many digits as are shown, on their safe side."""
    if unit == "1":
        return (np.ceil(1e3 * values - 1e-9) if up else np.floor(1e3 * values + 1e-9)) / 1e3
    side, digits = rounded_up if up else rounded_down, 3 if unit in _PREFIXED else BOUND
    return np.array([side(one, digits) if math.isfinite(one) else one for one in values.tolist()])


def _shown(values: np.ndarray, unit: str) -> list[str]:
    """The values of a column for people."""
    if values.dtype.kind == "f":
        finite = values[np.isfinite(values)]
        largest = float(np.abs(finite).max(initial=0.0))
        least = SAME * largest
        if values.ndim == 2 and unit in _PREFIXED:
            return [quantities.components(row, unit, least, largest) for row in values.tolist()]
        if values.ndim == 2:
            return [", ".join(f"{one + 0.0:.4g}" for one in row) for row in values.tolist()]
        return [_one(value, unit, least, largest) for value in values.tolist()]
    return [_text(value) for value in values.tolist()]


def _one(value: float, unit: str, least: float, largest: float) -> str:
    if not math.isfinite(value):
        return "-" if math.isnan(value) else "unlimited" if value > 0.0 else "none"
    if unit == "1":
        return f"{value + 0.0:.1%}"
    small = least if unit.startswith("N") else 1e-2 if unit == "m" else math.inf
    if largest >= 1.0 > abs(value) > small:
        return f"{value:.3g} {unit}"  # one smaller unit in a column is not read
    if unit in _PREFIXED:
        return quantities.quantity(value, unit, least)
    return f"{value + 0.0:.4g}"


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(map(str, value))
    return str(value)
