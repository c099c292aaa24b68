"""Parametric families by name, and the parameters that ``--set`` gives them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from drystone.base.errors import FormatError, InputError, meant
from drystone.cli.offered import MODEL, Option

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.base.declared import Declared

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

Parameters: TypeAlias = "Mapping[str, Declared]"


def names() -> list[str]:
    """The families: functions of :mod:`drystone.models` that return assemblies."""
    from drystone import models

    return [
        name.replace("_", "-")
        for name in models.__all__
        if inspect.signature(getattr(models, name)).return_annotation == "Assembly"
    ]


def family(name: str) -> tuple[Callable[..., Assembly], Parameters]:
    """The function of a family and its parameters.

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
    from drystone.base.declared import declared

    return build, declared(build)


def shell_family(name: str) -> tuple[Callable[..., Any], Parameters] | None:
    """The function of a family of shells, such as ``dome-shell``, and its parameters."""
    surface = name.removesuffix(_SHELL)
    if surface == name:
        return None
    from drystone.base.declared import declared
    from drystone.shells import shell_by_name

    known = dict(declared(shell_by_name))
    del known["surface"]
    return partial(shell_by_name, surface), known


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
    try:
        return name, known[name].value(value.strip())
    except InputError as error:
        file = f": {error.where}" if isinstance(error, FormatError) else ""
        raise error.located(f"--set {name}{file}") from error
