"""Could any forces balance the loads? Asked again in lines that share no matrix with drystone.

Virtual velocities are sought along which the loads work and against which no contact force can:
where there are any, no forces balance the loads (Farkas). The linear program replaces the cone of
friction by a pyramid of 16 sides around it; what it finds is then held against the cone itself.
Turns are multiplied and moments divided by the size of the block.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, csr_array, vstack

from drystone.base.arrays import Floats
from drystone.model import Model
from drystone.results import Result
from drystone.settlement.settlement_types import moved_model

SIDES = 16
RESISTED = 1e-8
"""Largest rate against which a force could work, by the fastest motion, in a proof."""
WORK = 1e-5
"""Least power of the loads in a proof, by the largest load and the fastest motion."""
WRONG = 1e-6
"""Largest residual of forces that are said to balance the loads, by the largest on the block."""
EXACT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}


def proven_none(model: Model) -> bool | None:
    """Whether it is proven that no forces balance the loads.

    ``None`` where the linear program was not solved.
    """
    rate = _rates(model)
    along = _friction(model) / np.cos(np.pi / SIDES)
    angles = 2.0 * np.pi * np.arange(SIDES) / SIDES
    resisting = vstack(
        [
            rate[0::3] + (along * np.cos(a))[:, None] * rate[1::3]
            + (along * np.sin(a))[:, None] * rate[2::3]
            for a in angles
        ]
    ).tocsr()  # fmt: skip
    resisting = resisting / np.tile(np.hypot(1.0, along), SIDES)[:, None]
    reach = np.repeat(~model.assembly.fixed, 6).astype(float)
    found = linprog(
        -_loads(model), A_ub=-resisting, b_ub=np.zeros(resisting.shape[0]),
        bounds=list(zip(-reach, reach, strict=True)), method="highs", options=EXACT,
    )  # fmt: skip
    return proves_none(model, found.x) if found.status == 0 else None


def proves_none(model: Model, velocity: Floats) -> bool:
    """Whether the loads work along velocities (6n,) against which no force of the cones can."""
    fastest = float(np.abs(velocity).max(initial=0.0))
    opening = (_rates(model) @ velocity).reshape(-1, 3)
    mu = _friction(model)
    least = opening[:, 0] - mu * np.hypot(opening[:, 1], opening[:, 2])
    power = float(_loads(model) @ velocity)
    return power > WORK * fastest and bool(least.min(initial=0.0) >= -RESISTED * fastest)


def fault_of_forces(found: Result) -> str:
    """What is wrong with the forces of a result that stands; empty where nothing is.

    Where it stands after settling they are those on the blocks where they came to rest.
    """
    if found.force is None:
        return "it has none"
    paths = () if found.settlement is None else found.settlement.paths
    rested = [path for path in paths if path.residuals is not None]
    if not rested:
        return _fault(found.model, found.force)
    return "".join(
        _fault(moved_model(path.model, path.displacement, path.axes, path.point), path.force)
        for path in rested
    )


def _fault(model: Model, force: Floats) -> str:
    """What is wrong with corner forces (k, 3) of a model."""
    local = np.asarray(force, dtype=np.longdouble)
    contacts, assembly = model.contacts, model.assembly
    world = np.einsum("ki,kij->kj", local, contacts.frame[contacts.interface])
    size = np.array([one.size for one in assembly.blocks])
    total = model.load.wrench.astype(np.longdouble)
    total[:, 3:] /= size[:, None]
    most = np.abs(total).max(axis=1)
    for owner, sign in ((contacts.block_a, -1.0), (contacts.block_b, 1.0)):
        block = owner[contacts.interface]
        arm = (contacts.point - assembly.centroid[block]) / size[block][:, None]
        wrench = sign * np.hstack([world, np.cross(arm, world)])
        np.add.at(total, block, wrench)
        np.maximum.at(most, block, np.abs(wrench).max(axis=1))
    allowed = WRONG * np.where(most > 0.0, most, 1.0)
    share = (np.abs(total).max(axis=1) / allowed)[assembly.free].max(initial=0.0)
    if not share <= 1.0:
        return f"they do not balance: {WRONG * share:.1e}"
    allowed[assembly.fixed] = np.inf
    slack = np.minimum(
        *(allowed[b][contacts.interface] for b in (contacts.block_a, contacts.block_b))
    )
    if (local[:, 0] < -slack).any():
        return "a corner pulls"
    friction = np.hypot(local[:, 1], local[:, 2])
    if (friction > _friction(model) * np.maximum(local[:, 0], 0.0) + slack).any():
        return "one is outside of its cone"
    return ""


def _friction(model: Model) -> Floats:
    """Of each corner (k,)."""
    return model.contacts.friction[model.contacts.interface]


def _rates(model: Model) -> csr_array:
    """Rates (3k, 6n) of the corners along n, u, v from velocities and turns."""
    assembly, contacts = model.assembly, model.contacts
    axes = contacts.frame[contacts.interface]
    size = np.array([one.size for one in assembly.blocks])
    row = np.repeat(np.arange(3 * len(axes)), 6)
    rates = csr_array((3 * len(axes), 6 * len(assembly)))
    for owner, sign in ((contacts.block_a, -1.0), (contacts.block_b, 1.0)):
        block = owner[contacts.interface]
        arm = (contacts.point - assembly.centroid[block]) / size[block][:, None]
        values = sign * np.concatenate([axes, np.cross(arm[:, None], axes)], axis=2)
        column = np.repeat(6 * block, 18).reshape(-1, 3, 6) + np.arange(6)
        rates = rates + coo_array((values.ravel(), (row, column.ravel())), rates.shape).tocsr()
    return rates


def _loads(model: Model) -> Floats:
    """Loads (6n,) on free blocks, by the largest."""
    load = model.load.wrench.copy()
    load[:, 3:] /= np.array([one.size for one in model.assembly.blocks])[:, None]
    load[model.assembly.fixed] = 0.0
    most = float(np.abs(load).max(initial=0.0))
    return load.ravel() / most if most > 0.0 else load.ravel()
