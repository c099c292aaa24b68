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
order of :class:`drystone.formulations.rest.tangent.TangentSystem`.

Sources: Moreau 1962 (decomposition by polar cones); Vandenberghe 2010 (the iteration).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import SolverError
from drystone.formulations.rest.compliance import corner_load
from drystone.formulations.rest.rest_state import mass_matrix
from drystone.formulations.rest.tangent import TangentSystem
from drystone.solvers.cone_scaling import Scaling, inner, longest_step, product, quotient

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

BALANCED = 1e-9
"""Acceleration left, by that of free fall, at which forces balance the loads."""

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
    system: TangentSystem, *, stop: Callable[[], bool] | None = None
) -> NearestMechanism:
    """The mechanism nearest to free fall, or forces that balance the loads, for dry joints.

    Parameters
    ----------
    system
    stop
        Called before every step; True ends the iteration with what it has found.
    """
    return _Iteration(system).run(stop)


class _Iteration:
    """The data that do not change, and the present point."""

    def __init__(self, system: TangentSystem) -> None:
        self.system = system
        self.statics = statics = system.statics
        self.mass = mass_matrix(statics)
        self.scale = np.ones((statics.corner_count, 3))
        self.scale[:, 1:] = statics.friction[:, None]
        size = corner_load(statics)
        self.softness = SOFTNESS / size
        axis = np.array([1.0, 0.0, 0.0])
        self.motion = np.zeros((statics.free_count, 6))
        self.force = size[:, None] * axis
        self.slack = np.full((statics.corner_count, 1), FIRST_SLACK) * axis
        self.steps = 0

    def run(self, stop: Callable[[], bool] | None) -> NearestMechanism:
        """The mechanism where there is one; it is kept while the iteration improves it."""
        found: Floats | None = None
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            while self.steps < STEP_LIMIT and not (stop is not None and stop()):
                unbalanced, apart = self.defects()
                if self.steps:
                    power = float((self.statics.load * self.motion).sum())
                    motion = self.mechanism() if power > 0.0 else None
                    gap = float((self.force * self.slack).sum())
                    left_it = found is not None and motion is None
                    found = found if motion is None else motion
                    done = EXACT if found is None else NEAR
                    if gap <= done * power or left_it:
                        break
                    left = np.abs(unbalanced - self.mass * self.motion) / self.mass
                    if found is None and float(left.max(initial=0.0)) <= BALANCED:
                        break
                try:
                    if not self.step(unbalanced, apart):
                        break
                except SolverError:
                    break
        return NearestMechanism(found, self.scale * self.force, self.steps)

    def defects(self) -> tuple[Floats, Floats]:
        """``M v - p - A S f`` and ``s - S A' v - C f``."""
        statics = self.statics
        borne = statics.load + statics.wrench(self.scale * self.force)
        moved = self.scale * statics.displacement(self.motion)
        return (
            self.mass * self.motion - borne,
            self.slack - moved - self.softness[:, None] * self.force,
        )

    def mechanism(self) -> Floats | None:
        """The motion if it closes no corner, or else without that of blocks that hardly move."""
        speed = np.abs(self.motion).max(axis=1)
        for least in (0.0, STILL):
            moving = speed > least * speed.max()
            motion = np.where(moving[:, None], self.motion, 0.0)
            if self.opens(motion):
                return motion
        return None

    def opens(self, motion: Floats) -> bool:
        """Whether a motion (n, 6) closes no corner so far that forces there could resist it."""
        statics, speed = self.statics, np.append(np.abs(motion).max(axis=1), 0.0)
        local = np.maximum(speed[statics.block_a], speed[statics.block_b])
        closing = np.maximum(0.0, -inner(self.scale * statics.displacement(motion)))
        if (closing > CLOSING * np.maximum(local, 1e-9 * speed.max())).any():
            return False
        resisted = float((closing * np.linalg.norm(self.force, axis=1)).sum())
        return resisted < RESISTED * float((statics.load * motion).sum())

    def step(self, unbalanced: Floats, apart: Floats) -> bool:
        """One step by predictor and corrector; False where it comes to nothing."""
        self.steps += 1
        scaling = Scaling.of(self.force, self.slack)
        both = scaling.apply(self.force)
        tangent = scaling.tangent(self.softness)
        scaled = self.scale[:, :, None] * tangent * self.scale[:, None, :]
        solve = self.system.factorise(scaled, self.mass)
        statics, gap = self.statics, float((self.force * self.slack).sum())

        def direction(aim: Floats) -> tuple[Floats, Floats, Floats]:
            wanted = scaling.apply(quotient(both, aim))
            pushed = wanted + apart
            local = (tangent @ pushed[:, :, None])[:, :, 0]
            motion = solve(statics.wrench(self.scale * local) - unbalanced)
            moved = self.scale * statics.displacement(motion)
            force = (tangent @ (pushed - moved)[:, :, None])[:, :, 0]
            return motion, force, moved + self.softness[:, None] * force - apart

        squared = product(both, both)
        _, force, slack = direction(-squared)
        length = self.length(force, slack)
        left = ((self.force + length * force) * (self.slack + length * slack)).sum() / gap
        aim = -squared - product(scaling.apply(force), scaling.undo(slack))
        aim[:, 0] += float(np.clip(left, 0.0, 1.0)) ** 3 * gap / max(len(both), 1)
        motion, force, slack = direction(aim)
        length = NEAR_BOUNDARY * self.length(force, slack)
        if not np.isfinite(motion).all() or not length > 0.0:
            return False
        self.motion = self.motion + length * motion
        self.force = self.force + length * force
        self.slack = self.slack + length * slack
        return True

    def length(self, force: Floats, slack: Floats) -> float:
        return min(longest_step(self.force, force), longest_step(self.slack, slack))
