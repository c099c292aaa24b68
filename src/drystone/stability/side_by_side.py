"""The checks of several models side by side, where that is faster.

For a small model an operation on arrays takes longer to start than to do. What is the same for many
models is done at once. No answer depends on the other models.
"""

from __future__ import annotations

from collections.abc import Sequence

from drystone.base.errors import DrystoneError
from drystone.base.progress import Clock
from drystone.formulations.nearest_mechanism import NearestMechanism, nearest_mechanisms
from drystone.model import Model
from drystone.results import Result
from drystone.solvers.threads import one_blas_thread
from drystone.stability.cascade import Cascade
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Problem


@one_blas_thread()
def check_side_by_side(
    models: Sequence[Model], options: CheckOptions
) -> list[Result | DrystoneError]:
    """The result of :func:`drystone.check` of each model, or why it has none."""
    clock = Clock(float("inf"))
    problems: list[Problem | DrystoneError] = []
    for model in models:
        try:
            problems.append(Problem.build(model))
        except DrystoneError as error:
            problems.append(error)
    nearest = _nearest([one for one in problems if isinstance(one, Problem)])
    shared_s = clock.elapsed_s / max(len(models), 1)
    found: list[Result | DrystoneError] = []
    for problem in problems:
        if isinstance(problem, Problem):
            own = Clock(float("inf"))
            own.began -= shared_s
            found.append(Cascade(problem, options, None, own, nearest=nearest.get(problem)).run())
        else:
            found.append(problem)
    return found


def _nearest(problems: Sequence[Problem]) -> dict[Problem, NearestMechanism]:
    """The nearest mechanisms of the models that are asked for them first."""
    asked = [one for one in problems if one.statics.free_count and one.equilibrium_first]
    found = nearest_mechanisms([one.system for one in asked]) if asked else []
    return dict(zip(asked, found, strict=True))


__all__ = ["check_side_by_side"]
