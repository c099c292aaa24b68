"""States of eq. 5.6 that no path of the loads leads to, searched from many motions.

All corners that press overlap by one length, the unit of motion here. A motion changes step by step
until forces that agree with it balance the loads: a corner that presses has a normal force, and
friction up to its limit against its slide. Each step is a quadratic program in forces and motion,
linearised about the motion, within a share of the slides.

Source of the conditions: Kao et al. 2022, eq. 5.6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, lengths
from drystone.mechanics import law
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions
from drystone.mechanics.statics import Statics
from drystone.solvers.program import ConicOptions, ConicStatus, ProgramBuilder

LARGEST = 20_000
"""Numbers in the matrix of the largest model that is searched: it is full."""

TRIES = 48
"""Random motions in a model of one block and up to 24 corners, fewer in larger ones. Within half a
degree of the limit of a wedge one in 20 leads to a state, further inside one in 3."""

STEPS, PATIENCE = 60, 8
"""Largest number of steps from one motion, and of those with little progress in a row. Within 0.1
degree of the limit of a wedge half as many lead to a quarter of the states."""

EQUAL = 1e-6
"""Relative difference of overlaps that counts as none."""

NORMAL = np.eye(3)[0]
"""Local direction of a normal force."""


class EqualOverlaps:
    """The search in one model.

    Parameters
    ----------
    statics
    stop
        Asked often; True ends it.
    """

    def __init__(self, statics: Statics, stop: Callable[[], bool]) -> None:
        self.statics, self.stop = statics, stop
        self.load = statics.load.ravel()

    @cached_property
    def rows(self) -> Floats:
        """(k, 3, 6 n) displacement of each corner by the motion; transposed, wrenches of forces."""
        return self.statics.matrix_transposed.toarray().reshape(-1, 3, self.load.size)

    def states(self) -> Iterator[tuple[Floats, Floats]]:
        """Motions (n, 6), by the overlap, and forces (k, 3) that agree and balance the loads."""
        if self.statics.corner_count * self.load.size > LARGEST:
            return
        for motion in self._starts():
            if self.stop():
                return
            if (found := self._followed(motion)) is not None:
                yield found[0].reshape(-1, 6), found[1]

    def _starts(self) -> Iterator[Floats]:
        """Blocks that lean on weak springs against all motion; then random motions.

        There each block turns about one of its corners, which closes a little, and the loads do
        work.
        """
        statics = self.statics
        springs = law.uniform(statics, slip=1.0)
        for ground in (1e-2, 1e-3):
            weak = RestOptions(ground=ground, tolerance=1e-6)
            yield find_rest(statics, springs, weak, stop=self.stop).motion.ravel()
        rng = np.random.default_rng(0)
        blocks = statics.free_count
        corners = [np.flatnonzero((statics.blocks == i).any(axis=1)) for i in range(blocks)]
        for _ in range(round(TRIES * min(1.0, 24 / len(self.rows)) / blocks)):
            motion = rng.standard_normal(self.load.size)
            pivots = self.rows[np.unique([rng.choice(one) for one in corners])]
            held = np.linalg.pinv(pivots.reshape(-1, self.load.size))
            motion -= held @ (pivots @ motion).ravel()
            motion *= np.sign(motion @ self.load)
            closed = 0.02 * np.abs(self.rows @ motion).max()
            yield motion - closed * held[:, ::3].sum(axis=1)

    def _followed(self, motion: Floats) -> tuple[Floats, Floats] | None:
        """The motion and forces at the end of the steps, if the loads are balanced there."""
        equal = self._equalled(motion)
        if equal is None:
            return None
        motion, trust, idle = equal, 0.5, 0
        force, left = self._agreeing(motion, self._pressing(motion))
        for _ in range(STEPS):
            if left <= 1e-9 * np.linalg.norm(self.load):
                return motion, force
            change = self._step(motion, force, trust)
            if change is None or idle == PATIENCE or self.stop():
                break
            trial = self._sharpened(motion + change, self._pressing(motion) & (force[:, 0] > 0.0))
            trial_force, trial_left = self._agreeing(trial, self._pressing(trial))
            idle = 0 if trial_left < 0.8 * left else idle + 1
            if trial_left < (1.0 - 1e-4) * left:
                motion, force, left = trial, trial_force, trial_left
                trust = min(1.5 * trust, 0.9)
            else:
                trust *= 0.4
        return None

    def _pressing(self, motion: Floats) -> Bools:
        return self.rows[:, 0] @ motion <= EQUAL - 1.0

    def _edge(self, moved: Floats, corner: Ints) -> tuple[Floats, Floats, Floats]:
        """Slides (c,) of corners that moved (c, 3), their directions (c, 3), full friction (c, 3).

        With the unit normal force it is against the slide.
        """
        slide = moved * (0.0, 1.0, 1.0)
        size = lengths(slide) + 1e-12
        direction = slide / size[:, None]
        return size, direction, NORMAL - self.statics.friction[corner, None] * direction

    def _wrenches(self, corner: Ints, force: Floats) -> Floats:
        """Of forces (c, 3) at corners (c,), as columns (6 n, c)."""
        return np.einsum("ci,cij->jc", force, self.rows[corner])

    def _agreeing(self, motion: Floats, pressing: Bools) -> tuple[Floats, float]:
        """Forces (k, 3) that agree with a motion and leave least of the loads; its norm."""
        from scipy.optimize import nnls  # slow to import

        force, corner = np.zeros((len(self.rows), 3)), np.flatnonzero(pressing)
        if not len(corner):
            return force, np.inf
        *_, edge = self._edge(self.rows[corner] @ motion, corner)
        rays = np.concatenate([np.tile(NORMAL, (len(corner), 1)), edge])
        twice = np.tile(corner, 2)
        try:
            size, left = nnls(self._wrenches(twice, rays), -self.load)
        except RuntimeError:  # it may cycle
            return force, np.inf
        np.add.at(force, twice, size[:, None] * rays)
        return force, float(left)

    def _equalled(self, motion: Floats) -> Floats | None:
        """The nearest motion at which all corners that would bear the loads overlap by 1."""
        moved = self.rows @ motion
        force, _ = self._agreeing(motion, moved[:, 0] < -1e-3 * np.abs(moved).max())
        loaded = force[:, 0] > 1e-6 * force[:, 0].max()
        if not loaded.any():
            return None
        normal = force[loaded, 0]
        unit = -float(normal @ moved[loaded, 0] / normal.sum())
        gap = moved[:, 0] / unit
        program = ProgramBuilder()
        change = program.variable("change", len(motion), quadratic=1e-6)
        missing = program.variable("missing", len(normal), quadratic=normal / normal.mean())
        rows = self.rows[:, 0]
        program.equal("overlap", -1.0 - gap[loaded], (change, rows[loaded]), (missing, -1.0))
        program.at_most("largest overlap", gap + 1.0, (change, -rows))
        solution = program.build().solve()
        if solution.status is not ConicStatus.SOLVED:
            return None
        return self._sharpened(motion / unit + solution.x[change.place], loaded)

    def _sharpened(self, motion: Floats, loaded: Bools) -> Floats:
        """The nearest motion at which loaded corners that overlap by nearly 1 do so exactly."""
        over = 1.0 + self.rows[:, 0] @ motion
        near = loaded & (np.abs(over) < 1e-3)
        return motion - np.linalg.lstsq(self.rows[near, 0], over[near])[0]

    def _step(self, motion: Floats, force: Floats, trust: float) -> Floats | None:
        """Change of motion (6 n,) with the least of the loads left, to first order."""
        moved = self.rows @ motion
        corner = np.flatnonzero(self._pressing(motion))
        loaded = corner[force[corner, 0] > 1e-9 * force[:, 0].max(initial=0.0)]
        count, none = len(corner), np.zeros(len(corner))
        if not count:
            return None
        slide, direction, edge = self._edge(moved[corner], corner)
        # friction turns with the slide: what changes is across it
        across = self._wrenches(corner, np.cross(direction, NORMAL))
        held = lengths(force[corner, 1:]) / slide
        program = ProgramBuilder()
        change = program.variable("change", len(motion), quadratic=1e-10)
        straight = program.variable("straight", count, quadratic=1e-10)
        at_edge = program.variable("at the edge of friction", count, quadratic=1e-10)
        rest = program.variable("rest", len(motion), quadratic=1.0)
        program.equal(
            "balance",
            -self.load,
            (change, -(across * held) @ across.T),
            (straight, self.rows[corner, 0].T),
            (at_edge, self._wrenches(corner, edge)),
            (rest, -1.0),
        )
        program.equal("pressed", np.zeros(len(loaded)), (change, self.rows[loaded, 0]))
        program.at_most("straight", none, (straight, -1.0))
        program.at_most("at the edge", none, (at_edge, -1.0))
        # a corner that slides little may reverse its slide
        reach = trust * np.maximum(slide, 0.02 * slide.mean())
        for axis in (1, 2):
            program.at_most(f"most {axis}", reach, (change, self.rows[corner, axis]))
            program.at_most(f"least {axis}", reach, (change, -self.rows[corner, axis]))
        overlap = np.maximum(moved[:, 0] + 1.0, 0.0)
        program.at_most("overlap", overlap, (change, -self.rows[:, 0]))
        solution = program.build().solve(ConicOptions(tolerance=1e-8))
        return solution.x[change.place] if solution.status is ConicStatus.SOLVED else None
