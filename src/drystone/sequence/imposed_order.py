"""What a plan tells of an imposed order."""

from __future__ import annotations

from collections.abc import Sequence


def departure(given: Sequence[str], found: Sequence[str]) -> str:
    """Where an order of assembly departs from a given one; empty if it does not.

    Parameters
    ----------
    given
        Names in the order of assembly. Blocks that are not placed by the plan do not count.
    found
        Names of all placed blocks in the order of the plan.
    """
    placed = set(found)
    wanted = [name for name in given if name in placed]
    for want, name in zip(wanted, found, strict=False):
        if want != name:
            return f"the given order is not kept: '{name}' is placed before '{want}'"
    return ""
