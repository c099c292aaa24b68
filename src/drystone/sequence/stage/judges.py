"""Who says whether a stage stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from drystone.arrays import Floats
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability import CheckOptions, RBEOptions, check, solve_rbe, try_rest

Check: TypeAlias = Callable[[Model], Result]
"""Any verdict: ``check(model)``. It travels to other processes, so it must be
importable there."""

SMOOTH = 10.0
"""Slip length, by the local overlap, of the friction law of the second look: the one that
:func:`drystone.check` turns to as well."""

HASTY = range(25, 101)
"""Free blocks of models whose glances are hasty. Chosen: with fewer the search goes on for so long
that a wrong no loses the best order, in 3 of 50 heaps of up to 8; a vault of 366 needs a sixth more
props, those of 37 and 60 blocks none."""


def check_once(model: Model) -> Result:
    """The verdict with uniform contact stiffness: what every stage is asked by default.

    What comes to rest for other stiffnesses only is not counted upon while it is built.
    """
    return check(model, options=CheckOptions(samples=0, search=False))


def check_thoroughly(model: Model) -> Result:
    """The verdict of the whole cascade: any compatible state counts."""
    found = glance(model)
    return found if found.verdict is Verdict.STABLE else check(model)


def glance(
    model: Model,
    *,
    slip: float | None = None,
    hasty: bool = False,
    start: Floats | None = None,
) -> Result:
    """A quick look: STABLE with the full proof, or UNDECIDED.

    Parameters
    ----------
    model
    slip
        Of the friction law, as in :func:`drystone.stability.try_rest`.
    hasty
        As there.
    start : (n, 6) [m, rad]
        Displacements of a neighbouring stage.
    """
    return try_rest(model, slips=(slip,), brief=True, hasty=hasty, start=start)


def glances(judge: Check) -> tuple[float | None, ...]:
    """Slip length of each quick look that may come before a judge; the first to be asked first."""
    return (None, SMOOTH) if judge is check_once else ()


def balance(model: Model) -> Result:
    """Rigid-block equilibrium alone: necessary for standing."""
    return solve_rbe(model, options=RBEOptions.feasibility())


__all__ = ["HASTY", "Check", "balance", "check_once", "check_thoroughly", "glance", "glances"]
