"""Tables: named columns with units."""

from __future__ import annotations

import csv
import html
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.base.arrays import Ints, frozen, whole
from drystone.base.display import OneLine, shortened
from drystone.base.errors import InputError, MissingDependency, counted
from drystone.base.files import PathLike, write_bytes

if TYPE_CHECKING:
    import pandas

SHOWN = 30
"""Largest number of rows in a notebook. Chosen: one screen."""


@dataclass(frozen=True, eq=False)
class Table(OneLine):
    """Rows of plain values under named columns.

    Parameters
    ----------
    title
    columns
        Per name one value for each row; kept as read-only arrays.
    units
        Of the columns that have one.

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

    def __post_init__(self) -> None:
        columns = {name: frozen(_column(values)) for name, values in self.columns.items()}
        if len({len(values) for values in columns.values()}) > 1:
            raise InputError(f"the columns of the table '{self.title}' differ in length")
        for name in self.units:
            _known(name, columns)
        object.__setattr__(self, "columns", MappingProxyType(columns))
        object.__setattr__(self, "units", MappingProxyType(dict(self.units)))

    def _summary(self) -> str:
        return f"'{self.title}', {counted(len(self), 'row')}: {', '.join(self.headings())}"

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __getitem__(self, column: str) -> np.ndarray:
        """The values of one column."""
        values: np.ndarray = self.columns[_known(column, self.columns)]
        return values

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """The rows, each as plain values by name of the column."""
        plain = [values.tolist() for values in self.columns.values()]
        return (dict(zip(self.columns, row, strict=True)) for row in zip(*plain, strict=True))

    def headings(self) -> list[str]:
        """Names of the columns with their units, such as ``normal [N]``."""
        return [f"{n} [{self.units[n]}]" if n in self.units else n for n in self.columns]

    def take(self, rows: Sequence[int] | Ints) -> Table:
        """Some of the rows, in the given order."""
        chosen = np.array([whole(row, "a row") for row in rows], dtype=np.intp)
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return Table(self.title, columns, self.units)

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

        Raises
        ------
        FormatError
            The file cannot be written.
        """
        text = io.StringIO(newline="")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.headings())
        writer.writerows(row.values() for row in self)
        write_bytes(path, text.getvalue().encode("utf-8"))

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame; title and units are in its ``attrs``.

        Raises
        ------
        MissingDependency
            pandas is not installed.
        """
        try:
            import pandas  # optional: only for those who work with data frames
        except ImportError as error:
            raise MissingDependency("pandas", extra="pandas", purpose="a data frame") from error
        frame = pandas.DataFrame({name: values.copy() for name, values in self.columns.items()})
        frame.attrs.update(title=self.title, units=dict(self.units))
        return frame

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{html.escape(name)}</th>" for name in self.headings())
        rows = self.take(range(min(SHOWN, len(self))))
        body = "".join(
            f"<tr>{''.join(f'<td>{html.escape(_told(x))}</td>' for x in row.values())}</tr>"
            for row in rows
        )
        more = f"<div>and {len(self) - SHOWN} more</div>" if len(self) > SHOWN else ""
        return (
            f"<div><b>{html.escape(self.title)}</b><table><thead><tr>{head}</tr></thead>"
            f"<tbody>{body}</tbody></table>{more}</div>"
        )


def _column(values: Any) -> np.ndarray:
    """An array of numbers, truth values or text; of objects where None is among them."""
    if isinstance(values, np.ndarray):
        return values.copy()
    listed = list(values)
    return np.array(listed, dtype=object if None in listed else None)


def _known(name: str, columns: Mapping[str, Any]) -> str:
    if name not in columns:
        raise InputError(f"there is no column '{name}'", remedy=f"there are {', '.join(columns)}")
    return name


def _told(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else shortened(str(value), 60)
