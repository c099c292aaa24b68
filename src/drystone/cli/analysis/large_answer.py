"""The answer of ``push`` and of ``settle --to``: large displacements."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base import units
from drystone.cli.base import kinds
from drystone.cli.base.command import OUTPUT, Option
from drystone.cli.base.output import Screen
from drystone.cli.base.told import Printed
from drystone.cli.base.written import Pictures, apart

if TYPE_CHECKING:
    from drystone.base.files import Job
    from drystone.cli.base.told import Files
    from drystone.settlement import LargeDisplacement

_SHOWN = 12
"""Rows of hinges and slides that are shown; chosen."""


@dataclass(frozen=True)
class Curves(Pictures):
    """The page, the plot and the curve as numbers."""

    curve: Annotated[
        Path | None,
        Option(
            "Write the curve of load against displacement, .csv or .json.",
            OUTPUT,
            kind=kinds.target(".csv", ".json"),
        ),
    ] = None

    def __post_init__(self) -> None:
        apart([self.html, self.png, self.curve])
        self.require_picture()


def answer(
    found: LargeDisplacement, model: str, notes: Sequence[str], wanted: Curves, code: int
) -> Printed:
    """The answer, with its files."""
    data = {"model": model, **found.to_dict()}
    return Printed(
        data, partial(_show, found, data), code, notes, partial(_files, found, wanted, model)
    )


def _files(found: LargeDisplacement, wanted: Curves, source: str) -> Files:
    jobs: list[Job] = []
    if wanted.html is not None or wanted.png is not None:
        from drystone import view  # work is imported when there is some

        page = partial(view.save_page, found, section=wanted.section)
        plot = partial(view.save_curve, found, title=Path(source).stem)
        jobs = wanted.jobs(page, plot)
    if wanted.curve is not None:
        from drystone.base.files import write_bytes  # as above

        if wanted.curve.suffix.lower() == ".csv":
            jobs.append((wanted.curve, found.table().to_csv))
        else:
            content = json.dumps(found.to_dict()).encode("utf-8")
            jobs.append((wanted.curve, partial(write_bytes, data=content)))
    return jobs, []


def _show(found: LargeDisplacement, data: dict[str, Any], screen: Screen) -> None:
    screen.line(str(data["model"]), found.end.value.upper(), "bold")
    screen.line(found.message)
    events = list(found.events())
    screen.line(f"hinges and slides: {len(events) or 'none'}")
    unit = found.unit
    screen.table(
        ("at", "load", "joint", "becomes"),
        [
            (
                units.quantity(row["displacement"], "m"),
                units.quantity(row["load"], unit) if unit else f"{row['load']:.4g}",
                f"{row['block_a']} - {row['block_b']}",
                "a hinge" if row["event"] == "hinge" else "sliding",
            )
            for row in events[:_SHOWN]
        ],
    )
    if len(events) > _SHOWN:
        screen.line(f"and {len(events) - _SHOWN} more, see --json")
