"""Coupled rigid-block analysis, eq. 5.6 of the source."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import lengths
from drystone.base.settings import Clock, Options, checked_call
from drystone.checks import check_forces, corner_motion
from drystone.io.opening import Given, LongHow, as_model
from drystone.mechanics import law
from drystone.mechanics.law import Compliance, FrictionBound, SlipLength
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions, RestState
from drystone.mechanics.statics import Statics
from drystone.results import Result, Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.asked import SAMPLES, Asked, CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.verdict import decided

LOADED = 1e-7
"""Share of the largest normal force from which on a corner counts as loaded."""

BEGUN = RestOptions(ground=1e-8, tolerance=1e-8, polish=1e-7)
"""The path of equal overlaps starts best from a state that the relaxed law led to."""

HANGS = 0.1
"""Share of a block's load on the ground from which on no path is followed."""


@dataclass(frozen=True)
class CRAOptions(Options):
    """Options of :func:`solve_cra`.

    Attributes
    ----------
    tolerance : > 0
        Largest residual of every condition, equal overlap included.
    slide_limit : >= 0
        eta / eps: largest motion d of a corner by the overlap. The source uses 10 to 1000; a fine
        mesh needs more than a coarse one.
    slips : > 0, < inf
        Slip lengths of the friction law, by the local overlap, tried one after another.
    """

    tolerance: float = 1e-6
    slide_limit: float = 1000.0
    slips: tuple[float, ...] = (1.0, 10.0, 0.1)


@checked_call
@one_blas_thread()
def solve_cra(given: Given, *, options: CRAOptions | None = None, **how: Unpack[LongHow]) -> Result:
    """Forces and a virtual motion with equal overlaps wherever force passes (eq. 5.6).

    A state is searched along the path of the loads; states that jam are not. Where none is found,
    the verdict is that of :func:`check`, which need not be that of CRA: what comes to rest without
    such a state is stable all the same, and what is undecided there is so here. The message says
    both.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options

    Returns
    -------
    Result
        ``method`` is ``cra`` where a state of eq. 5.6 was found within ``slide_limit``, else
        ``rest`` where it comes to rest, and ``check`` where not. ``displacement`` (n, 6) is the
        translation [m] and rotation [rad] of each block about its centroid, in the scale in which
        eps, the overlap, is the mean ``size`` of the free blocks. ``eta`` is the largest motion
        d of a corner, by eps.

    Raises
    ------
    InputError
        What was given cannot be made into a model.
    """
    chosen = CRAOptions.of(options)
    clock = Clock.of(how)
    problem = Problem.build(as_model(given, **how))
    problem.model.require_dry(
        "coupled rigid-block analysis", "eq. 5.6 is for joints that only press and rub"
    )
    best: Result | None = None
    for slip in chosen.slips if problem.statics.free_count else ():
        clock.tell("equal overlaps", chosen.slips.index(slip), len(chosen.slips))
        state = _with_equal_overlaps(problem, slip, clock)
        if state is not None and (best is None or _worst(state, chosen) < _worst(best, chosen)):
            best = state
        if clock.late() or (best is not None and _meets(best, chosen)):
            break
    told: dict[str, Any] = {
        "options": chosen,
        "stopped": clock.reason,
        "time_s": {"solve": clock.elapsed_s},
    }
    if best is not None and _left(best) <= chosen.tolerance:
        met = f"stands, eq. 5.6 is met; the largest displacement is {best.eta:.3g} overlaps"
        if _meets(best, chosen):
            return replace(best, message=met, **told)
        wider = f"{met}, more than the {chosen.slide_limit:g} asked for"
        return replace(best, method="rest", message=wider, **told)
    base = decided(Asked(problem, CheckOptions(samples=SAMPLES), clock))
    told |= {"stopped": clock.reason, "time_s": {"solve": clock.elapsed_s}}
    if not problem.statics.free_count:
        return replace(base, method="cra", **told)
    if base.verdict is Verdict.UNDECIDED:
        told["message"] = f"{base.message}; nor was a state with equal overlaps found"
    if not base.stable:
        return replace(base, method="check", **told)
    left = f" (best: {_left(best):.1e})" if best is not None else ""
    message = f"it comes to rest, but no state with equal overlaps was found{left}"
    if clock.late():
        message += f" before {clock.reason}"
    return replace(base, method="rest", message=message, **told)


