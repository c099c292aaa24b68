"""Forces compatible with a given motion, and a motion compatible with given forces.

Coupled rigid-block analysis needs corner forces in equilibrium and block motions q such that a
corner is in compression only where it closes, and friction acts only against its slide (Kao et al.
2022, eq. 5.6). For a given motion the forces are the solution of a convex program; for given forces
the motion is. :mod:`benchmarks.shims.stiffness_range` steps between them.

A corner in compression has two unknowns, both >= 0: the factor of the normal force ``n``, and the
factor of ``n - mu t``, a force at the friction limit against the unit slide t.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import optimize, sparse
from scipy.sparse.linalg import lsmr

from drystone.base.arrays import Bools, Floats, Ints
from drystone.mechanics.statics import Statics
from drystone.solvers.program import ConicStatus, ProgramBuilder

NORMAL = np.array([1.0, 0.0, 0.0])
"""Local direction of a normal force."""

PRESSED = 1e-3
"""Least overlap of a corner in compression, relative to the largest displacement. The source bounds
slides by eta = 10 to 1000 overlaps. A force at a smaller overlap would in effect be prestress."""

DENSE = 40_000
"""Largest number of matrix entries for an active-set method on the dense matrix, which gives exact
zeros. Measured against an interior-point method: two to four times as fast with 7,000 to 20,000
entries; from 60,000 entries on either may be faster."""


def compatible_forces(
    statics: Statics,
    motion: Floats,
    *,
    pressing: Bools | None = None,
) -> tuple[Floats, float]:
    """Forces compatible with a motion that leave the least load unbalanced.

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
        Euclidean norm of the unbalanced scaled wrenches.
    """
    moved = statics.displacement(motion)
    if pressing is None:
        pressing = moved[:, 0] < -PRESSED * np.abs(moved).max(initial=0.0)
    corner = np.flatnonzero(pressing)
    count = len(corner)
    force = np.zeros((statics.corner_count, 3))
    right = -statics.load.ravel()
    if count == 0:
        return force, float(np.linalg.norm(right))
    edge = edge_of_friction(statics, moved)[corner]
    rays = unit_wrenches(
        statics,
        np.concatenate([corner, corner]),
        np.concatenate([np.tile(NORMAL, (count, 1)), edge]),
    )
    matrix = rays.tocsc()
    factor = _nonnegative(matrix, right)
    if factor is None:
        return force, float(np.linalg.norm(right))
    force[corner] = factor[:count, None] * NORMAL + factor[count:, None] * edge
    return force, float(np.linalg.norm(statics.wrench(force) + statics.load))


def compatible_motion(statics: Statics, force: Floats) -> Floats | None:
    """The motion (n, 6) most compatible with given forces; None if the program fails.

    Loaded corners overlap by 1 or more. Slides are opposite to the friction forces as nearly as the
    blocks allow.
    """
    normal = force[:, 0]
    corner = np.flatnonzero(normal > 1e-3 * normal.max(initial=0.0))
    if len(corner) == 0:
        return None
    weight = np.sqrt(normal[corner] / normal[corner].mean())
    none = np.zeros(len(corner))
    program = ProgramBuilder()
    motion = program.variable("motion", 6 * statics.free_count, quadratic=1e-6)
    scale = program.variable("slide by friction", len(corner), quadratic=1e-9)
    missing = program.variable("missing overlap", len(corner), quadratic=10.0 * weight**2)
    for axis in (1, 2):
        misfit = program.variable(f"misfit {axis}", len(corner), quadratic=1.0)
        slide = unit_wrenches(statics, corner, weight[:, None] * np.eye(3)[axis]).T
        against = weight * force[corner, axis]
        program.equal(f"slide {axis}", none, (motion, slide), (scale, against), (misfit, -1.0))
    gap = unit_wrenches(statics, corner, NORMAL).T
    program.at_most("overlap", none - 1.0, (motion, gap), (missing, -1.0))
    program.at_most("scale", none, (scale, -1.0))
    program.at_most("missing", none, (missing, -1.0))
    solution = program.build().solve()
    if solution.status is not ConicStatus.SOLVED:
        return None
    return solution.x[motion.place].reshape(-1, 6)


def slide_directions(moved: Floats) -> Floats:
    """Unit slides (k, 2) of relative displacements (k, 3); zero where there is none."""
    slide = np.linalg.norm(moved[:, 1:], axis=1)
    return moved[:, 1:] / np.where(slide > 0.0, slide, 1.0)[:, None]


def edge_of_friction(statics: Statics, moved: Floats) -> Floats:
    """Forces (k, 3) with unit normal part and the largest friction against the slide."""
    friction = -statics.friction[:, None] * slide_directions(moved)
    return np.concatenate([np.ones((len(moved), 1)), friction], axis=1)


def _nonnegative(matrix: sparse.csc_matrix, right: Floats) -> Floats | None:
    """Least squares with factors >= 0; None if that fails."""
    rows, columns = matrix.shape
    if rows * columns <= DENSE:
        try:
            return np.asarray(optimize.nnls(matrix.toarray(), right)[0])
        except RuntimeError:  # the active-set method may cycle; the interior-point method does not
            pass
    # the residual is a separate unknown, so the program stays sparse
    program = ProgramBuilder()
    factor = program.variable("factor", columns, quadratic=1e-9)
    rest = program.variable("rest", rows, quadratic=1.0)
    program.equal("balance", right, (factor, matrix), (rest, -1.0))
    program.at_most("sign", np.zeros(columns), (factor, -1.0))
    solution = program.build().solve()
    if solution.status is not ConicStatus.SOLVED:
        return None
    return _refined(matrix, right, np.maximum(solution.x[factor.place], 0.0))


def _refined(matrix: sparse.csc_matrix, right: Floats, factor: Floats) -> Floats:
    """The factors with their last digits corrected by least squares."""
    active = factor > 1e-7 * factor.max(initial=0.0)
    kept = np.where(active, factor, 0.0)
    rest = right - matrix @ kept
    if not active.any() or np.linalg.norm(rest) > 1e-4 * np.linalg.norm(right):
        return factor
    change = lsmr(matrix[:, active], rest, atol=1e-15, btol=1e-15, conlim=1e12, maxiter=2000)[0]
    kept[active] = np.maximum(kept[active] + change, 0.0)
    better = np.linalg.norm(matrix @ kept - right) < np.linalg.norm(matrix @ factor - right)
    return kept if better else factor


def wrenches_along(statics: Statics, corner: Ints, direction: Floats) -> tuple[Ints, Floats]:
    """Wrenches of unit forces at corners: rows (c, 12), negative for a fixed block, and values.

    Parameters
    ----------
    statics
    corner : (c,)
    direction : (c, 3) or (3,) local n, u, v
    """
    entries = statics.transfers.reshape(-1, 12, 3)[corner]
    along = np.broadcast_to(direction, (len(corner), 3))
    rows = (6 * statics.blocks[corner][:, :, None] + np.arange(6)).reshape(-1, 12)
    return rows, (entries @ along[:, :, None])[:, :, 0]


def unit_wrenches(statics: Statics, corner: Ints, direction: Floats) -> Any:
    """The same as a sparse matrix (6 n, c); its transpose gives displacements along a direction."""
    row, value = wrenches_along(statics, corner, direction)
    meets = row >= 0
    shape = 6 * statics.free_count, len(corner)
    return sparse.csr_matrix((value[meets], (row[meets], np.nonzero(meets)[0])), shape=shape)
