"""Units of length in files. Inside, everything is metres."""

from __future__ import annotations

import re

from drystone.errors import InputError

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048}
"""Metres per unit. Source: international yard and pound agreement 1959 for inch and foot."""


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
    match = re.fullmatch(r"\s*([-+0-9.eE]+?)\s*([a-z]*)\s*", text)
    try:
        value = float(match[1]) if match else float("nan")
    except ValueError:
        value = float("nan")
    if match is None or not abs(value) < float("inf"):
        raise InputError(f"{what} '{text}' is not a length", remedy="write 0.15 (metres) or 150mm")
    return value * scale_of(match[2] or "m")
