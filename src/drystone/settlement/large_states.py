"""The states of a large displacement in metres and newtons, from a driver's moments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.base.arrays import Bools, Floats, cross, frozen
from drystone.contacts import Contacts
from drystone.mechanics.bodies import Bodies, numbered_axes, numbered_forces
from drystone.mechanics.drive import DrivenState
from drystone.mechanics.meeting import Apart, model_with_met
from drystone.model import Model
from drystone.settlement.large_types import LargeState
from drystone.settlement.path import block_motions


def large_state(
    model: Model,
    apart: Apart,
    bodies: Bodies,
    moment: DrivenState,
    met: Bools,
    length: float,
    load: float,
) -> LargeState:
    """A moment in m and N, for the interfaces of the model and those that blocks have met."""
    shown, mine, kept = model_with_met(model, apart, met)
    return state_of(shown, bodies, moment, mine, kept, length, load)


def state_of(
    model: Model,
    bodies: Bodies,
    moment: DrivenState,
    mine: Bools,
    kept: Bools,
    length: float,
    load: float,
) -> LargeState:
    """A moment in m and N, for all interfaces of the model.

    ``mine`` are the corners of the model that were followed; the moment has them among others, they
    are ``kept``.
    """
    contacts = model.contacts
    origin = model.assembly.centroid[bodies.free].mean(axis=0)
    point = contacts.point.copy()
    point[mine] = moment.placed.point[kept] * bodies.length_unit + origin
    axes = numbered_axes(bodies, moment.placed.axes)[kept]
    local = numbered_forces(bodies, moment.response.force)[kept]
    frame = contacts.frame.copy()
    frame[model.active] = _frames(contacts, model.active, axes, local[:, 0])
    force = np.zeros((contacts.corner_count, 3))
    world = np.einsum("ki,kij->kj", local, axes)
    of_interface = frame[contacts.interface[mine]]
    force[mine] = np.einsum("kij,kj->ki", of_interface, world) * bodies.force_unit
    moved = replace(contacts, point=point, frame=frame)
    return LargeState(
        length * moment.displacement,
        load * moment.load,
        frozen(block_motions(bodies, (moment.pose,))[0]),
        moved,
        frozen(force),
    )


def _frames(contacts: Contacts, active: Bools, axes: Floats, pressure: Floats) -> Floats:
    """(m, 3, 3) of the active interfaces: the mean of their corners, weighted by the pressure."""
    number = np.cumsum(active) - 1
    owner = number[contacts.interface[active[contacts.interface]]]
    total = np.bincount(owner, pressure, minlength=int(active.sum()))
    weight = np.where(total[owner] > 0.0, pressure, 1.0)
    sums = np.zeros((int(active.sum()), 3, 3))
    np.add.at(sums, owner, weight[:, None, None] * axes)
    n = sums[:, 0] / np.linalg.norm(sums[:, 0], axis=1, keepdims=True)
    u = sums[:, 1] - (sums[:, 1] * n).sum(axis=1, keepdims=True) * n
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return np.stack([n, u, cross(n, u)], axis=1)
