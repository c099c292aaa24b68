"""Axis-aligned boxes that overlap."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.ragged import BATCH

FEW = 4096
"""Up to so many pairs all are compared: faster than a tree, measured."""

_PAIRS = BATCH // 4
"""Pairs in a batch. Chosen: what is computed of a pair has some 200 bytes, 50 MB in all."""


def overlapping(low: Floats, high: Floats) -> tuple[Ints, Ints]:
    """Pairs of boxes that overlap or touch.

    Parameters
    ----------
    low, high : (b, 3) [m]
        Lowest and highest corner of each box.

    Returns
    -------
    first, second : (p,)
        ``first < second``, in lexicographic order.

    Examples
    --------
    >>> low = np.array([[0.0, 0, 0], [1, 0, 0], [5, 0, 0]])
    >>> [pair.tolist() for pair in overlapping(low, low + 1.0)]
    [[0], [1]]
    """
    first, second = between(low, high, low, high)
    keep = first < second
    return first[keep], second[keep]


def between(low_a: Floats, high_a: Floats, low_b: Floats, high_b: Floats) -> tuple[Ints, Ints]:
    """Pairs of a box of one set and a box of another that overlap or touch.

    Parameters
    ----------
    low_a, high_a : (a, 3) [m]
    low_b, high_b : (b, 3) [m]

    Returns
    -------
    first, second : (p,)
        Positions in the two sets, in lexicographic order.
    """
    found = [np.zeros((2, 0), dtype=np.intp)]
    found += [np.stack(pair) for pair in batches(low_a, high_a, low_b, high_b)]
    first, second = np.concatenate(found, axis=1)
    order = np.lexsort((second, first))
    return first[order], second[order]


def batches(
    low_a: Floats, high_a: Floats, low_b: Floats, high_b: Floats
) -> Iterator[tuple[Ints, Ints]]:
    """The pairs of :func:`between` in batches of bounded size, by the boxes of the first set.

    The memory does not grow with the number of pairs, unless one box overlaps very many others.
    """
    return BoxTree(low_b, high_b).overlapped_by(low_a, high_a)


@dataclass(frozen=True)
class BoxTree:
    """Boxes (b, 3) [m] in which those that overlap others are found, many times.

    Notes
    -----
    shapely's STRtree finds the boxes that overlap along two axes. The third axis is the one along
    which the boxes cover the largest part of the extent. It would separate the fewest pairs, and is
    tested last.
    """

    low: Floats
    high: Floats

    @cached_property
    def _left_out(self) -> int:
        """The axis that the tree does not have."""
        whole = self.high.max(axis=0) - self.low.min(axis=0)
        mean = (self.high - self.low).mean(axis=0)
        return int(np.argmax(mean / np.where(whole > 0.0, whole, 1.0) + (whole == 0.0)))

    def _diagonals(self, low: Floats, high: Floats) -> Any:
        axes = [axis for axis in range(3) if axis != self._left_out]
        return shapely.linestrings(np.stack([low[:, axes], high[:, axes]], axis=1))

    @cached_property
    def _tree(self) -> shapely.STRtree:
        return shapely.STRtree(self._diagonals(self.low, self.high))

    def overlapped_by(self, low: Floats, high: Floats) -> Iterator[tuple[Ints, Ints]]:
        """Pairs of one of some boxes (a, 3) and one in the tree, in batches of bounded size."""
        if len(low) == 0 or len(self.low) == 0:
            return
        if len(low) * len(self.low) <= FEW:
            apart = (low[:, None] > self.high).any(axis=2) | (self.low > high[:, None]).any(axis=2)
            first, second = np.nonzero(~apart)
            yield first, second
            return
        axis, diagonals = self._left_out, self._diagonals(low, high)
        begin, several = 0, 256  # before it is known how many others each overlaps
        while begin < len(diagonals):
            i, j = self._tree.query(diagonals[begin : begin + several]).astype(np.intp)
            i = i + begin
            near = low[i, axis] <= self.high[j, axis]
            near &= self.low[j, axis] <= high[i, axis]
            yield i[near], j[near]
            begin += several
            # parts of a body may be meshed more finely than others
            several = max(1, several * _PAIRS // max(len(i), _PAIRS // 64))


def touching(low_a: Floats, high_a: Floats, low_b: Floats, high_b: Floats) -> Bools:
    """Whether boxes (p, 3) overlap or touch, row by row."""
    apart = (low_a[:, 0] > high_b[:, 0]) | (low_b[:, 0] > high_a[:, 0])
    for axis in (1, 2):
        apart |= low_a[:, axis] > high_b[:, axis]
        apart |= low_b[:, axis] > high_a[:, axis]
    return ~apart
