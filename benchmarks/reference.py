"""Eq. 5.6 as it is written, given to a general nonlinear solver: a cross-check, not the engine.

    minimise  |fn|^2 + |alpha|^2
    subject to  A f + p = 0,  |ft| <= mu fn,  fn (dn + 1) = 0,  dn + 1 >= 0,
                ft = -alpha dt,  alpha >= 0,  fn >= 0,  |d| <= eta,   d = A' q

in scaled units, displacements by the overlap. Source: Kao et al. 2022, eq. 5.6; solved by IPOPT
(Waechter and Biegler 2006) through CasADi (Andersson et al. 2019), the extra ``reference``.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Unpack

import numpy as np

from benchmarks.shims.compatible import compatible_motion
from drystone.base.errors import InputError, MissingDependency
from drystone.base.settings import Clock
from drystone.checks import check_forces
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import solve_equilibrium
from drystone.io.opening import Given, How, as_model
from drystone.results import Result, Verdict
from drystone.stability.problem import Problem

LARGEST = 400
"""Corners of the largest model taken, some 50 blocks: beyond it the solver rarely ends."""


@dataclass(frozen=True)
class ReferenceOptions:
    """Options of :func:`solve_cra_reference`.

    Attributes
    ----------
    slide_limit
        eta / eps.
    tolerance
        Of the nonlinear solver, and largest residual of an answer.
    iteration_limit
    """

    slide_limit: float = 1000.0
    tolerance: float = 1e-7
    iteration_limit: int = 2000


def solve_cra_reference(
    given: Given,
    *,
    options: ReferenceOptions | None = None,
    **how: Unpack[How],
) -> Result:
    """Eq. 5.6 by an off-the-shelf interior point, for models of up to about 50 blocks.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options

    Returns
    -------
    Result
        STABLE where the solver found a state and it passes our checks at ``tolerance``; UNDECIDED
        otherwise, for a local solver that fails proves nothing.

    Raises
    ------
    MissingDependency
        CasADi is not installed.
    InputError
        The model is too large.
    """
    chosen = options if options is not None else ReferenceOptions()
    try:
        import casadi  # optional: only for those who want the cross-check
    except ImportError as error:
        raise MissingDependency("casadi", extra="reference", purpose="the reference") from error
    clock = Clock(float("inf"))
    problem = Problem.build(as_model(given, **how))
    problem.model.require_dry("the reference", "eq. 5.6 is for joints that only press and rub")
    corners = problem.statics.corner_count
    if corners > LARGEST:
        raise InputError(
            f"the reference takes {LARGEST} interface corners, the model has {corners}",
            remedy="use solve_cra",
        )
    force, motion, message = _solve(casadi, problem, chosen)
    physical, displacement = problem.force(force), problem.displacement(motion)
    residuals = check_forces(problem.model, physical, displacement)
    met = residuals.largest <= 10.0 * chosen.tolerance
    return Result(
        method="cra-reference",
        verdict=Verdict.STABLE if met else Verdict.UNDECIDED,
        model=problem.model,
        message=f"the nonlinear solver ended with '{message}'",
        force=physical if met else None,
        displacement=displacement if met else None,
        residuals=residuals,
        options=chosen,
        solver=f"ipopt through casadi {version('casadi')}",
        time_s={"solve": clock.elapsed_s},
    )


def _solve(casadi: Any, problem: Problem, options: ReferenceOptions) -> tuple[Any, Any, str]:
    """Forces (k, 3), motions (n, 6) and what the solver said."""
    statics = problem.statics
    k, n = statics.corner_count, statics.free_count
    matrix = casadi.DM(statics.matrix.tocsc())
    fn, alpha, q = casadi.SX.sym("fn", k), casadi.SX.sym("alpha", k), casadi.SX.sym("q", 6 * n)
    moved = casadi.reshape(casadi.mtimes(matrix.T, q), 3, k).T
    gap, slide = moved[:, 0], moved[:, 1:]
    tangential = -casadi.repmat(alpha, 1, 2) * slide
    force = casadi.horzcat(fn, tangential)
    balance = casadi.mtimes(matrix, casadi.reshape(force.T, 3 * k, 1)) + casadi.DM(
        statics.load.ravel()
    )
    friction = casadi.DM(statics.friction)
    cone = (friction * fn) ** 2 - casadi.sum2(tangential**2)
    touching = fn * (gap + 1.0)
    equal, least = casadi.vertcat(balance, touching), casadi.vertcat(cone, gap + 1.0)
    far = casadi.reshape(moved, 3 * k, 1)
    rows = casadi.vertcat(equal, least, far)
    limit = options.slide_limit
    lower = np.concatenate([np.zeros(6 * n + k), np.zeros(2 * k), np.full(3 * k, -limit)])
    upper = np.concatenate([np.zeros(6 * n + k), np.full(2 * k, np.inf), np.full(3 * k, limit)])
    start = solve_equilibrium(statics, cone=FrictionCone.exact())
    motion = compatible_motion(statics, start.force)
    guess = np.zeros(6 * n) if motion is None else motion.ravel()
    solver = casadi.nlpsol(
        "cra",
        "ipopt",
        {
            "x": casadi.vertcat(fn, alpha, q),
            "f": casadi.sumsqr(fn) + casadi.sumsqr(alpha),
            "g": rows,
        },
        {
            "print_time": False,
            "ipopt": {
                "print_level": 0,
                "sb": "yes",
                "tol": options.tolerance,
                "constr_viol_tol": 0.1 * options.tolerance,
                "max_iter": options.iteration_limit,
            },
        },
    )
    answer = solver(
        x0=np.concatenate([np.maximum(start.force[:, 0], 1e-3), np.full(k, 0.1), guess]),
        lbx=np.concatenate([np.zeros(2 * k), np.full(6 * n, -np.inf)]),
        ubx=np.full(2 * k + 6 * n, np.inf),
        lbg=lower,
        ubg=upper,
    )
    x = np.asarray(answer["x"]).ravel()
    found = x[2 * k :].reshape(-1, 6)
    slides = statics.displacement(found)[:, 1:]
    forces = np.concatenate([x[:k, None], -x[k : 2 * k, None] * slides], axis=1)
    return forces, found, str(solver.stats()["return_status"])
