"""Elastic linear program: forces compatible with a motion, on joints of bounded stiffness.

At each chosen corner the overlap o is given. The unknowns are the normal force n and the shear t
against the slide:

    o <= n <= ratio o,    0 <= t <= mu n + w c,    A f + p = r+ - r-

The cohesion c and the unbalanced load r are slack variables, w is the load of the lighter block.
The program minimises c plus the elastic weight times r by the load. At zero the forces are exact.
Within a trust region the motion may change as well; the rows are then linearised about it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from benchmarks.shims.compatible import NORMAL, slide_directions, unit_wrenches
from benchmarks.shims.improvement import add_trust_region, turned_friction
from drystone.base.arrays import Floats, Ints
from drystone.mechanics.statics import Statics
from drystone.solvers.program import ConicOptions, ConicStatus, ProgramBuilder, Term

ELASTIC_WEIGHT = 3.0
"""Cost of unbalanced load, relative to the load of its block; cohesion costs 1. Chosen."""


@dataclass(frozen=True, eq=False)
class TrustRegion:
    """Bound of the change of motion.

    Attributes
    ----------
    force : (k, 3)
        Present forces; their friction rotates with the slides.
    share
        Permitted change of a slide, as a share of it.
    """

    force: Floats
    share: float


@dataclass(frozen=True, eq=False)
class ElasticForces:
    """Solution of the elastic program.

    Attributes
    ----------
    change : (n, 6) of the motion; none where the motion is held
    normal, shear : (c,) at the chosen corners
    infeasibility
        Cohesion plus the elastic weight times the unbalanced load; 0 is an exact solution.
    """

    change: Floats
    normal: Floats
    shear: Floats
    infeasibility: float


def elastic_forces(
    statics: Statics,
    moved: Floats,
    corner: Ints,
    ratio: float,
    region: TrustRegion | None = None,
    *,
    tolerance: float = 1e-10,
    stop: Callable[[], bool] | None = None,
) -> ElasticForces | None:
    """Forces with the least infeasibility and, within a trust region, a change of motion.

    Parameters
    ----------
    statics
    moved : (k, 3)
        Corner displacements, in units in which the softest joint has a stiffness of 1.
    corner : (c,)
        Corners in compression. The others stay open.
    ratio
        Largest stiffness by the smallest.
    region
        When left out, the motion is fixed.
    tolerance
        Relative tolerance of the program.
    stop

    Returns
    -------
    ElasticForces
        None if the program fails.
    """
    none = np.zeros(len(corner))
    overlap = np.maximum(-moved[corner, 0], 0.0)
    direction = slide_directions(moved)[corner]
    closing = unit_wrenches(statics, corner, NORMAL)
    along = unit_wrenches(statics, corner, np.column_stack([none, direction]))
    load_of_corner = statics.corner_load[corner]
    weight = np.repeat(ELASTIC_WEIGHT / statics.load_scale, 6)
    program = ProgramBuilder()
    change = None
    if region is not None:
        change = program.variable("change", 6 * statics.free_count, quadratic=1e-10)
    normal = program.variable("normal", len(corner), quadratic=1e-10)
    shear = program.variable("shear", len(corner), quadratic=1e-10)
    cohesion = program.variable("cohesion", 1, linear=1.0)
    slack = [
        program.variable(f"unbalanced {sign}", 6 * statics.free_count, linear=weight)
        for sign in ("up", "down")
    ]
    balance: list[Term] = [(normal, closing), (shear, -along), (slack[0], 1.0), (slack[1], -1.0)]
    least: list[Term] = [(normal, -1.0)]
    most: list[Term] = [(normal, 1.0)]
    if region is not None and change is not None:
        slide = np.linalg.norm(moved[corner, 1:], axis=1) + 1e-12
        held = np.linalg.norm(region.force[corner, 1:], axis=1) / slide
        balance.append((change, turned_friction(statics, moved, corner, held)))
        least.append((change, -closing.T))
        most.append((change, closing.T * ratio))
        add_trust_region(program, statics, change, corner, slide, region.share)
        others = np.setdiff1d(np.arange(statics.corner_count), corner)
        opening = -unit_wrenches(statics, others, NORMAL).T
        program.at_most("open", np.maximum(moved[others, 0], 0.0), (change, opening))
    program.equal("balance", -statics.load.ravel(), *balance)
    program.at_most("least shear", none, (shear, -1.0))
    program.at_most(
        "friction",
        none,
        (shear, 1.0),
        (normal, -statics.friction[corner]),
        (cohesion, -sparse.csr_matrix(load_of_corner[:, None])),
    )
    program.at_most("least stiffness", -overlap, *least)
    program.at_most("largest stiffness", ratio * overlap, *most)
    for variable in (cohesion, *slack):
        program.at_most(f"sign of {variable.name}", np.zeros(variable.count), (variable, -1.0))
    made = program.build()
    solution = made.solve(ConicOptions(tolerance=tolerance), stop=stop)
    if solution.status is not ConicStatus.SOLVED:
        return None
    x = solution.x
    moves = np.zeros((0, 6)) if change is None else x[change.place].reshape(-1, 6)
    return ElasticForces(moves, x[normal.place], x[shear.place], float(made.linear @ x))
