"""Check of the forces of a settlement on the moved blocks."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats
from drystone.checks import check_forces
from drystone.contacts import Contacts
from drystone.model import Model
from drystone.results import Residuals

PROVEN = 1e-8
"""Largest residual of a rest state, dimensionless: that of every equilibrium."""


def moved_model(model: Model, motion: Floats, axes: Floats, point: Floats) -> Model:
    """The blocks at the end, with each corner as a separate interface.

    Parameters
    ----------
    model
        Before the motion.
    motion : (n, 6) [m, rad]
    axes : (k, 3, 3), rows n, u, v
    point : (k, 3) [m]
        Where the force of each corner acts.
    """
    assembly, contacts = model.assembly, model.contacts
    joint = contacts.interface
    corners = Contacts(
        contacts.block_a[joint],
        contacts.block_b[joint],
        axes,
        contacts.tributary,
        contacts.friction[joint],
        point,
        np.arange(len(joint)),
    )
    return Model(assembly.moved(motion), corners, model.load)


def rest_residuals(moved: Model, force: Floats, gap: Floats) -> Residuals:
    """Equilibrium, tension and friction of the forces at the end, from points and cross products.

    Parameters
    ----------
    moved
        What :func:`moved_model` gives.
    force : (k, 3) [N]
    gap : (k,) [m]
        Between the faces; a force where it is positive is a fault.
    """
    found = check_forces(moved, force)
    open_ = (gap > 0.0) & (np.abs(force).max(axis=1, initial=0.0) > 0.0)
    apart = float(np.linalg.norm(force[open_], axis=1).max(initial=0.0))
    weight = float(np.linalg.norm(moved.load.wrench[:, :3], axis=1).max(initial=0.0))
    return Residuals(
        found.equilibrium, found.tension, found.cone, apart / weight if weight else 0.0
    )
