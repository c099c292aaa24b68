"""Forces and a virtual motion that agree, found by convex steps that take turns.

Coupled rigid-block analysis asks for corner forces in equilibrium and block motions q such that a
corner presses only where it closes, and friction acts only against its slide (Kao et al. 2022,
eq. 5.6). With the motion held, the forces form a convex program; with the forces held, so do the
motions; linearised together they form a sequence of quadratic programs. Each is solved by an
interior point; none guesses a stiffness.

Unknowns per pressing corner: normal force fn >= 0 and friction 0 <= s <= mu fn against the unit
slide t, so that the corner force is ``fn n - s t``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import lsmr

from drystone.geometry.arrays import Bools, Floats, Ints
from drystone.solvers.conic import Cones, ConicOptions, ConicStatus, solve_conic
from drystone.statics import Statics

MARGIN = 1e-3
"""Overlap that a pressing corner keeps, by its present one, while a motion is improved."""

PRESSED = 1e-3
"""Least overlap of a corner that presses, by the largest displacement. The source bounds slides by
eta = 10 to 1000 overlaps; corners that press less than that would be prestress in all but name."""

LEVEL = 1e-6
"""Overlaps this near to the largest are equal to it."""

PATIENCE = 4
"""Steps with little progress after which a motion is given up: a good one is found in fewer."""

TURN = 0.02
"""Slides below this share of the mean one may change by it whatever their size."""


@dataclass(frozen=True, eq=False)
class CompatibleState:
    """Forces and a motion that agree, up to an unbalanced rest.

    Attributes
    ----------
    motion : (n, 6)
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


def compatible_forces(
    statics: Statics, motion: Floats, *, pressing: Bools | None = None
) -> tuple[Floats, float]:
    """Forces that agree with a motion and leave least unbalanced.

    Parameters
    ----------
    statics
    motion : (n, 6)
    pressing : (k,), optional
        Corners that may carry force; those that close, when left out.

    Returns
    -------
    force : (k, 3)
    unbalanced
    """
    moved = statics.displacement(motion)
    allowed = moved[:, 0] < -PRESSED * np.abs(moved).max(initial=0.0)
    if pressing is not None:
        allowed &= pressing
    corner = np.flatnonzero(allowed)
    count = len(corner)
    force = np.zeros((statics.corner_count, 3))
    if count == 0:
        return force, float(np.linalg.norm(statics.load))
    direction = _direction(moved)[corner]
    normal, along = _columns(statics, corner, direction)
    matrix = sparse.hstack([normal, -along]).tocsc()
    friction = statics.friction[corner]
    rows = 6 * statics.free_count
    # unknowns fn, s, and the unbalanced wrench itself, so that the program stays sparse
    identity = sparse.identity(count)
    solution = solve_conic(
        sparse.block_diag([1e-9 * sparse.identity(2 * count), sparse.identity(rows)]),
        np.zeros(2 * count + rows),
        sparse.vstack(
            [
                sparse.hstack([matrix, -sparse.identity(rows)]),
                sparse.hstack([-sparse.identity(2 * count), sparse.csc_matrix((2 * count, rows))]),
                sparse.hstack(
                    [-sparse.diags(friction), identity, sparse.csc_matrix((count, rows))]
                ),
            ]
        ),
        np.concatenate([-statics.load.ravel(), np.zeros(3 * count)]),
        Cones(zero=rows, nonnegative=3 * count),
    )
    if solution.status is not ConicStatus.SOLVED:
        return force, float(np.linalg.norm(statics.load))
    x = solution.x[: 2 * count]
    x = _refined(matrix, -statics.load.ravel(), x, friction)
    force[corner, 0] = x[:count]
    force[corner, 1:] = -x[count:, None] * direction
    return force, float(np.linalg.norm(matrix @ x + statics.load.ravel()))


