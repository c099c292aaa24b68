"""The cascade that ends with forces and a motion, or with a proof that it falls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.progress import Clock, Progress, Workers
from drystone.base.workers import WorkerPool
from drystone.formulations.nearest_mechanism import NearestMechanism
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.settlement import Outcome, SettlementOptions, settle
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Candidate, Record
from drystone.stability.check_options import CheckOptions
from drystone.stability.free_fall import (
    NO_APPROACH,
    beside_supports,
    closing_blocks,
    unpressed,
)
from drystone.stability.near_pairs import unless_near_pairs_hold
from drystone.stability.problem import Problem
from drystone.stability.stiffness_samples import TriedStiffnesses
from drystone.stability.verdict.check_answers import Answers
from drystone.stability.verdict.each_stiffness import EachStiffness
from drystone.stability.verdict.following import FOLLOWED, SETTLES_ALIKE, Following
from drystone.stability.verdict.shims import with_shims

UNBALANCED = "no contact forces can balance the loads"

ROUNDS = 3
"""How often light blocks are given what they feel, by the forces found before. Measured: a boulder
on three pebbles of 3e-16 of its weight stands after the second time."""


class Cascade:
    """The cascade: free fall, rest, impossibility, other stiffnesses, search, first motion.

    Parameters
    ----------
    problem, options, progress, clock, executor
    known : (n, 6) [m, rad] each
        Rest states of a similar model by the number of the contact stiffness, 0 for the uniform
        one. The same stiffness is tried from there first. Empty: none was found. Then it is looked
        for briefly, and again where following the blocks does not show that they rest. FOLLOWED:
        blocks that do not slide farther than there are not followed again.
    within
        Numbers (m,) of the interfaces in a larger model, and how many interfaces that has: the
        stiffness of each interface is then drawn as it is there.
    robust
        Whether only standing with every stiffness counts: the first that does not hold it ends the
        check.
    witness
        Whether other stiffnesses are tried after one that does not hold, and for a first motion
        where blocks were followed to a fall. Their motion is told where there is none.
    nearest
        The mechanism nearest to free fall, where it is known already.
    rest
        The rest state of uniform stiffness, where it is known already.
    tried
        What other checks of this model have tried. What is found here is added.
    """

    def __init__(
        self,
        problem: Problem,
        options: CheckOptions,
        progress: Progress | None,
        clock: Clock,
        executor: Workers | None = None,
        known: Mapping[int, Floats] | None = None,
        within: tuple[Ints, int] | None = None,
        robust: bool = False,
        witness: bool = True,
        nearest: NearestMechanism | None = None,
        rest: Candidate | None = None,
        tried: TriedStiffnesses | None = None,
    ) -> None:
        self.problem = problem
        self.options = options
        self.clock = clock
        self.executor = executor
        self.within = within
        self.robust = robust
        self.rest = rest
        self.answers = Answers(problem, options, progress, clock, nearest)
        if rest is not None:
            self.answers.attempts.add(Record([rest], tried=1))
        # settlement decides after the first that does not hold, or nothing is left
        first_ends = options.uniform or robust or not witness
        self.stiffnesses = EachStiffness(
            self.answers, known or {}, within, tried or TriedStiffnesses(), first_ends
        )
        self.following = Following(self.answers, self.stiffnesses, witness)

    def run(self) -> Result:
        """The verdict, with its proof; no proof of falling rests on pairs that were not joined."""
        return unless_near_pairs_hold(self._decided(), self._touching)

    def _touching(self, model: Model) -> Result:
        """The verdict on the same blocks with more contacts."""
        options, executor = self.options, self.executor
        return Cascade(Problem.build(model), options, None, self.clock, executor).run()

    def _decided(self) -> Result:
        """The verdict on the contacts that were found."""
        problem, answers = self.problem, self.answers
        if problem.statics.free_count == 0:
            return answers.nothing_free()
        if self.options.uniform:
            once = Cascade(
                problem,
                replace(self.options, samples=0, settle=False, uniform=False),
                answers.progress,
                self.clock,
                self.executor,
                self.stiffnesses.known,
                nearest=answers.nearest,
                rest=self.rest,
            )
            found = once._decided()
            self._take(once)
            if not found.stable or self.clock.late():
                return replace(found, options=self.options)
        with WorkerPool(self.executor) as answers.pool:
            dropped = self._free_fall()
            return self._after_free_fall() if dropped is None else dropped

    def _take(self, other: Cascade) -> None:
        """Take over the rest states that another check of the model has found."""
        self.answers.attempts = other.answers.attempts
        self.stiffnesses.rests = other.stiffnesses.rests

    @one_blas_thread()
    def _after_free_fall(self) -> Result:
        """The verdict where something presses on every block."""
        problem, answers, stiffnesses = self.problem, self.answers, self.stiffnesses
        attempts, late = answers.attempts, self.clock.late
        if 0 in stiffnesses.known:
            # where a known rest state leads nowhere a mechanism is likely, and is found soon
            small = problem.statics.full_transposed is not None and problem.statics.dry
            doubtful = small and stiffnesses.nearby is None
        else:
            # a fall then has the wrenches of the mechanism, not those of a state on the ground
            doubtful = answers.nearest is not None and not attempts.standing
        if doubtful and answers.collapse is not None:
            return answers.unstable(UNBALANCED, answers.collapse)
        if not stiffnesses.uniform.stands and not late():
            if answers.collapse is not None:
                return answers.unstable(UNBALANCED, answers.collapse)
            if not attempts.falling:  # no convergence
                stiffnesses.try_smooth()
        uniform = stiffnesses.uniform
        if uniform.stands:
            stiffnesses.rests[0] = uniform.displacement
            if FOLLOWED in stiffnesses.known:
                stiffnesses.rests[FOLLOWED] = stiffnesses.known[FOLLOWED]
        elif self.robust:
            return answers.answer(Verdict.UNDECIDED, "uniform contact stiffness does not hold")
        # settlement and the search know dry joints only
        follows = self.options.settle and problem.statics.dry
        if not follows or uniform.stands:  # otherwise the stiffness decides, whatever others do
            stiffnesses.try_others()
        decided = not follows or stiffnesses.robustly
        if attempts.standing and (decided or late()):
            return answers.stable(uniform)
        stands = self._by_what_blocks_feel()
        if stands is not None:
            return stands
        if follows and uniform.stands and self.following.settles_alike():
            return answers.stable(uniform, SETTLES_ALIKE)
        if follows:  # a first motion alone proves no fall
            return answers.no_answer() if late() else self.following.result()
        answers.report("search", 2 + self.options.samples)
        found = with_shims(answers)
        return answers.first_motion() if found is None else found

    def _by_what_blocks_feel(self) -> Result | None:
        """STABLE with every stiffness, where blocks feel little, or much more than their load.

        Joints are then softer in proportion, or slip later. None where there are no such blocks, or
        where it is not shown. What a block feels is at first taken from any forces that balance the
        loads: on uniform springs heavy blocks that turn may throw it away.
        """
        if self.problem.statics.felt is not None:
            return None  # this is such a try
        answers, uniform = self.answers, self.stiffnesses.uniform
        force, options = uniform.force, replace(self.options, settle=False, uniform=False)
        if answers.nearest is not None and not uniform.stands:
            force = self.problem.force(answers.nearest.force)
        for _ in range(ROUNDS):
            problem = self.problem.with_felt(force)
            if problem is None or self.clock.late():
                return None
            inner = Cascade(
                problem,
                options,
                answers.progress,
                self.clock,
                answers.pool.executor,
                within=self.within,
                robust=True,
                nearest=answers.nearest,
            )
            found = inner._decided()
            answers.iterations += found.iterations
            if found.stable and inner.stiffnesses.robustly:
                self._take(inner)
                return replace(found, options=self.options)
            force = inner.stiffnesses.uniform.force
        return None

    def _free_fall(self) -> Result | None:
        """UNSTABLE when the loads press some blocks against nothing and the others stand.

        A free block that touches those that would fall may settle against them: a rest state in
        which something presses on each of them shows that it does. Without one, and where they
        press a little, as on a plug that hardly tapers, following the blocks decides.

        Contact forces answer pressing. Blocks that the loads accelerate without approaching any
        corner feel none, at whatever friction: a block between two vertical walls falls, and so do
        several in a row, although forces that nothing provides could hold them.
        """
        problem = self.problem
        falling, acceleration = problem.unpressed, problem.acceleration
        assembly, contacts = problem.model.assembly, problem.model.contacts
        if not falling.any():
            return None
        words = "nothing presses on the blocks that fall, so nothing holds them"
        apart = beside_supports(assembly, contacts, falling)
        follows = self.options.settle and problem.statics.dry
        if not follows and not apart:
            return None
        if follows:
            surely = apart and unpressed(assembly, contacts, acceleration, NO_APPROACH).all(
                where=falling
            )
            if not apart and self._caught(falling):
                return None
            why = "hardly anything presses on some of its blocks at first"
            if not surely:
                # a plug that hardly tapers presses more and more on a long way
                followed = self.following.settlement(settle, SettlementOptions().fall)
                if followed.outcome is Outcome.RESTS:
                    return self.answers.rests(followed, why)
                if followed.outcome is Outcome.UNKNOWN and not apart:
                    return None
                if followed.outcome in (Outcome.ENDS_DECIDE, Outcome.UNKNOWN):
                    return self.answers.undecided(followed, why)
                words = f"{why}, and {followed.message}"
        rest = problem.without(falling)
        if rest is not None:
            part = Cascade(rest, self.options, None, self.clock, self.answers.pool.executor).run()
            self.answers.iterations += part.iterations
            if part.verdict is not Verdict.STABLE:
                return None
        motion = np.where(falling[:, None], acceleration, 0.0)
        return self.answers.answer(
            Verdict.UNSTABLE,
            words,
            mechanism=problem.normalised(motion),
            prop=0.0 - np.where(falling[:, None], problem.model.load.wrench, 0.0),
            falling=tuple(int(i) for i in np.flatnonzero(falling)),
        )

    @one_blas_thread()
    def _caught(self, falling: Bools) -> bool:
        """Whether uniform stiffness has a rest state in which something presses on blocks (n,)."""
        model, state = self.problem.model, self.stiffnesses.uniform
        if not state.stands:
            return False
        closing = closing_blocks(model.assembly, model.contacts, state.displacement)
        return bool(closing[falling].all())
