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
from drystone.design.changed_model import changed
from drystone.design.joint_changes import interface_near
from drystone.design.joint_cut import JointCut, one_body
from drystone.design.joint_plane import block_with, body_of, joint_plane, snapped
from drystone.design.joint_surgery import wedge_cells, wedge_words
from drystone.geometry.body.split import Piece
from drystone.model import Model
from drystone.stability.problem import Problem
from drystone.stability.programs.penalty import glued_state

_SHARED = 1e-9
"""The sum of the volumes of the blocks changes by less than this share: rounding."""

_REMEMBERED = 512
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
            blocks[i] = self._made(i, tuple((k, float(sharpness[k])) for k in own.tolist()))
        before, after = (
            float(assembly.volume[touched].sum()),
            sum(block.volume for block in blocks.values()),
        )
        if abs(after - before) > _SHARED * before:
            raise InputError(
                "two wedges would take the same part of a block", remedy="make them less sharp"
            )
        return changed(self.model, blocks)

    @cached_property
    def _made(self) -> Callable[[int, tuple[tuple[int, float], ...]], Block]:
        """A block with wedges in some of its joints."""
        blocks, contacts = self.model.assembly.blocks, self.model.contacts

        @lru_cache(maxsize=_REMEMBERED)
        def made(i: int, wedges: tuple[tuple[int, float], ...]) -> Block:
            pieces = [self._body(i)]
            for k, sharpness in wedges:
                cut = self._exchange(k, sharpness)[0]
                pieces = (cut.from_a if contacts.block_a[k] == i else cut.from_b)(pieces)[1]
            for k, sharpness in wedges:
                _, given, taken = self._exchange(k, sharpness)
                pieces += given if contacts.block_a[k] == i else taken
            return block_with(blocks[i], one_body(pieces, "the wedges", blocks[i].name))

        return made

    @cached_property
    def _exchange(self) -> Callable[[int, float], tuple[JointCut, list[Piece], list[Piece]]]:
        """The cut of one joint, and what block a and block b take at it from each other."""

        @lru_cache(maxsize=_REMEMBERED)
        def exchange(k: int, sharpness: float) -> tuple[JointCut, list[Piece], list[Piece]]:
            joint = joint_plane(self.model, k)
            one, other = self._body(joint.block_a), self._body(joint.block_b)
            cut = JointCut.of(joint, one, other, *wedge_cells(joint, sharpness))
            given, taken = cut.from_b([other])[0], cut.from_a([one])[0]
            names = [self.model.assembly.names[i] for i in (joint.block_a, joint.block_b)]
            where = f"{wedge_words(sharpness)} of the joint of '{names[0]}' and '{names[1]}'"
            cut.refuse_swallowed(one, other, taken, given, where)
            return cut, given, taken

        return exchange

    @cached_property
    def _body(self) -> Callable[[int], Piece]:
        """The body of a block as it was, its joints exactly plane."""
        contacts = self.model.contacts

        @lru_cache(maxsize=_REMEMBERED)
        def body(i: int) -> Piece:
            found = body_of(self.model.assembly.blocks[i])
            own = self.usable & ((contacts.block_a == i) | (contacts.block_b == i))
            for k in np.flatnonzero(own).tolist():
                found = snapped(found, joint_plane(self.model, k))
            return found

        return body

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
