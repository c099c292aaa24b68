"""Direct solution of block-sparse systems whose graph has positions in space.

The graph of blocks in contact is nearly planar or a thin solid, and every node has a position. A
nested dissection by coordinates is then close to the optimal ordering. The order and all index maps
are made once per graph. A factorisation processes dense fronts with LAPACK, with partial pivoting
inside each front.

Sources: George 1973 (nested dissection); Duff and Reid 1983 (multifrontal method).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dgemm
from scipy.linalg.lapack import dgetrf, dgetrs

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import SolverError

LEAF = 20
"""Nodes that are not divided further. Chosen by timing: smaller fronts cost more in bookkeeping
than they save in arithmetic."""


@dataclass(frozen=True, eq=False)
class _Front:
    """One dense step of the elimination.

    Attributes
    ----------
    pivots, boundary
        Nodes eliminated here, and later nodes that they are coupled with.
    entry, row, column
        Matrix blocks that enter here, and their place in the front.
    children
        Earlier fronts, with the place of their boundary in this front.
    """

    pivots: Ints
    boundary: Ints
    entry: Ints
    row: Ints
    column: Ints
    children: tuple[tuple[int, Ints], ...]


class BlockOrdering:
    """The symbolic factorisation: the place of every matrix block, for a fixed graph.

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
        if self.count <= LEAF:
            self.fronts = _one_front(self.count, row, column)
        else:
            neighbours = _adjacency(self.count, row, column)
            tree = _dissect(position, neighbours)
            self.fronts = _fronts(tree, neighbours, self.count, row, column)

    def factorise(self, blocks: Floats) -> BlockFactor:
        """Factors of the matrix with the given blocks (e, w, w), in the order of row and column.

        Raises
        ------
        SolverError
            A front is exactly singular.
        """
        w = self.width
        schur: dict[int, Floats] = {}
        factors = []
        turned = blocks.transpose(0, 2, 1)
        for number, front in enumerate(self.fronts):
            p, size = len(front.pivots), len(front.pivots) + len(front.boundary)
            # column by column in memory, as LAPACK takes it
            dense = np.zeros((size, w, size, w))
            dense[front.column, :, front.row, :] = turned[front.entry]
            for child, place in front.children:
                update = schur.pop(child).T
                b = len(place)
                dense[place[:, None], :, place[None, :], :] += update.reshape(b, w, b, w).transpose(
                    0, 2, 1, 3
                )
            flat = dense.reshape(size * w, size * w).T
            inner = p * w
            first = np.asfortranarray(flat[:inner, :inner])
            lu, pivots, info = dgetrf(first, overwrite_a=True)
            if info != 0:
                raise SolverError(f"front {number} of the elimination is singular")
            if size > p:
                right = np.asfortranarray(flat[:inner, inner:])
                coupling, _ = dgetrs(lu, pivots, right, overwrite_b=True)
                below, rest = (
                    np.asfortranarray(flat[inner:, cut])
                    for cut in (slice(0, inner), slice(inner, None))
                )
                schur[number] = dgemm(-1.0, below, coupling, 1.0, rest, overwrite_c=True)
            else:
                coupling = below = np.zeros((0, 0))
            factors.append((lu, pivots, coupling, below))
        return BlockFactor(self, factors)


class BlockFactor:
    """The numerical factorisation of one matrix."""

    def __init__(
        self, ordering: BlockOrdering, factors: list[tuple[Floats, Ints, Floats, Floats]]
    ) -> None:
        self.ordering = ordering
        self.factors = factors

    def solve(self, right: Floats) -> Floats:
        """X (n, w) with ``matrix @ x = right``."""
        x = np.array(right, dtype=np.float64).reshape(self.ordering.count, self.ordering.width)
        fronts = self.ordering.fronts
        for front, (lu, pivots, _, below) in zip(fronts, self.factors, strict=True):
            part, _ = dgetrs(lu, pivots, x[front.pivots].ravel())
            x[front.pivots] = part.reshape(-1, x.shape[1])
            if len(front.boundary):
                x[front.boundary] -= (below @ part).reshape(-1, x.shape[1])
        for front, (_, _, coupling, _) in zip(fronts[::-1], self.factors[::-1], strict=True):
            if len(front.boundary):
                x[front.pivots] -= (coupling @ x[front.boundary].ravel()).reshape(-1, x.shape[1])
        return x


