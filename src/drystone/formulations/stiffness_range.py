"""Rest on joints whose stiffnesses differ, but not without bounds.

In the rigid limit equally pressed corners may share a load in any proportion; corners that are
springs share it as their stiffnesses do. Here every corner presses with ``k_i`` times its overlap,
every ``k_i`` lies between 1 and ``spread`` times the softest, and friction acts against the slide,
as far as the cone goes. A motion is turned step by step until such forces balance the loads: a
sequence of quadratic programs in motion and forces with a trust region on the slides.

Close to the limit few motions are near enough to turn into a state. More are with more friction, so
that it begins there and is led down to the friction that there is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drystone.formulations.compatible import compatible_forces, slide_directions
from drystone.formulations.corner_blocks import NORMAL, CornerBlocks
from drystone.formulations.improvement import TURN, CompatibleState
from drystone.geometry.arrays import Bools, Floats
from drystone.solvers.conic import Cones, ConicOptions, ConicStatus, solve_conic
from drystone.solvers.triplets import Triplets
from drystone.statics import Statics

TOUCHING = 1e-7
"""Gaps below this share of the largest overlap may close or open in the next step."""

MORE_FRICTION = 1.2
"""Friction that a motion begins with, by what there is. Chosen: of the wedges of Kao 2023 within a
degree of their limit, with 1.1 half as many motions lead to a state, with 1.3 no more do."""

PATIENCE = 6
"""Steps with little progress after which a motion is given up."""


@dataclass(frozen=True)
class RangeOptions:
    """Options of :func:`settle`.

    Attributes
    ----------
    spread
        Largest ratio of two stiffnesses.
    tolerance
        Unbalanced norm, by the norm of the loads, that is an answer.
    iteration_limit
        Steps at one friction.
    """

    spread: float = 300.0
    tolerance: float = 1e-9
    iteration_limit: int = 30


def settle(
    statics: Statics,
    motion: Floats,
    options: RangeOptions | None = None,
    *,
    stop: Callable[[], bool] | None = None,
) -> CompatibleState:
    """Turn a motion until springs of some stiffness within the range balance the loads with it.

    Parameters
    ----------
    statics
    motion : (n, 6)
        Where to start; its size does not matter.
    options
    stop
        Asked before every step.
    """
    chosen = options if options is not None else RangeOptions()
    turning = _Turning(statics, chosen, stop)
    state = turning.begin(_scaled(statics, motion, chosen.spread), MORE_FRICTION)
    state, more = turning.run(state), MORE_FRICTION
    reached, less = state, 1.0
    ...
