"""Rest states without proofs of falling. Where one is found the model stands."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Unpack

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.progress import Clock, LongWork
from drystone.base.settings import checked_call
from drystone.mechanics import law
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Attempt, Candidate
from drystone.stability.problem import Problem, beside_supports
from drystone.stability.proofs import FALLING_SHARE
from drystone.stability.screening import PATIENT, Screening


@checked_call
@one_blas_thread()
def try_rest(
    given: Model | Problem,
    *,
    screening: Screening = PATIENT,
    start: Floats | None = None,
    **work: Unpack[LongWork],
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
    clock = Clock.of(work)
    clock.tell("rest state", 0, 1)
    problem = Problem.of(given)
    model = problem.model
    if model.contacts.brittle:  # mortar that cracks holds nothing that stands on springs alone
        problem = Problem.build(model.cracked())
    tried: tuple[Candidate, ...] = ()
    falling: tuple[int, ...] = ()
    if problem.statics.free_count == 0:
        force, motion = (
            np.zeros((model.contacts.corner_count, 3)),
            np.zeros((len(model.assembly), 6)),
        )
        found, message = Candidate(force, motion, Residuals()), "every block is fixed"
    elif _falls_freely(problem):
        found, message = Candidate(np.zeros(0), np.zeros(0), Residuals(equilibrium=np.inf)), ""
    else:
        tried = tuple(_by_each_law(problem, screening, start, clock.late))
        found, message = tried[-1], "stands"
    if not found.stands:
        message = "no rest state was found; nothing shows that it falls"
        leaning = [one.falling for one in tried if one.falling is not None]
        for state in leaning[-1:]:
            share = problem.ground_share(state.ground)
            chosen = problem.statics.free[share > FALLING_SHARE * share.max()]
            falling = tuple(int(i) for i in chosen)
    stands = found.stands
    ended = sum(one.stands or one.falling is not None or not clock.late() for one in tried)
    return Result(
        method="rest",
        verdict=Verdict.STABLE if stands else Verdict.UNDECIDED,
        model=model,
        message=message,
        falling=falling,
        samples=Samples(ended, sum(one.stands for one in tried)),
        force=found.force if stands else None,
        displacement=found.displacement if stands else None,
        residuals=found.residuals if stands else None,
        stopped=clock.reason,
        solver="rest state by interior points",
        iterations=sum(one.steps for one in tried),
        time_s={"solve": clock.elapsed_s},
    )


def _by_each_law(
    problem: Problem, screening: Screening, start: Floats | None, late: Callable[[], bool]
) -> Iterator[Candidate]:
    """What each friction law of a level comes to, up to the first that leads to rest."""
    for slip in screening.slip_lengths:
        attempt = Attempt(problem, law.uniform(problem.statics, slip=slip), late)
        found = None if start is None else attempt.begun_at(start, screening)
        start = None
        found = attempt.from_nothing(screening) if found is None else found
        yield found
        if found.stands:
            return


def _falls_freely(problem: Problem) -> bool:
    """Whether nothing presses on some blocks beside supports."""
    model, falling = problem.model, problem.unpressed
    return bool(falling.any()) and beside_supports(model.assembly, model.contacts, falling)
