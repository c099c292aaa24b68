"""The mechanism nearest to the loads as a conic program, and corners of a mechanism held still."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from drystone.formulations.equilibrium import EquilibriumSolution
from drystone.mechanics.statics import Statics
from drystone.solvers.program import ConicOptions, ConicStatus, ProgramBuilder

STILL = 1e-4
"""A corner that opens or slides by less than this share of the fastest one counts as fixed, if the
result is a mechanism. Chosen: on 11 tilted shelves all values from 1e-5 to 3e-2 give a
mechanism."""

SLIGHT = 1e-10
"""Weight, by the largest diagonal, that makes the matrix of the fixed corners regular."""


def held_still(statics: Statics, solution: EquilibriumSolution) -> EquilibriumSolution:
    """The nearest velocity at which nearly fixed corners are fixed.

    The solution of an interior-point method lies strictly inside the cone of mechanisms. For blocks
    between parallel faces this cone has no interior. There the solver leaves small motions at
    corners that do not move.
    """
    moved = np.abs(statics.displacement(solution.multiplier)).max(axis=1)
    still = np.flatnonzero(moved < STILL * moved.max(initial=0.0))
    if not len(still):
        return solution
    rows = statics.matrix_transposed[(3 * still[:, None] + np.arange(3)).ravel()]
    normal = (rows.T @ rows).tocsc()
    slight = SLIGHT * normal.diagonal().max() * sparse.identity(normal.shape[0], format="csc")
    solve = splu(normal + slight).solve
    motion = solution.multiplier.ravel()
    for _ in range(3):  # each takes off all but a small share of what the rows still see
        motion = motion - solve(rows.T @ (rows @ motion))
    return replace(solution, multiplier=motion.reshape(-1, 6))


def project_on_mechanisms(
    statics: Statics, *, stop: Callable[[], bool] | None = None
) -> EquilibriumSolution | None:
    """The mechanism nearest to the loads; None if the solver fails.

    It is for dry joints; None where there are others.

    ::

        minimise  1/2 |v - p|^2   subject to   dn >= mu |dt| at every corner,  (dn, dt) = A' v

    It is zero where forces balance the loads. Otherwise it is a mechanism on which the loads do
    the work ``|v|^2``, and ``p - v`` is the nearest load that can be balanced (Moreau 1962: the
    cones of mechanisms and of balanced loads are polar).

    Parameters
    ----------
    statics
    stop
    """
    if not statics.dry:
        return None
    k = statics.corner_count
    scale = np.ones((k, 3))
    scale[:, 1:] = statics.friction[:, None]
    program = ProgramBuilder()
    velocity = program.variable(
        "velocity", 6 * statics.free_count, linear=-statics.load.ravel(), quadratic=1.0
    )
    opening = sparse.diags(scale.ravel()) @ statics.matrix_transposed
    program.cone("opening", 3, np.zeros(3 * k), (velocity, -opening))
    made = program.build()
    raw = made.solve(ConicOptions(tolerance=1e-10), stop=stop)
    if raw.status is not ConicStatus.SOLVED:
        return None
    force = scale * raw.z[made.rows["opening"]].reshape(-1, 3)
    motion = raw.x[velocity.place].reshape(-1, 6)
    return EquilibriumSolution(force, np.zeros(k), motion, raw)
