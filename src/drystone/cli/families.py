"""Parametric families by name, and the parameters that ``--set`` gives them."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from drystone.cli.command import MODEL, Option
from drystone.errors import InputError

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


def family(name: str) -> tuple[Callable[..., Assembly], dict[str, type]]:
    """A family and the types of its plain parameters, from their defaults."""
    from drystone import models

    build: Callable[..., Assembly] = getattr(models, name.replace("-", "_"))
    defaults = {p.name: p.default for p in inspect.signature(build).parameters.values()}
    kinds = {key: type(value) for key, value in defaults.items()}
    return build, {key: float if kind is tuple else kind for key, kind in kinds.items()}


def refuse_unknown(name: str, types: dict[str, type], where: str) -> None:
    """Raise InputError where a family has no such parameter."""
    if name not in types:
        raise InputError(
            f"there is no parameter '{name}'", where=where, remedy=f"use {', '.join(types)}"
        )


def setting(text: str, types: dict[str, type]) -> tuple[str, Any]:
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
    refuse_unknown(name, types, "--set")
    if types[name] is bool:
        if value not in ("true", "false"):
            raise InputError(f"{name} is '{value}'", where="--set", remedy="true or false")
        return name, value == "true"
    try:
        return name, types[name](value)
    except ValueError as error:
        kind = "a whole number" if types[name] is int else "a number"
        raise InputError(f"{name} is '{value}', not {kind}", where="--set") from error
