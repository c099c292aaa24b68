"""A rest state from a similar one, by Newton's method on the unrelaxed contact law.

Between similar rest states few corners change between closed and open, or between sticking and
sliding. Full Newton steps then need about five iterations, a third of those with the relaxed law.
Where many corners change, the steps cycle and the method stops.

Source: the semismooth Newton method, Qi and Sun 1993.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import SolverError
from drystone.formulations.rest.compliance import Compliance, respond, wrench_size
from drystone.formulations.rest.rest_state import (
    RestOptions,
    RestState,
    Start,
    block_scale,
)
from drystone.formulations.rest.tangent import TangentSystem

STALL = 3
"""Largest number of successive steps that do not halve the largest unbalanced share. Measured: of
382 converging runs from a similar stage, 7 need more."""

HOPELESS = 0.25
"""Largest unbalanced share after two steps with which the method continues. Measured: of 332
converging runs one is lost; the others stop after 2.7 steps instead of 4.1."""

CHORDS = 2
"""Steps with the same factors in which the largest unbalanced share must become small enough: they
take two thirds of the time of one step with its own factors, which leads as far."""

LOST = 0.999
"""The same after one step. At 1 no force acts on some block; no run is known that came back."""


def find_rest_nearby(
    system: TangentSystem,
    compliance: Compliance,
    options: RestOptions,
    start: Start,
    stop: Callable[[], bool] | None = None,
) -> RestState | None:
    """The rest state near a start.

    Parameters
    ----------
    system
        The model, with its elimination order. No interface may join two fixed blocks.
    compliance
    options
        Only the ground and the tolerance are used.
    start
        A state near a rest state.
    stop
        Called before every step; True ends the iteration.

    Returns
    -------
    RestState
        Converged; None if the method does not converge, which proves nothing.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return descend(system, compliance, options, start.motion, stop)[0]


def find_rests_nearby(
    system: TangentSystem,
    compliance: Compliance,
    options: RestOptions,
    start: Start,
    stop: Callable[[], bool] | None = None,
) -> list[RestState | None]:
    """:func:`find_rest_nearby` for springs (s, k) from motions (s, n, 6), as one calculation."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _descend_together(system, compliance, options, start.motion, stop)[0]


def descend(
    system: TangentSystem,
    compliance: Compliance,
    options: RestOptions,
    motion: Floats,
    stop: Callable[[], bool] | None = None,
) -> tuple[RestState | None, int]:
    """As :func:`find_rest_nearby`, from a motion (n, 6), with the number of Newton steps."""
    together = Compliance.stacked([compliance])
    found, steps = _descend_together(system, together, options, motion[None], stop)
    return found[0], steps


def _descend_together(
    system: TangentSystem,
    compliance: Compliance,
    options: RestOptions,
    start: Floats,
    stop: Callable[[], bool] | None,
) -> tuple[list[RestState | None], int]:
    statics, kn = system.statics, compliance.normal
    weight = options.ground * statics.mass_matrix
    motion = start.copy()
    count = len(motion)
    found: list[RestState | None] = [None] * count
    left = list(range(count))
    best, since, steps = [np.inf] * count, [0] * count, 0
    before = [np.inf] * count
    solve: list[Callable[[Floats], Floats] | None] = [None] * count
    rough = [True] * count  # as long as single precision leads on
    moved = statics.displacement(motion)
    while left and not (stop is not None and stop()):
        gap = moved[..., 0] + compliance.overlap
        response = respond(compliance, gap, moved[..., 1:])
        force, pull = response.force, np.broadcast_to(response.tension, gap.shape)
        ground = weight * motion
        rest = statics.wrench(force) + statics.load - ground
        shares = wrench_size(rest) / block_scale(statics, force)
        for i in tuple(left):
            share = float(shares[i].max(initial=0.0))
            if share <= options.tolerance:
                state = (
                    motion[i].copy(),
                    np.maximum(0.0, -kn[i] * gap[i]),
                    force[i],
                    pull[i],
                    ground[i],
                )
                found[i] = RestState(*state, share, True, steps)
            # the first step often makes it worse: progress counts from there
            since[i] = 0 if steps < 2 or share < 0.5 * best[i] else since[i] + 1
            best[i] = share if steps < 2 else min(best[i], share)
            # convergence is quadratic in the end: the last factors then do for two steps more
            if share * (share / before[i]) ** CHORDS > options.tolerance:
                solve[i] = None
                rough[i] = share < HOPELESS * before[i]
            before[i] = share
            lost = steps > 0 and share > (HOPELESS if steps > 1 else LOST)
            if found[i] is not None or lost:
                left.remove(i)
        if not left:
            break
        if any(solve[i] is None for i in left):
            tangent = response.tangent
        for i in tuple(left):
            try:
                factors = solve[i] or system.factorise(tangent[i], weight, rough=rough[i])
            except SolverError:
                left.remove(i)
                continue
            solve[i], step = factors, factors(rest[i])
            motion[i] += step
            moved[i] += statics.displacement(step)
        steps += 1
        left = [i for i in left if since[i] < STALL]
    return found, steps