def compatible_motion(statics: Statics, force: Floats) -> Floats | None:
    """The motion (n, 6) that agrees best with given forces; None if the program fails.

    Loaded corners close by one or more; slides run against the friction, as far as they can.
    """
    normal = force[:, 0]
    corner = np.flatnonzero(normal > 1e-3 * normal.max(initial=0.0))
    count, size = len(corner), 6 * statics.free_count
    if count == 0:
        return None
    weight = np.sqrt(normal[corner] / normal[corner].mean())
    transposed = statics.matrix_transposed
    gap = transposed[3 * corner]
    slides = [
        sparse.hstack(
            [
                sparse.diags(weight) @ transposed[3 * corner + axis],
                sparse.diags(weight * force[corner, axis]),
                sparse.csc_matrix((count, count)),
            ]
        )
        for axis in (1, 2)
    ]
    misfit: Any = sparse.vstack(slides)
    # unknowns: motion, scale of each slide (>= 0), closing that is missing (>= 0), misfits
    total = size + 2 * count
    cost = np.concatenate([np.full(size, 1e-6), np.full(count, 1e-9), 10.0 * weight**2])
    empty = sparse.csc_matrix((count, count))
    bounds: Any = sparse.vstack(
        [
            sparse.hstack([gap, empty, -sparse.identity(count)]),
            sparse.hstack([sparse.csc_matrix((count, size)), -sparse.identity(count), empty]),
            sparse.hstack([sparse.csc_matrix((count, size)), empty, -sparse.identity(count)]),
        ]
    )
    solution = solve_conic(
        sparse.block_diag([sparse.diags(cost), sparse.identity(2 * count)]),
        np.zeros(total + 2 * count),
        sparse.vstack(
            [
                sparse.hstack([misfit, -sparse.identity(2 * count)]),
                sparse.hstack([bounds, sparse.csc_matrix((3 * count, 2 * count))]),
            ]
        ),
        np.concatenate([np.zeros(2 * count), -np.ones(count), np.zeros(2 * count)]),
        Cones(zero=2 * count, nonnegative=3 * count),
    )
    if solution.status is not ConicStatus.SOLVED:
        return None
    return solution.x[:size].reshape(-1, 6)


def improve(
    statics: Statics,
    motion: Floats,
    *,
    equal_overlap: bool = False,
    tolerance: float = 1e-9,
    iteration_limit: int = 30,
    stop: Callable[[], bool] | None = None,
) -> CompatibleState:
    """Turn a motion until the forces that agree with it balance the loads.

    Parameters
    ----------
    statics
    motion : (n, 6)
        Its closing corners are those that may press.
    equal_overlap
        Let force pass only at the largest overlap, 1 in the motion that is returned, as eq. 5.6
        demands; corners may join those that press and leave them.
    tolerance
        Unbalanced norm, by the norm of the loads, that is an answer.
    iteration_limit
    stop
        Asked before every step.
    """
    goal = tolerance * float(np.linalg.norm(statics.load))
    if equal_overlap:
        levelled = _level(statics, motion)
        if levelled is None:
            return CompatibleState(motion, np.zeros((statics.corner_count, 3)), np.inf, 1)
        motion = levelled
    else:
        motion = _scaled(statics, motion)
    pressing = _pressing(statics, motion, equal_overlap)
    force, unbalanced = compatible_forces(statics, motion, pressing=pressing)
    trust, steps, idle = 0.5, 1, 0
    while unbalanced > goal and trust > 1e-4 and steps < iteration_limit and idle < PATIENCE:
        if stop is not None and stop():
            break
        change = _joint_step(statics, motion, force, pressing, trust, equal_overlap)
        steps += 2
        if change is None:
            break
        trial = motion + change
        may_press = pressing
        if equal_overlap:
            trial = _sharpened(statics, trial, np.flatnonzero(pressing & (force[:, 0] > 0.0)))
            may_press = _pressing(statics, trial, True)
        else:
            trial = _scaled(statics, trial)
        trial_force, left = compatible_forces(statics, trial, pressing=may_press)
        idle = 0 if left < 0.8 * unbalanced else idle + 1
        if left < (1.0 - 1e-4) * unbalanced:
            motion, force, unbalanced, pressing = trial, trial_force, left, may_press
            trust = min(1.5 * trust, 0.9)
        else:
            trust *= 0.4
    return CompatibleState(motion, force, unbalanced, steps)


def _pressing(statics: Statics, motion: Floats, equal_overlap: bool) -> Bools:
    gap = statics.displacement(motion)[:, 0]
    return gap <= -1.0 + LEVEL if equal_overlap else gap < -1.5 * PRESSED


