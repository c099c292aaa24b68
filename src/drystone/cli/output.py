"""What the commands print: people read stdout, programs read one JSON object, errors are a line."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from drystone.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console


class UsageFault(InputError):
    """An option or argument that the command does not take."""


def say(text: str) -> None:
    """Print plain text."""
    print(text)


def clean(text: str) -> str:
    """Text without control characters: names come from files, and terminals obey them."""
    return "".join(c if c.isprintable() else "?" for c in text)


def safe(text: str) -> str:
    """Text from a file for printing with rich: neither control characters nor markup."""
    from rich.markup import escape  # slow to import

    return escape(clean(text))


def number(value: float) -> str:
    """A quantity of any size: one decimal where that says enough, else four digits."""
    if value == 0.0:
        return "0"
    return f"{value:,.1f}" if 1.0 <= abs(value) < 1e7 else f"{value:.4g}"


def vector(values: Sequence[float]) -> str:
    """Components, those that are only rounding told as 0."""
    largest = max(map(abs, values), default=0.0)
    return ", ".join(number(x if abs(x) > 1e-6 * largest else 0.0) for x in values)


def emit(data: dict[str, Any]) -> None:
    """Print one JSON object on stdout; what is not finite becomes null."""
    print(json.dumps(_finite(data), ensure_ascii=True, allow_nan=False))


def fail(error: BaseException, code: int, as_json: bool) -> int:
    """Print an error as one line on stderr, with --json as an object on stdout too."""
    message = clean(" ".join(str(error).split())) or type(error).__name__
    if code == 70:
        message = f"a fault in drystone, please report it: {type(error).__name__}: {message}"
    if as_json:
        told = {"type": type(error).__name__, "message": message}
        for part in ("what", "where", "remedy", "package", "extra"):
            if getattr(error, part, None):
                told[part] = getattr(error, part)
        try:
            emit({"error": told, "exit_code": code})
        except OSError:  # nobody reads stdout, or it is full: the line on stderr is left
            sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
    print(f"drystone: {message}", file=sys.stderr)
    return code


def console() -> Console:
    """Where a person reads the answer."""
    from rich.console import Console  # slow to import

    return Console(highlight=False, soft_wrap=True)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
