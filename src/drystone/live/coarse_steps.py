"""Supports that are dragged: the blocks follow in few coarse increments, for a first answer.

Springs, friction and finite rotations are those of :mod:`drystone.mechanics.follow`. Two things
are coarser. The blocks come to rest in one increment, under a drag that decreases. Supports then
move in increments as long as Newton's method finds an equilibrium, where the analysis limits them
by a block's motion.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.mechanics.bodies import build_bodies
from drystone.mechanics.corners import Carrier
from drystone.mechanics.drive import Driver
from drystone.mechanics.follow import Bounds
from drystone.mechanics.meeting import FARTHEST, faces_apart, followed_model
from drystone.model import Model
from drystone.settlement.large_states import large_state
from drystone.settlement.large_types import LargeState
from drystone.settlement.path import scaled_motion
from drystone.settlement.settlement_types import SettlementOptions


class _Place(NamedTuple):
    """The blocks, and the motion (n, 6) of the supports that led there, scaled."""

    driver: Driver
    motion: Floats


class CoarseSteps:
    """A model at rest whose supports are moved again and again.

    Parameters
    ----------
    model
    stop

    Raises
    ------
    InputError
        Joints carry more than friction.
    """

    def __init__(self, model: Model, stop: Callable[[], bool] | None = None) -> None:
        model.require_dry("moved supports", "what a joint carries after it has moved is not known")
        chosen = SettlementOptions()
        self.model = model.with_load(replace(model.load, motion=None))
        self.apart = faces_apart(self.model, FARTHEST)
        part, gap = followed_model(self.model, self.apart)
        self.bodies = build_bodies(
            part, Carrier.MOVING, overlap=chosen.overlap, tangential=chosen.tangential, gap=gap
        )
        self.rest = self._rested(chosen, stop)
        self.last = self.rest

    def _rested(self, chosen: SettlementOptions, stop: Callable[[], bool] | None) -> _Place | None:
        """The blocks at rest; None where none was found."""
        bounds = Bounds(chosen.fall, step_limit=chosen.step_limit)
        driver = Driver(self.bodies, bounds, stop=stop)
        if not driver.rest_at_once():
            return None
        return _Place(driver, np.zeros((len(self.model), 6)))

    def moved(self, motion: Floats, seconds: float) -> tuple[LargeState, float] | None:
        """Blocks and forces where supports have moved, and the share of their way that is done.

        They go on from where they were last, or from rest where that is nearer. At least one
        increment is tried, and none is begun after ``seconds``.

        Parameters
        ----------
        motion : (n, 6) [m, rad]
        seconds
        """
        if self.rest is None or self.last is None:
            return None
        wanted = scaled_motion(self.bodies, motion)
        nearer = np.linalg.norm(wanted - self.last.motion) < np.linalg.norm(wanted)
        begin = self.last if nearer else self.rest
        driver, way = begin.driver.again(), wanted - begin.motion
        end = time.monotonic() + seconds
        done = driver.shift_at_once(way, lambda: time.monotonic() > end)
        reached = begin.motion + done * way
        self.last = _Place(driver, reached)
        length = float(np.linalg.norm(reached[:, :3], axis=1).max()) * self.bodies.length_unit
        moment = driver.now()._replace(displacement=1.0, load=0.0)
        state = large_state(self.model, self.apart, self.bodies, moment, driver.met, length, 1.0)
        return state, done
