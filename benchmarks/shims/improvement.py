"""Forces and a motion with equal overlaps, as in eq. 5.6 of Kao et al. 2022.

All corners in compression overlap by the same depth. The motion changes step by step until
compatible forces balance the loads. Each step is a quadratic program in forces and motion,
linearised about the present motion, with a trust region on the slides. No stiffness is assumed.
:mod:`benchmarks.shims.stiffness_range` allows different overlaps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import lsmr

from benchmarks.shims.compatible import (
    NORMAL,
    compatible_forces,
    edge_of_friction,
    slide_directions,
    unit_wrenches,
    wrenches_along,
)
from drystone.base.arrays import Bools, Floats, Ints
from drystone.mechanics.statics import Statics
from drystone.solvers.program import ConicOptions, ConicStatus, ProgramBuilder, Variable

EQUAL = 1e-6
"""Relative difference of overlaps that counts as zero."""

PATIENCE = 4
"""Steps with little progress after which the iteration stops. Solutions needed fewer."""

PROGRAMS = 60
"""Largest number of convex programs for one motion."""

EXACT = 1e-9
"""Unbalanced norm, relative to the norm of the loads, that counts as zero."""

TURN = 0.02
"""Least permitted change of a slide, relative to the mean slide."""


@dataclass(frozen=True, eq=False)
class CompatibleState:
    """Forces compatible with a motion, and the unbalanced load.

    Attributes
    ----------
    motion : (n, 6) with a largest overlap of 1 at the corners
    force : (k, 3)
    unbalanced
        Euclidean norm of the unbalanced scaled wrenches; 0 is a solution.
    iterations
        Convex programs solved.
    """

    motion: Floats
    force: Floats
    unbalanced: float
    iterations: int


def improve(
    statics: Statics,
    motion: Floats,
    *,
    stop: Callable[[], bool] | None = None,
) -> CompatibleState:
    """Change a motion until compatible forces balance the loads.

    Parameters
    ----------
    statics
    motion : (n, 6)
        Initial motion. Corners may close and open during the iteration.
    stop
        Called before every step.
    """
    goal = EXACT * float(np.linalg.norm(statics.load))
    equal = _with_equal_overlap(statics, motion)
    if equal is None:
        return CompatibleState(motion, np.zeros((statics.corner_count, 3)), np.inf, 1)
    motion = equal
    pressing = _pressing(statics, motion)
    force, unbalanced = compatible_forces(statics, motion, pressing=pressing)
    trust, steps, idle = 0.5, 1, 0
    while unbalanced > goal and trust > 1e-4 and steps < PROGRAMS and idle < PATIENCE:
        if stop is not None and stop():
            break
        change = _step(statics, motion, force, pressing, trust)
        steps += 2
        if change is None:
            break
        trial = motion + change
        trial = _sharpened(statics, trial, np.flatnonzero(pressing & (force[:, 0] > 0.0)))
        may_press = _pressing(statics, trial)
        trial_force, left = compatible_forces(statics, trial, pressing=may_press)
        idle = 0 if left < 0.8 * unbalanced else idle + 1
        if left < (1.0 - 1e-4) * unbalanced:
            motion, force, unbalanced, pressing = trial, trial_force, left, may_press
            trust = min(1.5 * trust, 0.9)
        else:
            trust *= 0.4
    return CompatibleState(motion, force, unbalanced, steps)


def _pressing(statics: Statics, motion: Floats) -> Bools:
    return statics.displacement(motion)[:, 0] <= -1.0 + EQUAL


def _with_equal_overlap(statics: Statics, motion: Floats) -> Floats | None:
    """The nearest motion at which all corners in compression overlap by 1."""
    gap = statics.displacement(motion)[:, 0]
    force, _ = compatible_forces(statics, motion)
    loaded = np.flatnonzero(force[:, 0] > 1e-6 * force[:, 0].max(initial=0.0))
    if len(loaded) == 0:
        return None
    weighted = force[loaded, 0] * gap[loaded]
    unit = float(-weighted.sum() / force[loaded, 0].sum())
    motion, gap = motion / unit, gap / unit
    program = ProgramBuilder()
    change = program.variable("change", 6 * statics.free_count, quadratic=1e-6)
    missing = program.variable(
        "missing overlap", len(loaded), quadratic=force[loaded, 0] / force[loaded, 0].mean()
    )
    opening = unit_wrenches(statics, loaded, NORMAL).T
    program.equal("overlap", -1.0 - gap[loaded], (change, opening), (missing, -1.0))
    closing = -unit_wrenches(statics, np.arange(statics.corner_count), NORMAL).T
    program.at_most("largest overlap", gap + 1.0, (change, closing))
    solution = program.build().solve()
    if solution.status is not ConicStatus.SOLVED:
        return None
    motion = motion + solution.x[change.place].reshape(-1, 6)
    return _sharpened(statics, motion, loaded)


def _sharpened(statics: Statics, motion: Floats, corner: Ints) -> Floats:
    """The nearest motion at which corners that overlap by nearly 1 overlap by exactly 1."""
    gap = statics.displacement(motion)[corner, 0]
    near = np.abs(gap + 1.0) < 1e-3
    rows = statics.matrix_transposed[3 * corner[near]]
    change = lsmr(rows, -1.0 - gap[near], atol=1e-15, btol=1e-15, conlim=1e12, maxiter=2000)[0]
    return motion + change.reshape(-1, 6)


def _step(
    statics: Statics,
    motion: Floats,
    force: Floats,
    pressing: Bools,
    trust: float,
) -> Floats | None:
    """Change of motion (n, 6) with the least unbalanced load, to first order."""
    moved = statics.displacement(motion)
    corner = np.flatnonzero(pressing)
    if len(corner) == 0:
        return None
    slide = np.linalg.norm(moved[corner, 1:], axis=1) + 1e-12
    held = np.linalg.norm(force[corner, 1:], axis=1) / slide
    edge = unit_wrenches(statics, corner, edge_of_friction(statics, moved)[corner])
    every = np.arange(statics.corner_count)
    loaded = corner[force[corner, 0] > 1e-9 * force[:, 0].max(initial=0.0)]
    none = np.zeros(len(corner))
    program = ProgramBuilder()
    change = program.variable("change", 6 * statics.free_count, quadratic=1e-10)
    straight = program.variable("straight", len(corner), quadratic=1e-10)
    at_edge = program.variable("at the edge of friction", len(corner), quadratic=1e-10)
    rest = program.variable("rest", change.count, quadratic=1.0)
    program.equal(
        "balance",
        -statics.load.ravel(),
        (change, turned_friction(statics, moved, corner, held)),
        (straight, unit_wrenches(statics, corner, NORMAL)),
        (at_edge, edge),
        (rest, -1.0),
    )
    still = unit_wrenches(statics, loaded, NORMAL).T
    program.equal("still pressed", np.zeros(len(loaded)), (change, still))
    program.at_most("straight", none, (straight, -1.0))
    program.at_most("at the edge", none, (at_edge, -1.0))
    add_trust_region(program, statics, change, corner, slide, trust)
    closing = -unit_wrenches(statics, every, NORMAL).T
    program.at_most("overlap", np.maximum(moved[:, 0] + 1.0, 0.0), (change, closing))
    solution = program.build().solve(ConicOptions(tolerance=1e-8))
    if solution.status is not ConicStatus.SOLVED:
        return None
    return solution.x[change.place].reshape(-1, 6)


def turned_friction(statics: Statics, moved: Floats, corner: Ints, held: Floats) -> Any:
    """Change of wrenches (6 n, 6 n) by a change of motion, due to the rotation of the slide.

    Parameters
    ----------
    statics
    moved : (k, 3)
        Corner displacements.
    corner : (c,)
    held : (c,)
        Friction force divided by slide.
    """
    direction = slide_directions(moved)[corner]
    zero = np.zeros(len(corner))
    across = np.stack([zero, -direction[:, 1], direction[:, 0]], axis=1)
    freedom, value = wrenches_along(statics, corner, across)
    row, column = np.repeat(freedom, 12, axis=1), np.tile(freedom, 12)
    product = -np.repeat(held[:, None] * value, 12, axis=1) * np.tile(value, 12)
    meets = (row >= 0) & (column >= 0)
    size = 6 * statics.free_count
    return sparse.csr_matrix((product[meets], (row[meets], column[meets])), shape=(size, size))


def add_trust_region(
    program: ProgramBuilder,
    statics: Statics,
    change: Variable,
    corner: Ints,
    slide: Floats,
    trust: float,
) -> None:
    """Rows that bound the change of slides (c,) to a share of them."""
    # a corner that slides little may reverse its slide
    reach = trust * np.maximum(slide, TURN * slide.mean())
    for axis in (1, 2):
        along = unit_wrenches(statics, corner, np.eye(3)[axis]).T
        program.at_most(f"largest slide {axis}", reach, (change, along))
        program.at_most(f"least slide {axis}", reach, (change, -along))
