"""Rest on joints whose stiffnesses differ, but not without bounds.

In the rigid limit equally pressed corners may share a load in any proportion; springs share it as
stiff as they are. Here every corner that closes presses with a stiffness of its own times its
overlap, no stiffness is more than ``spread`` times another, and friction acts against the slide, as
far as the cone goes. A motion is turned step by step until such forces balance the loads.

What is made small on the way is cohesion: so much shear as every joint would have to carry beyond
its friction. With enough of it almost any motion balances the loads, so that the way down seldom
ends where no forces balance them at all. Motion and forces, linearised together, form linear
programs with a trust region on the slides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drystone.formulations.compatible import compatible_forces, slide_directions
from drystone.formulations.compliance import corner_load, wrench_size
from drystone.formulations.corner_blocks import NORMAL, CornerBlocks
from drystone.formulations.improvement import TURN, CompatibleState
from drystone.geometry.arrays import Floats, Ints
from drystone.solvers.conic import Cones, ConicOptions, ConicStatus, solve_conic
from drystone.solvers.triplets import Triplets
from drystone.statics import Statics

TOUCHING = 1e-7
"""A gap below this share of the largest overlap is none: the corner may close or open."""

ROUNDING = 1.0 + 1e-6
"""Share by which a spread may miss what is asked for."""

BALANCED = 1e-8
"""Load left over, by the loads, of a state that is worth checking."""

LOADED = 1e-6
"""Forces below this share of the largest say nothing of the stiffness of their joint."""

DEAR = 3.0
"""What load left unbalanced costs, by its share of a block's load, where cohesion costs 1."""

SOFT = 1.0 / 3.0
"""Stiffness at the beginning, by the middle of the range: motions led from the stiffer side of the
middle to twice as many states of the wedges of Kao 2023."""

PATIENCE = 6
"""Steps with little progress after which a motion is given up."""

CLOSER = (0.3, 0.6, 0.85)
"""Shares of a spread that are tried to bring stiffnesses closer, one after the other."""

ALIKE = 2.0
"""Stiffnesses that differ by no more than this factor are not worth bringing closer."""


@dataclass(frozen=True)
class RangeOptions:
    """Options of :func:`settle`.

    Attributes
    ----------
    spread
        Largest ratio of two stiffnesses.
    tolerance
        Cohesion and load left over, by the loads, that are none.
    iteration_limit
    """

    spread: float = 200.0
    tolerance: float = 1e-9
    iteration_limit: int = 40


def settle(
    statics: Statics,
    motion: Floats,
    options: RangeOptions | None = None,
    *,
    stop: Callable[[], bool] | None = None,
) -> CompatibleState:
    """Turn a motion until springs of some stiffness within the range balance the loads with it.

    Parameters
    ----------
    statics
    motion : (n, 6)
        Where to start; its size does not matter.
    options
    stop
        Asked before every step.
    """
    return _Turning(statics, options if options is not None else RangeOptions(), stop).run(motion)


def evened(
    statics: Statics,
    state: CompatibleState,
    content: float = ALIKE,
    options: RangeOptions | None = None,
    *,
    stop: Callable[[], bool] | None = None,
) -> CompatibleState:
    """A state nearby that balances the loads on joints whose stiffnesses differ less.

    Parameters
    ----------
    statics
    state
        Of :func:`settle`, balanced.
    content
        Spread that is small enough.
    options
        Tolerance and limit of the steps.
    stop
    """
    chosen = options if options is not None else RangeOptions()
    enough = BALANCED * float(np.linalg.norm(statics.load))
    spread, programs = spread_of(statics, state), state.iterations
    going = True
    while going and spread > content * ROUNDING:
        going = False
        for share in CLOSER:
            within = replace(chosen, spread=max(share * spread, content))
            trial = settle(statics, state.motion, within, stop=stop)
            programs += trial.iterations
            if trial.unbalanced <= enough and spread_of(statics, trial) < spread:
                state, spread, going = trial, spread_of(statics, trial), True
                break
    return replace(state, iterations=programs)


def spread_of(statics: Statics, state: CompatibleState) -> float:
    """Largest ratio of the stiffnesses of two corners that press."""
    overlap = -statics.displacement(state.motion)[:, 0]
    normal = state.force[:, 0]
    pressed = (normal > LOADED * normal.max(initial=0.0)) & (overlap > 0.0)
    stiffness = normal[pressed] / overlap[pressed]
    return float(stiffness.max() / stiffness.min()) if len(stiffness) else 1.0


