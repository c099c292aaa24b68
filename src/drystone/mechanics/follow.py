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

import enum
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.mechanics.bodies import BlockPositions, Bodies, Placed
from drystone.mechanics.increments import EASY, FEW, Increment, Increments, travelled
from drystone.mechanics.law import ContactResponse, respond
from drystone.mechanics.soft_springs import SoftSprings
from drystone.solvers.threads import one_blas_thread

MANY = 5.0
"""Of many blocks: how much longer increments are, until they clearly move."""
SLOWER, FASTER, QUICK = 2.5, 0.9, 0.1
"""Factors on the drag after a refused increment, and after an easy one. Chosen: with 0.8, steps
twice as long (0.64) moved the limit of one wedge by a degree; 0.4 moves those of two. The last is
that nearly at rest, while no block moves by more than the overlap: else corners let go together,
and a hood that rests up to 41.6 degrees falls at 41.5 too. It is the drag of few blocks at the
beginning as well, by that with which no block moves by more than the overlap."""
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
NEAR = 1e-3
"""Drag by the initial one where the blocks are near a rest state."""
SUPPORT_STEP = 1e-3
"""Largest step of a motion of supports, relative to the mean size of a block."""
DRAGGED = 1e-2
"""Share of the load that the drag may carry while blocks follow a support. A larger drag would let
joints slide that friction holds. An arch moves alike, to 0.02 %, for 0.1 to 0.0001."""
FOLLOWS = 10.0
"""Motion of a block by that of the supports, above which it no longer follows them: it falls. It is
taken in shorter steps, with a larger drag."""
MOST_DRAG = 1e12
"""Largest drag relative to the initial one; beyond it no increment can be solved."""
LEFT_STEPS = 250
"""Increments after which what clearly moves on is followed no farther: it does not stand, and a
fall without obstacles takes 135."""
SLOW_STEPS = 1000
"""Increments after which what clearly moves, but too slowly to fall within the limit of steps, is
followed no farther: stones of 1/700 of the next one's size allow only tiny increments."""
NEWTON_EACH = 4
"""Mean number of Newton steps, over as many increments as are allowed, after which the blocks are
followed no farther. Runs of more than 300 increments take up to 3.5; a block of 1e-8 N on one of
1e12 N takes 6.5."""
FRAMES = 240
"""Positions kept of a path; of more, every other one is left out."""


class Ended(enum.Enum):
    """How a run ends."""

    RESTS = "rests"
    FALLS = "falls"
    LEAVES = "leaves"
    """It moved as far as it was to be followed."""
    SOFT = "soft"
    """Forces far above the loads grew, so stiffer springs are to be tried."""
    LOST = "lost"
    """No increment could be solved."""
    STOPPED = "stopped"
    SPENT = "spent"
    """The load that grows is needed no longer."""
    HELD = "held"
    """Nothing gives way to what is driven."""
    REACHED = "reached"
    """What is driven went as far as it was to go."""


Course: TypeAlias = Sequence[tuple[float, Floats]]
"""Displacement of a block relative to its size, and what the drag carries (f, 6), after each
increment of few blocks since their motion last changed."""


@dataclass(frozen=True)
class Bounds:
    """How far a run goes.

    Attributes
    ----------
    fall
        Displacement of a block relative to its size at which it falls.
    pace
        Length of the steps, 1 by default.
    step_limit
    left_at
        Displacement of a block relative to its size at which the path ends.
    """

    fall: float
    pace: float = 1.0
    step_limit: int = 5000
    left_at: float = np.inf


@dataclass(frozen=True, eq=False)
class Track:
    """The motion of the blocks, scaled.

    Attributes
    ----------
    ended
    frames
        Poses from first to last.
    placed, response
        Corners and their forces at the last pose.
    travel : (f,) displacement of each free block relative to its size
    share
        Of the load that the contacts do not carry at the end.
    met : (k,)
        Whether a corner has ever pressed.
    steps, iterations
    """

    ended: Ended
    frames: tuple[BlockPositions, ...]
    placed: Placed
    response: ContactResponse
    travel: Floats
    share: float
    met: Bools
    steps: int
    iterations: int


