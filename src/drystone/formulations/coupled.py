"""Coupled rigid-block analysis after eq. 5.6: equal overlap of all corners in compression.

``fn (dn + eps) = 0, dn + eps >= 0``: no overlap exceeds eps, and a corner carries force only where
its overlap is eps. A family of laws leads from springs (overlap = fn / kn) to this one:

    overlap = theta eps + (1 - theta) fn / kn,    0 <= theta <= 1,

The solution is followed from a rest state on springs, theta = 0, to theta = 1 - 1e-7. The overlaps
then agree to 1e-7. Source of the law: Kao et al. 2022, eq. 5.6. The path is our own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drystone.mechanics.law import Compliance, FrictionBound, SlipLength
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions, RestState
from drystone.mechanics.statics import Statics

SPRING_LEFT = 1e-7
"""1 - theta at the end of the path: relative difference of overlaps, a tenth of the tolerance."""


@dataclass(frozen=True, eq=False)
class EqualOverlap:
    """End of the path.

    Attributes
    ----------
    state
        Motions in units of the overlap eps.
    reached
        Whether the path reached its end.
    iterations
    """

    state: RestState
    reached: bool
    iterations: int


def equal_overlap(
    statics: Statics,
    start: RestState,
    slip: float,
    *,
    stop: Callable[[], bool] | None = None,
    step_limit: int = 60,
) -> EqualOverlap:
    """Follow the overlaps of a rest state until they are equal.

    Parameters
    ----------
    statics
    start
        A rest state on springs of uniform stiffness and the given slip length.
    slip
        Slip length of the friction law, relative to the local overlap.
    stop
    step_limit
        Largest number of points of the path.
    """
    gap = statics.displacement(start.motion)[:, 0]
    total = float(start.force[:, 0].sum())
    mean = float(-(start.force[:, 0] * gap).sum()) / total if total > 0.0 else 1.0
    if not mean > 0.0:
        return EqualOverlap(start, False, 0)
    spring = mean * statics.normal_stiffness
    reach = SlipLength(FrictionBound(statics.friction), slip * statics.corner_load / spring)
    # near the end of the path Newton's method on the unrelaxed law needs a point near the state
    options = RestOptions(
        ground=1e-10, tolerance=1e-9, iteration_limit=40, warm_relaxation=1e-2, polish=1e-7
    )
    state = replace(start, motion=start.motion / mean)
    left, factor, iterations = 1.0, 0.3, 0
    for _ in range(step_limit):
        aim = max(left * factor, SPRING_LEFT)
        law = Compliance(spring / aim, reach, overlap=1.0 - aim)
        trial = find_rest(statics, law, options, start=state, stop=stop)
        iterations += trial.iterations
        if trial.converged:
            state, left = trial, aim
            factor = max(factor**1.5, 0.03)
            if left <= SPRING_LEFT:
                break
        else:
            factor = np.sqrt(factor)
        if factor > 0.97 or (stop is not None and stop()):
            break
    if left > SPRING_LEFT:
        return EqualOverlap(state, False, iterations)
    free = replace(options, ground=1e-16, tolerance=1e-10, iteration_limit=30, warm_relaxation=1e-8)
    final = find_rest(statics, law, free, start=state, stop=stop)
    iterations += final.iterations
    return EqualOverlap(final, final.converged, iterations)
