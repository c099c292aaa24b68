"""What annotations and documentation say of arguments, and which argument has another value."""

from __future__ import annotations

import collections.abc
import enum
import functools
import inspect
import operator
import os
import re
import sys
import types
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from numbers import Integral
from pathlib import Path
from typing import Any, Literal, Union, Unpack, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from drystone.base.errors import DrystoneError, InputError, quoted, refuse_unknown

_SECTIONS = ("Attributes", "Parameters")
_ROLE = re.compile(r":\w+:`~?([^`]*)`|`+([^`]*)`+")
"""Markup of a name in a docstring."""
_KIND = re.compile(
    r"(?:\([-\w, ]+\) )?(?:\[(?P<unit>[^]]*)\]|(?P<plain>coefficient))?"
    r"(?P<ends>(?:,? ?[<>]=? ?[-\d.einf]+)*)(?P<rest> ?(?<=\] ).*)?"
)
"""Of an entry, behind its name: shape, unit, range, and the beginning of its text."""
_END = re.compile(r"([<>]=?) ?([-\d.einf]+)")
_SIDES = {">=": operator.ge, ">": operator.gt, "<=": operator.le, "<": operator.lt}
_UNIONS = (types.UnionType, Union)
_ARRAYS = (np.ndarray, NDArray)  # since numpy 2.5 the second is a type of its own
_SEVERAL = {tuple, list, set, frozenset, collections.abc.Set, Sequence, Collection, Iterable}
_OURS = {*sys.stdlib_module_names, "numpy", "drystone"} - {"types", "unittest"}
"""Packages whose values are what they are; one of another may stand for a class, as a mesh does."""
_WORDS: dict[Any, str] = {
    float: "a number", int: "a whole number", bool: "True or False", str: "a text",
    Callable: "a function", Mapping: "a dictionary", os.PathLike: "a path", Path: "a path",
    np.ndarray: "numbers", NDArray: "numbers", types.NoneType: "None",
}  # fmt: skip


def kinds_of(hint: Any) -> list[Any]:
    """The types of a union, but for ``None`` and arrays, which are written as sequences."""
    parts = [one for one in _parts(hint) if one is not types.NoneType]
    return [one for one in parts if get_origin(one) not in _ARRAYS]


def is_many(kind: Any) -> bool:
    """Whether a type is that of several values."""
    return get_origin(kind) in (tuple, list, Sequence)


def fits(value: Any, hint: Any) -> bool:
    """Whether an annotation allows a value; True where that is for the function to tell.

    Examples
    --------
    >>> fits(np.int64(2), float | None), fits(True, float), fits(["a", 2], str | Sequence[str])
    (True, False, False)
    """
    own, inner = get_origin(hint) or hint, get_args(hint)
    if test := _TESTS.get(own):
        return test(value, inner)
    if not isinstance(own, type) or getattr(own, "_is_protocol", False):
        return True
    return isinstance(value, own) or _is_one_of(value, _values(own)) or _is_foreign(value)


def told(hint: Any) -> str:
    """What an annotation allows, in words.

    Examples
    --------
    >>> told(float | Sequence[str] | None), told(Literal["x", "y"])
    ('a number, a list of texts or None', "one of 'x', 'y'")
    """
    words = dict.fromkeys(map(_word, _parts(hint)))
    *first, last = [one for one in words if not (one.startswith("a list of") and "a list" in words)]
    return f"{', '.join(first)} or {last}" if first else last


def refuse_wrong(values: Iterable[tuple[str, Any]], hints: Mapping[str, Any]) -> None:
    """Refuse the first value that its annotation does not allow.

    Raises
    ------
    InputError
        There is one; it is named, with what is wanted.
    """
    for name, value in values:
        if name in hints and not fits(value, hints[name]):
            said, wanted = f"{name} is {quoted(value)}", told(hints[name])
            wanted += f" of {name}" if wanted == "a list" else ""
            raise InputError(said, remedy=f"give {wanted}")