class Follower(Increments):
    """One run of the steps.

    Parameters
    ----------
    bodies
    bounds
    stop
        Called before every increment.
    tell
        Called with the largest displacement after every increment.
    known
        The course of a run that fell, of the same blocks with another shear stiffness.
    """

    def __init__(
        self,
        bodies: Bodies,
        bounds: Bounds,
        *,
        stop: Callable[[], bool] | None = None,
        tell: Callable[[float], None] | None = None,
        known: Course = (),
    ) -> None:
        super().__init__(bodies)
        self.drag, self.many = (self.first, MANY) if self.rough else (QUICK * self.first, 1.0)
        self.bounds, self.step_limit = bounds, bounds.step_limit
        self.stop, self.tell, self.known = stop, tell, known
        self.course: list[tuple[float, Floats]] = []
        self.frames = [self.pose]
        self.stride, self.since = 1, 0
        self.stretch = 1.0
        self.smallest = float(bodies.size[bodies.free].min(initial=np.inf))
        self.travel = np.zeros(len(bodies.free))
        self.followed = self.travel
        self.farthest = self.alone_by = 0.0
        self.soft = self._springs()
        self.guess: tuple[Floats, float] | None = None
        self.steps = self.beyond = 0
        self.left_steps = self.step_limit
        self.response = respond(bodies.springs, self.placed.gap, self.friction)
        self.met = self.response.pressed
        self.share = 1.0

    def begin_at(self, pose: BlockPositions, friction: Floats) -> None:
        """Begin near a rest state, with its friction forces (k, 2).

        It is not asked then whether the springs are too soft.
        """
        self.friction = friction
        self.place(pose)
        self.frames.append(pose)
        self.drag = NEAR * self.first
        self.soft.asked = True

    @one_blas_thread()
    def run(self, supports: Floats | None = None, earlier: Sequence[Bodies] = ()) -> Track:
        """Until they rest or fall; then, where they rest, with supports that move by (n, 6).

        ``earlier`` are the bodies under loads that they rest under, more or less, before.
        """
        # blocks that follow their supports go far without falling
        self.left_steps = LEFT_STEPS if supports is None else self.step_limit
        ended = self._loaded(earlier)
        if ended is Ended.RESTS:
            ended = self.to_rest()
        if supports is not None and ended is Ended.RESTS:
            ended = self._supports(supports)
        return self._track(ended)

    def _loaded(self, earlier: Sequence[Bodies]) -> Ended:
        """Rest under one load after another, and go on with the last one."""
        whole = self.bodies
        for self.bodies in earlier:
            ended = self.to_rest(roughly=True)
            self.drag, self.guess = self.first, None
            if ended is not Ended.RESTS:
                return ended
        self.bodies = whole
        return Ended.RESTS

    def to_rest(self, *, roughly: bool = False) -> Ended:
        """Increments until the blocks rest or fall."""
        bodies = self.bodies
        refused, quick = 0, False
        while True:
            if self._late():
                return Ended.STOPPED
            guess = None
            if self.guess is not None and refused < 2:
                guess = self.guess[0] * (self.guess[1] / self.drag)
            found, steps = self.increment(guess)
            longest = np.inf if found is None else float(np.abs(found.motion).max(initial=0.0))
            if found is None or longest > (bodies.overlap if quick else self._longest()):
                refused += 1
                self.drag *= FASTER / QUICK if quick else SLOWER
                quick = False
                self.stretch = 1.0
                if self.drag > MOST_DRAG * self.first:
                    return Ended.LOST
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
            self.share = self.carried(found.motion)
            self.accept(found)
            rests = self.share < AT_REST and longest < STILL * bodies.overlap
            if rests or (roughly and self.share < ROUGHLY):
                return Ended.RESTS
            if self.soft.told(self.alone_by, self.placed.gap):
                return Ended.SOFT
            if self.alone_by > self.bounds.fall or self._falls_alike(found.motion, swerve):
                return Ended.FALLS
            if self.farthest > self.bounds.left_at:
                return Ended.LEAVES
            longer = STRETCH if swerve < STEADY else 1.0 / STRETCH
            self.stretch = min(max(longer * self.stretch, 1.0), STRETCHED)
            # nearly at rest: small steps are not needed, unless a longer one comes of it
            quick = steps < EASY and longest < bodies.overlap and self.share < 1e-3
            if steps < EASY:
                least = longest / (0.9 * self._longest())
                ease = QUICK if quick else max(FASTER ** (self.bounds.pace * self.many), least)
                # what drifts without resistance would bring it to zero
                self.drag = max(self.drag * ease, float(np.finfo(float).tiny))

    def _falls_alike(self, motion: Floats, swerve: float) -> bool:
        """Whether few blocks go on steadily, as they do here on the course that is known."""
        if len(self.bodies.free) > FEW:
            return False
        if swerve > STEADY:
            self.course = []
        left = self.drag * motion
        self.course.append((self.farthest, left))
        at = bisect_left(self.known, self.farthest, key=lambda one: one[0])
        if self.stretch < STRETCHED or not 0 < at < len(self.known):
            return False
        there = self.known[at][1]
        return bool(np.abs(left - there).max() < STEADY * np.abs(there).max())

    def _supports(self, motion: Floats) -> Ended:
        """Move the supports in small steps, with approximate rest after each."""
        each = np.linalg.norm(motion[:, :3], axis=1) + np.linalg.norm(motion[:, 3:], axis=1)
        reach = float(each.max(initial=0.0))
        parts = max(int(np.ceil(reach / (SUPPORT_STEP * self.bounds.pace))), 1)
        done, part = 0.0, 1.0 / parts
        before: Floats | None = None
        while done < 1.0 - 1e-12:
            if self._late():
                return Ended.STOPPED
            part = min(part, 1.0 - done)
            guess = None if before is None else part * before
            found = self._follow(part * motion, part * reach, guess)
            if found is None:
                part *= 0.5
                if part * parts < 1e-6:
                    return Ended.LOST
                continue
            before = found.motion / part
            self.accept(found, part * motion)
            self.followed, self.soft = self.travel, self._springs()
            done += part
            part = min(2.0 * part, 1.0 / parts)
            ended = self.to_rest(roughly=done < 1.0 - 1e-12)
            if ended is not Ended.RESTS:
                return ended
        return Ended.RESTS

    def _follow(self, motion: Floats, reach: float, guess: Floats | None) -> Increment | None:
        """One increment with supports that move by (n, 6), at most by ``reach``; None: too long."""
        self.drag, self.guess = 1.0, None
        along = np.tile(reach * np.eye(1, 6), (len(self.bodies.free), 1))
        share, falling = self.carried(along), NEAR * self.first
        self.drag = min(falling, DRAGGED / share) if share > 0.0 else falling
        found = None
        if guess is not None:
            found, _ = self.increment(guess, motion)
        if found is None:
            found, _ = self.increment(None, motion)
        if found is None or self.drag == falling:
            return found
        far = float(np.abs(found.motion).max(initial=0.0))
        return found if far <= max(self._longest(), FOLLOWS * reach) else None

    def accept(self, found: Increment, moving: Floats | None = None) -> None:
        """Go on to where an increment leads, with supports that move by (n, 6)."""
        self.response = found.response
        self.met = self.met | found.response.pressed
        self.move(found, moving)
        self.travel = self.way()
        self.farthest = float(self.travel.max(initial=0.0))
        self.alone_by = float((self.travel - self.followed).max(initial=0.0))
        self.soft.pass_by(self.alone_by, self.placed.gap, self.share)
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

    def way(self) -> Floats:
        """Displacement (f,) of each free block relative to its size."""
        bodies, free = self.bodies, self.bodies.free
        gone = self.pose.place[free] - bodies.centroid[free]
        return travelled(gone, self.pose.turn[free], bodies.radius[free], bodies.size[free])

    def _springs(self) -> SoftSprings:
        """Asked of a motion that begins here."""
        return SoftSprings(
            self.bodies, self.rough > 0.0, min(self.bounds.fall, self.bounds.left_at)
        )

    def _longest(self) -> float:
        """Of an increment, by the smallest block: short where it matters how blocks slide."""
        clear = self.share > CLEAR or self.farthest > FAR
        stretched = min(self.stretch * (LONG_STEP if clear else self.many * STEP), LONGEST)
        return self.bounds.pace * self.smallest * stretched

    def _late(self) -> bool:
        if self.steps >= self.step_limit or self.iterations >= NEWTON_EACH * self.step_limit:
            return True
        if self.beyond >= self.left_steps or self._creeps():
            return True
        return self.stop is not None and self.stop()

    def _creeps(self) -> bool:
        """Whether blocks on supports at rest move on, but too slowly to be followed to a fall."""
        if self.steps < SLOW_STEPS or self.share < CLEAR or self.left_steps == self.step_limit:
            return False
        return self.farthest * self.step_limit < self.bounds.fall * self.steps

    def _track(self, ended: Ended) -> Track:
        frames = self.frames if self.frames[-1] is self.pose else [*self.frames, self.pose]
        return Track(
            ended,
            tuple(frames),
            self.placed,
            self.response,
            self.travel,
            self.share,
            self.met,
            self.steps,
            self.iterations,
        )
