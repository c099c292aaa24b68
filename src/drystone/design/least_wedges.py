"""Wedges taken back until each one that is left is needed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.progress import Stop
from drystone.design.search import bracket


def least_wedges(
    sharpness: Floats,
    stands: Callable[[Floats], bool],
    *,
    close: float,
    late: Stop,
    tell: Callable[[int, int], None] | None = None,
) -> tuple[Floats, bool]:
    """Wedges made plane or flatter, each alone, until every one that is left is needed.

    First wedges are made plane, as long as one can be. Then each one is made as flat as the
    structure stands with, by bisection. Both are repeated until nothing changes. The least sharp
    is tried first. A flatter wedge may make another one needless that was needed before. So after
    each change all other wedges are tried again. The sum of the sharpness falls by at least
    ``close`` with each change, so this ends.

    Parameters
    ----------
    sharpness : (j,) [degrees]
        With which the structure stands.
    stands
        Whether the structure stands with a sharpness (j,).
    close : [degrees]
    late
        Whether it is time to stop.
    tell
        Called with the number of wedges that are known to be needed, and of all wedges.

    Returns
    -------
    (j,) [degrees], bool
        The sharpness, and whether every wedge is needed: with each one alone plane, or less sharp
        by ``close``, ``stands`` was False. That is so unless it was stopped.
    """
    step, other = np.inf, close
    sharpness, known = _in_turn(sharpness, step, stands, close, late, tell)
    while known:
        step, other = other, step
        before = sharpness
        sharpness, known = _in_turn(before, step, stands, close, late, tell)
        if sharpness is before:
            break
    return sharpness, known


def _in_turn(
    sharpness: Floats,
    step: float,
    stands: Callable[[Floats], bool],
    close: float,
    late: Stop,
    tell: Callable[[int, int], None] | None,
) -> tuple[Floats, bool]:
    """Wedges taken back until it falls with any one of them less sharp by a step, or plane.

    What was given is returned where it is so already; and False where it was stopped.
    """
    needed: set[int] = set()
    wedges = np.flatnonzero(sharpness > 0.0)
    while not needed.issuperset(wedges.tolist()):
        for k in wedges[np.argsort(sharpness[wedges], kind="stable")].tolist():
            if k in needed:
                continue
            if tell is not None:
                tell(len(needed), len(wedges))
            value = _taken_back(sharpness, k, step, stands, close, late)
            if value < sharpness[k]:
                sharpness = _with(sharpness, k, value)
                needed.clear()
            if late():
                return sharpness, False
            needed.add(k)
        wedges = np.flatnonzero(sharpness > 0.0)
    return sharpness, True


def _taken_back(
    sharpness: Floats,
    joint: int,
    step: float,
    stands: Callable[[Floats], bool],
    close: float,
    late: Stop,
) -> float:
    """The sharpness of one wedge [degrees] with which it stands, and not with a step less."""

    def holds(value: float) -> bool:
        return stands(_with(sharpness, joint, value))

    value = float(sharpness[joint])
    while value > 0.0 and not late() and holds(less := max(value - step, 0.0)):
        value = less and bracket(holds, 0.0, less, 0.5 * close, late)[1]
    return value


def _with(sharpness: Floats, joint: int, value: float) -> Floats:
    """The sharpness (j,) with another value for one joint."""
    out = sharpness.copy()
    out[joint] = value
    return out
