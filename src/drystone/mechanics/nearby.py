"""A rest state from a similar one, by Newton's method on the unrelaxed contact law.

Between similar rest states few corners change between closed and open, or between sticking and
sliding. Newton steps then need about five iterations, a third of those with the relaxed law.
A step that does not lessen what is left is halved; where many corners change this leads nowhere,
and the method stops. A corner about to open or close has part of its stiffness in the step, so that
no block is left without joints for one step, and far away after it.

What plainly stands is as near to the state in which no corner opens or slips, one linear solution.

Where many corners stick and slip in turn, each changes what its neighbours feel, and Newton's steps
go in circles. With the largest friction of each corner given, the law is that of a convex energy.
Its minimum is found, or it has none, and the normal forces there give the friction of the next
round.

Sources: the semismooth Newton method, Qi and Sun 1993; tangents of a smoothed law for what the law
itself leaves, Chen, Qi and Sun 1998; rounds with given friction, Panagiotopoulos 1975, and their
convergence, Necas, Jarusek and Haslinger 1980.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.mechanics.law import (
    BLURRED,
    Compliance,
    ContactResponse,
    FrictionBound,
    respond,
    wrench_size,
)
from drystone.mechanics.newton import Equation, Steps, newton
from drystone.mechanics.rest_state import RestOptions, RestState, Start, block_scale
from drystone.mechanics.statics import Statics
from drystone.solvers.factors import Solve

STALL = 3
"""Largest number of successive steps that do not halve what is left; twice as many where they are
compared with the last two. With 2, the rest state of a tilted curved joint is not found by
way of smooth friction."""

SHORTEST = 0.25
"""Share of a step that is taken whatever it leaves. Measured: full steps take 1,302 in
place of 1,252 on 85 models."""

CHORDS = 2
"""Steps with the same factors in which what is left must become small enough: they
take two thirds of the time of one step with its own factors, which leads as far."""

PLAIN, LOOSE = 0.08, 0.9
"""Unbalanced share of a block up to which a hurried run begins, and from which on, after two
successive steps, a block counts as without joints. Measured from where no corner opens or slips: at
rest, walls have 0.00, domes and vaults 0.01 to 0.03 and arches 0.04 to 0.08; models near their
limits have more, and a run that leads nowhere takes a third of their path. In runs that lead
nowhere the share is 1.0 or more twice."""

IDLE = 0.8
"""Share of what was left two steps before, from which on a step is halved where it may grow.
Measured: a dome of 51 by 40 that is tilted by 0, 4 and 8 degrees takes 21, 32 and 34 factorisations
without and 19, 23 and 25 with it; 50 other domes, vaults and walls take 1,580 and 1,583."""

TRIES, OWN_LAW_EVERY = 50, 5
"""Tries at most, every so many of them by Coulomb's law and the others with given friction.
Measured on 128 models whose path does not converge: 35 are found, after 0 to 28 rounds. What falls
mostly ends in the first or second."""

LIMIT = 100
"""Steps at most; STALL ends a run long before."""


def find_rest_nearby(
    statics: Statics,
    compliance: Compliance,
    options: RestOptions,
    start: Start,
    stop: Callable[[], bool] | None = None,
    hurried: bool = False,
) -> RestState:
    """The rest state near a start.

    Parameters
    ----------
    statics
        No interface may join two fixed blocks.
    compliance
    options
        Only the ground and the tolerance are used.
    start
        A state near a rest state.
    stop
        Called before every step; True ends the iteration.
    hurried
        Whether it begins only where little is unbalanced, and ends where blocks lose their joints.

    Returns
    -------
    RestState
        The last state. That it is not ``converged`` proves nothing.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return descend(statics, compliance, options, start.motion, stop, True, hurried)


def find_rest_by_rounds(
    statics: Statics,
    compliance: Compliance,
    options: RestOptions,
    start: Start,
    stop: Callable[[], bool],
) -> RestState:
    """As :func:`find_rest_nearby`, by rounds with friction that the last normal forces give.

    Those of the start give it first. The state is ``converged`` where Coulomb's law holds in it.
    """
    steps = 0
    for number in range(TRIES):
        own = number % OWN_LAW_EVERY == 0
        springs = compliance if own else _with_given_friction(compliance, start.normal)
        state = find_rest_nearby(statics, springs, options, start, stop)
        steps += state.iterations
        if state.converged is own:
            break
        if not own:
            start = Start(state.motion, state.force[:, 0] + state.tension)
    return replace(state, iterations=steps, converged=own and state.converged)


def _with_given_friction(compliance: Compliance, normal: Floats) -> Compliance:
    """The same with the largest friction (k,) that some normal forces (k,) allow."""
    law = compliance.friction
    given = FrictionBound(np.zeros_like(normal), cohesion=law.bound(normal))
    return replace(compliance, friction=replace(law, bound=given))


