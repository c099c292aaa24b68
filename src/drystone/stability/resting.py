"""Does it come to rest with a given friction law? A yes is a proof; a no says nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from drystone.arrays import Floats
from drystone.errors import InputError
from drystone.formulations.rest import compliance
from drystone.formulations.rest.compliance import Compliance
from drystone.formulations.rest.rest_state import Start, start_from
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.stability.attempts import Attempts, Candidate
from drystone.stability.problem import Clock, Problem
from drystone.stability.proofs import FALLING_SHARE, free_acceleration, unpressed


def try_rest(
    model: Model,
    *,
    slips: Sequence[float | None] = (None,),
    brief: bool = False,
    hasty: bool = False,
    start: Floats | None = None,
    stop: Callable[[], bool] | None = None,
) -> Result:
    """Follow springs of uniform stiffness to rest, with one friction law after another.

    The cheapest way to a proof that it stands, for those who ask often. That it falls is never
    shown: use :func:`drystone.check` for that.

    Parameters
    ----------
    model
    slips
        Slip length of each law to try, by the local overlap; ``None`` is the law that sticks and
        slips. The first that leads to rest is the answer.
    brief
        Give up as soon as there is trouble: a no takes half the time, and there are more of them.
    hasty
        Of a brief look from a start: give up at the first short step. Half the time again; up to
        some 60 blocks hardly anything that rests is missed, among hundreds much is.
    start : (n, 6) [m, rad]
        ``displacement`` of a neighbouring model's rest state, block by block, for the first law:
        half the steps where few blocks differ. Its size does not matter; where it leads nowhere,
        and unless the look is brief, the law is followed without it.
    stop
        Asked often; True ends the analysis.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion, or UNDECIDED; then ``falling`` are the blocks
        that the last law let fall, if any.

    Raises
    ------
    InputError
        Load, contacts or start of another assembly.
    """
    clock = Clock(float("inf"), stop)
    problem = Problem.build(model)
    verdict, message = Verdict.UNDECIDED, "no rest state was found; nothing shows that it falls"
    force = displacement = residuals = None
    attempts = Attempts(problem, clock)
    if problem.statics.free_count == 0:
        verdict, message, residuals = Verdict.STABLE, "every block is fixed", Residuals()
        force, displacement = (
            np.zeros((model.contacts.corner_count, 3)),
            np.zeros((len(model.assembly), 6)),
        )
    elif not _falls_freely(problem, slips, brief, clock):
        near = None if start is None else _start(problem, start, slips[0])
        found = None if near is None else attempts.nearby(*near)
        if found is None:
            found = _first_standing(attempts, slips, brief, hasty, near and near[1])
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


def _start(problem: Problem, motion: Floats, slip: float | None) -> tuple[Compliance, Start]:
    """The first law, and where it begins from a motion (n, 6) [m, rad]."""
    count = len(problem.model.assembly)
    if np.shape(motion) != (count, 6) or not np.isfinite(motion).all():
        raise InputError(f"the start must hold {count} times six finite numbers", where="start")
    statics = problem.statics
    springs = compliance.uniform(statics, slip=slip)
    scaled = statics.scaled_motion(np.asarray(motion), statics.mean_length)
    return springs, start_from(problem.system, springs, scaled)


def _first_standing(
    attempts: Attempts,
    slips: Sequence[float | None],
    brief: bool,
    hasty: bool = False,
    start: Start | None = None,
) -> Candidate | None:
    for slip in slips:
        springs = compliance.uniform(attempts.problem.statics, slip=slip)
        first = hasty and start is not None
        found = attempts.attempt(springs, brief=brief, hasty=first, start=start)
        if start is not None and not (brief or found.stands):
            found = attempts.attempt(springs, again=True)
        start = None
        if found.stands:
            return found
    return None


def _falls_freely(
    problem: Problem, slips: Sequence[float | None], brief: bool, clock: Clock
) -> bool:
    """Whether some blocks press on nothing and the others do without them."""
    falling = unpressed(problem.model.assembly, problem.model.contacts, free_acceleration(problem))
    if not falling.any():
        return False
    others = problem.without(falling)
    return others is None or _first_standing(Attempts(others, clock), slips, brief) is not None
