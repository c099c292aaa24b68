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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.settlement.bodies import Bodies
from drystone.settlement.springs import (
    BlockPositions,
    Placed,
    Response,
    place_corners,
    respond,
)
from drystone.settlement.steps.increments import (
    EASY,
    Increment,
    Increments,
    Place,
    Steps,
)
from drystone.settlement.steps.soft_springs import SoftSprings

MANY = 5.0
"""Of many blocks: how much longer increments are, until they clearly move."""
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


@dataclass(frozen=True, eq=False)
class Track:
    """The motion of the blocks, scaled.

    Attributes
    ----------
    ended : ``rests``, ``falls``, ``leaves``, ``soft``, ``lost`` or ``stopped``
        ``soft``: forces far above the loads grew, so stiffer springs are to be tried. ``lost``: no
        increment could be solved.
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

    ended: str
    frames: tuple[BlockPositions, ...]
    placed: Placed
    response: Response
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
        super().__init__(bodies)
        self.many = MANY if self.rough else 1.0
        self.fall, self.pace, self.step_limit = fall, pace, step_limit
        self.left_at = left_at
        self.stop, self.tell = stop, tell
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
        self.left_steps = step_limit
        nothing = np.zeros((len(bodies.block_a), 3))
        self.response = respond(bodies, self.placed.gap, self.friction, nothing)
        self.met = self.response.pressed
        self.share = 1.0

    def begin_at(self, pose: BlockPositions, friction: Floats) -> None:
        """Begin near a rest state, with its friction forces (k, 2).

        It is not asked then whether the springs are too soft.
        """
        self.pose, self.friction = pose, friction
        self.placed = place_corners(self.bodies, pose)
        self.maps.at(pose, self.placed)
        self.frames.append(pose)
        self.drag = NEAR * self.first
        self.soft.asked = True

    def run(self, supports: Floats | None = None, earlier: Sequence[Floats] = ()) -> Track:
        """Until they rest or fall; then, where they rest, with supports that move by (n, 6).

        ``earlier`` are loads (f, 6) under which they rest, more or less, before.
        """
        return self.alone(self.whole_run(supports, earlier))

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
            if self.soft.told(self.alone_by, self.placed.gap):
                return "soft"
            if self.alone_by > self.fall:
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
        each = np.linalg.norm(motion[:, :3], axis=1) + np.linalg.norm(motion[:, 3:], axis=1)
        reach = float(each.max(initial=0.0))
        parts = max(int(np.ceil(reach / (SUPPORT_STEP * self.pace))), 1)
        done, part = 0.0, 1.0 / parts
        before: Floats | None = None
        while done < 1.0 - 1e-12:
            if self._late():
                return "stopped"
            part = min(part, 1.0 - done)
            guess = None if before is None else part * before
            found = yield from self._follow(part * motion, part * reach, guess)
            if found is None:
                part *= 0.5
                if part * parts < 1e-6:
                    return "lost"
                continue
            before = found.motion / part
            yield from self._accept(found, part * motion)
            self.followed, self.soft = self.travel, self._springs()
            done += part
            part = min(2.0 * part, 1.0 / parts)
            ended = yield from self._to_rest(roughly=done < 1.0 - 1e-12)
            if ended != "rests":
                return ended
        return "rests"

    def _follow(
        self, motion: Floats, reach: float, guess: Floats | None
    ) -> Steps[Increment | None]:
        """One increment with supports that move by (n, 6), at most by ``reach``; None: too long."""
        self.drag, self.guess = 1.0, None
        share, falling = self._carried(np.array([[reach]])), NEAR * self.first
        self.drag = min(falling, DRAGGED / share) if share > 0.0 else falling
        found = None
        if guess is not None:
            found = yield from self._increment(guess, motion)
        if found is None:
            found = yield from self._increment(None, motion)
        if found is None or self.drag == falling:
            return found
        far = float(np.abs(found.motion).max(initial=0.0))
        return found if far <= max(self._longest(), FOLLOWS * reach) else None

    def _accept(self, found: Increment, moving: Floats | None = None) -> Steps[None]:
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

    def _springs(self) -> SoftSprings:
        """Asked of a motion that begins here."""
        return SoftSprings(self.bodies, self.rough > 0.0, min(self.fall, self.left_at))

    def _longest(self) -> float:
        """Of an increment, by the smallest block: short where it matters how blocks slide."""
        clear = self.share > CLEAR or self.farthest > FAR
        stretched = min(self.stretch * (LONG_STEP if clear else self.many * STEP), LONGEST)
        return self.pace * self.smallest * stretched

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
            self.steps,
            self.iterations,
        )
