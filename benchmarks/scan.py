"""The tilt at which something is lost, which may be lost more than once."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Limit:
    """Where standing ends when the tilt grows from zero.

    Attributes
    ----------
    angle : [degrees]
        Middle of the last bracket; 180 when it is never lost, 0 when it never stood.
    islands
        Angles of the scan beyond the limit at which it stands again.
    """

    angle: float
    islands: tuple[float, ...] = ()


def first_loss(
    stands: Callable[[float], bool], low: float, high: float, width: float
) -> tuple[float, float]:
    """Bracket of the first tilt [degrees] at which it does not stand.

    Close to a limit it may fall, stand again and fall for good. So a bisection ends at a degree,
    and a scan upwards by ``width`` follows.

    Parameters
    ----------
    stands
        Whether it stands at a tilt: true at ``low``, false at ``high``.
    low, high, width : [degrees]
    """
    while high - low > max(1.0, width):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stands(middle) else (low, middle)
    for number in range(math.floor(low / width) + 1, math.ceil(high / width)):
        if not stands(number * width):
            return low, number * width
        low = number * width
    return low, high


def tilt_limit(
    stands: Callable[[float], bool], highest: float = 180.0, step: float = 5.0, width: float = 0.05
) -> Limit:
    """Scan from 0 to ``highest`` by ``step``, then find where standing is first lost.

    Parameters
    ----------
    stands
        Whether it stands at a tilt [degrees].
    highest : [degrees]
        A bound beyond which it cannot stand, or 180.
    step, width : [degrees]
        Of the scan, and of the last bracket.
    """
    angles = [step * i for i in range(int(highest / step) + 2) if step * i < highest + step]
    angles = [a for a in angles if a <= 180.0]
    found = [stands(angle) for angle in angles]
    if not found[0]:
        return Limit(0.0, tuple(a for a, f in zip(angles, found, strict=True) if f))
    if all(found):
        return Limit(angles[-1])
    lost = found.index(False)
    low, high = first_loss(stands, angles[lost - 1], angles[lost], width)
    islands = tuple(a for a, f in zip(angles[lost:], found[lost:], strict=True) if f)
    return Limit(0.5 * (low + high), islands)


__all__ = ["Limit", "first_loss", "tilt_limit"]
