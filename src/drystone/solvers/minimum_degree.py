"""Minimum degree: the order in which nodes of a part of a graph are eliminated, and their fronts.

The next node is the one with the fewest neighbours left. Nodes that are eliminated next to each
other then share a front where that takes less time than two fronts.

Sources: Tinney and Walker 1967 (minimum degree); Duff and Reid 1983 (relaxed amalgamation).
"""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np

from drystone.base.arrays import Ints

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
