"""Rest states on joints whose stiffnesses differ within bounds.

In the rigid limit corners with equal overlap may share a load in any proportion. Springs share it
by their stiffness. Here the normal force of every closed corner is its overlap times its own
stiffness. The stiffness ratio, largest divided by smallest, is bounded. Friction acts against the
slide, up to its limit. The motion changes step by step until such forces balance the loads.

Each step is a linear program in motion and forces, linearised about the present motion within a
trust region on the slides. It is elastic: cohesion and unbalanced load are slack variables
(:mod:`benchmarks.shims.range_program`). With enough cohesion almost every motion has forces
that balance the loads, so the iteration rarely stops at a motion without such forces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.shims.compatible import compatible_forces, slide_directions
from benchmarks.shims.improvement import CompatibleState
from benchmarks.shims.range_program import TrustRegion, elastic_forces
from drystone.base.arrays import Floats
from drystone.mechanics.statics import Statics

TOUCHING = 1e-7
"""A gap below this share of the largest overlap counts as zero: the corner may close or open."""

ROUNDING = 1.0 + 1e-6
"""Factor by which a stiffness ratio may exceed its bound."""

BALANCED = 1e-8
"""Largest unbalanced load, relative to the load, of a state that is checked."""

LOADED = 1e-6
"""Forces below this share of the largest one do not count in the stiffness ratio."""

SOFT = 1.0 / 3.0
"""Scale of the first motion, relative to the scale that puts the stiffnesses in the middle of the
range. Measured: with 0.1 to 1 the same number of starts led to a rest state."""

STEPS = 40
"""Largest number of steps."""

EXACT = 1e-9
"""Elastic infeasibility that counts as zero: ten times the tolerance of the programs."""

PATIENCE = 6
"""Steps with little progress after which the iteration stops."""

SHARES = (0.3, 0.6, 0.85, 0.95)
"""Factors that are tried, one after the other, to reduce a stiffness ratio."""

SMALL_RATIO = 2.0
"""A stiffness ratio that is not reduced further."""


def rest_within_ratio(
    statics: Statics,
    motion: Floats,
    ratio: float,
    *,
    stop: Callable[[], bool] | None = None,
) -> CompatibleState:
    """Change a motion until springs within the stiffness ratio balance the loads.

    Parameters
    ----------
    statics
    motion : (n, 6)
        Initial motion; its size has no effect.
    ratio
        Largest stiffness by the smallest.
    stop
        Called before every step.
    """
    return _TrustRegionMethod(statics, ratio, stop).run(motion)


def with_reduced_ratio(
    statics: Statics,
    state: CompatibleState,
    enough: float = SMALL_RATIO,
    *,
    stop: Callable[[], bool] | None = None,
) -> CompatibleState:
    """A rest state near a given one, with a smaller stiffness ratio if one is found.

    Parameters
    ----------
    statics
    state
        Balanced result of :func:`rest_within_ratio`.
    enough
        Ratio that is small enough.
    stop

    Returns
    -------
    CompatibleState
        Its ``iterations`` are those of this call.
    """
    allowed = BALANCED * float(np.linalg.norm(statics.load))
    ratio, programs = stiffness_ratio(statics, state), 0
    going = True
    while going and ratio > enough * ROUNDING:
        going = False
        for share in SHARES:
            trial = rest_within_ratio(statics, state.motion, max(share * ratio, enough), stop=stop)
            programs += trial.iterations
            reduced = stiffness_ratio(statics, trial)
            if trial.unbalanced <= allowed and reduced < ratio:
                state, ratio, going = trial, reduced, True
                break
    return replace(state, iterations=programs)


def stiffness_ratio(statics: Statics, state: CompatibleState) -> float:
    """Largest divided by smallest stiffness of the corners in compression."""
    overlap = -statics.displacement(state.motion)[:, 0]
    normal = state.force[:, 0]
    pressed = (normal > LOADED * normal.max(initial=0.0)) & (overlap > 0.0)
    stiffness = normal[pressed] / overlap[pressed]
    return float(stiffness.max() / stiffness.min()) if len(stiffness) else 1.0


@dataclass(frozen=True, eq=False)
class _Point:
    """A motion, the best compatible forces, and their elastic infeasibility."""

    motion: Floats
    force: Floats
    infeasibility: float


class _TrustRegionMethod:
    """Steps of one model. In the unit of motion the softest joint has a stiffness of 1."""

    def __init__(self, statics: Statics, ratio: float, stop: Callable[[], bool] | None) -> None:
        self.statics = statics
        self.ratio = ratio
        self.stop = stop
        self.programs = 0

    def run(self, start: Floats) -> CompatibleState:
        point = self._forces(self._scaled(start))
        trust, idle, joining = 0.5, 0, True
        for _ in range(STEPS):
            if point.infeasibility <= EXACT or trust < 1e-4 or idle >= PATIENCE:
                break
            if self.stop is not None and self.stop():
                break
            change = self._step(point, trust, joining)
            joining = not joining
            if change is None:
                trust, idle = 0.4 * trust, idle + 1
                continue
            trial = self._forces(point.motion + change)
            idle = 0 if trial.infeasibility < 0.9 * point.infeasibility else idle + 1
            if trial.infeasibility < (1.0 - 1e-4) * point.infeasibility:
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
        """Forces (k, 3) whose shear is reduced to the friction limit."""
        shear = np.linalg.norm(force[:, 1:], axis=1)
        least = np.minimum(shear, self.statics.friction * force[:, 0])
        share = np.divide(least, shear, out=np.ones_like(shear), where=shear > 0.0)
        return force * np.stack([np.ones_like(share), share, share], axis=1)

    def _scaled(self, motion: Floats) -> Floats:
        """The motion in units that put its stiffnesses near the middle of the range."""
        overlap = -self.statics.displacement(motion)[:, 0]
        force, _ = compatible_forces(self.statics, motion)
        normal = force[:, 0]
        loaded = normal > LOADED * normal.max(initial=0.0)
        if not loaded.any():
            return motion
        weight = normal[loaded] / normal[loaded].sum()
        middle = np.exp(weight @ np.log(normal[loaded] / overlap[loaded]))
        return motion * (SOFT * middle / np.sqrt(self.ratio))

    def _forces(self, motion: Floats) -> _Point:
        """Compatible forces within the ratio, with the least infeasibility."""
        statics = self.statics
        moved = statics.displacement(motion)
        corner = np.flatnonzero(moved[:, 0] < 0.0)
        force = np.zeros((statics.corner_count, 3))
        self.programs += 1
        found = elastic_forces(statics, moved, corner, self.ratio, stop=self.stop)
        if found is None:
            return _Point(motion, force, np.inf)
        force[corner, 0] = found.normal
        force[corner, 1:] = -found.shear[:, None] * slide_directions(moved)[corner]
        return _Point(motion, force, found.infeasibility)

    def _step(self, point: _Point, trust: float, joining: bool) -> Floats | None:
        """Change of motion (n, 6) of least infeasibility, to first order.

        Corners that touch without force may close when ``joining``, else they may open.
        """
        moved = self.statics.displacement(point.motion)
        touching = TOUCHING * -moved[:, 0].min(initial=0.0)
        corner = np.flatnonzero(moved[:, 0] < (touching if joining else -touching))
        if len(corner) == 0:
            return None
        self.programs += 1
        found = elastic_forces(
            self.statics,
            moved,
            corner,
            self.ratio,
            TrustRegion(point.force, trust),
            tolerance=1e-8,
            stop=self.stop,
        )
        return None if found is None else found.change
