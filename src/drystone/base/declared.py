"""Options as their documentation declares them: text, unit, type and default.

The command line, the JSON interface and the tools for programs are made of these declarations, so
an option is said once, beside its analysis.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import inspect
import math
import re
import types
import typing
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args, get_origin

from drystone.base import units
from drystone.base.arrays import number, of_type, refuse_many, whole
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.hints import beyond, documented, hints_of, is_many, kinds_of, unmarked
from drystone.base.settings import Options

_ONLY_PYTHON = re.compile(r" (In Python|See) .*|; see (?:[^;.]|\.(?=\w))*")
"""What a docstring says to those who write Python."""
_BOUND = {
    ">=": "minimum", ">": "exclusiveMinimum", "<=": "maximum", "<": "exclusiveMaximum",
}  # fmt: skip
"""Keywords of a JSON schema."""
COEFFICIENT = "coefficient"
"""In place of a unit: of a friction coefficient, which may be written as an angle."""


@dataclass(frozen=True)
class Declared(OneLine):
    """One option.

    Attributes
    ----------
    name
    text
        What it is, from the documentation.
    unit
        Of its value; empty where there is none.
    hint
        Its type.
    default
        ``inspect.Parameter.empty`` where it must be given.
    ends
        Its value is on that side of each of these numbers, such as ``{">=": 0.0}``.
    """

    name: str
    hint: Any
    default: Any
    text: str = ""
    unit: str = ""
    ends: Mapping[str, float] = field(default_factory=dict)

    @property
    def kinds(self) -> list[Any]:
        """The types that its value may have; see :func:`drystone.base.hints.kinds_of`."""
        return kinds_of(self.hint)

    @property
    def several(self) -> bool:
        """Whether it takes several words."""
        return any(
            hasattr(kind, "of_words")
            or (is_many(kind) and not {int, float} >= {*kinds_of(get_args(kind)[0])})
            for kind in self.kinds
        )

    @property
    def choices(self) -> tuple[str, ...]:
        """The words from which one is chosen; empty where others are possible."""
        found: list[str] = []
        for kind in self.kinds:
            for inner in kinds_of(get_args(kind)[0]) if is_many(kind) else [kind]:
                if get_origin(inner) is Literal:
                    found += map(str, get_args(inner))
                elif isinstance(inner, type) and issubclass(inner, enum.Enum):
                    found += [str(one.value).replace(" ", "-") for one in inner]
        return tuple(found)

    def told(self) -> str:
        """The text with the unit and the default."""
        default = self.default
        if isinstance(default, enum.Enum):
            default = default.value
        plain = isinstance(default, int | float | str) and not isinstance(default, bool)
        known = plain and default != "" and default not in (math.inf, -math.inf)
        shown = (f"{default:g}" if isinstance(default, float) else str(default)) if known else ""
        unit = "" if self.unit == COEFFICIENT else self.unit
        more = " ".join(one for one in (shown, unit) if one)
        text = _ONLY_PYTHON.sub("", self.text.removeprefix("Whether to "))
        text = text[:1].upper() + text[1:]
        if more and text.endswith(")."):
            return f"{text[:-2]} {more})."
        return f"{text.rstrip('.')} ({more})." if more else text

    @property
    def schema(self) -> dict[str, Any]:
        """Its values as a JSON schema."""
        kinds = [one for one in map(_schema, self.kinds) if one]
        if self.unit == COEFFICIENT:
            kinds.append({"type": "string"})
        kind = {"anyOf": kinds} if len(kinds) > 1 else kinds[0] if kinds else {}
        bounds = {_BOUND[sign]: end for sign, end in self.ends.items() if math.isfinite(end)}
        return {"description": self.told(), **kind, **bounds}

    def value(self, given: Any) -> Any:
        """The value of what was given: a text, or a value of JSON.

        Raises
        ------
        InputError
            It cannot be read; ``where`` is the name of the option.
        """
        try:
            value = value_of(given, self.hint, self.unit)
        except InputError as error:
            raise error.located(error.where or self.name) from error
        if isinstance(value, int):
            refuse_many(value, self.name)
        if isinstance(value, int | float) and (remedy := beyond(value, self.ends)):
            raise InputError(f"is {given}", where=self.name, remedy=remedy)
        return value


@dataclass(frozen=True)
class Offered(OneLine):
    """An analysis of a model, as the command line and other programs offer it.

    What it takes by position behind the model is an argument; its keywords, and the fields of its
    ``options``, are options.

    Attributes
    ----------
    analysis
    example
        What stands behind the name of its command in an example.
    shown
        Options that the help shows; others are shown by ``--help-all``.
    writes
        What its answer can write beside pictures: ``joints``, a ``model``, that of a ``train``
        and a film, or nothing.
    names
        Options that are offered, such as ``options.scan``; all when left out.
    """

    analysis: Callable[..., Any]
    example: str = ""
    shown: tuple[str, ...] = ()
    writes: Literal["", "joints", "model", "train"] = ""
    names: tuple[str, ...] | None = None

    @property
    def options(self) -> Sequence[str]:
        """What may be chosen beside the model; see :func:`options_of`."""
        return options_of(self.analysis) if self.names is None else self.names

    @property
    def text(self) -> str:
        """What it answers, for whoever chooses one."""
        text = inspect.getdoc(self.analysis) or ""
        return _ONLY_PYTHON.sub("", unmarked(re.split(r"\n\w+\n---", text)[0].strip()))

    @property
    def arguments(self) -> dict[str, Declared]:
        """What must be given beside the model."""
        takes = inspect.signature(self.analysis).parameters.values()
        names = [one.name for one in takes if one.kind is one.POSITIONAL_OR_KEYWORD]
        known = declared(self.analysis)
        return {name: known[name] for name in names[1:]
                if known[name].default is inspect.Parameter.empty}  # fmt: skip


@functools.cache
def declared(of: Callable[..., Any]) -> Mapping[str, Declared]:
    """The fields of a class of options, or the keywords of a function, by their names.

    Examples
    --------
    >>> from drystone.limits import LimitOptions
    >>> declared(LimitOptions)["scan"].default
    6
    """
    told = documented(of)
    known: dict[str, Any]
    plain = isinstance(of, type) and not dataclasses.is_dataclass(of)
    hints = typing.get_type_hints(vars(of)["__init__"] if plain else of)
    if dataclasses.is_dataclass(of):
        known = {one.name: _default(one) for one in dataclasses.fields(of)}
    else:
        known = {name: one.default for name, one in inspect.signature(of).parameters.items()}
        hints = hints_of(inspect.unwrap(of)) | hints
    return types.MappingProxyType(
        {
            name: Declared(name, hints.get(name, Any), default, **told.get(name, {}))
            for name, default in known.items()
        }
    )


def options_of(of: Callable[..., Any]) -> list[str]:
    """Names of what may be chosen of a class or an analysis, such as ``options.scan``.

    These are its keywords with a default, and the fields of its options; not what Python alone can
    give.
    """
    if dataclasses.is_dataclass(of):
        return list(declared(of))
    found = []
    for name, one in declared(of).items():
        kind = next(iter(one.kinds), None)
        words = hasattr(kind, "named") or hasattr(kind, "of_words")
        if isinstance(kind, type) and issubclass(kind, Options) and not words:
            found += [f"{name}.{inner}" for inner in declared(kind)]  # type: ignore[arg-type]
        elif one.default is not inspect.Parameter.empty:
            found.append(name)
    python = ("check", "progress", "stop")
    return [name for name in found if name.rpartition(".")[2] not in python]


def declared_at(of: Callable[..., Any], path: str) -> Declared:
    """An option of options, such as ``plan.rules.hands``."""
    head, dot, rest = path.partition(".")
    one = declared(of)[head]
    return declared_at(one.kinds[0], rest) if dot else one


def nested(of: Callable[..., Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """The keywords of a class or a function from values by names such as ``plan.rules.hands``."""
    own: dict[str, Any] = {}
    inner: defaultdict[str, dict[str, Any]] = defaultdict(dict)
    for name, value in values.items():
        head, dot, rest = name.partition(".")
        if dot:
            inner[head][rest] = value
        else:
            own[head] = value
    for head, some in inner.items():
        own[head] = made_of(declared(of)[head].kinds[0], some)
    return own


def made_of(of: Callable[..., Any], values: Mapping[str, Any]) -> Any:
    """What a class of options makes of values by names such as ``plan.rules.hands``."""
    return of(**nested(of, values))


def value_of(given: Any, hint: Any, unit: str = "") -> Any:
    """The value of a text or of a value of JSON by a type; of a union, the first one that fits.

    Raises
    ------
    InputError
        It fits none.

    Examples
    --------
    >>> value_of("2mm", float, "m"), value_of("1,2.5", tuple[float, ...]), value_of(3, int | None)
    (0.002, (1.0, 2.5), 3)
    """
    if given is None and types.NoneType in get_args(hint):
        return None
    *first, last = [kind for kind in kinds_of(hint) if unit != COEFFICIENT or kind is not str]
    for kind in first:
        try:
            return _of_kind(given, kind, unit)
        except InputError:
            continue
    return _of_kind(given, last, unit)


def _schema(kind: Any) -> dict[str, Any]:
    """The JSON schema of a type; empty where JSON has no such values."""
    plain = {bool: "boolean", int: "integer", float: "number", str: "string"}
    if kind in plain:
        return {"type": plain[kind]}
    if get_origin(kind) is Literal:
        return {"enum": list(get_args(kind))}
    if isinstance(kind, type) and issubclass(kind, enum.Enum):
        return {"enum": [one.value for one in kind]}
    if is_many(kind):
        inner = [one for one in map(_schema, kinds_of(get_args(kind)[0])) if one]
        return {"type": "array", "items": {"anyOf": inner} if len(inner) > 1 else inner[0]}
    if hasattr(kind, "of_words"):
        return {"type": "array", "items": {"type": "string"}}
    if get_origin(kind) is Mapping:
        return {"type": "object"}
    return {"type": "string"} if hasattr(kind, "named") else {}


def _of_kind(given: Any, kind: Any, unit: str) -> Any:
    if kind in (int, float):
        return _number(given, kind, unit)
    if kind is bool:
        return of_type({"true": True, "false": False}.get(given, given) if isinstance(given, str)
                       else given, bool, "it", "give true or false")  # fmt: skip
    if get_origin(kind) is Literal:
        return _chosen(given, {str(one): one for one in get_args(kind)})
    if isinstance(kind, type) and issubclass(kind, enum.Enum):
        return _chosen(given, {str(one.value): one for one in kind})
    if is_many(kind):
        return _many(given, kind, unit)
    if hasattr(kind, "of_words") and isinstance(given, str | list | tuple):
        return kind.of_words([given] if isinstance(given, str) else given)
    if hasattr(kind, "named") and isinstance(given, str):
        return kind.named(given)
    own = get_origin(kind) or kind
    return of_type(given, own, "it") if isinstance(own, type) else given


def _number(given: Any, kind: type, unit: str) -> float:
    if not isinstance(given, str):
        return whole(given, "it") if kind is int else number(given, "it")
    if kind is int:
        try:
            return int(given)
        except ValueError as error:
            raise InputError(
                f"'{given}' is not a whole number", remedy="write it in digits, as 4"
            ) from error
    if unit == COEFFICIENT:
        return units.coefficient(given)
    if unit == "m":
        return units.length(given, "length")
    try:
        value = float(given.removesuffix("deg") if unit.startswith("deg") else given)
    except ValueError as error:
        raise InputError(f"'{given}' is not a number", remedy="write 0.5") from error
    if not math.isfinite(value):
        raise InputError(f"is {given}", remedy="give a finite number")
    return value


def _many(given: Any, kind: Any, unit: str) -> tuple[Any, ...]:
    """Several values; a text has them between commas, unless they are texts."""
    inner = [one for one in get_args(kind) if one is not Ellipsis]
    if isinstance(given, str):
        given = [given] if str in kinds_of(inner[0]) else given.split(",")
    of_type(given, list | tuple, "it", "give a list")  # type: ignore[arg-type]
    if len(inner) == 1:
        return tuple(value_of(one, inner[0], unit) for one in given)
    if len(given) != len(inner):
        raise InputError(f"has {len(given)} values", remedy=f"give {len(inner)}")
    return tuple(value_of(one, each, unit) for one, each in zip(given, inner, strict=True))


def _chosen(given: Any, known: Mapping[str, Any]) -> Any:
    text = given.value if isinstance(given, enum.Enum) else given
    if isinstance(text, str) and text not in known:
        text = text.replace("-", " ")
    if not isinstance(text, str) or text not in known:
        raise InputError(f"is '{given}'", remedy=f"use one of {', '.join(known)}")
    return known[text]


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default is not dataclasses.MISSING:
        return field.default
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return inspect.Parameter.empty
