"""The verdict of blocks that are followed by finite steps, where the contact stiffness decides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from drystone.base.arrays import Floats
from drystone.results import Result
from drystone.settlement import Outcome, Settlement
from drystone.settlement.settling import settle_for_verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.proofs import first_motion
from drystone.stability.stiffness_samples import NONE_FOUND
from drystone.stability.verdict.check_answers import NOT_REACHED, SENSITIVE, Answers
from drystone.stability.verdict.each_stiffness import SLIDES_FAR, EachStiffness

FOLLOWED = -1
"""In place of the number of a stiffness: the rest state with the springs of settlement of a similar
model whose blocks were followed to rest."""

SETTLES_ALIKE = "it settles as a similar stage that was followed to rest"


class Following:
    """The blocks followed by finite steps, once, and what comes of it.

    Parameters
    ----------
    answers, stiffnesses
    witness
        As for :class:`~drystone.stability.verdict.cascade.Cascade`.
    """

    def __init__(self, answers: Answers, stiffnesses: EachStiffness, witness: bool) -> None:
        self.answers = answers
        self.stiffnesses = stiffnesses
        self.witness = witness
        self._settlement: Settlement | None = None

    @one_blas_thread()
    def settlement(
        self, follow: Callable[..., Settlement] = settle_for_verdict, least: float = 0.0
    ) -> Settlement:
        """The motion of the blocks; ``least``: displacement by size up to which none has fallen."""
        answers, options = self.answers, self.answers.options.settlement
        if self._settlement is None:
            answers.report("settlement", 2 + answers.options.samples)
            found = follow(
                answers.problem.model,
                options=replace(options, fall=max(options.fall, least)),
                executor=answers.pool.executor,
                stop=answers.clock.late,
            )
            if found.stopped:  # by the clock of the check, which knows why
                message = found.message.replace(found.stopped, answers.clock.reason)
                found = replace(found, message=message, stopped=answers.clock.reason)
            self._settlement = found
            answers.iterations += sum(path.iterations for path in self._settlement.paths)
        return self._settlement

    def settles_alike(self) -> bool:
        """Whether the blocks slide on the way on which those of a similar model came to rest."""
        here = self.stiffnesses.rests.get(1)
        followed = self.stiffnesses.known.get(FOLLOWED)
        if here is None or followed is None or not len(here):
            return False
        return self.answers.problem.slide_beyond(here, followed) <= SLIDES_FAR

    def result(self) -> Result:
        """The verdict."""
        answers, stiffnesses, found = self.answers, self.stiffnesses, self.settlement()
        uniform, rests, attempts = stiffnesses.uniform, stiffnesses.rests, answers.attempts
        if found.outcome is not Outcome.RESTS and stiffnesses.robust_after_all():
            return answers.stable(uniform)
        moves = found.outcome in (Outcome.FALLS, Outcome.DISPLACED)
        told = not moves or not self.witness or self._first_motion() is not None
        if found.outcome is Outcome.UNKNOWN or not told:
            stiffnesses.try_others()
        stood, tried = len(attempts.standing), attempts.tried
        held = f"{stood or 'none'} of {tried} contact stiffnesses tried would hold it in place"
        if tried == 1:
            held = "uniform contact stiffness would not hold it in place"
        if found.outcome is Outcome.RESTS:
            if len(rests.get(1, NONE_FOUND)):
                rests[FOLLOWED] = rests[1]
            # that it slides far was the only doubt
            certain = uniform.stands and stood == tried
            return answers.stable(uniform) if certain else answers.rests(found, held)
        if not moves:
            return answers.undecided(found, held)
        motion = self._first_motion()
        if motion is None:
            motion = answers.problem.normalised(found.displacement)
        words = f"{found.message}; {held}: {SENSITIVE}"
        if not stood and answers.balances:
            words = f"{NOT_REACHED}; {found.message}; shims or prestress might hold it: {SENSITIVE}"
        return replace(answers.unstable(words, motion), settlement=found)

    def _first_motion(self) -> Floats | None:
        """The first motion (n, 6) of a state on ground springs; None where there is none."""
        problem, falling = self.answers.problem, self.answers.attempts.falling
        motions = (first_motion(problem, one.state) for one in falling)
        return next((one for one in motions if one is not None), None)
