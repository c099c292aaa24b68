"""The complete structure: which blocks touch, which are connected, and how high they are.

Blocks that are not connected through free blocks do not influence each other. So a stage is divided
into connected parts. Each part is checked and cached separately: after the removal of a block only
its part is checked again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.loads import LoadCase
from drystone.model import Model, OfModel
from drystone.sequence.stages import Check, Stage, check_both, mask_of, members
from drystone.stability import Screening

CHECKED = 1000
"""Most corners of a connected part with which every stage of a plan is checked, also where a quick
look shows that it stands, and with which the complete structure may stand after settling."""


@dataclass(frozen=True, eq=False)
class StagedModel(OfModel, OneLine):
    """The complete model, and how its stages are checked.

    Attributes
    ----------
    model
    check
        Function that gives the verdict on a stage.
    quick
        How a stage is looked at before its check; None: it is checked at once.
    """

    model: Model
    check: Check = check_both
    quick: Screening | None = None

    def __post_init__(self) -> None:
        self.model.require_still()
        if not self.assembly.fixed.any():
            raise InputError("no block is fixed", remedy="fix the supports")

    @property
    def load(self) -> LoadCase:
        """The load of the model."""
        return self.model.load

    @cached_property
    def everything(self) -> int:
        """The set of all free blocks."""
        return mask_of(self.assembly.free.tolist())

    @cached_property
    def _touching(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Per block the sets of free blocks and of supports that touch it."""
        free, grounds = [0] * len(self.assembly), [0] * len(self.assembly)
        pairs = zip(self.contacts.block_a.tolist(), self.contacts.block_b.tolist(), strict=True)
        fixed = self.assembly.fixed.tolist()
        for a, b in pairs:
            (grounds if fixed[b] else free)[a] |= 1 << b
            (grounds if fixed[a] else free)[b] |= 1 << a
        return tuple(free), tuple(grounds)

    @property
    def neighbours(self) -> tuple[int, ...]:
        """Per block the set of free blocks that touch it."""
        return self._touching[0]

    @property
    def grounds(self) -> tuple[int, ...]:
        """Per block the set of supports that touch it."""
        return self._touching[1]

    @cached_property
    def up(self) -> Floats:
        """Unit vector (3,) opposite to the total load; z if there is no load."""
        total = self.load.wrench[self.assembly.free, :3].sum(axis=0)
        size = float(np.linalg.norm(total))
        return -total / size if size > 0.0 else np.array([0.0, 0.0, 1.0])

    @cached_property
    def height(self) -> Floats:
        """Heights (n,) [m] of the centroids, opposite to the load."""
        out: Floats = self.assembly.centroid @ self.up
        return out

    def around(self, blocks: int) -> int:
        """The set of free blocks that touch some blocks."""
        near = 0
        for block in members(blocks):
            near |= self.neighbours[block]
        return near

    def _reached(self, start: int, within: int) -> int:
        """The set of blocks that are connected to some blocks through blocks of a set."""
        reached = frontier = start
        while frontier:
            frontier = self.around(frontier) & within & ~reached
            reached |= frontier
        return reached

    def parts(self, stage: Stage) -> list[Stage]:
        """The connected parts of a stage, each with its adjacent held blocks."""
        left = moving = stage.placed & ~stage.held
        out = []
        while left:
            reached = self._reached(left & -left, moving)
            held = self.around(reached) & stage.held
            out.append(Stage(reached | held, held, stage.quick, stage.near))
            left &= ~reached
        return out

    def cut_out(self, stage: Stage) -> tuple[Model, Ints]:
        """The model of a stage, its held blocks fixed, and the positions of its blocks."""
        fixed = np.flatnonzero(self.assembly.fixed).tolist()
        blocks = np.array(sorted([*fixed, *members(stage.placed)]), dtype=np.intp)
        resting = self.model.with_supports([*fixed, *members(stage.held)])
        return resting.subset(blocks), blocks

    @cached_property
    def largest(self) -> tuple[int, int]:
        """Most free blocks and most corners of a connected part of the complete structure."""
        part = np.full(len(self.assembly), -1)
        for number, one in enumerate(self.parts(Stage(self.everything))):
            part[list(members(one.placed))] = number
        joined = np.maximum(part[self.contacts.block_a], part[self.contacts.block_b])
        corners = joined[self.contacts.interface]
        blocks, points = np.bincount(part[part >= 0]), np.bincount(corners[corners >= 0])
        return int(blocks.max(initial=0)), int(points.max(initial=0))

    @property
    def small(self) -> bool:
        """Whether every stage of a plan is checked."""
        return self.largest[1] <= CHECKED

    def floating(self, placed: int) -> int:
        """Blocks in place that are not connected to a support through blocks in place."""
        return placed & ~self._reached(placed & self.grounded, placed)

    @cached_property
    def grounded(self) -> int:
        """Free blocks that touch a support."""
        return mask_of(b for b in self.assembly.free.tolist() if self.grounds[b])
