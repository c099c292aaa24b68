"""Proofs that a structure falls, and their conditions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, dot
from drystone.checks import block_speed, check_forces, mechanism_defects, point_motion
from drystone.contacts import Contacts
from drystone.formulations.equilibrium import (
    EquilibriumSolution,
    held_still,
    project_on_mechanisms,
)
from drystone.formulations.rest.rest_state import RestState
from drystone.stability.problem import Problem

FORCE_TOLERANCE = 1e-8
"""Largest residual of a claim of equilibrium, dimensionless."""

MECHANISM_TOLERANCE = 1e-5
"""Largest closing of a gap in a claimed mechanism, by the speed of its blocks: ten times what the
certificates of the interior point come to on slender overlaps."""

WITNESS_TOLERANCE = 1e-5
"""The same for a first motion, which the compliance of the contacts blurs by about the weakness of
the ground springs, 1e-7, times the stiffness of the structure."""

APPROACH = 1e-3
"""A corner is pressed when free blocks approach it by more than this share of their speed: it then
overlaps by as much of their motion, and the source bounds slides by a thousand overlaps."""

NO_APPROACH = 1e-7
"""The same for faces along which blocks fall freely: less is rounding of their coordinates."""

FALLING_SHARE = 1e-3
"""A block falls when it moves, or leans on the ground springs, more than this share of the one that
does so most."""


def sound_mechanism(problem: Problem, velocity: Floats) -> Floats | None:
    """A scaled velocity (n, 6) of the free blocks as a physical mechanism, if it is one.

    It is a proof whatever found it: every corner opens at least as fast as friction times its
    slide, and the loads do work.
    """
    largest = float(np.abs(velocity).max(initial=0.0))
    if not 0.0 < largest < np.inf:
        return None
    # the size of a certificate is arbitrary, and its square may overflow
    motion = problem.mechanism(velocity / largest)
    violation, power = mechanism_defects(problem.model, motion)
    return motion if violation <= MECHANISM_TOLERANCE and power > 1e-9 else None


def checked_mechanism(problem: Problem, solution: EquilibriumSolution) -> Floats | None:
    """The multiplier of an infeasible equilibrium as a physical mechanism, if it is one."""
    return sound_mechanism(problem, solution.multiplier)


def balanced(problem: Problem, force: Floats) -> bool:
    """Whether scaled corner forces (k, 3) balance the loads within friction, without pull."""
    if not np.isfinite(force).all():
        return False
    found = check_forces(problem.model, problem.force(force))
    return max(found.equilibrium, found.tension, found.cone) <= FORCE_TOLERANCE


def found_mechanism(
    problem: Problem, solution: EquilibriumSolution, stop: Callable[[], bool]
) -> Floats | None:
    """The mechanism of an equilibrium that was not found, from the multiplier or solved for.

    Close to the limit the multiplier of a failed program may miss the tolerance; the projection of
    the loads onto the cone of mechanisms does not, once what hardly moves is held still. It is left
    out, or given up, where ``stop`` says so.
    """
    mechanism = checked_mechanism(problem, solution)
    if mechanism is not None or stop():
        return mechanism
    projected = project_on_mechanisms(problem.statics, stop=stop)
    mechanism = None if projected is None else checked_mechanism(problem, projected)
    if projected is None or mechanism is not None or stop():
        return mechanism
    return checked_mechanism(problem, held_still(problem.statics, projected))


def moving_blocks(assembly: Assembly, mechanism: Floats) -> tuple[int, ...]:
    """Positions of the blocks that take part in a mechanism (n, 6)."""
    speed = block_speed(assembly, mechanism)
    return tuple(int(i) for i in np.flatnonzero(speed > FALLING_SHARE * speed.max(initial=0.0)))


def first_motion(problem: Problem, state: RestState) -> Floats | None:
    """The motion (n, 6) with which a state on weak ground springs begins to fall, if it is one.

    The ground carries what the contacts do not, ``g M q = p + A f``: an acceleration. Checked from
    points and cross products: that equation, friction in its cone and against the slide, no pull;
    and of the blocks that move, that no gap closes and that the loads do work.
    """
    share = problem.ground_share(state.ground)
    moving = (share > FALLING_SHARE * share.max())[:, None]
    motion = problem.mechanism(np.where(moving, state.motion, 0.0))
    residuals = check_forces(
        problem.model,
        problem.force(state.force),
        problem.displacement(state.motion),
        prop=-problem.wrench(state.ground),
    )
    left = (residuals.equilibrium, residuals.tension, residuals.cone, residuals.alignment)
    dry = problem.model.with_capacity(None).with_friction(0.0)
    violation, power = mechanism_defects(dry, motion)
    admissible = violation <= WITNESS_TOLERANCE and power > 0.0
    return motion if admissible and max(left) <= WITNESS_TOLERANCE else None


def free_acceleration(problem: Problem) -> Floats:
    """Acceleration (n, 6) of each free block under its load alone."""
    assembly = problem.model.assembly
    free = problem.statics.free
    motion = np.zeros((len(assembly), 6))
    motion[free, :3] = problem.model.load.wrench[free, :3] / assembly.mass[free, None]
    turning = assembly.mass[free] * problem.statics.inertia * assembly.size[free] ** 2
    motion[free, 3:] = problem.model.load.wrench[free, 3:] / turning[:, None]
    return motion


def unpressed(
    assembly: Assembly, contacts: Contacts, acceleration: Floats, least: float = APPROACH
) -> Bools:
    """The largest set (n,) of free blocks whose free motion approaches no corner.

    Parameters
    ----------
    assembly, contacts
    acceleration : (n, 6)
        Of each block under its load alone; blocks outside the set rest.
    least
        Share of its speed by which a block that is pressed approaches a corner. A block at a joint
        that is not dry counts as pressed.
    """
    speed = block_speed(assembly, acceleration)
    falling = ~assembly.fixed & (speed > 0.0)
    joint = contacts.interface
    holds = ~contacts.dry[joint]  # a joint that pulls or coheres need not be pressed
    a, b = contacts.block_a, contacts.block_b
    away_a, away_b = _along_normals(assembly, contacts, acceleration)

    def approach(opening: Floats, reach: Floats) -> Bools:
        near = (opening < -least * reach[joint]) | holds
        return np.bincount(joint[near], minlength=contacts.count) > 0

    both = approach(away_b - away_a, np.maximum(speed[a], speed[b]))
    only_a, only_b = approach(-away_a, speed[a]), approach(away_b, speed[b])
    while falling.any():
        of_a, of_b = falling[a], falling[b]
        pressed = (of_a & of_b & both) | (of_a & ~of_b & only_a) | (of_b & ~of_a & only_b)
        if not pressed.any():
            break
        falling[a[pressed]] = falling[b[pressed]] = False
    return falling


def closing_blocks(assembly: Assembly, contacts: Contacts, motion: Floats) -> Bools:
    """The blocks (n,) of which a corner closes by a share of their way in a motion (n, 6)."""
    away_a, away_b = _along_normals(assembly, contacts, motion)
    speed = block_speed(assembly, motion)
    found = np.zeros(len(assembly), dtype=bool)
    for block in (contacts.block_a, contacts.block_b):
        of_corner = block[contacts.interface]
        found[of_corner[away_b - away_a < -APPROACH * speed[of_corner]]] = True
    return found


def _along_normals(assembly: Assembly, contacts: Contacts, motion: Floats) -> tuple[Floats, Floats]:
    """(k,) motion of each corner along the normal of its joint, with block a and with block b."""
    of_a, of_b = (
        dot(
            point_motion(assembly, contacts, motion, block[contacts.interface]),
            contacts.frame[contacts.interface, 0],
        )
        for block in (contacts.block_a, contacts.block_b)
    )
    return of_a, of_b


def beside_supports(assembly: Assembly, contacts: Contacts, falling: Bools) -> bool:
    """Whether blocks (n,) that fall touch none but each other and supports.

    A free block that stands without them may still settle against them.
    """
    a, b = contacts.block_a, contacts.block_b
    other = np.where(falling[a], b, a)[falling[a] != falling[b]]
    return bool(assembly.fixed[other].all())
