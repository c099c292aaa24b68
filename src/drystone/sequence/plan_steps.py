"""The parts of a plan: its steps and their checks, the status of every block, the props."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.stages import Stage, StageAnswer, mask_of

CHECKED = 1000
"""Most corners of a connected part with which every stage of a plan is checked, also where a quick
look shows that it stands, and with which the complete structure may stand after settling."""
LISTED = 6
"""Number of falling blocks named in a message."""


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
    IMPOSSIBLE = "impossible"
    """Cannot be inserted."""


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
    checked = evaluator.model.largest[1] <= CHECKED

    sure = partial(evaluator.answer, forces=True, checked=checked)
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
    return "; ".join(
        "without help: " + falling_words(one, names) + one.message
        for one in found
        if not one.stands
    )


def falling_words(answer: StageAnswer, names: Sequence[str]) -> str:
    """The blocks that fall, followed by a semicolon; empty if unknown."""
    falling = answer.falling
    if not falling:
        return ""
    if len(falling) == 1:
        return f"{names[falling[0]]} falls; "
    more = f" and {len(falling) - LISTED} more" if len(falling) > LISTED else ""
    return f"{', '.join(names[b] for b in falling[:LISTED])}{more} fall; "
