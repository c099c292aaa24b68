"""What a file format is to the rest: a name, suffixes, a reader and a writer."""

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
        By which it is asked for.
    title
        For people.
    suffixes
        Lower case, with the dot.
    read
        ``read(data, path)``, the draft of a file's bytes; the path is for errors and for files
        beside it. ``None`` when the format is only written.
    write
        ``write(model, path)``; ``None`` when it is only read.
    loses
        What of a model the format has no place for, in words; empty when it keeps everything.
    axes_unknown
        Whether files do not say which axis points up.
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
