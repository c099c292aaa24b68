"""The help that a found order really needs: the search may have given more on the way.

The search believes its screening and never takes a prop back. A block may be propped or held that
needs neither at the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from drystone.sequence.search.best_first import Search
from drystone.sequence.search.states import Node
from drystone.sequence.stage.stages import Stage, mask_of, members

POLISHED = 8
"""Props of one stage that are tried one by one whether they are needed there."""

SPARED = 100
"""Free blocks of models of which every prop is tried at all of its stages. Chosen: a vault of 366
has hundreds of props, of dozens of stages each."""


def apart(path: Sequence[Node], search: Search) -> list[Node]:
    """The same order, groups divided where those that come first stand without the rest.

    Parameters
    ----------
    path
        In the order of assembly.
    search
    """
    out: list[Node] = []
    for node in path:
        late, end = node, len(node.group)
        for start in range(len(node.group) - 1, 0, -1):  # the last to leave come first
            placed = node.placed | mask_of(node.group[start:])
            props = (node.props | (node.parent.props if node.parent else 0)) & placed
            early = replace(node, placed=placed, props=props, group=node.group[:start])
            if search.answer(early).stands and search.can_hold(early):
                out.append(replace(late, group=node.group[start:end], parent=early))
                late, end = early, start
        out.append(late)
    return out


def props_in_time(path: Sequence[Node], search: Search) -> list[int]:
    """Props at each stage, in the order of assembly: from first to last need, no longer."""
    needed = [_needed(node, search) for node in path]
    ever = 0
    for mask in needed:
        ever |= mask
    active = [0] * len(path)
    for block in members(ever):
        when = [i for i, mask in enumerate(needed) if mask >> block & 1]
        for i in range(when[0], when[-1] + 1):
            active[i] |= 1 << block
    level = search.levels[0]
    stages = [
        Stage(node.placed, mask, level, (node.placed, node.props) if level else None)
        for node, mask in zip(path, active, strict=True)
    ]
    answers = search.evaluator.answers(stages)
    active = [
        mask if answer.stands else least
        for mask, answer, least in zip(active, answers, needed, strict=True)
    ]
    if len(search.model.assembly.free) <= SPARED:
        _spare(path, active, search)
    return active


def _needed(node: Node, search: Search) -> int:
    """Props of a stage without which it falls, tried one by one where there are few."""
    mask = node.props
    certain = mask_of(search.local.unbalanced(mask, node.placed))
    if mask == certain:
        return mask
    if not certain and _stands(replace(node, props=0), search, well=False):
        return 0
    doubtful = mask & ~certain
    if doubtful.bit_count() <= POLISHED:
        for block in members(doubtful):
            if _stands(replace(node, props=mask & ~(1 << block)), search, well=False):
                mask &= ~(1 << block)
    return mask


def _spare(path: Sequence[Node], active: list[int], search: Search) -> None:
    """Take props away from the first and from the last of their stages, as far as all stand."""
    ever = 0
    for mask in active:
        ever |= mask
    for block in members(ever):
        bit = 1 << block
        when = [i for i, mask in enumerate(active) if mask & bit]
        for stages in (when, when[::-1]):
            for i in stages:
                if not active[i] & bit:
                    break  # all of them were spared from the other end
                fewer = replace(path[i], props=active[i] & ~bit)
                if not (
                    search.local.holds(block, fewer.placed) and _stands(fewer, search, well=True)
                ):
                    break
                active[i] &= ~bit


def _stands(node: Node, search: Search, *, well: bool) -> bool:
    """Whether a stage stands, and hands can hold what is placed together up to the next one."""
    answer = search.answer(node) if well else search.look(node)
    return answer.stands and search.can_hold(node)


__all__ = ["apart", "props_in_time"]
