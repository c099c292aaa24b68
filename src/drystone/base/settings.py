"""Options with checked fields, and functions with checked calls."""

from __future__ import annotations

import dataclasses
import enum
import functools
import inspect
import sys
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, ParamSpec, Self, TypeVar

from drystone.base.arrays import number, of_type, whole
from drystone.base.display import OneLine, shortened
from drystone.base.errors import InputError, counted, refuse_unknown
from drystone.base.progress import check_keywords, with_keywords

P = ParamSpec("P")
R = TypeVar("R")
E = TypeVar("E", bound=enum.Enum)


class Options(OneLine):
    """Base of all options: a frozen dataclass that checks the types of its fields.

    Whole numbers, numbers, truth values, members of an enumeration (or their values) and other
    options are checked. What else a field may hold, and the range of numbers, is for each class.

    Raises
    ------
    InputError
        A field is of another type, or there is none of that name; it is named.
    """

    def __post_init__(self) -> None:
        for name, (kind, optional) in _kinds(type(self)).items():  # type: ignore[arg-type]
            value = getattr(self, name)
            if not (optional and value is None):
                object.__setattr__(self, name, _checked(value, kind, name))

    def _refuse_below(self, least: float, *names: str) -> None:
        """Refuse fields that hold a number below ``least``."""
        for name in names:
            value = getattr(self, name)
            if value is not None and not value >= least:
                raise InputError(f"{name} is {value:g}", remedy=f"give {least:g} or more")

    def _refuse_unless_positive(self, *names: str) -> None:
        """Refuse fields that do not hold a number above zero."""
        for name in names:
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise InputError(f"{name} is {value:g}", remedy="give a number above zero")

    @classmethod
    def of(cls, given: Self | None) -> Self:
        """The given options; the defaults if None.

        Raises
        ------
        InputError
            It is something else.
        """
        return cls() if given is None else of_type(given, cls, "options")


@functools.cache
def _kinds(cls: Any) -> dict[str, tuple[type, bool]]:
    """The type of each field that can be checked, and whether None is one of its values."""
    found = {}
    hints = typing.get_type_hints(cls)
    for field in dataclasses.fields(cls):
        hint = hints[field.name]
        parts = typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)
        kinds = [part for part in parts if part is not types.NoneType]
        if len(kinds) == 1 and isinstance(kinds[0], type) and _is_checked(kinds[0]):
            found[field.name] = kinds[0], len(kinds) < len(parts)
    return found


def _is_checked(kind: type) -> bool:
    return kind in (int, float, bool) or issubclass(kind, enum.Enum | Options)


def _checked(value: Any, kind: type, name: str) -> Any:
    if kind is int:
        return whole(value, name)
    if kind is float:
        return number(value, name, finite=False)
    if issubclass(kind, enum.Enum):
        return member_of(kind, value, name)
    return of_type(value, kind, name, "give True or False" if kind is bool else "")


def member_of(kind: type[E], value: Any, name: str) -> E:
    """The member of an enumeration, or of that value; else InputError."""
    try:
        return kind(value)
    except ValueError as error:
        known = ", ".join(f"'{one.value}'" for one in kind)
        said = shortened(repr(value), 60)
        raise InputError(f"{name} is {said}", remedy=f"give one of {known}") from error


def checked_call(function: Callable[P, R]) -> Callable[P, R]:
    """A public function that refuses wrong arguments with a message.

    These are more arguments by position than it has, an unknown keyword, a field of its
    ``options`` that is given by itself, and a ``progress``, ``stop``, ``check``, ``executor`` or
    ``time_limit_s`` that is none. The keywords of long calculations are added to its documentation.
    """
    known = inspect.signature(function).parameters
    most = sum(one.kind is one.POSITIONAL_OR_KEYWORD for one in known.values())
    own = {name for name, one in known.items() if one.kind is not one.VAR_KEYWORD}
    may_be_none = {name for name, one in known.items() if one.default is None}

    @functools.wraps(function)
    def asked(*given: P.args, **named: P.kwargs) -> R:
        if len(given) > most:
            raise InputError(
                f"{function.__name__} takes {counted(most, 'argument')} by position, "
                f"got {len(given)}",
                remedy="name all others; blocks, contacts and load together are a "
                "Model(assembly, contacts, load)",
            )
        check_keywords(named, may_be_none)
        if not named.keys() <= own:
            _refuse_unknown(function, named)
        return function(*given, **named)

    asked.__doc__ = with_keywords(function.__doc__, known)
    return asked


def _refuse_unknown(function: Callable[..., Any], named: Mapping[str, Any]) -> None:
    """Refuse keywords that a function does not have, also those that belong into its options."""
    known, options = _keywords(function)
    for name in named.keys() - known:
        is_field = name in getattr(options, "__dataclass_fields__", {})
        if is_field or isinstance(vars(options).get(name), classmethod):
            given = f"({name}=...)" if is_field else f".{name}()"
            raise InputError(
                f"'{name}' is no argument of {function.__name__}, but of its options",
                remedy=f"give options={options.__name__}{given}",
            )
    refuse_unknown(named, known, f"{function.__qualname__.removesuffix('.__init__')} has")


@functools.cache
def _keywords(function: Callable[..., Any]) -> tuple[tuple[str, ...], type]:
    """The keywords of a function, with those of a dictionary of them; its class of options."""
    known = inspect.signature(function).parameters
    told = {name: one.annotation for name, one in known.items() if name in ("options", "how")}
    place = vars(sys.modules[function.__module__])
    hints = typing.get_type_hints(types.SimpleNamespace(__annotations__=told), place)
    asked = hints.get("options", object)
    options = next(one for one in typing.get_args(asked) or (asked,) if one is not types.NoneType)
    if typing.get_origin(how := hints.get("how")) is typing.Unpack:
        (more,) = typing.get_args(how)
        return (*[name for name in known if name != "how"], *more.__annotations__), options
    return tuple(known), options
