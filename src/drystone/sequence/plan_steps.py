"""The steps of a plan, and what follows from them: order, status of every block, props.

The checks of a step of a plan, and of what it would be without its help.
"""

from __future__ import annotations

import enum
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from drystone.base.arrays import Floats, Ints, whole
from drystone.base.display import OneLine, named
from drystone.base.errors import InputError, counted
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.robots import Robot
from drystone.sequence.rules import RemovalTest
from drystone.sequence.stages import Stage, StageAnswer, StagedModel, mask_of, members
from drystone.stability.touching_edges import may_touch_more
from drystone.supports import props_of


class Status(enum.Enum):
    """How a block is placed."""

    SUPPORT = "support"
    """In place from the beginning."""
    FREE = "free"
    """Placed alone; it stands at once."""
    HELD = "held"
    """Placed together with its partners: one is placed while hands hold the others."""
    PROPPED = "propped"
    """Needs a prop during some stages."""
    UNSURE = "unsure"
    """Placed alone; that it stands then was not shown."""
    IMPOSSIBLE = "impossible"
    """Cannot be placed."""


@dataclass(frozen=True, eq=False)
class Step(OneLine):
    """The blocks placed between two stages that stand, alone or with props.

    Attributes
    ----------
    blocks
        In the order of placement; all except the last are held until the last is in place.
    motion : (b, 3) unit
        Direction in which each block is moved into place.
    props
        Blocks that are propped after the step.
    placed
        All free blocks in place, as bits.
    answer
        Of the stage at the end of the step.
    during
        Answers while blocks are held, one after each block except the last.
    why
        Why the step needs hands or a new prop: the result of the check without them. Empty if it
        needs none, and in models with more than 100 free blocks.
    """

    blocks: tuple[int, ...]
    motion: Floats
    props: tuple[int, ...]
    placed: int
    answer: StageAnswer
    during: tuple[StageAnswer, ...] = ()
    why: str = ""

    def _summary(self) -> str:
        propped = f", propped {self.props}" if self.props else ""
        return f"blocks {self.blocks}{propped}, {self.answer.verdict}"

    def hold(self, block: int) -> Floats:
        """The largest force and moment (6,) [N, N m] that hold a block, about its centroid.

        Zero of the last block, and where the hand gives nothing; less may hold it too.
        """
        wrench = [a.reaction[block] for a in self.during if block in a.reaction]
        return max(wrench, key=lambda w: float(np.linalg.norm(w[:3])), default=np.zeros(6))


@dataclass(frozen=True, eq=False)
class Prop(OneLine):
    """A prop under one block.

    Attributes
    ----------
    block
    first, last
        First and last step, counted from 0, after which it is in place; ``last`` is the final step
        if the complete structure does not stand without it.
    wrench : (6,) [N, N m]
        Largest force and moment of the prop, about the block's centroid.
    """

    block: int
    first: int
    last: int
    wrench: Floats

    @property
    def stages(self) -> int:
        """Number of stages in which it is needed."""
        return self.last - self.first + 1

    @property
    def force(self) -> float:
        """[N], the size of its largest force."""
        return float(np.linalg.norm(self.wrench[:3]))


