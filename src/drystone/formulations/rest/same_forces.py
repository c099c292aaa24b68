"""A start for other contact stiffnesses with the forces of a rest state.

The forces of a rest state balance the loads whatever the stiffness is. With other springs each
corner has these forces at another overlap and slide, which no motion of the blocks gives. A step
of Newton's method from there, with the tangent of the new law, gives a motion and forces that
balance again. From the motion of the rest state in place of its forces, joints that are ten times
as stiff begin with forces ten times as large, and most starts lead nowhere.

Source: balanced forces and the contact law in turn, with the tangent between them: the LATIN
method, Ladeveze 1999.
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.formulations.rest.compliance import Compliance, wrench_size
from drystone.formulations.rest.friction import StickSlip
from drystone.formulations.rest.rest_state import RestOptions, RestState, Start, block_scale
from drystone.formulations.rest.tangent import TangentSystem
from drystone.statics import Statics

LEAST_FORCE = 0.05
"""Share of its normal force that a corner keeps at least in a step. Measured on 13 models: 427
factorisations for all stiffnesses, 428 with 0.1 and 431 with 0.2."""

NEAR, STEPS, SLOWLY = 0.2, 4, 0.75
"""Largest unbalanced share of a block after which no further step is made; the number of steps; and
the share of the error that a step may leave where another one is to follow. Measured: random
stiffnesses of the Armadillo vault and of a wall of 2,000 blocks get to rest after two to four
steps, but not after one. Eleven models take 245 factorisations, 249 with 0.15; the Armadillo 24 of
these, 27 with 0.25."""

RELAXED = 1e-4
"""Relative tau at which a rest state is taken for an iterate. Measured on twelve models, in
factorisations for other stiffnesses: 258, and 278 to 285 at 1e-3, 1e-5 or 1e-6; 248 from the
iterates that led to the rest states."""

FAR = 0.5
"""Unbalanced share of a block from which on Newton's method is not tried. Measured: of 19 such
starts near the limit of a dome one led to rest."""


def start_of_forces(
    system: TangentSystem, compliance: Compliance, options: RestOptions, path: Start
) -> tuple[Start, int, float]:
    """A start for some springs from an iterate of the relaxed law with others.

    Parameters
    ----------
    system
    compliance
        Springs of dry joints.
    options
        Only the ground is used.
    path
        An iterate with its friction.

    Returns
    -------
    Start
    int
        Number of steps, of one factorisation each.
    float
        Largest unbalanced share of a block.

    Raises
    ------
    SolverError
        The matrix of a step is singular.
    """
    statics, kn, law = system.statics, compliance.normal, compliance.friction
    tau, normal, held = path.relaxation, path.normal, path.friction
    if tau is None or held is None:
        raise ValueError("the start is no iterate of the relaxed law")
    ground = options.ground * statics.mass_matrix
    slide = statics.displacement(path.motion)[:, 1:]
    tangent = np.zeros((len(kn), 3, 3))
    steps, before = 0, np.inf
    while True:
        steps += 1
        slack = tau * statics.corner_load**2 / (kn * normal)
        slid = law.slide_of(normal, held, slide)
        friction = law(normal, slid)
        stiffness = normal / (slack + normal / kn)
        tangent[:, 0, 0] = stiffness
        tangent[:, 1:, 0] = -friction.by_normal * stiffness[:, None]
        tangent[:, 1:, 1:] = friction.by_slide
        place = np.concatenate([(slack - normal / kn)[:, None], slid], axis=1)
        force = np.concatenate([normal[:, None], -friction.force], axis=1)
        right = statics.wrench(force + np.einsum("kij,kj->ki", tangent, place)) + statics.load
        motion = system.factorise(tangent, ground, rough=True)(right)
        moved = statics.displacement(motion)
        force -= np.einsum("kij,kj->ki", tangent, moved - place)
        normal = np.maximum(force[:, 0], LEAST_FORCE * normal)
        held, slide = -force[:, 1:], moved[:, 1:]
        share = unbalanced_share(system, compliance, moved)
        if share <= NEAR or share > SLOWLY * before or steps == STEPS:
            return Start(motion, normal, tau), steps, share
        before = share


def relaxed_again(statics: Statics, compliance: Compliance, state: RestState) -> Start:
    """A rest state as an iterate of the relaxed law, for where none led to it."""
    kn, gap = compliance.normal, statics.displacement(state.motion)[:, 0]
    product = RELAXED * statics.corner_load**2 / kn
    root = np.sqrt(gap**2 + 4.0 * product / kn) + np.abs(gap)
    normal = np.where(gap < 0.0, 0.5 * kn * root, 2.0 * product / root)
    return Start(state.motion, normal, RELAXED, -state.force[:, 1:])


def unbalanced_share(system: TangentSystem, compliance: Compliance, moved: Floats) -> float:
    """Largest unbalanced share of a block with dry joints where corners have moved (k, 3)."""
    statics = system.statics
    normal = compliance.normal * np.maximum(0.0, -moved[:, 0])
    friction = compliance.friction(normal, moved[:, 1:])
    force = np.concatenate([normal[:, None], -friction.force], axis=1)
    rest = wrench_size(statics.wrench(force) + statics.load)
    return float((rest / block_scale(statics, force)).max(initial=0.0))


def sliding_share(compliance: Compliance, moved: Floats) -> float:
    """Share of the normal force at corners that slide where corners have moved (k, 3).

    1 with a smooth law: there every corner slides a little.
    """
    law = compliance.friction
    if not isinstance(law, StickSlip):
        return 1.0
    normal = compliance.normal * np.maximum(0.0, -moved[:, 0])
    slides = law.stiffness * lengths(moved[:, 1:]) > law.bound(normal)
    return float(normal[slides].sum() / max(normal.sum(), np.finfo(float).tiny))
