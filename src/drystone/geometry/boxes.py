"""Axis-aligned boxes that overlap."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.ragged import BATCH

_FEW = 4096
"""Up to so many pairs all are compared: faster than a tree, measured."""


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

    Notes
    -----
    shapely's STRtree finds the boxes that overlap along two axes. The third axis is the one along
    which the boxes cover the largest part of the extent. It would separate the fewest pairs, and is
    tested last.
    """
    if len(low_a) == 0 or len(low_b) == 0:
        return
    if len(low_a) * len(low_b) <= _FEW:
        apart = (low_a[:, None] > high_b).any(axis=2) | (low_b > high_a[:, None]).any(axis=2)
        first, second = np.nonzero(~apart)
        yield first, second
        return
    whole = np.maximum(high_a.max(axis=0), high_b.max(axis=0))
    whole = whole - np.minimum(low_a.min(axis=0), low_b.min(axis=0))
    mean = 0.5 * ((high_a - low_a).mean(axis=0) + (high_b - low_b).mean(axis=0))
    left_out = int(np.argmax(mean / np.where(whole > 0.0, whole, 1.0) + (whole == 0.0)))
    axes = [axis for axis in range(3) if axis != left_out]
    diagonal_a, diagonal_b = (
        shapely.linestrings(np.stack([low[:, axes], high[:, axes]], axis=1))
        for low, high in ((low_a, high_a), (low_b, high_b))
    )
    tree = shapely.STRtree(diagonal_b)
    begin, several = 0, 256  # before it is known how many others each overlaps
    while begin < len(diagonal_a):
        i, j = tree.query(diagonal_a[begin : begin + several]).astype(np.intp)
        i = i + begin
        near = low_a[i, left_out] <= high_b[j, left_out]
        near &= low_b[j, left_out] <= high_a[i, left_out]
        yield i[near], j[near]
        begin += several
        # parts of a body may be meshed more finely than others
        several = max(1, several * BATCH // max(len(i), BATCH // 64))


def touching(low_a: Floats, high_a: Floats, low_b: Floats, high_b: Floats) -> Bools:
    """Whether boxes (p, 3) overlap or touch, row by row."""
    apart = (low_a[:, 0] > high_b[:, 0]) | (low_b[:, 0] > high_a[:, 0])
    for axis in (1, 2):
        apart |= low_a[:, axis] > high_b[:, axis]
        apart |= low_b[:, axis] > high_a[:, axis]
    return ~apart
