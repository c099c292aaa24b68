"""Display of values: as one line, and as a card in a notebook."""

from __future__ import annotations

import dataclasses
import enum
import functools
import html
import inspect
import reprlib
from collections.abc import Callable, Mapping, Sequence
from decimal import ROUND_CEILING, Context
from typing import Any, Self

from drystone.base.errors import ODD, refuse_unknown

_LONGEST = 180
"""Largest number of characters of the line. Chosen: at most two lines on a wide terminal."""
NAME = 60
"""Largest number of characters of a name in a sentence or a table. Chosen: half a line."""
FEW_NAMES = 3
"""Names of equal things that are said; of more, how many there are."""


class OneLine:
    """A value whose ``repr`` is one line: its class, and the text of :meth:`_summary`.

    A dataclass that inherits from it keeps this ``repr``. It and its public methods refuse
    arguments that they do not know, with the nearest one.
    """

    def __new__(cls, *_: Any, **named: Any) -> Self:
        """A new value; all arguments that are named are known."""
        if named and (known := _arguments(cls.__init__)) is not None:
            refuse_unknown(named, known, f"{cls.__name__} has")
        return object.__new__(cls)

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        for name, one in [*vars(cls).items()]:
            call = getattr(one, "__func__", one)
            public = name[0] != "_" or name in ("__init__", "__post_init__")
            if (
                public
                and inspect.isfunction(call)
                and call.__qualname__ == f"{cls.__qualname__}.{name}"
            ):
                asked = _knowing(call)
                type.__setattr__(cls, name, asked if one is call else type(one)(asked))
        if "__repr__" not in cls.__dict__:
            # in the class itself: the dataclass decorator comes later and keeps what it finds there
            type.__setattr__(cls, "__repr__", OneLine.__repr__)

    def __repr__(self) -> str:
        return shortened(f"{type(self).__name__}({self._summary()})", end="...)")

    def _summary(self) -> str:
        """The text between the brackets: the fields that differ from their defaults."""
        return ", ".join(f"{name}={text}" for name, text in differing(self, code=True).items())


@functools.cache
def _arguments(method: Callable[..., Any]) -> tuple[str, ...] | None:
    """The names of all arguments of a method but the first; None if it takes any."""
    known = inspect.signature(method).parameters
    any_name = any(one.kind is one.VAR_KEYWORD for one in known.values())
    return None if any_name else (*known,)[1:]


def _knowing(method: Callable[..., Any]) -> Callable[..., Any]:
    """A method that names the argument that it does not know, or that made it end in an error."""
    if method.__name__ == "__post_init__":

        @functools.wraps(method)
        def made(self: Any, *given: Any) -> None:
            try:
                method(self, *given)
            except ODD as error:
                from drystone.base.hints import blame, hints_of

                kind: Any = type(self)
                blame(kind, (), {name: getattr(self, name) for name in hints_of(kind)}, error)
                raise

        return made

    @functools.wraps(method)
    def asked(*given: Any, **named: Any) -> Any:
        try:
            return method(*given, **named)
        except ODD as error:
            from drystone.base.hints import blame  # numpy is not needed before

            blame(method, given, named, error)
            raise

    return asked


