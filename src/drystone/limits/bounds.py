"""Limits of rigid-block equilibrium, by convex programs.

Equilibrium is necessary for standing, not sufficient: these limits are upper bounds of the limits
of rest. They allow any prestress. Flow is associated: sliding joints open (Livesley 1978).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.progress import Stop, Stopped
from drystone.checks import check_forces
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import FactorSolution, LoadFactors, held_still
from drystone.limits.limit_search import VerdictSearch, Width
from drystone.limits.limit_types import Bracket, Family, LoadFactor, Tilt
from drystone.loads import LoadCase
from drystone.loads.applied import common_acceleration, is_vertical
from drystone.mechanics.statics import Statics, build_statics
from drystone.model import Model
from drystone.programs import RBEOptions, solve_rbe
from drystone.programs.rbe import BALANCE_TOLERANCE
from drystone.results import Result, Verdict
from drystone.solvers.program import ConicSolution
from drystone.stability.problem import Problem
from drystone.stability.proofs import checked_mechanism, moving_blocks
from drystone.stability.strength import crushing_factor
from drystone.stability.touching_edges import unless_edges_hold

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


def rbe(
    cone: FrictionCone,
    stop: Stop | None,
    model: Model,
) -> Result:
    """Result of rigid-block equilibrium without the penalty form."""
    return solve_rbe(model, options=_options(cone), stop=stop)


def _options(cone: FrictionCone) -> RBEOptions:
    options = RBEOptions.feasibility(cone)
    return replace(options, conic=replace(options.conic, iteration_limit=_STEPS))


def _falls_by(model: Model, cone: FrictionCone, solution: FactorSolution) -> Result | None:
    """UNSTABLE where the mechanism of the largest load factor is one under this load as well.

    At the limit the loads do no work on it, and beyond the limit they do (the kinematic theorem).
    Near the limit this proves what another program may not: none has a margin there.
    """
    problem = Problem.build(model)
    mechanism = checked_mechanism(problem, solution.state)
    if mechanism is None:
        mechanism = checked_mechanism(problem, held_still(problem.statics, solution.state))
    if mechanism is None:
        return None
    found = Result(
        method="rbe",
        verdict=Verdict.UNSTABLE,
        model=model,
        message="no contact forces can balance the loads",
        mechanism=mechanism,
        falling=moving_blocks(model.assembly, mechanism),
        options=_options(cone),
        solver=solution.state.raw.solver,
        iterations=solution.state.raw.iterations,
    )
    # the factor was that of the contacts of the model: edges that touch may hold it
    held = unless_edges_hold(found, partial(rbe, cone, None))
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
    solution = _largest(family.model, family.live, cone, stop)
    factor = solution.factor
    scale = factor if 0.0 < factor < upper else upper
    chosen = share * scale if width is None else width
    return _confirmed(family, factor, solution, (0.0, upper), chosen, cone, stop), chosen


def tilt_bound(
    family: Tilt, upper: float, *, width: float, cone: FrictionCone, stop: Stop | None = None
) -> Bracket:
    """The limit of equilibrium under tilt.

    A load normal to the axis rotates in a plane. There the loads that can be balanced form a convex
    cone. Its edge is found quarter by quarter: as the largest factor of the load rotated by 90
    degrees, added to the load. Any other load is bisected.
    """
    if not family.is_planar():
        return bisected_bound(family, 0.0, upper, width=width, cone=cone, stop=stop)
    angle = float("inf")
    solution: FactorSolution | None = None
    for quarter in np.arange(0.0, upper, 90.0).tolist():
        solution = _largest(family(quarter), family.turned(quarter + 90.0), cone, stop)
        if solution.factor < np.inf:
            angle = quarter + float(np.rad2deg(np.arctan(solution.factor)))
            break
    return _confirmed(family, angle, solution, (0.0, upper), width, cone, stop)


def tilt_margin(model: Model, *, most: int = 150, stop: Stop | None = None) -> float | None:
    """The tilt [degrees] up to which forces balance the loads, least of those about x and y.

    One conic program for each of the four ways to tilt. Loads that are not all vertical, as those
    of fill, do not turn: of them it is the angle of the weight of blocks with the largest push
    along x and y that forces balance beside the loads.

    Parameters
    ----------
    model
    most
        Blocks of a model of which it is asked. Measured: 0.23 s of CPU time for a vault of 97
        blocks, 2.2 s for one of 399.
    stop

    Returns
    -------
    float or None
        None where it is not asked: of more blocks, of joints that carry more than friction, and
        where no weight acts; and where forces balance them up to 90 degrees, as wedged blocks
        press on each other however they are turned.
    """
    if len(model) > most or model.contacts.capacity is not None or model.contacts.count == 0:
        return None
    least, statics, load = 90.0, _statics(model), model.load
    largest = LoadFactors(statics, FrictionCone.exact())
    if not is_vertical(load):
        down = -float(common_acceleration(model.assembly, load)[2])
        if down <= 0.0:
            return None
        load = LoadCase.gravity(model.assembly, down)
    for axis in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)):
        way = Tilt(model.with_load(load), np.array(axis)).turned(90.0)
        factor = largest(scaled_wrench(statics, way), stop).factor
        least = min(least, float(np.rad2deg(np.arctan(factor))))
    return least if 0.0 < least < 90.0 else None


def with_margins(result: Result, stop: Stop | None = None) -> Result:
    """A result with the margins of what stands, where they are asked and not known yet."""
    if not result.stable or result.stopped or result.tilt_margin is not None:
        return result
    margin, factor = tilt_margin(result.model, stop=stop), crushing_factor(result.model, stop=stop)
    return replace(result, tilt_margin=margin, crushing_factor=factor)


def _statics(model: Model) -> Statics:
    """The scales are those of the model without a live load."""
    return build_statics(model.with_contacts(model.contacts.select(model.active)))


def _largest(model: Model, live: LoadCase, cone: FrictionCone, stop: Stop | None) -> FactorSolution:
    statics = _statics(model)
    return LoadFactors(statics, cone)(scaled_wrench(statics, live), stop)


def scaled_wrench(statics: Statics, load: LoadCase) -> Floats:
    """Wrenches (n, 6) of the free blocks in the units of a dimensionless problem."""
    wrench = load.wrench[statics.free] / statics.force_unit
    return np.concatenate([wrench[:, :3], wrench[:, 3:] / statics.length[:, None]], axis=1)


def _confirmed(
    family: Family,
    value: float,
    solution: FactorSolution | None,
    span: tuple[float, float],
    width: float,
    cone: FrictionCone,
    stop: Stop | None,
) -> Bracket:
    """A bracket around the value of a solver, with checked answers at both sides."""
    search = _search(family, cone, stop)
    start, end = span
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
