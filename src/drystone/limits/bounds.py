"""Limits of rigid-block equilibrium, by convex programs.

Equilibrium is necessary for standing, not sufficient: these limits are upper bounds of the limits
of rest. They allow any prestress. Flow is associated: sliding joints open (Livesley 1978).

A bridge under a train: the largest factor at a place, its forces, and a proof of no more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy import sparse

from drystone.base.arrays import SAME, Bools, Floats, Ints
from drystone.base.errors import InputError
from drystone.base.settings import Stop, Stopped
from drystone.checks import check_forces, mechanism_defects
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import FactorSolution, LoadFactors, PlaneFactors, held_still
from drystone.formulations.nearest_mechanism import nearest_mechanism
from drystone.geometry.frames import LEVEL_AXES
from drystone.limits.limit_search import VerdictSearch, Width
from drystone.limits.limit_types import Bracket, Family, Friction, LimitOptions, LoadFactor, Tilt
from drystone.loads import LoadCase, Train
from drystone.loads.applied import common_acceleration, is_vertical
from drystone.loads.fill import Tops
from drystone.loads.placing import GivenLoad
from drystone.mechanics.statics import Statics
from drystone.model import Model
from drystone.programs import RBEOptions, solve_rbe
from drystone.programs.rbe import BALANCE_TOLERANCE, NEAREST
from drystone.results import Result, Verdict
from drystone.results.solution import MARGINS
from drystone.solvers.program import ConicSolution
from drystone.solvers.threads import one_blas_thread
from drystone.stability.problem import (
    MECHANISM_TOLERANCE,
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


def rbe(
    cone: FrictionCone,
    stop: Stop | None,
    model: Model,
) -> Result:
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
) -> Bracket:
    """The limit of equilibrium between a friction where it is expected and none.

    From a hundredth of the start it is approached by Newton's method, where joints only press and
    rub: in the mechanism nearest to free fall the loads have a power, of which friction takes up a
    part in proportion to it. On an arch, a vault and a dome it is within a thousandth after two or
    three programs, in place of the ten of a bisection.
    """
    search = _search(family, cone, stop)
    value, limit = 0.01 * start, end
    exact = cone == FrictionCone.exact() and bool(family(start).contacts.plain.all())
    while exact and width < value < start:
        problem = Problem.build(family(value))
        found = nearest_mechanism(problem.statics, stop=stop)
        motion, falling = found.motion, None
        if motion is not None:
            proven = sound_mechanism(problem, motion)
            falling = _falling(problem.model, cone, proven, NEAREST, found.iterations)
        if motion is not None and falling is not None:
            search.results[value] = falling
            limit = value + value * _left_by_friction(problem.statics, motion, found.force)
            if limit - value <= 0.7 * width:
                break
            value = limit - 0.3 * width
        elif search.results:
            limit = value
            break
        else:
            value *= 0.01
    if not search.results:
        return search.run(start, end, width=Width(width), scan=1).bracket
    near = min(limit + 0.3 * width, start)
    far = max(*search.results, near - width)
    return search.around(near, far, (start, end), width=Width(width)).bracket


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
) -> Bracket:
    """The limit of equilibrium under tilt.

    A load normal to the axis rotates in a plane. There the loads that can be balanced form a convex
    cone. Its edge is found quarter by quarter: as the largest factor of the load rotated by 90
    degrees, added to the load. Any other load is bisected. ``first``: of the first quarter, where
    it is known, see :func:`tilt_factor`.
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
    return _confirmed(family, angle, solution, (0.0, upper), width, cone, stop)


def tilt_factor(
    family: Tilt, cone: FrictionCone, stop: Stop | None, enough: float = np.inf
) -> FactorSolution:
    """Tangent of the tilt below 90 degrees up to which forces balance the loads, if not enough."""
    return _largest(family.model, family.turned(90.0), cone, stop, enough)