def _level(statics: Statics, motion: Floats) -> Floats | None:
    """The nearest motion whose pressing corners overlap by 1, or as nearly so as they can."""
    gap = statics.displacement(motion)[:, 0]
    force, _ = compatible_forces(statics, motion)
    loaded = np.flatnonzero(force[:, 0] > 1e-6 * force[:, 0].max(initial=0.0))
    if len(loaded) == 0:
        return None
    mean = float(-(force[loaded, 0] * gap[loaded]).sum() / force[loaded, 0].sum())
    motion = motion / mean
    gap = gap / mean
    rows = statics.matrix_transposed[3 * np.arange(statics.corner_count)]
    size, count = 6 * statics.free_count, len(loaded)
    pull = np.sqrt(force[loaded, 0] / force[loaded, 0].mean())
    weight = np.concatenate([np.full(size, 1e-6), pull**2])
    solution = solve_conic(
        sparse.diags(weight),
        np.zeros(size + count),
        sparse.vstack(
            [
                sparse.hstack([rows[loaded], -sparse.identity(count)]),
                sparse.hstack([-rows, sparse.csc_matrix((statics.corner_count, count))]),
            ]
        ),
        np.concatenate([-1.0 - gap[loaded], gap + 1.0]),
        Cones(zero=count, nonnegative=statics.corner_count),
    )
    if solution.status is not ConicStatus.SOLVED:
        return None
    return _sharpened(statics, motion + solution.x[:size].reshape(-1, 6), loaded)


def _sharpened(statics: Statics, motion: Floats, corner: Ints) -> Floats:
    """The nearest motion at which those of the corners that overlap by nearly 1 do so exactly."""
    gap = statics.displacement(motion)[corner, 0]
    near = np.abs(gap + 1.0) < 1e-3
    rows = statics.matrix_transposed[3 * corner[near]]
    change = lsmr(rows, -1.0 - gap[near], atol=1e-15, btol=1e-15, conlim=1e12, maxiter=2000)[0]
    return motion + change.reshape(-1, 6)


def _joint_step(
    statics: Statics,
    motion: Floats,
    force: Floats,
    pressing: Bools,
    trust: float,
    equal_overlap: bool,
) -> Floats | None:
    """Change of motion (n, 6) that lets forces balance best, to first order."""
    moved = statics.displacement(motion)
    corner = np.flatnonzero(pressing)
    count, size = len(corner), 6 * statics.free_count
    if count == 0:
        return None
    slide = np.linalg.norm(moved[:, 1:], axis=1)[corner] + 1e-12
    direction = _direction(moved)[corner]
    normal, along = _columns(statics, corner, direction)
    friction_now = np.linalg.norm(force[corner, 1:], axis=1)
    # turning the slide of a corner turns its friction: the component across the slide
    across = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    _, sideways = _columns(statics, corner, across)
    transposed = statics.matrix_transposed
    gap = transposed[3 * corner]
    slides = [transposed[3 * corner + axis] for axis in (1, 2)]
    turning = sparse.diags(across[:, 0]) @ slides[0] + sparse.diags(across[:, 1]) @ slides[1]
    by_motion = -sideways @ sparse.diags(friction_now / slide) @ turning
    balance = sparse.hstack([by_motion, normal, -along, -sparse.identity(size)])
    identity = sparse.identity(count)
    nothing, none = sparse.csc_matrix((count, size)), sparse.csc_matrix((count, count))
    # a corner that hardly slides may turn its slide round
    far = trust * np.maximum(slide, TURN * slide.mean())
    reach = np.concatenate([far, far])
    both = sparse.hstack([sparse.vstack(slides), sparse.csc_matrix((2 * count, 2 * count + size))])
    free_columns = sparse.csc_matrix((count, 2 * count + size))
    zero_rows: list[Any] = [balance]
    zero_right = [-statics.load.ravel()]
    rows: list[Any] = [
        sparse.hstack([nothing, -identity, none, nothing]),
        sparse.hstack([nothing, none, -identity, nothing]),
        sparse.hstack([nothing, -sparse.diags(statics.friction[corner]), identity, nothing]),
        both,
        -both,
    ]
    right = [np.zeros(3 * count), reach, reach]
    if equal_overlap:
        loaded = force[corner, 0] > 1e-9 * force[:, 0].max(initial=0.0)
        every = transposed[3 * np.arange(statics.corner_count)]
        wide = sparse.csc_matrix((statics.corner_count, 2 * count + size))
        rows.append(sparse.hstack([-every, wide]))
        right.append(np.maximum(moved[:, 0] + 1.0, 0.0))
        closing: Any = sparse.hstack([gap, free_columns])
        zero_rows.append(closing.tocsr()[loaded])
        zero_right.append(np.zeros(int(loaded.sum())))
    else:
        overlap = -moved[corner, 0]
        rows.append(sparse.hstack([gap, free_columns]))
        right.append(overlap - np.maximum(MARGIN * overlap, 1.5 * PRESSED))
    equalities: Any = sparse.vstack(zero_rows)
    inequalities: Any = sparse.vstack(rows)
    weight = np.concatenate([np.full(size + 2 * count, 1e-10), np.ones(size)])
    solution = solve_conic(
        sparse.diags(weight),
        np.zeros(len(weight)),
        sparse.vstack([equalities, inequalities]),
        np.concatenate([*zero_right, *right]),
        Cones(zero=equalities.shape[0], nonnegative=inequalities.shape[0]),
        ConicOptions(tolerance=1e-8),
    )
    if solution.status is not ConicStatus.SOLVED:
        return None
    return solution.x[:size].reshape(-1, 6)


