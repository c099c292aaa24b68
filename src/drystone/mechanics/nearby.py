"""A rest state from a similar one, by Newton's method on the unrelaxed contact law.

Between similar rest states few corners change between closed and open, or between sticking and
sliding. Full Newton steps then need about five iterations, a third of those with the relaxed law.
Where many corners change, the steps cycle and the method stops.

Source: the semismooth Newton method, Qi and Sun 1993.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.mechanics.law import (
    Compliance,
    ContactResponse,
    respond,
    wrench_size,
)
from drystone.mechanics.maps import Solve
from drystone.mechanics.newton import Equation, Steps, newton
from drystone.mechanics.rest_state import RestOptions, RestState, Start, block_scale
from drystone.mechanics.statics import Statics

STALL = 3
"""Largest number of successive steps that do not halve the largest unbalanced share. Measured: of
382 converging runs from a similar stage, 7 need more."""

HOPELESS = 0.25
"""Largest unbalanced share after two steps with which the method continues. Measured: of 332
converging runs one is lost; the others stop after 2.7 steps instead of 4.1."""

CHORDS = 2
"""Steps with the same factors in which the largest unbalanced share must become small enough: they
take two thirds of the time of one step with its own factors, which leads as far."""

LIMIT = 100
"""Steps at most; STALL ends a run long before."""

LOST = 0.999
"""The same after one step. At 1 no force acts on some block; no run is known that came back."""


def find_rest_nearby(
    statics: Statics,
    compliance: Compliance,
    options: RestOptions,
    start: Start,
    stop: Callable[[], bool] | None = None,
) -> RestState | None:
    """The rest state near a start.

    Parameters
    ----------
    statics
        No interface may join two fixed blocks.
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
        return descend(statics, compliance, options, start.motion, stop)[0]


def descend(
    statics: Statics,
    compliance: Compliance,
    options: RestOptions,
    motion: Floats,
    stop: Callable[[], bool] | None = None,
) -> tuple[RestState | None, int]:
    """As :func:`find_rest_nearby`, from a motion (n, 6), with the number of Newton steps."""
    law = _Law(statics, compliance, options, stop)
    begin = law.at(motion, statics.displacement(motion))
    point, solved, steps = newton(law, begin, Steps(LIMIT, chords=CHORDS))
    if not solved:
        return None, steps
    normal = compliance.normal * np.maximum(0.0, -point.moved[:, 0] - compliance.overlap)
    response = point.response
    tension = np.broadcast_to(response.tension, normal.shape)
    state = RestState(
        point.motion, normal, response.force, tension, point.ground, point.size, True, steps
    )
    return state, steps


class _Point(NamedTuple):
    """An iterate; ``size`` is the largest unbalanced share of a block."""

    motion: Floats
    moved: Floats
    response: ContactResponse
    ground: Floats
    left: Floats
    size: float


class _Law(Equation[_Point, Floats]):
    """Balance under the unrelaxed law."""

    def __init__(
        self,
        statics: Statics,
        compliance: Compliance,
        options: RestOptions,
        stop: Callable[[], bool] | None,
    ) -> None:
        self.statics, self.compliance, self.stop = statics, compliance, stop
        self.goal = options.tolerance
        self.weight = options.ground * statics.mass_matrix
        self.solve: Solve | None = None
        self.best, self.since, self.before = np.inf, 0, np.inf

    def at(self, motion: Floats, moved: Floats) -> _Point:
        """The iterate at a motion (n, 6), and at the corner displacements (k, 3) by it."""
        statics = self.statics
        response = respond(self.compliance, moved[:, 0] + self.compliance.overlap, moved[:, 1:])
        ground = self.weight * motion
        left = statics.wrench(response.force) + statics.load - ground
        share = wrench_size(left) / block_scale(statics, response.force)
        return _Point(motion, moved, response, ground, left, float(share.max(initial=0.0)))

    def tolerance(self, point: _Point) -> float:
        del point
        return self.goal

    def lost(self, sizes: Sequence[float], point: _Point) -> bool:
        steps, share = len(sizes) - 1, point.size
        # the first step often makes it worse: progress counts from there
        self.since = 0 if steps < 2 or share < 0.5 * self.best else self.since + 1
        self.best = share if steps < 2 else min(self.best, share)
        far = steps > 0 and share > (HOPELESS if steps > 1 else LOST)
        return far or self.since >= STALL or (self.stop is not None and self.stop())

    def step(self, point: _Point, renew: bool) -> Floats:
        if renew or self.solve is None:
            rough = point.size < HOPELESS * self.before  # as long as single precision leads on
            self.solve = None  # one set of factors at a time
            tangent = point.response.tangent
            self.solve = self.statics.maps.factorise(tangent, self.weight, rough=rough)
        self.before = point.size
        return self.solve(point.left)

    def after(self, point: _Point, step: Floats, length: float) -> _Point:
        del length  # steps are full
        moved = point.moved + self.statics.displacement(step)
        return self.at(point.motion + step, moved)
