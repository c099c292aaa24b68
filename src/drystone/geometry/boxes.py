"""Axis-aligned boxes that overlap, found through grids of cells that fit their sizes."""

from __future__ import annotations

import numpy as np

from drystone.arrays import Bools, Floats, Ints

MOST_LEVELS = 40
"""Boxes more than 2**40 times smaller than the largest share the finest grid; chosen, as float64
coordinates of such boxes side by side hold few digits of the smaller."""
BATCH = 2_000_000
"""Candidate pairs expanded at a time, chosen: bounds the memory to some 100 MB."""


def expand(first: Ints, count: Ints) -> tuple[Ints, Ints]:
    """All numbers of several ranges, and the range that each comes from.

    Parameters
    ----------
    first, count : (r,)
        Range i is ``first[i]`` to ``first[i] + count[i] - 1``.

    Returns
    -------
    source, value : (total,)

    Examples
    --------
    >>> source, value = expand(np.array([5, 0]), np.array([2, 3]))
    >>> source.tolist(), value.tolist()
    ([0, 0, 1, 1, 1], [5, 6, 0, 1, 2])
    """
    source = np.repeat(np.arange(len(count), dtype=np.intp), count)
    before = np.cumsum(count) - count
    value = np.arange(len(source), dtype=np.intp) + (first - before)[source]
    return source, value.astype(np.intp)


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
    One grid per size class, whose cells are as large as the largest box of the class: a box is
    compared with those of its own class and of smaller ones in the at most eight cells that it
    touches. A pair is kept in the cell of the lowest corner of its overlap only.
    """
    none = np.zeros(0, dtype=np.intp)
    if len(low_a) == 0 or len(low_b) == 0:
        return none, none
    origin = np.minimum(low_a.min(axis=0), low_b.min(axis=0))
    low_a, high_a, low_b, high_b = (x - origin for x in (low_a, high_a, low_b, high_b))
    extent_a, extent_b = (high_a - low_a).max(axis=1), (high_b - low_b).max(axis=1)
    largest = max(float(extent_a.max()), float(extent_b.max()))
    if largest == 0.0:
        largest = max(float(high_a.max()), float(high_b.max())) or 1.0
    level_a, level_b = _levels(extent_a, largest), _levels(extent_b, largest)
    found: list[tuple[Ints, Ints]] = []
    for level in np.union1d(level_a, level_b):
        cell = largest * 0.5 ** float(level)
        big_a, big_b = np.flatnonzero(level_a == level), np.flatnonzero(level_b == level)
        any_b, finer_a = np.flatnonzero(level_b >= level), np.flatnonzero(level_a > level)
        one = _join(low_a[big_a], high_a[big_a], low_b[any_b], high_b[any_b], cell)
        found += [(big_a[i], any_b[j]) for i, j in one]
        two = _join(low_b[big_b], high_b[big_b], low_a[finer_a], high_a[finer_a], cell)
        found += [(finer_a[j], big_b[i]) for i, j in two]
    first = np.concatenate([none, *(i for i, _ in found)])
    second = np.concatenate([none, *(j for _, j in found)])
    order = np.lexsort((second, first))
    return first[order], second[order]


def touching(low_a: Floats, high_a: Floats, low_b: Floats, high_b: Floats) -> Bools:
    """Whether boxes (p, 3) overlap or touch, row by row."""
    apart = (low_a[:, 0] > high_b[:, 0]) | (low_b[:, 0] > high_a[:, 0])
    for axis in (1, 2):
        apart |= low_a[:, axis] > high_b[:, axis]
        apart |= low_b[:, axis] > high_a[:, axis]
    return ~apart


def _levels(extent: Floats, largest: float) -> Ints:
    """Size class of each box: 0 for the largest, one more each time the size is halved."""
    share = np.maximum(extent / largest, 0.5**MOST_LEVELS)
    return np.floor(-np.log2(share) + 1e-9).astype(np.intp)


def _cells(low: Floats, high: Floats, cell: float) -> tuple[Ints, Ints]:
    """Box (e,) and cell (e, 3) of every cell that a box touches."""
    first = np.floor(low / cell).astype(np.intp)
    span = np.floor(high / cell).astype(np.intp) - first + 1
    box = np.arange(len(low), dtype=np.intp)
    cells = first
    for axis in range(3):
        source, step = expand(np.zeros(len(box), dtype=np.intp), span[box, axis])
        box, cells = box[source], cells[source]
        cells[:, axis] += step
    return box, cells


def _key(cells: Ints) -> Ints:
    """A number per cell; unlike cells may share one, which costs a comparison and no error.

    Source of the primes: Teschner et al. 2003, Optimized spatial hashing.
    """
    with np.errstate(over="ignore"):
        key: Ints = cells[:, 0] * 73856093 ^ cells[:, 1] * 19349663 ^ cells[:, 2] * 83492791
    return key


def _join(
    low_big: Floats, high_big: Floats, low_any: Floats, high_any: Floats, cell: float
) -> list[tuple[Ints, Ints]]:
    """Overlapping pairs of boxes that are no larger than a cell."""
    if len(low_big) == 0 or len(low_any) == 0:
        return []
    big, big_cell = _cells(low_big, high_big, cell)
    other, other_cell = _cells(low_any, high_any, cell)
    other_key = _key(other_cell)
    order = np.argsort(other_key, kind="stable")
    sorted_key, other = other_key[order], other[order]
    key = _key(big_cell)
    start = np.searchsorted(sorted_key, key, side="left")
    count = np.searchsorted(sorted_key, key, side="right") - start
    busy = np.flatnonzero(count)
    big, big_cell, start, count = big[busy], big_cell[busy], start[busy], count[busy]
    found = []
    batch = np.cumsum(count) // BATCH
    for number in range(int(batch[-1]) + 1 if len(batch) else 0):
        part = np.flatnonzero(batch == number)
        source, place = expand(start[part], count[part])
        entry = part[source]
        i, j = big[entry], other[place]
        keep = touching(low_big[i], high_big[i], low_any[j], high_any[j])
        i, j, entry = i[keep], j[keep], entry[keep]
        corner = np.floor(np.maximum(low_big[i], low_any[j]) / cell).astype(np.intp)
        home = (corner == big_cell[entry]).all(axis=1)
        found.append((i[home], j[home]))
    return found


__all__ = ["between", "expand", "overlapping", "touching"]
