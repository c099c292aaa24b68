"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

from drystone.base.errors import InputError
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


def vector(text: str, example: str = "0,0,-9.81") -> tuple[float, float, float]:
    """Three finite numbers separated by commas, such as the example.

    Raises
    ------
    InputError
        Not three, or not finite.
    """
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"'{text}' is not X,Y,Z", remedy=f"write {example}") from error
    if len(values) != 3 or not all(abs(value) < float("inf") for value in values):
        raise InputError(f"'{text}' is not three finite numbers", remedy=f"write {example}")
    return values[0], values[1], values[2]


def gravity_vector(text: str) -> tuple[float, float, float]:
    """Acceleration (3,) [m/s2] from its size or its components.

    Raises
    ------
    InputError
        Neither one number above zero nor three that are not all zero.
    """
    if "," in text:
        given = vector(text)
        if given == (0.0, 0.0, 0.0):
            raise InputError("is zero", remedy="give a direction")
        return given
    try:
        size = float(text)
    except ValueError as error:
        raise InputError(f"'{text}' is neither a number nor X,Y,Z", remedy="write 9.81") from error
    if not 0.0 < size < float("inf"):
        raise InputError(f"is {text}", remedy="give a number above zero")
    return (0.0, 0.0, -size)
