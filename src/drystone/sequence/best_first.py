"""Best-first search over stages, backwards from the complete structure.

A state is a stage and the props used so far. Its cost is lexicographic: propped blocks, then held
blocks, then simultaneous placements. States wait in a queue unchecked. The state with the lowest
cost is checked next; among equals the one with the fewest blocks. So where every stage stands, the
search removes one block after the other.

A stage is screened first. If the screening finds no rest state, the stage waits; before any stage
with more help it is checked. In larger models the neighbourhood of the removed blocks is screened
first, with all other blocks held: where it finds no rest state, the whole stage is checked when an
order is found (:mod:`drystone.sequence.helping`). An imposed order is checked at once.

Where a stage falls, only a change to one of the falling blocks helps: a mechanism that leaves a
block at rest still exists when that block is held or removed. So the next states are, for each
falling block: it is removed too (placed together with the others), or it is propped.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from dataclasses import replace

from drystone.base.progress import Progress
from drystone.results import Verdict
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.hands import can_hold
from drystone.sequence.insertion import RemovalTest
from drystone.sequence.needs import LocalBalance
from drystone.sequence.rules import BoundRules, Order
from drystone.sequence.scaffolded_stages import ScaffoldedStages
from drystone.sequence.stages import Stage, StageAnswer, mask_of, members
from drystone.sequence.states import NO_HELP, Cost, FoundOrder, Node, SearchOptions
from drystone.stability import Screening
from drystone.stability.screening import FEW_BLOCKS, MANY_BLOCKS, PATIENT, SLIP_LENGTH

LOOK = 0.1
"""Cost of a state that is decided without a check, in checks. Such a state takes about a tenth of
the time of a check."""

UNHELPED = 1 / 3
"""Cost of a state without help in models of few blocks, in checks: chosen, so that three times as
many are checked before help is given. The bridge of the source with its load, at friction 0.34, has
an order without help that is found after some hundred states."""

RINGS = 2
"""Rings of neighbours of the removed blocks that are screened alone. Measured on stages of vaults
and domes: with one ring 6 of 43 that stand find no rest state, with two none; of 37 that fall, 31
are found with two rings, in a third to a half of the time of a check."""

NEAR = PATIENT.with_slip_lengths(None, SLIP_LENGTH)
"""Screening of a neighbourhood: both friction laws of a check."""

NEAR_QUICKLY = replace(NEAR, name="quick neighbourhood", patient=False)
"""The same in models of up to MANY_BLOCKS, begun at the rest state before, without weaker
ground springs. Measured on vaults and a dome at five friction coefficients: the same plans in half
of the time of these screenings."""


class OrderSearch:
    """One search; see the module docstring.

    Parameters
    ----------
    evaluator
    bound
    removal
    options
    bounded
        Whether to use a lower bound of the remaining cost.
    scaffold
        What holds propped blocks. A stage that stands with ideal props must also stand with it.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        bound: BoundRules,
        removal: RemovalTest,
        options: SearchOptions,
        *,
        bounded: bool = False,
        progress: Progress | None = None,
        scaffold: ScaffoldedStages | None = None,
    ) -> None:
        self.evaluator = evaluator
        self.model = evaluator.model
        self.scaffold = scaffold
        self.proppable = self.model.everything if scaffold is None else scaffold.takes
        self.bound = bound
        self.removal = removal
        self.options = options
        self.local = LocalBalance(self.model)
        self.pairs = self.local.helpless_pairs() if bounded else ()
        self.progress = progress
        # a proof of optimality needs the full check of every stage
        screening = () if math.isinf(options.patience) else self.model.screening
        self.levels: tuple[Screening | None, ...] = (*screening, None)
        self.few = self.model.largest[0] < FEW_BLOCKS
        every, screened = len(self.levels), max(1, len(screening))
        imposed = not isinstance(bound.rules.order, Order)
        # number of screening levels at first, and after help was given
        self.first_levels = every if imposed else screened if self.few else 1
        self.later_levels = every if self.few else screened
        self.queue: list[tuple[Cost, int, int, int, int, bool, Node]] = []
        self.pushed = 0
        self.rounds = 0

    def run(self, root: Node) -> FoundOrder:
        """Search from a stage that stands to the core."""
        closed: dict[tuple[int, int, frozenset[int], bool], Cost] = {}
        every = self.later_levels == len(self.levels)
        proved = every and self.options.width >= len(self.model.assembly)
        best = root
        waited = 0.0
        self.push([root])
        while self.queue:
            *_, screened, node = heapq.heappop(self.queue)
            before = self.evaluator.asked
            answer = self.answer(node, len(self.levels) if screened else self.first_levels)
            if not screened:
                one = UNHELPED if self.few and node.cost == NO_HELP else 1.0
                waited += LOOK if self.evaluator.asked == before else one
                if answer.verdict is Verdict.UNDECIDED and self.to_check(node):
                    self.push([node], screened=True)
                    continue
            stands = answer.stands and self.can_hold(node)
            group = frozenset(() if stands else node.group)
            key = (node.placed, node.props, group, bool(group) and node.propped_first)
            known = key in closed and closed[key] <= node.cost
            if not known:
                closed[key] = node.cost
            if stands and not known:
                if node.placed & ~self.bound.core == 0:
                    return FoundOrder(node.path(), proved)
                if node.placed.bit_count() < best.placed.bit_count():
                    best, waited = node, 0.0
                    self.report(node)
                self.push(self.removals(node))
            elif not known:
                self.push(self.cures(node, answer))
            if waited > self.options.patience or not self.queue:
                proved = False
                best = self.force(best)
                waited = 0.0
                self.report(best)
                if best.placed & ~self.bound.core == 0:
                    return FoundOrder(best.path(), proved)
                self.queue.clear()
                self.push(self.removals(best))
        return FoundOrder(best.path(), False)

    def report(self, node: Node) -> None:
        """Report the progress of the best stage."""
        if self.progress is not None:
            total = (self.model.everything & ~self.bound.core).bit_count()
            left = (node.placed & ~self.bound.core).bit_count()
            self.progress("planning", total - left, total)

    def to_check(self, node: Node) -> bool:
        """Whether a node without a result from screening waits for its check.

        In larger models stages that have more help than their parent do not wait. Unnecessary help
        is removed at the end.
        """
        left = self.first_levels < len(self.levels)
        alone = node.parent is None or node.cost == node.parent.cost
        return left and (self.few or alone)

    def answer(self, node: Node, levels: int = 2**30, *, sure: bool = False) -> StageAnswer:
        """The answer of a node by the first levels.

        Levels are tried until one proves that it stands or falls. If none does, the answer has the
        falling blocks. ``sure``: the neighbourhood alone does not decide.
        """
        answers: list[StageAnswer] = []
        for number in range(min(levels, len(self.levels))):
            if self.levels[number] is None and answers and not sure:
                near = self.nearby(node)
                if near is not None and not near.stands:
                    answers.insert(0, near)
                    break
            answers.append(self.look(node, number))
            if answers[-1].stands:
                return answers[-1]
            if answers[-1].verdict is Verdict.UNSTABLE:
                break
        return next((one for one in answers if one.falling), answers[-1])

    def look(self, node: Node, number: int = 0) -> StageAnswer:
        """The answer of a node by one level; with workers, likely nodes are computed too.

        If a neighbour of the last removed blocks has no equilibrium, no check is needed.
        """
        near = 0
        for block in node.group:
            near |= self.model.neighbours[block]
        loose = self.local.unbalanced(near & node.placed & ~node.props, node.placed)
        if loose:
            return StageAnswer(Verdict.UNSTABLE, "cannot be balanced", loose)
        stage = self.stage(node, self.levels[number])
        likely = heapq.nsmallest(self.evaluator.batch - 1, self.queue)
        ahead = [self.stage(entry[-1], self.levels[0]) for entry in likely]
        found = self.evaluator.answers([stage], ahead=ahead)[0]
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
        if self.model.largest[0] > MANY_BLOCKS:
            return self.evaluator.answer(Stage(moving | held, held, NEAR))
        before = None if node.parent is None else (node.parent.placed, node.parent.props)
        return self.evaluator.answer(Stage(moving | held, held, NEAR_QUICKLY, before))

    def stage(self, node: Node, level: Screening | None) -> Stage:
        """The stage to check; the search starts from the stage before the last removal."""
        if node.parent is None or (level is not None and not level.from_neighbour):
            return Stage(node.placed, node.props, level)
        return Stage(node.placed, node.props, level, (node.parent.placed, node.parent.props))

    def widened(self, blocks: int) -> int:
        """Some blocks and all their neighbours."""
        for block in members(blocks):
            blocks |= self.model.neighbours[block]
        return blocks

    def push(self, nodes: list[Node], *, screened: bool = False) -> None:
        """Add nodes to the queue; later calls come first, each in its given order.

        Nodes that were ``screened`` without a result are checked before any node with more blocks
        or more help.
        """
        self.rounds += 1
        for node in nodes:
            self.pushed += 1
            count = node.placed.bit_count()
            when = (count, screened) if self.few else (screened, count)
            entry = (self.estimate(node), *when, -self.rounds, self.pushed, screened, node)
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
            if self.bound.allows(block, placed) and self.removal.free(block, placed):
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
            if len(out) >= self.options.width:
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
        if not node.group or block in members(self.bound.core):
            return False
        if int(self.bound.lifters[[*node.group, block]].sum()) > self.bound.hands:
            return False
        if not self.bound.allows(block, node.placed) or not self.removal.free(block, node.placed):
            return False
        return not self.model.floating(node.placed & ~(1 << block))

    def can_hold(self, node: Node) -> bool:
        """Whether a group can be placed block by block while hands hold the placed ones."""
        return can_hold(self.held_answer, self.bound, self.model, node)

    def held_answer(self, stage: Stage) -> StageAnswer:
        """The answer of a stage within a step, by all levels until it stands."""
        answer = None
        for level in self.levels:
            near = stage.near if level is None or level.from_neighbour else None
            answer = self.evaluator.answer(stage._replace(screening=level, near=near))
            if answer.stands:
                break
        assert answer is not None
        return answer

    def force(self, node: Node) -> Node:
        """One further removal from a stage that stands, with held blocks, else with props."""
        tries = self.removals(node)[: self.options.tries]
        answers: list[StageAnswer] = []
        for levels in range(1, len(self.levels) + 1):
            answers = [self.answer(one, levels) for one in tries]
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
            answer = self.answer(node, self.later_levels)
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
            answer = self.answer(node, self.later_levels)
        added = node.props & ~given
        if answer.stands and added.bit_count() <= 2 * self.options.tries:
            for block in members(added):
                fewer = replace(node, props=node.props & ~(1 << block))
                if self.answer(fewer, self.later_levels).stands:
                    node = fewer
        props, held, together = node.cost
        return replace(node, cost=(props + (node.props & ~given).bit_count(), held, together))
