"""Units of lengths in files, of user input and of output. Inside, all values are SI."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from drystone.base.errors import InputError

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048}
"""Metres per unit. Source: international yard and pound agreement 1959 for inch and foot."""
FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6}
MOMENTS = {"Nm": 1.0, "kNm": 1e3, "MNm": 1e6}
PRESSURES = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6}
MASSES = {"g": 1e-3, "kg": 1.0, "t": 1e3}
ANGLES = ("deg", "°")
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
NUMBER = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*([a-zA-Z]*)\s*")


def scale_of(units: str) -> float:
    """Metres per ``units``.

    Raises
    ------
    InputError
        No unit that is known here.

    Examples
    --------
    >>> scale_of("ft")
    0.3048
    """
    if not isinstance(units, str) or units not in UNITS:
        raise InputError(
            f"unit '{units}' is not known", where="units", remedy=f"use one of {', '.join(UNITS)}"
        )
    return UNITS[units]


def measured(
    text: str, units: Mapping[str, float], plain: float = math.nan, what: str = "quantity"
) -> float:
    """A number with its unit, in the SI unit.

    Parameters
    ----------
    text
    units
        Value of each unit.
    plain
        Value of a number that stands alone; NaN where a unit must be given.
    what
        What it is, for errors.

    Raises
    ------
    InputError
        Not a number with one of the units, or above 1e12 in the SI unit, as nothing built is.

    Examples
    --------
    >>> measured("1.5kN", FORCES)
    1500.0
    """
    match = NUMBER.fullmatch(text)
    typed, unit = (math.nan, "") if match is None else (float(match[1]), match[2])
    if unit and unit not in units:
        raise InputError(
            f"unit '{unit}' is not known", where=what, remedy=f"use one of {', '.join(units)}"
        )
    factor = units[unit] if unit else plain
    value = typed * factor
    if abs(value) > 1e12:
        remedy = f"give up to {1e12 / factor:g}{unit}"
        raise InputError(f"{what} '{text}' is larger than anything built", remedy=remedy)
    if math.isnan(value):
        size = "0.15" if match is None else f"{typed:.12g}"
        examples = [f"{size}{unit}" for unit in ("", *units)][math.isnan(plain) : 4]
        raise InputError(
            f"{what} '{text}' is not a number with a unit",
            remedy=f"write {', '.join(examples)}",
        )
    return value


def length(text: str, what: str) -> float:
    """A length [m] written as a number of metres or as a number with its unit.

    Raises
    ------
    InputError
        Not a finite number, or a unit that is not known.

    Examples
    --------
    >>> length("0.15", "depth"), length("150mm", "depth")
    (0.15, 0.15)
    """
    return measured(text, UNITS, 1.0, what)


def coefficient(text: str) -> float:
    """A friction coefficient, written as a number or as the friction angle.

    Raises
    ------
    InputError
        Not a number of zero or more, or not an angle from 0 to below 90 degrees.

    Examples
    --------
    >>> coefficient("0.6"), round(coefficient("40deg"), 3)
    (0.6, 0.839)
    """
    angle = next((unit for unit in ANGLES if text.strip().endswith(unit)), "")
    try:
        value = float(text.strip().removesuffix(angle))
    except ValueError as error:
        raise InputError(f"'{text}' is not a number", remedy="write 0.6 or 31deg") from error
    if angle:
        if not 0.0 <= value < 90.0:
            raise InputError(
                f"is {text}", remedy="give a friction angle from 0 to below 90 degrees"
            )
        return math.tan(math.radians(value))
    if not 0.0 <= value < math.inf:
        raise InputError(f"is {value}", remedy="give a coefficient of zero or more")
    return value


def quantity(value: float, unit: str, negligible: float = 0.0, digits: int = 3) -> str:
    """Significant digits and a prefix; what is at most ``negligible`` is zero.

    Examples
    --------
    >>> quantity(12340.0, "N"), quantity(-2.6e-13, "N", 1e-6), quantity(1.66e12, "N")
    ('12.3 kN', '0 N', '1,660 GN')
    """
    if value == 0.0 or abs(value) <= negligible:
        return f"0 {unit}"
    for factor, prefix in _PREFIXES:
        if abs(value) >= 0.9995 * factor:
            return f"{_rounded(value / factor, digits)} {prefix}{unit}"
    return f"{value:.{digits}g} {unit}"


def components(
    values: Sequence[float], unit: str, negligible: float = 0.0, column: float = 0.0
) -> str:
    """Components of a vector with one prefix, to three digits of the largest.

    A vector of which no component exceeds ``negligible`` is zero. ``column`` is the largest value
    of a table, which then has one prefix, unless that value is negligible too. Tenths of a newton
    are no millinewtons. Places are told to the millimetre, however far they are from the origin.

    Examples
    --------
    >>> components([0.1, -2500.0, 12340.0], "N"), components([0.0, -2e-7, 0.0], "N m", 1e-6)
    ('0, -2.5, 12.3 kN', '0, 0, 0 N m')
    >>> components([0.5, 0.55, 101.2], "m"), components([0.5, 250, 4250.1], "m")
    ('0.5, 0.55, 101.2 m', '0.0005, 0.25, 4.2501 km')
    >>> components([0.0, -0.165], "N m"), components([0.0, -0.165], "N m", column=1.64)
    ('0, -0.165 N m', '0, -0.165 N m')
    >>> components([0.0, 3e-13], "N m", 1e-6, column=3e-13)
    '0, 0 N m'
    """
    largest = max((abs(value) for value in values), default=0.0)
    if largest <= negligible:
        values, largest = [0.0] * len(values), 0.0
    size = max(largest, column if column > negligible else 0.0)
    size *= 10.0 if unit.startswith("N") and 0.0995 <= size < 1.0 else 1.0
    factor, prefix = next((one for one in _PREFIXES if size >= 0.9995 * one[0]), (1.0, ""))
    digits = 0 if largest == 0.0 else max(2 - math.floor(math.log10(largest / factor)), 0)
    digits = max(digits, {"m": 3, "km": 6}.get(prefix + unit, 0))

    def shown(value: float) -> str:
        text = f"{round(value / factor, digits) + 0.0:.{digits}f}"
        return text.rstrip("0").rstrip(".") if "." in text else text

    return f"{', '.join(map(shown, values))} {prefix}{unit}"


def extent(sizes: Sequence[float]) -> str:
    """Sizes [m] along x, y and z.

    Examples
    --------
    >>> extent([6.125, 0.5, 3.0]), extent([2150.0, 300.0, 1220.0])
    ('6.12 x 0.5 x 3 m', '2,150 x 300 x 1,220 m')
    >>> extent([0.001, 0.001, 0.003])
    '1 x 1 x 3 mm'
    """
    scale, unit = (1e3, "mm") if max(sizes, default=1.0) < 1e-2 else (1.0, "m")
    return f"{' x '.join(_rounded(scale * one) for one in sizes)} {unit}"


def mass(value: float) -> str:
    """A mass [kg] in kg, from a tonne on in t, below a gram in parts of it.

    Examples
    --------
    >>> mass(850.0), mass(12345.0), mass(8.3e9)
    ('850 kg', '12.3 t', '8,300,000 t')
    >>> mass(4.8e-6)
    '4.8 mg'
    """
    if 0.0 < value < 1e-3:
        return quantity(1e3 * value, "g")
    shown, unit = (value, "kg") if abs(value) < 999.5 else (value / 1e3, "t")
    return f"{_rounded(shown)} {unit}"


def _rounded(value: float, digits: int = 3) -> str:
    """Significant digits; from a thousand on without an exponent."""
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:,.0f}" if 1e3 <= abs(rounded) < 1e15 else f"{rounded:g}"
