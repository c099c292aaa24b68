"""Lengths that make sense."""

from __future__ import annotations

import math

from drystone.errors import InputError


def refuse_unless_positive(where: str = "", **metres: float) -> None:
    """Refuse a length that is no number above zero, by its name.

    Raises
    ------
    InputError
        There is one.
    """
    for name, value in metres.items():
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(
                f"the {name.replace('_', ' ')} is {value}",
                where=where,
                remedy="give metres above zero",
            )