def _one_front(count: int, row: Ints, column: Ints) -> list[_Front]:
    """A matrix of few nodes as one front."""
    if not count:
        return []
    none = np.zeros(0, dtype=np.intp)
    return [_Front(np.arange(count), none, np.arange(len(row)), row, column, ())]


def _adjacency(count: int, row: Ints, column: Ints) -> tuple[Ints, Ints]:
    """Neighbours of each node, itself excluded: (start, neighbour)."""
    off = row != column
    order = np.argsort(row[off], kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(row[off], minlength=count))])
    return start.astype(np.intp), column[off][order].astype(np.intp)


def _dissect(position: Floats, neighbours: tuple[Ints, Ints]) -> list[tuple[Ints, list[int]]]:
    """Nested dissection: (nodes, children) per front, children first."""
    start, other = neighbours
    tree: list[tuple[Ints, list[int]]] = []
    side = np.zeros(len(position), dtype=np.int8)

    def neighbours_of(nodes: Ints) -> tuple[Ints, Ints]:
        lengths = start[nodes + 1] - start[nodes]
        index = np.repeat(start[nodes] - np.concatenate([[0], np.cumsum(lengths)[:-1]]), lengths)
        index += np.arange(lengths.sum())
        return np.repeat(np.arange(len(nodes)), lengths), other[index]

    def split(nodes: Ints) -> list[int]:
        """Fronts of these nodes appended to the tree; the topmost ones are returned."""
        if len(nodes) == 0:
            return []
        if len(nodes) <= LEAF:
            tree.append((nodes, []))
            return [len(tree) - 1]
        here = position[nodes]
        axis = int(np.argmax(here.max(axis=0) - here.min(axis=0)))
        ranked = nodes[np.argsort(here[:, axis], kind="stable")]
        low, high = ranked[: len(ranked) // 2], ranked[len(ranked) // 2 :]
        side[low], side[high] = 1, 2
        touching = []
        for nodes_here, opposite in ((low, 2), (high, 1)):
            which, near = neighbours_of(nodes_here)
            touching.append(np.unique(which[side[near] == opposite]))
        side[nodes] = 0
        if len(touching[0]) <= len(touching[1]):
            separator = low[touching[0]]
            low = np.delete(low, touching[0])
        else:
            separator = high[touching[1]]
            high = np.delete(high, touching[1])
        below = [*split(low), *split(high)]
        if len(separator) == 0:
            return below
        tree.append((separator, below))
        return [len(tree) - 1]

    split(np.arange(len(position)))
    return tree


def _fronts(
    tree: list[tuple[Ints, list[int]]],
    neighbours: tuple[Ints, Ints],
    count: int,
    row: Ints,
    column: Ints,
) -> list[_Front]:
    start, other = neighbours
    front_of = np.empty(count, dtype=np.intp)
    for number, (nodes, _) in enumerate(tree):
        front_of[nodes] = number
    first = np.minimum(front_of[row], front_of[column])
    by_front = np.argsort(first, kind="stable")
    bounds = np.searchsorted(first[by_front], np.arange(len(tree) + 1))
    place = np.empty(count, dtype=np.intp)
    boundaries: list[Ints] = []
    fronts = []
    for number, (nodes, children) in enumerate(tree):
        later = [boundaries[c] for c in children]
        later += [other[start[i] : start[i + 1]] for i in nodes.tolist()]
        reach = np.unique(np.concatenate(later)) if later else np.zeros(0, dtype=np.intp)
        boundary = reach[front_of[reach] > number]
        boundary = boundary[np.argsort(front_of[boundary], kind="stable")]
        boundaries.append(boundary)
        members = np.concatenate([nodes, boundary])
        place[members] = np.arange(len(members))
        entry = by_front[bounds[number] : bounds[number + 1]]
        fronts.append(
            _Front(
                nodes,
                boundary,
                entry,
                place[row[entry]],
                place[column[entry]],
                # a front without a boundary is a separate part
                tuple((c, place[boundaries[c]].copy()) for c in children if len(boundaries[c])),
            )
        )
    return fronts
