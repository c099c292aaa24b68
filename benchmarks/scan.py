"""The tilt at which something is lost, which may be lost more than once."""

from __future__ import annotations

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
    calls
        Verdicts asked for.
    """

    angle: float
    islands: tuple[float, ...] = ()
    calls: int = 0


def tilt_limit(
    stands: Callable[[float], bool], highest: float = 180.0, step: float = 5.0, width: float = 0.05
) -> Limit:
    """Scan from 0 to ``highest`` by ``step``, then bisect where standing is first lost.

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
    calls = len(angles)
    if not found[0]:
        return Limit(0.0, tuple(a for a, f in zip(angles, found, strict=True) if f), calls)
    if all(found):
        return Limit(angles[-1], (), calls)
    lost = found.index(False)
    low, high = angles[lost - 1], angles[lost]
    while high - low > width:
        middle = 0.5 * (low + high)
        calls += 1
        if stands(middle):
            low = middle
        else:
            high = middle
    islands = tuple(a for a, f in zip(angles[lost:], found[lost:], strict=True) if f)
    return Limit(0.5 * (low + high), islands, calls)


__all__ = ["Limit", "tilt_limit"]