@dataclass(frozen=True, eq=False)
class PlannedSteps:
    """Steps from the supports to the complete structure.

    Attributes
    ----------
    model
    steps
        Empty if there is no plan.
    impossible
        Blocks that cannot be placed, and why; they are in place in no step.
    """

    model: StagedModel
    steps: tuple[Step, ...]
    impossible: Mapping[int, str]

    @cached_property
    def order(self) -> tuple[str, ...]:
        """Names in the order of assembly."""
        names = self.model.assembly.names
        return tuple(names[b] for step in self.steps for b in step.blocks)

    @cached_property
    def step_of(self) -> Mapping[int, int]:
        """Position in ``steps`` of the one that places each block; it is told as one more."""
        return {b: i for i, step in enumerate(self.steps) for b in step.blocks}

    @cached_property
    def props(self) -> tuple[Prop, ...]:
        """All props, in the order in which they are needed."""
        out = []
        for block in dict.fromkeys(b for step in self.steps for b in step.props):
            when = [i for i, step in enumerate(self.steps) if block in step.props]
            found = [
                answer.reaction[block]
                for i in when
                for answer in (*self.steps[i].during, self.steps[i].answer)
                if block in answer.reaction
            ]
            size = [float(np.linalg.norm(one[:3])) for one in found]
            out.append(Prop(block, when[0], when[-1], found[int(np.argmax(size))]))
        return tuple(out)

    @cached_property
    def status(self) -> tuple[Status, ...]:
        """(n,) of each block."""
        propped = {prop.block for prop in self.props}

        def of(block: int) -> Status:
            if block in self.impossible:
                return Status.IMPOSSIBLE
            if block not in self.step_of:  # in place from the beginning
                return Status.SUPPORT
            step = self.steps[self.step_of[block]]
            if block in propped:
                return Status.PROPPED
            if len(step.blocks) > 1:
                return Status.HELD
            return Status.FREE if step.answer.stands else Status.UNSURE

        return tuple(of(block) for block in range(len(self.model.assembly)))

    @property
    def help(self) -> tuple[int, int, int]:
        """Number of propped blocks, of held blocks, and of simultaneous placements.

        Simultaneous placements are the blocks of each step, without the last.
        """
        held = sum(one is Status.HELD for one in self.status)
        return len(self.props), held, sum(len(step.blocks) - 1 for step in self.steps)

    @property
    def hands(self) -> int:
        """Largest number of blocks that hands or props keep in place at once, the placed one too.

        It is no advice: with other hands another plan is found.

        Examples
        --------
        >>> from drystone.models import arch
        >>> from drystone.sequence import plan
        >>> found = plan(arch(0.3, 7), friction=0.7)
        >>> found.counts["propped"], found.hands
        (1, 2)
        """
        in_place = [(), *(step.props for step in self.steps)]
        return max(
            (len({*before, *step.blocks, *step.props})
             for before, step in zip(in_place, self.steps, strict=False)), default=0,
        )  # fmt: skip

    def partners(self, block: int) -> tuple[int, ...]:
        """Blocks that are placed together with this one."""
        step = self.step_of.get(block)
        together = () if step is None else self.steps[step].blocks
        return tuple(b for b in together if b != block)

    def directions(self, number: int) -> tuple[Floats, ...]:
        """Generators (g, 3), unit, of the directions in which each block of a step can be inserted.

        Sums with non-negative factors are free. The joints with the blocks in place block every
        other translation.
        """
        removal = RemovalTest(self.model)
        placed = self.before(number)
        out = []
        for block in self.steps[number].blocks:
            out.append(0.0 - removal.freedom(block, placed).generators)
            placed |= 1 << block
        return tuple(out)

    @cached_property
    def counts(self) -> dict[str, int]:
        """Number of blocks of each status, without blocks that were not planned."""
        known = self.status if self.steps or self.impossible else ()
        return {one.value: sum(s is one for s in known) for one in Status}

    @property
    def drop(self) -> float:
        """[m], sum of the descents from one placement to the next."""
        height = self.model.height[[b for step in self.steps for b in step.blocks]]
        return float(np.maximum(0.0, -np.diff(height)).sum())

    @cached_property
    def known_steps(self) -> int:
        """Number of steps before the first stage that is not known to stand."""
        answers = [(*step.during, step.answer) for step in self.steps]
        stands = [all(one.stands for one in some) for some in answers]
        return [*stands, False].index(False)

    def stage(self, number: int) -> Model:
        """The blocks in place after a step; those that are propped are supports.

        Steps are counted from 0; negative numbers count from the end.

        Raises
        ------
        InputError
            There is no such step.
        """
        i, most = whole(number, "the number of a step"), len(self.steps)
        if not -most <= i < most:
            remedy = f"they are counted from 0 to {most - 1}" if most else "the plan has none"
            raise InputError(f"there is no step {i}", remedy=remedy)
        step = self.steps[i]
        return self.model.cut_out(Stage(step.placed, mask_of(step.props)))[0]

    @cached_property
    def on_edge(self) -> Mapping[int, str]:
        """Steps after which something stands exactly above an edge, from 0, and what it is.

        Those after settling are left out.
        """
        told = {}
        for number, step in enumerate(self.steps):
            if step.answer.stands and not step.answer.settled:
                told[number] = self._forces(number).zero_margin
        return {number: words for number, words in told.items() if words}

    def _forces(self, number: int) -> Result:
        """The forces at the end of a step, without joints of blocks that are not in place."""
        answer, contacts = self.steps[number].answer, self.model.contacts
        here = np.array(self.model.assembly.fixed)
        here[list(members(self.steps[number].placed))] = True
        chosen = here[contacts.block_a] & here[contacts.block_b]
        force = np.zeros((contacts.corner_count, 3))
        force[answer.corner] = answer.force
        force = force[chosen[contacts.interface]]
        return Result(answer.message, answer.verdict, self.stage(number), force=force)

    def before(self, number: int) -> int:
        """Blocks in place before a step begins, as bits."""
        return self.steps[number].placed & ~mask_of(self.steps[number].blocks)

    @property
    def told(self) -> str:
        """The number of steps, and of blocks of each status."""
        counts = self.counts
        always, known = ("free", "held", "propped"), [*counts.items()][1:]
        said = ", ".join(f"{n} {kind}" for kind, n in known if n or kind in always)
        return f"{counted(len(self.steps), 'step')}: {said}"


