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

Sources: Moreau 1962 (decomposition by polar cones); Vandenberghe 2010 (the iteration).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.base.errors import SolverError
from drystone.mechanics.statics import Statics
from drystone.solvers.cone_scaling import Scaling, inner, product, quotient, step_lengths

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
    """

    motion: Floats | None
    force: Floats
    iterations: int


def nearest_mechanism(
    statics: Statics, *, stop: Callable[[], bool] | None = None
) -> NearestMechanism:
    """The mechanism nearest to free fall, or forces that balance the loads, for dry joints.

    Parameters
    ----------
    statics
    stop
        Called before every step; True ends the iteration with what it has found.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _Iteration(statics).run(stop)


class _Iteration:
    """The present point of the iteration."""

    def __init__(self, statics: Statics) -> None:
        self.statics = statics
        self.mass, self.load = statics.mass_matrix, statics.load
        self.scale = np.ones((statics.corner_count, 3))
        self.scale[:, 1:] = statics.friction[:, None]
        size = statics.corner_load
        self.softness = SOFTNESS / size
        axis = np.array([1.0, 0.0, 0.0])
        self.motion = np.zeros_like(self.load)
        self.force = size[:, None] * axis
        self.slack = np.full((len(size), 1), FIRST_SLACK) * axis
        self.found: Floats | None = None
        self.unbalanced, self.apart = self.defects()

    def run(self, stop: Callable[[], bool] | None) -> NearestMechanism:
        """The mechanism where there is one; it is kept while the iteration improves it."""
        steps = 0
        while steps < STEP_LIMIT and not (stop is not None and stop()):
            if (steps and self.done()) or self.balance():
                break
            steps += 1
            if not self.step():
                break
        return NearestMechanism(self.found, self.scale * self.force, steps)

    def done(self) -> bool:
        """Whether the iteration has come to its end; a mechanism is kept."""
        power = self.power(self.motion)
        better = self.mechanism() if power > 0.0 else None
        before = self.found is not None
        if better is not None:
            self.found = better
        known = self.found is not None
        gap = float((self.force * self.slack).sum())
        near = gap <= (NEAR if known else EXACT) * power
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
        """The solution with ``mass + A S tangent S A'`` as a function of the right side."""
        scaled = self.scale[:, :, None] * tangent * self.scale[:, None, :]
        return self.statics.maps.factorise(scaled, mass)

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
        gap = float((self.force * self.slack).sum())

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
