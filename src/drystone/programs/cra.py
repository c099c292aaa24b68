"""Coupled rigid-block analysis of the source: eq. 5.6, and its penalty form, eq. 5.8."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.base.display import named
from drystone.base.settings import Clock, Options, checked_call
from drystone.checks import check_forces, corner_motion
from drystone.io.opening import Given, LongHow, as_model
from drystone.mechanics import law
from drystone.mechanics.law import Compliance, FrictionBound, SlipLength
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions, RestState
from drystone.mechanics.statics import Statics
from drystone.programs.overlaps import EqualOverlaps
from drystone.results import Result, Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.asked import SAMPLES, Asked, CheckOptions
from drystone.stability.attempts import FALLS_FROM, TO_REST
from drystone.stability.problem import FALLING_SHARE, Problem
from drystone.stability.verdict import decided

LOADED = 1e-7
"""Share of the largest normal force from which on a corner counts as loaded."""

BEGUN = RestOptions(ground=1e-8, tolerance=1e-8, polish=1e-7)
"""The path of equal overlaps starts best from a state that the relaxed law led to."""

SLIPS = (1.0, 10.0, 0.1)
"""Slip lengths of the friction law, by the local overlap, tried one after another."""

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
    """

    tolerance: float = 1e-6
    slide_limit: float = 1000.0


@checked_call
@one_blas_thread()
def solve_cra(given: Given, *, options: CRAOptions | None = None, **how: Unpack[LongHow]) -> Result:
    """Forces and a virtual motion with equal overlaps wherever force passes (eq. 5.6).

    A state is searched along the path of the loads, and from other motions unless :func:`check`
    finds that the blocks fall: states that only jam, as of model H from friction 0.889 on, are not
    returned. Where none is found, the verdict is that of :func:`check`, which need not be that of
    CRA: what comes to rest without such a state is stable all the same, and what is undecided there
    is so here. The message says both.

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
    for slip in SLIPS if problem.statics.free_count else ():
        clock.tell("equal overlaps", SLIPS.index(slip), len(SLIPS))
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
    met = "stands, eq. 5.6 is met; the largest displacement is {:.3g} overlaps"
    if best is not None and _meets(best, chosen):
        return replace(best, message=met.format(best.eta), **told)
    wide = best if best is not None and _left(best) <= chosen.tolerance else None
    base = wide
    if base is None:
        base = decided(Asked(problem, CheckOptions(samples=SAMPLES), clock))
    if problem.statics.free_count and base.verdict is not Verdict.UNSTABLE:
        clock.tell("other motions", 0, 1)
        for motion, force in EqualOverlaps(problem.statics, clock.late).states():
            state = _examined(problem, motion, force)
            if _meets(state, chosen):
                return replace(state, message=met.format(state.eta), **told)
    told |= {"stopped": clock.reason, "time_s": {"solve": clock.elapsed_s}}
    if wide is not None:
        wider = f"{met.format(wide.eta)}, more than the {chosen.slide_limit:g} asked for"
        return replace(wide, method="rest", message=wider, **told)
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
    return replace(
        _examined(problem, path.motion, path.force),
        solver="equal-overlap path",
        iterations=path.iterations,
    )


def _examined(problem: Problem, motion: Floats, scaled: Floats) -> Result:
    """A state of scaled motion (n, 6) and forces (k, 3), with its residuals."""
    model, force = problem.model, problem.force(scaled)
    displacement = problem.displacement(motion)
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
        solver="steps from many motions",
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
        # where few corners bear the loads, overlaps differ more than the springs that are left
        least = SPRING_LEFT / max(1.0, 0.2 * float((state.force[:, 0] / spring).max()))
        aim = max(left * factor, least)
        law = Compliance(spring / aim, reach, overlap=1.0 - aim)
        trial = find_rest(statics, law, options, start=state, stop=stop)
        iterations += trial.iterations
        if trial.converged:
            state, left = trial, aim
            factor = max(factor**1.5, 0.03)
            if left <= least:
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


GLUE = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Tensile stiffness of a corner divided by its stiffness in compression. It is reduced step by step
while the iteration converges. With a smaller value there is tension only where contact cannot carry
the load."""

HELD = 0.01
"""Glue holds a block when the ground carries less than this share of its load."""

PULLS = 1e-5
"""Share of the largest force from which on a pull, or what is not balanced, is some. Below is the
rounding of interior points: 7e-7 where tension costs a million times as much."""

_ACCURACY = 1e-7
"""Tolerance of the rest state, by the load. What is smaller beside the largest force is none."""


@dataclass(frozen=True)
class PenaltyOptions(Options):
    """Options of :func:`solve_cra_penalty`.

    Attributes
    ----------
    ground : > 0, < inf
        Stiffness of the ground, far below that of the glue: it carries what glue cannot.
    gamma : >= 1, < inf
        Cost of tension by that of compression, one or more: springs that balance loads have the
        least energy, in which a pull on glue of a stiffness counts by its inverse. As far as the
        iteration follows, 1000 at most, when left out.
    """

    ground: float = 1e-8
    gamma: float | None = None

    @property
    def glue(self) -> tuple[float, ...]:
        """Tensile stiffnesses that are tried one after another, the weakest last."""
        if self.gamma is None:
            return GLUE
        steps = max(1, math.ceil(2.0 * math.log10(self.gamma)))
        return tuple(self.gamma ** -(i / steps) for i in range(1, steps + 1))


