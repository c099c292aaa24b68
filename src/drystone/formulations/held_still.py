"""Corners that hardly move in a mechanism of an interior-point method are held still."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import lsmr

from drystone.base.arrays import Floats
from drystone.formulations.equilibrium import EquilibriumSolution
from drystone.mechanics.statics import Statics
from drystone.solvers.dense_factor import inverse

STILL = 1e-4
"""A corner that opens or slides by less than this share of the fastest one counts as fixed, if the
result is a mechanism. Chosen: on 11 tilted shelves all values from 1e-5 to 3e-2 give a
mechanism."""

DIRECT = 600
"""Unknowns up to which a full matrix is factorised. LSMR takes hundreds of steps on an arch of 38
blocks."""

SLIGHT = 1e-10
"""Weight, by the largest diagonal, that makes that matrix regular."""


def held_still(statics: Statics, solution: EquilibriumSolution) -> EquilibriumSolution:
    """The nearest velocity at which nearly fixed corners are fixed.

    The solution of an interior-point method lies strictly inside the cone of mechanisms. For blocks
    between parallel faces this cone has no interior. There the solver leaves small motions at
    corners that do not move.
    """
    moved = np.abs(statics.displacement(solution.multiplier)).max(axis=1)
    still = np.flatnonzero(moved < STILL * moved.max(initial=0.0))
    rows = statics.matrix_transposed[(3 * still[:, None] + np.arange(3)).ravel()]
    motion = solution.multiplier.ravel()
    if len(still) and len(motion) <= DIRECT:
        motion = _without(rows, motion)
    elif len(still):
        seen = rows @ motion
        motion = motion - lsmr(rows, seen, atol=1e-15, btol=1e-15, conlim=1e12, maxiter=2000)[0]
    return replace(solution, multiplier=motion.reshape(-1, 6))


def _without(rows: sparse.csr_matrix, motion: Floats) -> Floats:
    """The nearest motion (u,) that the rows (r, u) take to zero.

    Each pass takes off all but a small share of what the rows still see.
    """
    matrix = (rows.T @ rows).toarray(order="C")
    matrix.reshape(-1)[:: len(motion) + 1] += SLIGHT * matrix.diagonal().max()
    solve = inverse(matrix)
    for _ in range(3):
        motion = motion - solve(rows.T @ (rows @ motion))
    return motion
