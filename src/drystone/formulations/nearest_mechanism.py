"""The mechanism nearest to the acceleration of free fall, or forces that balance the loads.

    minimise  1/2 v' M v - p' v + 1/2 f' C f
    subject to  s = S A' v + C f  and f in second-order cones,  S = diag(1, mu, mu)

M is the mass of the blocks, A the equilibrium matrix, p the loads; ``S f`` are corner forces. At
the solution ``M v = p + A S f`` and ``f . s = 0``. Where forces balance the loads, v is zero. Where
they cannot, v is the motion with which the blocks begin to fall if every slide opens its joint by
the friction coefficient, a collapse mechanism of limit analysis: Moreau's projection of the loads.

The softness C is a billionth of what changes the motion. It gives the program a solution in the
interior of its cones also where faces are parallel, or more forces than needed hold a block.

The primal-dual interior-point method with the scaling of Nesterov and Todd eliminates the forces of
each corner. What is left is the tangent of blocks on springs, ``M + A D A'``, with the elimination
order of :class:`drystone.mechanics.maps.SparseMaps`.

A vector x = (x0, x1, x2) lies in a cone where ``x0 >= |(x1, x2)|``. The scaling W of Nesterov and
Todd takes a point x and a dual point z, both inside, to the same point: ``W x = W^-1 z``. Arrays
hold one cone per row (k, 3).

Sources: Moreau 1962 (decomposition by polar cones); Vandenberghe 2010, The CVXOPT linear and
quadratic cone program solvers, sections 4 and 5 (the iteration).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.base.errors import SolverError
from drystone.mechanics.maps import SINGLE_FROM
from drystone.mechanics.statics import Statics
from drystone.solvers.factors import Refined, Solve


def inner(x: Floats) -> Floats:
    """Distance (k,) of each vector from the boundary along its axis; negative outside the cone."""
    return np.asarray(x[:, 0] - np.hypot(x[:, 1], x[:, 2]))


def product(x: Floats, y: Floats) -> Floats:
    """The Jordan product (k, 3): ``(x . y, x0 (y1, y2) + y0 (x1, x2))``."""
    out = x[:, :1] * y + y[:, :1] * x
    out[:, 0] = (x * y).sum(axis=1)
    return out


def quotient(x: Floats, y: Floats) -> Floats:
    """The vector (k, 3) whose Jordan product with x is y, for x inside the cone."""
    across = x[:, 1] * y[:, 1] + x[:, 2] * y[:, 2]
    first = (x[:, 0] * y[:, 0] - across) / _determinant(x)
    out = (y - first[:, None] * x) / x[:, :1]
    out[:, 0] = first
    return out


def step_lengths(x: Floats, step: Floats) -> Floats:
    """The largest s <= 1 (k,) for which ``x + s step`` stays in each cone, for x inside them."""
    a = step[:, 0] ** 2 - step[:, 1] ** 2 - step[:, 2] ** 2
    b = x[:, 0] * step[:, 0] - x[:, 1] * step[:, 1] - x[:, 2] * step[:, 2]
    c = _determinant(x)
    # the least positive root of a s^2 + 2 b s + c, in the form that does not cancel
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    ahead = np.where(b < 0.0, c / np.where(b < 0.0, root - b, 1.0), np.inf)
    back = np.where(a < 0.0, -(b + root) / np.where(a < 0.0, a, 1.0), np.inf)
    lengths = np.where(b < 0.0, np.where(b * b >= a * c, ahead, np.inf), back)
    # a step through the apex, where rounding may hide the root
    falling = step[:, 0] < 0.0
    to_apex = np.where(falling, -x[:, 0] / np.where(falling, step[:, 0], 1.0), np.inf)
    return np.minimum(np.minimum(lengths, to_apex), 1.0)


@dataclass(frozen=True, eq=False)
class Scaling:
    """W of each cone, by its eigenvalues ``size (grow, 1, 1 / grow)``.

    Attributes
    ----------
    size, grow : (k,)
    along : (k, 2)
        Unit vectors u. The eigenvectors are (1, u), (0, across u), (1, -u).
    """

    size: Floats
    grow: Floats
    along: Floats

    @classmethod
    def of(cls, point: Floats, dual: Floats) -> Scaling:
        """The scaling of points inside the cones."""
        of_point, of_dual = np.sqrt(_determinant(point)), np.sqrt(_determinant(dual))
        x, z = point / of_point[:, None], dual / of_dual[:, None]
        gamma = np.sqrt(0.5 * (1.0 + (x * z).sum(axis=1)))
        middle = (z - x)[:, 1:] / (2.0 * gamma)[:, None]
        first = (z + x)[:, 0] / (2.0 * gamma)
        length = np.hypot(middle[:, 0], middle[:, 1])
        some = length > 0.0
        along = np.where(
            some[:, None], middle / np.where(some, length, 1.0)[:, None], np.array([1.0, 0.0])
        )
        return cls(np.sqrt(of_dual / of_point), first + length, along)

    def apply(self, x: Floats) -> Floats:
        """W x."""
        return self._combined(x, self.size * self.grow, self.size, self.size / self.grow)

    def undo(self, x: Floats) -> Floats:
        """W^-1 x."""
        return self._combined(
            x, 1.0 / (self.size * self.grow), 1.0 / self.size, self.grow / self.size
        )

    def tangent(self, softness: Floats) -> Floats:
        """(k, 3, 3) the inverse of ``W^2 + softness``, for numbers (k,) >= 0."""
        low, middle, high = (
            1.0 / ((self.size * factor) ** 2 + softness)
            for factor in (self.grow, np.ones_like(self.grow), 1.0 / self.grow)
        )
        u, v = self.along[:, 0], self.along[:, 1]
        mean, half = 0.5 * (low + high), 0.5 * (low - high)
        out = np.empty((len(u), 3, 3))
        out[:, 0, 0] = mean
        out[:, 0, 1] = out[:, 1, 0] = half * u
        out[:, 0, 2] = out[:, 2, 0] = half * v
        out[:, 1, 1] = mean * u * u + middle * v * v
        out[:, 2, 2] = mean * v * v + middle * u * u
        out[:, 1, 2] = out[:, 2, 1] = (mean - middle) * u * v
        return out

    def _combined(self, x: Floats, grown: Floats, kept: Floats, shrunk: Floats) -> Floats:
        u, v = self.along[:, 0], self.along[:, 1]
        ahead, across = u * x[:, 1] + v * x[:, 2], u * x[:, 2] - v * x[:, 1]
        plus, minus = 0.5 * grown * (x[:, 0] + ahead), 0.5 * shrunk * (x[:, 0] - ahead)
        ahead, across = plus - minus, kept * across
        return np.stack([plus + minus, u * ahead - v * across, v * ahead + u * across], axis=1)


def _determinant(x: Floats) -> Floats:
    length = np.hypot(x[:, 1], x[:, 2])
    return np.asarray((x[:, 0] - length) * (x[:, 0] + length))


BALANCED = 1e-9
"""Acceleration left, by that of free fall, at which forces balance the loads."""

LIGHTER = 1e-9
"""Share of the mass that holds motions which no force resists."""

SOFTNESS = 1e-11
"""C by the size of the loads: corners close by this share of the acceleration of free fall."""

CLOSING = 1e-6
"""Share of its speed by which a corner may close in a mechanism that is handed out: a tenth of what
a proof allows."""

RESISTED = 0.1
"""Share of the power of the loads that the forces found so far may take up where corners close."""

NEAR = 1e-4
"""Duality gap, by the power of the loads, at which a mechanism is near enough to the nearest one.
Measured on random piles, arches, vaults and domes: the same blocks move as at 1e-8 then."""

LOOSE = 0.1
"""The same where it begins on the way to that with less friction. Measured: to the least friction
of vaults and domes it takes 16 to 31 steps in all, in place of 25 to 86."""

EXACT = 1e-6
"""Duality gap, by the power of the loads, at which the iteration ends in any case."""

NEARLY_BALANCED = 3e-2
"""Acceleration left at which a change of the forces alone is tried. Measured on the shelf,
an arch and a barrel vault, tilted or not: 16 steps in all at 3e-1, 20 here, 26 at 1e-3; each try
costs a factorisation."""

FIRST_SLACK = 0.1
"""Slack of all corners at the start, by the acceleration of free fall. Measured: 1 takes up to
three steps more, and from 0.01 fewer mechanisms are found."""

STILL = 1e-7
"""Share of the fastest speed below which a block may be held still: less than a corner may close,
and more than the softness lets blocks move that the loads press together."""

PART = 1e-2
"""Duality gap, by the power of the loads, at which the blocks that move faster than this share of
the fastest are looked at alone, and at every tenth of it again. Among irregular stones the others
come to rest slowly, and a corner that closes a little beside them hides the mechanism. Measured on
Voronoi stones of 60 to 400 that fall: without it 27 of 37 mechanisms are not found in 60 steps."""

STEP_LIMIT = 60
NEAR_BOUNDARY = 0.99
"""Share of the way to the boundary of the cones that a step may take."""


@dataclass(frozen=True, eq=False)
class NearestMechanism:
    """End of the iteration.

    Attributes
    ----------
    motion : (n, 6), or None
        A mechanism v in scaled numbers.
    force : (k, 3)
        Corner forces in their cones; they balance the loads where there is no mechanism.
    iterations
    way : (n, 6), (k, 3), (k, 3)
        An iterate well inside of the cones.
    """

    motion: Floats | None
    force: Floats
    iterations: int
    way: tuple[Floats, Floats, Floats]


def nearest_mechanism(
    statics: Statics,
    *,
    stop: Callable[[], bool] | None = None,
    after: NearestMechanism | None = None,
) -> NearestMechanism:
    """The mechanism nearest to free fall, or forces that balance the loads, for dry joints.

    Parameters
    ----------
    statics
    stop
        Called before every step; True ends the iteration with what it has found.
    after
        That of the same joints with another friction: it begins on the way to it, and ends sooner.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _Iteration(statics, after).run(stop)


