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

Several models are taken side by side, as rows of the same arrays: for a small model each operation
on arrays takes longer to start than to do. Only what is solved is solved model by model, and no
number of one model depends on another.

Sources: Moreau 1962 (decomposition by polar cones); Vandenberghe 2010 (the iteration).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.errors import SolverError
from drystone.base.ragged import Ragged
from drystone.formulations.balancing import BALANCED, balancing_forces
from drystone.mechanics.statics import Statics
from drystone.solvers.cone_scaling import Scaling, inner, product, quotient, step_lengths

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
    return nearest_mechanisms([statics], stop=stop)[0]


def nearest_mechanisms(
    problems: Sequence[Statics], *, stop: Callable[[], bool] | None = None
) -> list[NearestMechanism]:
    """:func:`nearest_mechanism` of each of several models, side by side."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _Iteration(problems).run(stop)


class _Iteration:
    """The present points of the models that are not ended yet: rows of blocks and of corners."""

    def __init__(self, problems: Sequence[Statics]) -> None:
        self.problems = list(problems)
        self.number = np.arange(len(problems))
        self.ended: dict[int, NearestMechanism] = {}
        self.found: dict[int, Floats] = {}
        every = self.problems
        self.blocks = Ragged.from_counts([one.free_count for one in every])
        self.corners = Ragged.from_counts([one.corner_count for one in every])
        self.mass = np.concatenate([one.mass_matrix for one in every])
        self.load = np.concatenate([one.load for one in every])
        self.scale = np.ones((self.corners.rows, 3))
        self.scale[:, 1:] = np.concatenate([one.friction for one in every])[:, None]
        size = np.concatenate([one.corner_load for one in every])
        self.softness = SOFTNESS / size
        axis = np.array([1.0, 0.0, 0.0])
        self.motion = np.zeros_like(self.load)
        self.force = size[:, None] * axis
        self.slack = np.full((len(size), 1), FIRST_SLACK) * axis
        self.steps = 0
        self.rows_known()
        self.unbalanced, self.apart = self.defects()

    def rows_known(self) -> None:
        """The rows of each model, as slices."""
        self.of_block, self.of_corner = list(self.blocks), list(self.corners)

    def run(self, stop: Callable[[], bool] | None) -> list[NearestMechanism]:
        """The mechanism of each where there is one; it is kept while the iteration improves it."""
        while len(self.number):
            late = self.steps >= STEP_LIMIT or (stop is not None and stop())
            self.end(np.full(len(self.number), late))
            if len(self.number):
                self.end(self.done())
            if len(self.number):
                self.end(self.balance())
            if len(self.number):
                self.end(self.step())
        return [self.ended[number] for number in range(len(self.ended))]

    def end(self, which: Bools) -> None:
        """Keep the answers of some models (c,), and go on without them."""
        if not which.any():
            return
        for i in np.flatnonzero(which).tolist():
            rows = self.of_corner[i]
            force = self.scale[rows] * self.force[rows]
            motion = self.found.get(int(self.number[i]))
            self.ended[int(self.number[i])] = NearestMechanism(motion, force, self.steps)
        self.problems = [one for one, gone in zip(self.problems, which, strict=True) if not gone]
        self.number = self.number[~which]
        if not len(self.number):
            return
        self.blocks, blocks = self.blocks.take(~which)
        self.corners, corners = self.corners.take(~which)
        self.rows_known()
        for name in ("mass", "load", "motion", "unbalanced"):
            setattr(self, name, getattr(self, name)[blocks])
        for name in ("scale", "softness", "force", "slack", "apart"):
            setattr(self, name, getattr(self, name)[corners])

    def done(self) -> Bools:
        """(c,) the models whose iteration has come to its end; their mechanisms are kept."""
        if not self.steps:
            return np.zeros(len(self.number), dtype=bool)
        power = self.power(self.motion)
        better = self.mechanisms(power > 0.0)
        before = np.array([number in self.found for number in self.number.tolist()])
        after = np.array([number in better for number in self.number.tolist()])
        self.found |= better
        known = before | after
        gap = self.corners.sum((self.force * self.slack).sum(axis=1))
        near = gap <= np.where(known, NEAR, EXACT) * power
        done: Bools = near | (before & ~after) | ((self.left() <= BALANCED) & ~known)
        return done

    def balance(self) -> Bools:
        """(c,) the models whose forces balance the loads after a small change; they are kept so.

        Of all changes the least one by the scaling of the iteration. Forces that it keeps in their
        cones are an answer steps before the iteration itself would come to rest.
        """
        balances = np.zeros(len(self.number), dtype=bool)
        near = self.left() <= NEARLY_BALANCED
        near &= [number not in self.found for number in self.number.tolist()]
        for i in np.flatnonzero(near).tolist():
            corner = self.of_corner[i]
            force, slack, softness = (
                one[corner] for one in (self.force, self.slack, self.softness)
            )
            tangent = Scaling.of(force, slack).tangent(softness)
            changed = balancing_forces(self.problems[i], self.scale[corner], force, tangent)
            if changed is not None:
                balances[i], self.force[corner] = True, changed
        return balances

    def left(self) -> Floats:
        """(c,) largest acceleration that the forces of each model leave, by that of free fall."""
        left = np.abs(self.unbalanced - self.mass * self.motion) / self.mass
        return self.blocks.max(left.max(axis=1), empty=0.0)

    def power(self, motion: Floats) -> Floats:
        """(c,) power of the loads of each model in a motion (n, 6)."""
        power: Floats = self.blocks.sum((self.load * motion).sum(axis=1))
        return power

    def displacement(self, motion: Floats) -> Floats:
        """``S A' v``: (k, 3) of all models."""
        rows = zip(self.problems, self.of_block, strict=True)
        return self.scale * np.concatenate(
            [statics.displacement(motion[block]) for statics, block in rows]
        )

    def wrench(self, force: Floats) -> Floats:
        """``A S f``: (n, 6) of all models."""
        scaled = self.scale * force
        rows = zip(self.problems, self.of_corner, strict=True)
        return np.concatenate([statics.wrench(scaled[corner]) for statics, corner in rows])

    def defects(self) -> tuple[Floats, Floats]:
        """``M v - p - A S f`` and ``s - S A' v - C f``."""
        return (
            self.mass * self.motion - self.load - self.wrench(self.force),
            self.slack - self.displacement(self.motion) - self.softness[:, None] * self.force,
        )

    def mechanisms(self, asked: Bools) -> dict[int, Floats]:
        """The motion of each model (c,) that is asked for, if it closes no corner.

        Or else without that of blocks that hardly move.
        """
        speed = np.abs(self.motion).max(axis=1)
        fastest = self.blocks.spread(self.blocks.max(speed, empty=0.0))
        found: dict[int, Floats] = {}
        for least in (0.0, STILL):
            if not asked.any():
                break
            moving = speed > least * fastest
            if least > 0.0:  # others would be the same motion again
                asked = asked & self.blocks.any(~moving & (speed > 0.0))
            motion = np.where(moving[:, None], self.motion, 0.0)
            opens = asked & self.opens(motion)
            for i in np.flatnonzero(opens).tolist():
                found[int(self.number[i])] = motion[self.of_block[i]]
            asked = asked & ~opens
        return found

    def opens(self, motion: Floats) -> Bools:
        """(c,) whether a motion (n, 6) closes no corner so far that forces could resist it."""
        speed = np.abs(motion).max(axis=1)
        fastest = self.corners.spread(self.blocks.max(speed, empty=0.0))
        local = np.concatenate(
            [
                _of_corners(statics, speed[block])
                for statics, block in zip(self.problems, self.of_block, strict=True)
            ]
        )
        closing = np.maximum(0.0, -inner(self.displacement(motion)))
        closed = self.corners.any(closing > CLOSING * np.maximum(local, 1e-9 * fastest))
        resisted = self.corners.sum(closing * np.linalg.norm(self.force, axis=1))
        opens: Bools = ~closed & (resisted < RESISTED * self.power(motion))
        return opens

    def step(self) -> Bools:
        """One step by predictor and corrector; (c,) the models where it comes to nothing."""
        self.steps += 1
        unbalanced, apart = self.unbalanced, self.apart
        scaling = Scaling.of(self.force, self.slack)
        both = scaling.apply(self.force)
        tangent = scaling.tangent(self.softness)
        scaled = self.scale[:, :, None] * tangent * self.scale[:, None, :]
        solves: list[Callable[[Floats], Floats]] = []
        for statics, block, corner in zip(
            self.problems, self.of_block, self.of_corner, strict=True
        ):
            solves.append(_solution(statics, scaled[corner], self.mass[block]))
        gap = self.corners.sum((self.force * self.slack).sum(axis=1))

        def direction(aim: Floats) -> tuple[Floats, Floats, Floats]:
            wanted = scaling.apply(quotient(both, aim))
            pushed = wanted + apart
            local = (tangent @ pushed[:, :, None])[:, :, 0]
            right = self.wrench(local) - unbalanced
            rows = zip(solves, self.of_block, strict=True)
            motion = np.concatenate([solve(right[block]) for solve, block in rows])
            moved = self.displacement(motion)
            force = (tangent @ (pushed - moved)[:, :, None])[:, :, 0]
            return motion, force, moved + self.softness[:, None] * force - apart

        squared = product(both, both)
        _, force, slack = direction(-squared)
        length = self.corners.spread(self.lengths(force, slack))[:, None]
        ahead = (self.force + length * force) * (self.slack + length * slack)
        left = np.clip(self.corners.sum(ahead.sum(axis=1)) / gap, 0.0, 1.0)
        aim = -squared - product(scaling.apply(force), scaling.undo(slack))
        aim[:, 0] += self.corners.spread(left**3 * gap / np.maximum(self.corners.counts, 1))
        motion, force, slack = direction(aim)
        lengths = NEAR_BOUNDARY * self.lengths(force, slack)
        finite = self.blocks.all(np.asarray(np.isfinite(motion).all(axis=1)))
        works = finite & (lengths > 0.0)
        lengths = np.where(works, lengths, 0.0)
        by_block = self.blocks.spread(lengths)[:, None]
        by_corner = self.corners.spread(lengths)[:, None]
        # a model that ends keeps its point
        self.motion = np.where(by_block > 0.0, self.motion + by_block * motion, self.motion)
        self.force = np.where(by_corner > 0.0, self.force + by_corner * force, self.force)
        self.slack = np.where(by_corner > 0.0, self.slack + by_corner * slack, self.slack)
        self.unbalanced, self.apart = self.defects()
        return ~works

    def lengths(self, force: Floats, slack: Floats) -> Floats:
        """(c,) the longest step of each model that leaves no cone."""
        points = np.concatenate([self.force, self.slack])
        both = step_lengths(points, np.concatenate([force, slack])).reshape(2, -1)
        least: Floats = self.corners.min(both.min(axis=0), empty=1.0)
        return least


def _of_corners(statics: Statics, speed: Floats) -> Floats:
    """Larger value (k,) of the two blocks of each corner, of values (n,) of the free blocks."""
    of_block = np.append(speed, 0.0)  # a fixed block has the number -1
    return np.maximum(of_block[statics.block_a], of_block[statics.block_b])


def _solution(statics: Statics, tangent: Floats, mass: Floats) -> Callable[[Floats], Floats]:
    """The factorised tangent."""
    try:
        return statics.maps.factorise(tangent, mass)
    except SolverError:
        return _no_solution


def _no_solution(right: Floats) -> Floats:
    return np.full_like(right, np.nan)
