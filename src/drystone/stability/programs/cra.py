"""Coupled rigid-block analysis, eq. 5.6 of the source."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Unpack

import numpy as np

from drystone.base.arrays import Floats, frozen_floats
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import Options, checked_call
from drystone.base.workers import WorkerPool
from drystone.checks import check_forces, corner_motion
from drystone.formulations.coupled import equal_overlap
from drystone.formulations.improvement import CompatibleState, improve
from drystone.formulations.rest import compliance
from drystone.formulations.rest.interior_point import find_rest
from drystone.formulations.rest.rest_state import RestOptions
from drystone.formulations.stiffness_range import stiffness_ratio
from drystone.io.opening import Given, How, as_model
from drystone.results import Residuals, Result, Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.verdict.cascade import Cascade
from drystone.stability.verdict.search_starts import SEARCH_LIMIT, StateSearch


@dataclass(frozen=True)
class CRAOptions(Options):
    """Options of :func:`solve_cra`.

    Attributes
    ----------
    tolerance
        Largest residual of every condition, equal overlap included.
    slide_limit
        eta / eps: largest displacement of a corner by the overlap. The source uses 10 to 1000; a
        fine mesh needs more than a coarse one.
    slips
        Slip lengths of the friction law, by the local overlap, tried one after another.
    """

    tolerance: float = 1e-6
    slide_limit: float = 1000.0
    slips: tuple[float, ...] = (1.0, 10.0, 0.1)

    def __post_init__(self) -> None:
        super().__post_init__()
        frozen_floats(self.slips, (None,), "slips")
        if not all(value > 0.0 for value in (self.tolerance, *self.slips)):
            raise InputError(
                f"the tolerance is {self.tolerance}, slip lengths are {self.slips}",
                remedy="give more than 0",
            )
        if not self.slide_limit >= 0.0:
            raise InputError(f"the slide limit is {self.slide_limit}", remedy="give 0 or more")


@dataclass(frozen=True, eq=False)
class _OverlapState:
    force: Floats
    displacement: Floats
    residuals: Residuals
    slide: float
    stiffness_ratio: float
    iterations: int


@checked_call
@one_blas_thread()
def solve_cra(
    given: Given,
    *,
    options: CRAOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Result:
    """Forces and a virtual motion with equal overlaps wherever force passes (eq. 5.6).

    Stricter than :func:`check`: where a structure comes to rest but eq. 5.6 is not met, the verdict
    is that of the rest state and the message says both.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options

    Returns
    -------
    Result
        ``method`` is ``cra`` where eq. 5.6 is met and ``rest`` or ``check`` where it is not;
        ``eta`` is the largest displacement of a corner, by the overlap.

    Raises
    ------
    InputError
        What was given cannot be made into a model.
    """
    chosen = CRAOptions.of(options)
    clock = Clock(time_limit_s, stop)
    problem = Problem.build(as_model(given, **how))
    problem.model.require_dry(
        "coupled rigid-block analysis", "eq. 5.6 is for joints that only press and rub"
    )
    shimmed = CheckOptions(samples=2, settle=False, search=True)
    with WorkerPool(executor) as pool:
        base = Cascade(problem, shimmed, progress, clock, pool.executor).run()
        if base.verdict is not Verdict.STABLE or problem.statics.free_count == 0:
            method = "cra" if base.verdict is Verdict.UNSTABLE else "check"
            return replace(base, method=method, options=chosen, time_s={"solve": clock.elapsed_s})
        if progress is not None:
            progress("equal overlaps", 0, 1)
        best = _best(_states(problem, base, chosen, clock, pool), chosen, clock)
    time_s = {"solve": clock.elapsed_s}
    if best is None or best.residuals.largest > chosen.tolerance:
        left = f" (best: {best.residuals.largest:.1e})" if best is not None else ""
        message = f"it comes to rest, but no state with equal overlaps was found{left}"
        if clock.late():
            message += f" before {clock.reason}"
        return replace(
            base,
            method="rest",
            message=message,
            stopped=clock.reason,
            options=chosen,
            time_s=time_s,
        )
    message = f"stands, eq. 5.6 is met; the largest displacement is {best.slide:.3g} overlaps"
    if best.slide > chosen.slide_limit:
        message += f", more than the {chosen.slide_limit:g} asked for"
    return replace(
        base,
        method="cra" if best.slide <= chosen.slide_limit else "rest",
        message=message,
        force=best.force,
        displacement=best.displacement,
        residuals=best.residuals,
        eta=best.slide,
        stiffness_ratio=None if base.stiffness_ratio is None else best.stiffness_ratio,
        stopped=clock.reason,
        options=chosen,
        solver="equal-overlap path",
        iterations=base.iterations + best.iterations,
        time_s=time_s,
    )


def _best(
    states: Iterator[_OverlapState], options: CRAOptions, clock: Clock
) -> _OverlapState | None:
    """The first state that meets all conditions; the best one where none does."""
    best: _OverlapState | None = None
    for state in states:
        if best is None or _worst(state, options) < _worst(best, options):
            best = state
        if best.residuals.largest <= options.tolerance and best.slide <= options.slide_limit:
            break
        if clock.late():
            break
    return best


def _worst(state: _OverlapState, options: CRAOptions) -> tuple[bool, float, float]:
    met = state.residuals.largest <= options.tolerance
    return (not met, 0.0 if met else state.residuals.largest, state.slide)


def _states(
    problem: Problem, base: Result, options: CRAOptions, clock: Clock, pool: WorkerPool
) -> Iterator[_OverlapState]:
    """Candidates for eq. 5.6: the equal-overlap path per slip length, convex steps, the search."""
    statics = problem.statics
    # the path of equal overlaps starts best from a state that the relaxed law led to
    loose = RestOptions(ground=1e-8, tolerance=1e-8, polish=1e-7)
    for slip in options.slips:
        start = find_rest(
            problem.system, compliance.uniform(statics, slip=slip), loose, stop=clock.late
        )
        if problem.ground_share(start.ground).max() > 0.1 or clock.late():
            continue
        path = equal_overlap(problem.system, start, slip, stop=clock.late)
        yield _examined(problem, path.state.motion, path.state.force, path.iterations)
    if statics.corner_count <= SEARCH_LIMIT and base.displacement is not None:
        motion = statics.scaled_motion(base.displacement, statics.mean_length)
        found = improve(statics, motion, stop=clock.late)
        yield _examined(problem, found.motion, found.force, found.iterations)
    for found in StateSearch(problem, clock, pool=pool).equal_overlap_states():
        yield _examined(problem, found.motion, found.force, found.iterations)


def _examined(problem: Problem, motion: Floats, force: Floats, iterations: int) -> _OverlapState:
    physical, displacement = problem.force(force), problem.displacement(motion)
    residuals = check_forces(problem.model, physical, displacement)
    moved = corner_motion(problem.model.assembly, problem.model.contacts, displacement)
    normal = physical[:, 0]
    loaded = normal > 1e-7 * normal.max(initial=0.0)
    overlap = -moved[loaded, 0]
    mean = float(overlap.mean()) if len(overlap) and overlap.mean() > 0.0 else 1.0
    spread = float(np.abs(overlap / mean - 1.0).max(initial=0.0))
    deeper = float((np.maximum(0.0, -moved[:, 0] / mean - 1.0)).max(initial=0.0))
    slide = float(np.abs(moved[problem.corners]).max(initial=0.0)) / mean
    return _OverlapState(
        physical,
        displacement,
        replace(residuals, overlap=max(spread, deeper)),
        slide,
        stiffness_ratio(problem.statics, CompatibleState(motion, force, 0.0, iterations)),
        iterations,
    )
