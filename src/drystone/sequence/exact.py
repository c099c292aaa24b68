"""The optimal order for small models: Dijkstra over all stages, props and last blocks."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import TypeAlias

from drystone.base.errors import InputError
from drystone.sequence.best_first import OrderSearch
from drystone.sequence.rules import BoundRules
from drystone.sequence.states import FoundOrder, Node

LARGEST = 14
"""Largest number of free blocks. The number of stages doubles with every block; more blocks take
hours."""

Key: TypeAlias = tuple[int, int, int, bool]
"""Placed blocks, props, last removed block (-1 at first), and whether the first block of an open
group is propped."""


@dataclass(frozen=True, eq=False)
class _State:
    node: Node
    last: int


def search_exactly(search: OrderSearch, root: Node) -> FoundOrder:
    """The order with the least help (:data:`Cost`), and of these the one with the least descent.

    Parameters
    ----------
    search
        Provides removable blocks and changes of falling stages.
    root
        The complete structure; it stands.

    Raises
    ------
    InputError
        Too many blocks.
    """
    bound: BoundRules = search.bound
    count = (root.placed & ~bound.core).bit_count()
    if count > LARGEST:
        raise InputError(
            f"an exact search over {count} blocks",
            remedy=f"it is for {LARGEST} or fewer; leave it out",
        )
    queue: list[tuple[tuple[int, int, int, float], int, _State]] = []
    heapq.heappush(queue, ((*root.cost, 0.0), 0, _State(root, -1)))
    done: set[tuple[Key, frozenset[int]]] = set()
    pushed = 0
    while queue:
        (*_, drop), _, state = heapq.heappop(queue)
        node = state.node
        answer = search.answer(node)
        stands = answer.stands and search.can_hold(node)
        group = frozenset(() if stands else node.group)
        propped = bool(group) and node.propped_first
        key = ((node.placed, node.props, state.last, propped), group)
        if key in done:
            continue
        done.add(key)
        if stands and node.placed & ~bound.core == 0:
            return FoundOrder(node.path(), True)
        following = search.removals(node) if stands else search.cures(node, answer)
        for one in following:
            moved = one.group[-1] if one.placed != node.placed else -1
            last, total = state.last, drop
            if moved >= 0:
                total += _rise(search, state.last, moved)
                last = moved
            pushed += 1
            heapq.heappush(queue, ((*one.cost, total), pushed, _State(one, last)))
    raise InputError("there is no order of assembly", remedy="allow props")


def _rise(search: OrderSearch, last: int, block: int) -> float:
    """Height gained from the block removed before to this one: a descent in assembly."""
    if last < 0:
        return 0.0
    height = search.model.height
    return max(0.0, float(height[block] - height[last]))