class _Iteration:
    """The present point of the iteration."""

    def __init__(self, statics: Statics, after: NearestMechanism | None = None) -> None:
        self.statics, self.near = statics, NEAR if after is None else LOOSE
        self.mass, self.load = statics.mass_matrix, statics.load
        self.scale = np.ones((statics.corner_count, 3))
        self.scale[:, 1:] = statics.friction[:, None]
        size = statics.corner_load
        self.softness = SOFTNESS / size
        axis = np.array([1.0, 0.0, 0.0])
        slack = np.full((len(size), 1), FIRST_SLACK) * axis
        self.way = np.zeros_like(self.load), size[:, None] * axis, slack
        if after is not None:
            self.way = after.way
        self.motion, self.force, self.slack = self.way
        self.found: Floats | None = None
        self.part, self.of_parts = PART, 0
        self.rough = statics.free_count >= SINGLE_FROM
        self.solve: Solve | None = None
        self.unbalanced, self.apart = self.defects()

    def run(self, stop: Callable[[], bool] | None) -> NearestMechanism:
        """The mechanism where there is one; it is kept while the iteration improves it."""
        steps = 0
        while steps < STEP_LIMIT and not (stop is not None and stop()):
            if (steps and self.done()) or self.balance() or self.in_part(stop):
                break
            steps += 1
            if not self.step():
                break
        steps += self.of_parts
        return NearestMechanism(self.found, self.scale * self.force, steps, self.way)

    def done(self) -> bool:
        """Whether the iteration has come to its end; a mechanism is kept."""
        gap, power = self.gap(), self.power(self.motion)
        if gap > power:
            self.way = self.motion, self.force, self.slack
        better = self.mechanism() if power > 0.0 else None
        before = self.found is not None
        if better is not None:
            self.found = better
        known = self.found is not None
        near = gap <= (self.near if known else EXACT) * power
        return near or (before and better is None) or (not known and self.left() <= BALANCED)

    def balance(self) -> bool:
        """Whether forces balance the loads after a small change; they are kept so.

        Of all changes the least one by the scaling of the iteration. Forces that it keeps in their
        cones are an answer steps before the iteration itself would come to rest.
        """
        if self.found is not None or self.left() > NEARLY_BALANCED:
            return False
        tangent = Scaling.of(self.force, self.slack).tangent(self.softness)
        try:
            solve = self.factorised(tangent, LIGHTER * self.mass)
        except SolverError:
            return False
        force = self.force
        left = self.load + self.wrench(force)
        for _ in range(2):  # the second time for what rounding left
            force = force - (tangent @ self.displacement(solve(left))[:, :, None])[:, :, 0]
            left = self.load + self.wrench(force)
        balanced = np.abs(left / self.mass).max(initial=0.0) <= BALANCED
        if not balanced or inner(force).min(initial=0.0) < 0.0:
            return False
        self.force = force
        return True

    def in_part(self, stop: Callable[[], bool] | None) -> bool:
        """Whether the fastest blocks alone have a mechanism; it is kept."""
        gap, power = self.gap(), self.power(self.motion)
        if self.found is not None or not gap < self.part * power:
            return False
        speed = np.abs(self.motion).max(axis=1)
        moving = speed > self.part * speed.max(initial=0.0)
        self.part = 0.1 * gap / power
        if moving.all() or not moving.any():
            return False
        alone = _Iteration(self.statics.with_free(moving)).run(stop)
        self.of_parts += alone.iterations
        if alone.motion is None:
            return False
        self.found = np.zeros_like(self.motion)
        self.found[moving] = alone.motion
        return True

    def gap(self) -> float:
        """Duality gap."""
        return float((self.force * self.slack).sum())

    def left(self) -> float:
        """Largest acceleration that the forces leave, by that of free fall."""
        left = np.abs(self.unbalanced - self.mass * self.motion) / self.mass
        return float(left.max(initial=0.0))

    def power(self, motion: Floats) -> float:
        """Power of the loads in a motion (n, 6)."""
        return float((self.load * motion).sum())

    def displacement(self, motion: Floats) -> Floats:
        """``S A' v``: (k, 3)."""
        return self.scale * self.statics.displacement(motion)

    def wrench(self, force: Floats) -> Floats:
        """``A S f``: (n, 6)."""
        return self.statics.wrench(self.scale * force)

    def defects(self) -> tuple[Floats, Floats]:
        """``M v - p - A S f`` and ``s - S A' v - C f``."""
        return (
            self.mass * self.motion - self.load - self.wrench(self.force),
            self.slack - self.displacement(self.motion) - self.softness[:, None] * self.force,
        )

    def factorised(self, tangent: Floats, mass: Floats) -> Callable[[Floats], Floats]:
        """The solution with ``mass + A S tangent S A'`` as a function of the right side.

        Where rough factors did not lead on they do not later: the numbers grow apart.
        """
        scaled = self.scale[:, :, None] * tangent * self.scale[:, None, :]
        self.rough &= not isinstance(self.solve, Refined) or self.solve.leads
        self.solve = None  # one set of factors at a time
        self.solve = self.statics.maps.factorise(scaled, mass, self.rough)
        return self.solve

    def mechanism(self) -> Floats | None:
        """The motion, if it closes no corner; or else without that of blocks that hardly move."""
        if self.opens(self.motion):
            return self.motion
        speed = np.abs(self.motion).max(axis=1)
        still = speed <= STILL * speed.max(initial=0.0)
        if not (still & (speed > 0.0)).any():  # it would be the same motion again
            return None
        motion = np.where(still[:, None], 0.0, self.motion)
        return motion if self.opens(motion) else None

    def opens(self, motion: Floats) -> bool:
        """Whether a motion (n, 6) closes no corner so far that forces could resist it."""
        statics = self.statics
        speed = np.append(np.abs(motion).max(axis=1), 0.0)  # a fixed block has the number -1
        local = np.maximum(speed[statics.block_a], speed[statics.block_b])
        closing = np.maximum(0.0, -inner(self.displacement(motion)))
        if (closing > CLOSING * np.maximum(local, 1e-9 * speed.max())).any():
            return False
        resisted = float((closing * lengths(self.force)).sum())
        return resisted < RESISTED * self.power(motion)

    def step(self) -> bool:
        """One step by predictor and corrector; False where it comes to nothing."""
        scaling = Scaling.of(self.force, self.slack)
        both = scaling.apply(self.force)
        tangent = scaling.tangent(self.softness)
        try:
            solve = self.factorised(tangent, self.mass)
        except SolverError:
            return False
        gap = self.gap()

        def direction(aim: Floats) -> tuple[Floats, Floats, Floats]:
            pushed = scaling.apply(quotient(both, aim)) + self.apart
            local = (tangent @ pushed[:, :, None])[:, :, 0]
            motion = solve(self.wrench(local) - self.unbalanced)
            moved = self.displacement(motion)
            force = (tangent @ (pushed - moved)[:, :, None])[:, :, 0]
            return motion, force, moved + self.softness[:, None] * force - self.apart

        squared = product(both, both)
        _, force, slack = direction(-squared)
        length = self.length(force, slack)
        ahead = (self.force + length * force) * (self.slack + length * slack)
        left = min(max(float(ahead.sum() / gap), 0.0), 1.0)
        aim = -squared - product(scaling.apply(force), scaling.undo(slack))
        aim[:, 0] += left**3 * gap / max(len(aim), 1)
        motion, force, slack = direction(aim)
        length = NEAR_BOUNDARY * self.length(force, slack)
        if not (np.isfinite(motion).all() and length > 0.0):
            return False  # the point is kept
        self.motion = self.motion + length * motion
        self.force = self.force + length * force
        self.slack = self.slack + length * slack
        self.unbalanced, self.apart = self.defects()
        return True

    def length(self, force: Floats, slack: Floats) -> float:
        """The longest step that leaves no cone."""
        points = np.concatenate([self.force, self.slack])
        steps = step_lengths(points, np.concatenate([force, slack]))
        return float(steps.min(initial=1.0))
