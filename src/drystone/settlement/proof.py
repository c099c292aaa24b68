"""The forces of a settlement, checked like any proof, on the moved blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from drystone.assembly import Assembly
from drystone.checks import check_forces
from drystone.contacts import Contacts
from drystone.model import Model
from drystone.results import Residuals
from drystone.settlement.springs import rotations

if TYPE_CHECKING:
    from drystone.settlement.settlement_types import SettlementPath

PROVEN = 1e-8
"""Largest residual of a rest, dimensionless: that of every claim of equilibrium."""


def moved_model(path: SettlementPath) -> Model:
    """The blocks where they end, and each corner as an interface of its own."""
    model = path.model
    assembly, contacts = model.assembly, model.contacts
    motion = path.displacement
    turn = rotations(motion[:, 3:])
    moved = assembly.centroid + motion[:, :3]
    blocks = [
        block.transformed(turn[i], moved[i] - turn[i] @ assembly.centroid[i])
        if motion[i].any()
        else block
        for i, block in enumerate(assembly.blocks)
    ]
    joint = contacts.interface
    corners = Contacts(
        contacts.block_a[joint],
        contacts.block_b[joint],
        path.axes,
        contacts.tributary,
        contacts.friction[joint],
        path.point,
        np.arange(len(joint)),
    )
    return Model(Assembly(tuple(blocks), assembly.fixed), corners, model.load)


def rest_residuals(path: SettlementPath) -> Residuals:
    """Equilibrium, pull and friction of the forces at the end, from points and cross products."""
    found = check_forces(moved_model(path), path.force)
    # a force where the faces do not overlap
    open_ = (path.gap > 0.0) & (np.abs(path.force).max(axis=1, initial=0.0) > 0.0)
    apart = float(np.linalg.norm(path.force[open_], axis=1).max(initial=0.0))
    weight = float(np.linalg.norm(path.model.load.wrench[:, :3], axis=1).max(initial=0.0))
    return Residuals(
        found.equilibrium, found.tension, found.cone, apart / weight if weight else 0.0
    )


__all__ = ["PROVEN", "moved_model", "rest_residuals"]
