"""Every error that drystone raises.

::

    DrystoneError
    ├── InputError (ValueError)            the model or an argument is wrong
    │   └── FormatError                    a file cannot be read or written: path, field
    ├── MissingDependency (ImportError)    an optional package is needed
    └── SolverError (RuntimeError)         a back end was called in a way that it cannot serve

A verdict is never an error: a structure that falls is an answer.
"""

from __future__ import annotations

import enum
import functools
import importlib.util
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

_LONGEST = 300
"""Characters of one part of an error that quotes a file. Chosen: enough for a path and a name."""

ODD = (TypeError, ValueError, AttributeError, LookupError, ArithmeticError)
"""The errors in which Python ends where an argument is of another type."""


def counted(number: int, one: str, many: str = "") -> str:
    """A number with its noun, for messages; ``many`` is the plural where it is not ``one`` + s.

    Examples
    --------
    >>> counted(1, "face"), counted(2, "face"), counted(0, "unused vertex", "unused vertices")
    ('1 face', '2 faces', '0 unused vertices')
    """
    return f"{number} {one if number == 1 else many or one + 's'}"


def meant(given: str, known: Iterable[str], otherwise: str = "") -> str:
    """Which known names a given one is like, for the remedy of an error.

    Without ``otherwise`` the first names are shown where none is like it.

    Examples
    --------
    >>> meant("blok-1", ["base", "block-1"]), meant("x", ["base", "block-1"])
    ('did you mean block-1?', 'names are like base, block-1')
    """
    import difflib  # only needed to word an error

    names = list(known)
    close = difflib.get_close_matches(given, names, n=3)
    if close:
        return f"did you mean {', '.join(close)}?"
    return otherwise or f"names are like {', '.join(names[:3])}"


def refuse_unknown(given: Iterable[str], known: Collection[str], who: str = "there is") -> None:
    """Raise InputError at the first name that is not known; the nearest one is told."""
    for name in given:
        if name not in known:
            remedy = meant(name, known) if known else "there are none"
            raise InputError(f"{who} no argument '{name}'", remedy=remedy)


def clean(text: str) -> str:
    """Text without line ends and control characters."""
    return text if text.isprintable() else "".join(c if c.isprintable() else "?" for c in text)


def printable(text: str, limit: int = _LONGEST) -> str:
    r"""Text without line ends and control characters, cut in the middle when it is too long.

    Examples
    --------
    >>> printable("red\x1b[31m\nblue")
    'red?[31m?blue'
    """
    shown = clean(text)
    if len(shown) <= limit:
        return shown
    half = limit // 2 - 2
    return f"{shown[:half]}...{shown[-half:]}"


def quoted(value: object, limit: int = 60) -> str:
    """A value as Python writes it, on one short line, for errors.

    Examples
    --------
    >>> quoted("a"), quoted(10**5000)
    ("'a'", '<int>')
    """
    try:
        return printable(" ".join(repr(value).split()), limit)
    except Exception:  # nested too deep, more digits than Python writes, or a fault of its own
        return f"<{type(value).__name__}>"


def _with_short_words(told: object) -> str:
    """As text, each word that is too long cut in the middle: it quotes what was given."""
    text = str(told)
    if len(text) <= _LONGEST:
        return text
    return " ".join(printable(word) if len(word) > _LONGEST else word for word in text.split(" "))


class DefectKind(enum.StrEnum):
    """Kinds of defects of the shape of a block that callers distinguish."""

    OPEN = "open mesh"
    CROWDED = "non-manifold"
    TWICE = "twice"
    TOUCHING = "touches itself"
    CROSSING = "crosses itself"


class DrystoneError(Exception):
    """Base of all errors raised on purpose by drystone."""

    def parts(self) -> dict[str, str]:
        """What is wrong, where and what to do, apart, for programs."""
        return {"what": str(self), "where": "", "remedy": ""}


class InputError(DrystoneError, ValueError):
    """A model or an argument that cannot be used.

    Parameters
    ----------
    what
        What is wrong, in one sentence without a final stop.
    where
        The block, face, interface or argument that is wrong.
    remedy
        What the user can do about it.
    kind
        Kind of fault, where a caller may have to tell it from others.
    """

    def __init__(
        self, what: str, *, where: str = "", remedy: str = "", kind: DefectKind | None = None
    ) -> None:
        self.what, self.where, self.remedy = map(_with_short_words, (what, where, remedy))
        self.kind = kind
        super().__init__(self.what, self.where, self.remedy)

    def __reduce__(self) -> tuple[Any, ...]:
        make = functools.partial(type(self), where=self.where, remedy=self.remedy, kind=self.kind)
        return make, (self.what,)

    def located(self, where: str, remedy: str | None = None) -> InputError:
        """The same error with its place, and optionally another remedy."""
        remedy = self.remedy if remedy is None else remedy
        return type(self)(self.what, where=where, remedy=remedy, kind=self.kind)

    def parts(self) -> dict[str, str]:
        """What is wrong, where and what to do, apart, for programs."""
        return {"what": self.what, "where": self.where, "remedy": self.remedy}

    def __str__(self) -> str:
        head = f"{self.where}: {self.what}" if self.where else self.what
        return f"{head}; {self.remedy}" if self.remedy else head


class FormatError(InputError):
    """A file that cannot be read or written in its format."""


class MissingDependency(DrystoneError, ImportError):
    """An optional package is needed.

    Parameters
    ----------
    package
        The package that cannot be imported.
    extra
        The extra of drystone that brings it.
    purpose
        What it is needed for.
    """

    def __init__(self, package: str, *, extra: str, purpose: str) -> None:
        self.package = package
        self.extra = extra
        self.purpose = purpose
        super().__init__(package, extra, purpose)

    def __reduce__(self) -> tuple[Any, ...]:
        make = functools.partial(type(self), extra=self.extra, purpose=self.purpose)
        return make, (self.package,)

    def __str__(self) -> str:
        install = f"pip install '.[{self.extra}]' in the folder of drystone"
        return f"{self.purpose} needs {self.package}; {install}"


def require(package: str, extra: str, purpose: str) -> None:
    """Refuse where an optional package is not installed.

    Raises
    ------
    MissingDependency
    """
    if importlib.util.find_spec(package) is None:
        raise MissingDependency(package, extra=extra, purpose=purpose)


class SolverError(DrystoneError, RuntimeError):
    """A numerical back end cannot process its input."""


@contextmanager
def located(where: str, remedy: str | None = None) -> Iterator[None]:
    """Errors inside are raised with this place; see :meth:`InputError.located`."""
    try:
        yield
    except InputError as error:
        raise error.located(where, remedy) from error


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Convert errors that quote a file to one printable line."""
    try:
        yield
    except InputError as error:
        parts = (error.what, error.where, error.remedy)
        shown = tuple(printable(part) for part in parts)
        if shown == parts:
            raise
        what, where, remedy = shown
        raise type(error)(what, where=where, remedy=remedy, kind=error.kind) from error
