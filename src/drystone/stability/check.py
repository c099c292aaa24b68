"""The verdict: compatible forces and motion, or a proof that it falls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Unpack

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import DrystoneError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.formulations.nearest_mechanism import NearestMechanism, nearest_mechanisms
from drystone.io.opening import Given, How, supported_model
from drystone.model import Model
from drystone.results import Result
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Candidate
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.verdict.cascade import Cascade


@checked_call
def check(
    given: Given,
    *,
    options: CheckOptions | None = None,
    start: Floats | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Result:
    """Does the assembly stand by contact and friction alone, without prestress?

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    options
    start : (n, 6) [m, rad]
        ``displacement`` of the result of a similar model with the same blocks. It saves time where
        the model stands for every stiffness that is tried, and does not change the verdict.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion that pass every check; UNSTABLE with a mechanism;
        UNDECIDED with a list of what was tried. ``samples`` has the number of assumed contact
        stiffnesses with a rest state.

    Raises
    ------
    InputError
        What was given cannot be made into a model, or the start has another shape.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import arch
    >>> drystone.check(arch(0.15), friction=0.9).verdict
    <Verdict.STABLE: 'stable'>
    """
    chosen = CheckOptions.of(options)
    problem = Problem.build(supported_model(given, **how))
    known = None if start is None else {0: start}
    clock = Clock(time_limit_s, stop)
    return Cascade(problem, chosen, progress, clock, executor, known).run()


@checked_call
def check_near(
    given: Model | Problem,
    known: Mapping[int, Floats],
    *,
    options: CheckOptions,
    within: tuple[Ints, int] | None = None,
    rest: Candidate | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> tuple[Result, dict[int, Floats]]:
    """The verdict of :func:`drystone.check`, begun at the rest states of a similar model.

    Parameters
    ----------
    given
        A model, or the problem that was built of it.
    known : (n, 6) [m, rad] each
        Displacements of the rest states of a similar model with the same blocks, by the number of
        the contact stiffness: 0 is the uniform one, 1 the first sample. Others begin from nothing.
        Where the blocks of that model were followed to rest and these slide on the same way, they
        are not followed again.
    options
    within
        Where the model is a part of a structure: the number (m,) of each interface among those of
        the structure that a free block takes part in, and how many these are. An interface then has
        the same random stiffness in every part, so a rest state of one part is near that of the
        next.
    rest
        The rest state of this model with uniform stiffness, where it is known already.

    Returns
    -------
    Result, dict
        The verdict, and the displacements of the rest states that were found; those with number -1
        are of blocks that were followed to rest, here or in the similar model.
    """
    clock = Clock(time_limit_s, stop)
    problem = Problem.of(given)
    if within is not None:
        within = within[0][problem.model.active], within[1]
    cascade = Cascade(problem, options, progress, clock, executor, known, within, rest=rest)
    return cascade.run(), cascade.stiffnesses.rests


@checked_call
def could_hold(
    given: Given,
    *,
    options: CheckOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Result:
    """Could it stand with shims: does it stand with some contact stiffness, without prestress?

    If it stands with no tried stiffness, joints of different stiffness are searched. Shims can make
    such joints. For blocks that are only set in place use :func:`drystone.check`. Parameters and
    result are those of :func:`drystone.check`.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import concave
    >>> load = drystone.LoadCase.tilt(concave("short"), (0.0, 1.0, 0.0), 50.0)
    >>> model = drystone.Model.of(concave("short"), friction=0.84, load=load)
    >>> could_hold(model).verdict, drystone.check(model).verdict
    (<Verdict.STABLE: 'stable'>, <Verdict.UNSTABLE: 'unstable'>)
    """
    chosen = replace(CheckOptions.of(options), settle=False, search=True)
    problem = Problem.build(supported_model(given, **how))
    return Cascade(problem, chosen, progress, Clock(time_limit_s, stop), executor).run()


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
