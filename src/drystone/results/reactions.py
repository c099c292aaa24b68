"""Reactions: what supports give to the blocks on them."""

from __future__ import annotations

import numpy as np

from drystone.answer.scene import Layer, LayerKind
from drystone.base.arrays import SAME, Floats, dot, lengths
from drystone.base.ragged import sum_by_owner
from drystone.base.table import Table
from drystone.contacts import Contacts
from drystone.joints import Resultants
from drystone.results.solution import Solution


def reaction_table(result: Solution) -> Table:
    """The table of :meth:`drystone.Result.reactions`."""
    contacts, fixed = result.contacts, result.assembly.fixed
    toward = _toward_free(contacts, result)
    corner = np.flatnonzero(toward[contacts.interface])
    interface = contacts.interface[corner]
    side = np.where(fixed[contacts.block_a], contacts.block_a, contacts.block_b)
    support, owner = np.unique(side[interface], return_inverse=True)
    count, place = len(support), contacts.point[corner]
    force = toward[interface, None] * result.world_force()[corner]
    normal = np.maximum(dot(force, toward[interface, None] * contacts.frame[interface, 0]), 0.0)
    weight = np.where((np.bincount(owner, normal, count) > 0.0)[owner], normal, 1.0)
    point = sum_by_owner(weight[:, None] * place, owner, count)
    point /= np.bincount(owner, weight, count)[:, None]
    total = sum_by_owner(force, owner, count)
    moment = sum_by_owner(np.cross(place - point[owner], force), owner, count)
    rounding = SAME * float(result.assembly.size.max()) * lengths(total)
    moment = np.where((lengths(moment) > rounding)[:, None], moment, 0.0)
    columns = {
        "support": [result.assembly.names[i] for i in support],
        "point": point,
        "force": total,
        "moment": moment,
    }
    return Table("reactions", columns, {"point": "m", "force": "N", "moment": "N m"})


def reaction_layer(result: Solution, resultants: Resultants) -> tuple[Layer, ...]:
    """An arrow at each joint of a support with a free block, which ends at its centre of pressure.

    Parameters
    ----------
    result
    resultants
        Of the joints.
    """
    contacts = result.contacts
    first = np.unique(contacts.joint, return_index=True)[1]
    toward = _toward_free(contacts.joints, result)
    held = np.flatnonzero((toward != 0.0) & resultants.force.any(axis=1))
    if len(held) == 0:
        return ()
    return (
        Layer(
            "reactions", "reactions at joints of supports", LayerKind.ARROWS, "reaction",
            resultants.position[held], toward[held, None] * resultants.force[held],
            interface=first[held], single=True, width=2.4, group="reactions",
        ),
    )  # fmt: skip


def _toward_free(contacts: Contacts, result: Solution) -> Floats:
    """Signs (m,) by which forces on block b become forces on the free block; else zero."""
    fixed = result.assembly.fixed.astype(np.float64)
    toward: Floats = fixed[contacts.block_a] - fixed[contacts.block_b]
    return toward
