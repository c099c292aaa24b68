"""Who says whether a stage stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.loads import LoadCase
from drystone.results import Result
from drystone.stability import CheckOptions, check

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


__all__ = ["Check", "check_once", "check_thoroughly"]
