"""Lengths along lines, and checks of lengths and numbers."""

from __future__ import annotations

import math

import numpy as np

from drystone.base.arrays import Floats, floats, number
from drystone.base.errors import InputError


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
        said = f"the {name.replace('_', ' ')}"
        if not 0.0 < number(value, said, finite=False) < math.inf:
            raise InputError(f"{said} is {value}", where=where, remedy="give metres above zero")


def numbers(values: object, what: str, where: str = "") -> Floats:
    """Values as an array of numbers.

    Raises
    ------
    InputError
        They are no numbers, or ragged.
    """
    try:
        return floats(values, what)
    except InputError as error:
        raise error.located(where) from error
