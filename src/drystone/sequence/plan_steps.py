"""The parts of a plan: its steps, the status of every block, the props."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.sequence.stages import StageAnswer


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
