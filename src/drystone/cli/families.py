"""Parametric families by name, and the parameters that ``--set`` gives them."""

from __future__ import annotations

import inspect
import types
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin

from drystone.base.errors import InputError, meant
from drystone.cli.offered import MODEL, Option

if TYPE_CHECKING:
    from drystone.assembly import Assembly

Settings: TypeAlias = Annotated[
    tuple[str, ...],
    Option(
        "A parameter of the family, such as voussoirs=36. Can be given several times.",
        MODEL,
        metavar="NAME=VALUE",
    ),
]
_SHELL = "-shell"
"""What the name of a family of shells ends with, after the name of its surface."""

Parameters: TypeAlias = Mapping[str, inspect.Parameter]


def names() -> list[str]:
    """The families: functions of :mod:`drystone.models` that return assemblies."""
    from drystone import models

    return [
        name.replace("_", "-")
        for name in models.__all__
        if inspect.signature(getattr(models, name)).return_annotation == "Assembly"
    ]


def family(name: str) -> tuple[Callable[..., Assembly], Parameters]:
    """The function of a family and its parameters, their annotations resolved.

    Raises
    ------
    InputError
        There is no such family; close names are suggested.
    """
    from drystone import models

    known = names()
    if name.replace("_", "-") not in known:
        remedy = meant(name, known, "'drystone models' lists all")
        raise InputError(f"there is no family '{name}'", where="FAMILY", remedy=remedy)
    build: Callable[..., Assembly] = getattr(models, name.replace("-", "_"))
    return build, inspect.signature(build, eval_str=True).parameters


def shell_family(name: str) -> tuple[Callable[..., Any], Parameters] | None:
    """The function of a family of shells, such as ``dome-shell``, and its parameters."""
    surface = name.removesuffix(_SHELL)
    if surface == name:
        return None
    from drystone.shells import shell_by_name

    return partial(shell_by_name, surface), shell_parameters()


def shell_parameters() -> Parameters:
    """The parameters of a shell, but for its surface."""
    from drystone.shells import shell_by_name

    known = dict(inspect.signature(shell_by_name, eval_str=True).parameters)
    del known["surface"]
    return known


def refuse_unknown(name: str, known: Parameters, where: str) -> None:
    """Raise InputError where a family has no such parameter."""
    if name not in known:
        remedy = meant(name, known, f"use {', '.join(known)}" if known else "it has none")
        raise InputError(f"there is no parameter '{name}'", where=where, remedy=remedy)


def setting(text: str, known: Parameters) -> tuple[str, Any]:
    """Name and value of ``NAME=VALUE``.

    Raises
    ------
    InputError
        Not of that form, no such parameter, or a value of another type.
    """
    name, equals, value = text.partition("=")
    name = name.replace("-", "_")
    if not equals:
        raise InputError(f"'{text}' is not NAME=VALUE", where="--set")
    refuse_unknown(name, known, "--set")
    return name, _value(name, value.strip(), known[name].annotation)


def _value(name: str, text: str, hint: Any) -> Any:
    """The value of a text by the type of a parameter; of a union, the first type that fits."""
    if get_origin(hint) in (types.UnionType, Union):
        parts = [part for part in get_args(hint) if part is not types.NoneType]
        for part in parts[:-1]:
            try:
                return _value(name, text, part)
            except InputError:
                continue
        return _value(name, text, parts[-1])
    if get_origin(hint) is Literal:
        words = {str(one): one for one in get_args(hint)}
    elif hint is bool:
        words = {"true": True, "false": False}
    else:
        words = {}
    if words:
        if text not in words:
            raise InputError(
                f"{name} is '{text}'", where="--set", remedy=f"one of {', '.join(words)}"
            )
        return words[text]
    many = get_origin(hint) in (Sequence, tuple, list) or hint is Sequence
    kind: Callable[[str], Any] = int if hint is int else float
    try:
        return [float(part) for part in text.split(",")] if many else kind(text)
    except ValueError as error:
        what = "a whole number" if kind is int else "numbers" if many else "a number"
        raise InputError(f"{name} is '{text}', not {what}", where="--set") from error
