"""From one rest state to the next: Newton's method on the contact law itself.

Next to a rest state few corners change between pressing and open, or between sticking and sliding.
Full Newton steps on the unrelaxed law then need about five iterations, a third of those of the
relaxed law from the same start. Where many corners change, the steps cycle and are given up.

Source: the semismooth Newton method, Qi and Sun 1993.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drystone.base.errors import SolverError
from drystone.formulations.rest.compliance import Compliance, wrench_size
from drystone.formulations.rest.rest_state import (
    RestOptions,
    RestState,
    Start,
    block_scale,
    mass_matrix,
)
from drystone.formulations.rest.tangent import TangentSystem

STALL = 3
"""The steps are given up after this many in a row that do not halve the largest unbalanced share.
Measured: of 382 runs from a neighbouring stage that come to rest, 7 need more."""

HOPELESS = 0.25
"""The steps are given up where the largest unbalanced share is above this after two steps.
Measured: of 332 runs that come to rest one is lost; those that do not take 2.7 steps instead of
4.1."""


def find_rest_nearby(
    system: TangentSystem,
    compliance: Compliance,
    options: RestOptions,
    start: Start,
    stop: Callable[[], bool] | None = None,
) -> RestState | None:
    """The rest state next to a start.

    Parameters
    ----------
    system
        The model, with its elimination order. No corner may join two fixed blocks.
    compliance
    options
        Of these, the ground and the tolerance count.
    start
        A state near a rest state.
    stop
        Asked before every step; True ends the iteration.

    Returns
    -------
    RestState
        Converged; None where the method leads nowhere, which says nothing.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _descend(system, compliance, options, start, stop)


def _descend(
    system: TangentSystem,
    compliance: Compliance,
    options: RestOptions,
    start: Start,
    stop: Callable[[], bool] | None,
) -> RestState | None:
    statics, kn = system.statics, compliance.normal
    glue = compliance.glue * kn
    weight = options.ground * mass_matrix(statics)
    tangent = np.zeros((statics.corner_count, 3, 3))
    motion = start.motion
    best, since, steps = np.inf, 0, 0
    while since < STALL and not (stop is not None and stop()):
        moved = statics.displacement(motion)
        gap = moved[:, 0] + compliance.overlap
        normal = kn * np.maximum(0.0, -gap)
        held, slope = compliance.pull(np.maximum(0.0, gap))
        bearing = normal - held
        pull = glue * np.maximum(0.0, gap)
        friction = compliance.friction(bearing, moved[:, 1:])
        force = np.concatenate([(bearing - pull)[:, None], -friction.force], axis=1)
        ground = weight * motion
        rest = statics.wrench(force) + statics.load - ground
        share = float((wrench_size(rest) / block_scale(statics, force)).max(initial=0.0))
        if share <= options.tolerance:
            return RestState(motion, normal, force, pull, ground, share, True, steps)
        if steps >= 2 and share > HOPELESS:
            return None
        since = 0 if share < 0.5 * best else since + 1
        best = min(best, share)
        pressed = gap < 0.0
        tangent[:, 0, 0] = np.where(pressed, kn, glue + slope)
        tangent[:, 1:, 0] = -friction.by_normal * np.where(pressed, kn, slope)[:, None]
        tangent[:, 1:, 1:] = friction.by_slide
        try:
            motion = motion + system.factorise(tangent, weight).solve(rest)
        except SolverError:
            return None
        steps += 1
    return None
