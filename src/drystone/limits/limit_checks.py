"""The checks of one value of a limit: from fast to complete."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias

from drystone.base.arrays import Floats
from drystone.base.progress import Stop
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability import QUICK, CheckOptions, check, try_rest

Check: TypeAlias = Callable[[Model], Result]
"""A function that gives the verdict on a model."""

SEARCHED = 500
"""Largest number of corners with which uniform stiffness is checked as thoroughly as by
:func:`drystone.check`. Chosen: for larger models that fall one such try takes seconds; two quick
ones are made instead."""

_UNIFORM = QUICK.with_slip_lengths(None, 1.0)
"""Screening of large models, for the limit of uniform stiffness. Measured on the Armadillo vault:
the quick level gives the same limits as the patient one in half of the time."""


def one_stiffness(model: Model, *, stop: Stop | None = None) -> Result:
    """Whether it stands with uniform contact stiffness: the fastest proof."""
    contacts = model.contacts
    if contacts.corner_count > SEARCHED and not (contacts.brittle or contacts.crushes.any()):
        return try_rest(model, screening=_UNIFORM, stop=stop)
    return check(model, options=CheckOptions(settle=False), stop=stop)


def every_stiffness(
    model: Model, *, start: Floats | None = None, stop: Stop | None = None
) -> Result:
    """Whether it stands with every contact stiffness that is tried: robust.

    Where they slide far they are followed, and must come to rest.

    Returns
    -------
    Result
        STABLE where it stands with all of them. Otherwise UNSTABLE where no forces balance the
        loads or the blocks fall, or else UNDECIDED.
    """
    options = replace(CheckOptions.robust(), uniform=True)
    found = check(model, options=options, start=start, stop=stop)
    everywhere = found.samples.standing == found.samples.tried
    return found if everywhere or not found.stable else replace(found, verdict=Verdict.UNDECIDED)


def verdict(model: Model, *, start: Floats | None = None, stop: Stop | None = None) -> Result:
    """The verdict of :func:`drystone.check`: settlement where contact stiffness decides."""
    return check(model, start=start, stop=stop)


STANDS: Mapping[Verdict, bool | None] = {
    Verdict.STABLE: True,
    Verdict.EQUILIBRIUM_EXISTS: True,
    Verdict.UNSTABLE: False,
    Verdict.UNDECIDED: None,
}
"""Whether a verdict counts as standing; ``None`` counts as neither."""

STANDS_OR_NOT: Mapping[Verdict, bool | None] = {
    kind: stands is True for kind, stands in STANDS.items()
}
"""As above, but an undecided value counts as falling."""
