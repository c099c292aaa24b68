"""The answer of ``settle`` where no support moves: blocks followed until they rest or fall."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from drystone.base import units
from drystone.base.errors import InputError
from drystone.cli.base.output import Screen
from drystone.cli.base.told import Printed
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import Written

if TYPE_CHECKING:
    from drystone.cli.base.told import Files
    from drystone.model import Model
    from drystone.settlement import Settlement

_SHOWN = 12
"""Blocks that are shown; chosen."""
_NO_TURN = 1e-12
"""[rad], below which a rotation is rounding."""
STYLE = {"comes to rest": "bold green", "falls": "bold red", "comes to rest far away": "bold red"}


def answer(
    model: Model, source: str, wanted: Written, waiting: Waiting, time_limit: float | None
) -> Printed:
    """Follow the blocks under their load.

    Raises
    ------
    InputError
        A table of joints is asked for.
    """
    from drystone.settlement import settle  # work is imported when there is some

    if wanted.joints or wanted.strength is not None:
        raise InputError(
            "there is no table of joints without --move", remedy="ask for --html, --png or --json"
        )
    waiting.stage("solve", "following the blocks")
    with waiting.keywords(time_limit) as common:
        found = settle(model, **common)
    data = {"model": source, **found.to_dict()}
    files = partial(_files, found, wanted)
    return Printed(data, partial(_show, data), 0 if found.rests else 1, model.notes, files)


def _files(found: Settlement, wanted: Written) -> Files:
    jobs, said = wanted.of(found)
    return [*jobs, *wanted.for_cad(found)], said


def _show(data: Mapping[str, Any], screen: Screen) -> None:
    screen.line(
        str(data["model"]), data["outcome"].upper(), STYLE.get(data["outcome"], "bold yellow")
    )
    screen.line(data["message"])
    differ = len({path["outcome"] for path in data["paths"]}) > 1
    for path in data["paths"] if differ else data["paths"][:1]:
        moved = sorted(path["blocks"], key=lambda row: -row["travel"])
        moved = [row for row in moved if row["travel"] > 0.0]
        if differ:
            carrier = f"ends of joints carried by the {path['carrier']} block"
            screen.line(f"{carrier}: {path['outcome']}")
        rows = [
            (
                row["block"],
                units.components([row[f"move_{axis}"] for axis in "xyz"], "m"),
                _degrees([row[f"turn_{axis}"] for axis in "xyz"]),
                f"{row['travel']:.2g}",
            )
            for row in moved[:_SHOWN]
        ]
        screen.table(("block", "moves by", "turns by", "by its size"), rows)
        if len(moved) > _SHOWN:
            screen.line(f"and {len(moved) - _SHOWN} more, see --json")


def _degrees(vector: list[float]) -> str:
    """The angle of a rotation vector [rad]."""
    size = sum(one * one for one in vector) ** 0.5
    return f"{math.degrees(size):.2g} deg" if size > _NO_TURN else "0 deg"
