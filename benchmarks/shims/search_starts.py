"""Where the search for a compatible state starts, and how far it goes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

import numpy as np
from scipy.sparse.linalg import lsmr

from benchmarks.shims.compatible import compatible_motion
from benchmarks.shims.improvement import CompatibleState
from benchmarks.shims.stiffness_range import (
    BALANCED,
    ROUNDING,
    SMALL_RATIO,
    rest_within_ratio,
    stiffness_ratio,
    with_reduced_ratio,
)
from drystone.base.arrays import Bools, Floats
from drystone.base.settings import Clock
from drystone.base.workers import WorkerPool
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import solve_equilibrium
from drystone.mechanics import law
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions
from drystone.mechanics.statics import Statics
from drystone.solvers.program import ConicOptions, ConicStatus
from drystone.stability.problem import Problem

Found = TypeVar("Found")

FEW = 24
"""Corners beyond which fewer random motions are tried. Their number is in inverse proportion to the
number of corners, because the time of one start grows with it, and to the number of blocks, because
in models of many blocks hardly any random motion leads to a state."""

SEARCH_LIMIT = 4000
"""Corners of the largest model that is searched. One convex step takes about 1 s there."""

SLIDE_LIMIT = 2500.0
"""eta / eps: the largest displacement of a corner by the largest overlap, in a state that the
search answers with. The source uses up to 1000. Some states in which a block slides on two joints
need more."""

CLOSING = 0.02
"""Overlap of the corners about which a random motion turns, by its largest displacement."""

WIDER = 20.0
"""Stiffness ratio that is allowed at first, by the one that is asked for. More starts then lead to
a state."""

LEANING = RestOptions(ground=1e-2, tolerance=1e-6)
"""On ground springs this stiff every model rests. The state shows which corners are pressed."""


@dataclass(eq=False)
class StateSearch:
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
    pool
        Follows several starts side by side.
    iterations
        Convex programs and solver steps so far.
    """

    problem: Problem
    clock: Clock
    tries: int = 48
    seed: int = 0
    first: Sequence[Floats] = ()
    pool: WorkerPool = field(default_factory=lambda: WorkerPool(None))
    iterations: int = 0

    def states(self, ratio: float, *, reduce: bool = True) -> Iterator[CompatibleState]:
        """States whose stiffness ratio is at most ``ratio``, reduced by further steps if wanted."""
        task = partial(_state_within, self.problem.statics, self.clock, ratio, reduce)
        for state, iterations in self._followed(task, self._starts()):
            self.iterations += iterations
            if state is not None:
                yield state

    def slide(self, state: CompatibleState) -> float:
        """Largest displacement of a corner by the largest overlap: eta / eps."""
        return float(np.abs(self.problem.statics.displacement(state.motion)).max(initial=0.0))

    def _followed(
        self, task: Callable[[Floats], Found], starts: Iterator[Floats]
    ) -> Iterator[Found]:
        """What a task makes of each start, in their order.

        The starts are prepared here, so only few are prepared ahead of those that are followed.
        The steps of those that are not used in the end do not count.
        """
        spent: deque[int] = deque()

        def prepared() -> Iterator[Floats]:
            while True:
                before = self.iterations
                motion = next(starts, None)
                cost, self.iterations = self.iterations - before, before
                spent.append(cost)
                if motion is None:
                    return
                yield motion

        for found in self.pool.answers(task, prepared(), ahead=2):
            self.iterations += spent.popleft()
            yield found
        self.iterations += sum(spent)

    def _starts(self) -> Iterator[Floats]:
        statics = self.problem.statics
        if statics.corner_count > SEARCH_LIMIT:
            return
        yield from self.first
        springs = law.uniform(statics, slip=1.0)
        leaning = find_rest(self.problem.statics, springs, LEANING, stop=self.clock.late)
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
            yield self._at_random(rng, pivots=number % 4 != 3)

    def _at_random(self, rng: np.random.Generator, *, pivots: bool) -> Floats:
        """A random motion (n, 6) along which the loads do work.

        With ``pivots`` each block turns about one of its corners. Close to their limit the wedges
        of Kao 2023 turn about a corner that hardly slides, or slide on all corners. About one start
        in 30 of the fitting kind leads to such a state. Of 300 motions about a corner 9 led to a
        state of a wedge and 16 to one of a keystone, of 300 others none and 15.
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

    def _agreeing(self, parts: Iterable[Bools]) -> Iterator[Floats]:
        """Motions that agree best with forces at some corners (k,) that balance the loads."""
        for corners in parts:
            force = None if self.clock.late() else self._balanced(corners)
            motion = None if force is None else compatible_motion(self.problem.statics, force)
            if motion is not None:
                yield motion

    def _balanced(self, corners: Bools) -> Floats | None:
        """Least forces at some of the corners that balance the loads; None where none do."""
        if not corners.any():
            return None
        statics = self.problem.statics
        part = solve_equilibrium(
            _at_corners(statics, corners),
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


def _at_corners(statics: Statics, corners: Bools) -> Statics:
    """The same blocks and loads with some of the corners (k,) only."""
    of_corners = (
        "block_a", "block_b", "lever_a", "lever_b", "frame", "friction", "tributary", "block_area",
        "interface", "tension", "cohesion", "shear",
    )  # fmt: skip
    return replace(statics, **{name: getattr(statics, name)[corners] for name in of_corners})


def _state_within(
    statics: Statics, clock: Clock, ratio: float, reduce: bool, motion: Floats
) -> tuple[CompatibleState | None, int]:
    """The state that one start leads to, if its stiffness ratio is small enough; the steps."""
    wide = rest_within_ratio(statics, motion, WIDER * ratio, stop=clock.late)
    if wide.unbalanced > BALANCED * float(np.linalg.norm(statics.load)):
        return None, wide.iterations
    small = min(SMALL_RATIO, ratio) if reduce else ratio
    state = with_reduced_ratio(statics, wide, small, stop=clock.late)
    within = stiffness_ratio(statics, state) <= ratio * ROUNDING
    return state if within else None, wide.iterations + state.iterations
