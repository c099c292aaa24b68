"""The model of an analysis, and the conversion to physical numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, lengths
from drystone.base.ragged import linked
from drystone.checks import accelerations, block_speed
from drystone.mechanics.increments import FEW
from drystone.mechanics.statics import Statics, build_statics
from drystone.model import Model
from drystone.stability.free_fall import unpressed


@dataclass(frozen=True, eq=False)
class Problem:
    """A model, and its statics without the interfaces between two fixed blocks.

    Attributes
    ----------
    model
    corners : (k,) corners that take part
    statics
    """

    model: Model
    corners: Bools
    statics: Statics

    @classmethod
    def build(cls, model: Model) -> Problem:
        """The problem of a model.

        Raises
        ------
        InputError
            The load moves supports.
        """
        active = model.active
        part = model if active.all() else model.with_contacts(model.contacts.select(active))
        return cls(model, active[model.contacts.interface], build_statics(part))

    @classmethod
    def of(cls, given: Model | Problem) -> Problem:
        """A problem as it is, or that of a model."""
        return given if isinstance(given, Problem) else cls.build(given)

    def without(self, falling: Bools) -> Problem | None:
        """The model without some blocks (n,); None if no free block is left."""
        if self.model.assembly.fixed[~falling].all():
            return None
        return Problem.build(self.model.without(np.flatnonzero(falling).tolist()))

    def with_felt(self, force: Floats) -> Problem | None:
        """The same for blocks that feel some forces (k, 3) [N].

        The joints of those that feel hardly any are softer; None where no block differs so much.
        """
        statics = self.statics.with_felt(force[self.corners] / self.statics.force_unit)
        return None if statics is None else replace(self, statics=statics)

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("model", "corners", "statics")}

    @property
    def equilibrium_first(self) -> bool:
        """Whether it is cheaper to ask first whether any forces balance the loads.

        Of a small model with dry joints the nearest mechanism takes as long as a third of the path
        to a rest state; where there is no rest state, that path takes twice as long.
        """
        return self.statics.dry and self.statics.free_count <= FEW

    @cached_property
    def acceleration(self) -> Floats:
        """Acceleration (n, 6) of each free block under its load alone."""
        return accelerations(self.model.assembly, self.model.load.wrench)

    @cached_property
    def unpressed(self) -> Bools:
        """The free blocks (n,) on which nothing presses."""
        return unpressed(self.model.assembly, self.model.contacts, self.acceleration)

    def force(self, scaled: Floats) -> Floats:
        """Physical values (k, c) [N] of all corners from scaled ones of those that take part."""
        out = np.zeros((self.model.contacts.corner_count, scaled.shape[1]))
        out[self.corners] = self.statics.physical_force(scaled)
        return out

    def wrench(self, scaled: Floats) -> Floats:
        """Physical wrenches (n, 6) [N, N m] of all blocks."""
        return self.statics.physical_wrench(scaled, len(self.model.assembly))

    def displacement(self, scaled: Floats) -> Floats:
        """Virtual motion (n, 6) [m, rad] for a displacement unit of the mean block size."""
        return self.statics.physical_motion(
            scaled, len(self.model.assembly), self.statics.mean_length
        )

    def mechanism(self, scaled: Floats) -> Floats:
        """Motion (n, 6) whose fastest block moves by the mean size of a block."""
        return self.normalised(self.displacement(scaled))

    def normalised(self, motion: Floats) -> Floats:
        """The same physical motion, its fastest block moving by the mean size of a block."""
        speed = float(block_speed(self.model.assembly, motion).max(initial=0.0))
        return motion * (self.statics.mean_length / speed) if speed > 0.0 else motion

    def slides_by_overlap(self, displacement: Floats, times: float) -> bool:
        """Whether a pressed corner slides so many times the largest overlap of its part.

        What stands beside a part and does not touch it says nothing of it. The overlap at a block
        is no larger than that of its part: mostly it is enough already, and soon known.

        Parameters
        ----------
        displacement : (n, 6) [m, rad]
        times
        """
        statics = self.statics
        moved = statics.displacement(statics.scaled_motion(displacement, statics.mean_length))
        pressed = moved[:, 0] < 0.0
        a, b = statics.block_a, statics.block_b
        block, overlap = np.maximum(a, b)[pressed], -moved[pressed, 0]
        slide = lengths(moved[pressed, 1:])

        def within(group: Ints) -> bool:
            most = np.zeros(statics.free_count)
            np.maximum.at(most, group, overlap)
            return bool((slide <= times * most[group]).all())

        if within(block):
            return False
        touch = (a >= 0) & (b >= 0)
        return not within(linked(a[touch], b[touch], statics.free_count)[block])

    def ground_share(self, ground: Floats) -> Floats:
        """Share (n free,) of each block's load that the ground springs (n free, 6) carry."""
        load = self.statics.load
        size = np.linalg.norm(load[:, :3], axis=1) + np.linalg.norm(load[:, 3:], axis=1)
        carried = np.linalg.norm(ground[:, :3], axis=1) + np.linalg.norm(ground[:, 3:], axis=1)
        return carried / np.where(size > 0.0, size, 1.0)
