"""Whether a model could stand with shims: a rest state with joints of different stiffness."""

from __future__ import annotations

from drystone.formulations.improvement import CompatibleState
from drystone.formulations.stiffness_range import ROUNDING, stiffness_ratio
from drystone.results import Result
from drystone.stability.attempts import Candidate
from drystone.stability.verdict.check_answers import Answers
from drystone.stability.verdict.search_starts import SLIDE_LIMIT, StateSearch


def with_shims(answers: Answers) -> Result | None:
    """STABLE with a state by convex steps, with the least difference of stiffness that works.

    Without a bound on their ratio, forces due to prestress only would hold almost every wedge.
    """
    options, problem, reduce = answers.options, answers.problem, answers.options.reduce_ratio
    if not options.search or answers.clock.late() or not problem.statics.dry:
        return None
    look = StateSearch(
        problem,
        answers.clock,
        tries=options.search_tries,
        seed=options.seed,
        first=answers.attempts.stalled,
        pool=answers.pool,
    )
    try:
        for state in look.states(options.stiffness_ratio, reduce=reduce):
            candidate = _standing(answers, look, state)
            if candidate is not None:
                equal = _with_equal_overlap(answers, look, state) if reduce else None
                best, ratio = equal or (candidate, stiffness_ratio(problem.statics, state))
                return answers.sensitive(best, ratio, equal_overlap=equal is not None)
        return None
    finally:
        answers.iterations += look.iterations


def _standing(answers: Answers, look: StateSearch, state: CompatibleState) -> Candidate | None:
    """The state as a proof that it stands, if it is one."""
    if look.slide(state) > SLIDE_LIMIT:
        return None
    candidate = answers.attempts.examine(state.motion, state.force)
    return candidate if candidate.stands else None


def _with_equal_overlap(
    answers: Answers, look: StateSearch, state: CompatibleState
) -> tuple[Candidate, float] | None:
    """The nearest state of eq. 5.6 and its stiffness ratio, if that is within the bound.

    Equal overlaps do not mean equal stiffnesses: these differ like the forces.
    """
    equal = look.equal_overlap(state.motion)
    ratio = stiffness_ratio(answers.problem.statics, equal)
    if ratio > answers.options.stiffness_ratio * ROUNDING:
        return None
    candidate = _standing(answers, look, equal)
    return None if candidate is None else (candidate, ratio)
