"""Where the search for a compatible state starts, and how far it goes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from scipy.sparse.linalg import lsmr

from drystone.arrays import Bools, Floats
from drystone.formulations.compatible import compatible_motion
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import solve_equilibrium
from drystone.formulations.improvement import CompatibleState, improve
from drystone.formulations.rest import compliance
from drystone.formulations.rest.interior_point import find_rest
from drystone.formulations.rest.rest_state import RestOptions
from drystone.formulations.stiffness_range import (
    BALANCED,
    ROUNDING,
    SMALL_RATIO,
    rest_within_ratio,
    stiffness_ratio,
    with_reduced_ratio,
)
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.stability.problem import Clock, Problem

FEW = 24
"""Corners beyond which fewer random motions are tried, in proportion: what a try takes grows so.
Fewer still of many blocks: hardly one leads to a state there."""

PARTS, PARTS_LIMIT = 8, 400
"""Random parts of the corners whose forces begin a search for equal overlaps, a quarter as many as
random motions of one block, and the corners up to which it is done: a start takes less than a tenth
of a second there."""

SEARCH_LIMIT = 4000
"""Corners up to which a state is searched for by convex steps where sampled stiffnesses find none.
Chosen: one step takes about a second there."""

SLIDE_LIMIT = 2500.0
"""eta / eps: largest displacement by the overlap of a state that the search may answer with. The
source uses up to 1000; where two ways to slide meet a state needs a little more."""

CLOSING = 0.02
"""Overlap of the corners about which a random motion turns, by its largest displacement."""

WIDER = 20.0
"""Spread to begin with, by what is asked for."""

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
        Random motions to start from on small models, fewer on larger ones.
    seed
    first : (n, 6) each
        Motions to start from before all others.
    iterations
        Convex programs and solver steps so far.
    """

    problem: Problem
    clock: Clock
    tries: int = 48
    seed: int = 0
    first: Sequence[Floats] = ()
    iterations: int = 0

    def states(self, ratio: float, *, reduce: bool = True) -> Iterator[CompatibleState]:
        """On joints whose stiffnesses differ by no more than a factor, and as little as steps lead.

        More starts lead to joints that differ more, and from there it is not far.
        """
        statics = self.problem.statics
        enough = BALANCED * float(np.linalg.norm(statics.load))
        for motion in self._starts():
            wide = self._counted(
                rest_within_ratio(statics, motion, WIDER * ratio, stop=self.clock.late)
            )
            if wide.unbalanced <= enough:
                small = min(SMALL_RATIO, ratio) if reduce else ratio
                state = self._counted(
                    with_reduced_ratio(statics, wide, small, stop=self.clock.late)
                )
                if stiffness_ratio(statics, state) <= ratio * ROUNDING:
                    yield state

    def equal_overlap_states(self) -> Iterator[CompatibleState]:
        """With equal overlaps, as eq. 5.6 asks: the end of the steps from every start."""
        for motion in chain(self._starts(), self._more_starts()):
            yield self.equal_overlap(motion)

    def equal_overlap(self, motion: Floats) -> CompatibleState:
        """The steps from one start, with equal overlaps."""
        return self._counted(improve(self.problem.statics, motion, stop=self.clock.late))

    def slide(self, state: CompatibleState) -> float:
        """Largest displacement of a corner by the largest overlap: eta / eps."""
        return float(np.abs(self.problem.statics.displacement(state.motion)).max(initial=0.0))

    def _counted(self, state: CompatibleState) -> CompatibleState:
        self.iterations += state.iterations
        return state

    def _starts(self) -> Iterator[Floats]:
        statics = self.problem.statics
        if statics.corner_count > SEARCH_LIMIT:
            return
        yield from self.first
        springs = compliance.uniform(statics, slip=1.0)
        leaning = find_rest(self.problem.system, springs, LEANING, stop=self.clock.late)
        self.iterations += leaning.iterations
        if not self.clock.late():
            yield leaning.motion
        pressed = statics.displacement(leaning.motion)[:, 0] < 0.0
        yield from self._agreeing((pressed, np.ones_like(pressed)))
        rng = np.random.default_rng(self.seed)
        few = min(1.0, FEW / statics.corner_count) / statics.free_count
        for number in range(round(self.tries * few)):
            if self.clock.late():
                return
            yield self._at_random(rng, pivots=number % 2 == 0)

    def _at_random(self, rng: np.random.Generator, *, pivots: bool) -> Floats:
        """A random motion (n, 6) that yields to the loads; each block about one of its corners.

        The wedges of Kao 2023 close to their limit turn about a corner that hardly slides, or slide
        on all: of either kind one start in thirty or so leads there.
        """
        statics = self.problem.statics
        motion = rng.standard_normal(6 * statics.free_count)
        if not pivots:
            yields = motion @ statics.load.ravel() >= 0.0
            return (motion if yields else -motion).reshape(-1, 6)
        corner = np.unique(
            [
                rng.choice(np.flatnonzero((statics.block_a == i) | (statics.block_b == i)))
                for i in range(statics.free_count)
            ]
        )
        rows = statics.matrix_transposed[(3 * corner[:, None] + np.arange(3)).ravel()]
        motion -= lsmr(rows, rows @ motion)[0]
        if motion @ statics.load.ravel() < 0.0:
            motion = -motion
        moved = np.abs(statics.matrix_transposed @ motion).max(initial=0.0)
        closing = np.tile([CLOSING * moved, 0.0, 0.0], len(corner))
        motion -= lsmr(rows, closing)[0]
        return motion.reshape(-1, 6)

    def _more_starts(self) -> Iterator[Floats]:
        """From forces on random halves, more or less, of the corners, and from any motions."""
        statics = self.problem.statics
        count, blocks = statics.corner_count, statics.free_count
        if count > PARTS_LIMIT:
            return
        rng = np.random.default_rng(self.seed)
        parts = (rng.random(count) < rng.uniform(0.4, 0.9) for _ in range(PARTS))
        yield from self._agreeing(part for part in parts if part.any())
        for _ in range(4 * PARTS // blocks):
            if self.clock.late():
                return
            yield rng.standard_normal((blocks, 6))

    def _agreeing(self, parts: Iterable[Bools]) -> Iterator[Floats]:
        """Motions that agree best with forces at some corners (k,) that balance the loads."""
        for corners in parts:
            force = None if self.clock.late() else self._balanced(corners)
            motion = None if force is None else compatible_motion(self.problem.statics, force)
            if motion is not None:
                yield motion

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