def with_forces(
    statics: Statics, compliance: Compliance, options: RestOptions, force: Floats, motion: Floats
) -> Start:
    """A start with the corner forces (k, 3) of a rest state at a motion (n, 6) with other springs.

    These forces balance the loads whatever the stiffness is. With other springs each corner has
    them at another overlap and slide, which no motion of the blocks gives. A step of Newton's
    method from there, with the tangent of the new law, gives a motion. None is taken where the
    blocks rest at this motion with these springs as well.

    Source: the LATIN method, Ladeveze 1999.

    Raises
    ------
    SolverError
        The tangent is singular.
    """
    moved = statics.displacement(motion)
    normal = force[:, 0] if compliance.tension is not None else np.maximum(force[:, 0], 0.0)
    begin = _Law(statics, compliance, options)
    if motion.any() and begin.at(motion, moved).largest <= options.tolerance:
        return Start(motion, np.maximum(normal, 0.0))
    gap = compliance.gap_of(normal, moved[:, 0])
    slide = compliance.friction.slide_of(normal, -force[:, 1:], moved[:, 1:])
    response = respond(compliance, gap, slide)
    tangent, place = response.tangent, np.concatenate([gap[:, None], slide], axis=1)
    pushed = response.force + (tangent @ place[:, :, None])[:, :, 0]
    solve = statics.maps.factorise(tangent, options.ground * statics.mass_matrix)
    return Start(solve(statics.wrench(pushed) + statics.load), np.maximum(normal, 0.0))


def descend(
    statics: Statics,
    compliance: Compliance,
    options: RestOptions,
    motion: Floats,
    stop: Callable[[], bool] | None = None,
    blurred: bool = False,
    hurried: bool = False,
) -> RestState:
    """As :func:`find_rest_nearby`, from a motion (n, 6).

    With ``blurred``, corners about to open or close have part of their stiffness, and what is left
    may grow for one step.
    """
    law = _Law(statics, compliance, options, stop, blurred, hurried)
    begin = law.at(motion, statics.displacement(motion))
    idle = IDLE if blurred else np.inf
    chosen = Steps(LIMIT, SHORTEST, law.memory, chords=CHORDS, idle=idle)
    point, solved, steps = newton(law, begin, chosen)
    normal = compliance.normal * np.maximum(0.0, -point.moved[:, 0] - compliance.overlap)
    response = point.response
    tension = np.broadcast_to(response.tension, normal.shape)
    return RestState(
        point.motion, normal, response.force, tension, point.ground, point.largest, solved, steps
    )


class _Point(NamedTuple):
    """An iterate; ``size`` is that of all unbalanced shares, ``largest`` that of one block."""

    motion: Floats
    moved: Floats
    response: ContactResponse
    ground: Floats
    left: Floats
    scale: Floats
    size: float
    largest: float


class _Law(Equation[_Point, Floats]):
    """Balance under the unrelaxed law."""

    def __init__(
        self,
        statics: Statics,
        compliance: Compliance,
        options: RestOptions,
        stop: Callable[[], bool] | None = None,
        blurred: bool = False,
        hurried: bool = False,
    ) -> None:
        self.statics, self.compliance, self.stop = statics, compliance, stop
        self.goal = options.tolerance
        self.hurried, self.memory = hurried, 2 if blurred else 1
        self.blurred, self.loose, self.first = blurred, 0, 0.0
        self.weight = options.ground * statics.mass_matrix
        self.solve: Solve | None = None

    def at(self, motion: Floats, moved: Floats) -> _Point:
        """The iterate at a motion (n, 6), and at the corner displacements (k, 3) by it."""
        statics = self.statics
        response = respond(self.compliance, moved[:, 0] + self.compliance.overlap, moved[:, 1:])
        ground = self.weight * motion
        left = statics.wrench(response.force) + statics.load - ground
        scale = block_scale(statics, response.force)
        share = wrench_size(left) / scale
        size, largest = float(np.sqrt(share @ share)), float(share.max(initial=0.0))
        return _Point(motion, moved, response, ground, left, scale, size, largest)

    def tolerance(self, point: _Point) -> float:
        del point
        return self.goal

    def solved(self, point: _Point) -> bool:
        return point.largest <= self.goal

    def lost(self, sizes: Sequence[float], point: _Point) -> bool:
        if self.hurried:
            self.loose = self.loose + 1 if point.largest > LOOSE else 0
            if self.loose > 1 or (len(sizes) == 1 and point.largest > PLAIN):
                return True
        after = sizes[1:]  # the first step often makes it worse: progress counts from there
        stall = STALL * self.memory
        stuck = len(after) > stall and min(after[-stall:]) > 0.5 * min(after[:-stall])
        return stuck or (self.stop is not None and self.stop())

    def step(self, point: _Point, renew: bool) -> Floats:
        if renew or self.solve is None:
            self.solve = None  # one set of factors at a time
            self.solve = self.statics.maps.factorise(self.tangent(point), self.weight)
        return self.solve(point.left)

    def tangent(self, point: _Point) -> Floats:
        """(k, 3, 3) with part of the stiffness of corners about to open or close."""
        if not self.blurred:
            return point.response.tangent
        return point.response.blurred(self.width(point) / self.compliance.normal)

    def width(self, point: _Point) -> Floats:
        """Force (k,) of a corner about to change: in arches many times the load of a block."""
        if not self.hurried:
            return BLURRED * point.largest * self.statics.corner_load
        self.first = self.first or point.largest
        share = point.largest * min(1.0, point.largest / self.first)
        scale = np.append(point.scale, np.inf)
        return BLURRED * share * scale.take(self.statics.blocks.T).min(axis=0)

    def after(self, point: _Point, step: Floats, length: float) -> _Point:
        moved = point.moved + length * self.statics.displacement(step)
        return self.at(point.motion + length * step, moved)
