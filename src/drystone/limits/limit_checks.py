"""The checks of one value of a limit: from fast to complete."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from drystone import stability
from drystone.base.arrays import Floats
from drystone.base.progress import Clock, Stop
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.stiffness_samples import TriedStiffnesses
from drystone.stability.verdict.cascade import Cascade

Check: TypeAlias = Callable[[Model], Result]
"""A function that gives the verdict on a model."""

SEARCHED = 500
"""Largest number of corners with which uniform stiffness is checked as thoroughly as by
:func:`drystone.check`. Chosen: for larger models that fall one such try takes seconds; two quick
ones are made instead."""

_UNIFORM = stability.QUICK.with_slip_lengths(None, 1.0)
"""Screening of large models, for the limit of uniform stiffness. Measured on the Armadillo vault:
the quick level gives the same limits as the patient one in half of the time."""


@dataclass(eq=False)
class RestStates:
    """Rest states that one check of a search hands to the next.

    Attributes
    ----------
    displacement : (n, 6) [m, rad] each
        Of the last model that stands with every stiffness, by the number of the contact stiffness,
        0 for the uniform one. Empty: there is none yet.
    tried
        What was tried on each model, so that it is tried once.
    """

    displacement: Mapping[int, Floats] = field(default_factory=dict)
    tried: dict[Model, TriedStiffnesses] = field(default_factory=dict)

    def tried_on(self, model: Model) -> TriedStiffnesses:
        """What was tried on this model, for checks to add to."""
        return self.tried.setdefault(model, TriedStiffnesses())

    def cascade(
        self, model: Model, options: CheckOptions, stop: Stop | None, **how: Any
    ) -> Cascade:
        """The check of a model, which adds to what was tried on it."""
        clock = Clock(float("inf"), stop)
        return Cascade(
            Problem.build(model), options, None, clock, tried=self.tried_on(model), **how
        )


def one_stiffness(
    model: Model, *, near: RestStates | None = None, stop: Stop | None = None
) -> Result:
    """Whether it stands with uniform contact stiffness: the fastest proof.

    Its rest state is kept for other checks of the same model; it begins at no other model.
    """
    near = near or RestStates()
    if model.contacts.corner_count > SEARCHED:
        tried = near.tried_on(model)
        return stability.try_rest(model, screening=_UNIFORM, tried=tried, stop=stop)
    return near.cascade(model, CheckOptions(samples=0, settle=False), stop).run()


def every_stiffness(
    model: Model, *, near: RestStates | None = None, stop: Stop | None = None
) -> Result:
    """Whether it stands with every contact stiffness of :func:`drystone.check`: robust.

    No blocks are followed, and the first stiffness that does not hold the blocks ends the check.

    Parameters
    ----------
    model
    near
        Rest states of a similar model with the same blocks, from which this check begins. Those of
        this model take their place where it stands with every stiffness.
    stop

    Returns
    -------
    Result
        That of :func:`drystone.check` where it stands with all of them. Otherwise UNSTABLE where
        no forces balance the loads, or else UNDECIDED.
    """
    near = near or RestStates()
    options = CheckOptions(settle=False)
    cascade = near.cascade(model, options, stop, known=near.displacement, robust=True)
    found = cascade.run()
    if not found.stable:
        return found
    if model.assembly.free.size and not cascade.stiffnesses.robustly:
        return replace(found, verdict=Verdict.UNDECIDED)
    near.displacement = cascade.stiffnesses.rests
    return replace(found, options=CheckOptions())  # the answer of the check with these


def verdict(model: Model, *, near: RestStates | None = None, stop: Stop | None = None) -> Result:
    """The verdict of :func:`drystone.check`: settlement where contact stiffness decides.

    After the first stiffness that does not hold the blocks no other is tried: following them
    decides. Where they were followed to a fall, the mechanism of the result is the motion that was
    followed. Parameters as for :func:`every_stiffness`.
    """
    near = near or RestStates()
    known = near.displacement
    return near.cascade(model, CheckOptions(), stop, known=known, witness=False).run()


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