@checked_call
@one_blas_thread()
def solve_cra_penalty(
    given: Given,
    *,
    options: PenaltyOptions | None = None,
    **how: Unpack[LongHow],
) -> Result:
    """Where help is needed: props, or glue in the joints.

    ``prop`` is the wrench that would hold each falling block with dry joints. ``tension`` is the
    tension of the joints if they were glued: corners get a weak tensile spring, and friction is
    bounded by compression. There is always a result.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options

    Returns
    -------
    Result
        The verdict of :func:`check` with ``force`` and ``tension`` per corner of the glued
        structure and ``prop`` per block of the dry one. ``falling`` lists the blocks that need
        help, the one with the largest prop force first; the message says which of them glue cannot
        hold.

    Raises
    ------
    InputError
        What was given cannot be made into a model.

    Notes
    -----
    Source: Kao et al. 2022, eq. 5.8, with ``gamma``. There all pressed corners overlap by the same
    length; here by as much as they carry.
    """
    chosen = PenaltyOptions.of(options)
    clock = Clock.of(how)
    problem = Problem.build(as_model(given, **how))
    problem.model.require_dry(
        "the penalty form of coupled rigid-block analysis",
        "it measures the pull that dry joints do not have",
    )
    asked = CheckOptions(samples=SAMPLES, settle=False)
    dry = decided(Asked(problem, asked, clock))
    assembly = problem.model.assembly
    corners = problem.model.contacts.corner_count

    def told(message: str, **found: Any) -> Result:
        time_s = {"solve": clock.elapsed_s}
        return replace(
            dry, method="cra-penalty", message=message, options=chosen, time_s=time_s, **found
        )

    if dry.stable:
        none = {"tension": np.zeros(corners), "prop": np.zeros((len(assembly), 6))}
        return told("no block needs help: it stands dry", **none)
    clock.tell("glue", 0, 1)
    statics = problem.statics
    glued = glued_state(problem, chosen, clock.late)
    leaning = find_rest(
        problem.statics, law.uniform(statics), replace(TO_REST, end=None), stop=clock.late
    )
    if clock.late():
        early = f"{dry.message}; {clock.reason} before the help that it needs was known"
        return told(early, stopped=clock.reason)
    share = problem.ground_share(leaning.ground)
    prop = dry.prop
    leans = leaning.converged and share.max() > FALLS_FROM
    if prop is None or leans:  # that of the mechanism also presses blocks together
        prop = -problem.wrench(leaning.ground)
    needy = dry.falling or tuple(int(i) for i in statics.free[share > FALLING_SHARE * share.max()])
    strength = np.linalg.norm(prop[:, :3], axis=1)
    order = tuple(sorted(needy, key=lambda i: -strength[i]))
    unheld = set(statics.free[problem.ground_share(glued.ground) > HELD].tolist())
    force, tension = problem.force(glued.force), problem.force(glued.tension[:, None])[:, 0]
    weight = float(np.abs(problem.model.load.wrench[statics.free, :3]).max(initial=0.0))
    small = _ACCURACY * max(float(np.abs(force).max(initial=0.0)), weight)
    force = np.where((lengths(force) > small)[:, None], force, 0.0)
    tension = np.where(tension > small, tension, 0.0)
    displacement = problem.displacement(glued.motion)
    residuals = check_forces(
        problem.model,
        force,
        displacement,
        prop=-problem.wrench(glued.ground),
    )
    names = assembly.names
    return told(
        _words(
            [names[i] for i in order], {names[i] for i in unheld}, residuals.equilibrium <= PULLS
        ),
        force=force,
        tension=tension,
        displacement=displacement,
        prop=prop,
        falling=order,
        residuals=residuals,
        iterations=dry.iterations + glued.iterations + leaning.iterations,
    )


def glued_state(
    problem: Problem,
    options: PenaltyOptions | None = None,
    stop: Callable[[], bool] | None = None,
) -> RestState:
    """The rest state with the weakest glue that the iteration follows, see :data:`GLUE`.

    Parameters
    ----------
    problem
    options
    stop
        Asked often; True ends the iteration with what is there.
    """
    chosen = PenaltyOptions.of(options)
    numerics = RestOptions(ground=chosen.ground, tolerance=_ACCURACY)
    statics = problem.statics
    first, *rest = chosen.glue
    glued = find_rest(problem.statics, _glue(statics, first), numerics, stop=stop)
    for glue in rest:
        weaker = find_rest(problem.statics, _glue(statics, glue), numerics, start=glued, stop=stop)
        if not weaker.converged:
            break
        glued = weaker
    return glued


def _glue(statics: Statics, stiffness: float) -> Compliance:
    return law.uniform(statics, slip=1.0, glue=stiffness)


def _words(needy: list[str], unheld: set[str], balanced: bool) -> str:
    if not needy:
        return "no block shows that it needs help"
    shown = named(needy)
    stuck = [name for name in needy if name in unheld]
    if not balanced:
        return f"help is needed at {shown}; no tension was found that balances the loads: prop them"
    if not stuck:
        return f"help is needed at {shown}; glue would do"
    return f"help is needed at {shown}; glue cannot hold {named(stuck)}: prop them"