def tilt_margin(
    model: Model, *, most: int = MARGINS, stop: Stop | None = None
) -> tuple[float | None, str]:
    """The tilt [degrees] up to which forces balance the loads, least of those about x and y.

    One conic program for each of the four ways to tilt. Loads that are not all vertical, as those
    of fill, do not turn: of them it is the angle of the weight, of blocks and what they carry, with
    the largest push along x and y that forces balance beside the loads.

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
    for name, axis in LEVEL_AXES.items():
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


def with_margins(result: Result, stop: Stop | None = None) -> Result:
    """A result with the margins of what stands, where they are asked and not known yet."""
    if not result.stable or result.stopped or result.tilt_margin is not None:
        return result
    margin, about = tilt_margin(result.model, stop=stop)
    factor = crushing_factor(result.model, stop=stop)
    share = friction_margin(result.model, stop)
    return replace(
        result, tilt_margin=margin, tilt_about=about, friction_margin=share, crushing_factor=factor
    )


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


_BEYOND = 1e-3
"""Share of the factor beyond it at which the mechanism is checked."""


Known: TypeAlias = Callable[[Floats], tuple[Floats, list[Floats]]]
"""Factors (p,) at places (p,) [m], and of each stretches (s, 2) [m] of the line load."""


class Position(NamedTuple):
    """A train with its middle at a place [m].

    Attributes
    ----------
    place
    train
    axles : (n, 6)
        Wrenches of its axles.
    ends : (p, 2) [m]
        Pieces of the road on which its line load may act.
    pieces : (p, n, 6)
        Wrenches of the line load on each.
    """

    place: float
    train: Train
    axles: Floats
    ends: Floats
    pieces: Floats

    @property
    def words(self) -> str:
        """Where it is."""
        return f"x = {self.place:.3g} m"

    def worked(self, motion: Floats) -> Floats:
        """Power (p, m) of the line load on each piece in mechanisms (m, n, 6)."""
        flat = motion.reshape(len(motion), -1).T
        return np.asarray(self.pieces.reshape(len(self.pieces), len(flat)) @ flat)

    def power(self, motion: Floats) -> Floats:
        """(m,) in mechanisms (m, n, 6): of the axles, and of the line load where it is adverse."""
        axles = motion.reshape(len(motion), -1) @ self.axles.ravel()
        return np.asarray(axles + np.maximum(self.worked(motion), 0.0).sum(axis=0))

    def adverse(self, motion: Floats) -> Bools:
        """Pieces (p,) on which the line load works in a mechanism (n, 6)."""
        return np.asarray(self.worked(motion[None])[:, 0] > 0.0)

    def on(self, line: Floats) -> Bools:
        """Pieces (p,) with their middle in one of some stretches (s, 2) [m]."""
        middle = self.ends.mean(axis=1)[:, None]
        return np.asarray(((middle > line[:, 0]) & (middle < line[:, 1])).any(axis=1))

    def line(self, adverse: Bools) -> Floats:
        """Stretches (s, 2) [m] of the road that pieces (p,) make up."""
        ends = self.ends[adverse]
        if not len(ends):
            return ends
        gap = ends[1:, 0] > ends[:-1, 1] + 1e-9
        return np.stack([ends[np.append(True, gap), 0], ends[np.append(gap, True), 1]], axis=1)

    def load(self, adverse: Bools) -> LoadCase:
        """The axles, and the line load on some pieces (p,)."""
        wrench = self.axles + self.pieces[adverse].sum(axis=0)
        name = f"{self.train.name} at {self.words}"
        return LoadCase(wrench, name, each=GivenLoad.of(name, wrench))


class PlacedTrain(NamedTuple):
    """The largest factor of a train by equilibrium, its line load on the pieces ``adverse``."""

    at: Position
    found: FactorSolution
    adverse: Bools

    @property
    def factor(self) -> float:
        """Infinite where none was found."""
        return math.inf if math.isnan(self.found.factor) else self.found.factor

    @property
    def live(self) -> LoadCase:
        """What the factor multiplies."""
        return self.at.load(self.adverse)

    @property
    def line(self) -> Floats:
        """Stretches (s, 2) [m] of the road on which the line load acts."""
        return self.at.line(self.adverse)


@dataclass(frozen=True, eq=False)
class Crossing:
    """A bridge under a train, wherever it is.

    Attributes
    ----------
    problem
        With its weight and that of the fill.
    tops
    train
    options
    """

    problem: Problem
    tops: Tops
    train: Train
    options: LimitOptions

    @cached_property
    def resisted(self) -> Ints:
        """Positions of the free blocks on which fill resists, where no ties do in its place."""
        model = self.problem.model
        free = ~model.assembly.fixed & ~model.contacts.of_fill.any()
        return np.flatnonzero(free & self.tops.resisting.any(axis=1))

    @cached_property
    def _reserve(self) -> sparse.csc_matrix | None:
        """What the fill resists at each of these blocks as a column, in the units of a program."""
        each = []
        for block in self.resisted.tolist():
            alone = np.zeros_like(self.tops.resisting)
            alone[block] = self.tops.resisting[block]
            each.append(self.problem.statics.scaled_wrench(alone).ravel())
        return sparse.csc_matrix(np.array(each).T) if each else None

    def __call__(self, asked: tuple[float, Sequence[Floats]]) -> PlacedTrain:
        """The largest factor of the train at a place: the lesser one of both ways it may move.

        With the place [m] come stretches (s, 2) [m] of the line load from which it is descended.
        """
        place, lines = asked
        return min((self._placed(place, one, lines) for one in self.train.ways), key=factor_of)

    def lines(self, count: int) -> list[list[Floats]]:
        """For each of some places stretches of the line load to begin with.

        All and none of it at each; of the others, from one sixth of the road to another, each at
        one place at least. At 270 places of nine bridges what mechanisms of all places then make
        of it is within 0.11 % of the least of 59 starts; all and none had up to 108 % more.
        """
        low, high = self.tops.road.ends
        ends = list(combinations(np.linspace(low, high, 7).tolist(), 2))
        each = [np.array([one]) for one in ends]
        every = [np.array([[-np.inf, np.inf]]), np.zeros((0, 2))]
        return [[*every, *each[i % len(each) :: count]] for i in range(count)]

    def at(self, places: Floats, train: Train) -> Iterator[Position]:
        """The train, or what it is turned round, at places [m]."""
        for place, axles in zip(places.tolist(), train.on(self.tops, places), strict=True):
            yield Position(place, train, axles, *train.pieces(self.tops, place))

    def known(self, found: Sequence[PlacedTrain]) -> Known:
        """What mechanisms found at some places say of all: no larger factor is carried there.

        A mechanism ends the train wherever that is when its power makes up for what resists. With
        the factors (p,) come the stretches of the line load by which they are.
        """
        ended = [one for one in found if 0.0 < one.factor < math.inf]
        motion = np.array([self.problem.mechanism(one.found.state.multiplier) for one in ended])
        each = zip(ended, motion, strict=True)
        resists = np.array([one.factor * one.at.power(by[None])[0] for one, by in each])

        def factor(places: Floats) -> tuple[Floats, list[Floats]]:
            ways = [self.at(places, way) for way in self.train.ways]
            least, lines = [], []
            for alike in zip(*ways, strict=True):
                power = np.array([at.power(motion) for at in alike])
                ends = np.divide(resists, power, np.full_like(power, np.inf), where=power > 0.0)
                way, by = np.unravel_index(ends.argmin(), ends.shape)
                least.append(ends[way, by])
                lines.append(alike[way].line(alike[way].adverse(motion[by])))
            return np.array(least), lines

        return factor

    def _placed(self, place: float, train: Train, lines: Sequence[Floats]) -> PlacedTrain:
        """The least of the largest factors over stretches of the line load.

        It is descended from each, then from the best with its ends moved by two pieces.
        """
        (at,) = self.at(np.array([place]), train)
        statics = self.problem.statics
        known: dict[bytes, PlacedTrain] = {}
        largest = PlaneFactors.of(statics, self.options.cone, self._reserve)

        def under(adverse: Bools) -> PlacedTrain:
            key = adverse.tobytes()
            if key not in known:
                live = statics.scaled_wrench(at.load(adverse).wrench)
                known[key] = PlacedTrain(at, largest(live), adverse)
            return known[key]

        starts = [at.on(one) for one in lines]
        acting = [one for one in starts if at.load(one).wrench[statics.free].any()]
        if not acting:
            raise InputError("no axle is on a free block", remedy="give fewer steps")
        best = min((self._descended(under, each) for each in acting), key=factor_of)
        while moved := _moved(best.adverse):
            one = min((self._descended(under, each) for each in moved), key=factor_of)
            if not _less(one, best):
                break
            best = one
        return best

    def _descended(self, under: Callable[[Bools], PlacedTrain], adverse: Bools) -> PlacedTrain:
        """The line load where the mechanism moves down, again as long as the factor decreases."""
        best = under(adverse)
        while len(adverse) and 0.0 < best.factor < math.inf:
            one = under(best.at.adverse(self.problem.mechanism(best.found.state.multiplier)))
            if not _less(one, best):
                break
            best = one
        return best

    def result(self, placed: PlacedTrain) -> Result | None:
        """The forces and the mechanism at the limit; None where they are not balanced."""
        found = placed.found
        if not np.isfinite(found.factor):
            return None
        problem = self.problem
        model = problem.model.with_load(self._loaded(placed, found.factor, found.reserve))
        force = problem.force(found.state.force)
        mechanism = problem.mechanism(found.state.multiplier)
        words = "the largest load that forces balance, and how it gives way beyond"
        return balanced(model, force, found.state.raw, words, mechanism)

    def falls(self, placed: PlacedTrain) -> bool:
        """Whether the mechanism proves that no forces balance a thousandth more.

        Whatever share of its reserve the fill resists with: the whole where it is moved against.
        """
        problem, found = self.problem, placed.found
        beyond = found.factor + _BEYOND * abs(found.factor)
        for state in (found.state, held_still(problem.statics, found.state)):
            motion = problem.mechanism(state.multiplier)
            against = (self.tops.resisting[self.resisted] * motion[self.resisted]).sum(axis=1) < 0.0
            load = self._loaded(placed, beyond, against.astype(np.float64))
            violation, power = mechanism_defects(problem.model.with_load(load), motion)
            if violation <= MECHANISM_TOLERANCE and power > 0.0:
                return True
        return False

    def _loaded(self, placed: PlacedTrain, factor: float, reserve: Floats) -> LoadCase:
        dead = self.problem.model.load
        wrench = np.zeros_like(dead.wrench)
        wrench[self.resisted] = reserve[:, None] * self.tops.resisting[self.resisted]
        acts = LoadCase(wrench, "what the fill resists") if reserve.any() else None
        load = dead + factor * placed.live
        return load if acts is None else load + acts


def factor_of(one: PlacedTrain) -> float:
    """For the least one: what was not found may be less than all others."""
    return -math.inf if math.isnan(one.found.factor) else one.found.factor


def _less(one: PlacedTrain, other: PlacedTrain) -> bool:
    """Whether a factor is less than another by more than rounding."""
    return factor_of(one) < factor_of(other) - 1e-6 * abs(factor_of(other))


def _moved(adverse: Bools) -> list[Bools]:
    """The same pieces (p,) with the ends of all stretches moved by two."""
    wide = np.pad(adverse, 2)
    left, right = wide[:-4], wide[4:]
    others = (adverse | left, adverse | right, adverse & left, adverse & right)
    return [one for one in others if (one != adverse).any()]
