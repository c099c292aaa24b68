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

from drystone.arrays import Floats
from drystone.formulations.compatible import compatible_forces, slide_directions
from drystone.formulations.improvement import CompatibleState
from drystone.formulations.range_program import Reach, least_lack
from drystone.statics import Statics

TOUCHING = 1e-7
"""A gap below this share of the largest overlap is none: the corner may close or open."""

ROUNDING = 1.0 + 1e-6
"""Share by which a spread may miss what is asked for."""

BALANCED = 1e-8
"""Load left over, by the loads, of a state that is worth checking."""

LOADED = 1e-6
"""Forces below this share of the largest say nothing of the stiffness of their joint."""

SOFT = 1.0 / 3.0
"""Scale of the motion at the beginning, by the one that puts stiffnesses midway. It hardly matters:
from a tenth to one as many starts led to a state."""

STEPS = 40
"""Most steps of one motion: what is not there after them is given up."""

NOTHING = 1e-9
"""Cohesion and load left over, by the loads, that are none: ten times what the programs leave."""

PATIENCE = 6
"""Steps with little progress after which a motion is given up."""

CLOSER = (0.3, 0.6, 0.85, 0.95)
"""Shares of a spread that are tried to bring stiffnesses closer, one after the other."""

ALIKE = 2.0
"""Stiffnesses that differ by no more than this factor are not worth bringing closer."""


def settle(
    statics: Statics,
    motion: Floats,
    spread: float,
    *,
    stop: Callable[[], bool] | None = None,
) -> CompatibleState:
    """Turn a motion until springs of some stiffness within the range balance the loads with it.

    Parameters
    ----------
    statics
    motion : (n, 6)
        Where to start; its size does not matter.
    spread
        Largest ratio of two stiffnesses.
    stop
        Asked before every step.
    """
    return _Turning(statics, spread, stop).run(motion)


def evened(
    statics: Statics,
    state: CompatibleState,
    content: float = ALIKE,
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
    stop

    Returns
    -------
    CompatibleState
        Its ``iterations`` are those of this call.
    """
    enough = BALANCED * float(np.linalg.norm(statics.load))
    spread, programs = spread_of(statics, state), 0
    going = True
    while going and spread > content * ROUNDING:
        going = False
        for share in CLOSER:
            trial = settle(statics, state.motion, max(share * spread, content), stop=stop)
            programs += trial.iterations
            closer = spread_of(statics, trial)
            if trial.unbalanced <= enough and closer < spread:
                state, spread, going = trial, closer, True
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


class _Turning:
    """Steps of one model. Motions are in units in which the softest joint has a stiffness of 1."""

    def __init__(self, statics: Statics, spread: float, stop: Callable[[], bool] | None) -> None:
        self.statics = statics
        self.spread = spread
        self.stop = stop
        self.programs = 0

    def run(self, start: Floats) -> CompatibleState:
        point = self._forces(self._begun(start))
        trust, idle, joining = 0.5, 0, True
        for _ in range(STEPS):
            if point.lack <= NOTHING or trust < 1e-4 or idle >= PATIENCE:
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
        return motion * (SOFT * middle / np.sqrt(self.spread))

    def _forces(self, motion: Floats) -> _Point:
        """Forces within the range that agree with a motion and lack least."""
        statics = self.statics
        moved = statics.displacement(motion)
        corner = np.flatnonzero(moved[:, 0] < 0.0)
        force = np.zeros((statics.corner_count, 3))
        self.programs += 1
        found = least_lack(statics, moved, corner, self.spread, stop=self.stop)
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
        self.programs += 1
        found = least_lack(
            self.statics,
            moved,
            corner,
            self.spread,
            Reach(point.force, trust),
            tolerance=1e-8,
            stop=self.stop,
        )
        return None if found is None else found.change
