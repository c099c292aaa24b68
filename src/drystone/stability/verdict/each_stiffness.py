"""Rest states with uniform contact stiffness, and with other ones."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial

from drystone.base.arrays import Floats, Ints
from drystone.formulations.rest import compliance
from drystone.formulations.rest.compliance import Compliance
from drystone.stability.attempts import CLEARLY, MUCH, Attempts, Candidate, Record
from drystone.stability.screening import QUICK, SLIP_LENGTH
from drystone.stability.stiffness_samples import (
    NONE_FOUND,
    TriedStiffnesses,
    attempt_sample,
    samples_to_try,
)
from drystone.stability.verdict.check_answers import Answers

SLIDES_FAR = 20.0
"""Slide by overlap, in the rest state with the springs of settlement, from which on the blocks are
followed although every stiffness stands. A slide changes the friction on its way, and one so long
occurs close to a limit. Measured on the published models: 24 or more where following shows a fall.
Domes, vaults, walls and arches near their limits: 8 at most if they do not slide as a whole."""


class EachStiffness:
    """The rest states of a model with each contact stiffness that is tried.

    Parameters
    ----------
    answers
    known, within, tried
        As for :class:`~drystone.stability.verdict.cascade.Cascade`.
    first_ends
        Whether none is tried after the first one that does not hold the blocks.

    Attributes
    ----------
    rests : (n, 6) [m, rad] each
        As ``known``, of this model.
    """

    def __init__(
        self,
        answers: Answers,
        known: Mapping[int, Floats],
        within: tuple[Ints, int] | None,
        tried: TriedStiffnesses,
        first_ends: bool,
    ) -> None:
        self.answers = answers
        self.problem = answers.problem
        self.known = known
        self.within = within
        self.tried = tried
        self.first_ends = first_ends
        self.rests: dict[int, Floats] = {}

    @cached_property
    def uniform(self) -> Candidate:
        """The answer of uniform contact stiffness."""
        self.answers.report("rest state", 0)
        attempts, statics = self.answers.attempts, self.problem.statics
        if self.nearby is not None:
            return self.nearby
        if self.tried.uniform is not None:
            attempts.add(Record([self.tried.uniform], tried=1))
            return self.tried.uniform
        # without friction equilibrium decides
        much = MUCH if statics.friction.any() else CLEARLY
        springs = compliance.uniform(statics)
        found = attempts.attempt(
            springs, falls=lambda: self.answers.collapse is not None, much=much
        )
        if found.stands:
            self.tried.uniform = found
        return found

    def try_smooth(self) -> None:
        """Try uniform stiffness with a smooth law, which converges more easily."""
        springs = compliance.uniform(self.problem.statics, slip=SLIP_LENGTH)
        self.uniform = self.answers.attempts.attempt(springs, again=True)
        if self.uniform.stands:
            self.tried.uniform = self.uniform

    @cached_property
    def nearby(self) -> Candidate | None:
        """The rest state of uniform stiffness near a known one, or one that was found before."""
        attempts = self.answers.attempts
        if attempts.standing:
            return attempts.standing[0]
        if 0 not in self.known or not self.problem.statics.dry:
            return None
        springs = compliance.uniform(self.problem.statics)
        found = attempts.nearby(springs, attempts.start(springs, self.known[0]))
        return found or self._smooth_nearby(springs)

    def _smooth_nearby(self, springs: Compliance) -> Candidate | None:
        """The rest state of a smooth law near the known one; none where stick-slip shows a fall.

        A check from nothing accepts it as well. It follows stick-slip for longer before.
        """
        problem, attempts = self.problem, self.answers.attempts
        smooth = compliance.uniform(problem.statics, slip=SLIP_LENGTH)
        tries = Attempts(problem, self.answers.clock)
        found = tries.nearby(smooth, tries.start(smooth, self.known[0]))
        if found is None:
            return None
        quickly = tries.attempt(springs, QUICK, again=True)
        attempts.iterations += tries.iterations
        if tries.falling:
            return None
        if quickly.stands:
            found = quickly
        attempts.tried += 1
        attempts.standing.append(found)
        return found

    def try_others(self) -> None:
        """Rest states for the samples of the stiffness, once.

        Without friction the motion of a joint is normal to its limits. Then all stiffnesses give
        the same answer (static theorem of limit analysis).
        """
        answers, uniform = self.answers, self.uniform
        attempts, options, late = answers.attempts, answers.options, answers.clock.late
        if attempts.tried > 1 or not options.samples:
            return
        if uniform.stands and not self.problem.statics.friction.any():
            return
        samples = samples_to_try(attempts, options, uniform, self.known, self.within, self.tried)
        answers.report("stiffness samples", 2)
        task = partial(attempt_sample, self.problem, answers.clock, options.uniform)
        tried = answers.pool.answers(task, samples, late)
        for number, record in enumerate(tried, start=1):
            attempts.add(record)
            answers.report("stiffness samples", 2 + number)
            if record.standing:
                self.rests[number] = record.standing[0].displacement
                continue
            if uniform is self.tried.uniform and not (samples[number - 1].briefly or late()):
                self.tried.failed[number] = record
            if self.first_ends:
                self.rests[number] = NONE_FOUND
                break

    @property
    def robustly(self) -> bool:
        """Whether each stiffness that was tried stands, without sliding far."""
        attempts = self.answers.attempts
        if not attempts.standing or len(attempts.standing) < attempts.tried:
            return False
        like_settlement = self.rests.get(1)
        if like_settlement is None or not self.problem.statics.dry:
            return True
        if not len(like_settlement):
            return False  # it was stopped before
        return self.problem.slide_by_overlap(like_settlement) <= SLIDES_FAR

    def robust_after_all(self) -> bool:
        """Whether each stiffness stands once those that were tried briefly are tried again."""
        doubted = [number for number, near in self.known.items() if not len(near)]
        if not doubted or not self.uniform.stands:
            return False
        self.known = {n: near for n, near in self.known.items() if n not in doubted}
        del self.answers.attempts.standing[1:]
        self.answers.attempts.tried = 1
        self.try_others()
        return self.robustly
