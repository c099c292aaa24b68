"""Direct solution of block-sparse systems whose graph has positions in space.

The graph of blocks in contact is nearly planar or a thin solid, and every node has a position. A
nested dissection by coordinates, with the order of least degree in each part, is then close to the
optimal ordering. The order and all index maps are made once per graph. A factorisation processes
dense fronts with LAPACK, with partial pivoting inside each front.

Sources: George 1973 (nested dissection); Duff and Reid 1983 (multifrontal method).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dgemm, sgemm
from scipy.linalg.lapack import dgetrf, dgetrs, sgetrf, sgetrs

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import SolverError
from drystone.solvers.dissection import WHOLE, adjacency, dissect

ONE_FRONT = 20
"""Nodes up to which a matrix is one front, whatever its graph: it takes 0.2 ms less to prepare."""

ROUTINES: dict[type, tuple[Any, Any, Any]] = {
    np.float64: (dgetrf, dgetrs, dgemm),
    np.float32: (sgetrf, sgetrs, sgemm),
}
"""BLAS and LAPACK for each precision. Measured: with factors in single precision a check of
domes and vaults of 600 to 2,000 blocks takes 0.75 of the time."""

Singles = NDArray[np.float32]

NONE = np.zeros(0, dtype=np.intp)
"""No nodes."""

INDEXED = 10_000_000
"""Numbers that all fronts add to later ones, up to which their places are kept (80 MB). Measured: a
check of walls, domes and vaults of 2,000 to 3,630 blocks takes nine tenths of the time."""


@dataclass(frozen=True, eq=False)
class Front:
    """One dense step of the elimination: a square matrix, the pivots first, then the boundary.

    Attributes
    ----------
    pivots, boundary
        Nodes eliminated here, and later nodes that they are coupled with.
    children
        Earlier fronts, with the row of this front of each of their boundary's rows.
    own_rows, later_rows
        Places of the pivots and of the boundary among all rows, in the order of elimination.
    """

    pivots: Ints
    boundary: Ints
    children: tuple[tuple[int, Ints], ...]
    own_rows: slice
    later_rows: Ints


class BlockFactor:
    """Triangular factors of all fronts of a matrix.

    ``order`` has the nodes in the order of elimination.
    """

    def __init__(self, fronts: list[Front], order: Ints, factors: list[tuple[Any, ...]]) -> None:
        self.fronts, self.order, self.factors = fronts, order, factors

    def solve(self, right: Floats) -> Floats:
        """X (n, w) with ``matrix @ x = right``."""
        precision = self.factors[0][0].dtype.type if self.factors else np.float64
        _, getrs, _ = ROUTINES[precision]
        x = right[self.order].astype(precision, copy=False).ravel()
        steps = list(zip(self.fronts, self.factors, strict=True))
        for front, (lu, pivots, below, _) in steps:
            part = x[front.own_rows] = getrs(lu, pivots, x[front.own_rows])[0]
            if below.size:
                x[front.later_rows] -= below @ part
        for front, (_, _, _, coupling) in reversed(steps):
            if coupling.size:
                x[front.own_rows] -= coupling @ x[front.later_rows]
        solved = np.empty(right.shape)
        solved[self.order] = x.reshape(right.shape)
        return solved


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
        neighbours = adjacency(self.count, row, column)
        tree: list[tuple[Ints, list[int]]] = [(np.arange(self.count), [])] if self.count else []
        if self.count > ONE_FRONT:
            tree = dissect(position, neighbours, width)
        self.fronts = _fronts(tree, neighbours, self.count, width)
        self.sizes = [
            (width * len(front.pivots), width * (len(front.pivots) + len(front.boundary)))
            for front in self.fronts
        ]
        self.largest = max((size for _, size in self.sizes), default=0)
        added = sum(len(rows) ** 2 for front in self.fronts for _, rows in front.children)
        self.added = [self._added(front) for front in self.fronts] if added <= INDEXED else None
        self.order = np.concatenate([front.pivots for front in self.fronts] or [NONE])
        self._place_entries(row, column)

    def _place_entries(self, row: Ints, column: Ints) -> None:
        """Where every number of the matrix belongs, front by front.

        ``blocks`` has the matrix blocks (e,) in the order of the fronts, ``bounds`` where those of
        each front begin, ``entry`` the place (e, w, w) of each number in its front.
        """
        front_of = np.empty(self.count, dtype=np.intp)
        for number, front in enumerate(self.fronts):
            front_of[front.pivots] = number
        by_front = np.minimum(front_of[row], front_of[column])
        self.blocks = np.argsort(by_front, kind="stable")
        self.bounds = np.searchsorted(by_front[self.blocks], np.arange(len(self.fronts) + 1))
        place = np.empty(self.count, dtype=np.intp)
        inside = np.arange(self.width)
        self.entry = np.empty((len(row), self.width, self.width), dtype=np.intp)
        for number, front in enumerate(self.fronts):
            nodes = np.concatenate([front.pivots, front.boundary])
            place[nodes] = self.width * np.arange(len(nodes))
            part = slice(self.bounds[number], self.bounds[number + 1])
            here = self.blocks[part]
            rows, columns = (place[each[here]][:, None] + inside for each in (row, column))
            height = self.width * len(nodes)
            self.entry[part] = rows[:, :, None] + height * columns[:, None, :]

    def _added(self, front: Front) -> list[tuple[int, Ints]]:
        """Earlier fronts that add to a front, and the place in it of each number that they add."""
        size = self.width * (len(front.pivots) + len(front.boundary))
        return [(child, (rows[:, None] * size + rows).ravel()) for child, rows in front.children]

    def factorise(self, blocks: Floats | Singles) -> BlockFactor:
        """Factors of the matrix with the given blocks (e, w, w), in the order of row and column.

        The precision is that of the blocks.

        Raises
        ------
        SolverError
            A front is exactly singular.
        """
        left: dict[int, Floats] = {}
        factors: list[tuple[Any, ...]] = []
        getrf, getrs, gemm = ROUTINES[blocks.dtype.type]
        number_of, bounds = blocks[self.blocks], self.bounds.tolist()
        memory = np.empty(self.largest**2, blocks.dtype)  # of one front after the other
        for number, (p, size) in enumerate(self.sizes):
            part = slice(bounds[number], bounds[number + 1])
            flat = memory[: size * size]
            flat.fill(0.0)
            flat[self.entry[part]] = number_of[part]
            added = self.added[number] if self.added else self._added(self.fronts[number])
            for child, places in added:
                np.add.at(flat, places, left.pop(child).ravel(order="K"))
            whole = flat.reshape(size, size).T
            lu, pivots, failed = getrf(whole[:p, :p])
            if failed:
                raise SolverError(f"front {number} of the elimination is singular")
            coupling = whole[:p, p:]
            if size > p:
                coupling, _ = getrs(lu, pivots, coupling)
                below = whole[p:, :p].copy(order="F")
                left[number] = gemm(-1.0, below, coupling, 1.0, whole[p:, p:])
            factors.append((lu, pivots, below if size > p else coupling, coupling))
        return BlockFactor(self.fronts, self.order, factors)


def ordering_of(position: Floats, row: Ints, column: Ints, width: int) -> BlockOrdering:
    """As :class:`BlockOrdering`; of the same graph it is made once, and the last ones are kept.

    The order of a graph that is not cut depends on no position.
    """
    graph = row.tobytes(), column.tobytes(), width
    if len(position) <= WHOLE:
        return _ordering_of_graph(len(position), *graph)
    return _ordering_in_space(position.tobytes(), *graph)


@lru_cache(maxsize=2)  # as many as a check needs: at rest, and with the faces that blocks may meet
def _ordering_in_space(position: bytes, row: bytes, column: bytes, width: int) -> BlockOrdering:
    first, second = (np.frombuffer(nodes, dtype=np.intp) for nodes in (row, column))
    return BlockOrdering(np.frombuffer(position).reshape(-1, 3), first, second, width)


@lru_cache(maxsize=16)
def _ordering_of_graph(count: int, row: bytes, column: bytes, width: int) -> BlockOrdering:
    return _ordering_in_space.__wrapped__(bytes(24 * count), row, column, width)


def _fronts(
    tree: list[tuple[Ints, list[int]]], neighbours: tuple[Ints, Ints], count: int, width: int
) -> list[Front]:
    start, other = neighbours
    front_of = np.empty(count, dtype=np.intp)
    for number, (nodes, _) in enumerate(tree):
        front_of[nodes] = number
    at, inside = np.empty(count, dtype=np.intp), np.arange(width)

    def rows_of(nodes: Ints) -> Ints:
        return (width * at[nodes][:, None] + inside).ravel()

    boundaries: list[Ints] = []
    children = []
    for number, (pivots, below) in enumerate(tree):
        later = [boundaries[child] for child in below]
        later += [other[start[i] : start[i + 1]] for i in pivots.tolist()]
        reach = np.unique(np.concatenate(later)) if later else NONE
        boundary = reach[front_of[reach] > number]
        boundaries.append(boundary[np.argsort(front_of[boundary], kind="stable")])
        nodes = np.concatenate([pivots, boundaries[-1]])
        at[nodes] = np.arange(len(nodes))
        # a front without a boundary is a separate part
        children.append(
            tuple((child, rows_of(boundaries[child])) for child in below if len(boundaries[child]))
        )
    at[np.concatenate([nodes for nodes, _ in tree] or [NONE])] = np.arange(count)
    fronts, first = [], 0
    for (pivots, _), boundary, moved in zip(tree, boundaries, children, strict=True):
        own = slice(first, first + width * len(pivots))
        fronts.append(Front(pivots, boundary, moved, own, rows_of(boundary)))
        first = own.stop
    return fronts
