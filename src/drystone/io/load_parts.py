"""Load cases defined by parts in a file: forces, pressures, settlements, with factors."""

from __future__ import annotations

import inspect
from collections.abc import Callable

from drystone.assembly import Assembly
from drystone.base.errors import InputError
from drystone.io.jsontext import Field
from drystone.loads import Earth, Fill, LoadCase


def _fill(assembly: Assembly, words: str) -> LoadCase:
    return Fill.named(words).on(assembly)


def _earth(assembly: Assembly, words: str) -> LoadCase:
    return Earth.named(words).on(assembly)


_KINDS: dict[str, Callable[..., LoadCase]] = {
    "gravity": LoadCase.gravity,
    "seismic": LoadCase.seismic,
    "point": LoadCase.point_load,
    "line": LoadCase.line_load,
    "surface": LoadCase.surface_load,
    "moment": LoadCase.moment,
    "mass": LoadCase.extra_mass,
    "settlement": LoadCase.settlement,
    "fill": _fill,
    "earth": _earth,
}
"""Kinds of parts. The keys of each are what its constructor takes, in SI units, and its factor."""


def load_of_parts(field: Field, assembly: Assembly, name: str) -> LoadCase:
    """The sum of the parts of a load case.

    Parameters
    ----------
    field
        A list of objects, each with ``kind``, an optional ``factor``, and the keys of its kind.
    assembly
    name

    Raises
    ------
    FormatError
        A field is wrong; its path is named.
    """
    parts = []
    for part in field.elements():
        kind = part["kind"].text()
        if kind not in _KINDS:
            raise part["kind"].error(f"'{kind[:40]}' is no load", f"known are {', '.join(_KINDS)}")
        try:
            parts.append((part.get("factor", 1.0).number(), _made(part, kind, assembly)))
        except InputError as error:
            if error.where.startswith(str(field.file)):
                raise
            raise part.error(str(error)) from error
    if not parts:
        raise field.error("has no parts", "give one or more")
    return LoadCase.combine(parts, name)


def _made(part: Field, kind: str, assembly: Assembly) -> LoadCase:
    """What the constructor of a kind makes of the keys of a part."""
    make = _KINDS[kind]
    _, *takes = inspect.signature(make).parameters.values()
    names = {one.name: one.name for one in takes}
    if kind == "surface":
        if part.has("traction") == part.has("pressure"):
            raise part.error("needs either a traction or a pressure")
        names["traction"] = "pressure" if part.has("pressure") else "traction"
    part.only(("kind", "factor", *names.values()))
    given = {
        one.name: part[names[one.name]].value
        for one in takes
        if part.has(names[one.name]) or one.default is one.empty
    }
    return make(assembly, **given)
