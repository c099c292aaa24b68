"""Convex quadratic programs over second-order cones, by Clarabel.

    minimise  1/2 x' P x + c' x   subject to  A x + s = b,  s in a product of cones

Source of the method: Goulart and Chen 2024 (Clarabel).
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any

import clarabel
import numpy as np
from scipy import sparse

from drystone.base.arrays import Floats
from drystone.base.settings import Options


class ConicStatus(enum.Enum):
    """Status reported by a back end; results are checked before use."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    FAILED = "failed"


@dataclass(frozen=True)
class Cones:
    """Cones of the rows, in this order.

    Attributes
    ----------
    zero
        Number of equality rows.
    nonnegative
        Number of rows with s >= 0.
    second_order
        Size of each second-order cone; its first row is the bound.
    """

    zero: int = 0
    nonnegative: int = 0
    second_order: tuple[int, ...] = ()


@dataclass(frozen=True)
class ConicOptions(Options):
    """Settings of the interior point.

    Attributes
    ----------
    tolerance
        Relative feasibility, dimensionless; 1e-9 is close to what doubles allow.
    gap
        Relative distance from the optimum; the same as ``tolerance`` when left out. If any feasible
        point is sufficient, a coarse gap saves a third of the steps.
    iteration_limit
    time_limit_s
    """

    tolerance: float = 1e-9
    gap: float | None = None
    iteration_limit: int = 200
    time_limit_s: float = float("inf")

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_unless_positive("tolerance", "gap")
        self._refuse_below(1, "iteration_limit")
        self._refuse_below(0.0, "time_limit_s")


@dataclass(frozen=True, eq=False)
class ConicSolution:
    """Primal x and dual z; when infeasible, z is the certificate: A'z = 0, b'z < 0."""

    status: ConicStatus
    x: Floats
    z: Floats
    iterations: int
    solver: str
    message: str


def prepared(
    quadratic: Floats,
    linear: Floats,
    matrix: Any,
    right: Floats,
    cones: Cones,
    options: ConicOptions | None = None,
) -> Any:
    """A solver of a conic program; its method ``update`` changes entries.

    Parameters
    ----------
    quadratic, linear : (x,)
        Of the quadratic part its diagonal.
    matrix : (r, x) sparse
    right : (r,)
    cones
        Cones of the r rows, in the order of :class:`Cones`.
    options
    """
    chosen = options if options is not None else ConicOptions()
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = chosen.iteration_limit
    settings.tol_feas = chosen.tolerance
    settings.tol_gap_abs = settings.tol_gap_rel = chosen.gap or chosen.tolerance
    settings.tol_infeas_abs = settings.tol_infeas_rel = chosen.tolerance
    settings.max_threads = 1
    if np.isfinite(chosen.time_limit_s):
        settings.time_limit = max(chosen.time_limit_s, 1e-3)
    flat = (clarabel.ZeroConeT, cones.zero), (clarabel.NonnegativeConeT, cones.nonnegative)
    kinds = [kind(count) for kind, count in flat if count]
    kinds.extend(clarabel.SecondOrderConeT(size) for size in cones.second_order)
    size = len(quadratic)
    place = np.arange(size + 1)
    upper = sparse.csc_matrix((quadratic, place[:-1], place), shape=(size, size))
    return clarabel.DefaultSolver(upper, linear, sparse.csc_matrix(matrix), right, kinds, settings)


def solution(solver: Any, stop: Callable[[], bool] | None = None) -> ConicSolution:
    """The solution by a solver.

    Parameters
    ----------
    solver
    stop
        Called at every step with Clarabel 0.11 and later; True ends the program as FAILED. An
        exception in it, or Ctrl-C, is raised from here at the next step.
    """
    raw = _watched(solver, stop)
    name = str(raw.status)
    known = {
        "Solved": ConicStatus.SOLVED,
        "PrimalInfeasible": ConicStatus.INFEASIBLE,
        "DualInfeasible": ConicStatus.UNBOUNDED,
    }
    status = known.get(name.removeprefix("Almost"), ConicStatus.FAILED)
    x, z = np.asarray(raw.x), np.asarray(raw.z)
    solver_name = f"clarabel {clarabel.__version__}"
    return ConicSolution(status, x, z, int(raw.iterations), solver_name, name)


def _watched(solver: Any, stop: Callable[[], bool] | None) -> Any:
    """The solution of a solver that asks at every step whether to continue.

    Clarabel prints and discards exceptions of its callback, so none may leave it. Python handles a
    signal at the next instruction, which in a function comes before any ``try``. A generator
    resumes inside its ``try``.
    """
    raised: list[BaseException] = []

    def answers() -> Generator[bool, object, None]:
        answer = False
        while True:
            try:
                yield answer
                answer = bool(raised) or (stop is not None and stop())
            except GeneratorExit:
                return
            except BaseException as error:  # raised again below
                raised.append(error)
                answer = True

    asking = answers()
    next(asking)
    if hasattr(solver, "set_termination_callback"):
        solver.set_termination_callback(asking.send)
    raw = solver.solve()
    if raised:
        raise raised[0]
    return raw
