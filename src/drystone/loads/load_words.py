"""Loads in words: forces, masses and moments on blocks, earthquakes, cases of a file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from drystone.assembly import Assembly
from drystone.base import units
from drystone.base.errors import InputError, located
from drystone.loads.case import DOWN, STANDARD_GRAVITY, LoadCase, name_of_sum
from drystone.loads.earth import Earth
from drystone.loads.fill import Fill

_Direction: TypeAlias = tuple[float, float, float]

_GROUND: Mapping[str, type[Fill] | type[Earth]] = {"fill": Fill, "earth": Earth}
"""Loads of the ground, by the word before their values."""
_MOST = 5e3
"""Gravity [m/s2]: 500 times that of the Earth, as in the largest centrifuges. What is given in
mm/s2 is above it."""
_MOST_SHARE = 500.0
"""Of the weight, level."""
_EXAMPLE = "a force 0,0,-500 or 2kN, a mass 80kg or a moment m=0,0,25"


def _vector(text: str) -> _Direction:
    """Three finite numbers separated by commas.

    Raises
    ------
    InputError
        Not three, or not finite.
    """
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"'{text}' is not X,Y,Z", remedy="write 0,0,-9.81") from error
    if len(values) != 3 or not all(abs(value) < float("inf") for value in values):
        raise InputError(f"'{text}' is not three finite numbers", remedy="write 0,0,-9.81")
    return values[0], values[1], values[2]


def position(text: str) -> tuple[float, float, float]:
    """A point (3,) [m], each number with a unit of length or all in that of the last.

    Raises
    ------
    InputError
        Not three lengths.
    """
    return _components(text, units.UNITS, "0,0,1.2")


def gravity_vector(text: str) -> tuple[float, float, float]:
    """Acceleration (3,) [m/s2] from its size or its components.

    Raises
    ------
    InputError
        Neither one number above zero nor three that are not all zero.
    """
    if "," in text:
        given = _vector(text)
        if not 0.0 < math.hypot(*given) <= _MOST:
            raise InputError(f"is {text}", remedy=f"give one above zero, up to {_MOST:g} m/s2")
        return given
    try:
        size = float(text)
    except ValueError as error:
        raise InputError(f"'{text}' is neither a number nor X,Y,Z", remedy="write 9.81") from error
    if not 0.0 < size <= _MOST:
        raise InputError(f"is {text}", remedy=f"give a number above zero, up to {_MOST:g} m/s2")
    return (0.0, 0.0, -size)


def gravity_size(gravity: _Direction | None) -> float:
    """[m/s2]; the standard one where none is given."""
    return STANDARD_GRAVITY if gravity is None else math.hypot(*gravity)


def load_of_words(
    text: str, assembly: Assembly, where: str = "load", gravity: _Direction | None = None
) -> LoadCase:
    """A load case from ``BLOCK:WHAT[@X,Y,Z]``, ``fill:WORDS`` or ``earth:WORDS``.

    Raises
    ------
    InputError
        It cannot be read, or the block is fixed or unknown.
    """
    kind, _, words = text.partition(":")
    g = gravity_size(gravity)
    if kind in _GROUND and kind not in assembly.names:
        with located(f"{where} {kind}"):
            if gravity is not None and (any(gravity[:2]) or gravity[2] > 0.0):
                remedy = "leave out --gravity X,Y,Z; 'limit tilt' turns blocks and their fill"
                raise InputError("weighs along -z, and gravity is turned", remedy=remedy)
            ground = _GROUND[kind].named(words)
            by_volume, slash, _ = words.partition("/m3")
            if slash and by_volume.strip().endswith(tuple(units.MASSES)):
                ground = replace(ground, weight=ground.weight * g / STANDARD_GRAVITY)
            made = ground.on(assembly)
            return replace(made, masses=tuple(one.weighing_by(g) for one in made.masses))
    block, colon, rest = text.rpartition(":")
    what, at_sign, place = (part.strip() for part in rest.partition("@"))
    if not colon or not block:
        raise InputError(
            f"'{text}' names no block", where=where, remedy="write BLOCK:FX,FY,FZ[@X,Y,Z]"
        )
    down = DOWN if gravity is None else gravity
    try:
        at = position(place) if at_sign else None
        if what.startswith("m="):
            if at is not None:
                raise InputError("a moment acts at no point", remedy="leave out what follows @")
            moment = _components(what[2:], units.MOMENTS, "m=0,0,25")
            return LoadCase.moment(assembly, block, moment)
        if "," in what:
            force = _components(what, units.FORCES, _EXAMPLE)
            return LoadCase.point_load(assembly, block, force, at)
        if any(what.endswith(unit) for unit in units.FORCES):
            size = units.measured(what, units.FORCES, what="force") / math.hypot(*down)
            return LoadCase.point_load(assembly, block, [size * x for x in down], at)
        if any(what.endswith(unit) for unit in units.MASSES):
            mass = units.measured(what, units.MASSES, what="mass")
            return LoadCase.extra_mass(assembly, block, mass, at, g, down)
        raise InputError(f"'{what}' is not a load", remedy=f"write {_EXAMPLE}")
    except InputError as error:
        raise error.located(error.where or where) from error


def _components(text: str, known: dict[str, float], example: str) -> _Direction:
    """Three numbers; the unit of the last is that of all numbers without one."""
    parts = text.split(",")
    plain = _unit_of_last(parts, known)
    try:
        values = [units.measured(part, known, plain) for part in parts]
    except InputError as error:
        what = f"'{text}' is not X,Y,Z: {error.what}"
        raise InputError(what, remedy=f"write {example}") from error
    if len(values) != 3:
        raise InputError(f"'{text}' is not three finite numbers", remedy=f"write {example}")
    return values[0], values[1], values[2]


def move_of_words(text: str, assembly: Assembly) -> LoadCase:
    """A settlement from ``BLOCK:DX,DY,DZ[,RX,RY,RZ]``.

    Raises
    ------
    InputError
        It cannot be read, or the block is unknown.
    """
    block, colon, rest = text.rpartition(":")
    if not colon or not block:
        raise InputError(
            f"'{text}' names no block", where="move", remedy="write BLOCK:DX,DY,DZ[,RX,RY,RZ]"
        )
    parts = rest.split(",")
    plain = _unit_of_last(parts[:3], units.UNITS)
    moved = [
        units.length(part, "move") if part.strip().endswith(tuple(units.UNITS))
        else plain * _number(part, "move")
        for part in parts[:3]
    ]  # fmt: skip
    turned = [math.radians(_number(part, "move")) for part in parts[3:]]
    with located("move"):
        return LoadCase.settlement(assembly, block, moved + turned)


def _unit_of_last(parts: Sequence[str], known: Mapping[str, float]) -> float:
    """The unit of the last of some numbers, which is that of all numbers without one."""
    last = units.NUMBER.fullmatch(parts[-1])
    return 1.0 if last is None else known.get(last[2], 1.0)


def seismic_of_words(text: str, assembly: Assembly) -> LoadCase:
    """A load case from ``KX,KY``."""
    parts = text.split(",")
    if len(parts) not in (1, 2):
        raise InputError(f"'{text}' is not KX,KY", where="seismic", remedy="write 0.1,0")
    shares = [_number(part, "seismic") for part in parts]
    if math.hypot(*shares) > _MOST_SHARE:
        raise InputError(f"is {text}", where="seismic", remedy=f"give shares up to {_MOST_SHARE:g}")
    return LoadCase.seismic(assembly, *shares)


def combined(texts: Iterable[str], cases: Iterable[LoadCase]) -> LoadCase:
    """The sum of load cases of the file, each ``[FACTOR*]NAME``.

    Raises
    ------
    InputError
        A factor is not a number, or the file has no such case.
    """
    parts = []
    for text in texts:
        factor, star, name = text.rpartition("*")
        parts.append((_number(factor, "case") if star else 1.0, case_named(name, cases)))
    return LoadCase.combine(parts, name_of_sum(texts))


def case_named(
    name: str, cases: Iterable[LoadCase], where: str = "case", more: str = ""
) -> LoadCase:
    """The load case of a file with a name; ``more`` follows the names that there are.

    Raises
    ------
    InputError
        The file has no such case.
    """
    known = {case.name: case for case in cases}
    if name not in known:
        names = ", ".join(f"'{case}'" for case in known) or "none"
        remedy = f"the file has {names}{more}"
        raise InputError(f"no load case is called '{name}'", where=where, remedy=remedy)
    return known[name]


def _number(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise InputError(f"'{text}' is not a number", where=where) from error
    if not abs(value) < float("inf"):
        raise InputError(f"is {value}", where=where, remedy="give a finite number")
    return value
