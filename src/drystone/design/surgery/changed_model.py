"""A model with changed blocks, and its updated contacts, friction and loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Bools, Floats, Ints, cross
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.detection import find_contacts
from drystone.joint_capacity import JointCapacity
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.results import Result


def joined_contacts(one: Contacts, other: Contacts) -> Contacts:
    """The interfaces of both, those of the first one first."""

    def both(name: str) -> Any:
        return np.concatenate([getattr(one, name), getattr(other, name)])

    return Contacts(
        both("block_a"),
        both("block_b"),
        both("frame"),
        both("area"),
        both("friction"),
        both("point"),
        np.concatenate([one.interface, other.interface + one.count]),
        _joined_capacity(one, other),
    )


def _joined_capacity(one: Contacts, other: Contacts) -> JointCapacity | None:
    if one.capacity is None and other.capacity is None:
        return None
    parts = [
        c.capacity or JointCapacity(np.zeros(c.count), np.zeros(c.count)) for c in (one, other)
    ]
    tension, cohesion, shear = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("tension", "cohesion", "shear")
    )
    return JointCapacity(tension, cohesion, shear)


def changed(
    model: Model,
    blocks: Mapping[int, Block] | None = None,
    *,
    added: Sequence[Block] = (),
    fixed: Sequence[bool] = (),
    removed: Sequence[int] = (),
    contacts: Contacts | None = None,
) -> Model:
    """The model with other blocks in some places, more blocks at the end, or fewer.

    Interfaces between unchanged blocks are kept. All others are searched again. They have the
    friction of the same two blocks before, else the median of the model.

    Parameters
    ----------
    model
    blocks
        New blocks by position.
    added
    fixed
        Whether each added block is fixed.
    removed
        Positions of blocks that are left out.
    contacts
        Interfaces of the changed and added blocks, numbered as in the new model, if known; searched
        when left out.
    """
    blocks = dict(blocks or {})
    before = len(model)
    kept = np.setdiff1d(np.arange(before), np.asarray(removed, dtype=np.intp))
    assembly = Assembly(
        (*(blocks.get(i, model.assembly.blocks[i]) for i in kept.tolist()), *added),
        np.concatenate([model.assembly.fixed[kept], np.asarray(fixed, dtype=bool)]),
    )
    new = np.full(before, -1, dtype=np.intp)
    new[kept] = np.arange(len(kept))
    touched = np.zeros(len(assembly), dtype=bool)
    touched[new[[i for i in blocks if new[i] >= 0]]] = True
    touched[len(kept) :] = True
    old = model.contacts
    a, b = new[old.block_a], new[old.block_b]
    stays = (a >= 0) & (b >= 0) & ~touched[a] & ~touched[b]
    unchanged = old.select(stays, new)
    if contacts is None:
        contacts = _found(model, assembly, touched, new)
    return Model(
        assembly,
        joined_contacts(unchanged, contacts),
        carried_load(model, assembly, kept),
        notes=model.notes,
    )


def _found(model: Model, assembly: Assembly, touched: Bools, new: Ints) -> Contacts:
    """The interfaces of blocks that changed, found among them and those near them."""
    if not touched.any():
        return Contacts.empty()
    margin = 0.01 * assembly.size.max()
    low, high = assembly.bounds[:, 0] - margin, assembly.bounds[:, 1] + margin
    near = touched.copy()
    for i in np.flatnonzero(touched):
        near |= (low <= high[i]).all(axis=1) & (low[i] <= high).all(axis=1)
    chosen = np.flatnonzero(near)
    found = find_contacts(assembly.subset(chosen.tolist())).contacts
    a, b = chosen[found.block_a], chosen[found.block_b]
    mine = touched[a] | touched[b]
    back = np.full(len(chosen), -1, dtype=np.intp)
    back[:] = chosen
    part = found.select(mine, back)
    return part.with_friction(_friction(model, part, new))


def _friction(model: Model, part: Contacts, new: Ints) -> Floats:
    """Friction of interfaces: that of the same two blocks before, else the median."""
    usual = usual_friction(model)
    before: dict[tuple[int, int], float] = {}
    for i in range(model.contacts.count):
        pair = sorted((int(new[model.contacts.block_a[i]]), int(new[model.contacts.block_b[i]])))
        value = float(model.contacts.friction[i])
        before[pair[0], pair[1]] = min(value, before.get((pair[0], pair[1]), np.inf))
    return np.array(
        [
            before.get((min(a, b), max(a, b)), usual)
            for a, b in zip(part.block_a.tolist(), part.block_b.tolist(), strict=True)
        ],
        dtype=np.float64,
    )


def usual_friction(model: Model) -> float:
    """The median friction coefficient of the joints of a model."""
    friction = model.contacts.friction
    return float(np.median(friction)) if len(friction) else 0.6


def carried_load(model: Model, assembly: Assembly, kept: Ints) -> LoadCase:
    """The load of a model on its changed blocks; loads other than weight keep their position.

    New volume has the acceleration of most blocks.

    Parameters
    ----------
    model
    assembly
        The changed blocks: first the kept ones, in their order, then new ones.
    kept : (s,)
        Positions of the kept blocks in the model.
    """
    if model.load.motion is not None:
        raise InputError(
            f"the load case '{model.load.name}' moves supports",
            remedy="leave the motion out: only 'settle' uses it",
        )
    acceleration = acceleration_of(model)
    before = model.assembly
    wrench = np.zeros((len(assembly), 6))
    wrench[:, :3] = assembly.mass[:, None] * acceleration
    extra = model.load.wrench[kept, :3] - before.mass[kept, None] * acceleration
    shift = before.centroid[kept] - assembly.centroid[: len(kept)]
    wrench[: len(kept), :3] += extra
    wrench[: len(kept), 3:] = model.load.wrench[kept, 3:] + cross(shift, extra)
    return replace(model.load, wrench=wrench)


def acceleration_of(model: Model) -> Floats:
    """The acceleration (3,) [m/s2] of most blocks of a model.

    Blocks whose load has a moment about the centroid carry more than their weight. They are ignored
    unless all blocks have one.
    """
    wrench, mass = model.load.wrench, model.assembly.mass
    arm = np.linalg.norm(wrench[:, 3:], axis=1) / model.assembly.size
    plain = arm <= 1e-9 * np.linalg.norm(wrench[:, :3], axis=1)
    chosen = plain if plain.any() else np.ones(len(model), dtype=bool)
    acceleration: Floats = np.median(wrench[chosen, :3] / mass[chosen, None], axis=0)
    return acceleration


def fresh_name(model: Model, stem: str, others: Sequence[str] = ()) -> str:
    """An unused name: the stem and a number."""
    number = 1
    while f"{stem}-{number}" in model.assembly or f"{stem}-{number}" in others:
        number += 1
    return f"{stem}-{number}"


@dataclass(frozen=True, eq=False)
class ChangedStructure(OneLine):
    """A structure that was changed in rounds so that it stands.

    Attributes
    ----------
    before, model
        The structure without the change, and with it.
    result
        The check of ``model``, or that of the case of the margin in which it falls.
    stands
        Whether it stands at the margin.
    rounds
    message
    """

    before: Model
    model: Model
    result: Result
    stands: bool
    rounds: int
    message: str

    def _summary(self) -> str:
        return self.message

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "stands": self.stands,
            "verdict": self.result.verdict.value,
            "message": self.message,
            "check": self.result.message,
            "rounds": self.rounds,
        }


__all__ = [
    "ChangedStructure",
    "acceleration_of",
    "carried_load",
    "changed",
    "fresh_name",
    "joined_contacts",
    "usual_friction",
]