def _scaled(statics: Statics, motion: Floats) -> Floats:
    largest = float(np.abs(statics.displacement(motion)).max(initial=0.0))
    return motion / largest if largest > 0.0 else motion


def _direction(moved: Floats) -> Floats:
    """Unit slides (k, 2)."""
    slide = np.linalg.norm(moved[:, 1:], axis=1)
    return moved[:, 1:] / np.where(slide > 0.0, slide, 1.0)[:, None]


def _columns(
    statics: Statics, corner: Ints, direction: Floats
) -> tuple[sparse.csc_matrix, sparse.csc_matrix]:
    """Wrenches per unit normal force, and per unit force along ``direction``, of some corners."""
    matrix = statics.matrix_by_column
    normal = matrix[:, 3 * corner]
    along = matrix[:, 3 * corner + 1] @ sparse.diags(direction[:, 0]) + matrix[
        :, 3 * corner + 2
    ] @ sparse.diags(direction[:, 1])
    return normal, along.tocsc()


def _refined(matrix: sparse.csc_matrix, right: Floats, x: Floats, friction: Floats) -> Floats:
    """The same forces with the interior point's last digits mended by least squares.

    Forces on a bound stay on it; a corner at the edge of its cone keeps the ratio.
    """
    count = len(friction)
    normal, slide = np.maximum(x[:count], 0.0), x[count:]
    small = 1e-7 * max(float(normal.max(initial=0.0)), 1e-300)
    loaded = normal > small
    at_edge = loaded & (slide >= friction * normal - small)
    inside = loaded & ~at_edge & (slide > small)
    normal = np.where(loaded, normal, 0.0)
    slide = np.where(at_edge, friction * normal, np.where(inside, slide, 0.0))
    start = np.concatenate([normal, slide])
    first, second = matrix[:, :count], matrix[:, count:]
    ratio = sparse.diags(np.where(at_edge, friction, 0.0)[loaded])
    basis = sparse.hstack([first[:, loaded] + second[:, loaded] @ ratio, second[:, inside]]).tocsr()
    rest = right - matrix @ start
    if basis.shape[1] == 0 or float(np.linalg.norm(rest)) > 1e-4 * float(np.linalg.norm(right)):
        return x
    change = lsmr(basis, rest, atol=1e-15, btol=1e-15, conlim=1e12, maxiter=2000)[0]
    loads = int(loaded.sum())
    normal[loaded] += change[:loads]
    slide[inside] += change[loads:]
    slide = np.where(at_edge, friction * normal, slide)
    normal = np.maximum(normal, 0.0)
    slide = np.clip(slide, 0.0, friction * normal)
    refined = np.concatenate([normal, slide])
    better = np.linalg.norm(matrix @ refined - right) < np.linalg.norm(matrix @ x - right)
    return refined if better else x
