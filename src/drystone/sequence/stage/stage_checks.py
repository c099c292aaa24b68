"""Functions that tell whether a stage stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from drystone.model import Model
from drystone.results import Result
from drystone.stability import (
    QUICK,
    CheckOptions,
    RBEOptions,
    check,
    solve_rbe,
    try_rest,
)

Check: TypeAlias = Callable[[Model], Result]
"""Tells whether a model stands. Other processes must be able to import it."""


def check_once(model: Model) -> Result:
    """The verdict with uniform contact stiffness; the default for stages.

    A stage that stands only with other stiffnesses is not relied upon.
    """
    return check(model, options=CheckOptions(samples=0, settle=False))


def check_thoroughly(model: Model) -> Result:
    """The verdict of :func:`drystone.check`: any compatible state counts."""
    found = try_rest(model, screening=QUICK)
    return found if found.stable else check(model)


def balance(model: Model) -> Result:
    """The verdict of rigid-block equilibrium alone: necessary for standing, not sufficient."""
    return solve_rbe(model, options=RBEOptions.feasibility())


__all__ = ["Check", "balance", "check_once", "check_thoroughly"]
