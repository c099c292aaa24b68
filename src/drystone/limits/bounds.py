"""Limits of rigid-block equilibrium, by convex programs.

Equilibrium is necessary for standing, not sufficient: these limits are upper bounds of the limits
of rest. They allow any prestress. Flow is associated: sliding joints open (Livesley 1978).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from drystone.base.arrays import SAME, Floats
from drystone.base.settings import Stop, Stopped
from drystone.checks import check_forces
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import FactorSolution, LoadFactors
from drystone.formulations.nearest_mechanism import nearest_mechanism
from drystone.limits.images import unlike_axes
from drystone.limits.limit_search import VerdictSearch, Width
from drystone.limits.limit_types import Bracket, Family, Friction, LoadFactor, Tilt
from drystone.loads import LoadCase
from drystone.loads.applied import common_acceleration, is_vertical
from drystone.mechanics.statics import Statics
from drystone.model import Model
from drystone.programs import RBEOptions, solve_rbe
from drystone.programs.rbe import BALANCE_TOLERANCE, BALANCED, NEAREST
from drystone.results import Result, Verdict
from drystone.results.solution import MARGINS
from drystone.solvers.program import ConicSolution
from drystone.solvers.threads import one_blas_thread
from drystone.stability.problem import (
    UNBALANCED,
    Problem,
    checked_mechanism,
    moving_blocks,
    sound_mechanism,
)
from drystone.stability.strength import crushing_factor
from drystone.stability.touching_edges import unless_more_holds

_WIDEST = 3e-3
"""A limit from one program needs checked states within this share of it on both sides. Otherwise it
is bisected."""

_STEPS = 100
"""Steps of one program. Those that end with an answer take about 40; very near the limit others end
without one, whatever their number."""


def balanced(
    model: Model, force: Floats, raw: ConicSolution, message: str, mechanism: Floats | None = None
) -> Result | None:
    """Forces (k, 3) [N] of a program as a result; None where they do not balance the loads."""
    residuals = check_forces(model, force)
    if max(residuals.equilibrium, residuals.tension) > BALANCE_TOLERANCE:
        return None
    return Result(
        method="rbe", verdict=Verdict.EQUILIBRIUM_EXISTS, model=model, message=message,
        force=force, mechanism=mechanism, residuals=residuals, solver=raw.solver,
        iterations=raw.iterations,
    )  # fmt: skip


def rbe(cone: FrictionCone, stop: Stop | None, model: Model) -> Result:
    """Result of rigid-block equilibrium without the penalty form."""
    found = solve_rbe(model, options=_options(cone), stop=stop)
    return replace(found, options=RBEOptions(cone=cone))  # numerics are not what was asked


def _options(cone: FrictionCone) -> RBEOptions:
    options = RBEOptions.feasibility(cone)
    return replace(options, conic=replace(options.conic, iteration_limit=_STEPS))


def _falls_by(model: Model, cone: FrictionCone, solution: FactorSolution) -> Result | None:
    """UNSTABLE where the mechanism of the largest load factor is one under this load as well.

    At the limit the loads do no work on it, and beyond the limit they do (the kinematic theorem).
    Near the limit this proves what another program may not: none has a margin there.
    """
    raw = solution.state.raw
    mechanism = checked_mechanism(Problem.build(model), solution.state)
    return _falling(model, cone, mechanism, raw.solver, raw.iterations)


def _falling(
    model: Model, cone: FrictionCone, mechanism: Floats | None, solver: str, iterations: int
) -> Result | None:
    """UNSTABLE with a mechanism (n, 6), where there is one and edges that touch do not hold it."""
    if mechanism is None:
        return None
    found = Result(
        method="rbe",
        verdict=Verdict.UNSTABLE,
        model=model,
        message=UNBALANCED,
        mechanism=mechanism,
        falling=moving_blocks(model.assembly, mechanism),
        options=RBEOptions(cone=cone),
        solver=solver,
        iterations=iterations,
    )
    held = unless_more_holds(found, partial(rbe, cone, None))
    return held if held.verdict is Verdict.UNSTABLE else None


def bisected_bound(
    family: Family,
    start: float,
    end: float,
    *,
    width: float,
    cone: FrictionCone,
    stop: Stop | None = None,
) -> Bracket:
    """The limit of equilibrium between a value where it is expected and one where it is not."""
    return _search(family, cone, stop).run(start, end, width=Width(width), scan=1).bracket


def _search(family: Family, cone: FrictionCone, stop: Stop | None) -> VerdictSearch:
    return VerdictSearch(family, partial(rbe, cone, stop), stop=stop)


@one_blas_thread()
def friction_bound(
    family: Family,
    start: float,
    end: float,
    *,
    width: float,
    cone: FrictionCone,
    stop: Stop | None = None,
    rests: Callable[[float], Mapping[float, Result]] | None = None,
) -> Bracket:
    """The limit of equilibrium between a friction where it is expected and none.

    From a hundredth of the start it is approached by Newton's method, where joints only press and
    rub: in the mechanism nearest to free fall the loads have a power, of which friction takes up a
    part in proportion to it. On an arch, a vault and a dome it is within a thousandth after two to
    four programs, in place of the ten of a bisection.

    ``rests``: rest states up to a value. Their forces balance the loads, and take less time than a
    program.
    """
    search = _search(family, cone, stop)
    exact = cone == FrictionCone.exact() and bool(family(start).contacts.plain.all())
    limit = _approached(search, family, start, width, cone, stop) if exact else end
    near = min(limit + 0.3 * width, start) if search.results else end
    far = max(*search.results, near - width) if search.results else end
    if rests is not None and exact:
        for value, one in rests(near).items():
            forces = replace(one, method="rbe", message=BALANCED)
            search.results[value] = replace(forces, verdict=Verdict.EQUILIBRIUM_EXISTS)
    if near == end:
        return search.run(start, end, width=Width(width), scan=1).bracket
    return search.around(near, far, (start, end), width=Width(width)).bracket


def _approached(
    search: VerdictSearch,
    family: Family,
    start: float,
    width: float,
    cone: FrictionCone,
    stop: Stop | None,
) -> float:
    """The limit, where the search has a value that falls. Each mechanism begins by the last one."""
    value, limit, before = 0.01 * start, start, None
    while width < value < start:
        problem = Problem.build(family(value))
        found = nearest_mechanism(problem.statics, stop=stop, after=before)
        motion, falling = found.motion, None
        if motion is not None:
            proven = sound_mechanism(problem, motion)
            falling = _falling(problem.model, cone, proven, NEAREST, found.iterations)
        if motion is not None and falling is not None:
            search.results[value], before = falling, found
            limit = value + value * _left_by_friction(problem.statics, motion, found.force)
            if limit - value <= 0.7 * width:
                break
            value = limit - 0.3 * width
        elif search.results:
            return value
        else:
            value *= 0.01
    return limit


def _left_by_friction(statics: Statics, motion: Floats, force: Floats) -> float:
    """Power of the loads in a mechanism (n, 6), by what friction (k, 3) takes up of it."""
    slid = statics.displacement(motion)[:, 1:]
    taken = -float((force[:, 1:] * slid).sum())
    return float((statics.load * motion).sum()) / taken if taken > 0.0 else math.inf


def load_factor_bound(
    family: LoadFactor,
    upper: float,
    *,
    share: float,
    width: float | None,
    cone: FrictionCone,
    stop: Stop | None = None,
) -> tuple[Bracket, float]:
    """The limit of equilibrium from one conic program, and the width of its bracket.

    Checked states stand on both sides. Without a width it is a share of the limit.
    """
    solution = _largest(family.model, LoadCase(family.acting), cone, stop)
    factor = solution.factor
    scale = factor if 0.0 < factor < upper else upper
    chosen = share * scale if width is None else width
    return _confirmed(family, factor, solution, (0.0, upper), chosen, cone, stop), chosen


def tilt_bound(
    family: Tilt,
    upper: float,
    *,
    width: float,
    cone: FrictionCone,
    stop: Stop | None = None,
    first: FactorSolution | None = None,
    rest: Result | None = None,
) -> Bracket:
    """The limit of equilibrium under tilt.

    A load normal to the axis rotates in a plane. There the loads that can be balanced form a convex
    cone. Its edge is found quarter by quarter: as the largest factor of the load rotated by 90
    degrees, added to the load. Any other load is bisected. ``first``: of the first quarter, where
    it is known, see :func:`tilt_factor`. ``rest``: forces that balance the load upright.
    """
    if not family.is_planar():
        return bisected_bound(family, 0.0, upper, width=width, cone=cone, stop=stop)
    angle = float("inf")
    solution: FactorSolution | None = None
    for quarter in np.arange(0.0, upper, 90.0).tolist():
        solution = None if quarter else first
        if solution is None:
            solution = _largest(family(quarter), family.turned(quarter + 90.0), cone, stop)
        if solution.factor < np.inf:
            angle = quarter + float(np.rad2deg(np.arctan(solution.factor)))
            break
    held = None
    if solution is not None and rest is not None and cone == FrictionCone.exact():
        held = _between(family, solution, rest, angle - 0.5 * width)
    return _confirmed(family, angle, solution, (0.0, upper), width, cone, stop, held)


def _between(family: Tilt, last: FactorSolution, rest: Result, angle: float) -> Result | None:
    """A state at an angle [degrees] below the limit, of the forces there and upright.

    The load there is a sum of those two with factors that are not negative, and so are the forces:
    they stay in their cones. None where joints do more than press and rub, and beyond 90 degrees.
    """
    contacts, upright = family.model.contacts, rest.force
    if upright is None or len(upright) != contacts.corner_count:
        return None
    if not (contacts.plain.all() and 0.0 < angle < 90.0):
        return None
    turn = math.radians(angle)
    share = math.sin(turn) / last.factor
    force = share * Problem.build(family.model).force(last.state.force)
    force += (math.cos(turn) - share) * upright
    return balanced(family(angle), force, last.state.raw, BALANCED)


def tilt_factor(
    family: Tilt, cone: FrictionCone, stop: Stop | None, enough: float = np.inf
) -> FactorSolution:
    """Tangent of the tilt below 90 degrees up to which forces balance the loads, if not enough."""
    return _largest(family.model, family.turned(90.0), cone, stop, enough)


def tilt_margin(
    model: Model, *, most: int = MARGINS, stop: Stop | None = None
) -> tuple[float | None, str]:
    """The tilt [degrees] up to which forces balance the loads, least of those about x and y.

    One conic program for each of the four ways to tilt that are not alike. Loads that are not all
    vertical, as those of fill, do not turn: of them it is the angle of the weight, of blocks and
    what they carry, with the largest push along x and y that forces balance beside the loads.

    Parameters
    ----------
    model
    most
        Blocks of a model of which it is asked.
    stop

    Returns
    -------
    float or None, and str
        The tilt, and the name of the axis of the least, of equal ones the first. None where it is
        not asked: of more blocks, of joints that carry more than friction, and
        where no weight acts; and where forces balance them up to 90 degrees, as wedged blocks
        press on each other however they are turned.
    """
    if len(model) > most or model.contacts.capacity is not None or model.contacts.count == 0:
        return None, ""
    least, about, statics, load = 90.0, "", Problem.build(model).statics, model.load
    largest = LoadFactors(statics, FrictionCone.exact())
    if not is_vertical(load):
        down = -float(common_acceleration(model.assembly, load)[2])
        if down <= 0.0:
            return None, ""
        load = LoadCase.gravity(model.assembly, down) + load.weight_of_masses
    for name, axis in unlike_axes(model).items():
        way = Tilt(model.with_load(load), np.array(axis)).turned(90.0)
        angle = math.degrees(math.atan(largest(statics.scaled_wrench(way.wrench), stop).factor))
        if angle < (1.0 - SAME) * least:
            least, about = angle, name
    return (least, about) if 0.0 < least < 90.0 else (None, "")


def friction_margin(model: Model, stop: Stop | None = None) -> float | None:
    """The share of the friction of all joints with which forces balance the loads.

    None of more than :data:`MARGINS` blocks, of joints that do more than press and rub, and where
    no block is free.
    """
    plain, rubs = model.contacts.plain, model.contacts.friction
    few = 0 < len(model.assembly.free) <= len(model) <= MARGINS
    if not (few and plain.all() and rubs.any()):
        return None
    share = Friction(model, True)
    cone = FrictionCone.exact()
    return friction_bound(share, 1.0, 0.0, width=1e-3, cone=cone, stop=stop).stands


def with_tilt_margin(result: Result, stop: Stop | None = None) -> Result:
    """A result with the margin of tilt of what stands, where it is asked and not known yet."""
    if not result.stable or result.stopped or result.tilt_margin is not None:
        return result
    margin, about = tilt_margin(result.model, stop=stop)
    return replace(result, tilt_margin=margin, tilt_about=about)


def with_margins(result: Result, stop: Stop | None = None) -> Result:
    """The same with those of friction and of strength."""
    found, model = with_tilt_margin(result, stop), result.model
    if not found.stable or found.stopped or found.friction_margin is not None:
        return found
    share, factor = friction_margin(model, stop), crushing_factor(model, stop=stop)
    return replace(found, friction_margin=share, crushing_factor=factor)


def _largest(
    model: Model, live: LoadCase, cone: FrictionCone, stop: Stop | None, enough: float = np.inf
) -> FactorSolution:
    statics = Problem.build(model).statics  # with the scales of the model without a live load
    return LoadFactors(statics, cone, enough=enough)(statics.scaled_wrench(live.wrench), stop)


def _confirmed(
    family: Family,
    value: float,
    solution: FactorSolution | None,
    span: tuple[float, float],
    width: float,
    cone: FrictionCone,
    stop: Stop | None,
    held: Result | None = None,
) -> Bracket:
    """A bracket around the value of a solver, with checked answers at both sides.

    ``held``: the state half of a width before it, where it is known.
    """
    search = _search(family, cone, stop)
    start, end = span
    if held is not None:
        search.results[value - 0.5 * width] = held
    try:
        if value >= end:
            verdict = search.stands(end)
            if verdict is True:
                return Bracket(stands=end, standing=search.results[end])
        elif value >= start:
            widest = max(width, _WIDEST * (abs(value) + width))
            low = _nearest(search, value, -0.5 * width, widest, start, True)
            beyond = min(end, value + 0.5 * width)
            known = None if solution is None else _falls_by(family(beyond), cone, solution)
            if known is not None:
                search.results[beyond] = known
            high = _nearest(search, value, 0.5 * width, widest, end, False)
            if low is not None and high is not None:
                return Bracket(low, high, search.results[low], search.results[high], value)
    except Stopped:
        return search.so_far(start).bracket
    return search.run(start, end, width=Width(width), scan=1).bracket


def _nearest(
    search: VerdictSearch, value: float, step: float, widest: float, end: float, stands: bool
) -> float | None:
    """The first checked answer on one side of a limit, or none within reach."""
    while abs(step) <= widest:
        there = min(end, value + step) if step > 0.0 else max(end, value + step)
        if search.stands(there) is stands:
            return there
        step *= 2.0
    return None
