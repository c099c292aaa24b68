"""A model with changed blocks, and its updated contacts, friction and loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Bools, Floats, Ints, marked, places
from drystone.base.errors import InputError
from drystone.contacts import Contacts, joined_contacts
from drystone.detection import find_contacts, find_overlaps
from drystone.joint_capacity import DRY, NO_LIMIT, JointCapacity
from drystone.loads import LoadCase
from drystone.loads.placing import filled, moved_points, moved_wrench
from drystone.model import Model


def changed(
    model: Model,
    blocks: Mapping[int, Block] | None = None,
    *,
    added: Sequence[Block] = (),
    fixed: Sequence[bool] = (),
    removed: Sequence[int] = (),
    parts_of: int = -1,
    heirs: Mapping[int, int] | None = None,
    contacts: Contacts | None = None,
) -> Model:
    """The model with other blocks in some places, more blocks at the end, or fewer.

    Interfaces between unchanged blocks are kept. All others are searched again. They have the
    friction and the capacity of the same two blocks before, less capacity where their area is less;
    those of two blocks that did not touch have the median friction and crushing stress of the model
    and are dry.

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
    parts_of
        All added blocks are parts of this one and have its joints; -1 where they are new.
    heirs
        The blocks that take over the joints of blocks that are left out.
    contacts
        Interfaces of the changed and added blocks, numbered as in the new model, if known; searched
        when left out.

    Raises
    ------
    InputError
        A joint with a capacity is no longer there, a block with a tie would change, or two blocks
        would overlap.
    """
    model.require_still()
    blocks = dict(blocks or {})
    before = len(model)
    kept = np.setdiff1d(np.arange(before), np.asarray(removed, dtype=np.intp))
    assembly = Assembly(
        (*(blocks.get(i, model.assembly.blocks[i]) for i in kept.tolist()), *added),
        np.concatenate([model.assembly.fixed[kept], np.asarray(fixed, dtype=bool)]),
    )
    new = places(kept, before)
    touched = marked(new[[i for i in blocks if new[i] >= 0]], len(assembly))
    touched[len(kept) :] = True
    old = model.contacts
    a, b = new[old.block_a], new[old.block_b]
    stays = (a >= 0) & (b >= 0) & ~touched[a] & ~touched[b]
    unchanged = old.select(stays, new)
    if contacts is None:
        _refuse_ties(model, ~stays)
        origin = np.arange(before)
        for left, heir in (heirs or {}).items():
            origin[left] = heir
        after = np.concatenate([origin[kept], np.full(len(added), parts_of, dtype=np.intp)])
        origin[np.setdiff1d(np.asarray(removed, dtype=np.intp), list(heirs or {}))] = -1
        found = _found(model, assembly, touched, after)
        contacts = _as_before(model, found, origin, after, ~stays)
    return Model(
        assembly,
        joined_contacts(unchanged, contacts),
        carried_load(model, assembly, kept),
        notes=model.notes,
        ends=model.ends,
    )


def _found(model: Model, assembly: Assembly, touched: Bools, after: Ints) -> Contacts:
    """The interfaces of blocks that changed, found among them and those near them.

    ``after`` are the blocks (n,) of the model that they were; -1 where they are new.

    Raises
    ------
    InputError
        Two of them overlap, and did not before.
    """
    if not touched.any():
        return Contacts.empty()
    margin = 0.01 * assembly.size.max()
    low, high = assembly.bounds[:, 0] - margin, assembly.bounds[:, 1] + margin
    near = touched.copy()
    for i in np.flatnonzero(touched):
        near |= (low <= high[i]).all(axis=1) & (low[i] <= high).all(axis=1)
    chosen = np.flatnonzero(near)
    detected = find_contacts(assembly.subset(chosen.tolist()))
    for one in detected.report.overlaps:
        pair = [int(chosen[i]) for i in (one.block_a, one.block_b)]
        were = after[pair]
        if not touched[pair].any() or (
            were.min() >= 0 and find_overlaps(model.assembly.subset(sorted(set(were.tolist()))))
        ):
            continue
        names = [assembly.names[i] for i in pair]
        raise InputError(
            f"would overlap by {1e3 * one.depth:.3g} mm",
            where=f"the blocks '{names[0]}' and '{names[1]}'",
            remedy="make the change smaller",
        )
    found = detected.contacts
    a, b = chosen[found.block_a], chosen[found.block_b]
    mine = touched[a] | touched[b]
    return found.select(mine, chosen)


def _as_before(model: Model, part: Contacts, before: Ints, after: Ints, gone: Bools) -> Contacts:
    """New interfaces with the friction and the capacity of the joints in whose place they are.

    A joint has one key before and after: the origins of its two blocks. Its friction is the least
    one before. Its strength is spread over its area, and less where the area is less. ``gone`` are
    the interfaces (m,) of the model that were not kept.

    Raises
    ------
    InputError
        A joint that carries a pull or cohesion is no longer there.
    """
    old = model.contacts
    keys = _keys(before, old.block_a, old.block_b), _keys(after, part.block_a, part.block_b)
    each, group = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    was, now = np.split(group.reshape(-1), [old.count])

    def total(values: Floats, of: Ints) -> Floats:
        return np.bincount(of, values, minlength=len(each)).astype(np.float64)

    known = (each.min(axis=1) >= 0) & (each[:, 0] != each[:, 1]) & marked(was, len(each))
    least = np.full(len(each), np.inf)
    np.minimum.at(least, was, old.friction)
    friction = np.where(known, least, usual_friction(model))[now]
    area, left = total(old.area, was), total(part.area, now)
    weight = np.where(left[now] > 0.0, part.area, 1.0)
    less = np.divide(left, area, out=np.ones(len(each)), where=area > left)
    share = (weight / total(weight, now)[now]) * less[now]
    capacity, strength = old.capacity or JointCapacity.of(old), {}
    for name, dry in DRY.items():
        whole = total(np.asarray(getattr(capacity, name)), was)[now]
        spread = np.where(whole < NO_LIMIT, whole * share, NO_LIMIT)
        new = _usual_strength(old, capacity, part.area) if name == "compression" else dry
        strength[name] = np.where(known[now], spread, new)
    _refuse_lost(model, capacity, gone, *keys)
    part = part.with_friction(friction)
    return part if old.capacity is None else part.with_capacity(capacity.with_values(strength))


def _refuse_lost(
    model: Model, capacity: JointCapacity, gone: Bools, before: Ints, after: Ints
) -> None:
    """Refuse a change with which a joint with strength disappears."""
    there = set(map(tuple, after.tolist()))
    for k in np.flatnonzero(gone & ((capacity.tension > 0.0) | (capacity.cohesion > 0.0))):
        key = tuple(before[k].tolist())
        if min(key) >= 0 and key[0] != key[1] and key not in there:
            names = [model.assembly.names[i] for i in key]
            raise InputError(
                "carries a pull or cohesion, and would no longer be there",
                where=f"the joint of '{names[0]}' and '{names[1]}'",
                remedy="change another joint, or take its capacity away first",
            )


def _refuse_ties(model: Model, gone: Bools) -> None:
    """Refuse to change a block with a tie."""
    contacts = model.contacts
    for k in np.flatnonzero(gone & contacts.ties).tolist():
        names = [model.assembly.names[i] for i in (contacts.block_b[k], contacts.block_a[k])]
        raise InputError(
            "have a tie between them, which would be lost",
            where=f"the blocks '{names[0]}' and '{names[1]}'",
            remedy="change other blocks, or add the tie afterwards",
        )


def _keys(origin: Ints, block_a: Ints, block_b: Ints) -> Ints:
    """Origins (m, 2) of the blocks of interfaces, the lower one first."""
    return np.sort(np.stack([origin[block_a], origin[block_b]], axis=1), axis=1)


def usual_friction(model: Model) -> float:
    """The median friction coefficient of the joints of a model."""
    friction = model.contacts.friction
    return float(np.median(friction)) if len(friction) else 0.6


def _usual_strength(old: Contacts, capacity: JointCapacity, area: Floats) -> Floats:
    """What new areas [m2] bear [N] with the median stress under which the joints that do crush."""
    weak = old.crushes & ~old.ties & (old.area > 0.0)
    stress = capacity.compression[weak] / old.area[weak]
    return float(np.median(stress)) * area if len(stress) else np.full(len(area), NO_LIMIT)


def carried_load(model: Model, assembly: Assembly, kept: Ints) -> LoadCase:
    """The load of a model on its changed blocks; loads other than weight keep their position.

    Supports keep the motion of their centroid. New volume has the acceleration of most blocks.

    Parameters
    ----------
    model
    assembly
        The changed blocks: first the kept ones, in their order, then new ones.
    kept : (s,)
        Positions of the kept blocks in the model.
    """
    acceleration = acceleration_of(model)
    before = model.assembly
    extra = model.load.wrench[kept].copy()
    extra[:, :3] -= before.mass[kept, None] * acceleration
    shift = before.centroid[kept] - assembly.centroid[: len(kept)]
    wrench = filled(moved_wrench(extra, shift), len(assembly))
    wrench[:, :3] += assembly.mass[:, None] * acceleration
    masses = tuple(one.of_blocks(kept, len(assembly), shift) for one in model.load.masses)
    load = model.load.of_blocks(kept, len(assembly))
    away, surface = filled(shift, len(assembly)), load.surface
    given = None if load.given is None else moved_points(load.given, away)
    if surface is not None:
        surface = replace(surface, wrench=moved_wrench(surface.wrench, away))
    each = tuple(one.of_blocks(kept, len(before), shift) for one in model.load.each)
    return replace(load, wrench=wrench, masses=masses, given=given, surface=surface, each=each)


def acceleration_of(model: Model) -> Floats:
    """The acceleration (3,) [m/s2] of all masses; where the load does not know it, of most blocks.

    Blocks whose load has a moment about the centroid carry more than their weight. They are then
    ignored, unless all blocks have one.
    """
    if model.load.acceleration.any():
        return model.load.acceleration
    wrench, mass = model.load.wrench, model.assembly.mass
    arm = np.linalg.norm(wrench[:, 3:], axis=1) / model.assembly.size
    plain = arm <= 1e-9 * np.linalg.norm(wrench[:, :3], axis=1)
    chosen = plain if plain.any() else np.ones(len(model), dtype=bool)
    return np.median(wrench[chosen, :3] / mass[chosen, None], axis=0)


def fresh_name(model: Model, stem: str, others: Sequence[str] = ()) -> str:
    """An unused name: the stem and a number."""
    number = 1
    while f"{stem}-{number}" in model.assembly or f"{stem}-{number}" in others:
        number += 1
    return f"{stem}-{number}"