def assigned(plan: PlannedSteps, team: Sequence[Robot]) -> dict[int, int]:
    """The robot of each block, in turn and for as many blocks as can be.

    Each block of a step has another robot: it holds it until the last one is in place.
    """
    from scipy.optimize import linear_sum_assignment  # slow to import

    assembly, chosen, turn = plan.model.assembly, dict[int, int](), 0
    for step in plan.steps[: plan.known_steps] if team else ():
        at, mass = assembly.centroid[list(step.blocks)], assembly.mass[list(step.blocks)]
        can = np.stack([robot.manages(at, mass) for robot in team], axis=1)
        wait = (np.arange(len(team)) - turn - np.arange(len(at))[:, None]) % len(team)
        of, robot = linear_sum_assignment(np.where(can, wait, len(team) ** 3))
        for i, k in zip(of.tolist(), robot.tolist(), strict=True):
            if can[i, k]:
                chosen[step.blocks[i]], turn = k, k + 1
    return chosen


def checked_step(
    evaluator: Evaluator,
    before: int,
    blocks: tuple[int, ...],
    motion: Floats,
    standing: int,
    props: tuple[int, ...],
    near: tuple[int, int] | None = None,
) -> Step:
    """A step, with the answers of its stages.

    Parameters
    ----------
    evaluator
    before
        Blocks in place before it, as bits.
    blocks
        In the order of placement.
    motion : (b, 3) unit
    standing
        Blocks that are propped before it, as bits.
    props
        Blocks that are propped after it.
    near
        Blocks in place and held blocks of a similar stage that was checked.
    """
    sure = partial(evaluator.answer, forces=True, checked=evaluator.model.small)
    after = Stage(before | mask_of(blocks), mask_of(props), False, near)
    answer = sure(after)
    during = []
    placed, propped = before, standing | mask_of(props)
    for number, block in enumerate(blocks[:-1]):
        placed |= 1 << block
        held = mask_of(blocks[: number + 1]) | propped & placed
        stage = Stage(placed, held, False, (after.placed, after.held))
        during.append(sure(stage))
    return Step(blocks, motion, props, after.placed, answer, tuple(during))


def without_help(evaluator: Evaluator, step: Step, standing: int) -> str:
    """The result of a step without its hands and without its new props, as text.

    Parameters
    ----------
    evaluator
    step
    standing
        Blocks that are propped before it, as bits.
    """
    props = mask_of(step.props)
    alone, near = [], (step.placed, props)
    if len(step.blocks) > 1:
        first = step.placed & ~mask_of(step.blocks[1:])
        alone.append(Stage(first, (props | standing) & first, False, near))
    if props & ~standing:
        alone.append(Stage(step.placed, props & standing, False, near))
    found = (evaluator.answer(stage) for stage in alone)
    names = evaluator.model.assembly.names
    told = [falling_words(one, names) + one.message for one in found if not one.stands]
    return "without help: " + "; then ".join(told) if told else ""


def permanent(model: StagedModel) -> tuple[Ints, Ints, Ints]:
    """Interfaces at which fixed blocks that are props carry others, the props, the others: (p,)."""
    contacts, prop = model.contacts, props_of(model.assembly)
    ends = np.stack([contacts.block_a, contacts.block_b], axis=1)
    at = np.flatnonzero(prop[ends].sum(axis=1) == 1)
    return at, ends[at][prop[ends[at]]], ends[at][~prop[ends[at]]]


def permanent_words(model: StagedModel, order: Collection[int]) -> str:
    """How many props are fixed blocks, and the first in an order that needs each; else empty."""
    rank, first = {block: i for i, block in enumerate(order)}, dict[int, int]()
    for prop, block in np.stack(permanent(model)[1:], axis=1).tolist():
        if block in rank:
            first[prop] = min(first.get(prop, len(rank)), rank[block])
    names = [model.assembly.names[block] for i, block in enumerate(order) if i in first.values()]
    props = counted(int(props_of(model.assembly).sum()), "permanent prop")
    before = "before" if len(names) == 1 else "before the first block on each:"
    blocks = named([f"'{one}'" for one in names])
    return f"{props}, which must be there {before} {blocks}" if names else ""


def falling_words(answer: StageAnswer, names: Sequence[str]) -> str:
    """The blocks that fall, followed by a semicolon; empty if unknown."""
    falling = [names[block] for block in answer.falling]
    verb = "falls" if len(falling) == 1 else "fall"
    return f"{named(falling)} {verb}; " if falling else ""


def refusal(complete: StageAnswer, model: StagedModel) -> str:
    """Why no order does: the complete structure does not stand, and what to do."""
    words = falling_words(complete, model.assembly.names).removesuffix("; ")
    told = f"{f': {words}' if words else ''}; {complete.message}"
    if complete.verdict is Verdict.UNSTABLE:
        remedy = "change it with drystone mend, or plan it --anyway, with props that stay"
        return f"the complete structure does not stand{told}; {remedy}"
    more = "" if may_touch_more(model.model) else "; a thorough check (--thorough) tries more"
    return f"the complete structure was not shown to stand{told}{more}"
