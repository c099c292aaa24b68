"""Direct solution of block-sparse systems whose graph has positions in space.

The graph of blocks in contact is nearly planar or a thin solid, and every node has a position. A
nested dissection by coordinates, with the order of least degree in each part, is then close to the
optimal ordering. The order and all index maps are made once per graph. A factorisation processes
dense fronts with LAPACK, with partial pivoting inside each front.

Sources: George 1973 (nested dissection); Duff and Reid 1983 (multifrontal method).
"""

from __future__ import annotations

import weakref
from itertools import pairwise
from typing import Any

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.errors import SolverError
from drystone.solvers.dissection import adjacency, dissect
from drystone.solvers.front_factors import (
    BlockFactor,
    Front,
    Precision,
    Run,
    SymmetricFactor,
    eliminated,
    eliminated_symmetric,
)
from drystone.solvers.front_memory import FrontMemory, FrontPlaces

ONE_FRONT = 20
"""Nodes up to which a matrix is one front, whatever its graph: it takes 0.2 ms less to prepare."""

MOST_RUNS = 16
"""Runs up to which a front is added to the next one run by run, by slices."""

KEPT = 32_000_000
"""Numbers up to which the memory of factors is kept for the next ones (256 MB). Measured on the
Armadillo vault of 399 blocks: a check takes a quarter less time, since no pages are given back to
the system and taken again."""


NONE = np.zeros(0, dtype=np.intp)
"""No nodes."""


class BlockOrdering:
    """The symbolic factorisation: the place of every matrix block, for a fixed graph.

    Pivots are exchanged within a front only. So nodes whose own blocks are nearly singular cost
    digits; those of blocks on springs are not.

    Parameters
    ----------
    position : (n, 3) place of each node
    row, column : (e,) node pairs of the matrix blocks: (i, j), (j, i) and (i, i), once each
    width
        Rows per node.
    """

    def __init__(self, position: Floats, row: Ints, column: Ints, width: int) -> None:
        self.count = len(position)
        self.width = width
        if self.count <= ONE_FRONT:
            self.fronts = _one_front(self.count, width)
        else:
            neighbours = adjacency(self.count, row, column)
            tree = dissect(position, neighbours, width)
            self.fronts = _fronts(tree, neighbours, self.count, width)
        self.order = np.concatenate([front.pivots for front in self.fronts] or [NONE])
        self.places = FrontPlaces(self.fronts, width)
        self.entry = self.places.entries(self.count, row, column)
        self._free: list[FrontMemory] = []

    def __getstate__(self) -> dict[str, Any]:
        """What travels to another process: without memory that is kept for the next factors."""
        return self.__dict__ | {"_free": []}

    def factorise(
        self, blocks: Floats, precision: Precision = np.float64, *, symmetric: bool = False
    ) -> BlockFactor | SymmetricFactor:
        """Factors of the matrix with the given blocks (e, w, w), in the order of row and column.

        Single precision takes about half of the time, and half of the memory of large factors. A
        matrix that is ``symmetric`` and positive definite is factorised by Cholesky's method, in
        double precision.

        Raises
        ------
        SolverError
            A front is exactly singular, or not positive definite where it is said to be symmetric.
        """
        schur: dict[int, Floats] = {}
        factors = []
        memory = self._memory(precision)
        memory.clear(precision)[self.entry] = blocks.astype(precision, copy=False)
        for number, front in enumerate(self.fronts):
            whole, first, right, below, rest = memory.of_front(number, precision)
            if self.places.with_rest:
                for (child, _), index in zip(front.children, self.places.flat[number], strict=True):
                    np.add.at(whole, index, schur.pop(child).ravel())
            else:
                _add_runs(front, schur, first, right, below, rest, symmetric=symmetric)
            try:
                if symmetric:
                    done, left = eliminated_symmetric(first, below, rest)
                else:
                    done, left = eliminated(first, right, below, rest)
            except SolverError as error:
                raise SolverError(f"front {number} of the elimination is {error}") from None
            factors.append(done)
            if len(front.boundary):
                schur[number] = left
        factor = (
            SymmetricFactor(self.fronts, self.order, factors)
            if symmetric
            else BlockFactor(self.fronts, self.order, factors, precision)
        )
        if self.places.size <= KEPT:
            weakref.finalize(factor, self._free.append, memory).atexit = False
        return factor

    def _memory(self, precision: Precision) -> FrontMemory:
        """Memory that no factors use any longer, or new memory."""
        if self.places.size > KEPT:
            return FrontMemory(self.places, precision)
        try:
            return self._free.pop()
        except IndexError:  # none is left, or another thread was faster
            return FrontMemory(self.places)


