"""Output of the commands: text for people, one JSON object for programs, errors in one line."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Sequence
from typing import Any, TextIO

from drystone.base.display import named, shown_of
from drystone.base.errors import InputError, MissingDependency, clean

BAD_INPUT, MISSING, FAULT, INTERRUPTED, CLOSED = 2, 3, 70, 130, 141
"""Exit codes of errors, and after Ctrl-C; the last one where nobody reads stdout, as where SIGPIPE
ends a program."""
PIPED = 120
"""Letters of a line of a table that is read from a pipe or a file."""
LISTED = 20
"""Rows of a table that are printed; --json has all."""


class UsageFault(InputError):
    """An option or argument that the command does not take."""


class Screen:
    """Prints for people.

    Control characters are removed from every text, because names come from files.
    """

    def __init__(self) -> None:
        from rich.console import Console  # slow to import

        width = None if sys.stdout.isatty() or "COLUMNS" in os.environ else PIPED
        self._console = Console(width=width, highlight=False, soft_wrap=True)

    def line(self, text: str, head: str = "", style: str = "bold", gap: str = "  ") -> None:
        """A line, with a coloured word before it."""
        from rich.text import Text

        made = Text(clean(head), style) if head else Text()
        made.append(f"{gap if head and text else ''}{clean(text)}", "default")
        self._console.print(made)

    def note(self, text: str) -> None:
        """A remark."""
        self.line(text, "note:", "yellow", " ")

    def dim(self, text: str) -> None:
        """A line in a dim colour."""
        if text:
            self.line("", text, "dim")

    def table(
        self,
        head: Sequence[str],
        rows: Sequence[Sequence[str]],
        listed: int = LISTED,
    ) -> None:
        """The first rows of a table, and the number of the others."""
        from rich.cells import cell_len
        from rich.table import Table
        from rich.text import Text

        listed = shown_of(len(rows), listed)
        shown = [[clean(cell) for cell in row] for row in rows[:listed]]
        columns = [[name, *cells] for name, *cells in zip(head, *shown, strict=True)]

        def longest(texts: Sequence[str]) -> int:
            return max(map(cell_len, texts), default=0)

        bare = [longest(" ".join(cells).split()) for _, *cells in columns]
        words = [longest(" ".join(one).split()) for one in columns]
        gap = 1 if sum(words) + 2 * len(words) > self._console.width else 2
        # headings are broken first, then folded, then the longest sentence
        wide = bare if sum(words) + gap * len(words) > self._console.width else words
        room = self._console.width - sum(wide) - gap * len(wide)
        fits = room >= 0
        for goal in (words, [longest(one[1:]) for one in columns], [*map(longest, columns)]):
            for i in sorted(range(len(goal)), key=lambda i: goal[i] - wide[i]):
                more = max(min(goal[i] - wide[i], room), 0)
                wide[i], room = wide[i] + more, room - more
        made = Table(box=None, pad_edge=gap == 2, padding=(0, 1) if gap == 2 else (0, 1, 0, 0))
        for one, width in zip(head, wide, strict=True):
            made.add_column(Text(one), overflow="fold", width=width if fits else None)
        for row in shown:
            made.add_row(*map(Text, row))
        if rows:
            self._console.print(made)
        if len(rows) > listed:
            self.dim(f"and {len(rows) - listed} more (--json lists all)")


def grouped(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Rows that differ only in their first cell become one, in the order of their first.

    Examples
    --------
    >>> grouped([["a", "1"], ["b", "2"], ["c", "1"]])
    [['a, c', '1'], ['b', '2']]
    """
    names: dict[tuple[str, ...], list[str]] = {}
    for first, *others in rows:
        names.setdefault(tuple(others), []).append(first)
    return [[named(firsts), *others] for others, firsts in names.items()]


def say(text: str) -> None:
    """Print plain text."""
    print(text)


def emit(data: dict[str, Any]) -> None:
    """Print one JSON object on stdout; numbers that are not finite become null."""
    print(json.dumps(_finite(data), ensure_ascii=True, allow_nan=False))


def code_of(error: BaseException) -> int:
    """The exit code of an error of the user or of the environment."""
    return MISSING if isinstance(error, MissingDependency) else BAD_INPUT


def nowhere() -> TextIO:
    """In place of a stream that is closed or full; Python writes to it once more when it exits."""
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123


def fail(error: BaseException, code: int, as_json: bool, data: dict[str, Any] | None = None) -> int:
    """Print an error as one line on stderr, and with --json as an object on stdout too.

    ``data`` is the answer, if there is one.
    """
    message = clean(" ".join(str(error).split())) or type(error).__name__
    if code == FAULT:
        message = f"a fault in drystone, please report it: {type(error).__name__}: {message}"
    if as_json:
        told = {"type": type(error).__name__, "message": message}
        for part in ("what", "where", "remedy", "package", "extra"):
            if getattr(error, part, None):
                told[part] = getattr(error, part)
        try:
            emit({**(data or {}), "error": told, "exit_code": code})
        except OSError:  # stdout is closed or full: the line on stderr remains
            sys.stdout = nowhere()
    try:
        print(f"drystone: {message}", file=sys.stderr, flush=True)
    except OSError:  # closed or full: the exit code remains
        sys.stderr = nowhere()
    return code


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