def _left(state: Result) -> float:
    """The worst residual."""
    return np.inf if state.residuals is None else state.residuals.largest


def _meets(state: Result, options: CRAOptions) -> bool:
    """Whether all conditions are met, the bound on displacements as well."""
    slide = np.inf if state.eta is None else state.eta
    return _left(state) <= options.tolerance and slide <= options.slide_limit


def _worst(state: Result, options: CRAOptions) -> tuple[bool, float, float]:
    left = _left(state)
    met = left <= options.tolerance
    return (not met, 0.0 if met else left, state.eta or 0.0)


def _with_equal_overlaps(problem: Problem, slip: float, clock: Clock) -> Result | None:
    """The end of the path of equal overlaps, for a slip length of the friction law."""
    springs = law.uniform(problem.statics, slip=slip)
    start = find_rest(problem.statics, springs, BEGUN, stop=clock.late)
    if problem.ground_share(start.ground).max() > HANGS or clock.late():
        return None
    path = equal_overlap(problem.statics, start, slip, stop=clock.late)
    model, force = problem.model, problem.force(path.force)
    displacement = problem.displacement(path.motion)
    residuals = check_forces(model, force, displacement)
    moved = corner_motion(model.assembly, model.contacts, displacement)
    overlap = -moved[:, 0]
    pressed = overlap[force[:, 0] > LOADED * force[:, 0].max(initial=0.0)]
    mean = float(pressed.mean()) if len(pressed) and pressed.mean() > 0.0 else 1.0
    spread = float(np.abs(pressed / mean - 1.0).max(initial=0.0))
    deeper = float((np.maximum(0.0, overlap / mean - 1.0)).max(initial=0.0))
    return Result(
        method="cra",
        verdict=Verdict.STABLE,
        model=model,
        force=force,
        displacement=displacement,
        residuals=replace(residuals, overlap=max(spread, deeper)),
        eta=float(lengths(moved[problem.corners]).max(initial=0.0)) / mean,
        solver="equal-overlap path",
        iterations=path.iterations,
    )


_POINTS = 60
"""Largest number of points of the path."""

SPRING_LEFT = 1e-7
"""1 - theta at the end of the path: relative difference of overlaps, a tenth of the tolerance."""


def equal_overlap(
    statics: Statics, start: RestState, slip: float, *, stop: Callable[[], bool]
) -> RestState:
    """Follow the overlaps of a rest state until they are equal, or as far as they can be followed.

    Parameters
    ----------
    statics
    start
        A rest state on springs of uniform stiffness and the given slip length.
    slip
        Slip length of the friction law, relative to the local overlap.
    stop

    Returns
    -------
    RestState
        Its motions are in units of the overlap eps.
    """
    gap = statics.displacement(start.motion)[:, 0]
    total = float(start.force[:, 0].sum())
    mean = float(-(start.force[:, 0] * gap).sum()) / total if total > 0.0 else 1.0
    if not mean > 0.0:
        return replace(start, iterations=0)
    spring = mean * statics.normal_stiffness
    reach = SlipLength(FrictionBound(statics.friction), slip * statics.corner_load / spring)
    # near the end of the path Newton's method on the unrelaxed law needs a point near the state
    options = RestOptions(
        ground=1e-10, tolerance=1e-9, iteration_limit=40, warm_relaxation=1e-2, polish=1e-7
    )
    state = replace(start, motion=start.motion / mean)
    left, factor, iterations = 1.0, 0.3, 0
    for _ in range(_POINTS):
        aim = max(left * factor, SPRING_LEFT)
        law = Compliance(spring / aim, reach, overlap=1.0 - aim)
        trial = find_rest(statics, law, options, start=state, stop=stop)
        iterations += trial.iterations
        if trial.converged:
            state, left = trial, aim
            factor = max(factor**1.5, 0.03)
            if left <= SPRING_LEFT:
                break
        else:
            factor = np.sqrt(factor)
        if factor > 0.97 or stop():
            break
    if left > SPRING_LEFT:
        return replace(state, iterations=iterations)
    free = replace(options, ground=1e-16, tolerance=1e-10, iteration_limit=30, warm_relaxation=1e-8)
    final = find_rest(statics, law, free, start=state, stop=stop)
    return replace(final, iterations=iterations + final.iterations)
