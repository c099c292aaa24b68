"""Struts, ropes, clamps and centring as joints of a stage, each with its one-sidedness.

Every point at which an item acts on a block is an interface with an added fixed block:

- a strut pushes along its axis, from its foot to its head, and never pulls;
- a rope pulls towards its anchor and never pushes (Deuss and others 2014);
- centring carries the free lower face of a block: it pushes and rubs, and never pulls;
- a clamp, or a hand, pushes and pulls with a limited force and a limited moment.

A strut and a rope have one joint without friction whose normal is the direction of the force.
Limits of struts, ropes and centring are compared with the forces of the state that was found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.geometry.frames import frames_from_normals
from drystone.joint_capacity import NO_LIMIT, JointCapacity
from drystone.model import Model
from drystone.results import Result
from drystone.sequence.scaffold_kinds import Centring, Clamp, Rope, ScaffoldItem, Strut

TOUCHING = 0.01
"""Distance of an end from its block, by the size of the block, that is still taken as touching."""
THICK = 0.02
"""Width of the body that stands for a strut, a rope or a clamp, by the size of its block: it is
there to be seen and carries nothing by it."""


@dataclass(frozen=True, eq=False)
class ScaffoldedModel(OneLine):
    """A model with items.

    Attributes
    ----------
    model
        With a fixed block for each item behind its blocks.
    items
    owner : (m,)
        Item of each interface, -1 for those of the model.
    """

    model: Model
    items: tuple[ScaffoldItem, ...]
    owner: Ints

    def force(self, result: Result) -> Floats:
        """(i,) [N] that each item supplies in a state, the length of its resultant."""
        total = np.zeros((len(self.items), 3))
        mine = self.owner >= 0
        np.add.at(total, self.owner[mine], result.resultants.force[mine])
        return np.linalg.norm(total, axis=1)

    def moment(self, result: Result) -> Floats:
        """(i,) [N m] that each item supplies about the centroid of its block."""
        total = np.zeros((len(self.items), 3))
        contacts, assembly = self.model.contacts, self.model.assembly
        found = result.resultants
        for k in np.flatnonzero(self.owner >= 0).tolist():
            arm = found.position[k] - assembly.centroid[contacts.block_b[k]]
            twist = found.torque[k] * contacts.frame[k, 0]
            total[self.owner[k]] += np.cross(arm, found.force[k]) + twist
        return np.linalg.norm(total, axis=1)

    def overloaded(self, result: Result) -> tuple[int, ...]:
        """Items whose limits are exceeded in a state."""
        force, moment = self.force(result), self.moment(result)
        out = []
        for i, item in enumerate(self.items):
            turned = isinstance(item, Clamp) and moment[i] > item.moment
            if force[i] > item.limit or turned:
                out.append(i)
        return tuple(out)


def with_scaffold(model: Model, items: Sequence[ScaffoldItem]) -> ScaffoldedModel:
    """A model whose blocks are held by items.

    A check of the model does not use the limits of struts, ropes and centring:
    :meth:`ScaffoldedModel.overloaded` tells which items exceed their limits in its result.

    Parameters
    ----------
    model
    items

    Raises
    ------
    InputError
        A block is not known, an item has no length, or it does not touch its block.
    """
    before, bodies = len(model), []
    joints: list[tuple[int, int, Floats, Floats, float, float]] = []
    owner: list[int] = []
    pull: dict[int, float] = {}
    for k, item in enumerate(items):
        if not isinstance(item, ScaffoldItem):
            raise InputError(f"{item!r} is no strut, rope, clamp or centring", where=f"item {k}")
        block = int(model.assembly.indices([item.block])[0])
        where = f"item {k} at block '{model.assembly.names[block]}'"
        bearer = before + k
        size = float(model.assembly.size[block])
        centroid = model.assembly.centroid[block]
        first = len(joints)
        ends: tuple[Floats, Floats]
        if isinstance(item, Strut):
            head, foot = np.asarray(item.head), np.asarray(item.foot)
            ends = (foot, head)
            _require_touching(model, block, head, f"{where}: its head")
            under = bearer
            if item.on is not None:
                under = int(model.assembly.indices([item.on])[0])
                _require_touching(model, under, foot, f"{where}: its foot")
            joints.append((under, block, head[None], _axis(head - foot, where), 0.0, 0.0))
        elif isinstance(item, Rope):
            at, anchor = np.asarray(item.at), np.asarray(item.anchor)
            ends = (at, anchor)
            _require_touching(model, block, at, where)
            joints.append((bearer, block, at[None], _axis(anchor - at, where), 0.0, 0.0))
        elif isinstance(item, Centring):
            face = item.face
            turned = face[::-1]  # counter-clockwise about the inward normal
            area = 0.5 * np.cross(turned - turned[0], np.roll(turned, -1, 0) - turned[0]).sum(0)
            inward = _axis(area, where)
            low = face.mean(axis=0)
            ends = (low - 0.1 * size * inward, low)
            joints.append(
                (bearer, block, turned, inward, float(np.linalg.norm(area)), item.friction)
            )
        else:
            ends = (centroid, centroid + np.array([0.0, 0.0, 0.2 * size]))
            reach = 0.25 * size
            ring = reach * np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0]])
            up = np.array([0.0, 0.0, 1.0])
            joints.append((bearer, block, centroid + ring, up, 2.0 * reach**2, 0.0))
            pull[first] = min(item.limit, NO_LIMIT)
        bodies.append(_bar(*ends, THICK * size, f"scaffold-{k:03d}"))
        owner += [k] * (len(joints) - first)
    assembly = Assembly(
        (*model.assembly.blocks, *bodies),
        np.concatenate([model.assembly.fixed, np.ones(len(bodies), dtype=bool)]),
    )
    contacts = _with_joints(model.contacts, joints, pull)
    load = replace(
        model.load, wrench=np.concatenate([model.load.wrench, np.zeros((len(bodies), 6))])
    )
    none = np.full(model.contacts.count, -1, dtype=np.intp)
    return ScaffoldedModel(
        Model(assembly, contacts, load, notes=model.notes),
        tuple(items),
        np.concatenate([none, np.array(owner, dtype=np.intp)]),
    )


def _require_touching(model: Model, block: int, point: Floats, where: str) -> None:
    """Refuse a point that is away from a block, by the box around the block."""
    low, high = model.assembly.bounds[block]
    away = float(np.maximum(np.maximum(low - point, point - high), 0.0).max())
    if away > TOUCHING * float(model.assembly.size[block]):
        raise InputError(
            f"it is {away:.3g} m away from block '{model.assembly.names[block]}'",
            where=where,
            remedy="give a point of its surface",
        )


def _axis(vector: Floats, where: str) -> Floats:
    length = float(np.linalg.norm(vector))
    if not length > 0.0:
        raise InputError("it has no length", where=where, remedy="give two different points")
    return np.asarray(vector / length)


def _bar(one: Floats, other: Floats, width: float, name: str) -> Block:
    """A square bar between two points."""
    axis = np.asarray(other) - np.asarray(one)
    length = float(np.linalg.norm(axis))
    frame = frames_from_normals((axis / length)[None])[0]
    flat = 0.5 * width * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    ring = flat @ frame[1:]
    faces = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    return Block(np.concatenate([one + ring, other + ring]), faces, name)


def _with_joints(
    contacts: Contacts,
    joints: Sequence[tuple[int, int, Floats, Floats, float, float]],
    pull: dict[int, float],
) -> Contacts:
    """The interfaces, and others behind them: blocks, corners, normal, area, friction."""
    count = contacts.count
    if not joints:
        return contacts
    normal = np.array([joint[3] for joint in joints])
    capacity = contacts.capacity
    if pull or capacity is not None:
        old = capacity or JointCapacity(np.zeros(count), np.zeros(count))
        some = np.array([pull.get(i, 0.0) for i in range(len(joints))])
        more = JointCapacity(some, some)
        capacity = JointCapacity(
            *(
                np.concatenate([getattr(old, name), getattr(more, name)])
                for name in ("tension", "cohesion", "shear")
            )
        )
    corners = [len(joint[2]) for joint in joints]
    return Contacts(
        np.append(contacts.block_a, [joint[0] for joint in joints]),
        np.append(contacts.block_b, [joint[1] for joint in joints]),
        np.concatenate([contacts.frame, frames_from_normals(normal)]),
        np.append(contacts.area, [joint[4] for joint in joints]),
        np.append(contacts.friction, [joint[5] for joint in joints]),
        np.concatenate([contacts.point, *(joint[2] for joint in joints)]),
        np.append(contacts.interface, np.repeat(count + np.arange(len(joints)), corners)),
        capacity,
    )
