"""The plane joints of a structure, and the structure with some of them made wedges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from drystone.assembly import Block
from drystone.base.arrays import Bools, Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.surgery.changed_model import changed
from drystone.design.surgery.joint_changes import interface_near
from drystone.design.surgery.joint_cut import joint_plane
from drystone.design.surgery.joint_surgery import wedge_joint
from drystone.model import Model
from drystone.stability.problem import Problem
from drystone.stability.programs.penalty import glued_state

SHARED = 1e-9
"""The sum of the volumes of the blocks changes by less than this share: rounding."""

REMEMBERED = 512
"""Blocks with wedges that are kept for the next model, chosen: some for every joint of an arch."""


@dataclass(frozen=True, eq=False)
class PlaneJoints(OneLine):
    """The joints of a structure as they were, each of which may be made a wedge.

    Attributes
    ----------
    model
        With plane joints.
    usable : (j,)
        Joints that have an area, are convex, and belong to blocks that may be changed.
    """

    model: Model
    usable: Bools

    @classmethod
    def of(cls, model: Model, keep: frozenset[int] = frozenset()) -> PlaneJoints:
        """The joints of a model; those of the blocks to keep stay plane."""
        contacts = model.contacts
        usable = model.active.copy()
        for k in np.flatnonzero(usable).tolist():
            if {int(contacts.block_a[k]), int(contacts.block_b[k])} & keep:
                usable[k] = False
                continue
            try:
                joint_plane(model, k)
            except InputError:
                usable[k] = False
        return cls(model, usable)

    def wedged(self, sharpness: Floats) -> Model:
        """The model with wedges in its joints.

        Each block is made of its plane form and the sharpness of its own joints alone. So the
        same sharpness always gives the same model, and a change of one joint makes two blocks anew.

        Parameters
        ----------
        sharpness : (j,) [degrees]
            Zero where the joint stays plane.

        Raises
        ------
        InputError
            A wedge would remove a face or cut a block in two, or two wedges would take the same
            part of a block.
        """
        contacts, assembly = self.model.contacts, self.model.assembly
        sharp = sharpness > 0.0
        if not sharp.any():
            return self.model
        touched = np.union1d(contacts.block_a[sharp], contacts.block_b[sharp])
        blocks: dict[int, Block] = {}
        for i in touched.tolist():
            own = np.flatnonzero(sharp & ((contacts.block_a == i) | (contacts.block_b == i)))
            wedges = tuple((k, float(sharpness[k])) for k in own.tolist())
            blocks[i] = self._part_of(i, wedges).assembly.blocks[0]
        before, after = (
            float(assembly.volume[touched].sum()),
            sum(block.volume for block in blocks.values()),
        )
        if abs(after - before) > SHARED * before:
            raise InputError(
                "two wedges would take the same part of a block", remedy="make them less sharp"
            )
        return changed(self.model, blocks)

    @cached_property
    def _part_of(self) -> Callable[[int, tuple[tuple[int, float], ...]], Model]:
        """A block, the first one, and its neighbours, with wedges in some of its joints."""
        contacts = self.model.contacts

        @lru_cache(maxsize=REMEMBERED)
        def part_of(block: int, wedges: tuple[tuple[int, float], ...]) -> Model:
            own = (contacts.block_a == block) | (contacts.block_b == block)
            around = np.union1d(contacts.block_a[own], contacts.block_b[own])
            order = [block, *around[around != block].tolist()]
            if not wedges:
                return self.model.subset(order)
            k, sharpness = wedges[-1]
            a, b = order.index(contacts.block_a[k]), order.index(contacts.block_b[k])
            part = part_of(block, wedges[:-1])
            near = interface_near(part, a, b, contacts.centroid[k])
            return wedge_joint(part, near, sharpness, first=a)

        return part_of

    def tension(self, model: Model) -> Floats:
        """Tension (j,) [N] of each joint if all joints of a model with wedges were weakly glued.

        Glue is the penalty form of Kao et al. 2022, eq. 5.8, with friction still bounded by what
        presses; see :func:`drystone.solve_cra_penalty`.
        """
        problem = Problem.build(model)
        pull = problem.force(glued_state(problem).tension[:, None])[:, 0]
        contacts, before = model.contacts, self.model.contacts
        whole = np.bincount(contacts.interface, pull, minlength=contacts.count)
        tension = np.zeros(before.count)
        for i in np.flatnonzero(whole > 0.0).tolist():
            a, b = int(contacts.block_a[i]), int(contacts.block_b[i])
            try:
                tension[interface_near(self.model, a, b, contacts.centroid[i])] += whole[i]
            except InputError:  # two blocks touch that did not touch before
                continue
        return tension


__all__ = ["PlaneJoints"]
