"""Search for less help than a known order needs, deepest stages first.

Best-first search spends its patience on stages without help, and then gives help to one stage
without looking back. Here the help of that order is an upper bound: states that need as much are
left out, and of the others the one with the fewest blocks is tried first. So the alternatives near
the ground, which cost little to check, are tried before other beginnings.
"""

from __future__ import annotations

import heapq
import math

from drystone.results import Verdict
from drystone.sequence.best_first import LOOK, OrderSearch
from drystone.sequence.states import Cost, FoundOrder, Node


def search_below(search: OrderSearch, root: Node, limit: Cost) -> FoundOrder | None:
    """The order with the least help below a limit, found with as many checks as the patience.

    Parameters
    ----------
    search
        Its rules, stage checks and options are used; its patience is finite.
    root
        The stage that stands at the end of assembly.
    limit
        Help of a known order.

    Returns
    -------
    FoundOrder or None
        None if nothing was found. ``proved`` if no state below its cost is left. If nothing was
        found and no state is left, the path is empty and ``proved`` is true.
    """
    patience = search.options.patience
    exhaustive = search.later_levels == len(search.levels)
    exhaustive &= search.options.width >= len(search.model.assembly)
    closed: dict[tuple[int, int, frozenset[int], bool], Cost] = {}
    queue: list[tuple[int, Cost, int, Node]] = []
    best: Node | None = None
    pushed, spent = 0, 0.0
    search.queue.clear()  # workers would go on with its states

    def push(nodes: list[Node]) -> None:
        nonlocal pushed
        for node in nodes:
            pushed += 1
            entry = (node.placed.bit_count(), search.estimate(node), pushed, node)
            heapq.heappush(queue, entry)

    push([root])
    while queue and spent < patience:
        _, least, _, node = heapq.heappop(queue)
        if least >= limit:
            continue
        if search.progress is not None:
            search.progress("searching for less help", int(spent), math.ceil(patience))
        before = search.evaluator.asked
        answer = search.answer(node, sure=True)
        stands = answer.stands and search.can_hold(node)
        spent += LOOK if search.evaluator.asked == before else 1.0
        exhaustive &= answer.verdict is not Verdict.UNDECIDED
        group = frozenset(() if stands else node.group)
        key = (node.placed, node.props, group, bool(group) and node.propped_first)
        if key in closed and closed[key] <= node.cost:
            continue
        closed[key] = node.cost
        if not stands:
            push(search.cures(node, answer))
        elif node.placed & ~search.bound.core:
            push(search.removals(node))
        else:
            best, limit = node, least
    done = exhaustive and not queue
    if best is None:
        return FoundOrder([], True) if done else None
    return FoundOrder(best.path(), done)
