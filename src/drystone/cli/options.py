"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

from drystone.cli import kinds
from drystone.cli.offered import MODEL, OUTPUT, Option

if TYPE_CHECKING:
    pass

Supports: TypeAlias = Annotated[
    str | None,
    Option(
        "Fixed blocks: 'lowest', 'below:Z', or names and patterns, separated by commas; 'ground' "
        "or 'ground:Z' lays a plane below (those marked in the file).",
        MODEL,
    ),
]

Friction: TypeAlias = Annotated[
    float | None,
    Option(
        "Friction coefficient, or angle such as 31deg, of all joints (the file's, else 0.6).",
        MODEL,
        kind=kinds.COEFFICIENT,
    ),
]

Density: TypeAlias = Annotated[
    float | None,
    Option("Density of all blocks in kg/m3 (the file's, else 2400).", MODEL, kind=kinds.POSITIVE),
]

Units: TypeAlias = Annotated[
    str | None,
    Option("Unit of length of the file (the file's, else m).", MODEL, kind=kinds.UNIT),
]

Up: TypeAlias = Annotated[
    str,
    Option(
        "Axis that points up in the file (z).", MODEL, kind=kinds.one_of(("y", "z")), expert=True
    ),
]

SkipDefects: TypeAlias = Annotated[
    bool, Option("Leave out blocks that cannot be used.", MODEL, expert=True)
]

Html: TypeAlias = Annotated[
    Path | None,
    Option("Write a page that shows the answer in a browser.", OUTPUT,
           kind=kinds.target(".html", ".htm")),
]  # fmt: skip

Png: TypeAlias = Annotated[
    Path | None,
    Option("Write a figure, .png, .svg or .pdf.", OUTPUT,
           kind=kinds.target(".png", ".svg", ".pdf")),
]  # fmt: skip

Section: TypeAlias = Annotated[
    str | None,
    Option(
        "Cut the pictures across an axis: x through the middle, x=1.2 at a coordinate in metres. "
        "What lies before the cut is not drawn.",
        OUTPUT,
        kind=kinds.SECTION,
        expert=True,
    ),
]

Cad: TypeAlias = Annotated[
    Path | None,
    Option("Write the answer for CAD programs, .3dm or .glb.", OUTPUT,
           kind=kinds.target(".3dm", ".glb")),
]  # fmt: skip

TimeLimit: TypeAlias = Annotated[
    float | None,
    Option(
        "Seconds after which the search stops with what is known so far.",
        kind=kinds.POSITIVE,
        expert=True,
    ),
]

Workers: TypeAlias = Annotated[
    int, Option("Processes that work side by side (1).", kind=kinds.whole(1), expert=True)
]
