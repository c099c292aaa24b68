"""Mortar that breaks: joints crack one after another until none does, or the rest falls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Bools, Floats, dot, lengths
from drystone.base.errors import counted
from drystone.base.progress import Clock
from drystone.checks import check_forces
from drystone.contacts import Contacts
from drystone.joint_capacity import NO_LIMIT
from drystone.mechanics import law
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Attempt
from drystone.stability.problem import Problem
from drystone.stability.proofs import FORCE_TOLERANCE, undone
from drystone.virtual import joint_sections


@one_blas_thread()
def with_brittle_mortar(model: Model, decide: Callable[[Model], Result], clock: Clock) -> Result:
    """The verdict of a model whose joints lose their pull and cohesion where they crack.

    What stands with every joint cracked stands. Otherwise forces are found on uniform springs that
    pull as well as they press, as of mortar that is not cracked; a joint in whose face a linear
    pressure exceeds the pull, or the shear exceeds cohesion and friction, cracks; and again without
    it, until none cracks. Where what is left has no rest state, it must fall even if the joints
    left were ductile.

    Parameters
    ----------
    model
    decide
        Gives the verdict on a model with joints cracked, or with ductile ones.
    clock
    """
    found = decide(model.cracked())
    if found.stable:
        contacts = model.contacts.carried_to(found.contacts)
        words = f"{found.message}, with every joint of mortar cracked"
        return replace(found, model=found.model.with_contacts(contacts), message=words)
    capacity = model.contacts.capacity
    if capacity is None:
        return found
    late = clock.late
    mortar = (capacity.tension > 0.0) | (capacity.cohesion > 0.0)
    intact, steps = mortar, found.iterations
    while intact.any() and not late():
        bonded = np.where(intact, NO_LIMIT, 0.0)
        elastic = model.with_capacity(replace(capacity, tension=bonded, cohesion=bonded))
        problem = Problem.build(elastic.without_crushing())
        state = Attempt(problem, law.uniform(problem.statics), late).from_nothing()
        steps += state.steps
        if not state.stands:
            break
        breaking = intact & cracks(model.contacts, state.force)
        if not breaking.any():
            cracked = int((mortar & ~intact).sum())
            told = f"{counted(cracked, 'joint')} of it cracked" if cracked else "uncracked"
            stands = replace(found, model=model, iterations=steps)
            return _uncracked(elastic, state.force, stands, told)
        intact = intact & ~breaking
    if late():
        words = f"{clock.reason} before it was known which joints of mortar crack"
        return undone(replace(found, model=model, iterations=steps, stopped=clock.reason), words)
    ductile = replace(capacity.cracked(~intact), brittle=False)
    rest = decide(model.with_capacity(ductile)) if intact.any() else found
    cracks_in = f"its mortar cracks in {counted(int((mortar & ~intact).sum()), 'joint')}"
    if rest.falls:
        words = f"{cracks_in}, and what is left falls: {rest.message}"
        return replace(rest, model=model, message=words, iterations=steps)
    words = f"{cracks_in}, and whether what is left falls was not shown"
    return undone(replace(found, model=model, iterations=steps), words)


def _uncracked(elastic: Model, force: Floats, found: Result, told: str) -> Result:
    """STABLE with forces (k, 3) [N] that the joints which pull elastically carry.

    UNDECIDED where these forces crush a joint.
    """
    residuals = check_forces(elastic, force)
    if residuals.largest > FORCE_TOLERANCE:
        return undone(found, f"its mortar holds ({told}), but some joint crushes in part")
    words = f"stands on its mortar, {told}"
    stands = replace(undone(found, words), verdict=Verdict.STABLE)
    return replace(stands, force=force, residuals=residuals)


def cracks(contacts: Contacts, force: Floats) -> Bools:
    """Interfaces (m,) whose mortar corner forces (k, 3) [N], local n, u, v, exceed.

    The pressure is linear over the face, as of a plane section, and pulls as well, up to the
    tension and to cohesion by friction; the shear is even, torsion adds to it by the distance from
    the centroid, and friction is that of the mean pressure. Edges and points carry at corners.
    """
    capacity = contacts.capacity
    if capacity is None:
        return np.zeros(contacts.count, dtype=bool)
    corners, owner = contacts.corners, contacts.interface
    _, flat, made = joint_sections(contacts)
    face = (contacts.area > 0.0) & (corners.counts > 2)
    area = np.where(face, made.area, 1.0)
    arm = flat - made.centroid[owner]
    total = corners.sum(force) / area[:, None]
    slope = np.einsum("mij,mj->mi", made.inverse, corners.sum(force[:, :1] * arm)) / area[:, None]
    torque = corners.sum(arm[:, 0] * force[:, 2] - arm[:, 1] * force[:, 1]) / area
    polar = np.where(face, np.trace(made.inertia, axis1=1, axis2=2), 1.0)
    turned = np.stack([-arm[:, 1], arm[:, 0]], axis=1) * (torque / polar)[owner, None]
    inside = face[owner]
    pressure = np.where(inside, total[owner, 0] + dot(slope[owner], arm), force[:, 0])
    shear = np.where(inside, lengths(total[owner, 1:] + turned), lengths(force[:, 1:]))
    pull, cohesion, _ = contacts.corner_capacity
    friction = contacts.friction
    slides = np.divide(
        capacity.cohesion, friction, out=np.full(len(area), np.inf), where=friction > 0
    )
    most = np.where(inside, (np.minimum(capacity.tension, slides) / area)[owner], pull)
    holds = np.where(inside, (capacity.cohesion / area + friction * total[:, 0])[owner],
                     cohesion + friction[owner] * force[:, 0])  # fmt: skip
    over = (-pressure > most * (1.0 + 1e-9)) | (shear > np.maximum(holds, 0.0) * (1.0 + 1e-9))
    unlimited = (capacity.tension >= NO_LIMIT) & (capacity.cohesion >= NO_LIMIT)
    return corners.any(over) & ~unlimited
