"""The plane joints of a structure, and the structure with some of them made wedges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.joint_cut import recut
from drystone.design.joint_plane import JointPlane, joint_plane
from drystone.design.joint_surgery import wedge_cut
from drystone.model import Model
from drystone.programs.penalty import glued_state
from drystone.stability.problem import Problem


@dataclass(frozen=True, eq=False)
class PlaneJoints(OneLine):
    """The joints of a structure as they were, each of which may be made a wedge.

    Attributes
    ----------
    model
        With plane joints.
    usable : (j,)
        Joints that have an area, are convex, and belong to blocks that may be changed.
    planes
        Of these joints, by their numbers.
    """

    model: Model
    usable: Bools
    planes: Mapping[int, JointPlane]

    @classmethod
    def of(cls, model: Model, keep: frozenset[int] = frozenset()) -> PlaneJoints:
        """The joints of a model; those of the blocks to keep stay plane."""
        contacts = model.contacts
        usable = model.active.copy()
        planes: dict[int, JointPlane] = {}
        for k in np.flatnonzero(usable).tolist():
            if {int(contacts.block_a[k]), int(contacts.block_b[k])} & keep:
                usable[k] = False
                continue
            try:
                planes[k] = joint_plane(model, k)
            except InputError:
                usable[k] = False
        return cls(model, usable, planes)

    def wedged(self, sharpness: Floats) -> Model:
        """The model with wedges in its joints.

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
        sharp = np.flatnonzero(sharpness > 0.0).tolist()
        if not sharp:
            return self.model
        return recut(self.model, [wedge_cut(self.planes[k], float(sharpness[k])) for k in sharp])

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
            near = _interface_near(self.model, a, b, contacts.centroid[i])
            if near is not None:  # else two blocks touch that did not touch before
                tension[near] += whole[i]
        return tension


def _interface_near(model: Model, one: int, other: int, centre: Floats) -> int | None:
    """The interface between two blocks whose middle is nearest to a point (3,) [m]."""
    contacts = model.contacts
    ends = np.sort(np.stack([contacts.block_a, contacts.block_b], axis=1), axis=1)
    some = np.flatnonzero((ends == sorted((one, other))).all(axis=1))
    if not len(some):
        return None
    away = np.linalg.norm(contacts.centroid[some] - centre, axis=1)
    return int(some[int(np.argmin(away))])
