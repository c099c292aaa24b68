"""A drawing of matplotlib as a whole file, PNG, SVG or PDF."""

from __future__ import annotations

import warnings
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from drystone.base.errors import FormatError
from drystone.base.files import write_whole

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

SUFFIXES = ("png", "svg", "pdf")
DPI = 150.0
"""Pixels per inch of a PNG, unless another number is asked for."""


def save_plot(
    path: str | PathLike[str] | None,
    draw: Callable[[], Figure],
    dpi: float = DPI,
    what: str = "plot",
) -> Figure:
    """What ``draw`` makes, written once the suffix of the path is known to be PNG, SVG or PDF.

    Written to a temporary name beside the path and renamed; without a path nothing is written.

    Raises
    ------
    FormatError
        Another suffix, or the file cannot be written.
    """
    if path is None:
        return draw()
    kind = Path(path).suffix.lower().lstrip(".")
    if kind not in SUFFIXES:
        as_what = f"as '.{kind}'" if kind else "without a suffix"
        raise FormatError(
            f"a {what} cannot be written {as_what}",
            where=str(path),
            remedy="end the name in .png, .svg or .pdf",
        )
    drawing = draw()

    def fill(file: BinaryIO) -> None:
        with warnings.catch_warnings():
            # Characters that the font does not have are drawn as boxes; the figure is still valid.
            warnings.filterwarnings("ignore", message="Glyph .* missing from font")
            drawing.savefig(file, format=kind, dpi=dpi)

    write_whole(path, fill)
    return drawing


__all__ = ["save_plot"]
