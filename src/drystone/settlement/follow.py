"""Blocks followed by implicit quasi-static steps until they rest or fall.

A step solves for the motion q of the free blocks, with the friction forces of earlier steps:

    A f(q) + p - c M q = 0

c M is a drag proportional to mass. If the contacts balance the load, c is reduced until the drag
carries nothing: rest. If they do not, the blocks continue to move; c is such that no step is longer
than a small share of a block. After every step the blocks with their faces and corners are moved by
finite rotations, and the gaps are computed again.

The path does not depend on c, only on the order of loading. Measured on ten models: it ends at the
same tilt with the load applied at once, in twenty parts, or rotated from upright.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import SolverError
from drystone.settlement.bodies import Bodies
from drystone.settlement.springs import (
    Placed,
    Pose,
    Response,
    imposed,
    maps_of,
    place_corners,
    respond,
    tangents,
)

NEWTON = 40
"""Newton steps after which an increment counts as too long."""
BALANCED = 1e-10
"""Unbalanced share of the load at which an increment has converged."""
EASY = 12
"""Newton steps up to which the next increment may be longer."""
SLOWER, FASTER = 2.5, 0.8
"""Factors on the drag after a refused increment, and after an easy one. Chosen: with 0.4 instead of
0.8 the limits of two wedges differ by a degree, with 0.9 by less than a tenth."""
STEP, LONG_STEP = 2e-4, 2e-3
"""Longest increment relative to a block's size, and the same where the structure clearly moves:
then the only question is whether it stops."""
FAR, CLEAR = 0.03, 0.3
"""Displacement relative to a block's size, and share of the load on the drag, from which on the
structure clearly moves. With wedges that slide and jam the drag carries at most 0.15."""
AT_REST = 1e-9
"""Share of the load that the drag may carry at rest."""
ROUGHLY = 1e-3
"""The same between two parts of a motion of supports."""
STILL = 1e-3
"""Motion of the last increment relative to the overlap, at rest."""
SUPPORT_STEP = 1e-3
"""Largest step of a motion of supports, relative to the mean size of a block."""
MOST_DRAG = 1e12
"""Largest drag relative to the initial one; beyond it no increment can be solved."""
LEFT_STEPS = 250
"""Increments after which what clearly moves on is followed no farther: it does not stand, and a
fall without obstacles takes 135."""
FRAMES = 240
"""Largest number of stored positions of a path; if there are more, every other one is removed."""


@dataclass(frozen=True, eq=False)
class Track:
    """The motion of the blocks, scaled.

    Attributes
    ----------
    ended : ``rests``, ``falls``, ``lost`` (no increment could be solved) or ``stopped``
    frames
        Poses from first to last.
    placed, response
        Corners and their forces at the last pose.
    way : (f,) displacement of each free block relative to its size
    share
        Share of the load that the contacts do not carry at the end.
    steps, iterations
    """

    ended: str
    frames: tuple[Pose, ...]
    placed: Placed
    response: Response
    way: Floats
    share: float
    steps: int
    iterations: int


class _Increment(NamedTuple):
    motion: Floats
    response: Response
    iterations: int


class Follower:
    """One run of the steps.

    Parameters
    ----------
    bodies
    fall
        Displacement of a block relative to its size at which it falls.
    pace
        Length of the steps, 1 by default.
    stop
        Called before every increment.
    tell
        Called with the largest displacement after every increment.
    """

    def __init__(
        self,
        bodies: Bodies,
        *,
        fall: float,
        pace: float = 1.0,
        step_limit: int = 5000,
        stop: Callable[[], bool] | None = None,
        tell: Callable[[float], None] | None = None,
    ) -> None:
        self.bodies = bodies
        self.maps = maps_of(bodies)
        self.fall, self.pace, self.step_limit = fall, pace, step_limit
        self.stop, self.tell = stop, tell
        count = len(bodies.centroid)
        self.pose = Pose(bodies.centroid.copy(), np.tile(np.eye(3), (count, 1, 1)))
        self.friction = np.zeros((len(bodies.block_a), 2))
        self.frames = [self.pose]
        self.stride, self.since = 1, 0
        self.load_size = max(float(np.linalg.norm(bodies.load)), np.finfo(float).tiny)
        self.first = max(float(bodies.normal.sum()), 1.0) / max(len(bodies.free), 1)
        self.drag = self.first
        self.guess: tuple[Floats, float] | None = None
        self.steps = self.iterations = self.beyond = 0
        self.left_steps = step_limit
        self.placed = place_corners(bodies, self.pose)
        nothing = np.zeros((len(bodies.block_a), 3))
        self.response = respond(bodies, self.placed.gap, self.friction, nothing)
        self.share = 1.0

    def run(self, supports: Floats | None = None) -> Track:
        """Run until they rest or fall; if they rest, move the supports by (n, 6)."""
        # blocks that follow their supports go far without falling
        self.left_steps = LEFT_STEPS if supports is None else self.step_limit
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            ended = self._to_rest()
            if supports is not None and ended == "rests":
                ended = self._supports(supports)
            return self._track(ended)

    def _to_rest(self, *, roughly: bool = False) -> str:
        bodies = self.bodies
        refused = 0
        while True:
            if self._late():
                return "stopped"
            guess = None
            if self.guess is not None and refused < 2:
                guess = self.guess[0] * (self.guess[1] / self.drag)
            found = self._increment(guess)
            longest = np.inf if found is None else float(np.abs(found.motion).max(initial=0.0))
            if found is None or longest > self._longest():
                refused += 1
                self.drag *= SLOWER
                if self.drag > MOST_DRAG * self.first:
                    return "lost"
                continue
            refused = 0
            self.guess = found.motion, self.drag
            carried = self.drag * bodies.mass[:, None] * found.motion
            self.share = float(np.linalg.norm(carried)) / self.load_size
            self._accept(found)
            rests = self.share < AT_REST and longest < STILL * bodies.overlap
            if rests or (roughly and self.share < ROUGHLY):
                return "rests"
            if self._way().max(initial=0.0) > self.fall:
                return "falls"
            if found.iterations < EASY:
                # nearly at rest: small steps are not needed
                quick = longest < bodies.overlap and self.share < 1e-3
                self.drag *= 0.1 if quick else FASTER**self.pace

    def _supports(self, motion: Floats) -> str:
        """Move the supports in small steps, with approximate rest after each."""
        reach = np.linalg.norm(motion[:, :3], axis=1) + np.linalg.norm(motion[:, 3:], axis=1)
        parts = max(int(np.ceil(float(reach.max(initial=0.0)) / (SUPPORT_STEP * self.pace))), 1)
        done, part = 0.0, 1.0 / parts
        while done < 1.0 - 1e-12:
            if self._late():
                return "stopped"
            part = min(part, 1.0 - done)
            self.drag, self.guess = 1e-3 * self.first, None
            found = self._increment(None, part * motion)
            if found is None:
                part *= 0.5
                if part * parts < 1e-6:
                    return "lost"
                continue
            self._accept(found, part * motion)
            done += part
            part = min(2.0 * part, 1.0 / parts)
            ended = self._to_rest(roughly=done < 1.0 - 1e-12)
            if ended != "rests":
                return ended
        return "rests"

    def _increment(self, guess: Floats | None, moving: Floats | None = None) -> _Increment | None:
        """The motion (f, 6) of one increment, by Newton's method; None if it is too long."""
        bodies, maps = self.bodies, self.maps
        placed = self.placed
        maps.at(self.pose, placed)
        shift = None if moving is None else imposed(bodies, self.pose, placed, moving)
        weight = np.repeat(self.drag * bodies.mass[:, None], 6, axis=1)

        def answer(motion: Floats) -> tuple[Response, Floats, float]:
            moved = maps.moved(motion)
            if shift is not None:
                moved = moved + shift
            response = respond(bodies, placed.gap, self.friction, moved)
            left = maps.wrench(response.force) + bodies.load - weight * motion
            return response, left, float(np.linalg.norm(left)) / self.load_size

        motion = np.zeros((len(bodies.free), 6)) if guess is None else guess
        response, left, size = answer(motion)
        recent = [size]
        for number in range(NEWTON):
            if size < BALANCED:
                return _Increment(motion, response, number)
            self.iterations += 1
            try:
                step = maps.solve(tangents(bodies, response), weight, left)
            except SolverError:
                return None
            length, allowed = 1.0, max(recent[-4:])
            while True:
                trial = motion + length * step
                response, left, size = answer(trial)
                if size < (1.0 - 1e-3 * length) * allowed or length < 0.03:
                    break
                length *= 0.5
            if not np.isfinite(size):
                return None
            motion = trial
            recent.append(size)
        return None

    def _accept(self, found: _Increment, moving: Floats | None = None) -> None:
        bodies = self.bodies
        step = found.motion.copy()
        step[:, 3:] /= bodies.radius[bodies.free, None]
        if moving is not None:
            fixed = np.flatnonzero(bodies.slot < 0)
            part = moving[fixed].copy()
            part[:, 3:] /= bodies.radius[fixed, None]
            self.pose = self.pose.moved(fixed, part)
        self.pose = self.pose.moved(bodies.free, step)
        self.friction = found.response.force[:, 1:]
        self.response = found.response
        self.placed = place_corners(bodies, self.pose)
        self.steps += 1
        self.beyond += float(self._way().max(initial=0.0)) > FAR
        self.since += 1
        if self.since >= self.stride:
            self.frames.append(self.pose)
            self.since = 0
            if len(self.frames) > FRAMES:
                self.frames = self.frames[::2]
                self.stride *= 2
        if self.tell is not None:
            self.tell(float(self._way().max(initial=0.0)))

    def _way(self) -> Floats:
        """Displacement (f,) of each free block relative to its size, with rotation times radius."""
        bodies, free = self.bodies, self.bodies.free
        gone = np.linalg.norm(self.pose.place[free] - bodies.centroid[free], axis=1)
        trace = np.trace(self.pose.turn[free], axis1=1, axis2=2)
        turned = np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0))
        way: Floats = (gone + turned * bodies.radius[free]) / bodies.size[free]
        return way

    def _longest(self) -> float:
        """The longest increment, from the smallest block: short where sliding decides."""
        clear = self.share > CLEAR or float(self._way().max(initial=0.0)) > FAR
        size = float(self.bodies.size[self.bodies.free].min(initial=np.inf))
        return self.pace * size * (LONG_STEP if clear else STEP)

    def _late(self) -> bool:
        if self.steps >= self.step_limit or self.beyond >= self.left_steps:
            return True
        return self.stop is not None and self.stop()

    def _track(self, ended: str) -> Track:
        frames = self.frames if self.frames[-1] is self.pose else [*self.frames, self.pose]
        return Track(
            ended,
            tuple(frames),
            self.placed,
            self.response,
            self._way(),
            self.share,
            self.steps,
            self.iterations,
        )


__all__ = ["Follower", "Track"]