class Card(OneLine):
    """A value that a notebook shows as a small card: a sentence, numbers and a picture."""

    def _facts(self) -> tuple[str, Mapping[str, object]]:
        """A sentence, and the entries of the table below it, by name; empty ones are omitted."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        sentence, facts = self._facts()
        rows = "".join(
            f'<tr><td style="text-align:left;opacity:.7">{html.escape(name)}</td>'
            f'<td style="text-align:left">{html.escape(shortened(str(value)))}</td></tr>'
            for name, value in facts.items()
            if str(value)
        )
        return (
            '<div style="display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start">'
            '<div style="max-width:min(28em,100%);overflow:auto;overflow-wrap:anywhere">'
            f"<b>{type(self).__name__}</b><div>{html.escape(sentence)}</div><table>{rows}</table></div>"
            f"{picture_of(self)}</div>"
        )


def picture_of(value: object) -> str:
    """A small picture of a value as HTML; empty if no function was set."""
    return "".join(draw(value) for draw in _DRAWN_BY)


def differing(value: Any, *, code: bool = False) -> dict[str, str]:
    """The fields of a dataclass that differ from their defaults, as short text, or as code."""
    told = {}
    for field in dataclasses.fields(value):
        one = getattr(value, field.name)
        default = (
            field.default
            if field.default_factory is dataclasses.MISSING
            else field.default_factory()
        )
        if field.repr and not (one is default or _plainly_equal(one, default)):
            told[field.name] = _SHORT.repr(one) if code else _words(one)
    return told


def _words(value: Any, between: str = ", ") -> str:
    """A value as text: of several the first, and how many more there are."""
    if isinstance(value, enum.Enum):
        return str(value.value)
    if isinstance(value, list | tuple):
        most = _SHORT.maxlist
        rest = f" and {len(value) - most} more" if len(value) > most else ""
        return between.join(_words(one, ":") for one in value[:most]) + rest
    return shortened(value, NAME) if isinstance(value, str) else _SHORT.repr(value)


def draw_with(draw: Callable[[object], str]) -> None:
    """Make the pictures of values with a function from a value to HTML."""
    _DRAWN_BY[:] = [draw]


def shortened(text: str, longest: int = _LONGEST, end: str = "...") -> str:
    """The text on one line; if it is too long, ``end`` replaces the rest."""
    line = " ".join(text.split())
    return line if len(line) <= longest else line[: longest - len(end)] + end


def name_text(name: str) -> str:
    """A name as HTML; letters that turn the direction of writing end with it."""
    return f"<bdi>{html.escape(shortened(name, NAME))}</bdi>"


def named(names: Sequence[str], most: int = FEW_NAMES) -> str:
    """The names, or the first ones and how many more there are, where all are too long.

    Examples
    --------
    >>> named(["a", "b", "c", "d", "e"])
    'a, b, c, d, e'
    >>> named(["a long name of a block"] * 5, 2)
    'a long name of a block, a long name of a block and 3 more'
    """
    if len(whole := ", ".join(names)) <= NAME:
        return whole
    rest = len(names) - most
    return ", ".join(shortened(one, NAME) for one in names[:most]) + (
        f" and {rest} more" if rest > 0 else ""
    )


def shown_of(count: int, most: int) -> int:
    """How many of several lines or rows are shown: the first ones, or all where one is left.

    Examples
    --------
    >>> shown_of(21, 20), shown_of(22, 20)
    (21, 20)
    """
    return most + (count == most + 1)


def first_of(
    lines: Sequence[str], more: str = "more like this", most: int = FEW_NAMES
) -> list[str]:
    """The first of several lines of one kind, and how many more there are."""
    most = shown_of(len(lines), most)
    rest = len(lines) - most
    return [*lines[:most], *([f"and {rest} {more}"] if rest > 0 else [])]


BOUND = 4
"""Digits of a bound that is told, wherever it stands: title, table, chart or report."""


def digits_apart(*values: float) -> int:
    """Digits of bounds, or as many more as tell values apart, up to nine.

    Examples
    --------
    >>> digits_apart(1.81622, 1.81649), digits_apart(1.2, 1.3)
    (5, 4)
    """
    digits = BOUND
    while digits < 9 and len({f"{one:.{digits}g}" for one in values}) < len(values):
        digits += 1
    return digits


def rounded_up(value: float, digits: int = BOUND) -> float:
    """The least number of so many digits that is not below a value: told, it is enough.

    What arithmetic leaves behind the twelfth digit does not count.

    Examples
    --------
    >>> rounded_up(1.20001), rounded_up(86.01, 3), rounded_up(0.5), rounded_up(-1.239, 3)
    (1.201, 86.1, 0.5, -1.23)
    """
    return float(Context(digits, ROUND_CEILING).create_decimal(f"{value:.12g}"))


def rounded_down(value: float, digits: int = BOUND) -> float:
    """The largest number of so many digits that is not above a value; as :func:`rounded_up`.

    Examples
    --------
    >>> rounded_down(1.4419), rounded_down(0.3 - 0.1)
    (1.441, 0.2)
    """
    return 0.0 - rounded_up(-value, digits)


def _plainly_equal(value: object, default: object) -> bool:
    """Whether a value equals a default that is no array; a list without entries is as a tuple."""
    if isinstance(value, list | tuple) and isinstance(default, list | tuple) and not value:
        return not default
    return type(value) is type(default) and not hasattr(value, "shape") and value == default


class _Short(reprlib.Repr):
    """Values inside a line: arrays by their shape, long ones by their beginning."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel, self.maxstring, self.maxother = 2, 80, 80
        self.maxtuple = self.maxlist = 4

    def repr_float(self, x: float, level: int) -> str:  # noqa: ARG002
        return f"{x:.6g}"

    def repr1(self, x: Any, level: int) -> str:
        if isinstance(x, enum.Enum):
            return f"{type(x).__name__}.{x.name}"
        if callable(x) and hasattr(x, "__name__"):
            return str(x.__name__)
        if hasattr(x, "shape") and hasattr(x, "tolist"):
            return repr(x.tolist()) if 1 <= x.size <= 3 else f"<array {x.shape}>"
        if isinstance(x, Mapping):
            return self.repr_dict(dict(x), level)
        return super().repr1(x, level)


_SHORT = _Short()
_DRAWN_BY: list[Callable[[object], str]] = []
"""The function that makes pictures, set by the package: this layer does not import drawing."""
