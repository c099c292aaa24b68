"""Best-first search over stages, backwards from the complete structure.

A state is a stage and the props used so far. Its cost is lexicographic: propped blocks, then held
blocks, then simultaneous placements. States wait in a queue unchecked. The state with the lowest
cost is checked next; among equals the one with the fewest blocks. So where every stage stands, the
search removes one block after the other.

If a quick look finds no rest state of a stage, it waits; before any stage with more help it is
checked. An imposed order is checked at once.

The search gives help to the best stage when its patience is over, and does not look back. With
infinite patience it never does: the first order that is found needs the least help.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import replace

from drystone.base.settings import Progress
from drystone.results import Verdict
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.rules import BoundRules, Order
from drystone.sequence.scaffold_stages import ScaffoldedStages
from drystone.sequence.stage_tree import NO_HELP, Cost, Node, StageTree
from drystone.sequence.stages import StageAnswer, mask_of, members

LOOK = 0.1
"""Cost of a state that is decided without a check, in checks. Such a state takes about a tenth of
the time of a check."""

UNHELPED = 1 / 3
"""Cost of a state without help in models of few blocks, in checks: chosen, so that three times as
many are checked before help is given. The bridge of the source with its load, at friction 0.34, has
an order without help that is found after some hundred states."""


class OrderSearch(StageTree):
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
    scaffold, carried
        See :class:`drystone.sequence.stage_tree.StageTree`.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        bound: BoundRules,
        patience: float,
        width: int,
        *,
        progress: Progress | None = None,
        scaffold: ScaffoldedStages | None = None,
        carried: bool = True,
    ) -> None:
        whole = math.isinf(patience)
        super().__init__(evaluator, bound, None if whole else width, scaffold, carried)
        self.patience = patience
        self.tries = int(min(4.0, max(1.0, patience // 4)))
        self.progress = progress
        # they bound what is still to come, where the search goes to its end
        self.pairs = self.local.helpless_pairs() if whole else ()
        self.exhaustive = (self.few or not self.quick) and self.width >= len(self.model.assembly)
        self.imposed = not isinstance(bound.rules.order, Order)
        self.by_course = bound.rules.order is Order.COURSE and not (whole or self.few)
        self.below_course = 0  # the blocks of the courses below the one that is removed
        self.queue: list[tuple[Cost, int, int, int, int, bool, Node]] = []
        self.closed: dict[tuple[int, int, frozenset[int], bool], Cost] = {}
        self.pushed = 0
        self.rounds = 0
        self.reached: Node | None = None  # the stage that stands with the fewest blocks so far

    def likely(self) -> Sequence[Node]:
        """The next nodes of the queue."""
        return [entry[-1] for entry in heapq.nsmallest(self.evaluator.batch - 1, self.queue)]

    def run(self, root: Node) -> tuple[list[Node], bool]:
        """Stages that stand, from a first one to the core, and whether less help is impossible."""
        if not self.by_course:
            return self.removed(root)
        proved, node = True, root
        for below in self.courses_below(root.placed):
            self.below_course = below
            path, known = self.removed(node)
            less = None if known or path[-1].cost == node.cost else self.below(node, path[-1].cost)
            node = less[0][-1] if less is not None and less[0] else path[-1]
            proved = proved and known
        return node.path(), proved

    def courses_below(self, placed: int) -> list[int]:
        """Of each course, the highest first, the blocks of the courses below it."""
        course = self.bound.course
        blocks = members(placed & ~self.bound.core)
        levels = sorted({float(course[b]) for b in blocks}, reverse=True)
        return [mask_of(b for b in members(placed) if course[b] < level) for level in levels]

    def removed(self, root: Node) -> tuple[list[Node], bool]:
        """As :meth:`run`, to the courses below the one that is removed."""
        self.closed.clear()
        self.queue.clear()
        proved, best, waited = self.exhaustive, root, 0.0
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
            if stands and following is not None and node.placed.bit_count() < self.least(best):
                best, waited = node, 0.0
                self.report(node)
                if self.done(node):
                    break
            self.push(following or [])
            if waited > self.patience or not self.queue:
                proved, best, waited = False, self.force(best), 0.0
                self.report(best)
                self.queue.clear()
                self.push([] if self.done(best) else self.removals(best))
        return best.path(), proved and self.done(best)

    def done(self, node: Node) -> bool:
        """Whether nothing is left to remove above the courses below."""
        return not node.placed & ~self.bound.core & ~self.below_course

    def removals(self, node: Node) -> list[Node]:
        """As of every tree, but not of the courses below."""
        return [] if self.done(node) else super().removals(node)

    def least(self, node: Node) -> int:
        """Number of blocks below which a node is better; one in which nothing is left always is."""
        return node.placed.bit_count() + self.done(node)

    def below(self, root: Node, limit: Cost) -> tuple[list[Node], bool] | None:
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
        tuple or None
            As by :meth:`run`; None if nothing was found. If nothing was found and no state is left,
            the path is empty, and it is proved that no order needs less help.
        """
        exhaustive = self.exhaustive
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
            if stands and following is not None and self.done(node):
                best, limit = node, least
            for one in following or []:
                pushed += 1
                heapq.heappush(queue, (one.placed.bit_count(), self.estimate(one), pushed, one))
        done = exhaustive and not queue
        if best is None:
            return ([], True) if done else None
        return best.path(), done

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
        """Keep the best stage, and report its progress."""
        if self.reached is None or node.placed.bit_count() < self.reached.placed.bit_count():
            self.reached = node
        if self.progress is not None:
            total = (self.bound.there & ~self.bound.core).bit_count()
            left = (node.placed & ~self.bound.core).bit_count()
            self.progress("planning", total - left, total)

    def to_check(self, node: Node) -> bool:
        """Whether a node that was only looked at waits for its check."""
        alone = node.parent is None or node.cost == node.parent.cost
        return self.quick and not self.imposed and (self.few or alone)

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
