"""Description of a file format: name, suffixes, reader and writer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from drystone.base.display import OneLine
from drystone.io.draft import Contents, Draft


@dataclass(frozen=True)
class Format(OneLine):
    """A file format.

    Attributes
    ----------
    name
        Identifier.
    title
        Name for display.
    suffixes
        Lower case, with the dot.
    read
        ``read(data, path)`` makes a draft from the bytes of a file; the path serves errors and
        files in the same folder. ``None`` if the format is only written.
    write
        ``write(model, path)``; ``None`` if it is only read.
    loses
        The parts of a model that the format cannot hold, as text; empty if it holds everything.
    axes_unknown
        Whether files do not define the vertical axis.
    layers
        Whether it has layers; ``read`` then takes ``layers`` and ``hidden`` too.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    read: Callable[..., Draft] | None = None
    write: Callable[[Contents, Path], None] | None = None
    loses: str = ""
    axes_unknown: bool = False
    layers: bool = False
