"""Options that several commands share, and how their text becomes values."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from drystone.errors import InputError

ModelArgument: TypeAlias = Annotated[
    str, typer.Argument(metavar="MODEL", help="Model file; its suffix tells the format.")
]
Supports: TypeAlias = Annotated[
    str | None,
    typer.Option(
        help="Fixed blocks: 'lowest', 'below:Z' or names and patterns, separated by commas. Left "
        "out, those that the file marks."
    ),
]
Friction: TypeAlias = Annotated[
    float | None,
    typer.Option(help="Friction coefficient of all joints (0.6, or what the file says)."),
]
Density: TypeAlias = Annotated[
    float | None, typer.Option(help="Density of all blocks in kg/m3 (2400, or what the file says).")
]
Units: TypeAlias = Annotated[
    str | None, typer.Option(help="Unit of length of the file: mm, cm, m, in or ft.")
]
Split: TypeAlias = Annotated[
    bool, typer.Option("--split", help="Make blocks of the separate parts of a block.")
]
Json: TypeAlias = Annotated[
    bool, typer.Option("--json", help="Print one JSON object and nothing else.")
]
Gravity: TypeAlias = Annotated[
    str | None,
    typer.Option(help="Gravity in m/s2: its size, or a vector X,Y,Z (9.81 along -z)."),
]
Gap: TypeAlias = Annotated[
    float | None,
    typer.Option(help="Largest gap of a joint, relative to the size of the smaller block (0.005)."),
]
Angle: TypeAlias = Annotated[
    float | None,
    typer.Option(help="Largest angle in degrees between faces that make a joint (2)."),
]
Edges: TypeAlias = Annotated[
    str | None,
    typer.Option(
        help="Contacts along edges and in corners: for 'isolated' blocks only, which touch "
        "nothing else, 'always' or 'never' (isolated)."
    ),
]
FindContacts: TypeAlias = Annotated[
    bool,
    typer.Option("--find-contacts", help="Find contacts anew where the file brings some."),
]
Anyway: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--anyway",
        help="Go on where blocks overlap by more than a tenth of the smaller one; plan also where "
        "the complete model does not stand.",
    ),
]
Html: TypeAlias = Annotated[
    str | None, typer.Option("--html", help="Write a page to look at the answer in a browser.")
]
Png: TypeAlias = Annotated[str | None, typer.Option("--png", help="Write a figure, .png or .svg.")]
TimeLimit: TypeAlias = Annotated[
    float | None, typer.Option(help="Seconds after which the search stops with what it knows.")
]


def output_path(text: str, option: str, suffixes: tuple[str, ...]) -> Path:
    """Where to write, checked before any work is done.

    Raises
    ------
    InputError
        Another suffix, a folder that does not exist, or a folder of that name.
    """
    path = Path(text)
    if path.suffix.lower() not in suffixes:
        raise InputError(
            f"'{text}' does not end in {' or '.join(suffixes)}",
            where=option,
            remedy=f"write {path.stem or 'model'}{suffixes[0]}",
        )
    if path.is_dir():
        raise InputError(f"'{text}' is a folder", where=option, remedy="name a file in it")
    if not path.parent.is_dir():
        raise InputError(
            f"there is no folder '{path.parent}'", where=option, remedy="make it first"
        )
    return path


def apart(names: Sequence[str]) -> None:
    """Refuse to write two things to one file.

    Raises
    ------
    InputError
    """
    for number, name in enumerate(names):
        if Path(name).resolve() in [Path(other).resolve() for other in names[:number]]:
            raise InputError("is named twice", where=f"'{name}'", remedy="name each file once")


def positive(value: float | None, option: str) -> float | None:
    """The value, refused when it is not a finite number above zero.

    Raises
    ------
    InputError
    """
    if value is not None and not 0.0 < value < float("inf"):
        raise InputError(f"is {value}", where=option, remedy="give a number above zero")
    return value


def vector(text: str, what: str, example: str = "0,0,-9.81") -> tuple[float, float, float]:
    """Three finite numbers separated by commas, such as the example.

    Raises
    ------
    InputError
        Not three, or not finite.
    """
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"'{text}' is not X,Y,Z", where=what, remedy=f"write {example}") from error
    if len(values) != 3 or not all(abs(value) < float("inf") for value in values):
        raise InputError(
            f"'{text}' is not three finite numbers", where=what, remedy=f"write {example}"
        )
    return values[0], values[1], values[2]


def gravity_vector(text: str | None) -> tuple[float, float, float] | None:
    """Acceleration (3,) [m/s2] from ``--gravity``; ``None`` when it was not given.

    Raises
    ------
    InputError
        Neither one number above zero nor three that are not all zero.
    """
    if text is None:
        return None
    if "," in text:
        given = vector(text, "--gravity")
        if given == (0.0, 0.0, 0.0):
            raise InputError("is zero", where="--gravity", remedy="give a direction")
        return given
    try:
        size = float(text)
    except ValueError as error:
        raise InputError(
            f"'{text}' is neither a number nor X,Y,Z", where="--gravity", remedy="write 9.81"
        ) from error
    positive(size, "--gravity")
    return (0.0, 0.0, -size)
