"""The rest state of blocks on unilateral contact springs with Coulomb friction.

For given normal stiffnesses kn and a friction law T the unknowns are the motions q of the free
blocks. With ``d = A' q = (dn, dt)`` at each corner:

    fn = kn max(0, -dn),    ft = -T(fn, dt),    A (fn, ft) + p - g M q = 0

At joints that pull, ``fn - pull(s)`` stands in place of fn in T and in the balance.

g M is a weak ground spring proportional to mass. If a rest state exists, its share of the load
tends to zero with g. If none exists, ``g q`` tends to the acceleration of the falling blocks.

The contact law is the complementarity ``fn >= 0, s = dn + fn / kn >= 0, fn s = 0``; it is relaxed
to ``fn s = tau`` and followed to tau = 0 by a primal-dual Newton method. At each corner the product
fn s is kept within a band around tau. This replaces the usual ratio test: no corner can block a
step. About 20 steps are enough for 4 blocks and for 10,000.

Sources: complementarity by interior points, Wright 1997; the law as the compatible state of coupled
rigid-block analysis, Kao et al. 2022, eq. 5.6.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.mechanics.bodies import LIGHT
from drystone.mechanics.law import Compliance, FrictionResponse, pressing, wrench_size
from drystone.mechanics.nearby import descend
from drystone.mechanics.newton import Equation, Steps, newton
from drystone.mechanics.rest_state import RestOptions, RestState, Start, block_scale
from drystone.mechanics.statics import Statics

SHORTEST_STEP = 2e-3
"""Smallest share of a Newton step: rounding makes a shorter one meaningless."""

POLISH_AGAIN = 1e-2
"""Share of tau after which the unrelaxed law is tried again. Measured: 1e-1 takes as many steps
in all."""

IDLE_STEPS = 6
"""Steps at one tau without progress after which a fall is likely, and the unrelaxed law is tried
again. Measured: a pack of 30 then takes 85 steps in place of 95, and 38 other small models as many
as before. Not where joints still pull more: one of five such domes was then robust no more."""

LONG_STEPS = 25
"""Steps from which on a fall is likely too. Measured: a wall of 45 courses that falls takes 39 in
place of 76, and models that stand as many as before: hardly one takes more."""

GROWN = 1e8
"""Times what was left at first from which on a path leads nowhere, if no block is light. Measured
on 550 models: 6e3 at most where it comes to rest, 1e10 and more on half of those that do not and
begin at rough states."""

SINKING = 1e-3
"""Share of a block's load on the ground, if it moved as far as its joints open, close or slide,
from which on a fall is likely. Measured: structures that stand, near their limits and not, carry
5e-5 at most all along the path; those that fall carry 1e-3 after 5 to 13 steps, or make no progress
before. The blocks themselves move as far in towers and walls of 300 courses that stand, a little in
each joint: a fall of 100,014 blocks was then sought for minutes."""


def find_rest(
    statics: Statics,
    compliance: Compliance,
    options: RestOptions | None = None,
    *,
    start: RestState | Start | None = None,
    stop: Callable[[], bool] | None = None,
    falls: Callable[[], bool] | None = None,
) -> RestState:
    """Follow the relaxed contact law to a rest state.

    Parameters
    ----------
    statics
        No interface may join two fixed blocks.
    compliance
    options
    start
        A state of this model or of a similar one.
    stop
        Called before every step; True ends the iteration with the present state.
    falls
        Whether there is no rest state. Called once, where the iteration makes no progress or the
        ground carries much; True ends it with the present state.
    """
    chosen = options if options is not None else RestOptions()
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        # a diverging trial step overflows and is rejected by the merit function
        state = _Path(statics, compliance, chosen, stop=stop, falls=falls).follow(start)
        if compliance.tension is None or state.converged or (stop is not None and stop()):
            return state
        # joints that pull more at first can lead away from the rest state
        other = _Path(statics, compliance, chosen, harder=False, stop=stop).follow(start)
        steps = state.iterations + other.iterations
        return replace(other if other.converged else state, iterations=steps)


class _Path(Equation["_Point", tuple[Floats, Floats, Floats]]):
    """One run of the primal-dual iteration, with the data that do not change."""

    def __init__(
        self,
        statics: Statics,
        compliance: Compliance,
        options: RestOptions,
        *,
        harder: bool = True,
        stop: Callable[[], bool] | None = None,
        falls: Callable[[], bool] | None = None,
    ) -> None:
        self.harder = harder and compliance.tension is not None
        self.statics = statics
        self.law = compliance.friction
        self.compliance = compliance
        self.kn, self.quarter = compliance.normal, 0.25 * compliance.normal
        self.most = np.inf if compliance.most is None else compliance.most
        self.overlap = compliance.overlap
        self.glue = compliance.glue * compliance.normal
        self.options = options
        self.end = options.end
        self.steps = 0
        self.stop, self.falls = stop, falls
        self.state: RestState | None = None
        self.since, self.over, self.fallen = 0, False, False
        self.leap: tuple[_Point, _Point] | None = None
        self.leaps = bool(statics.load_size.min(initial=1.0) < LIGHT)
        self.best = np.inf
        self.ground = options.ground * statics.mass_matrix
        self.unit = statics.corner_load**2 / self.kn
        self.band = np.array([[options.band], [1.0 / options.band]]) * self.unit
        self.row_scale = statics.load_scale[:, None]
        weak = np.append(options.ground * statics.mass / statics.load_scale, 0.0)
        self.far = SINKING / np.maximum(weak[statics.block_a], weak[statics.block_b])

    def follow(self, start: RestState | Start | None) -> RestState:
        """The rest state, or the state where the iteration ends."""
        begin = self.evaluate(*self.begin(start))
        self.polish_at = self.options.polish
        self.best = begin.size
        shortest = max(SHORTEST_STEP, self.options.give_up)
        grown = np.inf if self.leaps else GROWN
        steps = Steps(self.options.iteration_limit, shortest, memory=1, grown=grown)
        point, solved, _ = newton(self, begin, steps)
        return self.state if solved and self.state is not None else self.unrelaxed(point)

    def tolerance(self, point: _Point) -> float:
        del point
        return 0.0

    def solved(self, point: _Point) -> bool:
        self.state = None
        if self.parts_far(point.moved) and self.fell():
            return False
        if self.due(point.tau):
            self.state = self.polish(point)
            self.polish_at = point.tau * POLISH_AGAIN
        if self.state is None and (point.tau <= self.options.relaxation or point.size < 1e-6):
            state = self.unrelaxed(point)
            self.state = state if state.converged else None
        return self.state is not None

    def due(self, tau: float) -> bool:
        """Whether the unrelaxed law is to be tried: where tau is small, and without progress."""
        idle = self.since == IDLE_STEPS and not self.harder
        return tau <= self.polish_at or (idle and tau < self.options.polish)

    def lost(self, sizes: Sequence[float], point: _Point) -> bool:
        options = self.options
        del sizes, point
        if self.steps >= options.iteration_limit or self.since > options.stall or self.over:
            return True
        if self.stop is not None and self.stop():
            return True
        slow = self.since >= IDLE_STEPS or self.steps >= LONG_STEPS
        return self.fallen or (slow and self.fell())

    def fell(self) -> bool:
        """Whether there is no rest state; it is asked once."""
        if self.falls is not None:
            asked, self.falls = self.falls, None
            self.fallen = asked()
        return self.fallen

    def accepted(self, point: _Point, trial: _Point, length: float) -> _Point:
        """Where a step has led, with a smaller tau if it may be."""
        self.over = length < self.options.give_up
        self.since += 1
        trial = self.led(point, trial, length)
        if trial is point:
            return point
        reduced = trial.size < 0.1 * point.size
        tau, before = trial.tau, trial.tau
        if trial.size < tau * np.sqrt(len(trial.normal) + 1.0) or (length > 0.9 and reduced):
            # near the end of the path the error is far below tau: reduce tau more
            tau = max((0.1 if tau > 1e-6 else 0.01) * tau, self.options.relaxation)
        elif trial.size < 1e-11:
            tau = max(0.01 * tau, self.options.relaxation)
        if tau < before:
            trial = self.with_tau(trial, tau)
        if tau < before or trial.size < 0.5 * self.best:
            self.best, self.since = trial.size, 0
        return trial

    def led(self, point: _Point, trial: _Point, length: float) -> _Point:
        """Where a step has led; ``point`` itself where it leaves much more.

        Where all joints of some blocks slip, the tangent is almost singular. The next steps have
        the secant of friction, until one is taken in full or leaves more. Where the first of them
        leads nowhere, the step is taken after all, as are others from then on; and beside much
        heavier blocks, where it tells little. Measured: walls tilted to 0.7 of their friction take
        24 to 38 steps, and 167 to 248 without.
        """
        if self.leap is None:
            if trial.size <= 10.0 * point.size or self.leaps:
                return trial
            self.leap = point, trial
            return point
        (before, leap), ended = self.leap, length <= SHORTEST_STEP
        if ended or length == 1.0 or trial.size >= point.size:
            self.leap = None
        if not (ended and before is point):
            return trial
        self.leaps, self.since = True, self.since - 1
        return leap

    def parts_far(self, moved: Floats) -> bool:
        """Whether blocks move so far apart (k, 3) that the ground would carry much of one of them.

        A high wall leans on the ground too, as all of its joints give a little.
        """
        return bool((lengths(moved) > self.far).any())

    def polish(self, point: _Point) -> RestState | None:
        """The rest state by Newton steps on the unrelaxed law; None if they do not converge.

        Near the end of the path few corners still change between closed and open. The first try is
        on the ground of the end, and counts where the given ground would carry little.
        """
        statics, options, ended = self.statics, self.options, False
        if self.end is not None and not self.parts_far(point.moved):
            options, ended, self.end = self.end, True, None
        state = descend(statics, self.compliance, options, point.motion, self.stop)
        self.steps += state.iterations
        if not state.converged or (ended and self.parts_far(statics.displacement(state.motion))):
            return None
        return replace(state, iterations=self.steps, ended=ended)

    def begin(self, start: RestState | Start | None) -> tuple[Floats, Floats, float]:
        statics = self.statics
        if start is None:
            gap = np.full(statics.corner_count, self.overlap)
            motion = np.zeros((statics.free_count, 6))
            return motion, self.relaxed_normal(gap, self.unit), 1.0
        tau = self.options.warm_relaxation
        gap = statics.displacement(start.motion)[:, 0] + self.overlap
        return start.motion, np.clip(start.normal, *self.limits(gap, tau)), tau

    def pull(self, opening: Floats, tau: float) -> tuple[Floats, Floats]:
        """Pull of joints that open by some lengths (k,), and its slope.

        Near its limit the slope of the pull is almost zero, and Newton steps are too long. So the
        pull hardens by the share sqrt(tau) of the stiffness, which vanishes at the end of the path.
        """
        held, slope = self.compliance.pull(opening)
        if not self.harder or tau == 0.0:
            return held, slope
        harder = np.sqrt(tau) * self.kn
        return held + harder * opening, slope + harder

    def limits(self, gap: Floats, tau: float) -> tuple[Floats, Floats]:
        """Normal forces between which the product fn s stays in the band around tau."""
        low, high = self.relaxed_normal(gap, tau * self.band)
        return low, high

    def relaxed_normal(self, gap: Floats, product: Floats) -> Floats:
        """The positive root fn of ``fn (gap + fn / kn) = product``, without cancellation."""
        half = 0.5 * (np.sqrt(gap**2 + product / self.quarter) + np.abs(gap))
        return np.where(gap < 0.0, self.kn * half, product / half)

    def evaluate(
        self, motion: Floats, normal: Floats, tau: float, moved: Floats | None = None
    ) -> _Point:
        """All quantities of an iterate; ``moved`` are its corner displacements, if known."""
        statics = self.statics
        if moved is None:
            moved = statics.displacement(motion)
        slack = moved[:, 0] + self.overlap + normal / self.kn
        bearing = np.minimum(normal, self.most) - self.pull(slack, tau)[0]
        friction = self.law(bearing, moved[:, 1:])
        net = bearing - self.glue * slack
        unbalanced = statics.wrench(pressing(net, friction)) + statics.load - self.ground * motion
        return self.sized(_Point(motion, normal, moved, friction, unbalanced, slack, tau, np.inf))

    def sized(self, point: _Point) -> _Point:
        """The same with its size."""
        left = point.unbalanced / self.row_scale
        centring = (point.normal * point.slack) / self.unit - point.tau
        size = math.sqrt(np.add.reduce(left**2, axis=None) + np.add.reduce(centring**2))
        return point._replace(size=size)

    def with_tau(self, point: _Point, tau: float) -> _Point:
        """The same relaxed to another tau; only joints that pull feel it."""
        if self.harder:
            return self.evaluate(point.motion, point.normal, tau)
        return self.sized(point._replace(tau=tau))

    def step(self, point: _Point, renew: bool) -> tuple[Floats, Floats, Floats]:
        """Changes of motion (n, 6), corner displacement (k, 3) and normal force (k,)."""
        del renew
        self.steps += 1
        statics, tau = self.statics, point.tau
        rigidity = np.maximum(point.slack + point.normal / self.kn, 1e-300)
        stiffness = point.normal / rigidity
        shift = (tau * self.unit - point.normal * point.slack) / rigidity
        by_slide, by_normal = point.friction.slope(self.leap is not None)
        held = self.pull(point.slack, tau)[1]
        opening, elastic = 1.0 - stiffness / self.kn, point.normal < self.most
        bearing = stiffness * elastic + held * opening
        tangent = np.zeros((3, 3, len(stiffness))).transpose(2, 0, 1)
        tangent[:, 0, 0] = bearing + self.glue * opening
        tangent[:, 1:, 0] = -by_normal * bearing[:, None]
        tangent[:, 1:, 1:] = by_slide
        borne = shift * (elastic - held / self.kn)
        net = borne - shift * (self.glue / self.kn)
        correction = np.concatenate([net[:, None], -by_normal * borne[:, None]], axis=1)
        right = point.unbalanced + statics.wrench(correction)
        motion = statics.maps.factorise(tangent, self.ground)(right)
        moved = statics.displacement(motion)
        return motion, moved, shift - stiffness * moved[:, 0]

    def after(self, point: _Point, step: tuple[Floats, Floats, Floats], length: float) -> _Point:
        """The iterate after a share of a step."""
        motion, moved, normal = step
        place = point.moved + length * moved
        low, high = self.limits(place[:, 0] + self.overlap, point.tau)
        target = np.minimum(np.maximum(point.normal + length * normal, low), high)
        return self.evaluate(point.motion + length * motion, target, point.tau, place)

    def unrelaxed(self, point: _Point) -> RestState:
        statics = self.statics
        open_ = point.slack * self.kn > point.normal
        presses = np.minimum(point.normal, self.most)
        bearing = np.where(open_, -self.pull(point.slack, 0.0)[0], presses)
        tension = np.where(open_, self.glue * point.slack, 0.0)
        friction = self.law(bearing, point.moved[:, 1:])
        force = pressing(bearing - tension, friction)
        ground = self.ground * point.motion
        rest = wrench_size(statics.wrench(force) + statics.load - ground)
        unbalanced = float((rest / block_scale(statics, force)).max(initial=0.0))
        return RestState(
            point.motion,
            point.normal,
            force,
            tension,
            ground,
            unbalanced,
            unbalanced <= self.options.tolerance,
            self.steps,
        )


class _Point(NamedTuple):
    """All quantities of one iterate; ``size`` is the merit function."""

    motion: Floats
    normal: Floats
    moved: Floats
    friction: FrictionResponse
    unbalanced: Floats
    slack: Floats
    tau: float
    size: float
