"""Does it come to rest with a given friction law? A yes is a proof; a no says nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.formulations import compliance
from drystone.loads import LoadCase
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.stability.attempts import Attempts, Candidate
from drystone.stability.problem import Clock, Problem
from drystone.stability.proofs import free_acceleration, unpressed


def try_rest(
    assembly: Assembly,
    contacts: Contacts,
    load: LoadCase | None = None,
    *,
    slips: Sequence[float | None] = (None,),
    stop: Callable[[], bool] | None = None,
) -> Result:
    """Follow springs of uniform stiffness to rest, with one friction law after another.

    The cheapest way to a proof that it stands, for those who ask often. That it falls is never
    shown: use :func:`drystone.check` for that.

    Parameters
    ----------
    assembly
    contacts
    load
        Gravity along -z when left out.
    slips
        Slip length of each law to try, by the local overlap; ``None`` is the law that sticks and
        slips. The first that leads to rest is the answer.
    stop
        Asked often; True ends the analysis.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion, or UNDECIDED.

    Raises
    ------
    InputError
        Load or contacts of another assembly.
    """
    clock = Clock(float("inf"), stop)
    problem = Problem.build(assembly, contacts, load)
    verdict, message = Verdict.UNDECIDED, "no rest state was found; nothing shows that it falls"
    force = displacement = residuals = None
    attempts = Attempts(problem, clock)
    if problem.statics.free_count == 0:
        verdict, message, residuals = Verdict.STABLE, "every block is fixed", Residuals()
        force, displacement = np.zeros((contacts.corner_count, 3)), np.zeros((len(assembly), 6))
    elif not _falls_freely(problem, slips, clock):
        found = _first_standing(attempts, slips)
        if found is not None:
            verdict, message, residuals = Verdict.STABLE, "stands", found.residuals
            force, displacement = found.force, found.displacement
    return Result(
        method="rest",
        verdict=verdict,
        assembly=assembly,
        contacts=contacts,
        load=problem.load,
        message=message,
        samples=Samples(attempts.tried, len(attempts.standing)),
        force=force,
        displacement=displacement,
        residuals=residuals,
        solver="rest state by interior points",
        iterations=attempts.iterations,
        time_s={"solve": clock.elapsed_s},
    )


def _first_standing(attempts: Attempts, slips: Sequence[float | None]) -> Candidate | None:
    for slip in slips:
        found = attempts.attempt(compliance.uniform(attempts.problem.statics, slip=slip))
        if found.stands:
            return found
    return None


def _falls_freely(problem: Problem, slips: Sequence[float | None], clock: Clock) -> bool:
    """Whether some blocks press on nothing and the others do without them."""
    falling = unpressed(problem.assembly, problem.contacts, free_acceleration(problem))
    if not falling.any():
        return False
    others = problem.without(falling)
    return others is None or _first_standing(Attempts(others, clock), slips) is not None
