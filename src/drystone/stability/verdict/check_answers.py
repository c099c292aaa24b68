"""The results that a check can end with, and what is known of it by then."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.progress import Clock, Progress
from drystone.base.workers import WorkerPool
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import solve_equilibrium
from drystone.formulations.nearest_mechanism import NearestMechanism, nearest_mechanism
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.settlement import Settlement
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.stability.attempts import Attempts, Candidate
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.programs.rbe import ANY_FORCES
from drystone.stability.proofs import (
    FALLING_SHARE,
    balanced,
    first_motion,
    found_mechanism,
    moving_blocks,
    sound_mechanism,
)

SENSITIVE = "sensitive to how the joints press"
NOT_REACHED = "forces could balance the loads, but the loads alone do not bring them about"


class Answers:
    """What a check has found so far, and every result that it can end with.

    Attributes
    ----------
    problem, options, progress, clock
    nearest
        The mechanism nearest to free fall, once it is known.
    pool
        Computes independent parts.
    attempts
        The rest states that were tried.
    iterations
        Steps of all other calculations.
    balances
        Whether some forces are known to balance the loads.
    left : (k, 3)
        Scaled forces beside the nearest mechanism; None where none was found.
    stage
        What is being calculated.
    """

    def __init__(
        self,
        problem: Problem,
        options: CheckOptions,
        progress: Progress | None,
        clock: Clock,
        nearest: NearestMechanism | None = None,
    ) -> None:
        self.problem = problem
        self.options = options
        self.progress = progress
        self.clock = clock
        self.nearest = nearest
        self.pool = WorkerPool(None)
        self.attempts = Attempts(problem, clock)
        self.iterations = 0
        self.balances = False
        self.left: Floats | None = None
        self.stage = "free fall"

    def report(self, stage: str, done: int) -> None:
        """Say what is calculated next."""
        if not self.clock.reason:
            self.stage = stage
        if self.progress is not None:
            self.progress(stage, done, 3 + self.options.samples)

    @cached_property
    def collapse(self) -> Floats | None:
        """The collapse mechanism (n, 6); None if forces balance the loads, or if none was found."""
        self.report("equilibrium", 1)
        problem, late = self.problem, self.clock.late
        if problem.statics.dry:
            if self.nearest is None:
                self.nearest = nearest_mechanism(problem.system, stop=late)
            nearest = self.nearest
            self.iterations += nearest.iterations
            if nearest.motion is not None:
                motion = sound_mechanism(problem, nearest.motion)
                if motion is not None:
                    self.left = nearest.force
                    return motion
            elif balanced(problem, nearest.force):
                self.balances = True
                return None
        balance = solve_equilibrium(
            problem.statics,
            cone=FrictionCone.exact(),
            options=ConicOptions(gap=ANY_FORCES, time_limit_s=self.clock.left_s),
            stop=late,
        )
        self.iterations += balance.raw.iterations
        self.balances = balance.raw.status is ConicStatus.SOLVED
        return None if self.balances else found_mechanism(problem, balance, late)

    def nothing_free(self) -> Result:
        """STABLE: there is nothing to calculate."""
        corners = self.problem.model.contacts.corner_count
        return self.answer(
            Verdict.STABLE,
            "every block is fixed",
            force=np.zeros((corners, 3)),
            displacement=np.zeros((len(self.problem.model.assembly), 6)),
            residuals=Residuals(),
        )

    def stable(self, uniform: Candidate, how: str = "") -> Result:
        """STABLE with a rest state; ``how`` it stands where that is not of the stiffness alone."""
        tried, stood = self.attempts.tried, len(self.attempts.standing)
        if tried == 1:
            words = "stands"
        elif stood == tried:
            words = f"stands, whichever joints press more ({tried} contact stiffnesses tried)"
        else:
            words = f"stands for {stood} of {tried} contact stiffnesses tried: {SENSITIVE}"
        words = f"{how}; {words}" if how else words
        left = 1 + self.options.samples - tried
        if self.clock.reason and left > 0:
            words += f"; {self.clock.reason} before {left} more could be tried"
        return self._standing(uniform if uniform.stands else self.attempts.standing[0], words)

    def sensitive(self, found: Candidate, ratio: float, *, equal_overlap: bool) -> Result:
        """STABLE with a state of the search, whose joints differ in stiffness by a ratio."""
        how = "eq. 5.6 is met"
        if not equal_overlap:
            times = f"{ratio:.0f}" if ratio >= 10.0 else f"{ratio:.1f}"
            how = f"it can rest where one joint is {times} times as stiff as another"
        tried = f"none of {self.attempts.tried} contact stiffnesses tried leads to rest"
        return self._standing(found, f"{how}, but {tried}: {SENSITIVE}", stiffness_ratio=ratio)

    def rests(self, found: Settlement, why: str) -> Result:
        """STABLE after settling, with a rest state in place if some stiffness has one.

        Otherwise the forces are those on the moved blocks, in the axes of the first joints. Faces
        that were met are the last joints of the model of the result.
        """
        words = f"{found.message}; {why}: {SENSITIVE}"
        if self.attempts.standing:
            return self._standing(self.attempts.standing[0], words, settlement=found)
        path = found.path
        contacts = path.model.contacts
        world = np.einsum("ki,kij->kj", path.force, path.axes)
        return self.answer(
            Verdict.STABLE,
            words,
            model=path.model,
            force=np.einsum("kij,kj->ki", contacts.frame[contacts.interface], world),
            displacement=path.displacement,
            residuals=path.residuals,
            settlement=found,
        )

    def _standing(self, rest: Candidate, words: str, **more: Any) -> Result:
        """STABLE with a rest state in place."""
        return self.answer(
            Verdict.STABLE,
            words,
            force=rest.force,
            displacement=rest.displacement,
            residuals=rest.residuals,
            **more,
        )

    def undecided(self, found: Settlement, why: str) -> Result:
        """UNDECIDED, with the result of following the blocks."""
        return self.answer(
            Verdict.UNDECIDED, f"{found.message}; {why}: {SENSITIVE}", settlement=found
        )

    def first_motion(self) -> Result:
        """UNSTABLE with a first motion; UNDECIDED where none was found."""
        problem = self.problem
        left_out = f"; {self.clock.reason} before all else was tried" if self.clock.late() else ""
        for state in self.attempts.falling_states():
            motion = first_motion(problem, state)
            if motion is not None:
                words = "it starts to move"
                if self.balances:
                    words = f"{NOT_REACHED}; {words}"
                return self.unstable(words + left_out, motion)
        return self.no_answer()

    def no_answer(self) -> Result:
        """UNDECIDED: neither a rest state nor a motion is shown."""
        tried = self.attempts.tried
        those = f"{tried} stiffness distribution{'' if tried == 1 else 's'}"
        words = f"no rest state in {those}, and no proof that there is none; more samples may help"
        if self.clock.late():
            steps = self.iterations + self.attempts.iterations
            done = f"no rest state in {those}" if tried else "no stiffness distribution tried out"
            words = f"{done}; {self.clock.reason} in '{self.stage}' (steps: {steps})"
        return self.answer(Verdict.UNDECIDED, words)

    def unstable(self, message: str, mechanism: Floats) -> Result:
        """UNSTABLE, with the blocks and props of the state on ground springs if there is one.

        Otherwise the props hold the blocks against the accelerations of the mechanism that was
        found.
        """
        problem = self.problem
        falling = moving_blocks(problem.model.assembly, mechanism)
        prop = force = None
        for trial in self.attempts.falling[:1]:
            share = problem.ground_share(trial.ground)
            chosen = problem.statics.free[share > FALLING_SHARE * share.max()]
            falling = tuple(int(i) for i in chosen)
            prop = -problem.wrench(trial.ground)
            force = trial.force
        if force is None and self.left is not None:
            force = problem.force(self.left)
            prop = -problem.wrench(problem.statics.load + problem.statics.wrench(self.left))
        return self.answer(
            Verdict.UNSTABLE,
            message,
            mechanism=mechanism,
            prop=prop,
            force_with_props=force,
            falling=falling,
        )

    def answer(
        self, verdict: Verdict, message: str, model: Model | None = None, **found: object
    ) -> Result:
        """A result, with the counts and times of the check."""
        self.report("done", 3 + self.options.samples)
        elapsed, checking = self.clock.elapsed_s, self.attempts.checking_s
        return Result(
            method="check",
            verdict=verdict,
            model=self.problem.model if model is None else model,
            message=message,
            samples=Samples(self.attempts.tried, len(self.attempts.standing)),
            stopped=self.clock.reason,
            options=self.options,
            solver="rest state by interior points",
            iterations=self.iterations + self.attempts.iterations,
            time_s={"solve": elapsed - checking, "check": checking},
            **found,  # type: ignore[arg-type]
        )
