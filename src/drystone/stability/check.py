"""The verdict: forces and a motion that agree, or a proof that it falls."""

from __future__ import annotations

from collections.abc import Callable

from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.loads import LoadCase
from drystone.progress import Progress
from drystone.results import Result
from drystone.stability.cascade import Cascade
from drystone.stability.options import CheckOptions
from drystone.stability.problem import Clock, Problem


def check(
    assembly: Assembly,
    contacts: Contacts,
    load: LoadCase | None = None,
    *,
    options: CheckOptions | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> Result:
    """Does the assembly stand by contact and friction alone, without prestress?

    Parameters
    ----------
    assembly
    contacts
    load
        Gravity along -z when left out.
    options
    progress
    stop
        Asked often; True ends the analysis with what is known, like the time limit.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion that pass every check; UNSTABLE with a mechanism;
        UNDECIDED with what was tried. ``samples`` tells how many of the assumed contact
        stiffnesses let it come to rest.

    Raises
    ------
    InputError
        Load or contacts of another assembly.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import arch
    >>> assembly = arch(0.15)
    >>> contacts = drystone.find_contacts(assembly, friction=0.9).contacts
    >>> drystone.check(assembly, contacts).verdict
    <Verdict.STABLE: 'stable'>
    """
    chosen = options if options is not None else CheckOptions()
    clock = Clock(chosen.time_limit_s, stop)
    return Cascade(Problem.build(assembly, contacts, load), chosen, progress, clock).run()


__all__ = ["CheckOptions", "check"]
