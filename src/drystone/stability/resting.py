"""Rest states without proofs of falling. Where one is found the model stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.formulations.rest import compliance
from drystone.formulations.rest.compliance import Compliance
from drystone.formulations.rest.rest_state import Start
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.settlement import Outcome
from drystone.settlement.settling import settle_for_verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Attempts, Candidate
from drystone.stability.check_options import CheckOptions
from drystone.stability.free_fall import beside_supports
from drystone.stability.problem import Problem
from drystone.stability.proofs import FALLING_SHARE
from drystone.stability.screening import PATIENT, Screening
from drystone.stability.stiffness_samples import TriedStiffnesses
from drystone.stability.verdict.check_answers import Answers
from drystone.stability.verdict.each_stiffness import EachStiffness


@checked_call
@one_blas_thread()
def try_rest(
    given: Model | Problem,
    *,
    screening: Screening = PATIENT,
    start: Floats | None = None,
    tried: TriedStiffnesses | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> Result:
    """Look for a rest state with uniform contact stiffness.

    This is the cheapest proof that a model stands. It never shows that a model falls: use
    :func:`drystone.check` for that. Each friction law is tried after the one before, so an
    ``executor`` has nothing to share.

    Parameters
    ----------
    given
        A model, or the problem that was built of it.
    screening
        How thoroughly to look. The first friction law that leads to rest is the answer.
    start : (n, 6) [m, rad]
        ``displacement`` of the rest state of a similar model with the same blocks. The first law
        begins there, which halves the steps where few blocks differ. The size of the motion does
        not matter. A patient level that finds nothing from the start also begins from nothing.
    tried
        Keeps a rest state of the stick-slip law that is found from nothing, for other checks of the
        same model.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion, or UNDECIDED. ``falling`` are then the blocks
        that fall with the last law, if there are any.

    Raises
    ------
    InputError
        The start has another shape.
    """
    del executor  # one law after the other
    clock = Clock(time_limit_s, stop)
    if progress is not None:
        progress("rest state", 0, 1)
    problem = Problem.of(given)
    model = problem.model
    verdict, message = Verdict.UNDECIDED, "no rest state was found; nothing shows that it falls"
    force = displacement = residuals = None
    attempts = Attempts(problem, clock)
    if problem.statics.free_count == 0:
        verdict, message, residuals = Verdict.STABLE, "every block is fixed", Residuals()
        force, displacement = (
            np.zeros((model.contacts.corner_count, 3)),
            np.zeros((len(model.assembly), 6)),
        )
    elif not _falls_freely(problem, screening, clock):
        near = None if start is None else _start(attempts, start, screening.slip_lengths[0])
        found = None if near is None else attempts.nearby(*near)
        if found is None:
            found = _first_standing(attempts, screening, near and near[1])
            first = attempts.tried == 1 and screening.slip_lengths[0] is None and start is None
            if tried is not None and first:
                tried.uniform = found
        if found is not None:
            verdict, message, residuals = Verdict.STABLE, "stands", found.residuals
            force, displacement = found.force, found.displacement
    falling: tuple[int, ...] = ()
    for state in attempts.falling[-1:] if verdict is Verdict.UNDECIDED else ():
        share = problem.ground_share(state.ground)
        chosen = problem.statics.free[share > FALLING_SHARE * share.max()]
        falling = tuple(int(i) for i in chosen)
    return Result(
        method="rest",
        verdict=verdict,
        model=problem.model,
        message=message,
        falling=falling,
        samples=Samples(attempts.tried, len(attempts.standing)),
        force=force,
        displacement=displacement,
        residuals=residuals,
        stopped=clock.reason,
        solver="rest state by interior points",
        iterations=attempts.iterations,
        time_s={"solve": clock.elapsed_s},
    )


@one_blas_thread()
def stands_for_all(
    model: Model,
    *,
    samples: int | None = None,
    seed: int = 0,
    stop: Stop | None = None,
) -> bool:
    """Whether a model stands for all contact stiffnesses of a check, for searches.

    True where :func:`drystone.check` finds a rest state with each of them. Where the blocks slide
    far they are followed, as there, and must come to rest. It ends at the first stiffness without a
    rest state, and looks for no proof that the model falls.

    Parameters
    ----------
    model
    samples
        Number of stiffness distributions besides the uniform one; those of a check when left out.
    seed
        Of the random ones.
    stop
        Asked often; True ends the analysis, and what is left counts as not found.
    """
    chosen = CheckOptions()
    options = replace(chosen, samples=chosen.samples if samples is None else samples, seed=seed)
    answers = Answers(Problem.build(model), options, None, Clock(float("inf"), stop))
    problem, attempts = answers.problem, answers.attempts
    if problem.statics.free_count == 0:
        return True
    if _falls_freely(problem, PATIENT, answers.clock):
        return False
    stiffnesses = EachStiffness(answers, {}, None, TriedStiffnesses(), first_ends=True)
    if not stiffnesses.uniform.stands:
        if attempts.falling or answers.clock.late() or answers.collapse is not None:
            return False
        stiffnesses.try_smooth()
    if not stiffnesses.uniform.stands:
        return False
    stiffnesses.try_others()
    if len(attempts.standing) < attempts.tried or answers.clock.late():
        return False
    if stiffnesses.robustly:
        return True
    return settle_for_verdict(model, options=options.settlement, stop=stop).outcome is Outcome.RESTS


def _start(attempts: Attempts, motion: Floats, slip: float | None) -> tuple[Compliance, Start]:
    """Springs of the first friction law, and their start from a motion (n, 6) [m, rad]."""
    springs = compliance.uniform(attempts.problem.statics, slip=slip)
    return springs, attempts.start(springs, motion)


def _first_standing(
    attempts: Attempts, screening: Screening, start: Start | None = None
) -> Candidate | None:
    for slip in screening.slip_lengths:
        springs = compliance.uniform(attempts.problem.statics, slip=slip)
        found = attempts.attempt(springs, screening, start=start)
        if start is not None and screening.patient and not found.stands:
            found = attempts.attempt(springs, screening, again=True)
        start = None
        if found.stands:
            return found
    return None


def _falls_freely(problem: Problem, screening: Screening, clock: Clock) -> bool:
    """Whether nothing presses on some blocks beside supports and the others stand without them."""
    assembly, contacts = problem.model.assembly, problem.model.contacts
    falling = problem.unpressed
    if not falling.any() or not beside_supports(assembly, contacts, falling):
        return False
    others = problem.without(falling)
    return others is None or _first_standing(Attempts(others, clock), screening) is not None
