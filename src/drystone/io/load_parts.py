"""Load cases defined by parts in a file: forces, pressures, settlements, with factors."""

from __future__ import annotations

from collections.abc import Callable

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.io.jsontext import Field
from drystone.loads import DOWN, STANDARD_GRAVITY, LoadCase

_KEYS = {
    "gravity": ("g", "direction"),
    "seismic": ("kx", "ky", "g"),
    "point": ("block", "force", "at"),
    "line": ("block", "force_per_length", "start", "end"),
    "surface": ("block", "traction", "pressure", "faces", "facing"),
    "moment": ("block", "moment"),
    "mass": ("block", "mass", "at", "g", "direction"),
    "settlement": ("block", "motion"),
}
"""Kinds of parts, and the keys of each besides its factor. SI units."""


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
        if kind not in _KEYS:
            raise part["kind"].error(f"'{kind[:40]}' is no load", f"known are {', '.join(_KEYS)}")
        part.only(("kind", "factor", *_KEYS[kind]))
        try:
            parts.append((part.get("factor", 1.0).number(), _MAKERS[kind](part, assembly)))
        except InputError as error:
            if error.where.startswith(str(field.file)):
                raise
            raise part.error(str(error)) from error
    if not parts:
        raise field.error("has no parts", "give one or more")
    return LoadCase.combine(parts, name)


def _gravity(part: Field, assembly: Assembly) -> LoadCase:
    return LoadCase.gravity(assembly, _g(part), _direction(part))


def _seismic(part: Field, assembly: Assembly) -> LoadCase:
    shares = part["kx"].number(), part.get("ky", 0.0).number()
    return LoadCase.seismic(assembly, *shares, g=_g(part))


def _point(part: Field, assembly: Assembly) -> LoadCase:
    return LoadCase.point_load(assembly, _block(part), part["force"].floats(3), _at(part))


def _line(part: Field, assembly: Assembly) -> LoadCase:
    ends = part["start"].floats(3), part["end"].floats(3)
    force = part["force_per_length"].floats(3)
    return LoadCase.line_load(assembly, _block(part), force, *ends)


def _surface(part: Field, assembly: Assembly) -> LoadCase:
    if part.has("traction") == part.has("pressure"):
        raise part.error("needs either a traction or a pressure")
    pressing = part.has("pressure")
    traction = part["pressure"].number() if pressing else part["traction"].floats(3)
    faces = part["faces"].integers(None).tolist() if part.has("faces") else None
    facing = part["facing"].floats(3) if part.has("facing") else None
    return LoadCase.surface_load(assembly, _block(part), traction, faces, facing)


def _moment(part: Field, assembly: Assembly) -> LoadCase:
    return LoadCase.moment(assembly, _block(part), part["moment"].floats(3))


def _mass(part: Field, assembly: Assembly) -> LoadCase:
    mass = part["mass"].number()
    where = _at(part)
    return LoadCase.extra_mass(assembly, _block(part), mass, where, _g(part), _direction(part))


def _settlement(part: Field, assembly: Assembly) -> LoadCase:
    return LoadCase.settlement(assembly, _block(part), part["motion"].floats(None))


def _block(part: Field) -> int | str:
    block = part["block"]
    return block.integer() if isinstance(block.value, int) else block.text()


def _at(part: Field) -> Floats | None:
    return part["at"].floats(3) if part.has("at") else None


def _g(part: Field) -> float:
    return part.get("g", STANDARD_GRAVITY).number()


def _direction(part: Field) -> Floats:
    return part.get("direction", list(DOWN)).floats(3)


_MAKERS: dict[str, Callable[[Field, Assembly], LoadCase]] = {
    "gravity": _gravity,
    "seismic": _seismic,
    "point": _point,
    "line": _line,
    "surface": _surface,
    "moment": _moment,
    "mass": _mass,
    "settlement": _settlement,
}
