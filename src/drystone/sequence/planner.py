"""Planning: check the complete structure, search its disassembly, and reverse it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Unpack

import numpy as np

from drystone.base.errors import counted
from drystone.base.files import PathLike
from drystone.base.settings import Clock, Options, Stopped, checked_call
from drystone.io.opening import Given, LongHow, as_model
from drystone.sequence.evaluation import Evaluator, finished, finished_whole
from drystone.sequence.helping import Trimmed, mended, trimmed
from drystone.sequence.order_search import OrderSearch
from drystone.sequence.plan_steps import Step, checked_step, refusal, without_help
from drystone.sequence.plans import Plan
from drystone.sequence.rules import BoundRules, Order, RemovalTest, Rules, bind, removal_rank
from drystone.sequence.scaffold_places import ScaffoldOptions, Support
from drystone.sequence.scaffold_stages import ScaffoldedStages
from drystone.sequence.stage_tree import NO_HELP, Node
from drystone.sequence.stages import (
    CHECKED,
    Check,
    StageAnswer,
    StagedModel,
    check_both,
    members,
)
from drystone.sequence.turns import in_turn
from drystone.stability.attempts import MANY_BLOCKS, stage_screening

EFFORT, LARGE = 1600.0, 50.0
"""The planner holds or props blocks after EFFORT / n stages without progress, with n free blocks
in the largest connected part; above LARGE blocks after EFFORT * LARGE / n**2. This gives 200 stages
for 8 blocks (most stages can be checked), 40 for a vault of 40 blocks, 22 for a dome of 60, and
none for 400. With half of it a shell of 42 blocks has 21 props instead of 12."""


@dataclass(frozen=True)
class PlanOptions(Options):
    """Options of :func:`plan`.

    Attributes
    ----------
    rules
    patience : >= 0
        Stages without progress before blocks are held or propped. When left out: 1600 divided by
        the number of free blocks in the largest connected part, fewer above 50 blocks. Infinite:
        the plan is proved to need the least help (`Plan.proved`).
    width : >= 1
        Number of blocks tried for removal at each stage. The default covers the ends of a course
        and a few more.
    anyway
        Plan even if the complete structure does not stand; some props then stay in the end.
    scaffold
        What holds propped blocks, or its name; each stage must stand with it. When left out: ideal
        props that hold a block in every direction.
    scaffold_options
        Limits of the scaffolding.
    """

    rules: Rules = field(default_factory=Rules)
    patience: float | None = None
    width: int = 16
    anyway: bool = False
    scaffold: Support | None = None
    scaffold_options: ScaffoldOptions = field(default_factory=ScaffoldOptions)


@checked_call
def plan(
    given: Given,
    *,
    options: PlanOptions | None = None,
    check: Check | None = None,
    checkpoint: PathLike | None = None,
    **how: Unpack[LongHow],
) -> Plan:
    """Plan the order of assembly, the held blocks and the props.

    Blocks are removed from the complete structure so that the remaining structure stands. The order
    of assembly is the reverse. A stage is the set of blocks in place; each stage is checked.

    Parameters
    ----------
    given
        A model of the complete structure; or an assembly or a file that ``how`` turns into one.
    options
    check
        Function that gives the verdict on a stage. When left out:
        :data:`drystone.sequence.check_both`, after a quick look for a rest state; the complete
        structure may also stand after settling.
    checkpoint
        File from which the search continues after an interruption.

    Returns
    -------
    Plan
        Without steps if the complete structure does not stand, or if the search was stopped. In the
        second case ``stopped`` has the reason, ``complete`` is known, and the checkpoint keeps
        every checked stage.

    Raises
    ------
    InputError
        Rules contradict each other or name unknown blocks; no hand; no support.

    Examples
    --------
    >>> from drystone.models import tower
    >>> found = plan(tower(4))
    >>> found.order
    ('block-1', 'block-2', 'block-3')
    >>> found.counts["free"]
    3
    """
    chosen = PlanOptions.of(options)
    clock = Clock.of(how)
    model = StagedModel(as_model(given, **how), check or check_both)
    if check is None:
        model = replace(model, quick=stage_screening(model.largest[0]))
    clock.tell("planning", 0, len(model.assembly.free))
    bound = bind(chosen.rules, model, RemovalTest(model))
    workers, late = clock.workers, clock.late
    with Evaluator(model, executor=workers, checkpoint=checkpoint, late=late) as evaluator:
        complete, touching = finished_whole(evaluator, check)
        if touching is not None:  # these edges count in the stages too
            return plan(touching, options=options, checkpoint=checkpoint, **clock.rest)
        if not complete.stands and not chosen.anyway:
            return _no_plan(evaluator, complete, refusal(complete, model))
        if complete.stands:
            bound = bound.without_what_falls(partial(finished, evaluator, check=check))
        planner = _Planner(evaluator, bound, chosen, clock)
        try:
            return planner.run(complete)
        except Stopped:
            return planner.stopped(complete)


def _no_plan(evaluator: Evaluator, complete: StageAnswer, message: str) -> Plan:
    """A plan without steps."""
    return Plan(
        evaluator.model, (), {}, complete=complete, message=message,
        solved=evaluator.solved, solve_s=evaluator.solve_s,
    )  # fmt: skip


class _Planner:
    """Search, then the plan that follows from the stages found."""

    def __init__(
        self,
        evaluator: Evaluator,
        bound: BoundRules,
        options: PlanOptions,
        clock: Clock,
    ) -> None:
        self.evaluator = evaluator
        self.clock = clock
        self.cut = ""  # why less help was not searched for to the end
        self.model = evaluator.model
        self.bound = bound
        self.options = options
        self.last_search: OrderSearch | None = None
        self.scaffold: ScaffoldedStages | None = None
        if options.scaffold is not None:
            kind, bearing = options.scaffold, options.scaffold_options
            self.scaffold = ScaffoldedStages(self.model.model, kind, bearing)
        free, _ = self.model.largest
        effort = EFFORT / max(1.0, free) * min(1.0, LARGE / max(1.0, free))
        self.patience = effort if options.patience is None else options.patience

    def run(self, complete: StageAnswer) -> Plan:
        order = self.search(complete, self.bound)
        plan = self.describe(complete, order, self.imposed_order(complete, order))
        other = self.in_turn(plan)
        return replace(plan, message=f"{plan.message}; {other}") if other else plan

    def in_turn(self, plan: Plan) -> str:
        """Whether hands that each hold their block until the next is in place need no prop."""
        bound, large = self.bound, self.model.largest[0] > MANY_BLOCKS
        if not plan.props or plan.impossible or bound.hands < 2 or bound.lifters.max() > 1 or large:
            return ""
        placed = 0
        for block in self.model.assembly.free.tolist():
            placed |= 1 << block
            if not bound.can_leave(block, placed):
                return ""
        blocks = self.model.assembly.free.tolist()
        # a look first: a vault of 97 blocks falls after 0.05 s of looks, and 0.5 s of checks
        look = partial(in_turn, self.evaluator, blocks, bound.rules.team, self.clock)
        said = "hands that hold each block until the next is in place need no prop: --turns"
        return said if look(quick=True).works and look().works else ""

    def search(self, complete: StageAnswer, bound: BoundRules) -> Trimmed:
        """The order with the least help that is found.

        Of scaffolding: the order with ideal props, with more of them where it does not carry; or
        what is found with scaffolding at each stage, where that needs less.
        """
        if self.scaffold is None or math.isinf(self.patience):
            return self.searched(complete, bound)
        ideal = self.searched(complete, bound, carried=False)
        try:
            known = mended(ideal, self.new_search(bound))
        except Stopped:
            self.cut_short(f"{self.scaffold.support.words(2)} were tried in place of ideal props")
            return ideal
        if self.cut or known.rank == (0, 0, ideal.cost):
            return known
        try:
            other = self.on_scaffolding(complete, bound, known)
        except Stopped:
            self.cut_short()
            return known
        if self.evaluator.late():
            self.cut_short()
        return min(known, other, key=lambda one: one.rank)

    def on_scaffolding(self, complete: StageAnswer, bound: BoundRules, known: Trimmed) -> Trimmed:
        """The order of a search with scaffolding at each stage.

        By courses, where the known order is not carried: a course carries the next one, where a
        strip that leans needs more than struts.
        """
        fails = any(known.failures)
        if fails and bound.rules.order is Order.TOP:
            courses = bind(replace(bound.rules, order=Order.COURSE), self.model, bound.removal)
            bound = replace(courses, impossible=bound.impossible)
        other = self.searched(complete, bound)
        return min(mended(other, self.new_search(bound)), other, key=lambda one: one.rank)

    def searched(
        self, complete: StageAnswer, bound: BoundRules, *, carried: bool = True
    ) -> Trimmed:
        """An order by searches of one kind; see :meth:`new_search`.

        Where the check denies stages of it that a quick look found to stand, it is searched again
        with what is known then, until no fewer are denied. In models of few blocks less help is
        searched below it, except where the order is given.
        """
        search = self.new_search(bound, carried=carried)
        root = Node(bound.there, 0)
        if not complete.stands:
            root = replace(search.prop(root, complete), cost=NO_HELP)
        best = trimmed(search.run(root), search)
        left = len(best.path)
        while 0 < best.denied < left:
            left = best.denied
            search = self.new_search(bound, carried=carried)
            best = min(
                best, trimmed(search.run(root), search), key=lambda one: (one.denied, one.cost)
            )
        known = best.cost == NO_HELP or best.proved or math.isinf(self.patience)
        if known or not search.few or not isinstance(self.bound.rules.order, Order):
            return best
        try:
            less = search.below(root, best.cost)
        except Stopped:
            self.cut_short()
            return best
        if less is None:
            return best
        if not less[0]:
            return replace(best, proved=True)
        return min(best, trimmed(less, search), key=lambda one: one.cost)

    def cut_short(self, before: str = "less help was searched for to the end") -> None:
        """Go on without a time limit: what was found is told in full."""
        self.evaluator.late = bool
        self.cut = f"{self.clock.reason} before {before}"

    def new_search(self, bound: BoundRules, *, carried: bool = True) -> OrderSearch:
        """A search that knows what is known of stages.

        Parameters
        ----------
        bound
        carried
            Whether scaffolding must carry the stages; else it only tells which blocks take it.
        """
        self.last_search = OrderSearch(
            self.evaluator, bound, self.patience, self.options.width, progress=self.clock.progress,
            scaffold=self.scaffold, carried=carried,
        )  # fmt: skip
        return self.last_search

    def stopped(self, complete: StageAnswer) -> Plan:
        """What is known when the search is stopped: which blocks are placed last."""
        reached = None if self.last_search is None else self.last_search.reached
        total = (self.bound.there & ~self.bound.core).bit_count()
        last = 0 if reached is None else (self.bound.there & ~reached.placed).bit_count()
        before = "an order was found" if last < total else "help was spared in the order found"
        message = f"{self.clock.reason} before {before}"
        if reached is not None and last:
            message += f"; the last {last} of {counted(total, 'block')} are known"
            message += f", {reached.cost[0]} propped" if reached.cost[0] else ""
        return replace(
            _no_plan(self.evaluator, complete, message),
            stopped=self.clock.reason, reached=reached, rules=self.bound.rules,
        )  # fmt: skip

    def imposed_order(self, complete: StageAnswer, order: Trimmed) -> list[str]:
        """Where an order given by names is not kept, and whether another one needs no help."""
        given = self.bound.rules.order
        if isinstance(given, Order):
            return []
        names = self.model.assembly.names
        found = [names[b] for node in order.path for b in node.group[::-1]]
        wanted = [name for name in given if name in set(found)]
        words = [
            f"the given order is not kept: '{name}' is placed before '{want}'"
            for want, name in zip(wanted, found, strict=False)
            if want != name
        ][:1]
        small = self.model.largest[0] <= MANY_BLOCKS
        if order.cost != NO_HELP and not order.proved and complete.stands and small:
            other = replace(self.bound, rank=removal_rank(Order.TOP, self.model))
            if self.search(complete, other).cost == NO_HELP:
                words.append(
                    "a plan without help exists in another order, which is found without a given "
                    "order (without --order)"
                )
        return words

    def describe(self, complete: StageAnswer, order: Trimmed, own: Sequence[str]) -> Plan:
        path, active = order.path, order.props
        steps: list[Step] = []
        told = self.model.largest[0] <= MANY_BLOCKS
        near = None
        for number in reversed(range(1, len(path))):  # each begins at the rest states of the last
            props = active[number - 1], active[number]
            step = self.step(path[number - 1], *props, near)
            near = step.placed, props[1]
            fails = order.failures[number]
            if step.answer.stands and fails is not None:
                answer = replace(
                    step.answer, verdict=fails.verdict, message=fails.message, falling=fails.falling
                )
                step = replace(step, answer=answer)
            if told:
                step = replace(step, why=without_help(self.evaluator, step, props[0]))
            steps.append(step)
            self.clock.tell("verifying stages", len(steps), len(path) - 1)
        steps.reverse()
        impossible = dict(self.bound.impossible)
        return Plan(
            self.model, tuple(steps), impossible, complete=complete,
            message="; ".join([self.message(complete, steps, impossible), *own]),
            proved=self.proves(complete, order.proved, steps), solved=self.evaluator.solved,
            solve_s=self.evaluator.solve_s, rules=self.bound.rules,
        )  # fmt: skip

    def message(
        self, complete: StageAnswer, steps: Sequence[Step], impossible: dict[int, str]
    ) -> str:
        """How a plan ended."""
        if not steps:
            return "no block can be placed" if impossible else "there is no block to place"
        screened = self.model.quick is not None and not self.model.small
        settled = sum(step.answer.stands and bool(step.answer.settled) for step in steps)
        words = self.flaws(complete, steps)
        if not words:
            stage = "every stage of the others" if impossible else "every stage"
            words = [f"{stage} stands{' with uniform contact stiffness' if screened else ''}"]
        if self.cut:
            words.append(self.cut)
        if settled:
            words.append(f"{settled} of {len(steps)} after settling: there the joints decide")
        if screened:
            words.append(
                f"above {CHECKED} corners a stage is only looked at, and not followed (--thorough, "
                "or check=check_both in Python, checks it)"
            )
        return "; ".join(words)

    def flaws(self, complete: StageAnswer, steps: Sequence[Step]) -> list[str]:
        """What does not stand."""
        words = []
        if not complete.stands:
            words.append("the complete structure does not stand without its props")
        unsure = [step for step in steps if not step.answer.stands]
        if unsure:
            last = self.model.assembly.names[unsure[0].blocks[-1]]
            words.append(
                f"{counted(len(unsure), 'stage')} could not be shown to stand, the first when "
                f"'{last}' is placed: {unsure[0].answer.message}"
            )
            falling = {block for step in unsure for block in step.answer.falling}
            if self.scaffold is not None and self.scaffold.refusal(falling):
                words.append(self.scaffold.refusal(falling))
        return words

    def proves(self, complete: StageAnswer, proved: bool, steps: list[Step]) -> bool:
        """Whether no order needs less help: there is no help, or the search was complete."""
        props = {block for step in steps for block in step.props}
        together = sum(len(step.blocks) - 1 for step in steps)
        if self.bound.core or self.bound.impossible:
            return False
        if together == 0 and len(props) <= (0 if complete.stands else 1):
            return True
        # other props may support a complete structure that does not stand
        return proved and complete.stands

    def step(self, before: Node, standing: int, props: int, near: tuple[int, int] | None) -> Step:
        """The step from one stage to the next; its order is the reverse of the search."""
        blocks = before.group[::-1]
        begins = placed = before.placed
        motion = []
        for block in blocks:
            out = self.bound.removal.direction(block, placed)
            motion.append(-self.model.up if out is None else -out)
            placed |= 1 << block
        directions = np.array(motion).reshape(-1, 3)
        some = tuple(members(props))
        return checked_step(self.evaluator, begins, blocks, directions, standing, some, near)
