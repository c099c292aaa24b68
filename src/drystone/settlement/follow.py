"""Blocks followed by implicit quasi-static steps until they rest or fall.

A step solves for the motion q of the free blocks, with the friction that earlier steps built up:

    A f(q) + p - c M q = 0

c M is a drag in proportion to mass. Where the contacts balance the load, c is lowered until it
carries nothing: rest. Where they do not, the blocks creep on, c being such that no step is longer
than a small share of a block. After every step the blocks, and the faces and corners on them, are
moved by finite rotations and the gaps are computed anew.

The path does not depend on c, only on the order in which the load is put on: measured on ten models
it ends at the same tilt with the load at once, in twenty parts and turned from upright.
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
"""Newton steps after which an increment is taken to be too long."""
BALANCED = 1e-10
"""Unbalanced share of the load at which an increment is solved."""
EASY = 12
"""Newton steps up to which the next increment may be longer."""
SLOWER, FASTER = 2.5, 0.9
"""What a refused increment does to the drag, and an easy one. With 0.8, steps twice as long (0.64)
moved the limit of one wedge by a degree; 0.4 moves those of two."""
STEP, LONG_STEP = 2e-4, 2e-3
"""Longest increment by a block's size, and where the structure clearly moves on: it is then asked
only whether it stops."""
FAR, CLEAR = 0.03, 0.3
"""Way by a block's size, and share of the load that the contacts do not carry, from which on it
clearly moves on. Wedges that slide and jam leave no more than 0.15 to the drag."""
AT_REST = 1e-9
"""Share of the load that the drag may carry at rest."""
ROUGHLY = 1e-3
"""The same between two parts of a motion of supports."""
STILL = 1e-3
"""Motion of the last increment by the overlap, at rest."""
SUPPORT_STEP = 1e-3
"""Largest part of a motion of supports, by the mean size of a block."""
MOST_DRAG = 1e12
"""By the drag at the beginning, beyond which no increment can be solved."""
LEFT_STEPS = 250
"""Increments after which what clearly moves on is followed no farther: it does not stand, and a
fall without obstacles takes 135."""
FRAMES = 240
"""Positions kept of a path; of more, every other one is left out."""


@dataclass(frozen=True, eq=False)
class Track:
    """How the blocks moved, scaled.

    Attributes
    ----------
    ended : ``rests``, ``falls``, ``lost`` (no increment could be solved) or ``stopped``
    frames
        Poses from first to last.
    placed, response
        Corners and their forces at the last pose.
    way : (f,) of each free block by its size
    share
        Of the load that the contacts do not carry at the end.
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
        Way of a block by its size at which it is said to fall.
    pace
        Length of the steps, 1 by default.
    stop
        Asked before every increment.
    tell
        Called with the largest way after every increment.
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
        """Until they rest or fall; then, where they rest, with supports that move by (n, 6)."""
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
                # what hardly moves any more needs no small steps to its end
                quick = longest < bodies.overlap and self.share < 1e-3
                self.drag *= 0.1 if quick else FASTER**self.pace

    def _supports(self, motion: Floats) -> str:
        """Move the supports in small parts, and let the blocks rest, more or less, after each."""
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
        """The motion (f, 6) of one increment, by Newton's method; None where it is too long."""
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
        """(f,) translation and rotation by the radius of each free block, by its size."""
        bodies, free = self.bodies, self.bodies.free
        gone = np.linalg.norm(self.pose.place[free] - bodies.centroid[free], axis=1)
        trace = np.trace(self.pose.turn[free], axis1=1, axis2=2)
        turned = np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0))
        way: Floats = (gone + turned * bodies.radius[free]) / bodies.size[free]
        return way

    def _longest(self) -> float:
        """Of an increment, by the smallest block: short where it matters how blocks slide."""
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
