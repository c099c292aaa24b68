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

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.errors import SolverError
from drystone.settlement.bodies import Bodies
from drystone.settlement.springs import (
    BlockPositions,
    Placed,
    Response,
    SparseMaps,
    imposed,
    maps_of,
    place_corners,
    respond,
    tangents,
)

NEWTON = 40
"""Newton steps after which an increment counts as too long."""
STUCK = 6
"""Newton steps that have to halve the unbalanced share of the load, once there were EASY of them;
otherwise they change between the same corners, and the increment counts as too long."""
BALANCED = 1e-10
"""Unbalanced share of the load at which an increment has converged."""
ROUGH, ROUGHEST = 3e-3, 0.1
"""Of many blocks: the same by the share that the drag carries, and the same where Newton's method
changes between the same corners. Corner forces meet the contact law at any motion, and the next
increment balances what was left."""
MANY = 5.0
"""Of many blocks: how much longer increments are, until they clearly move."""
EASY = 12
"""Newton steps up to which the next increment may be longer."""
SLOWER, FASTER = 2.5, 0.9
"""Factors on the drag after a refused increment, and after an easy one. Chosen: with 0.8, steps
twice as long (0.64) moved the limit of one wedge by a degree; 0.4 moves those of two."""
STEP, LONG_STEP = 2e-4, 2e-3
"""Longest increment relative to a block's size, and the same where the structure clearly moves:
then the only question is whether it stops."""
FAR, CLEAR = 0.03, 0.3
"""Travel, and share of the load that the contacts do not carry, from which on it
clearly moves on. Wedges that slide and jam leave no more than 0.15 to the drag."""
STRETCH, STRETCHED, LONGEST = 1.5, 50.0, 1e-2
"""What a steady increment does to the longest one, how much longer than at first it may become, and
its length by a block's size."""
STEADY, SWERVE = 0.02, 0.1
"""Change of the motion from one increment to the next, by the motion: it goes on as before; it does
not, and an increment that was made longer is taken again in short ones."""
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
SLOW_STEPS = 1000
"""Increments after which what clearly moves, but too slowly to fall within the limit of steps, is
followed no farther: stones of 1/700 of the next one's size allow only tiny increments."""
FRAMES = 240
"""Positions kept of a path; of more, every other one is left out."""
FADING = 0.5
"""Share of the load that the contacts do not carry where a block leaves, by that at half of the
way, below which springs were too soft: it was about to come to rest. Measured on the Armadillo
vault: 0.29 at 21 degrees, where it rests on stiffer springs, 0.74 at 24 and 0.85 at 27."""
SQUEEZED, GROWN = 20.0, 1.5
"""Overlap of a corner by that under the mean load, and by its own at half of the travel, from which
on springs are too soft: a plug that tapers by 0.05 degrees presses with 570 times its weight in the
end, and the overlap grows with its travel. Forces on what slides or topples hardly change."""
DOUBLED = 1.8
"""Of many blocks: what presses on the block of such a corner, by the same at half of the travel. On
a plug it doubles. In a vault that moves thrust goes from one corner of a joint to another: 1.62
times at most on the Armadillo vault, tilted by 24 to 30 degrees."""


@dataclass(frozen=True, eq=False)
class Track:
    """The motion of the blocks, scaled.

    Attributes
    ----------
    ended : ``rests``, ``falls``, ``leaves``, ``lost`` (no increment could be solved) or ``stopped``
    frames
        Poses from first to last.
    placed, response
        Corners and their forces at the last pose.
    travel : (f,) displacement of each free block relative to its size
    share
        Of the load that the contacts do not carry at the end.
    met : (k,)
        Whether a corner has ever pressed.
    squeezed
        Whether forces far above the loads grew meanwhile: the springs were too soft.
    steps, iterations
    """

    ended: str
    frames: tuple[BlockPositions, ...]
    placed: Placed
    response: Response
    travel: Floats
    share: float
    met: Bools
    squeezed: bool
    steps: int
    iterations: int


class _Increment(NamedTuple):
    motion: Floats
    response: Response
    iterations: int


class ResponseAsked(NamedTuple):
    """Asks for the forces after a motion (f, 6), and for what is not balanced.

    Attributes
    ----------
    motion
    load : (f, 6)
    drag
    shift : (k, 3) local motion of the corners by moving supports, or None
    """

    motion: Floats
    load: Floats
    drag: float
    shift: Floats | None


class StepAsked(NamedTuple):
    """Asks for the Newton step against what is ``left`` (f, 6).

    With the tangents of ``response``; without one, with the last tangents again.
    """

    left: Floats
    response: Response | None
    drag: float


class Place(NamedTuple):
    """Asks for the pose after a motion (f, 6) of the free blocks, for its corners and travel."""

    pose: BlockPositions
    motion: Floats


