"""Text from files, converted to one printable line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from drystone.base.errors import InputError

LONGEST = 300
"""Largest number of characters of one part of an error. Chosen: enough for a path and a name."""


def printable(text: str, limit: int = LONGEST) -> str:
    r"""Text without line ends and control characters, cut in the middle when it is too long.

    Examples
    --------
    >>> printable("red\x1b[31m\nblue")
    'red?[31m?blue'
    """
    shown = text if text.isprintable() else "".join(c if c.isprintable() else "?" for c in text)
    if len(shown) <= limit:
        return shown
    half = limit // 2 - 2
    return f"{shown[:half]}...{shown[-half:]}"


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Convert errors that quote a file to one printable line."""
    try:
        yield
    except InputError as error:
        parts = (error.what, error.where, error.remedy)
        clean = tuple(printable(part) for part in parts)
        if clean == parts:
            raise
        what, where, remedy = clean
        raise type(error)(what, where=where, remedy=remedy, kind=error.kind) from error
