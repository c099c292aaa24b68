"""Whether joints crush, of what stands without a limit of strength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import rounded_down
from drystone.base.progress import Clock, Stop
from drystone.checks import (
    FORCE_TOLERANCE,
    Residuals,
    check_forces,
    crushed_most,
    crushing_share,
)
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import LoadFactors
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.solvers.program import ConicStatus
from drystone.solvers.threads import one_blas_thread
from drystone.stability.problem import Problem
from drystone.stability.proofs import UNBALANCED, checked_mechanism, moving_blocks, undone
from drystone.ties import joint_words

WEAK = "no contact forces within the strength of"
_REACHED = 0.999
"""Share of its strength from which a joint reaches it: forces are asked for that carry a thousandth
more than all loads, so that they use less where they can."""


@dataclass(frozen=True, eq=False)
class Carried:
    """The largest share of the loads that forces within the strength balance.

    Attributes
    ----------
    share
        1 at most.
    force : (k, 3) [N]
        That balance all of them, where they do.
    residuals
        Of these forces.
    mechanism : (n, 6)
        The proof that none do, where it is one.
    iterations
    """

    share: float
    force: Floats | None
    residuals: Residuals
    mechanism: Floats | None
    iterations: int


def carried(problem: Problem, cone: FrictionCone, late: Callable[[], bool]) -> Carried:
    """What share of its loads a model carries whose joints crush."""
    statics = problem.statics
    none = replace(statics, load=np.zeros_like(statics.load))
    found = LoadFactors(none, cone, enough=1.0)(statics.load, late)
    share, state = found.factor, found.state
    steps = state.raw.iterations
    if state.raw.status is ConicStatus.SOLVED and share >= 1.0:  # all sets are convex, with zero
        force = problem.force(state.force / share)
        pull = None if state.pull is None else problem.force(state.pull[:, None] / share)
        return Carried(1.0, force, check_forces(problem.model, force, pull=pull), None, steps)
    return Carried(min(share, 1.0), None, Residuals(), checked_mechanism(problem, state), steps)


def crushing_factor(model: Model, *, stop: Stop | None = None) -> float | None:
    """The factor on all loads up to which forces within the strength of the joints balance them.

    Parameters
    ----------
    model
    stop

    Returns
    -------
    float or None
        None where no joint crushes, of more than 150 blocks, as for the margin of tilt, and where
        it was not found.
    """
    if len(model) > 150 or not model.contacts.crushes.any():
        return None
    statics = Problem.build(model).statics
    none = replace(statics, load=np.zeros_like(statics.load))
    found = LoadFactors(none, FrictionCone.exact())(statics.load, stop).factor
    return found if 0.0 < found < np.inf else None


def crushing_words(model: Model, share: float, motion: Floats) -> str:
    """How much of the loads is carried, why no more, and the joint that crushes most.

    What falls with nothing crushed slides or turns. What crushing resists less
    than weights do is not said to crush.
    """
    crushes = model.contacts.crushes
    stone, at = (crushes & ~model.contacts.ties).any(), crushed_most(model, motion)
    bare = (crushes & (model.contacts.area == 0.0)).any()
    edges = "; edges and corners have no area and carry nothing" if bare else ""
    if at is None:
        return f"{UNBALANCED}; no {'joint crushes' if stone else 'tie yields'}{edges}"
    words = f"{WEAK} its {'joints' if stone else 'ties'} balance the loads"
    words += f", only {rounded_down(share, 3):g} of them{edges}"
    _, which, fails = joint_words(model.assembly, model.contacts, at)
    if crushing_share(model, motion) > 0.5:
        words = f"{'it crushes' if fails == 'crushes' else 'ties yield'}: {words}"
    return f"{words}; the {which} {fails} most"


@one_blas_thread()
def within_strength(problem: Problem, decide: Callable[[Model], Result], clock: Clock) -> Result:
    """The verdict of a model whose joints crush.

    Without the limits of strength it must not fall. If it stands with the forces found there within
    them, it stands. Otherwise other forces are asked for, as crushing lets them move (it is
    ductile): none prove that it falls. Where some exist it stands if no contact stiffness throws it
    over, and is undecided where friction or settling decided.

    Parameters
    ----------
    problem
    decide
        Gives the verdict on a model without limits of strength.
    clock
    """
    model = problem.model
    found = decide(model.without_crushing())
    crushes = found.model.with_contacts(model.contacts.carried_to(found.contacts))
    found = replace(found, model=crushes)
    if found.falls:
        return found
    if found.force is not None:
        residuals = check_forces(crushes, found.force, found.displacement)
        if residuals.crushing <= FORCE_TOLERANCE:
            return replace(found, residuals=residuals)
    most = carried(problem, FrictionCone.exact(), clock.late)
    found = replace(found, iterations=found.iterations + most.iterations)
    if most.mechanism is not None:
        return replace(
            undone(found, crushing_words(crushes, most.share, most.mechanism)),
            verdict=Verdict.UNSTABLE,
            mechanism=most.mechanism,
            falling=moving_blocks(model.assembly, most.mechanism),
        )
    if not found.stable:
        return found
    if most.force is None or most.residuals.largest > FORCE_TOLERANCE:
        words = ["no forces within the strength of its joints were found", clock.reason]
        return replace(undone(found, "; ".join(filter(None, words))), stopped=clock.reason)
    if not found.sensitive:
        kept = replace(
            found, model=model, force=most.force, displacement=None, residuals=most.residuals
        )
        return replace(kept, message=f"{found.message}{_reached(kept)}")
    return undone(
        found,
        "forces within the strength of its joints balance the loads, but whether crushing brings "
        f"them about is not known: without it {found.message}",
    )


def _reached(found: Result) -> str:
    """Whether what stands reaches the strength of its joints, said after why it stands."""
    stone = (found.contacts.crushes & ~found.contacts.ties).any()
    if found.strength_use.max(initial=0.0) < _REACHED:
        return f", also within the strength of its {'joints' if stone else 'ties'}"
    words = "the stone reaches its strength where its joints press most"
    return f"; {words if stone else 'ties yield'}"
