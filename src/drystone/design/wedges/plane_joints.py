"""The plane joints of a structure, and the structure with some of them made wedges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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

        Parameters
        ----------
        sharpness : (j,) [degrees]
            Zero where the joint stays plane.

        Raises
        ------
        InputError
            A wedge would swallow a face or cut a block in two.
        """
        model = self.model
        for k in np.flatnonzero(sharpness > 0.0).tolist():
            model = self.cut(model, k, float(sharpness[k]))
        return model

    def plane_again(self, wedged: Model, sharpness: Floats, joint: int) -> Model:
        """A model with wedges of some sharpness (j,), with one joint plane again.

        Only the two blocks of the joint are made anew, with the wedges in their other joints.
        """
        contacts = self.model.contacts
        pair = [int(contacts.block_a[joint]), int(contacts.block_b[joint])]
        own = np.isin(contacts.block_a, pair) | np.isin(contacts.block_b, pair)
        around = np.union1d(contacts.block_a[own], contacts.block_b[own]).tolist()
        part = self.model.subset(around)
        slot = {block: i for i, block in enumerate(around)}
        for k in np.flatnonzero(own & (sharpness > 0.0)).tolist():
            if k != joint:
                ends = slot[int(contacts.block_a[k])], slot[int(contacts.block_b[k])]
                part = _cut(part, *ends, contacts.centroid[k], float(sharpness[k]))
        return changed(wedged, {i: part.assembly.blocks[slot[i]] for i in pair})

    def cut(self, model: Model, joint: int, sharpness: float) -> Model:
        """A model in which the joint is plane still, with a wedge there [degrees]."""
        if sharpness <= 0.0:
            return model
        contacts = self.model.contacts
        a, b = int(contacts.block_a[joint]), int(contacts.block_b[joint])
        return _cut(model, a, b, contacts.centroid[joint], sharpness)

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


def _cut(model: Model, a: int, b: int, centre: Floats, sharpness: float) -> Model:
    """The model with a wedge in the joint of two blocks whose middle is nearest to a point."""
    return wedge_joint(model, interface_near(model, a, b, centre), sharpness, first=a)


__all__ = ["PlaneJoints"]