def _add_runs(
    front: Front,
    schur: dict[int, Floats],
    first: Floats,
    right: Floats,
    below: Floats,
    rest: Floats,
    *,
    symmetric: bool,
) -> None:
    """Add what earlier fronts left to a front, run by run."""
    quarter = ((rest, right), (below, first))
    for child, runs in front.children:
        update = schur.pop(child)
        for turn, of in enumerate(runs):
            # of a symmetric matrix, the half above the diagonal: runs are in its order
            for by in runs[turn if symmetric else 0 :]:
                target = quarter[of.inner][by.inner]
                if isinstance(of.there, slice) or isinstance(by.there, slice):
                    target[of.there, by.there] += update[of.here, by.here]
                else:
                    target[of.there[:, None], by.there] += update[of.here, by.here]


def _one_front(count: int, width: int) -> list[Front]:
    """A matrix of few nodes as one front."""
    if not count:
        return []
    return [Front(np.arange(count), NONE, (), slice(0, count * width), NONE)]


def _fronts(
    tree: list[tuple[Ints, list[int]]], neighbours: tuple[Ints, Ints], count: int, width: int
) -> list[Front]:
    start, other = neighbours
    front_of = np.empty(count, dtype=np.intp)
    for number, (nodes, _) in enumerate(tree):
        front_of[nodes] = number
    rank = _ranks(front_of, neighbours)
    place = np.empty(count, dtype=np.intp)
    boundaries: list[Ints] = []
    steps = []
    for number, (nodes, children) in enumerate(tree):
        pivots = nodes[np.argsort(rank[nodes])]
        later = [boundaries[c] for c in children]
        later += [other[start[i] : start[i + 1]] for i in pivots.tolist()]
        reach = np.unique(np.concatenate(later)) if later else NONE
        boundary = reach[front_of[reach] > number]
        boundary = boundary[np.argsort(rank[boundary])]
        boundaries.append(boundary)
        place[pivots], place[boundary] = np.arange(len(pivots)), np.arange(len(boundary))
        # a front without a boundary is a separate part
        moved = tuple(
            (c, _runs(place[boundaries[c]], front_of[boundaries[c]] == number, width))
            for c in children
            if len(boundaries[c])
        )
        steps.append((pivots, boundary, moved))
    place[np.concatenate([pivots for pivots, _, _ in steps])] = np.arange(count)
    inside, fronts, first = np.arange(width), [], 0
    for pivots, boundary, moved in steps:
        own = slice(first, first + width * len(pivots))
        rows = (width * place[boundary][:, None] + inside).ravel()
        fronts.append(Front(pivots, boundary, moved, own, rows))
        first = own.stop
    return fronts


def _ranks(front_of: Ints, neighbours: tuple[Ints, Ints]) -> Ints:
    """A rank (n,) per node: front by front, and within it after the first front that it touches.

    The nodes of a separator that a part of the graph touches then follow each other.
    """
    start, other = neighbours
    touched = front_of.copy()
    np.minimum.at(touched, np.repeat(np.arange(len(front_of)), np.diff(start)), front_of[other])
    rank = np.empty(len(front_of), dtype=np.intp)
    rank[np.lexsort((touched, front_of))] = np.arange(len(front_of))
    return rank


def _runs(place: Ints, inner: Bools, width: int) -> tuple[Run, ...]:
    """The runs of the boundary of a front, with its places in the next front."""
    breaks = (np.diff(place) != 1) | (inner[1:] != inner[:-1])
    ends = [0, *(np.flatnonzero(breaks) + 1).tolist(), len(place)]
    runs = []
    if len(ends) - 1 > MOST_RUNS:
        split = int(np.count_nonzero(inner))
        for low, high in ((0, split), (split, len(place))):
            if high > low:
                index = width * place[low:high, None] + np.arange(width)
                runs.append(Run(low < split, slice(low * width, high * width), index.ravel()))
        return tuple(runs)
    for low, high in pairwise(ends):
        at = int(place[low])
        there = slice(at * width, (at + high - low) * width)
        runs.append(Run(bool(inner[low]), slice(low * width, high * width), there))
    return tuple(runs)