Asked: TypeAlias = ResponseAsked | StepAsked | Place
Found = TypeVar("Found")
Steps: TypeAlias = Generator[Asked, Any, Found]
"""Work that asks for what takes time. So several runs can be computed side by side."""


class Follower:
    """One run of the steps.

    Parameters
    ----------
    bodies
    fall
        Displacement of a block relative to its size at which it falls.
    pace
        Length of the steps, 1 by default.
    left_at
        Displacement of a block relative to its size at which the path ends.
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
        left_at: float = np.inf,
        step_limit: int = 5000,
        stop: Callable[[], bool] | None = None,
        tell: Callable[[float], None] | None = None,
    ) -> None:
        self.bodies = bodies
        self.maps = maps_of(bodies)
        many = isinstance(self.maps, SparseMaps)
        self.rough, self.many = (ROUGH, MANY) if many else (0.0, 1.0)
        self.fall, self.pace, self.step_limit = fall, pace, step_limit
        self.left_at = left_at
        self.stop, self.tell = stop, tell
        count = len(bodies.centroid)
        self.pose = BlockPositions(bodies.centroid.copy(), np.tile(np.eye(3), (count, 1, 1)))
        self.friction = np.zeros((len(bodies.block_a), 2))
        self.frames = [self.pose]
        self.stride, self.since = 1, 0
        self.stretch = 1.0
        self.load_size = max(_length(bodies.load), np.finfo(float).tiny)
        self.smallest = float(bodies.size[bodies.free].min(initial=np.inf))
        self.travel = np.zeros(len(bodies.free))
        self.farthest = 0.0
        self.half_way: Floats | None = None
        self.half_share = 0.0
        self.first = max(float(bodies.normal.sum()), 1.0) / max(len(bodies.free), 1)
        self.drag = self.first
        self.guess: tuple[Floats, float] | None = None
        self.steps = self.iterations = self.beyond = 0
        self.left_steps = step_limit
        self.solve: Callable[[Floats], Floats] | None = None
        self.placed = place_corners(bodies, self.pose)
        self.maps.at(self.pose, self.placed)
        nothing = np.zeros((len(bodies.block_a), 3))
        self.response = respond(bodies, self.placed.gap, self.friction, nothing)
        self.met = self.response.pressed
        self.share = 1.0

    def run(self, supports: Floats | None = None, earlier: Sequence[Floats] = ()) -> Track:
        """Until they rest or fall; then, where they rest, with supports that move by (n, 6).

        ``earlier`` are loads (f, 6) under which they rest, more or less, before.
        """
        return self.alone(self.whole_run(supports, earlier))

    def alone(self, work: Steps[Found], given: Any = None) -> Found:
        """Do work with what it asks for; ``given`` is what it asked for last."""
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            while True:
                try:
                    asked = work.send(given)
                except StopIteration as end:
                    found: Found = end.value
                    return found
                given = self.evaluate(asked)

    def evaluate(self, asked: Asked) -> Any:
        """What work asks for.

        Forces, what is left and its share of the load; a step, None if the tangent is singular;
        a pose, its corners and the travel (f,).
        """
        bodies, maps = self.bodies, self.maps
        if isinstance(asked, ResponseAsked):
            moved = maps.moved(asked.motion)
            if asked.shift is not None:
                moved = moved + asked.shift
            response = respond(bodies, self.placed.gap, self.friction, moved)
            drag = asked.drag * bodies.mass[:, None]
            left = maps.wrench(response.force) + asked.load - drag * asked.motion
            return response, left, _length(left) / self.load_size
        if isinstance(asked, StepAsked):
            try:
                if asked.response is not None:
                    weight = np.repeat(asked.drag * bodies.mass[:, None], 6, axis=1)
                    self.solve = maps.factorise(tangents(bodies, asked.response), weight)
            except SolverError:
                return None
            return None if self.solve is None else self.solve(asked.left)
        step = asked.motion.copy()
        step[:, 3:] /= bodies.radius[bodies.free, None]
        pose = asked.pose.moved(bodies.free, step)
        placed = place_corners(bodies, pose)
        maps.at(pose, placed)
        return pose, placed, self._travel(pose)

    def whole_run(
        self, supports: Floats | None = None, earlier: Sequence[Floats] = ()
    ) -> Steps[Track]:
        """As :meth:`run`."""
        # blocks that follow their supports go far without falling
        self.left_steps = LEFT_STEPS if supports is None else self.step_limit
        ended = yield from self._loaded(earlier)
        if ended == "rests":
            ended = yield from self._to_rest()
        if supports is not None and ended == "rests":
            ended = yield from self._supports(supports)
        return self._track(ended)

    def _loaded(self, earlier: Sequence[Floats]) -> Steps[str]:
        """Rest under one load after another, and go on with the last one."""
        whole = self.bodies
        for load in earlier:
            self.bodies = replace(whole, load=load)
            ended = yield from self._to_rest(roughly=True)
            self.drag, self.guess = self.first, None
            if ended != "rests":
                return ended
        self.bodies = whole
        return "rests"

    def _to_rest(self, *, roughly: bool = False) -> Steps[str]:
        bodies = self.bodies
        refused = 0
        while True:
            if self._late():
                return "stopped"
            guess = None
            if self.guess is not None and refused < 2:
                guess = self.guess[0] * (self.guess[1] / self.drag)
            found = yield from self._increment(guess)
            longest = np.inf if found is None else float(np.abs(found.motion).max(initial=0.0))
            if found is None or longest > self._longest():
                refused += 1
                self.drag *= SLOWER
                self.stretch = 1.0
                if self.drag > MOST_DRAG * self.first:
                    return "lost"
                continue
            swerve = 1.0
            if guess is not None and longest > 0.0:
                swerve = float(np.abs(found.motion - guess).max()) / longest
            if self.stretch > 1.0 and swerve > SWERVE:
                # an event before the end: it is passed by short increments
                self.drag *= self.stretch
                self.stretch = 1.0
                continue
            refused = 0
            self.guess = found.motion, self.drag
            self.share = self._carried(found.motion)
            yield from self._accept(found)
            rests = self.share < AT_REST and longest < STILL * bodies.overlap
            if rests or (roughly and self.share < ROUGHLY):
                return "rests"
            if self.farthest > self.fall:
                return "falls"
            if self.farthest > self.left_at:
                return "leaves"
            longer = STRETCH if swerve < STEADY else 1.0 / STRETCH
            self.stretch = min(max(longer * self.stretch, 1.0), STRETCHED)
            if found.iterations < EASY:
                # nearly at rest: small steps are not needed
                quick = longest < bodies.overlap and self.share < 1e-3
                least = longest / (0.9 * self._longest())
                self.drag *= 0.1 if quick else max(FASTER ** (self.pace * self.many), least)

    def _supports(self, motion: Floats) -> Steps[str]:
        """Move the supports in small steps, with approximate rest after each."""
        reach = np.linalg.norm(motion[:, :3], axis=1) + np.linalg.norm(motion[:, 3:], axis=1)
        parts = max(int(np.ceil(float(reach.max(initial=0.0)) / (SUPPORT_STEP * self.pace))), 1)
        done, part = 0.0, 1.0 / parts
        while done < 1.0 - 1e-12:
            if self._late():
                return "stopped"
            part = min(part, 1.0 - done)
            self.drag, self.guess = 1e-3 * self.first, None
            found = yield from self._increment(None, part * motion)
            if found is None:
                part *= 0.5
                if part * parts < 1e-6:
                    return "lost"
                continue
            yield from self._accept(found, part * motion)
            done += part
            part = min(2.0 * part, 1.0 / parts)
            ended = yield from self._to_rest(roughly=done < 1.0 - 1e-12)
            if ended != "rests":
                return ended
        return "rests"

    def _increment(
        self, guess: Floats | None, moving: Floats | None = None
    ) -> Steps[_Increment | None]:
        """The motion (f, 6) of one increment, by Newton's method; None if it is too long."""
        bodies, drag = self.bodies, self.drag
        shift = None if moving is None else imposed(bodies, self.pose, self.placed, moving)
        motion = np.zeros((len(bodies.free), 6)) if guess is None else guess
        response, left, size = yield ResponseAsked(motion, bodies.load, drag, shift)
        recent = [size]
        begun = False
        patient = STUCK if self.rough else EASY
        best = np.inf, motion, response
        for number in range(NEWTON):
            if size < max(BALANCED, self.rough * self._carried(motion)):
                return _Increment(motion, response, number)
            if number and size < best[0]:
                best = size, motion, response
            if number > patient and min(recent[-STUCK:]) > 0.5 * min(recent[:-STUCK]):
                if self.rough and best[0] < ROUGHEST * self._carried(best[1]):
                    return _Increment(best[1], best[2], EASY)
                return None
            self.iterations += 1
            # convergence is quadratic in the end: the last factors then do for one step more
            renew = not begun or size**2 > BALANCED * recent[-2]
            begun = True
            step = yield StepAsked(left, response if renew else None, drag)
            if step is None:
                return None
            length, allowed = 1.0, max(recent[-4:])
            while True:
                trial = motion + length * step
                response, left, size = yield ResponseAsked(trial, bodies.load, drag, shift)
                if size < (1.0 - 1e-3 * length) * allowed or length < 0.03:
                    break
                if self.rough and number < STUCK and size < 1.0:
                    break
                length *= 0.5
            if not np.isfinite(size):
                return None
            motion = trial
            recent.append(size)
        return None

    def _accept(self, found: _Increment, moving: Floats | None = None) -> Steps[None]:
        bodies = self.bodies
        if moving is not None:
            fixed = np.flatnonzero(bodies.slot < 0)
            part = moving[fixed].copy()
            part[:, 3:] /= bodies.radius[fixed, None]
            self.pose = self.pose.moved(fixed, part)
        self.friction = found.response.force[:, 1:]
        self.response = found.response
        self.met = self.met | found.response.pressed
        self.pose, self.placed, self.travel = yield Place(self.pose, found.motion)
        self.farthest = float(self.travel.max(initial=0.0))
        if self.half_way is None and self.farthest >= 0.5 * min(self.fall, self.left_at):
            self.half_way, self.half_share = self.placed.gap, self.share
        self.steps += 1
        self.beyond += self.farthest > FAR
        self.since += 1
        if self.since >= self.stride:
            self.frames.append(self.pose)
            self.since = 0
            if len(self.frames) > FRAMES:
                self.frames = self.frames[::2]
                self.stride *= 2
        if self.tell is not None:
            self.tell(self.farthest)

    def _travel(self, pose: BlockPositions) -> Floats:
        """Displacement (f,) of each free block relative to its size."""
        bodies, free = self.bodies, self.bodies.free
        gone = pose.place[free] - bodies.centroid[free]
        return travelled(gone, pose.turn[free], bodies.radius[free], bodies.size[free])

    def _carried(self, motion: Floats) -> float:
        """Share of the load that the drag carries while blocks move by (f, 6)."""
        return self.drag * _length(self.bodies.mass[:, None] * motion) / self.load_size

    def _longest(self) -> float:
        """Of an increment, by the smallest block: short where it matters how blocks slide."""
        clear = self.share > CLEAR or self.farthest > FAR
        stretched = min(self.stretch * (LONG_STEP if clear else self.many * STEP), LONGEST)
        return self.pace * self.smallest * stretched

    def _squeezed(self) -> bool:
        bodies, gap = self.bodies, self.placed.gap
        before = gap if self.half_way is None else GROWN * self.half_way
        grown = (gap < -SQUEEZED * bodies.overlap) & (gap <= before)
        if self.rough and self.half_way is not None and grown.any():
            more = self._pressing(gap) >= DOUBLED * self._pressing(self.half_way)
            more[bodies.slot < 0] = False
            grown &= more[bodies.block_a] | more[bodies.block_b]
        return bool(grown.any())

    def _pressing(self, gap: Floats) -> Floats:
        """Sum (n,) of the normal forces on each block."""
        bodies = self.bodies
        force = bodies.normal * np.maximum(0.0, -gap)
        both = np.concatenate([bodies.block_a, bodies.block_b])
        return np.asarray(np.bincount(both, np.tile(force, 2), minlength=len(bodies.centroid)))

    def _late(self) -> bool:
        if self.steps >= self.step_limit or self.beyond >= self.left_steps or self._creeps():
            return True
        return self.stop is not None and self.stop()

    def _creeps(self) -> bool:
        """Whether blocks on supports at rest move on, but too slowly to be followed to a fall."""
        if self.steps < SLOW_STEPS or self.share < CLEAR or self.left_steps == self.step_limit:
            return False
        return self.farthest * self.step_limit < self.fall * self.steps

    def _track(self, ended: str) -> Track:
        frames = self.frames if self.frames[-1] is self.pose else [*self.frames, self.pose]
        return Track(
            ended,
            tuple(frames),
            self.placed,
            self.response,
            self.travel,
            self.share,
            self.met,
            self._squeezed() or (ended == "leaves" and self.share < FADING * self.half_share),
            self.steps,
            self.iterations,
        )


def travelled(gone: Floats, turn: Floats, radius: Floats, size: Floats) -> Floats:
    """Displacement (f,) by the size, from translations (f, 3) and rotations (f, 3, 3) by radius."""
    way = np.sqrt((gone * gone).sum(axis=1))
    trace = turn[:, 0, 0] + turn[:, 1, 1] + turn[:, 2, 2]
    turned = np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0))
    travel: Floats = (way + turned * radius) / size
    return travel


def _length(values: Floats) -> float:
    """Root of the sum of squares; a quarter of the time of the general norm."""
    flat = values.ravel()
    return float(np.sqrt(flat @ flat))


__all__ = [
    "Asked",
    "Follower",
    "Place",
    "ResponseAsked",
    "StepAsked",
    "Steps",
    "Track",
    "travelled",
]
