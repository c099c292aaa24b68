"""Proofs that a structure falls, and their conditions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, marked
from drystone.checks import FORCE_TOLERANCE, block_speed, check_forces, mechanism_defects
from drystone.formulations.equilibrium import EquilibriumSolution, held_still
from drystone.mechanics.rest_state import RestState
from drystone.results import Result, Samples, Verdict
from drystone.stability.problem import Problem

UNBALANCED = "no contact forces can balance the loads"

MECHANISM_TOLERANCE = 1e-5
"""Largest closing of a gap in a claimed mechanism, by the speed of its blocks: ten times what the
certificates of the interior point come to on slender overlaps. A first motion is blurred by the
compliance of the contacts: about 1e-7, the weakness of the ground, times the stiffness."""

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
    """The multiplier of an infeasible equilibrium as a physical mechanism, if it is one.

    Beside blocks that hardly move its rounding counts as closing: these are then held still.
    """
    found = sound_mechanism(problem, solution.multiplier)
    if found is None:
        found = sound_mechanism(problem, held_still(problem.statics, solution).multiplier)
    return found


def balanced(problem: Problem, force: Floats) -> bool:
    """Whether scaled corner forces (k, 3) balance the loads within friction, without pull."""
    if not np.isfinite(force).all():
        return False
    found = check_forces(problem.model, problem.force(force))
    return max(found.equilibrium, found.tension, found.cone) <= FORCE_TOLERANCE


def moving_blocks(assembly: Assembly, mechanism: Floats | None) -> tuple[int, ...]:
    """Positions of the blocks that take part in a mechanism (n, 6), if there is one."""
    if mechanism is None:
        return ()
    speed = block_speed(assembly, mechanism)
    return tuple(int(i) for i in np.flatnonzero(speed > FALLING_SHARE * speed.max(initial=0.0)))


def part_of_fall(found: Result) -> Bools:
    """The blocks (n,) that fall or take part in the motion that proves it."""
    moving = marked(list(found.falling), len(found.assembly))
    moving[list(moving_blocks(found.assembly, found.mechanism))] = True
    return moving


def withdrawn(found: Result, message: str) -> Result:
    """UNDECIDED in place of a fall whose proof does not hold, and nothing of that proof."""
    return replace(
        found,
        verdict=Verdict.UNDECIDED,
        message=message,
        mechanism=None,
        prop=None,
        force_with_props=None,
        falling=(),
    )


def undone(found: Result, message: str) -> Result:
    """UNDECIDED in place of any verdict, and nothing of what showed it."""
    return replace(
        withdrawn(found, message),
        force=None,
        displacement=None,
        residuals=None,
        settlement=None,
        samples=Samples(),
        sensitive_to=(),
    )


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
    admissible = violation <= MECHANISM_TOLERANCE and power > 0.0
    return motion if admissible and max(left) <= MECHANISM_TOLERANCE else None