def blame(
    function: Callable[..., Any], given: Any, named: Mapping[str, Any], error: Exception
) -> None:
    """Where a call ended in an error of Python, refuse the argument that is wrong, if one is.

    Raises
    ------
    InputError
        There is no argument of a name, or one has a value that its annotation does not allow.
    """
    if isinstance(error, DrystoneError):
        return
    known = inspect.signature(function).parameters
    if not any(one.kind is one.VAR_KEYWORD for one in known.values()):
        refuse_unknown(named, [*(known.keys() - {"self", "cls"})], f"{function.__qualname__} has")
    refuse_wrong((*zip(known, given, strict=False), *named.items()), hints_of(function))


@functools.cache
def hints_of(function: Any) -> dict[str, Any]:
    """The annotation of each argument, with those of a dictionary of them as ``**how``."""
    found: dict[str, Any] = {}
    for name, one in inspect.signature(function).parameters.items():
        hint = hint_of(function, one)
        if get_origin(hint) is Unpack:
            found |= get_type_hints(get_args(hint)[0])
        elif one.annotation is not one.empty:
            found[name] = Union[hint, None] if one.default is None else hint  # noqa: UP007
    return found


@functools.cache
def documented(of: Any) -> dict[str, dict[str, Any]]:
    """Of each attribute or parameter the text, the unit and the ends of its range.

    Those of a class are known by what is made of it.

    Examples
    --------
    >>> from drystone.limits import LimitOptions
    >>> documented(LimitOptions)["width"]["ends"]
    {'>': 0.0, '<': inf}

    Raises
    ------
    InputError
        Python has no docstrings.
    """
    if sys.flags.optimize > 1:
        why = "python -OO takes the docstrings away, by which options are checked"
        raise InputError(why, remedy="python -O keeps them")
    known: dict[str, dict[str, Any]] = {}
    for one in reversed(of.__mro__) if isinstance(of, type) else (of,):
        known |= dict(_entries(inspect.getdoc(one) or ""))
    return known


def beyond(value: float | np.number[Any], ends: Mapping[str, float]) -> str:
    """What to give in place of a number that is on the wrong side of an end; empty where it is not.

    Examples
    --------
    >>> beyond(0, {">=": 1.0}), beyond(2.0, {">": 0.0, "<=": 1.0}), beyond(1, {">=": 1.0})
    ('give 1 or more', 'give a number above zero, up to 1', '')
    """
    if all(_SIDES[sign](value, end) for sign, end in ends.items()):
        return ""
    words = {">=": "{} or more", ">": "a number above {}", "<=": "up to {}", "<": "below {}"}
    said = [words[sign].format("zero" if sign == ">" and end == 0.0 else f"{end:g}")
            for sign, end in ends.items() if np.isfinite(end)]  # fmt: skip
    return "give a finite number" if value == np.inf else f"give {', '.join(said)}"


def left_out(hint: Any) -> Any:
    """What a keyword of a dictionary is when it is left out."""
    kinds = [get_origin(one) or one for one in _parts(hint)]
    if types.NoneType in kinds:
        return None
    if Literal in kinds:
        return get_args(hint)[0]
    return {bool: False, float: np.inf}.get(hint, ())


def hint_of(function: Any, one: inspect.Parameter) -> Any:
    """The annotation of an argument; Any where it is known to a type checker only."""
    homes = reversed(function.__mro__) if isinstance(function, type) else (function,)
    place: dict[str, Any] = {}
    for home in homes:
        place |= getattr(sys.modules.get(home.__module__), "__dict__", {})  # none of exec
    asked = types.SimpleNamespace(__annotations__={one.name: one.annotation})
    try:
        return get_type_hints(asked, place)[one.name]
    except NameError:
        return Any


def unmarked(text: str) -> str:
    """A text without the markup of names."""
    return _ROLE.sub(lambda found: (found[1] or found[2]).removeprefix("drystone."), text)


