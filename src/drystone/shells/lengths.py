"""Lengths and counts that make sense."""

from __future__ import annotations

import math
from numbers import Integral, Real

from drystone.errors import InputError


def refuse_unless_positive(where: str = "", **metres: float) -> None:
    """Refuse a length that is no number above zero, by its name.

    Raises
    ------
    InputError
        There is one.
    """
    for name, value in metres.items():
        if not (_is_number(value) and math.isfinite(value) and value > 0.0):
            raise InputError(
                f"the {name.replace('_', ' ')} is {value if _is_number(value) else repr(value)}",
                where=where,
                remedy="give metres above zero",
            )


def refuse_unless_count(value: object, name: str, where: str = "") -> None:
    """Refuse what is no whole number.

    Raises
    ------
    InputError
        It is none; 4.0 and True are none either.
    """
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise InputError(
            f"the number of {name} is {value!r}", where=where, remedy="give a whole number"
        )


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)
