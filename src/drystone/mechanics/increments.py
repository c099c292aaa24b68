"""One implicit step of the blocks, by Newton's method.

The step solves ``A f(q) + p + s g - c M q = 0`` for the motion q of the free blocks, see
:mod:`drystone.mechanics.follow`. Where a load g grows, its factor s is one more unknown, and the
displacement ``w . q = d`` with ``w = g / |g|`` is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.geometry.frames import UNTURNED
from drystone.mechanics.bodies import LIGHT, BlockPositions, Bodies, place_corners, turned_load
from drystone.mechanics.law import BLURRED, ContactResponse, respond
from drystone.mechanics.maps import corner_rows, maps_between, times
from drystone.mechanics.newton import Equation, Steps, newton
from drystone.solvers.factors import Solve

FEW = 24
"""Largest number of free blocks that are not many; from timings."""
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
SHORTEST = 0.02
"""Share of a Newton step that is taken whatever it leaves."""


class Increment(NamedTuple):
    """One increment.

    Attributes
    ----------
    motion : (f, 6)
    response
        Of the corners after it.
    left : (f, 6)
        What is not balanced.
    size
        Its share of the load.
    factor
        Of the load that grows.
    """

    motion: Floats
    response: ContactResponse
    left: Floats
    size: float
    factor: float


class Increments:
    """The state of the blocks, and one increment from there.

    Parameters
    ----------
    bodies

    Attributes
    ----------
    pose, placed
        Where the blocks and the corners are.
    mass : (f, 6, 6)
        Of the blocks as they have turned.
    friction : (k, 2)
        Forces along the faces after earlier increments.
    yielded : (k,)
        How far each corner of limited force was pressed in for good; its gap is larger by this.
    drag
        By mass; ``first`` at the beginning.
    rough
        Unbalanced share of the load, by the share that the drag carries, at which an increment has
        converged.
    grown : (f, 6), (f, 3, 3)
        The load that grows, and its arms; None where none does.
    factor
        Of it, so far.
    iterations
        Newton steps so far.
    """

    def __init__(self, bodies: Bodies) -> None:
        self.bodies = bodies
        a, b = bodies.slot[bodies.block_a], bodies.slot[bodies.block_b]
        self.maps = maps_between(a, b, bodies.radius[bodies.free], bodies.centroid[bodies.free])
        self.rough = ROUGH if len(bodies.free) > FEW else 0.0
        count = len(bodies.centroid)
        self.pose = BlockPositions(bodies.centroid.copy(), np.tile(np.eye(3), (count, 1, 1)))
        self.friction = np.zeros((len(bodies.block_a), 2))
        self.yielded = np.zeros(len(bodies.block_a))
        self.load_size = max(_length(bodies.load), np.finfo(float).tiny)
        self.unit = 1.0 if bodies.felt is None else self._by_feel(bodies.felt)
        self.first = max(float(bodies.normal.sum()), 1.0) / max(len(bodies.free), 1)
        self.drag = self.first
        self.grown: tuple[Floats, Floats] | None = None
        self.factor = 0.0
        self.iterations = 0
        self.place(self.pose)

    def increment(
        self,
        guess: Floats | None = None,
        moving: Floats | None = None,
        *,
        distance: float = 0.0,
    ) -> tuple[Increment | None, int]:
        """One increment, and its Newton steps; None if it is too long.

        Parameters
        ----------
        guess : (f, 6)
        moving : (n, 6)
            Motion of the supports.
        distance
            Displacement of the load that grows.
        """
        bodies = self.bodies
        motion = np.zeros((len(bodies.free), 6)) if guess is None else guess
        equation = _Balance(self, moving, distance)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            begin = equation.at(motion, self.factor)
            if self.grown is not None:  # the first step makes its displacement the given one
                begin = begin._replace(size=np.inf)
            bold = STUCK if self.rough else 0
            chords = 1 if self.grown is None else 0
            chosen = Steps(NEWTON, SHORTEST, bold=bold, chords=chords)
            found, solved, steps = newton(equation, begin, chosen)
        self.iterations += steps
        return found if solved else None, steps

    def carried(self, motion: Floats) -> float:
        """Share of the load that the drag carries while blocks move by (f, 6)."""
        left = self.unit * times(self.mass, motion)
        return self.drag * _length(left) / self.load_size

    def _by_feel(self, felt: Floats) -> Floats:
        """Factors (f, 1) with which what a light block is left with counts by what it feels."""
        return np.where(felt < LIGHT, self.load_size / felt, 1.0)[:, None]

    def move(self, found: Increment, moving: Floats | None = None) -> None:
        """Go on to where an increment leads, with supports that move by (n, 6)."""
        bodies, pose = self.bodies, self.pose
        if moving is not None:
            fixed = np.flatnonzero(bodies.slot < 0)
            pose = pose.moved(fixed, _turned(moving[fixed], bodies.radius[fixed]))
        step = _turned(found.motion, bodies.radius[bodies.free])
        self.friction, self.factor = found.response.force[:, 1:], found.factor
        self.place(pose.moved(bodies.free, step))

    def place(self, pose: BlockPositions) -> None:
        """Put the blocks somewhere."""
        springs, placed = self.bodies.springs, place_corners(self.bodies, pose)
        if springs.most is not None:
            self.yielded = np.maximum(self.yielded, -placed.gap - springs.most / springs.normal)
            placed = placed._replace(gap=placed.gap + self.yielded)
        self.pose, self.placed = pose, placed
        self.mass = self.bodies.turned_mass(pose.turn)
        self.maps.at(placed.axes, *self._arms())

    def imposed(self, moving: Floats) -> Floats:
        """Local motion (k, 3) of b over a at each corner due to supports that move by (n, 6)."""
        bodies, result = self.bodies, np.zeros((len(self.placed.gap), 3))
        still = np.where((bodies.slot < 0)[:, None], moving, 0.0)
        of_a, of_b = corner_rows(self.placed.axes, self._arms())
        result -= np.einsum("kij,kj->ki", of_a, still[bodies.block_a])
        result += np.einsum("kij,kj->ki", of_b, still[bodies.block_b])
        return result

    def _arms(self) -> Floats:
        """(2, k, 3) from the centroids of both blocks to the corner, by the radii of the blocks."""
        both = self.bodies.both
        place = self.pose.place.take(both, axis=0).reshape(2, -1, 3)
        arm: Floats = self.placed.point - place
        return arm / self.bodies.radius.take(both).reshape(2, -1, 1)


class _Balance(Equation[Increment, tuple[Floats, float]]):
    """The balance of one increment."""

    def __init__(self, blocks: Increments, moving: Floats | None, distance: float) -> None:
        self.blocks, self.maps, self.distance = blocks, blocks.maps, distance
        bodies = blocks.bodies
        self.springs, self.gap, self.before = bodies.springs, blocks.placed.gap, -blocks.friction
        self.weight = blocks.drag * blocks.mass
        turn = blocks.pose.turn[bodies.free]
        self.load = turned_load(bodies.load, bodies.arms, turn)
        self.size, self.grown = 1.0, None
        if blocks.grown is not None:
            self.grown = turned_load(*blocks.grown, turn)
            self.size = float(np.linalg.norm(blocks.grown[0]))
        self.blur = BLURRED * bodies.overlap if blocks.rough else 0.0  # few: another path
        self.shift: Floats | None = None
        if moving is not None:
            self.shift = blocks.imposed(moving)
        self.solve: Solve | None = None

    def at(self, motion: Floats, factor: float) -> Increment:
        """The forces after a motion (f, 6), and what is not balanced."""
        blocks, moved = self.blocks, self.maps.moved(motion)
        if self.shift is not None:
            moved = moved + self.shift
        response = respond(self.springs, self.gap + moved[:, 0], moved[:, 1:], self.before)
        left = self.maps.wrench(response.force) + self.load - times(self.weight, motion)
        if self.grown is not None:
            left = left + factor * self.grown
        return Increment(
            motion, response, left, _length(blocks.unit * left) / blocks.load_size, factor
        )

    def tolerance(self, point: Increment) -> float:
        rough = self.blocks.rough
        return max(BALANCED, rough * self.blocks.carried(point.motion)) if rough else BALANCED

    def lost(self, sizes: Sequence[float], point: Increment) -> bool:
        blocks = self.blocks
        if blocks.rough and sizes[-1] > LOST * max(sizes[0], blocks.carried(point.motion)):
            return True
        patient = STUCK if blocks.rough else EASY
        return len(sizes) > patient + 1 and min(sizes[-STUCK:]) > 0.5 * min(sizes[:-STUCK])

    def step(self, point: Increment, renew: bool) -> tuple[Floats, float]:
        if renew or self.solve is None:
            self.solve = None  # one set of factors at a time
            law, blur = point.response, self.blur
            tangent = law.blurred(blur * point.size) if blur else law.tangent
            self.solve = self.maps.factorise(tangent, self.weight)
        step = self.solve(point.left)
        if self.grown is None:
            return step, 0.0
        grows = self.solve(self.grown)
        along = self.grown / self.size
        missing = self.distance - float((along * (point.motion + step)).sum())
        change = missing / float((along * grows).sum())
        return step + change * grows, change

    def after(self, point: Increment, step: tuple[Floats, float], length: float) -> Increment:
        motion, change = step
        return self.at(point.motion + length * motion, point.factor + length * change)


def longest_way(motion: Floats) -> float:
    """The longest translation, or rotation by radius, of the motions (f, 6) of some blocks.

    A length, not a component along an axis: increments do not depend on the axes of the model.
    """
    parts = motion.reshape(-1, 2, 3)
    return float(np.sqrt((parts * parts).sum(axis=2)).max(initial=0.0))


def travelled(gone: Floats, turn: Floats, radius: Floats, size: Floats) -> Floats:
    """Displacement (f,) by the size, from translations (f, 3) and rotations (f, 3, 3) by radius."""
    way = lengths(gone)
    # |R - 1| = 2 sqrt(2) sin(angle / 2); the trace of R would lose half of the digits
    off = turn - UNTURNED
    half = lengths(off.reshape(-1, 9)) / np.sqrt(8.0)
    turned = 2.0 * np.arcsin(np.minimum(half, 1.0))
    return (way + turned * radius) / size


def _turned(motion: Floats, radius: Floats) -> Floats:
    """Motions (f, 6) with rotation vectors, from those with rotations by radius."""
    out = motion.copy()
    out[:, 3:] /= radius[:, None]
    return out


def _length(values: Floats) -> float:
    """Root of the sum of squares; a quarter of the time of the general norm."""
    flat = values.ravel()
    return float(np.sqrt(flat @ flat))