def _entries(text: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Name, and text, unit and range, of each entry with an attribute or a parameter."""
    names: list[str] = []
    more: dict[str, Any] = {}
    told: list[str] = []
    inside = False
    for line, below in pairwise([*text.splitlines(), ""]):
        if below.startswith("---"):
            inside = line in _SECTIONS
        elif inside and line and not line.startswith((" ", "-")):
            yield from ((name, {**more, "text": _plain(told)}) for name in names)
            head, _, kind = line.partition(" : ")
            names = [name.strip() for name in head.split(",")]
            found = _KIND.match(kind)
            more, told = {}, []
            if found:
                ends = {sign: float(end) for sign, end in _END.findall(found["ends"])}
                more = {"unit": found["unit"] or found["plain"] or "", "ends": ends}
                told = [(found["rest"] or "").strip()]
        elif inside:
            told.append(line.strip())
    yield from ((name, {**more, "text": _plain(told)}) for name in names)


def _plain(lines: Sequence[str]) -> str:
    """The lines as one text without markup."""
    return unmarked(" ".join(line for line in lines if line))


def _parts(hint: Any) -> tuple[Any, ...]:
    return get_args(hint) if get_origin(hint) in _UNIONS else (hint,)


def _word(hint: Any) -> str:
    """One of the types that an annotation allows, in words."""
    own, inner = get_origin(hint) or hint, get_args(hint)
    choices = inner if own is Literal else _values(own)
    if choices:
        return f"one of {', '.join(map(repr, choices))}"
    if own not in _SEVERAL:
        return _WORDS.get(own) or f"{getattr(own, '__name__', own)}(...)"
    words = told(inner[0]).removeprefix("a ") if len({*inner} - {...}) == 1 else ""
    return "a list" if not words or "(" in words or " " in words else f"a list of {words}s"


def _values(kind: Any) -> list[Any]:
    """The values of an enumeration; none of another type."""
    members = kind if isinstance(kind, type) and issubclass(kind, enum.Enum) else ()
    return [one.value for one in members]


def _is_foreign(value: Any) -> bool:
    return type(value).__module__.partition(".")[0] not in _OURS


def _is_one_of(value: Any, choices: Collection[Any]) -> bool:
    return isinstance(value, str | int | enum.Enum) and value in choices


def _is_number(value: Any, _: Any) -> bool:
    """Whether a value is a single number; truth values and texts are none."""
    if isinstance(value, str | bytes | bool | np.bool_ | np.complexfloating):
        return False
    return _made(float, value) is not None


def _are_numbers(value: Any, _: Any) -> bool:
    """Whether numpy takes a value for numbers."""
    made = _made(np.asarray, value)
    return made is not None and made.dtype.kind in "biuf"


def _made(make: Callable[[Any], Any], value: Any) -> Any:
    """What is made of a value; None where it ends in an error."""
    try:
        return make(value)
    except (TypeError, ValueError, OverflowError):
        return None


def _are_several(value: Any, inner: Collection[Any]) -> bool:
    """Whether a value is no text and has several, each of one of some types."""
    if isinstance(value, str | bytes) or not np.iterable(value):
        return False
    kinds = [one for one in inner if one is not Ellipsis]
    listed = value if kinds and hasattr(value, "__len__") else ()
    return all(any(fits(one, kind) for kind in kinds) for one in listed)


def _are_in_order(value: Any, inner: Sequence[Any]) -> bool:
    return not isinstance(value, Mapping) and _are_several(value, inner)


def _are_named(value: Any, inner: Sequence[Any]) -> bool:
    """Whether a value has names, all of a type."""
    named = isinstance(value, Mapping)
    return _is_foreign(value) or (named and _are_several([*value], inner[:1]))


_TESTS: dict[Any, Callable[[Any, Any], bool]] = {
    Any: lambda *_: True,
    float: _is_number,
    int: lambda value, _: isinstance(value, Integral) and not isinstance(value, bool),
    bool: lambda value, _: isinstance(value, bool | np.bool_),
    Callable: lambda value, _: callable(value),
    Literal: _is_one_of,
    Mapping: _are_named,
    **dict.fromkeys(_ARRAYS, _are_numbers),
    **dict.fromkeys(_UNIONS, lambda value, of: any(fits(value, one) for one in of)),
    **dict.fromkeys(_SEVERAL, _are_several),
    Iterable: lambda value, _: _are_several(value, ()),
    **dict.fromkeys((tuple, list, Sequence), _are_in_order),
}
"""Whether a value is of a type with types inside it, where the type itself does not tell."""
