"""Functions that give the verdict on a stage."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias

from drystone.base.arrays import Floats, Ints
from drystone.model import Model
from drystone.results import Result
from drystone.settlement import SettlementOptions
from drystone.stability import (
    CheckOptions,
    RBEOptions,
    check,
    check_near,
    solve_rbe,
)
from drystone.stability.attempts import Candidate
from drystone.stability.problem import Problem

Check: TypeAlias = Callable[[Model], Result]
"""Gives the verdict on a model. Other processes must be able to import it."""


FOLLOWED = CheckOptions(settlement=SettlementOptions(fall=0.05))
"""The verdict of :func:`drystone.check`. A block that moved by a twentieth of its size is not
followed further: the structure does not stand."""

BOTH = replace(FOLLOWED, uniform=True)


def check_once(model: Model, start: Floats | None = None) -> Result:
    """The verdict with uniform contact stiffness; ``start`` as in :func:`drystone.check`."""
    return check(model, options=CheckOptions(samples=0, settle=False), start=start)


def check_both(model: Model) -> Result:
    """Stands with uniform contact stiffness, and by the verdict of :func:`drystone.check`.

    The default for stages. A stage that falls with uniform stiffness is not relied upon, although
    it may stand after settling. Where other stiffnesses let it fall, settlement decides.
    """
    return check(model, options=BOTH)


def check_both_near(
    given: Model | Problem,
    known: Mapping[int, Floats],
    within: tuple[Ints, int] | None = None,
    rest: Candidate | None = None,
) -> tuple[Result, Mapping[int, Floats]]:
    """As :func:`check_both`, begun at known rest states; see :func:`drystone.stability.check_near`.

    A stage with one block more or less has almost the same rest states, if its joints have the same
    stiffness: ``within`` has the number (m,) of each interface in the complete structure, and how
    many that has. ``rest`` is the rest state with uniform stiffness, where it is known already.
    """
    return check_near(given, known, options=BOTH, within=within, rest=rest)


def check_thoroughly(model: Model) -> Result:
    """The verdict of :func:`drystone.check`; settlement where contact stiffness decides."""
    return check(model, options=FOLLOWED)


def balance(model: Model) -> Result:
    """The verdict of rigid-block equilibrium: necessary for standing, not sufficient."""
    return solve_rbe(model, options=RBEOptions.feasibility())


__all__ = [
    "Check",
    "balance",
    "check_both",
    "check_both_near",
    "check_once",
    "check_thoroughly",
]
