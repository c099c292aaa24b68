"""Axis-aligned boxes that overlap."""

from __future__ import annotations

import numpy as np
import shapely

from drystone.base.arrays import Bools, Floats, Ints

_BATCH = 20_000
"""Boxes in one batch. Chosen: bounds the memory."""


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

    Notes
    -----
    shapely's STRtree finds the boxes that overlap along two axes. The third axis is the one along
    which the boxes cover the largest part of the extent. It would separate the fewest pairs, and is
    tested last.
    """
    none = np.zeros(0, dtype=np.intp)
    if len(low_a) == 0 or len(low_b) == 0:
        return none, none
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
    found = [np.zeros((2, 0), dtype=np.intp)]
    for begin in range(0, len(diagonal_a), _BATCH):
        i, j = tree.query(diagonal_a[begin : begin + _BATCH])
        i = i + begin
        near = low_a[i, left_out] <= high_b[j, left_out]
        near &= low_b[j, left_out] <= high_a[i, left_out]
        found.append(np.stack([i[near], j[near]]))
    first, second = np.concatenate(found, axis=1).astype(np.intp)
    order = np.lexsort((second, first))
    return first[order], second[order]


def touching(low_a: Floats, high_a: Floats, low_b: Floats, high_b: Floats) -> Bools:
    """Whether boxes (p, 3) overlap or touch, row by row."""
    apart = (low_a[:, 0] > high_b[:, 0]) | (low_b[:, 0] > high_a[:, 0])
    for axis in (1, 2):
        apart |= low_a[:, axis] > high_b[:, axis]
        apart |= low_b[:, axis] > high_a[:, axis]
    return ~apart
