"""Supports that are dragged: the blocks follow in few coarse increments, for a first answer.

Springs, friction and finite rotations are those of :mod:`drystone.settlement.follow`. Two things
are coarser. The blocks come to rest in one increment, under a drag that decreases. Supports then
move in increments as long as Newton's method finds an equilibrium, where the analysis limits them
by a block's motion.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.model import Model
from drystone.settlement.bodies import build_bodies
from drystone.settlement.faces.corners import Carrier
from drystone.settlement.faces.meeting import FARTHEST, faces_apart, followed_model
from drystone.settlement.large.driven import DrivenState, Driver
from drystone.settlement.large.large_states import large_state
from drystone.settlement.large.large_types import LargeState
from drystone.settlement.path import scaled_motion
from drystone.settlement.settlement_types import SettlementOptions

_DRAGS = (1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-7)
"""Drag in turn, by the first of a block that is followed; the last one carries less than a
thousandth of the load. Chosen: a vault of 97 blocks rests in 0.05 s, one of 399 in 0.5 s."""
SHORTER, LONGER = 0.25, 2.0
"""Factors on the length of the next increment: after one that was not found, and after one that
was."""
_SHORTEST = 1e-6
"""Share of the motion below which increments are not made shorter."""


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
        driver = Driver(self.bodies, fall=chosen.fall, step_limit=chosen.step_limit, stop=stop)
        found = None
        for share in _DRAGS:
            driver.drag = share * driver.first
            guess = None if found is None else found.motion
            found = driver.alone(driver._increment(guess))
            if found is None:
                return None
        if found is not None:
            driver.alone(driver._accept(found))
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
        driver = copy.copy(begin.driver)
        driver.frames = [driver.pose]
        driver.maps.at(driver.pose, driver.placed)  # all places share the maps
        driver.guess, driver.drag = None, _DRAGS[-1] * driver.first
        way = wanted - begin.motion
        done, step, end = 0.0, 1.0, time.monotonic() + seconds
        while done < 1.0 - 1e-12 and step > _SHORTEST:
            step = min(step, 1.0 - done)
            found = driver.alone(driver._increment(None, step * way))
            if found is None:
                step *= SHORTER
            else:
                driver.alone(driver._accept(found, step * way))
                done += step
                step *= LONGER
            if time.monotonic() > end:
                break
        reached = begin.motion + done * way
        self.last = _Place(driver, reached)
        length = float(np.linalg.norm(reached[:, :3], axis=1).max()) * self.bodies.length_unit
        moment = DrivenState(1.0, 0.0, driver.pose, driver.placed, driver.response)
        state = large_state(self.model, self.apart, self.bodies, moment, driver.met, length, 1.0)
        return state, done
