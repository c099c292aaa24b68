"""Where the parts of all fronts of a factorisation lie in one piece of memory.

Front by front: pivots by pivots, pivots by boundary, boundary by pivots, and in small models also
boundary by boundary. They are transposed: column by column in memory, as LAPACK takes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import Any, TypeAlias

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.solvers.front_factors import Front, Precision, Run

FLAT = 2_000_000
"""Numbers of all fronts up to which every number that one front adds to the next has an index of
its own (16 MB at most). Measured on the Armadillo vault, with 0.8 million: to add all fronts takes
0.9 ms in place of 3.1, of 13 for a factorisation."""


FrontParts: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats]
"""The memory of a front, and the four parts of it."""


class FrontPlaces:
    """The places of the parts of all fronts.

    Parameters
    ----------
    fronts
    width
        Rows per node.

    Attributes
    ----------
    size
        Numbers of all parts.
    flat
        Of small models, for each front and each of its children, the place (c * c,) in the memory
        of the front of every number that the child adds; empty for larger ones.
    """

    def __init__(self, fronts: Sequence[Front], width: int) -> None:
        self.fronts, self.width = fronts, width
        self.rows = [(width * len(one.pivots), width * len(one.boundary)) for one in fronts]
        whole = sum((p + b) ** 2 for p, b in self.rows)
        self.with_rest = whole <= FLAT
        sizes = ((p + 2 * b) * p + self.with_rest * b * b for p, b in self.rows)
        self.at = list(accumulate(sizes, initial=0))
        self.size = self.at[-1]
        self.flat: list[list[Ints]] = []
        if self.with_rest:
            self.flat = [
                [self._index(number, runs, self.rows[child][1]) for child, runs in one.children]
                for number, one in enumerate(fronts)
            ]

    def views(self, parts: Floats, number: int) -> FrontParts:
        """All parts of a front as one vector, and each of the four.

        The four are pivots by pivots, pivots by boundary, boundary by pivots, and boundary by
        boundary. In large models the last one is new memory. A front shares no memory with its
        children, so nothing is copied.
        """
        p, b = self.rows[number]
        first, right, below, rest = self._begins(number)
        return (
            parts[self.at[number] : self.at[number + 1]],
            parts[first:right].reshape(p, p),
            parts[right:below].reshape(b, p),
            parts[below:rest].reshape(p, b),
            parts[rest : rest + b * b].reshape(b, b)
            if self.with_rest
            else np.zeros((b, b), parts.dtype),
        )

    def entries(self, count: int, row: Ints, column: Ints) -> Ints:
        """The place (e, w, w) of the matrix blocks of pairs of nodes (e,), of ``count`` in all."""
        fronts, width = self.fronts, self.width
        front_of = np.empty(count, dtype=np.intp)
        for number, front in enumerate(fronts):
            front_of[front.pivots] = number
        by_front = np.minimum(front_of[row], front_of[column])
        order = np.argsort(by_front, kind="stable")
        bounds = np.searchsorted(by_front[order], np.arange(len(fronts) + 1))
        place = np.empty(count, dtype=np.intp)
        corner, stride = np.empty(len(row), dtype=np.intp), np.empty(len(row), dtype=np.intp)
        for number, front in enumerate(fronts):
            p, b = self.rows[number]
            first, right, below, _ = self._begins(number)
            place[front.pivots] = np.arange(len(front.pivots))
            place[front.boundary] = np.arange(len(front.boundary))
            here = order[bounds[number] : bounds[number + 1]]
            outer_row, outer_column = front_of[row[here]] > number, front_of[column[here]] > number
            begin = np.where(outer_row, below, np.where(outer_column, right, first))
            stride[here] = np.where(outer_row, b, p)
            corner[here] = begin + width * (place[row[here]] + place[column[here]] * stride[here])
        inside = np.arange(width)
        entry: Ints = corner[:, None, None] + inside[:, None] + inside * stride[:, None, None]
        return entry

    def _begins(self, number: int) -> tuple[int, int, int, int]:
        """Where the four parts of a front begin."""
        (p, b), at = self.rows[number], self.at[number]
        return at, at + p * p, at + (p + b) * p, at + (p + 2 * b) * p

    def _index(self, number: int, runs: Sequence[Run], count: int) -> Ints:
        """The place of every number that a child with ``count`` rows adds to a front."""
        p, b = self.rows[number]
        first, right, below, rest = (begin - self.at[number] for begin in self._begins(number))
        quarter = (((rest, b), (right, p)), ((below, b), (first, p)))
        index = np.empty((count, count), dtype=np.intp)
        for of in runs:
            for by in runs:
                begin, stride = quarter[of.inner][by.inner]
                index[of.here, by.here] = begin + _rows(of)[:, None] * stride + _rows(by)
        return index.ravel()


def _rows(run: Run) -> Ints:
    """The places of a run in the next front."""
    there = run.there
    return np.arange(there.start, there.stop) if isinstance(there, slice) else there


class FrontMemory:
    """The memory of one factorisation.

    It is used again by later ones, in double and in single precision. Measured on the Armadillo
    vault: with half of the memory for single precision the system takes back what is freed ten
    times as often, and a check takes a tenth longer. Memory made for single precision is half as
    large, and for that only.
    """

    def __init__(self, places: FrontPlaces, precision: Precision = np.float64) -> None:
        self.places = places
        numbers: Any = np.zeros(places.size, precision)
        self._parts: dict[Precision, Floats] = {precision: numbers}
        if precision is np.float64:
            self._parts[np.float32] = numbers.view(np.float32)[: places.size]
        self._views: dict[Precision, list[FrontParts]] = {}
        self._used = False

    def clear(self, precision: Precision) -> Floats:
        """Zero for all fronts."""
        parts = self._parts[precision]
        if self._used:
            parts.fill(0.0)
        self._used = True
        return parts

    def of_front(self, number: int, precision: Precision) -> FrontParts:
        """As :meth:`FrontPlaces.views`; those of small models are made once."""
        places, parts = self.places, self._parts[precision]
        if not places.with_rest:
            return places.views(parts, number)
        views = self._views.get(precision)
        if views is None:
            count = len(places.fronts)
            views = self._views[precision] = [places.views(parts, one) for one in range(count)]
        return views[number]
