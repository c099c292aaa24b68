"""Joint tables to files: CSV for spreadsheets, JSON for programs."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path

from drystone.errors import FormatError
from drystone.io.files import PathLike, write_bytes
from drystone.joints import JointTable

UNITS = {
    "area": "m2",
    "normal": "N",
    "tangential": "N",
    "torque": "N m",
    "eccentricity": "m",
    "mean_pressure": "Pa",
    "peak_pressure": "Pa",
    "x": "m",
    "y": "m",
    "z": "m",
}
"""Units of the columns that have one."""


def write_joints(table: JointTable, path: PathLike) -> None:
    """Write all rows of a joint table.

    Parameters
    ----------
    table
    path
        ``.csv`` with the units in the header, or ``.json``, where an infinite number is null.

    Raises
    ------
    FormatError
        Another suffix, or the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    rows = table.rows()
    if suffix == ".csv":
        names = list(rows[0]) if rows else ["joint", "block_a", "block_b"]
        text = io.StringIO(newline="")
        writer = csv.writer(text)
        writer.writerow([f"{n} [{UNITS[n]}]" if n in UNITS else n for n in names])
        writer.writerows([row[name] for name in names] for row in rows)
        write_bytes(path, text.getvalue().encode("utf-8"))
    elif suffix == ".json":
        plain = [
            {
                key: None if isinstance(value, float) and not math.isfinite(value) else value
                for key, value in row.items()
            }
            for row in rows
        ]
        content = {"units": UNITS, "strength": table.strength, "joints": plain}
        write_bytes(path, json.dumps(content, allow_nan=False).encode("utf-8"))
    else:
        raise FormatError(
            f"a joint table cannot be written as '{suffix}'",
            where=str(path),
            remedy="end the name in .csv or .json",
        )


__all__ = ["UNITS", "write_joints"]
