"""The question of RBE by open convex solvers, on matrices that were made before.

Less is asked than of a check: whether any forces balance the loads. PIQP
(``pip install "drystone[benchmarks]"``) has a pyramid of eight sides for each cone of friction,
Clarabel the cones.
"""

from __future__ import annotations

import time

import numpy as np
from scipy import sparse

from drystone import Model
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import build_equilibrium
from drystone.mechanics.statics import build_statics
from drystone.solvers.program import prepared, solution

WEIGHT = 1e-3
"""Of the squared forces, as solvers of quadratic programs like some."""

Said = tuple[str, float]
"""What a solver says, and its time [s]."""


def by_piqp(model: Model) -> Said:
    """With the pyramids."""
    import piqp  # optional: what the times are compared with

    if model.assembly.fixed.all():
        return "solved", 0.0
    program = build_equilibrium(build_statics(model), cone=FrictionCone.octagon())
    equal, matrix = program.cones.zero, sparse.csr_matrix(program.matrix)
    cost = sparse.csc_matrix(sparse.diags(np.full(matrix.shape[1], WEIGHT)))
    balance, friction = (sparse.csc_matrix(one) for one in (matrix[:equal], matrix[equal:]))
    right = program.right[equal:]
    began = time.thread_time()
    solver = piqp.SparseSolver()
    solver.setup(
        cost, np.zeros(matrix.shape[1]), balance, program.right[:equal], friction,
        np.full(len(right), -np.inf), right,
    )  # fmt: skip
    status = solver.solve()
    said = status.name.removeprefix("PIQP_").lower()
    return said, time.thread_time() - began


def by_clarabel(model: Model) -> Said:
    """With the cones."""
    program = build_equilibrium(build_statics(model), cone=FrictionCone.exact())
    none = np.zeros(program.matrix.shape[1])
    matrix = sparse.csc_matrix(program.matrix)
    began = time.thread_time()
    solver = prepared(none + WEIGHT, none, matrix, program.right, program.cones)
    return solution(solver).status.value, time.thread_time() - began
