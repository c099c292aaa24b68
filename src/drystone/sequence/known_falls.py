"""Motions with which stages were shown to fall, and the other stages that they prove to fall.

A collapse mechanism says of each corner that it opens, and of the loads that they do work. Of
another stage it says the same if the blocks that it would run into are absent, and none of the
blocks that it moves is held: to know that takes no calculation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.checks import block_speed, closing
from drystone.formulations.nearest_mechanism import STILL
from drystone.sequence.staged_model import StagedModel
from drystone.sequence.stages import Stage, mask_of, members
from drystone.stability.proofs import FALLING_SHARE, MECHANISM_TOLERANCE


@dataclass(frozen=True, eq=False)
class Fall(OneLine):
    """A motion of some blocks, all others at rest.

    Attributes
    ----------
    moving
        Set of the blocks that move.
    stopped
        Pairs of blocks, as sets, of which both must not be in place; of a support and a block the
        set has only the block.
    power, gross
        Work of the load of each moving block, and the sum of its absolute parts.
    """

    moving: int
    stopped: tuple[int, ...]
    power: dict[int, float]
    gross: dict[int, float]

    def proves(self, part: Stage) -> bool:
        """Whether a part falls with it."""
        placed = part.placed
        present = self.moving & placed
        if not present or present & part.held:
            return False
        if any(pair & placed == pair for pair in self.stopped):
            return False
        # a proof has 1e-9 or more; where blocks are left out less is not relied upon
        blocks = list(members(present))
        power = sum(self.power[b] for b in blocks)
        return power > FALLING_SHARE * sum(self.gross[b] for b in blocks)


class KnownFalls(OneLine):
    """The falls of one model. Joints that pull or cohere may resist, so there nothing is kept."""

    def __init__(self, model: StagedModel) -> None:
        self.model = model
        self._kept: dict[tuple[int, tuple[int, ...]], Fall] = {}

    def _summary(self) -> str:
        return counted(len(self._kept), "fall")

    def add(self, part: Stage, motion: Floats) -> None:
        """Keep the mechanism (b, 6) [m, rad] of the moving blocks of a part that falls.

        Blocks that do not touch each other fall alone, so each is kept alone.
        """
        if not len(motion) or not self.model.contacts.dry.all():
            return
        every = np.zeros((len(self.model.assembly), 6))
        every[list(members(part.placed & ~part.held))] = motion
        speed = block_speed(self.model.assembly, every)
        moving = mask_of(np.flatnonzero(speed > STILL * speed.max()).tolist())
        for group in self.model.parts(Stage(moving)):
            alone = np.zeros_like(every)
            alone[list(members(group.placed))] = every[list(members(group.placed))]
            found = self._fall(group.placed, alone)
            if found.proves(part):
                self._kept.setdefault((found.moving, found.stopped), found)

    def _fall(self, moving: int, motion: Floats) -> Fall:
        contacts, free = self.model.contacts, self.model.assembly.free
        work = self.model.load.wrench * motion
        closes = closing(self.model.model, motion) > MECHANISM_TOLERANCE
        joints = np.unique(contacts.interface[closes])
        pairs = zip(
            contacts.block_a[joints].tolist(), contacts.block_b[joints].tolist(), strict=True
        )
        movable = mask_of(free.tolist())
        stopped = {(1 << a | 1 << b) & movable for a, b in pairs}
        blocks = list(members(moving))
        return Fall(
            moving,
            tuple(sorted(stopped)),
            {b: float(work[b].sum()) for b in blocks},
            {b: float(np.abs(work[b]).sum()) for b in blocks},
        )

    def falling(self, part: Stage) -> int:
        """The blocks of a part that are known to fall, as a set; empty where it is not known."""
        found = 0
        for fall in self._kept.values():
            if fall.moving & part.placed & ~found and fall.proves(part):
                found |= fall.moving & part.placed
        return found
