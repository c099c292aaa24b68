"""The verdict: forces and a motion that agree, or a proof that it falls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Unpack

from drystone.io.opening import Given, How, as_model
from drystone.progress import Progress
from drystone.results import Result
from drystone.settings import checked_call
from drystone.solvers.threads import one_blas_thread
from drystone.stability.cascade import Cascade
from drystone.stability.options import CheckOptions
from drystone.stability.problem import Clock, Problem


@checked_call
@one_blas_thread()
def check(
    given: Given,
    *,
    options: CheckOptions | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Result:
    """Does the assembly stand by contact and friction alone, without prestress?

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options
    progress
    stop
        Asked often; True ends the analysis with what is known by then.
    time_limit_s
        After it the answer is given from what is known by then.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion that pass every check; UNSTABLE with a mechanism;
        UNDECIDED with what was tried. ``samples`` tells how many of the assumed contact
        stiffnesses let it come to rest.

    Raises
    ------
    InputError
        What was given cannot be made into a model.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import arch
    >>> drystone.check(arch(0.15), friction=0.9).verdict
    <Verdict.STABLE: 'stable'>
    """
    chosen = CheckOptions.of(options)
    clock = Clock(time_limit_s, stop)
    return Cascade(Problem.build(as_model(given, **how)), chosen, progress, clock).run()


__all__ = ["CheckOptions", "check"]
