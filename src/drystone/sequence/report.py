"""A plan as a table: a row per block in the order of assembly."""

from __future__ import annotations

import csv
import io

from drystone.io.files import PathLike, write_bytes
from drystone.sequence.margins import Margins
from drystone.sequence.plans import Plan

COLUMNS = (
    "stage",
    "block",
    "status",
    "with",
    "prop_force_N",
    "prop_stages",
    "propped_now",
    "friction_used",
    "least_friction",
    "tilt_deg",
)


def table_text(plan: Plan, margins: Margins | None = None) -> str:
    """The table as CSV; margins are empty where they were not asked for."""
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, lineterminator="\n", restval="")
    writer.writeheader()
    for row in (plan if margins is None else margins).rows():
        writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})
    return out.getvalue()


def save_table(plan: Plan, path: PathLike, margins: Margins | None = None) -> None:
    """Write the table as CSV, to a temporary name beside it that is then renamed."""
    write_bytes(path, table_text(plan, margins).encode("utf-8"))


__all__ = ["COLUMNS", "save_table", "table_text"]
