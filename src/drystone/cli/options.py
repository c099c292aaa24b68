"""Options that several commands share."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, TypeAlias

from drystone.cli import kinds
from drystone.cli.offered import MODEL, OUTPUT, WORKERS, Option, writes

Friction: TypeAlias = Annotated[
    float | None,
    Option(
        "Friction coefficient, or angle such as 31deg, of all joints (the file's, else 0.6).",
        MODEL,
        kind=kinds.COEFFICIENT,
    ),
]

Html: TypeAlias = Annotated[
    Path | None,
    writes("Write a page that shows the answer in a browser.", ".html", ".htm"),
]

Png: TypeAlias = Annotated[
    Path | None,
    writes("Write a figure, .png, .svg or .pdf.", ".png", ".svg", ".pdf"),
]

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

_CAD = writes("Write the answer for CAD programs, .3dm or .glb.", ".3dm", ".glb")
Cad: TypeAlias = Annotated[Path | None, _CAD]
RareCad: TypeAlias = Annotated[Path | None, replace(_CAD, expert=True)]

Csv: TypeAlias = Annotated[
    Path | None,
    writes("Write the table of the answer, .csv.", ".csv", expert=True),
]

_REPORT = writes("Write a calculation report on the answer, .pdf or .html.", ".pdf", ".html")
Report: TypeAlias = Annotated[Path | None, _REPORT]
RareReport: TypeAlias = Annotated[Path | None, replace(_REPORT, expert=True)]

_TITLES = Option("TOML file with the entries of the title block.", OUTPUT, kind=kinds.FILE)
TitleBlock: TypeAlias = Annotated[Path | None, _TITLES]
RareTitleBlock: TypeAlias = Annotated[Path | None, replace(_TITLES, expert=True)]

TimeLimit: TypeAlias = Annotated[
    float | None,
    Option(
        "Seconds after which the search stops with what is known so far.",
        kind=kinds.POSITIVE,
        expert=True,
    ),
]

Workers: TypeAlias = Annotated[int | str, Option(WORKERS, kind=kinds.WORKERS, expert=True)]
