"""Kinds of values on the command line: conversion of their text, with error messages."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

from drystone.base import units
from drystone.base.errors import FormatError, InputError
from drystone.base.files import is_there, plain_target

if TYPE_CHECKING:
    from drystone.base.declared import Declared


class OptionKind(click.ParamType):  # type: ignore[type-arg]  # generic since click 8.5
    """Conversion of text to a value; errors name the option.

    Parameters
    ----------
    name
        What stands for the value in help.
    read
        Converts the text, or raises an InputError.
    choices
        All values, if there are few.
    written
        What the names may end with, where it is a file or a folder that the command writes.
    """

    def __init__(
        self,
        name: str,
        read: Callable[[str], Any],
        choices: Sequence[str] | None = None,
        written: Sequence[str] = (),
    ) -> None:
        self.name = name
        self.read = read
        self.choices = choices
        self.written = tuple(written)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:  # noqa: ARG002
        """The value of a text; defaults are not converted."""
        if not isinstance(value, str):
            return value
        try:
            return self.read(value)
        except InputError as error:
            file = f" {error.where}" if isinstance(error, FormatError) and error.where else ""
            raise error.located(named(param) + file) from error

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:  # noqa: ARG002
        """What stands for the value in help."""
        return "|".join(self.choices) if self.choices else self.name

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """The choices that begin with the text; file names for files."""
        if self.choices is None:
            return [CompletionItem(incomplete, type="file")] if self.name == "FILE" else []
        return [CompletionItem(one) for one in self.choices if one.startswith(incomplete)]


def named(param: click.Parameter | None) -> str:
    """The name of an option or argument on the command line."""
    if param is None:
        return ""
    if isinstance(param, click.Option):
        return max(param.opts, key=len)
    return param.metavar or (param.name or "").upper()


def typed(name: str, hint: Any, **ends: float) -> OptionKind:
    """A value of a type, within the ends of :class:`drystone.base.declared.Declared`."""

    def read(text: str) -> Any:
        from drystone.base.declared import Declared  # the program starts without numpy

        return Declared("", hint, None, ends=ends).value(text)

    return OptionKind(name, read)


def one_of(choices: Iterable[str], what: str = "") -> OptionKind:
    """One of a few words."""
    known = tuple(choices)

    def read(text: str) -> str:
        if text not in known:
            told = what.format(text) if what else f"is '{text}'"
            raise InputError(told, remedy=f"use one of {', '.join(known)}")
        return text

    return OptionKind("WORD", read, known)


def _workers(text: str) -> int | str:
    """A number of processes, or the address of a scheduler."""
    if "://" in text:
        return text
    count = int(COUNT.read(text))
    if count > 1_000:
        raise InputError(f"is {count}", remedy="give a number of processes")
    return count


def target(*suffixes: str) -> OptionKind:
    """A file to write, with one of the suffixes or any; it is looked at before any work."""
    return OptionKind("FILE", lambda text: output_path(text, suffixes), written=suffixes or ("",))


def output_path(text: str, suffixes: Sequence[str]) -> Path:
    """The path of a file to write.

    Raises
    ------
    InputError
        Another suffix, a folder that does not exist, or something of that name that is no file.
    """
    path = Path(text)
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(
            f"'{text}' does not end in {_either(suffixes)}",
            remedy=f"write {path.stem or 'model'}{suffixes[0]}",
        )
    try:
        plain_target(path)
    except FormatError as error:
        raise InputError(f"'{text}' {error.what}", remedy=error.remedy) from error
    if not path.parent.is_dir():
        raise InputError(f"there is no folder '{path.parent}'", remedy="make it first")
    return path


def _folder_path(text: str) -> Path:
    """The path of a folder, which may be made with those above it.

    Raises
    ------
    InputError
        Something of that name, or on the way to it, is no folder.
    """
    path = Path(text)
    there = next(one for one in (path, *path.absolute().parents) if is_there(one))
    if not there.is_dir():
        raise InputError(f"'{there}' is no folder", remedy="name another folder")
    return path


def _either(words: Sequence[str]) -> str:
    first = ", ".join(words[:-1])
    return f"{first} or {words[-1]}" if first else words[-1]


def see(ctx: click.Context | None) -> str:
    """Where the help is."""
    return f"see '{ctx.command_path} --help'" if ctx is not None else ""


def _section(text: str) -> str:
    from drystone.view.section import (
        read_section,  # pictures are imported when asked for
    )

    read_section(text)
    return text


def of(one: Declared) -> OptionKind:
    """The kind of a declared option; several words are converted together, later."""
    if one.choices:
        return one_of(one.choices) if one.several else OptionKind("WORD", one.value, one.choices)
    if one.several:
        return TEXT
    number = {int, float} & {*one.kinds}
    name = {"m": "LENGTH", "coefficient": "NUMBER|ANGLE"}.get(one.unit, "NUMBER")
    return OptionKind(("COUNT" if number == {int} else name) if number else "TEXT", one.value)


MODEL_FILE = target(".json", ".3dm", ".glb", ".mjcf", ".obj", ".ply", ".stl", ".urdf", ".xml")
TEXT = OptionKind("TEXT", str)
FOLDER = OptionKind("FOLDER", _folder_path, written=("",))
SECTION = OptionKind("AXIS[=METRES]", _section)
FILE = OptionKind("FILE", str)
WRITTEN = OptionKind("FILE", str, written=("",))
NUMBER = typed("NUMBER", float)
POSITIVE = typed("NUMBER", float, **{">": 0.0})
WHOLE = typed("COUNT", int)
COUNT = typed("COUNT", int, **{">=": 1.0})
COUNTS = OptionKind(
    "NUMBERS", lambda text: tuple(int(COUNT.read(part)) for part in text.split(","))
)
WORKERS = OptionKind("COUNT|ADDRESS", _workers)
LENGTH = OptionKind("LENGTH", lambda text: units.length(text, "length"))
COEFFICIENT = OptionKind("NUMBER|ANGLE", units.coefficient)
UNIT = one_of(units.UNITS, "unit '{}' is not known")
