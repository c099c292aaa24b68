"""Compliant blocks whose supports move: a convex program per step of a fixed point.

::

    minimise  1/2 f' C f + d0 . f   subject to   A f = -p,  fn >= 0,  |ft| <= g

C is the compliance of the corners and d0 the displacement that the supports impose there. The
multiplier q of equilibrium is the motion of the blocks, and ``d = A'q + d0`` obeys
``fn (d_n + C fn) = 0``, ``d_n + C fn >= 0``, friction against the slide and no dilatancy. Coulomb's
law is the fixed point ``g = mu fn``. Source: Panagiotopoulos 1975 (the fixed point); Haslinger,
Hlavacek and Necas 1996.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from drystone.arrays import Floats
from drystone.solvers.conic import Cones, ConicOptions, ConicSolution, ConicStatus, solve_conic
from drystone.statics import Statics

SOFTEST = 0.05
"""Corners of less tributary area than this share of the mean are as stiff as that: slivers would
spoil the conditioning."""
TANGENTIAL = 0.1
"""Tangential by normal stiffness, chosen as in the search for a rest state."""


@dataclass(frozen=True, eq=False)
class ResponseSolution:
    """Scaled answer.

    Attributes
    ----------
    force : (k, 3)
    motion : (n, 6) of the free blocks
    steps
        Of the fixed point.
    defect
        Largest excess of friction over ``mu fn`` or change of the bound, by the mean load.
    raw
    """

    force: Floats
    motion: Floats
    steps: int
    defect: float
    raw: ConicSolution


def solve_response(
    statics: Statics,
    imposed: Floats,
    *,
    compliance: float,
    tolerance: float = 1e-7,
    step_limit: int = 60,
    options: ConicOptions | None = None,
) -> ResponseSolution:
    """Forces and motion under the loads of ``statics`` and a motion of the supports.

    Parameters
    ----------
    statics
    imposed : (k, 3)
        Displacement of b against a at each corner that the supports impose, local n, u, v, by the
        unit of displacement.
    compliance
        Overlap of a corner of mean area under the mean load, by the unit of displacement.
    tolerance
        On the fixed point, by the mean load.
    step_limit
    options
    """
    k = statics.corner_count
    softness = compliance / np.maximum(statics.tributary, SOFTEST)
    diagonal = np.stack([softness, softness / TANGENTIAL, softness / TANGENTIAL], axis=1)
    quadratic = sparse.diags(diagonal.ravel())
    balance = statics.matrix
    one = sparse.identity(k, format="csr")
    pressing = sparse.kron(one, np.array([[-1.0, 0.0, 0.0]]))
    slide = np.array([[0.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    matrix = sparse.vstack([balance, pressing, sparse.kron(one, slide)], format="csc")
    cones = Cones(balance.shape[0], k, (3,) * k)
    right = np.concatenate([-statics.load.ravel(), np.zeros(4 * k)])
    bounds = slice(balance.shape[0] + k, None, 3)
    bound = _associative(statics, quadratic, imposed, options)
    step, defect = 0, float("inf")
    relaxation, last = 1.0, float("inf")
    while True:
        step += 1
        right[bounds] = bound
        raw = solve_conic(quadratic, imposed.ravel(), matrix, right, cones, options)
        if raw.status is not ConicStatus.SOLVED:
            break
        target = statics.friction * np.maximum(0.0, raw.x.reshape(k, 3)[:, 0])
        defect = float(np.abs(target - bound).max(initial=0.0))
        if defect <= tolerance or step >= step_limit:
            break
        relaxation = max(0.1, 0.5 * relaxation) if defect > last else min(1.0, 1.2 * relaxation)
        last = defect
        bound = bound + relaxation * (target - bound)
    motion = raw.z[: balance.shape[0]].reshape(-1, 6)
    return ResponseSolution(raw.x.reshape(k, 3), motion, step, defect, raw)


def _associative(
    statics: Statics, quadratic: sparse.spmatrix, imposed: Floats, options: ConicOptions | None
) -> Floats:
    """A first bound (k,) on friction: that of joints which open as they slide."""
    k = statics.corner_count
    cone = np.diag([0.0, -1.0, -1.0])
    axis = np.zeros((3, 3))
    axis[0, 0] = -1.0
    one = sparse.identity(k, format="csr")
    rows = sparse.kron(sparse.diags(statics.friction), axis) + sparse.kron(one, cone)
    frictionless = sparse.kron(one, np.array([[-1.0, 0.0, 0.0]]))
    matrix = sparse.vstack([statics.matrix, frictionless, rows], format="csc")
    right = np.concatenate([-statics.load.ravel(), np.zeros(4 * k)])
    cones = Cones(statics.matrix.shape[0], k, (3,) * k)
    raw = solve_conic(quadratic, imposed.ravel(), matrix, right, cones, options)
    if raw.status is not ConicStatus.SOLVED:
        return np.zeros(k)
    return statics.friction * np.maximum(0.0, raw.x.reshape(k, 3)[:, 0])


__all__ = ["ResponseSolution", "solve_response"]
