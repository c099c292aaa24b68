"""Best-first search over stages, backwards from the complete structure.

A state is a stage and the props used so far. Its cost is lexicographic: propped blocks, then held
blocks, then simultaneous placements. States wait in a queue unchecked. The state with the lowest
cost is checked next; among equals the one with the fewest blocks. So where every stage stands, the
search removes one block after the other.

A stage is looked at quickly first. If no rest state is found so, the stage waits; before any stage
with more help it is checked. In larger models the neighbourhood of the removed blocks is checked
first, with all other blocks held: where it falls, the whole stage falls. An imposed order is
checked at once.

Where a stage falls, only a change to one of the falling blocks helps: a mechanism that leaves a
block at rest still exists when that block is held or removed. So the next states are, for each
falling block: it is removed too (placed together with the others), or it is propped.

The search gives help to the best stage when its patience is over, and does not look back. With
infinite patience it never does: the first order that is found needs the least help.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.progress import Progress
from drystone.loads import STANDARD_GRAVITY
from drystone.results import Verdict
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.local_balance import LocalBalance
from drystone.sequence.rules import BoundRules, Order
from drystone.sequence.scaffold_stages import ScaffoldedStages
from drystone.sequence.stages import Stage, StageAnswer, mask_of, members
from drystone.sequence.structure import Structure

Cost: TypeAlias = tuple[int, int, int]
"""Number of propped blocks, of held blocks, and of simultaneous placements (of the blocks of a
step, all except the last). Fewer of the first count more than fewer of the next."""

NO_HELP: Cost = (0, 0, 0)

FEW_BLOCKS = 25
"""Free blocks below which every stage is checked. With more blocks that is done where a stage has
no more help than the one before, and before blocks are held or propped: unnecessary help is
removed at the end. Propped after a quick look only, a vault of 85 blocks has 17 props, not 8."""

LOOK = 0.1
"""Cost of a state that is decided without a check, in checks. Such a state takes about a tenth of
the time of a check."""

UNHELPED = 1 / 3
"""Cost of a state without help in models of few blocks, in checks: chosen, so that three times as
many are checked before help is given. The bridge of the source with its load, at friction 0.34, has
an order without help that is found after some hundred states."""

RINGS = 2
"""Rings of neighbours of the removed blocks that are checked alone. Measured on stages of vaults
and domes: with one ring 6 of 43 that stand find no rest state, with two none; of 37 that fall, 31
are found with two rings, in a third to a half of the time of a check."""


@dataclass(frozen=True, eq=False)
class Node:
    """A stage in the search.

    Attributes
    ----------
    placed, props
        Sets of blocks as bits; props are a subset of the placed blocks.
    group
        Blocks removed since the last stage that stands, in the order of removal.
    cost
    parent
        The last stage that stands.
    """

    placed: int
    props: int
    group: tuple[int, ...] = ()
    cost: Cost = NO_HELP
    parent: Node | None = None

    @property
    def propped_first(self) -> bool:
        """Whether the first removed block was propped; it does not count as held then."""
        return self.parent is not None and any(self.parent.props >> b & 1 for b in self.group[:1])

    def joined(self, block: int) -> Node:
        """The node with one more block removed together with the others."""
        props, held, together = self.cost
        first = len(self.group) == 1 and not self.propped_first
        cost = props, held + 1 + first, together + 1
        return replace(
            self, placed=self.placed & ~(1 << block), group=(*self.group, block), cost=cost
        )

    def path(self) -> list[Node]:
        """The stages from the complete structure to this one."""
        out: list[Node] = [self]
        while out[-1].parent is not None:
            out.append(out[-1].parent)
        return out[::-1]


@dataclass(frozen=True, eq=False)
class FoundOrder:
    """Result of a search.

    Attributes
    ----------
    path
        Stages that stand, from the complete structure to the core.
    proved
        Whether no path with a lower cost exists.
    """

    path: list[Node]
    proved: bool


class OrderSearch:
    """One search; see the module docstring.

    Parameters
    ----------
    evaluator
    bound
    patience
        Checks without progress before the best state is continued with held blocks or props.
        Infinite: never; the result is proved to be optimal.
    width
        Number of blocks tried for removal from one stage, the first ones in the order.
    scaffold
        What holds propped blocks. A stage that stands with ideal props must also stand with it.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        bound: BoundRules,
        patience: float = math.inf,
        width: int = 2**30,
        *,
        progress: Progress | None = None,
        scaffold: ScaffoldedStages | None = None,
    ) -> None:
        self.evaluator = evaluator
        self.model: Structure = evaluator.model
        self.bound = bound
        self.patience = patience
        whole = math.isinf(patience)
        self.width = 2**30 if whole else width
        self.tries = int(min(4.0, max(1.0, patience // 4)))
        self.progress = progress
        self.scaffold = scaffold
        self.proppable = self.model.everything if scaffold is None else scaffold.takes
        self.local = LocalBalance(self.model)
        # they bound what is still to come, where the search goes to its end
        self.pairs = self.local.helpless_pairs() if whole else ()
        # a proof of optimality needs the check of every stage
        self.quick = self.model.quick is not None and not whole
        self.few = self.model.largest[0] < FEW_BLOCKS
        self.every = not self.quick or self.model.small
        self.whole = (self.few or not self.quick) and self.width >= len(self.model.assembly)
        self.imposed = not isinstance(bound.rules.order, Order)
        self.queue: list[tuple[Cost, int, int, int, int, bool, Node]] = []
        self.closed: dict[tuple[int, int, frozenset[int], bool], Cost] = {}
        self.pushed = 0
        self.rounds = 0

    def run(self, root: Node) -> FoundOrder:
        """Search from a stage that stands to the core."""
        proved = self.whole
        best = root
        waited = 0.0
        self.push([root])
        while self.queue:
            *_, waits, node = heapq.heappop(self.queue)
            before = self.evaluator.asked
            answer = self.answer(node, full=waits or self.imposed or not self.quick)
            if not waits:
                one = UNHELPED if self.few and node.cost == NO_HELP else 1.0
                waited += LOOK if self.evaluator.asked == before else one
                if answer.verdict is Verdict.UNDECIDED and self.to_check(node):
                    self.push([node], waits=True)
                    continue
            stands, following = self.expanded(node, answer)
            if stands and following is not None:
                if node.placed & ~self.bound.core == 0:
                    return FoundOrder(node.path(), proved)
                if node.placed.bit_count() < best.placed.bit_count():
                    best, waited = node, 0.0
                    self.report(node)
            self.push(following or [])
            if waited > self.patience or not self.queue:
                proved = False
                best = self.force(best)
                waited = 0.0
                self.report(best)
                if best.placed & ~self.bound.core == 0:
                    return FoundOrder(best.path(), proved)
                self.queue.clear()
                self.push(self.removals(best))
        return FoundOrder(best.path(), False)

    def below(self, root: Node, limit: Cost) -> FoundOrder | None:
        """The order with the least help below a limit, found with as many checks as the patience.

        States that need as much as the best order so far are left out. Of the others the one with
        the fewest blocks is tried first: the alternatives near the ground cost little to check.

        Parameters
        ----------
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
        exhaustive = self.whole
        queue = [(root.placed.bit_count(), self.estimate(root), 0, root)]
        best: Node | None = None
        pushed, spent = 0, 0.0
        self.closed.clear()
        self.queue.clear()  # workers would go on with its states
        while queue and spent < self.patience:
            _, least, _, node = heapq.heappop(queue)
            if least >= limit:
                continue
            if self.progress is not None:
                self.progress("searching for less help", int(spent), math.ceil(self.patience))
            before = self.evaluator.asked
            answer = self.answer(node)
            spent += LOOK if self.evaluator.asked == before else 1.0
            exhaustive &= answer.verdict is not Verdict.UNDECIDED
            stands, following = self.expanded(node, answer)
            if stands and following is not None and not node.placed & ~self.bound.core:
                best, limit = node, least
            for one in following or []:
                pushed += 1
                heapq.heappush(queue, (one.placed.bit_count(), self.estimate(one), pushed, one))
        done = exhaustive and not queue
        if best is None:
            return FoundOrder([], True) if done else None
        return FoundOrder(best.path(), done)

    def expanded(self, node: Node, answer: StageAnswer) -> tuple[bool, list[Node] | None]:
        """Whether a node stands, and the next ones; None where it was known with as little help."""
        stands = answer.stands and self.can_hold(node)
        group = frozenset(() if stands else node.group)
        key = (node.placed, node.props, group, bool(group) and node.propped_first)
        if key in self.closed and self.closed[key] <= node.cost:
            return stands, None
        self.closed[key] = node.cost
        return stands, self.removals(node) if stands else self.cures(node, answer)

    def report(self, node: Node) -> None:
        """Report the progress of the best stage."""
        if self.progress is not None:
            total = (self.model.everything & ~self.bound.core).bit_count()
            left = (node.placed & ~self.bound.core).bit_count()
            self.progress("planning", total - left, total)

    def to_check(self, node: Node) -> bool:
        """Whether a node that was only looked at waits for its check."""
        alone = node.parent is None or node.cost == node.parent.cost
        return self.quick and not self.imposed and (self.few or alone)

    def answer(self, node: Node, *, full: bool = True) -> StageAnswer:
        """The answer of a node: a quick look, and where that does not decide the check if ``full``.

        If a neighbour of the last removed blocks has no equilibrium, neither is needed.
        """
        near = 0
        for block in node.group:
            near |= self.model.neighbours[block]
        loose = self.local.unbalanced(near & node.placed & ~node.props, node.placed)
        if loose:
            return StageAnswer(Verdict.UNSTABLE, "cannot be balanced", loose)
        seen = self.look(node, quick=True) if self.quick else None
        if seen is not None and (seen.verdict is not Verdict.UNDECIDED or not full):
            return seen
        found = self.nearby(node) if self.quick else None
        if found is None or found.stands:
            found = self.look(node, quick=False)
        return found if found.stands or found.falling or seen is None else seen

    def look(self, node: Node, *, quick: bool) -> StageAnswer:
        """The answer of a node; with workers, likely nodes are computed too."""
        likely = heapq.nsmallest(self.evaluator.batch - 1, self.queue)
        ahead = [self.stage(entry[-1], quick=self.quick) for entry in likely]
        found = self.evaluator.answers([self.stage(node, quick=quick)], ahead=ahead)[0]
        fails = self.failure(node.placed, node.props) if found.stands else None
        return found if fails is None else fails

    def failure(self, placed: int, props: int) -> StageAnswer | None:
        """The answer of a stage that the scaffolding does not carry; else None."""
        if self.scaffold is None or not props:
            return None
        answer = self.scaffold.answer(placed, props)
        return None if answer.stands else answer

    def nearby(self, node: Node) -> StageAnswer | None:
        """The neighbourhood of the removed blocks with all others held; None if it is all."""
        near = mask_of(node.group)
        for _ in range(RINGS):
            near = self.widened(near)
        moving = near & node.placed & ~node.props
        held = self.widened(moving) & node.placed & ~moving
        if self.few or not moving or not held & ~node.props:
            return None
        before = None if node.parent is None else (node.parent.placed, node.parent.props)
        return self.evaluator.answer(Stage(moving | held, held, False, before))

    def stage(self, node: Node, *, quick: bool) -> Stage:
        """The stage to check; the search starts from the stage before the last removal."""
        near = None if node.parent is None else (node.parent.placed, node.parent.props)
        return Stage(node.placed, node.props, quick, near)

    def widened(self, blocks: int) -> int:
        """Some blocks and all their neighbours."""
        for block in members(blocks):
            blocks |= self.model.neighbours[block]
        return blocks

    def push(self, nodes: Sequence[Node], *, waits: bool = False) -> None:
        """Add nodes to the queue; later calls come first, each in its given order.

        A node that waits for its check comes before any node with more blocks or more help.
        """
        self.rounds += 1
        for node in nodes:
            self.pushed += 1
            count = node.placed.bit_count()
            when = (count, waits) if self.few else (waits, count)
            entry = (self.estimate(node), *when, -self.rounds, self.pushed, waits, node)
            heapq.heappush(self.queue, entry)

    def estimate(self, node: Node) -> Cost:
        """A lower bound of the cost of any order through a node."""
        left = sum(1 for pair in self.pairs if pair & node.placed == pair and not pair & node.props)
        props, held, together = node.cost
        if self.bound.hands == 1:
            return props + left, held, together
        return props, held + 2 * left, together + left

    def candidates(self, placed: int) -> Iterator[int]:
        """Blocks that may and can be removed, in this order; of the highest course only."""
        rank, course = self.bound.rank, self.bound.course
        highest = None
        for block in sorted(members(placed & ~self.bound.core), key=lambda b: int(rank[b])):
            if highest is not None and course[block] < highest:
                return
            if self.bound.can_leave(block, placed):
                highest = course[block]
                yield block

    def removals(self, node: Node) -> list[Node]:
        """Stages with one block less, if possible without unsupported blocks."""
        out: list[Node] = []
        hanging: list[Node] = []
        for block in self.candidates(node.placed):
            bit = 1 << block
            one = Node(node.placed & ~bit, node.props & ~bit, (block,), node.cost, node)
            air = self.model.floating(one.placed) & ~self.model.floating(node.placed)
            (hanging if air else out).append(one)
            if len(out) >= self.width:
                break
        return out or hanging

    def cures(self, node: Node, answer: StageAnswer) -> list[Node]:
        """Stages in which one falling block is removed too, or propped."""
        falling = self.falling(node, answer)
        props, held, together = node.cost
        out = [node.joined(q) for q in falling if self.can_join(node, q)]
        out += [
            replace(node, props=node.props | 1 << p, cost=(props + 1, held, together))
            for p in falling
            if self.proppable >> p & 1
        ]
        return out

    def falling(self, node: Node, answer: StageAnswer) -> list[int]:
        """One of these blocks must be changed; in the order of removal; near the gap if unknown."""
        mask = mask_of(answer.falling) & node.placed & ~node.props
        if not mask:
            near = 0
            for block in node.group:
                near |= self.model.neighbours[block]
            mask = near & node.placed & ~node.props or node.placed & ~node.props
        return sorted(members(mask), key=lambda b: int(self.bound.rank[b]))

    def can_join(self, node: Node, block: int) -> bool:
        """Whether there are enough hands, and a path, for one more block of a group."""
        if not node.group or self.bound.core >> block & 1:
            return False
        if int(self.bound.lifters[[*node.group, block]].sum()) > self.bound.hands:
            return False
        if not self.bound.can_leave(block, node.placed):
            return False
        return not self.model.floating(node.placed & ~(1 << block))

    def can_hold(self, node: Node) -> bool:
        """Whether a group can be placed block by block while hands hold the placed ones."""
        if len(node.group) < 2 or node.parent is None:
            return True
        placed = node.placed | mask_of(node.group)
        for number, block in enumerate(node.group[:-1]):  # backwards, as it is removed
            placed &= ~(1 << block)
            held = node.props | mask_of(node.group[number + 1 :])
            answer = self.held_answer(Stage(placed, held, False, (node.placed, node.props)))
            if not answer.stands or overloads(answer, node.group, self.bound.limit, self.model):
                return False
        return True

    def held_answer(self, stage: Stage) -> StageAnswer:
        """The answer of a stage within a step: a quick look, else the check."""
        if self.quick:
            seen = self.evaluator.answer(stage._replace(quick=True))
            if seen.stands:
                return seen
        return self.evaluator.answer(stage)

    def force(self, node: Node) -> Node:
        """One further removal from a stage that stands, with held blocks, else with props."""
        tries = self.removals(node)[: self.tries]
        answers: list[StageAnswer] = []
        for full in (False, True):
            answers = [self.answer(one, full=full) for one in tries]
            for one, answer in zip(tries, answers, strict=True):
                if answer.stands:
                    return one
        for one, answer in zip(tries, answers, strict=True):
            grown = self.grow(one, answer)
            if grown is not None:
                return grown
        few = min(range(len(tries)), key=lambda i: len(answers[i].falling) or len(tries))
        return self.prop(tries[few], answers[few])

    def grow(self, node: Node, answer: StageAnswer) -> Node | None:
        """The group with all falling blocks, if there are enough hands."""
        while not answer.stands:
            joining = [q for q in self.falling(node, answer) if self.can_join(node, q)]
            if not joining:
                return None
            node = node.joined(joining[0])
            answer = self.answer(node, full=self.every)
        return node if self.can_hold(node) else None

    def prop(self, node: Node, answer: StageAnswer) -> Node:
        """Props until it stands: under falling blocks beside the gap, then farther away."""
        given = node.props
        reach = mask_of(node.group)
        while not answer.stands and node.props != node.placed:
            falling = mask_of(self.falling(node, answer)) & self.proppable
            if not falling:
                break
            wider = self.widened(reach)
            while not falling & wider and wider != reach:
                reach, wider = wider, self.widened(wider)
            reach = wider
            node = replace(node, props=node.props | (falling & reach or falling))
            answer = self.answer(node, full=self.every)
        added = node.props & ~given
        if answer.stands and added.bit_count() <= 2 * self.tries:
            for block in members(added):
                fewer = replace(node, props=node.props & ~(1 << block))
                if self.answer(fewer, full=self.every).stands:
                    node = fewer
        props, held, together = node.cost
        return replace(node, cost=(props + (node.props & ~given).bit_count(), held, together))


def overloads(answer: StageAnswer, group: Sequence[int], limit: Floats, model: Structure) -> bool:
    """Whether a hand carries more than its payload while a group is placed.

    Parameters
    ----------
    answer
        Of a stage in between.
    group
    limit : (n,) [kg]
        Mass whose weight the hands of a block can hold.
    model
    """
    load, mass = model.load.wrench, model.assembly.mass
    for block in group:
        if block not in answer.reaction:
            continue
        # without a load: standard gravity
        weight = float(np.linalg.norm(load[block, :3])) / float(mass[block]) or STANDARD_GRAVITY
        force = float(np.linalg.norm(answer.reaction[block][:3]))
        if force > (1.0 + 1e-6) * float(limit[block]) * weight:
            return True
    return False
