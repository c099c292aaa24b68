"""One implicit step of the blocks, by Newton's method, and what its calculation asks for.

The step solves ``A f(q) + p - c M q = 0`` for the motion q of the free blocks, see
:mod:`drystone.settlement.follow`.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import SolverError
from drystone.settlement.bodies import Bodies
from drystone.settlement.maps import SparseMaps, imposed, maps_of
from drystone.settlement.springs import BlockPositions, Response, place_corners, respond, tangents
from drystone.solvers.threads import one_blas_thread

NEWTON = 40
"""Newton steps after which an increment counts as too long."""
STUCK = 6
"""Newton steps that have to halve the unbalanced share of the load, once there were EASY of them;
otherwise they change between the same corners, and the increment counts as too long."""
BALANCED = 1e-10
"""Unbalanced share of the load at which an increment has converged."""
ROUGH = 0.01
"""Of many blocks: the same by the share that the drag carries. Corner forces meet the contact law
at any motion, and the next increment balances what was left. At 0.1 the Armadillo vault takes a
sixth fewer Newton steps near its limit, but what is left may be as large as the weight of a block:
there six of ten loads had another verdict where they were changed by 1e-11 to 1e-7, at 0.01 none.
"""
LOST = 10.0
"""Of many blocks: unbalanced share by what the drag carries, and by that at the beginning of the
increment, above which Newton's method has left the path, and the increment counts as too long. On
the Armadillo vault this ends a refused increment after 4 Newton steps in place of 8."""
EASY = 12
"""Newton steps up to which the next increment may be longer."""


class Increment(NamedTuple):
    """The motion (f, 6) of one increment, the forces after it, and its Newton steps."""

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


class Increments:
    """The state of the blocks, and one increment from there.

    Parameters
    ----------
    bodies

    Attributes
    ----------
    pose, placed
        Where the blocks and the corners are.
    friction : (k, 2)
        Forces along the faces after earlier increments.
    drag
        By mass; ``first`` at the beginning.
    rough
        Unbalanced share of the load, by the share that the drag carries, at which an increment has
        converged.
    iterations
        Newton steps so far.
    """

    def __init__(self, bodies: Bodies) -> None:
        self.bodies = bodies
        self.maps = maps_of(bodies)
        self.rough = ROUGH if isinstance(self.maps, SparseMaps) else 0.0
        count = len(bodies.centroid)
        self.pose = BlockPositions(bodies.centroid.copy(), np.tile(np.eye(3), (count, 1, 1)))
        self.friction = np.zeros((len(bodies.block_a), 2))
        self.load_size = max(_length(bodies.load), np.finfo(float).tiny)
        self.first = max(float(bodies.normal.sum()), 1.0) / max(len(bodies.free), 1)
        self.drag = self.first
        self.iterations = 0
        self.solve: Callable[[Floats], Floats] | None = None
        self.placed = place_corners(bodies, self.pose)
        self.maps.at(self.pose, self.placed)

    @one_blas_thread()
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

    def _increment(
        self, guess: Floats | None, moving: Floats | None = None
    ) -> Steps[Increment | None]:
        """The motion (f, 6) of one increment, by Newton's method; None if it is too long."""
        bodies, drag = self.bodies, self.drag
        shift = None if moving is None else imposed(bodies, self.pose, self.placed, moving)
        motion = np.zeros((len(bodies.free), 6)) if guess is None else guess
        response, left, size = yield ResponseAsked(motion, bodies.load, drag, shift)
        recent = [size]
        begun = False
        patient = STUCK if self.rough else EASY
        for number in range(NEWTON):
            if size < max(BALANCED, self.rough * self._carried(motion)):
                return Increment(motion, response, number)
            stuck = number > patient and min(recent[-STUCK:]) > 0.5 * min(recent[:-STUCK])
            if stuck or (self.rough and size > LOST * max(recent[0], self._carried(motion))):
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

    def _travel(self, pose: BlockPositions) -> Floats:
        """Displacement (f,) of each free block relative to its size."""
        bodies, free = self.bodies, self.bodies.free
        gone = pose.place[free] - bodies.centroid[free]
        return travelled(gone, pose.turn[free], bodies.radius[free], bodies.size[free])

    def _carried(self, motion: Floats) -> float:
        """Share of the load that the drag carries while blocks move by (f, 6)."""
        return self.drag * _length(self.bodies.mass[:, None] * motion) / self.load_size


def longest_way(motion: Floats) -> float:
    """The longest translation, or rotation by radius, of the motions (f, 6) of some blocks.

    A length, not a component along an axis: increments do not depend on the axes of the model.
    """
    parts = motion.reshape(-1, 2, 3)
    return float(np.sqrt((parts * parts).sum(axis=2)).max(initial=0.0))


def travelled(gone: Floats, turn: Floats, radius: Floats, size: Floats) -> Floats:
    """Displacement (f,) by the size, from translations (f, 3) and rotations (f, 3, 3) by radius."""
    way = np.sqrt((gone * gone).sum(axis=1))
    # |R - 1| = 2 sqrt(2) sin(angle / 2); the trace of R would lose half of the digits
    off = turn - np.eye(3)
    half = np.sqrt((off * off).sum(axis=(1, 2)) / 8.0)
    turned = 2.0 * np.arcsin(np.minimum(half, 1.0))
    travel: Floats = (way + turned * radius) / size
    return travel


def _length(values: Floats) -> float:
    """Root of the sum of squares; a quarter of the time of the general norm."""
    flat = values.ravel()
    return float(np.sqrt(flat @ flat))


__all__ = [
    "BALANCED",
    "EASY",
    "Asked",
    "Increment",
    "Increments",
    "Place",
    "ResponseAsked",
    "StepAsked",
    "Steps",
    "longest_way",
    "travelled",
]
