"""Nested dissection by coordinates: in which order the nodes of a graph in space are eliminated.

Parts are eliminated by minimum degree: the next node is the one with the fewest neighbours left.
Nodes that are eliminated next to each other then share a front where that takes less time than two
fronts.

Sources: George 1973 (dissection); Tinney and Walker 1967 (minimum degree); Duff and Reid 1983
(relaxed amalgamation).
"""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np

from drystone.base.arrays import Floats, Ints

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
        As :func:`~drystone.solvers.dissection.adjacency` gives them.
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
