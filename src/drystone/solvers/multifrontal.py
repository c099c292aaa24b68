"""Direct solution of block-sparse systems whose graph has positions in space.

The graph of blocks in contact is nearly planar or a thin solid, and every node has a position. A
nested dissection by coordinates, with the order of least degree in each part, is then close to the
optimal ordering. The order and all index maps are made once per graph. A factorisation processes
dense fronts with LAPACK, with partial pivoting inside each front.

The order of least degree eliminates the node with the fewest neighbours left. Nodes that are
eliminated next to each other then share a front where that takes less time than two fronts.

Sources: George 1973 (nested dissection); Tinney and Walker 1967 (least degree); Duff and Reid 1983
(multifrontal method, relaxed amalgamation).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from heapq import heapify, heappop, heappush
from typing import Any

import numpy as np
from scipy.linalg.blas import dgemm, sgemm
from scipy.linalg.lapack import dgetrf, dgetri, dgetrs, sgetrf, sgetri, sgetrs

from drystone.base.arrays import Floats, Ints, Singles
from drystone.base.errors import SolverError
from drystone.solvers.banded import Band

ENTRY = 40.0
"""Operations in the time that it takes to add a number of one front to the next: about a
nanosecond, measured on the Armadillo vault."""


def part_fronts(
    nodes: Ints, neighbours: tuple[Ints, Ints], width: int, overhead: float
) -> list[tuple[Ints, list[int]]]:
    """Fronts of a part of a graph: (nodes, children) per front, children first.

    Neighbours outside of the part are eliminated later.

    Parameters
    ----------
    nodes : (p,)
    neighbours
        As :func:`~drystone.solvers.multifrontal.adjacency` gives them.
    width
        Rows per node.
    overhead
        Operations in the time that a front takes however small it is.
    """

    def saved(one: int, other: int) -> float:
        """By eliminating the nodes of two fronts, of which the first comes earlier, in one."""
        p, b, q, c = len(pivots[one]), left[one], len(pivots[other]), left[other]
        apart = _work(width * p, width * b) + _work(width * q, width * c)
        return overhead + apart - _work(width * (p + q), width * c)

    order, boundaries = _by_degree(nodes, neighbours)
    rank = {node: number for number, node in enumerate(order)}
    outside = len(order)
    pivots = [[node] for node in order]
    children: list[list[int]] = [[] for _ in order]
    topmost: list[int] = []
    for number, boundary in enumerate(boundaries):
        parent = min((rank.get(node, outside) for node in boundary), default=outside)
        (children[parent] if parent < outside else topmost).append(number)
    left = [len(boundary) for boundary in boundaries]
    merged = [False] * len(order)

    def merge(one: int, other: int) -> None:
        """Eliminate the nodes of a front in another one, which comes later."""
        pivots[other] = pivots[one] + pivots[other]
        children[other] += children[one]
        merged[one] = True

    def alike(fronts: list[int]) -> list[int]:
        """Fronts with the same boundary, merged where that saves time; those that are left."""
        last: dict[frozenset[int], int] = {}
        for front in fronts:
            key = frozenset(boundaries[front])
            before = last.get(key)
            if before is not None and saved(before, front) > 0.0:
                merge(before, front)
            last[key] = front
        return [front for front in fronts if not merged[front]]

    for number in range(len(order)):
        below = children[number] = alike(children[number])
        while below:
            gains = [saved(child, number) for child in below]
            best = max(range(len(below)), key=gains.__getitem__)
            if gains[best] <= 0.0:
                break
            merge(below.pop(best), number)
    alike(topmost)
    kept = [number for number in range(len(order)) if not merged[number]]
    place = {number: at for at, number in enumerate(kept)}
    return [
        (np.array(pivots[number]), [place[child] for child in children[number]]) for number in kept
    ]


def _by_degree(nodes: Ints, neighbours: tuple[Ints, Ints]) -> tuple[list[int], list[set[int]]]:
    """Nodes in their order, and the nodes that each is coupled with when it is eliminated."""
    start, other = neighbours
    listed = nodes.tolist()
    left = {node: set(other[start[node] : start[node + 1]].tolist()) for node in listed}
    queue = [(len(left[node]), at, node) for at, node in enumerate(listed)]
    at_of = {node: at for at, node in enumerate(listed)}
    heapify(queue)
    order, boundaries = [], []
    while queue:
        degree, _, node = heappop(queue)
        if node not in left or degree != len(left[node]):
            continue  # eliminated, or queued again with another degree
        boundary = left.pop(node)
        for one in boundary:
            if one in left:
                coupled = left[one]
                coupled |= boundary
                coupled -= {one, node}
                heappush(queue, (len(coupled), at_of[one], one))
        order.append(node)
        boundaries.append(boundary)
    return order, boundaries


def _work(pivots: int, boundary: int) -> float:
    """Operations in the time that the arithmetic of a front takes.

    In units of those of a product of two matrices. Measured with 120 pivots, in operations a
    second: 57e9 in a product, 43e9 in a triangular solution, 24e9 to 35e9 in a factorisation.
    """
    p, b = float(pivots), float(boundary)
    return 1.1 * p**3 + 2.6 * p * p * b + 2.0 * p * b * b + ENTRY * b * b


WHOLE, PART = 400, 100
"""Nodes of a graph that is not cut, and of a part that is not cut any further. Within it the order
is that of the least degree. Measured: a factorisation of the Armadillo, 366 nodes, takes 1.8 ms in
place of 2.1 with cuts down to 100 nodes, and 2.5 with cuts down to 20 and none of the least degree.
Of 600 nodes and more, cuts down to 100 nodes take 0.88 to 0.98 of the time of those down to 400."""

OVERHEAD, LARGE_OVERHEAD = 1.5e5, 8e5
"""Operations in the time that a front takes however small it is; the same of a graph that is cut,
where one front is added to the next run by run. From timings: factors and a solution of an arch of
36 nodes take 0.095 ms with 1.5e5 and 0.128 with 4e5, those of a vault of 85 and of a dome of 126
as long; one of 1,958 nodes 33 ms with 5e5 and 32 with 7e5."""

LEAST_SIDE = 0.4
"""Share of the nodes on each side of a cut, at least. Measured: the Armadillo takes 51 million
operations, with cuts through the middle 62. Walls, a dome and a vault take 0.96 to 1.02 times as
many. With a share of 0.3 it would take 47, and the vault 1.06 times as many."""


def adjacency(count: int, row: Ints, column: Ints) -> tuple[Ints, Ints]:
    """Neighbours of each node, itself excluded: (start, neighbour)."""
    off = row != column
    order = np.argsort(row[off], kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(row[off], minlength=count))])
    return start.astype(np.intp), column[off][order].astype(np.intp)


def dissect(
    position: Floats, neighbours: tuple[Ints, Ints], width: int
) -> list[tuple[Ints, list[int]]]:
    """Nested dissection: (nodes, children) per front, children first; ``width`` rows per node.

    Of the cuts across the three axes the one with the fewest nodes between its sides is taken.
    """
    start, other = neighbours
    tree: list[tuple[Ints, list[int]]] = []
    place = np.full(len(position), -1)
    most, overhead = (WHOLE, OVERHEAD) if len(position) <= WHOLE else (PART, LARGE_OVERHEAD)

    def pairs_of(nodes: Ints) -> tuple[Ints, Ints]:
        """Places in ``nodes`` of all pairs of neighbours, in both orders."""
        lengths = start[nodes + 1] - start[nodes]
        index = np.repeat(start[nodes] - np.concatenate([[0], np.cumsum(lengths)[:-1]]), lengths)
        index += np.arange(lengths.sum())
        place[nodes] = np.arange(len(nodes))
        one, two = np.repeat(place[nodes], lengths), place[other[index]]
        place[nodes] = -1
        return one[two >= 0], two[two >= 0]

    def add(fronts: list[tuple[Ints, list[int]]]) -> list[int]:
        """Append the fronts of a part; the topmost ones are returned."""
        first = len(tree)
        tree.extend((own, [first + child for child in below]) for own, below in fronts)
        inner = {child for _, below in fronts for child in below}
        return [first + number for number in range(len(fronts)) if number not in inner]

    def split(nodes: Ints) -> list[int]:
        """Fronts of these nodes appended to the tree; the topmost ones are returned."""
        if len(nodes) == 0:
            return []
        if len(nodes) <= most:
            return add(part_fronts(nodes, neighbours, width, overhead))
        here = position[nodes]
        longest_first = np.argsort(here.min(axis=0) - here.max(axis=0), kind="stable")
        pairs = pairs_of(nodes)
        cuts = (_cut(np.argsort(here[:, axis], kind="stable"), pairs) for axis in longest_first)
        separator, low, high = min(cuts, key=lambda one: len(one[0]))
        below = [*split(nodes[low]), *split(nodes[high])]
        if len(separator) == 0:
            return below
        tree.append((nodes[separator], below))
        return [len(tree) - 1]

    split(np.arange(len(position)))
    return tree


def _cut(order: Ints, pairs: tuple[Ints, Ints]) -> tuple[Ints, Ints, Ints]:
    """The smallest separator of nodes in an order (n,), and the nodes before and after it.

    It is on one side of a cut near the middle, next to the other side. A node is needed there for
    every cut between itself and its farthest neighbour.
    """
    count = len(order)
    rank = np.empty(count, dtype=np.intp)
    rank[order] = at = np.arange(count)
    first, last = at.copy(), at.copy()
    one, two = rank[pairs[0]], rank[pairs[1]]
    np.minimum.at(first, one, two)
    np.maximum.at(last, one, two)
    own, lowest, highest = (np.bincount(x + 1, minlength=count + 1) for x in (at, first, last))
    before, after = np.cumsum(own - highest), np.cumsum(lowest - own)
    least = max(int(LEAST_SIDE * count), 1)
    cuts = np.arange(least, count - least + 1)
    fewest = np.minimum(before[cuts], after[cuts])
    cut = cuts[np.lexsort((np.abs(2 * cuts - count), fewest))[0]]
    low, high = at < cut, at >= cut
    parted = low & (last >= cut) if before[cut] <= after[cut] else high & (first < cut)
    return order[parted], order[low & ~parted], order[high & ~parted]


ROUTINES: dict[type, tuple[Any, Any, Any, Any]] = {
    np.float64: (dgetrf, dgetrs, dgetri, dgemm),
    np.float32: (sgetrf, sgetrs, sgetri, sgemm),
}
"""BLAS and LAPACK for each precision. Measured: with factors in single precision a check of
domes and vaults of 600 to 2,000 blocks takes 0.75 of the time."""

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
    """Factors of all fronts of a matrix.

    Where rough, pivots that are not twice as many as the rows of a boundary are inverted: in place
    of triangular solutions for each row of that, four fifths of the time. Others have triangular
    factors. Measured: with all of them inverted 126 Voronoi stones take 2.7 ms in place of 2.1.
    ``order`` has the nodes in the order of elimination.
    """

    def __init__(self, fronts: list[Front], order: Ints, factors: list[tuple[Any, ...]]) -> None:
        self.fronts, self.order, self.factors = fronts, order, factors

    def solve(self, right: Floats) -> Floats:
        """X (n, w) with ``matrix @ x = right``."""
        precision = self.factors[0][0].dtype.type if self.factors else np.float64
        getrs = ROUTINES[precision][1]
        x = right[self.order].astype(precision, copy=False).ravel()
        steps = list(zip(self.fronts, self.factors, strict=True))
        for front, (own, pivots, below, _) in steps:
            part = x[front.own_rows]
            part = getrs(own, pivots, part)[0] if len(pivots) else own @ part
            x[front.own_rows] = part
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

    def factorise(self, blocks: Floats | Singles, rough: bool = True) -> BlockFactor:
        """Factors of the matrix with the given blocks (e, w, w), in the order of row and column.

        The precision is that of the blocks. ``rough``: whether pivots may be inverted, which costs
        digits: with a friction of 10,000 forces are not found so.

        Raises
        ------
        SolverError
            A front is exactly singular.
        """
        left: dict[int, Floats] = {}
        factors: list[tuple[Any, ...]] = []
        getrf, getrs, getri, gemm = ROUTINES[blocks.dtype.type]
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
            own, pivots, failed = getrf(whole[:p, :p])
            if failed:
                raise SolverError(f"front {number} of the elimination is singular")
            below = coupling = whole[:p, p:]
            if size > p:
                if rough and p < 2 * (size - p):
                    own, _ = getri(own, pivots, overwrite_lu=True)
                    coupling, pivots = gemm(1.0, own, coupling), NONE
                else:
                    coupling, _ = getrs(own, pivots, coupling)
                below = whole[p:, :p].copy(order="F")
                left[number] = gemm(-1.0, below, coupling, 1.0, whole[p:, p:])
            factors.append((own, pivots, below, coupling))
        return BlockFactor(self.fronts, self.order, factors)


REACH = 100
"""Numbers on each side of the diagonal up to which a matrix is one band. Measured, factors and a
solution: an arch of 30 blocks, reach 11, takes 35 us in place of 256, a vault of 97, reach 65, 415
in place of 576, a dome of 98, reach 113, 674 in place of 666 and a wall of 200, reach 119, 2,909 in
place of 2,080."""


def ordering_of(position: Floats, row: Ints, column: Ints, width: int) -> BlockOrdering | Band:
    """As :class:`BlockOrdering`; of the same graph it is made once, and the last ones are kept.

    The order of a graph that is not cut depends on no position.
    """
    graph = row.tobytes(), column.tobytes(), width
    if len(position) <= WHOLE:
        return _ordering_of_graph(len(position), *graph)
    return _ordering_in_space(position.tobytes(), *graph)


@lru_cache(maxsize=2)  # as many as a check needs: at rest, and with the faces that blocks may meet
def _ordering_in_space(
    position: bytes, row: bytes, column: bytes, width: int
) -> BlockOrdering | Band:
    first, second = (np.frombuffer(nodes, dtype=np.intp) for nodes in (row, column))
    place = np.frombuffer(position).reshape(-1, 3)
    band = Band(len(place), first, second, width)
    return band if band.reach <= REACH else BlockOrdering(place, first, second, width)


@lru_cache(maxsize=16)
def _ordering_of_graph(count: int, row: bytes, column: bytes, width: int) -> BlockOrdering | Band:
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
