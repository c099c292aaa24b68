"""Removal of unnecessary help from an order.

The search relies on quick looks and never removes a prop. So a block may be propped at a stage that
stands without. Here that is asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_

from drystone.base.settings import Stopped
from drystone.sequence.order_search import OrderSearch
from drystone.sequence.stage_tree import Cost, Node
from drystone.sequence.stages import StageAnswer, mask_of, members


@dataclass(frozen=True, eq=False)
class Trimmed:
    """An order without its unnecessary help.

    Attributes
    ----------
    path
        Stages in the order of assembly.
    props
        Props at each stage.
    cost
    proved
        Whether no order has a lower cost.
    failures
        Answer of each stage that the scaffolding does not carry; else None.
    denied
        Number of stages that do not stand by the check, where stages are checked.
    """

    path: list[Node]
    props: list[int]
    cost: Cost
    proved: bool
    failures: list[StageAnswer | None]
    denied: int

    @property
    def rank(self) -> tuple[int, int, Cost]:
        """Stages that are not carried, those denied, and the help: less is better."""
        return sum(one is not None for one in self.failures), self.denied, self.cost


def trimmed(found: tuple[list[Node], bool], search: OrderSearch) -> Trimmed:
    """The order that a search found, without its unnecessary help."""
    path = found[0][::-1]
    return _finished(path, [_needed(node, search) for node in path], found[1], search)


def mended(order: Trimmed, search: OrderSearch) -> Trimmed:
    """An order with further props where scaffolding does not carry those that it has.

    What was found is kept when the time is over.

    Raises
    ------
    Stopped
        The time is over before it is known which stages are carried.
    """
    best = _finished(order.path, order.props, order.proved, search)
    with suppress(Stopped):
        while any(best.failures):
            needed: list[int] = []
            more = 0
            for number, (node, props) in enumerate(zip(best.path, best.props, strict=True)):
                placed = best.path[number - 1].group if number else ()
                needed.append(_carried(replace(node, props=props), placed, more, search))
                more |= needed[-1] & ~props
            found = _finished(best.path, needed, proved=False, search=search)
            if found.rank >= best.rank:
                break
            best = found
    return best


def _carried(node: Node, last: Sequence[int], more: int, search: OrderSearch) -> int:
    """Props with which scaffolding carries a stage: one more, else under all that falls on fewer.

    Those it has where none does.

    Parameters
    ----------
    node
    last
        The blocks that were placed last, which are tried first,
    more
        after those that were propped at other stages for the same reason.
    search
    """
    props, placed, newest = node.props, node.placed, mask_of(last)
    fails = search.failure(placed, props, followed=True)
    if fails is None:
        return props
    able = placed & ~props & search.proppable
    near = search.widened(props | newest) & able
    near = near & mask_of(fails.falling) or near  # only what falls is mended by a prop
    ranked = sorted(members(near), key=lambda b: (not more >> b & 1, not newest >> b & 1))
    for added in filter(None, (more & able, *(1 << block for block in ranked))):
        wider = props | added
        stands = _stands(replace(node, props=wider), search)
        if stands and search.failure(placed, wider, followed=True) is None:
            return wider
    return _under_what_falls(node, able, fails, search)


def _under_what_falls(node: Node, able: int, fails: StageAnswer, search: OrderSearch) -> int:
    """Props under all that falls, until scaffolding carries it; those it has if it never does."""
    props = node.props
    while props != node.props | able:
        props |= mask_of(fails.falling) & able & ~props or able
        answer = search.failure(node.placed, props, followed=True)
        if answer is None:
            return props
        fails = answer
    return node.props


def _finished(
    path: list[Node], needed: Sequence[int], proved: bool, search: OrderSearch
) -> Trimmed:
    """An order with the props that its stages need, each in place from its first to its last."""
    props = _props_in_time(path, needed, search)
    cost = _cost(path, props)
    failures = [search.failure(node.placed, held, followed=True)
                for node, held in zip(path, props, strict=True)]  # fmt: skip
    denied = 0
    if search.quick and search.model.small:
        stages = [search.stage(replace(node, props=held), quick=False)
                  for node, held in zip(path, props, strict=True)]  # fmt: skip
        answers = search.evaluator.answers(stages, checked=True)
        denied = sum(not answer.stands for answer in answers)
    return Trimmed(path, props, cost, proved and not any(failures), failures, denied)


def _cost(path: Sequence[Node], props: Sequence[int]) -> Cost:
    """Propped blocks, held blocks and simultaneous placements of an order."""
    ever = reduce(or_, props, 0)
    several = [node.group for node in path if len(node.group) > 1]
    held = mask_of(block for group in several for block in group) & ~ever
    return ever.bit_count(), held.bit_count(), sum(len(group) - 1 for group in several)


def _props_in_time(path: Sequence[Node], needed: Sequence[int], search: OrderSearch) -> list[int]:
    """Props at each stage, from the first to the last stage that needs them."""
    ever = reduce(or_, needed, 0)
    active = [0] * len(path)
    for block in members(ever):
        when = [i for i, mask in enumerate(needed) if mask >> block & 1]
        for i in range(when[0], when[-1] + 1):
            active[i] |= 1 << block
    return [
        mask if _stands(replace(node, props=mask), search) else least
        for node, mask, least in zip(path, active, needed, strict=True)
    ]


def _needed(node: Node, search: OrderSearch) -> int:
    """Props with which a stage stands: none where it does without."""
    mask = node.props
    certain = mask_of(search.local.unbalanced(mask, node.placed))
    if mask == certain or search.failure(node.placed, mask) is not None:
        return mask
    if not certain and _stands(replace(node, props=0), search):
        return 0
    return mask


def _stands(node: Node, search: OrderSearch) -> bool:
    """Whether a stage stands, and hands can hold the blocks placed together until the next one.

    A quick look must find it, and where the stages of the plan are checked the check must agree:
    it follows blocks that uniform stiffness holds.
    """
    seen = search.answer(node, full=False)
    if seen.stands and search.quick and search.model.small:
        stage = search.stage(node, quick=False)
        seen = search.evaluator.answer(stage, checked=True)
    if not seen.stands:
        return False
    return search.can_hold(node)
