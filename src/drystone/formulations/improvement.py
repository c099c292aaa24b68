"""A motion turned step by step until the forces that agree with it balance the loads.

Every corner that presses overlaps by the same, as in eq. 5.6 of Kao et al. 2022. Forces and motion,
linearised together, form a sequence of quadratic programs with a trust region on the slides; none
guesses a stiffness. :mod:`drystone.formulations.stiffness_range` lets overlaps differ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import lsmr

from drystone.arrays import Bools, Floats, Ints
from drystone.formulations.compatible import compatible_forces, edge_of_friction, slide_directions
from drystone.formulations.corner_blocks import NORMAL, CornerBlocks
from drystone.solvers.conic import Cones, ConicOptions, ConicStatus, solve_conic
from drystone.solvers.triplets import Triplets
from drystone.statics import Statics

LEVEL = 1e-6
"""Overlaps this near to what they must reach have reached it."""

PATIENCE = 4
"""Steps with little progress after which a motion is given up: a good one is found in fewer."""

PROGRAMS = 60
"""Most convex programs of one motion."""

NOTHING = 1e-9
"""Unbalanced norm, by the norm of the loads, that is an answer."""

TURN = 0.02
"""Slides below this share of the mean one may change by it whatever their size."""


@dataclass(frozen=True, eq=False)
class CompatibleState:
    """Forces and a motion that agree, up to an unbalanced rest.

    Attributes
    ----------
    motion : (n, 6) with a largest overlap of 1 at the corners
    force : (k, 3)
    unbalanced
        Euclidean norm of the scaled wrenches left over; 0 is an answer.
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
    """Turn a motion until the forces that agree with it balance the loads.

    Parameters
    ----------
    statics
    motion : (n, 6)
        Where to start. Corners may join those that press and leave them.
    stop
        Asked before every step.
    """
    goal = NOTHING * float(np.linalg.norm(statics.load))
    levelled = _level(statics, motion)
    if levelled is None:
        return CompatibleState(motion, np.zeros((statics.corner_count, 3)), np.inf, 1)
    motion = levelled
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
    return statics.displacement(motion)[:, 0] <= -1.0 + LEVEL


def _level(statics: Statics, motion: Floats) -> Floats | None:
    """The nearest motion whose pressing corners overlap by 1."""
    gap = statics.displacement(motion)[:, 0]
    force, _ = compatible_forces(statics, motion)
    loaded = np.flatnonzero(force[:, 0] > 1e-6 * force[:, 0].max(initial=0.0))
    if len(loaded) == 0:
        return None
    weighted = force[loaded, 0] * gap[loaded]
    unit = float(-weighted.sum() / force[loaded, 0].sum())
    motion, gap = motion / unit, gap / unit
    size, count, every = 6 * statics.free_count, len(loaded), statics.corner_count
    pull = force[loaded, 0] / force[loaded, 0].mean()
    # unknowns: change of motion, what a loaded corner fails to reach
    rows = Triplets(count + every, size + count)
    blocks = CornerBlocks(statics, loaded)
    rows.add(blocks.local, blocks.freedom, blocks.along(NORMAL))
    rows.diagonal(0, size, np.full(count, -1.0))
    blocks = CornerBlocks(statics, np.arange(every))
    rows.add(count + blocks.local, blocks.freedom, -blocks.along(NORMAL))
    cost = np.concatenate([np.full(size, 1e-6), pull])
    solution = solve_conic(
        cost,
        np.zeros(len(cost)),
        rows.csc(),
        np.concatenate([-1.0 - gap[loaded], gap + 1.0]),
        Cones(zero=count, nonnegative=every),
    )
    if solution.status is not ConicStatus.SOLVED:
        return None
    motion = motion + solution.x[:size].reshape(-1, 6)
    return _sharpened(statics, motion, loaded)


def _sharpened(statics: Statics, motion: Floats, corner: Ints) -> Floats:
    """The nearest motion at which those of the corners that overlap by nearly 1 do so exactly."""
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
    """Change of motion (n, 6) that lets forces balance best, to first order."""
    moved = statics.displacement(motion)
    corner = np.flatnonzero(pressing)
    count, size, every = len(corner), 6 * statics.free_count, statics.corner_count
    if count == 0:
        return None
    blocks = CornerBlocks(statics, corner)
    slide = np.linalg.norm(moved[corner, 1:], axis=1) + 1e-12
    direction = slide_directions(moved)[corner]
    edge = edge_of_friction(statics, moved)[corner]
    # turning the slide of a corner turns its friction: the component across the slide
    across = np.stack([np.zeros(count), -direction[:, 1], direction[:, 0]], axis=1)
    sideways = blocks.along(across)
    friction = np.linalg.norm(force[corner, 1:], axis=1) / slide
    # unknowns: change of motion, factors of the two rays of each corner, unbalanced rest
    rays, rest = size, size + 2 * count
    loaded = force[corner, 0] > 1e-9 * force[:, 0].max(initial=0.0)
    chosen, place = blocks.kept(loaded)
    loads = int(loaded.sum())
    rows = Triplets(size + loads + 6 * count + every, rest + size)
    rows.add(*blocks.crossed(-sideways * friction[blocks.local], sideways))
    rows.add(blocks.freedom, rays + blocks.local, blocks.along(NORMAL))
    rows.add(blocks.freedom, rays + count + blocks.local, blocks.along(edge))
    rows.diagonal(0, rest, np.full(size, -1.0))
    below = size + place[blocks.local[chosen]]
    rows.add(below, blocks.freedom[chosen], blocks.along(NORMAL)[chosen])
    first = size + loads
    rows.diagonal(first, rays, np.full(2 * count, -1.0))
    first += 2 * count
    for axis in (1, 2):
        values = blocks.along(np.eye(3)[axis])
        for sign in (1.0, -1.0):
            rows.add(first + blocks.local, blocks.freedom, sign * values)
            first += count
    whole = CornerBlocks(statics, np.arange(every))
    rows.add(first + whole.local, whole.freedom, -whole.along(NORMAL))
    # a corner that hardly slides may turn its slide round
    reach = trust * np.maximum(slide, TURN * slide.mean())
    right = np.concatenate(
        [
            -statics.load.ravel(),
            np.zeros(loads),
            np.zeros(2 * count),
            np.tile(reach, 4),
            np.maximum(moved[:, 0] + 1.0, 0.0),
        ]
    )
    zero = size + loads
    cost = np.concatenate([np.full(size + 2 * count, 1e-10), np.ones(size)])
    solution = solve_conic(
        cost,
        np.zeros(len(cost)),
        rows.csc(),
        right,
        Cones(zero=zero, nonnegative=len(right) - zero),
        ConicOptions(tolerance=1e-8),
    )
    if solution.status is not ConicStatus.SOLVED:
        return None
    return solution.x[:size].reshape(-1, 6)
