"""Figures of matplotlib as files: PNG, SVG or PDF."""

from __future__ import annotations

import inspect
import warnings
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Protocol, TypeVar

from drystone.base.errors import FormatError
from drystone.base.files import write_whole

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

_SUFFIXES = ("png", "svg", "pdf")
_DPI = 150.0
"""Default of the pixels per inch of a PNG."""


_PARAMETERS = """

Parameters
----------
subject
    What is drawn.
path
    Its suffix says PNG, SVG or PDF. Written to a temporary name beside it and renamed. Left out,
    nothing is written.
title

Returns
-------
matplotlib.figure.Figure

Raises
------
FormatError
    Another suffix, or the file cannot be written.
"""

Subject = TypeVar("Subject", contravariant=True)


class _SavedPlot(Protocol[Subject]):
    """A function that draws something, and writes the figure if there is a path."""

    def __call__(
        self, subject: Subject, path: str | PathLike[str] | None = None, *, title: str = ""
    ) -> Figure: ...


def saved_plot(draw: Callable[[Subject, str], Figure]) -> _SavedPlot[Subject]:
    """A function that draws, as one that also writes its figure if there is a path."""

    def save(
        subject: Subject, path: str | PathLike[str] | None = None, *, title: str = ""
    ) -> Figure:
        return save_plot(path, lambda: draw(subject, title))

    for name in ("__module__", "__name__", "__qualname__"):
        setattr(save, name, getattr(draw, name))
    save.__doc__ = inspect.cleandoc(draw.__doc__ or "") + _PARAMETERS
    return save


def save_plot(
    path: str | PathLike[str] | None,
    draw: Callable[[], Figure],
    dpi: float = _DPI,
    what: str = "plot",
) -> Figure:
    """The figure that ``draw`` makes, written if there is a path.

    The suffix is checked first. The file is written to a temporary name and renamed.

    Raises
    ------
    FormatError
        Another suffix, or the file cannot be written.
    """
    if path is None:
        return draw()
    kind = Path(path).suffix.lower().lstrip(".")
    if kind not in _SUFFIXES:
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
