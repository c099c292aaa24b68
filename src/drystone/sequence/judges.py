"""Who says whether a stage stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.loads import LoadCase
from drystone.results import Result
from drystone.stability import CheckOptions, RBEOptions, check, solve_rbe

Check: TypeAlias = Callable[[Assembly, Contacts, LoadCase], Result]
"""Any verdict: ``check(assembly, contacts, load)``. It travels to other processes, so it must be
importable there."""


def check_once(assembly: Assembly, contacts: Contacts, load: LoadCase) -> Result:
    """The verdict with uniform contact stiffness: what every stage is asked by default.

    What comes to rest for other stiffnesses only is not counted upon while it is built.
    """
    return check(assembly, contacts, load, options=CheckOptions(samples=0, search=False))


def check_thoroughly(assembly: Assembly, contacts: Contacts, load: LoadCase) -> Result:
    """The verdict of the whole cascade: any compatible state counts."""
    return check(assembly, contacts, load)


def balance(assembly: Assembly, contacts: Contacts, load: LoadCase) -> Result:
    """Rigid-block equilibrium alone: necessary for standing."""
    return solve_rbe(assembly, contacts, load, options=RBEOptions.feasibility())


__all__ = ["Check", "balance", "check_once", "check_thoroughly"]
