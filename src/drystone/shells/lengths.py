"""Lengths along lines, and checks of lengths and numbers."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError, quoted


def arc_lengths(points: Floats) -> Floats:
    """Length (p, ...) [m] of polylines (p, ..., 3) from their first point to each one."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    return np.concatenate([np.zeros_like(step[:1]), np.cumsum(step, axis=0)])


def refuse_unless_positive(where: str = "", **metres: float) -> None:
    """Refuse lengths that are not numbers above zero.

    Raises
    ------
    InputError
        There is such a length; it is named.
    """
    for name, value in metres.items():
        if not (_is_number(value) and math.isfinite(value) and value > 0.0):
            raise InputError(
                f"the {name.replace('_', ' ')} is {value if _is_number(value) else repr(value)}",
                where=where,
                remedy="give metres above zero",
            )


def numbers(values: object, what: str, where: str = "") -> Floats:
    """Values as an array of numbers.

    Raises
    ------
    InputError
        They are no numbers, or ragged.
    """
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        told = quoted(values, 180)
        raise InputError(
            f"{what} must be numbers, got {told}", where=where, remedy="give numbers, evenly nested"
        ) from error


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)