@dataclass(frozen=True, eq=False)
class _Point:
    """A motion, the best forces that agree with it, and what they lack."""

    motion: Floats
    force: Floats
    lack: float


@dataclass(frozen=True, eq=False)
class _Reach:
    """Forces (k, 3) whose friction turns, and how far slides may change."""

    force: Floats
    trust: float


@dataclass(frozen=True, eq=False)
class _Found:
    """Change of motion (n, 6), normal forces and shear of some corners, and what they lack."""

    change: Floats
    normal: Floats
    shear: Floats
    lack: float


class _Turning:
    """Steps of one model. Motions are in units in which the softest joint has a stiffness of 1."""

    def __init__(
        self, statics: Statics, options: RangeOptions, stop: Callable[[], bool] | None
    ) -> None:
        self.statics = statics
        self.options = options
        self.stop = stop
        self.share = corner_load(statics)
        load = wrench_size(statics.load)
        self.dear = np.repeat(DEAR / np.where(load > 0.0, load, 1.0), 6)
        self.programs = 0

    def run(self, start: Floats) -> CompatibleState:
        point = self._forces(self._begun(start))
        trust, idle, joining = 0.5, 0, True
        for _ in range(self.options.iteration_limit):
            if point.lack <= self.options.tolerance or trust < 1e-4 or idle >= PATIENCE:
                break
            if self.stop is not None and self.stop():
                break
            change = self._step(point, trust, joining)
            joining = not joining
            if change is None:
                trust, idle = 0.4 * trust, idle + 1
                continue
            trial = self._forces(point.motion + change)
            idle = 0 if trial.lack < 0.9 * point.lack else idle + 1
            if trial.lack < (1.0 - 1e-4) * point.lack:
                point, trust = trial, min(1.5 * trust, 0.9)
            else:
                trust *= 0.4
        moved = self.statics.displacement(point.motion)
        force = self._without_cohesion(point.force)
        left = float(np.linalg.norm(self.statics.wrench(force) + self.statics.load))
        unit = float(-moved[:, 0].min(initial=0.0))
        motion = point.motion / (unit if unit > 0.0 else 1.0)
        return CompatibleState(motion, force, left, self.programs)

    def _without_cohesion(self, force: Floats) -> Floats:
        """Forces (k, 3) with no more shear than friction allows."""
        shear = np.linalg.norm(force[:, 1:], axis=1)
        least = np.minimum(shear, self.statics.friction * force[:, 0])
        share = np.divide(least, shear, out=np.ones_like(shear), where=shear > 0.0)
        return force * np.stack([np.ones_like(share), share, share], axis=1)

    def _begun(self, motion: Floats) -> Floats:
        """The motion in units in which the forces that agree with it best are about midway."""
        overlap = -self.statics.displacement(motion)[:, 0]
        force, _ = compatible_forces(self.statics, motion)
        normal = force[:, 0]
        loaded = normal > LOADED * normal.max(initial=0.0)
        if not loaded.any():
            return motion
        weight = normal[loaded] / normal[loaded].sum()
        middle = np.exp(weight @ np.log(normal[loaded] / overlap[loaded]))
        return motion * (SOFT * middle / np.sqrt(self.options.spread))

    def _forces(self, motion: Floats) -> _Point:
        """Forces within the range that agree with a motion and lack least."""
        statics = self.statics
        moved = statics.displacement(motion)
        corner = np.flatnonzero(moved[:, 0] < 0.0)
        force = np.zeros((statics.corner_count, 3))
        found = self._solved(moved, corner, None, 1e-10)
        if found is None:
            return _Point(motion, force, np.inf)
        force[corner, 0] = found.normal
        force[corner, 1:] = -found.shear[:, None] * slide_directions(moved)[corner]
        return _Point(motion, force, found.lack)

    def _step(self, point: _Point, trust: float, joining: bool) -> Floats | None:
        """Change of motion (n, 6) with which forces lack least, to first order."""
        moved = self.statics.displacement(point.motion)
        touching = TOUCHING * -moved[:, 0].min(initial=0.0)
        corner = np.flatnonzero(moved[:, 0] < (touching if joining else -touching))
        if len(corner) == 0:
            return None
        found = self._solved(moved, corner, _Reach(point.force, trust), 1e-8)
        return None if found is None else found.change

    def _solved(
        self, moved: Floats, corner: Ints, reach: _Reach | None, tolerance: float
    ) -> _Found | None:
        """The least lack with forces at some corners, and within reach with a change of motion."""
        statics, spread = self.statics, self.options.spread
        count, wrenches = len(corner), 6 * statics.free_count
        elsewhere = np.ones(statics.corner_count, dtype=bool)
        elsewhere[corner] = False
        others = np.flatnonzero(elsewhere)
        moves, turns, opens = (0, 0, 0) if reach is None else (wrenches, 4 * count, len(others))
        # unknowns: change of motion, normal forces, shear, cohesion, unbalanced rest up and down
        normal, shear, cohesion = moves, moves + count, moves + 2 * count
        rest = cohesion + 1
        bounds = 4 * count + 1 + 2 * wrenches
        rows = Triplets(wrenches + bounds + turns + opens, rest + 2 * wrenches)
        blocks = CornerBlocks(statics, corner)
        closing = blocks.along(NORMAL)
        direction = slide_directions(moved)[corner]
        along = blocks.along(np.concatenate([np.zeros((count, 1)), direction], axis=1))
        rows.add(blocks.freedom, normal + blocks.local, closing)
        rows.add(blocks.freedom, shear + blocks.local, -along)
        rows.diagonal(0, rest, np.ones(wrenches))
        rows.diagonal(0, rest + wrenches, np.full(wrenches, -1.0))
        # shear is not below zero, nor beyond friction and cohesion; forces agree with overlaps
        every, first = np.arange(count), wrenches
        rows.diagonal(first, shear, np.full(count, -1.0))
        first += count
        rows.diagonal(first, shear, np.ones(count))
        rows.diagonal(first, normal, -statics.friction[corner])
        rows.add(first + every, np.full(count, cohesion), -self.share[corner])
        first += count
        rows.diagonal(first, normal, np.full(count, -1.0))
        rows.diagonal(first + count, normal, np.ones(count))
        overlap = np.maximum(-moved[corner, 0], 0.0)
        right = [-statics.load.ravel(), np.zeros(2 * count), -overlap, spread * overlap]
        right.append(np.zeros(1 + 2 * wrenches))
        rows.diagonal(first + 2 * count, cohesion, np.full(1 + 2 * wrenches, -1.0))
        if reach is not None:
            rows.add(first + blocks.local, blocks.freedom, -closing)
            rows.add(first + count + blocks.local, blocks.freedom, spread * closing)
            first += 2 * count + 1 + 2 * wrenches
            # turning the slide of a corner turns its friction
            slide = np.linalg.norm(moved[corner, 1:], axis=1) + 1e-12
            across = np.stack([np.zeros(count), -direction[:, 1], direction[:, 0]], axis=1)
            sideways = blocks.along(across)
            held = np.linalg.norm(reach.force[corner, 1:], axis=1) / slide
            rows.add(*blocks.crossed(-sideways * held[blocks.local], sideways))
            # a corner that hardly slides may turn its slide round
            right.append(np.tile(reach.trust * np.maximum(slide, TURN * slide.mean()), 4))
            for axis in (1, 2):
                values = blocks.along(np.eye(3)[axis])
                for sign in (1.0, -1.0):
                    rows.add(first + blocks.local, blocks.freedom, sign * values)
                    first += count
            opening = CornerBlocks(statics, others)
            rows.add(first + opening.local, opening.freedom, -opening.along(NORMAL))
            right.append(np.maximum(moved[others, 0], 0.0))
        cost = np.concatenate([np.zeros(cohesion), [1.0], self.dear, self.dear])
        self.programs += 1
        solution = solve_conic(
            np.concatenate(
                [np.full(moves, 1e-10), np.full(2 * count, 1e-10), np.zeros(1 + 2 * wrenches)]
            ),
            cost,
            rows.csc(),
            np.concatenate(right),
            Cones(zero=wrenches, nonnegative=bounds + turns + opens),
            ConicOptions(tolerance=tolerance),
            stop=self.stop,
        )
        if solution.status is not ConicStatus.SOLVED:
            return None
        x = solution.x
        return _Found(x[:moves].reshape(-1, 6), x[normal:shear], x[shear:cohesion], float(cost @ x))
