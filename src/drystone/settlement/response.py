"""Compliant blocks whose supports move: a convex program per step of a fixed point.

::

    minimise  1/2 f' C f + d0 . f   subject to   A f = -p,  fn >= 0,  |ft| <= g

C is the compliance of the corners and d0 the displacement there due to the supports. The
multiplier q of equilibrium is the motion of the blocks, and ``d = A'q + d0`` obeys
``fn (d_n + C fn) = 0``, ``d_n + C fn >= 0``, friction against the slide and no dilatancy. Coulomb's
law is the fixed point ``g = mu fn``. Source: Panagiotopoulos 1975 (the fixed point); Haslinger,
Hlavacek and Necas 1996.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse

from drystone.base.arrays import Floats
from drystone.mechanics.bodies import LEAST_AREA
from drystone.mechanics.statics import Statics
from drystone.solvers.program import ConicProgram, ConicSolution, ConicStatus, ProgramBuilder

TANGENTIAL = 0.1
"""Tangential stiffness divided by normal stiffness. Chosen as in the search for a rest state."""


@dataclass(frozen=True, eq=False)
class ResponseSolution:
    """Scaled answer.

    Attributes
    ----------
    force : (k, 3)
    motion : (n, 6) of the free blocks
    steps
        Steps of the fixed-point iteration.
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
    """
    k = statics.corner_count
    softness = compliance / np.maximum(statics.tributary, LEAST_AREA)
    diagonal = np.stack([softness, softness / TANGENTIAL, softness / TANGENTIAL], axis=1)
    costs = {"linear": imposed.ravel(), "quadratic": diagonal.ravel()}
    program = _program(statics, np.zeros(k), costs)
    friction = program.rows["friction"]
    bounds = slice(friction.start, friction.stop, 3)
    right = program.right.copy()
    bound = _associative(statics, costs)
    relaxation, last, defect = 1.0, float("inf"), float("inf")
    for step in range(1, step_limit + 1):  # noqa: B007 - counted
        right[bounds] = bound
        raw = replace(program, right=right).solve()
        if raw.status is not ConicStatus.SOLVED:
            break
        target = statics.friction * np.maximum(0.0, raw.x.reshape(k, 3)[:, 0])
        defect = float(np.abs(target - bound).max(initial=0.0))
        if defect <= tolerance:
            break
        relaxation = max(0.1, 0.5 * relaxation) if defect > last else min(1.0, 1.2 * relaxation)
        last = defect
        bound = bound + relaxation * (target - bound)
    motion = raw.z[program.rows["equilibrium"]].reshape(-1, 6)
    return ResponseSolution(raw.x.reshape(k, 3), motion, step, defect, raw)


def _program(statics: Statics, coupling: Floats, costs: Mapping[str, Any]) -> ConicProgram:
    """Forces in equilibrium with friction of at most ``coupling`` times the normal force."""
    k = statics.corner_count
    one = sparse.identity(k, format="csr")
    axis = np.zeros((3, 3))
    axis[0, 0] = -1.0
    slide = sparse.kron(one, np.diag([0.0, -1.0, -1.0]))
    program = ProgramBuilder()
    force = program.variable("force", 3 * k, **costs)
    program.equal("equilibrium", -statics.load.ravel(), (force, statics.matrix))
    program.at_most("no pull", np.zeros(k), (force, sparse.kron(one, np.array([[-1.0, 0.0, 0.0]]))))
    bound = sparse.kron(sparse.diags(coupling), axis)
    program.cone("friction", 3, np.zeros(3 * k), (force, bound + slide))
    return program.build()


def _associative(statics: Statics, costs: Mapping[str, Any]) -> Floats:
    """A first bound (k,) on friction: that of joints that open when they slide."""
    raw = _program(statics, statics.friction, costs).solve()
    if raw.status is not ConicStatus.SOLVED:
        return np.zeros(statics.corner_count)
    return statics.friction * np.maximum(0.0, raw.x.reshape(-1, 3)[:, 0])
