"""Could a model stand with shims: does it rest with some contact stiffness, without prestress?"""

from __future__ import annotations

from benchmarks.shims.search_starts import SLIDE_LIMIT, StateSearch
from drystone import CheckOptions, Model, check
from drystone.base.settings import Clock
from drystone.checks import check_forces
from drystone.stability.problem import Problem

RATIO = 200.0
"""Largest ratio of two contact stiffnesses. It follows the wedge of type b of Kao 2023, which needs
a ratio of 92 to stand at 58.0 degrees and of 265 at 59.5 degrees; with discrete elements (3DEC) it
stands up to 58.7."""

TRIES = 250
"""Random motions from which the search starts on small models; fewer on larger ones. One in 30 to
60 leads to a state of a wedge that a joint ten or eighty times as stiff would hold."""

SOUND = 1e-8
"""Largest residual of a state that proves that it stands."""


def could_hold(model: Model, *, ratio: float = RATIO, tries: int = TRIES) -> bool:
    """Whether it stands with a stiffness that is tried, or with one that is searched."""
    found = check(model, options=CheckOptions(samples=4, settle=False))
    if found.stable:
        return True
    problem = Problem.build(model)
    if found.message == "no contact forces can balance the loads" or not problem.statics.dry:
        return False
    look = StateSearch(problem, Clock(float("inf")), tries=tries)
    for state in look.states(ratio, reduce=False):
        force, motion = problem.force(state.force), problem.displacement(state.motion)
        slides = look.slide(state)
        if slides <= SLIDE_LIMIT and check_forces(model, force, motion).largest <= SOUND:
            return True
    return False
