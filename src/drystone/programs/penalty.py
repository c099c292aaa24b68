"""The penalty form: where an unstable design needs help."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import lengths
from drystone.base.display import named
from drystone.base.settings import Clock, Options, checked_call
from drystone.checks import check_forces
from drystone.io.opening import Given, LongHow, as_model
from drystone.mechanics import law
from drystone.mechanics.law import Compliance
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions, RestState
from drystone.mechanics.statics import Statics
from drystone.results import Result
from drystone.solvers.threads import one_blas_thread
from drystone.stability.asked import SAMPLES, Asked, CheckOptions
from drystone.stability.attempts import FALLS_FROM
from drystone.stability.problem import FALLING_SHARE, Problem
from drystone.stability.screening import TO_REST
from drystone.stability.verdict import decided

GLUE = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Tensile stiffness of a corner divided by its stiffness in compression. It is reduced step by step
while the iteration converges. With a smaller value there is tension only where contact cannot carry
the load."""

HELD = 0.01
"""Glue holds a block when the ground carries less than this share of its load."""

PULLS = 1e-5
"""Share of the largest force from which on a pull, or what is not balanced, is some. Below is the
rounding of interior points: 7e-7 where tension costs a million times as much."""

_ACCURACY = 1e-7
"""Tolerance of the rest state, by the load. What is smaller beside the largest force is none."""


@dataclass(frozen=True)
class PenaltyOptions(Options):
    """Options of :func:`solve_cra_penalty`.

    Attributes
    ----------
    ground : > 0, < inf
        Stiffness of the ground, far below that of the glue: it carries what glue cannot.
    settle
        Whether a structure that comes to rest after settling needs no help.
    gamma : >= 1, < inf
        Cost of tension by that of compression, one or more: springs that balance loads have the
        least energy, in which a pull on glue of a stiffness counts by its inverse. As far as the
        iteration follows, 1000 at most, when left out.
    """

    ground: float = 1e-8
    settle: bool = False
    gamma: float | None = None

    @property
    def glue(self) -> tuple[float, ...]:
        """Tensile stiffnesses that are tried one after another, the weakest last."""
        if self.gamma is None:
            return GLUE
        steps = max(1, math.ceil(2.0 * math.log10(self.gamma)))
        return tuple(self.gamma ** -(i / steps) for i in range(1, steps + 1))


@checked_call
@one_blas_thread()
def solve_cra_penalty(
    given: Given,
    *,
    options: PenaltyOptions | None = None,
    **how: Unpack[LongHow],
) -> Result:
    """Where help is needed: props, or glue in the joints.

    ``prop`` is the wrench that would hold each falling block with dry joints. ``tension`` is the
    tension of the joints if they were glued: corners get a weak tensile spring, and friction is
    bounded by compression. There is always a result.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options

    Returns
    -------
    Result
        The verdict of :func:`check` with ``force`` and ``tension`` per corner of the glued
        structure and ``prop`` per block of the dry one. ``falling`` lists the blocks that need
        help, the one with the largest prop force first; the message says which of them glue cannot
        hold.

    Raises
    ------
    InputError
        What was given cannot be made into a model.

    Notes
    -----
    Source: Kao et al. 2022, eq. 5.8, with ``gamma``. There all pressed corners overlap by the same
    length; here by as much as they carry.
    """
    chosen = PenaltyOptions.of(options)
    clock = Clock.of(how)
    problem = Problem.build(as_model(given, **how))
    problem.model.require_dry(
        "the penalty form of coupled rigid-block analysis",
        "it measures the pull that dry joints do not have",
    )
    asked = CheckOptions(samples=SAMPLES, settle=chosen.settle)
    dry = decided(Asked(problem, asked, clock))
    assembly = problem.model.assembly
    corners = problem.model.contacts.corner_count

    def told(message: str, **found: Any) -> Result:
        time_s = {"solve": clock.elapsed_s}
        return replace(
            dry, method="cra-penalty", message=message, options=chosen, time_s=time_s, **found
        )

    if dry.stable:
        none = {"tension": np.zeros(corners), "prop": np.zeros((len(assembly), 6))}
        return told("no block needs help: it stands dry", **none)
    clock.tell("glue", 0, 1)
    statics = problem.statics
    glued = glued_state(problem, chosen, clock.late)
    leaning = find_rest(
        problem.statics, law.uniform(statics), replace(TO_REST, end=None), stop=clock.late
    )
    if clock.late():
        early = f"{dry.message}; {clock.reason} before the help that it needs was known"
        return told(early, stopped=clock.reason)
    share = problem.ground_share(leaning.ground)
    prop = dry.prop
    leans = leaning.converged and share.max() > FALLS_FROM
    if prop is None or leans:  # that of the mechanism also presses blocks together
        prop = -problem.wrench(leaning.ground)
    needy = dry.falling or tuple(int(i) for i in statics.free[share > FALLING_SHARE * share.max()])
    strength = np.linalg.norm(prop[:, :3], axis=1)
    order = tuple(sorted(needy, key=lambda i: -strength[i]))
    unheld = set(statics.free[problem.ground_share(glued.ground) > HELD].tolist())
    force, tension = problem.force(glued.force), problem.force(glued.tension[:, None])[:, 0]
    weight = float(np.abs(problem.model.load.wrench[statics.free, :3]).max(initial=0.0))
    small = _ACCURACY * max(float(np.abs(force).max(initial=0.0)), weight)
    force = np.where((lengths(force) > small)[:, None], force, 0.0)
    tension = np.where(tension > small, tension, 0.0)
    displacement = problem.displacement(glued.motion)
    residuals = check_forces(
        problem.model,
        force,
        displacement,
        prop=-problem.wrench(glued.ground),
    )
    names = assembly.names
    return told(
        _words(
            [names[i] for i in order], {names[i] for i in unheld}, residuals.equilibrium <= PULLS
        ),
        force=force,
        tension=tension,
        displacement=displacement,
        prop=prop,
        falling=order,
        residuals=residuals,
        iterations=dry.iterations + glued.iterations + leaning.iterations,
    )


def glued_state(
    problem: Problem,
    options: PenaltyOptions | None = None,
    stop: Callable[[], bool] | None = None,
) -> RestState:
    """The rest state with the weakest glue that the iteration follows, see :data:`GLUE`.

    Parameters
    ----------
    problem
    options
    stop
        Asked often; True ends the iteration with what is there.
    """
    chosen = PenaltyOptions.of(options)
    numerics = RestOptions(ground=chosen.ground, tolerance=_ACCURACY)
    statics = problem.statics
    first, *rest = chosen.glue
    glued = find_rest(problem.statics, _glue(statics, first), numerics, stop=stop)
    for glue in rest:
        weaker = find_rest(problem.statics, _glue(statics, glue), numerics, start=glued, stop=stop)
        if not weaker.converged:
            break
        glued = weaker
    return glued


def _glue(statics: Statics, stiffness: float) -> Compliance:
    return law.uniform(statics, slip=1.0, glue=stiffness)


def _words(needy: list[str], unheld: set[str], balanced: bool) -> str:
    if not needy:
        return "no block shows that it needs help"
    shown = named(needy)
    stuck = [name for name in needy if name in unheld]
    if not balanced:
        return f"help is needed at {shown}; no tension was found that balances the loads: prop them"
    if not stuck:
        return f"help is needed at {shown}; glue would do"
    return f"help is needed at {shown}; glue cannot hold {named(stuck)}: prop them"
