"""A plan: the steps of an assembly, the status of every block, the props and their forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import counted
from drystone.results import Verdict
from drystone.sequence.insertion import RemovalTest
from drystone.sequence.plan_answer import PlanAnswer
from drystone.sequence.plan_steps import Prop, Status, Step
from drystone.sequence.rules import Rules
from drystone.sequence.stages import StageAnswer
from drystone.sequence.structure import Structure


@dataclass(frozen=True, eq=False)
class Plan(PlanAnswer):
    """An order of assembly.

    Attributes
    ----------
    model
    complete
        Answer of the complete structure, without props.
    steps
        Empty if there is no plan.
    impossible
        Blocks that cannot be inserted, and why; they count as in place from the beginning.
    message
        Text for the user.
    proved
        Whether no other order needs less help: fewer propped blocks; with equally many fewer held
        blocks; with equally many of both more steps. Orders that leave a block without contact
        although another removal is possible are not counted.
    solved
        Number of checks of connected parts; ``solve_s`` is their total time.
    stopped
        Why the search stopped before an order was found; else empty.
    rules
        Of the search.
    """

    model: Structure
    complete: StageAnswer
    steps: tuple[Step, ...] = ()
    impossible: Mapping[int, str] = field(default_factory=dict)
    message: str = ""
    proved: bool = False
    solved: int = 0
    solve_s: float = 0.0
    stopped: str = ""
    rules: Rules = field(default_factory=Rules)

    def _summary(self) -> str:
        counts = ", ".join(f"{n} {kind}" for kind, n in self.counts.items() if n)
        told = f", {counts}" if counts else ""
        return f"{self.verdict}, {counted(len(self.steps), 'step')}{told}, '{self.message}'"

    def __bool__(self) -> bool:
        raise TypeError("a plan is neither true nor false; ask for its counts or its verdict")

    def __len__(self) -> int:
        """Number of steps."""
        return len(self.steps)

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps)

    @property
    def verdict(self) -> Verdict:
        """Verdict on the plan: STABLE if every stage stands, with the props of the plan.

        UNDECIDED if the search was stopped before it found an order.
        """
        if not self.steps:
            return Verdict.UNDECIDED if self.stopped else self.complete.verdict
        answers = [a for step in self.steps for a in (*step.during, step.answer)]
        return next((a.verdict for a in answers if not a.stands), Verdict.STABLE)

    @property
    def stable(self) -> bool:
        """Whether every stage stands, with the props of the plan."""
        return self.verdict is Verdict.STABLE

    @cached_property
    def order(self) -> tuple[str, ...]:
        """Names in the order of assembly."""
        names = self.model.assembly.names
        return tuple(names[b] for step in self.steps for b in step.blocks)

    @cached_property
    def step_of(self) -> Mapping[int, int]:
        """Step that places each block."""
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
            out.append(Prop(block, when[0], when[-1], max(found, key=_size)))
        return tuple(out)

    @cached_property
    def status(self) -> tuple[Status, ...]:
        """(n,) of each block."""
        fixed = self.model.assembly.fixed
        propped = {prop.block for prop in self.props}
        held = {b for step in self.steps if len(step.blocks) > 1 for b in step.blocks}

        def of(block: int) -> Status:
            if block in self.impossible:
                return Status.IMPOSSIBLE
            if fixed[block] or block not in self.step_of:  # in place from the beginning
                return Status.SUPPORT
            if block in propped:
                return Status.PROPPED
            return Status.HELD if block in held else Status.FREE

        return tuple(of(block) for block in range(len(fixed)))

    @property
    def help(self) -> tuple[int, int, int]:
        """Number of propped blocks, of held blocks, and of simultaneous placements.

        Simultaneous placements are the blocks of each step, without the last.
        """
        held = sum(one is Status.HELD for one in self.status)
        return len(self.props), held, sum(len(step.blocks) - 1 for step in self.steps)

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
        placed = placed_before(self, number)
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
        return _drop_of(self.model, [b for step in self.steps for b in step.blocks])


def _drop_of(model: Structure, order: Sequence[int]) -> float:
    """[m], sum of the descents from one placement to the next in an order."""
    height = model.height[list(order)]
    return float(np.maximum(0.0, -np.diff(height)).sum()) if len(height) > 1 else 0.0


def placed_before(plan: Plan, number: int) -> int:
    """Blocks in place before a step begins, as bits."""
    if number > 0:
        return plan.steps[number - 1].placed
    return plan.steps[0].placed & ~sum(1 << b for b in plan.steps[0].blocks)


def _size(wrench: Floats) -> float:
    return float(np.linalg.norm(wrench[:3]))
