"""Blocks that are driven by finite amounts: a load that grows, supports that move, less friction.

The driven quantity grows by small increments. A load that is to be followed beyond its peak is not
given but found: the displacement d of an increment is given, and the load factor s is one more
unknown:

    A f(q) + p + s g - c M q = 0,    w . q = d,    w = g / |g|

g is the load at the factor one. d and s belong together as displacement and force: the area below
the curve of s |g| against d is work, and d grows along every mechanism that gravity resists. The
drag c M q carries at most a millionth of the load. Source: Batoz and Dhatt 1979 (displacement
control). The springs and the finite rotations are those of :mod:`drystone.mechanics.follow`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.mechanics.bodies import BlockPositions, Bodies, Placed
from drystone.mechanics.follow import Bounds, Ended, Follower
from drystone.mechanics.increments import EASY, Increment, longest_way, travelled
from drystone.mechanics.law import ContactResponse
from drystone.solvers.threads import one_blas_thread

LONGEST = 1e-3
"""Motion of a block in one increment by its size. A block that rocks by 26 degrees in such steps
keeps its load within 0.3 % of its peak of the closed form."""
PASSED = 1e-2
"""Motion of a support in one increment by the mean size of a block, also where no block follows:
joints are placed anew after an increment, and a support would leave a block without a fall."""
CARRIED = 1e-6
"""Share of the mean load of a block that the drag carries in the longest increment."""
HELD_BACK, LAST = 1e-3, 1e-3
"""The same where supports move and no increment is found. Below that share of the first increment
it is for this increment, not for the longest one. Measured on walls of 14 to 60 blocks on a foot
that sinks or turns: five of twelve were lost before, none now. At 1e-2 forces differ by 0.6 % where
blocks are numbered otherwise, and one of ten walls took another path."""
CALM = 5
"""Increments after a refused one in which their length does not grow."""
FIRST = 1e-2
"""First increment of a displacement that a load causes, by the overlap of the corners."""
SHORTEST = 1e-6
"""By the first increment, below which the blocks are let go while what drives them is held."""
HOLDS = 50
"""Times in a row that blocks are let go without an increment of the usual length in between."""
STALLED = 5
"""Of these, times in a row without any increment at all, after which there is no further position.
Chosen: measured on a vault of 97 blocks, the fifth time and the fiftieth end alike."""
HELD = 1e3
"""Force at a corner by the mean load of a block from which on nothing gives way: what is pushed
against a wall would otherwise be followed into its springs."""
AT_ONCE = (1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-7)
"""Drag in turn, by the first one, where the blocks come to rest in one increment; the last one
carries less than a thousandth of the load. Chosen: a vault of 97 blocks rests in 0.05 s, one of 399
in 0.5 s."""
KEPT = 120
"""Moments that are kept; of more, every other one is left out."""


class DrivenState(NamedTuple):
    """The blocks after an increment.

    Attributes
    ----------
    displacement, load
        As the curve has them.
    pose, placed, response
    """

    displacement: float
    load: float
    pose: BlockPositions
    placed: Placed
    response: ContactResponse


Advance: TypeAlias = tuple[Increment | None, int, Floats | None]
"""An increment, its Newton steps, and the motion (n, 6) of the supports."""


class Driver(Follower):
    """One run in which something is driven.

    Parameters
    ----------
    bodies
    bounds
        ``fall`` is the travel of a block, while what drives is held, at which it is said to fall.
    stop
        Asked before every increment.
    """

    def __init__(
        self, bodies: Bodies, bounds: Bounds, *, stop: Callable[[], bool] | None = None
    ) -> None:
        super().__init__(bodies, bounds, stop=stop)
        self.rough, self.many = 0.0, 1.0
        self.soft = self._springs()
        self.base = self.pose
        self.reached = 0.0
        self.measure: Callable[[], tuple[float, float]] = lambda: (self.reached, self.factor)
        self.way_done: Callable[[], float] = lambda: self.reached
        self.curve: list[tuple[float, float]] = []
        self.moments: dict[int, DrivenState] = {}
        self.most: tuple[int, DrivenState] | None = None
        self.last: tuple[int, DrivenState] | None = None
        self.every = 1
        self.whole = bodies.friction

    @one_blas_thread()
    def rest(self) -> Ended:
        """Let the blocks come to rest under the load that does not grow."""
        ended = self.to_rest()
        self.guess = None
        return ended

    @one_blas_thread()
    def rest_at_once(self) -> bool:
        """Let the blocks come to rest in one long increment; whether they do."""
        found: Increment | None = None
        for share in AT_ONCE:
            self.drag = share * self.first
            found, _ = self.increment(None if found is None else found.motion)
            if found is None:
                return False
        if found is not None:
            self.accept(found)
        return True

    def again(self) -> Driver:
        """Another run that begins where this one is; only one of the two can go on."""
        other = copy.copy(self)
        other.frames = [other.pose]
        other.place(other.pose)  # both share the maps
        other.guess, other.drag = None, AT_ONCE[-1] * other.first
        return other

    @one_blas_thread()
    def shift_at_once(self, motion: Floats, late: Callable[[], bool]) -> bool | None:
        """Move the supports by (n, 6) in one long increment; whether the blocks rest after it.

        The drag falls as in :meth:`rest_at_once`. Where no increment is found with less of it, the
        blocks go where the last one leads, and on from there until it is late. None where not even
        the first increment is found.
        """
        found: Increment | None = None
        guess: Floats | None = None
        moving: Floats | None = motion
        at = 0
        while at < len(AT_ONCE) and (found is None or not late()):
            self.drag = AT_ONCE[at] * self.first
            further, _ = self.increment(guess, moving)
            if further is not None:
                found, guess, at = further, further.motion, at + 1
            elif found is None or guess is None:
                break
            else:
                self.accept(found, moving)
                guess, moving, at = None, None, at - 1
        if found is not None and guess is not None:
            self.accept(found, moving)
        return None if found is None else at == len(AT_ONCE)

    def now(self) -> DrivenState:
        """Where the blocks are."""
        return DrivenState(*self.measure(), self.pose, self.placed, self.response)

    def grow(
        self, load: Floats, arms: Floats, reach: float, tell: Callable[[float], None]
    ) -> Ended:
        """A load (f, 6) grows until a block has moved by ``reach`` or no more load is needed.

        ``arms`` are those of :func:`turned_load`.
        """
        self.grown = load, arms

        def advance(step: float) -> Advance:
            return (*self._next(step, distance=step), None)

        self.way_done, begin = self._gone, self.pose.place
        sways = min(self._gone(), self._limit())

        def spent() -> bool:
            # a vault that settled on four hinges sways freely until one of them closes, by less
            # than it settled; what settled by more than an increment has slid
            return self.factor <= 0.0 and float(lengths(self.pose.place - begin).max()) > sways

        return self._drive(advance, FIRST * self.bodies.overlap, reach, tell, spent)

    def shift(self, motion: Floats, reach: float, tell: Callable[[float], None]) -> Ended:
        """Supports move by a motion (n, 6), from the share 0 to the share 1 of it.

        ``reach`` is the largest motion of their corners.
        """
        self.measure = lambda: (self.reached, self._on_supports(motion, reach))
        far = longest_way(motion)
        first = min(self._limit() / max(far, 1e-300), 1.0)

        def advance(step: float) -> Advance:
            part = step * motion
            (found, steps), limit = self._next(step, part), self._limit()
            ways = (limit, step * far) if step < LAST * first else (limit,)
            for way in ways:
                if found is None:
                    self.drag = HELD_BACK / way
                    found, steps = self._next(step, part)
            return found, steps, part

        most = PASSED / max(far, 1e-300)
        return self._drive(advance, first, 1.0, tell, lambda: False, most)

    def slacken(self, tell: Callable[[float], None]) -> Ended:
        """All friction coefficients fall from the share 1 to the share 0."""
        self.measure = lambda: (self._gone(), 1.0 - self.reached)

        def advance(step: float) -> Advance:
            left = max(1.0 - self.reached - step, 0.0)
            self.bodies = replace(self.bodies, friction=left * self.whole)
            return (*self.increment(), None)

        return self._drive(advance, 1e-2, 1.0, tell, lambda: False)

    def _next(
        self, step: float, moving: Floats | None = None, *, distance: float = 0.0
    ) -> tuple[Increment | None, int]:
        """An increment that begins where the last one would lead."""
        guess = None if self.guess is None else self.guess[0] * (step / self.guess[1])
        found, steps = self.increment(guess, moving, distance=distance)
        if found is not None:
            self.guess = found.motion, step
        return found, steps

    @one_blas_thread()
    def _drive(
        self,
        advance: Callable[[float], Advance],
        first: float,
        reach: float,
        tell: Callable[[float], None],
        done: Callable[[], bool],
        most: float = np.inf,
    ) -> Ended:
        """Increments of at most ``most`` until ``reach``, or done, or not to be followed."""
        step, held, calm = first, 0, 0
        stalled, at = 0, -1.0
        done_so_far, rate = self.way_done(), 1.0
        self.note()
        while done_so_far < reach * (1.0 - 1e-9):
            if self._late():
                return Ended.STOPPED
            limit = self._limit()
            self.drag = CARRIED / limit
            step = min(step, most, (reach - done_so_far) / rate)
            found, steps, moving = advance(step)
            longest = np.inf if found is None else longest_way(found.motion)
            if found is None or longest > limit:
                step *= 0.5 if found is None else max(0.8 * limit / longest, 0.1)
                calm = CALM if found is None else 0
                if step < SHORTEST * first:
                    held += 1
                    stalled, at = stalled + 1 if self.reached == at else 1, self.reached
                    lost = held > HOLDS or stalled > STALLED
                    ended = Ended.LOST if lost else self._let_go(first if stalled > 1 else 0.0)
                    if ended is not Ended.RESTS:
                        return ended
                    if done():  # the load fell at once, through zero
                        return Ended.SPENT
                    step = first
                continue
            self.accept(found, moving)
            self.share = 0.0
            self.reached += step
            self.note()
            rate = max((self.way_done() - done_so_far) / step, 1e-300)
            done_so_far = self.way_done()
            tell(done_so_far / reach)
            if done():
                return Ended.SPENT
            if found.response.force[:, 0].max(initial=0.0) > HELD:
                return Ended.HELD
            held = 0 if step >= first else held
            calm = max(calm - 1, 0)
            if steps < EASY and not calm:
                step *= min(2.0, 0.9 * limit / max(longest, 1e-300))
        return Ended.REACHED

    def _let_go(self, nudge: float) -> Ended:
        """Hold what drives, and let the blocks come to rest again or fall.

        A load that grows pushes them by ``nudge`` first: where they balance and would not stay,
        they are still there otherwise.
        """
        if nudge and self.grown is not None:
            self.drag = HELD_BACK / nudge
            found, _ = self.increment(distance=nudge)
            if found is not None:
                self.accept(found)
        self.base, self.drag, self.guess = self.pose, self.first, None
        self.farthest, self.stretch, self.soft = 0.0, 1.0, self._springs()
        ended = self.to_rest()
        self.guess = None
        if ended is Ended.RESTS:
            self.note()
        return ended

    def _limit(self) -> float:
        size = float(self.bodies.size[self.bodies.free].min(initial=np.inf))
        return self.bounds.pace * LONGEST * size

    def way(self) -> Floats:
        """(f,) of each free block since what drives was last held, by its size."""
        bodies, free = self.bodies, self.bodies.free
        gone = self.pose.place[free] - self.base.place[free]
        turned = self.pose.turn[free] @ np.swapaxes(self.base.turn[free], 1, 2)
        return travelled(gone, turned, bodies.radius[free], bodies.size[free])

    def _gone(self) -> float:
        """Largest displacement of a centroid from the beginning."""
        return float(lengths(self.pose.place - self.bodies.centroid).max(initial=0.0))

    def _on_supports(self, motion: Floats, far: float) -> float:
        """Force of the blocks on the supports whose corners move by ``far``, along that motion.

        The motion is (n, 6), its rotation by radius; the force times ``far`` is work.
        """
        turn = motion[:, 3:] / self.bodies.radius[:, None]
        world = np.einsum("ki,kij->kj", self.response.force, self.placed.axes)
        work = 0.0
        for block, sign in ((self.bodies.block_b, 1.0), (self.bodies.block_a, -1.0)):
            arm = self.placed.point - self.pose.place[block]
            moved = motion[block, :3] + np.cross(turn[block], arm)
            work += sign * float((world * moved).sum())
        return work / far

    def note(self) -> None:
        """Keep the moment; of too many, every other one but first, last and largest load."""
        number, now = len(self.curve), self.now()
        self.curve.append((now.displacement, now.load))
        self.last = number, now
        if self.most is None or now.load > self.most[1].load:
            self.most = self.last
        if number % self.every == 0:
            self.moments[number] = now
        if len(self.moments) > KEPT:
            self.every *= 2
            self.moments = {at: one for at, one in self.moments.items() if at % self.every == 0}

    def kept(self) -> list[DrivenState]:
        """The moments that were kept, that of the largest load, and the last one."""
        others = dict(one for one in (self.most, self.last) if one is not None)
        return [one for _, one in sorted((self.moments | others).items())]
