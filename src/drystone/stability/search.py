"""Where the search for a compatible state starts, and how far it goes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from drystone.formulations import compliance
from drystone.formulations.compatible import compatible_motion
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import solve_equilibrium
from drystone.formulations.improvement import CompatibleState, StepOptions, improve
from drystone.formulations.rest import find_rest
from drystone.formulations.rest_state import RestOptions
from drystone.geometry.arrays import Bools, Floats
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.stability.problem import Clock, Problem

TRIES_LIMIT = 400
"""Corners up to which the search also starts from random parts of the corners. Chosen: a start
takes less than a tenth of a second there."""

SEARCH_LIMIT = 4000
"""Corners up to which a state is searched for by convex steps where sampled stiffnesses find none.
Chosen: one step takes about a second there."""

SLIDE_LIMIT = 2500.0
"""eta / eps: largest displacement by the overlap of a state that the search may answer with. The
source uses up to 1000; where two ways to slide meet a state needs a little more."""

LEANING = RestOptions(ground=1e-2, tolerance=1e-6)
"""On ground this stiff every model rests, and shows which corners it presses."""


@dataclass(eq=False)
class Search:
    """Convex steps from the pressed corners, and from forces that balance the loads.

    Attributes
    ----------
    problem
    clock
    tries
        Random parts of the corners to start from on small models; four times as many random
        motions, divided by the number of free blocks, follow.
    seed
    iterations
        Solver steps so far.
    """

    problem: Problem
    clock: Clock
    tries: int = 8
    seed: int = 0
    iterations: int = 0

    def states(self, evenness: float) -> Iterator[CompatibleState]:
        """The end of the steps from every start, most of them no answer."""
        if self.problem.statics.corner_count > SEARCH_LIMIT:
            return
        for motion in self._starts():
            if self.clock.late():
                return
            if motion is not None:
                yield self.improved(motion, evenness)

    def improved(self, motion: Floats, evenness: float) -> CompatibleState:
        """The steps from one start."""
        options = StepOptions(evenness=evenness)
        found = improve(self.problem.statics, motion, options, stop=self.clock.late)
        self.iterations += found.iterations
        return found

    def slide(self, state: CompatibleState) -> float:
        """Largest displacement of a corner by the largest overlap: eta / eps."""
        return float(np.abs(self.problem.statics.displacement(state.motion)).max(initial=0.0))

    def _starts(self) -> Iterator[Floats | None]:
        statics = self.problem.statics
        springs = compliance.uniform(statics, slip=1.0)
        leaning = find_rest(self.problem.system, springs, LEANING, stop=self.clock.late)
        self.iterations += leaning.iterations
        yield leaning.motion
        pressed = statics.displacement(leaning.motion)[:, 0] < 0.0
        for corners in (pressed, np.ones_like(pressed), *self._parts_of_corners()):
            force = self._balanced(corners)
            yield compatible_motion(statics, force) if force is not None else None
        if statics.corner_count <= TRIES_LIMIT:
            # of one block every tenth or so leads to a state where there is one; of many blocks
            # none to speak of
            rng = np.random.default_rng(self.seed)
            for _ in range(4 * self.tries // statics.free_count):
                yield rng.standard_normal((statics.free_count, 6))

    def _parts_of_corners(self) -> Iterator[Bools]:
        """Random halves, more or less, of the corners: forces on few of them differ most."""
        count = self.problem.statics.corner_count
        if count > TRIES_LIMIT:
            return
        rng = np.random.default_rng(self.seed)
        for _ in range(self.tries):
            part = rng.random(count) < rng.uniform(0.4, 0.9)
            if part.any():
                yield part

    def _balanced(self, corners: Bools) -> Floats | None:
        """Least forces at some of the corners that balance the loads."""
        statics = self.problem.statics
        part = solve_equilibrium(
            statics.at_corners(corners),
            cone=FrictionCone.exact(),
            options=ConicOptions(time_limit_s=self.clock.left_s),
            stop=self.clock.late,
        )
        self.iterations += part.raw.iterations
        if part.raw.status is not ConicStatus.SOLVED:
            return None
        force = np.zeros((statics.corner_count, 3))
        force[corners] = part.force
        return force
