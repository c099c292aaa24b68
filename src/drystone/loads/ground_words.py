"""Words of the ground: ``name=value`` pairs of weights, pressures, levels and their ratios."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from drystone.base import units
from drystone.base.errors import InputError, meant
from drystone.base.hints import beyond, documented
from drystone.loads.case import STANDARD_GRAVITY

T = TypeVar("T")
Reader = Callable[[str], Any]
_MASSES = {name: STANDARD_GRAVITY * kg for name, kg in units.MASSES.items()}


def read_words(
    of: Callable[..., T],
    text: str,
    what: str,
    known: Mapping[str, Reader],
    example: str,
    **angles: str,
) -> T:
    """What is made of the values of ``name=value,name=value``.

    Parameters
    ----------
    of
        Makes it, and says in its documentation how large a ratio may be.
    text
    what
        Is described.
    known
        Names, and what reads the value of each.
    example
        Its names must be given.
    **angles
        What comes before an angle, by the names of ratios that can be given as one.

    Raises
    ------
    InputError
        A name is unknown, given twice or missing, or its value cannot be read.
    """
    found: dict[str, Any] = {}
    for part in text.split(","):
        name, _, value = (one.strip() for one in part.partition("="))
        names = f"give some of {', '.join(known)}, each once; such as {example}"
        if not value:
            raise InputError(f"'{part}' is not NAME=VALUE", remedy=names)
        if name not in known:
            raise InputError(f"{what} has no '{name}'", remedy=meant(name, known, names))
        if name in found:
            raise InputError(f"'{name}' is given twice", remedy=names)
        try:
            found[name] = known[name](value)
        except InputError as error:
            raise InputError(f"{name}: {error.what}", remedy=error.remedy) from error
        if name in angles:
            _refuse_degrees(of, name, found[name], value, angles[name])
    for part in example.split(","):
        name = part.partition("=")[0]
        if name not in found:
            raise InputError(f"{what} has no {name}", remedy=f"write {example}")
    return of(**found)


def _refuse_degrees(of: Any, name: str, ratio: float, typed: str, before: str) -> None:
    """Refuse a ratio that is too large, and tell how the same number is written as an angle."""
    most = beyond(ratio, documented(of)[name]["ends"])
    if most and ratio < 90.0 and typed.replace(".", "").isdecimal():
        remedy = f"{most}; degrees are written {name}={before}{typed}deg"
        raise InputError(f"{name} is {ratio:g}", remedy=remedy)


def before(text: str, unit: str, example: str) -> str:
    """What is given by exactly this unit, such as ``20kN`` of ``20kN/m3``.

    Raises
    ------
    InputError
        By another unit, or by none.
    """
    size, slash, per = text.strip().partition("/")
    if per != unit:
        other = "another" if slash else "no"
        raise InputError(f"'{text}' has {other} unit", remedy=f"write {example}")
    return size


def weight(text: str) -> float:
    """A weight by volume [N/m3], such as ``20kN/m3`` or ``2000kg/m3``.

    Examples
    --------
    >>> weight("20kN/m3"), weight("2000kg/m3")
    (20000.0, 19620.0)
    """
    return units.measured(
        before(text, "m3", "20kN/m3 or 2000kg/m3"), units.FORCES | _MASSES, what="weight"
    )


def force(text: str) -> float:
    """A force [N], such as ``300kN``, or the weight of a mass such as ``22.5t``."""
    return units.measured(text, units.FORCES | _MASSES, what="load")


def pressure(text: str) -> float:
    """A pressure [Pa], such as ``10kPa`` or ``10kN/m2``."""
    if "/" in text:
        return units.measured(before(text, "m2", "10kPa or 10kN/m2"), units.FORCES, what="pressure")
    known = units.PRESSURES | {"kN/m2": 1e3}  # to be told
    return units.measured(text, known, what="pressure")


def length(text: str) -> float:
    """A length [m]."""
    return units.length(text, "length")


def spread(text: str) -> float:
    """Horizontal by vertical: ``2:1`` (down to across), ``30deg`` from the vertical, or a number.

    Examples
    --------
    >>> spread("2:1"), round(spread("45deg"), 6)
    (0.5, 1.0)
    """
    down, colon, across = text.partition(":")
    if not colon:
        return units.coefficient(text)
    try:
        return float(across) / float(down)
    except (ValueError, ZeroDivisionError) as error:
        raise InputError(f"'{text}' is no slope", remedy="write 2:1 or 30deg") from error


def between(text: str) -> tuple[float, float]:
    """Two places [m], such as ``-1.5m:1.5m``."""
    low, colon, high = text.partition(":")
    if not colon:
        raise InputError(f"'{text}' is one place", remedy="write two, such as -1.5m:1.5m")
    return length(low), length(high)


def grade(text: str) -> float:
    """A rise by length: ``3%``, or a number.

    Examples
    --------
    >>> grade("3%"), grade("-0.02")
    (0.03, -0.02)
    """
    number = units.measured(text.removesuffix("%"), {}, 1.0, "grade")
    return number / 100.0 if text.endswith("%") else number


def pressure_ratio(text: str) -> float:
    """Horizontal by vertical pressure: a number, or ``active:``, ``rest:``, ``passive:30deg``.

    The active and the passive one of an angle of friction, for level earth on an upright smooth
    wall, also in an earthquake, as ``active:30deg:0.1`` at 0.1 g: the horizontal acceleration by
    that of gravity, times saturated by submerged weight below water. Jaky 1944 at rest.

    Source: EN 1998-5, E.3 and E.4 (Mononobe and Okabe); Rankine 1857 without an earthquake.

    Examples
    --------
    >>> [round(pressure_ratio(f"{state}:30deg"), 3) for state in ("active", "rest", "passive")]
    [0.333, 0.5, 3.0]
    >>> [round(pressure_ratio(f"{state}:30deg:0.1"), 3) for state in ("active", "passive")]
    [0.397, 2.821]
    """
    state, colon, angle = text.partition(":")
    if not colon and text.endswith(units.ANGLES):
        raise InputError(f"'{text}' is an angle", remedy=f"write active:{text}, or the ratio")
    if not colon:
        return units.coefficient(text)
    angle, shaken, share = angle.partition(":")
    if not angle.endswith(units.ANGLES):
        raise InputError(f"'{angle}' is no angle", remedy=f"write {state}:30deg")
    friction, level = units.coefficient(angle), units.coefficient(share) if shaken else 0.0
    if level > friction:
        what = f"level earth of {angle} slides by itself at {share} g"
        raise InputError(what, remedy=f"give at most {friction:.3g}")
    if shaken and state == "rest":
        raise InputError(
            "earth in an earthquake does not rest", remedy=f"write active:{angle}:{share}"
        )
    own, turn = math.atan(friction), math.atan(level)
    side = math.sqrt(math.sin(own) * math.sin(own - turn) / math.cos(turn))
    wedge = (math.cos(own - turn) / math.cos(turn)) ** 2
    known = {
        "active": wedge / (1.0 + side) ** 2,
        "rest": 1.0 - math.sin(own),
        "passive": wedge / (1.0 - side) ** 2,
    }
    if state not in known:
        raise InputError(f"'{state}' is no state of earth", remedy="active, rest or passive")
    return known[state]
