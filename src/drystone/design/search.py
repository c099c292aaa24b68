"""Searches over changes of a design: the least value that stands, and change after change."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, TypeVar

from drystone.base.progress import Stop

_CLOSE = 0.01
"""Relative width at which a search ends that has none of its own."""


def bracket(
    stands: Callable[[float], bool],
    low: float,
    high: float,
    width: float = 0.0,
    late: Stop = bool,
) -> tuple[float, float]:
    """The largest value known to fall and the least known to stand, a width apart.

    It is taken to fall at ``low`` and to stand at ``high``, which are not tried. With a width the
    search goes by whole widths from ``low``: searches with the same width give the same value.

    Parameters
    ----------
    stands, low, high
    width
        One hundredth of the value when zero.
    late
        True ends the search.

    Examples
    --------
    >>> bracket(lambda x: x > 0.33, 0.0, 1.0, width=0.125)
    (0.25, 0.375)
    """
    while high - low > (1.0 + 1e-9) * (width or _CLOSE * high) and not late():
        middle = 0.5 * (low + high)
        if width:
            middle = low + width * max(1, round((middle - low) / width))
        if stands(middle):
            high = middle
        else:
            low = middle
    return low, high


def least(
    stands: Callable[[float], bool], steps: Sequence[float], width: float = 0.0, low: float = 0.0
) -> float | None:
    """The least value at which something stands, below the first of some rising ones that does.

    ``None`` where it falls at all of them. No value below ``low`` is tried.
    """
    for high in steps:
        if stands(high):
            return bracket(stands, low, high, width)[1]
        low = high
    return None


class Ranked(Protocol):
    """A design with the help that it needs; less is better."""

    @property
    def rank(self) -> Any:
        """What is compared."""


R = TypeVar("R", bound=Ranked)


def improved(best: R, proposals: Callable[[R], Iterator[R]], late: Stop) -> R:
    """The design after the first proposed change that is better, again and again, until none is.

    Parameters
    ----------
    best
    proposals
        Other designs to try from a design.
    late
        True ends the search.
    """
    while not late():
        rank = best.rank
        better = next((one for one in proposals(best) if one.rank < rank), None)
        if better is None:
            break
        best = better
    return best
