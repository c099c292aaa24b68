"""Search for a path on which a block is removed from its place, straight or with rotation.

Straight paths along free directions are tried first. If there is none and some twist is free at the
joints, constant twists are followed until a collision. From poses along them straight paths are
tried again, then further twists. The path of insertion is the path of removal, reversed.
"""

from __future__ import annotations

import heapq
import itertools
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.model import Model
from drystone.sequence.freedom import (
    NAMED,
    Joints,
    Obstacle,
    face_at,
    free_twists,
    freedom,
    in_words,
    obstacles,
    opens,
)
from drystone.sequence.sweeps import (
    HERE,
    PLAY,
    Hit,
    Mover,
    Pose,
    Solids,
    Surroundings,
    moved_along,
)


@dataclass(frozen=True)
class PathOptions(Options):
    """Options of the search for paths.

    Attributes
    ----------
    play : > 0, < 0.1
        How much the moving block is reduced on all sides, relative to its size.
    turning
        Whether to search paths with rotation if there is no straight path.
    effort : >= 1
        Largest number of swept volumes that are tested for one block.
    up : (3,)
        The preferred direction of paths.
    """

    play: float = PLAY
    turning: bool = True
    effort: int = 6000
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not np.linalg.norm(self.up) > 0.0:
            raise InputError("up is zero", remedy="give a direction")


@dataclass(frozen=True, eq=False)
class RemovalPath(OneLine):
    """A path on which a block is removed from its place without collision.

    Attributes
    ----------
    block
        Position of the block.
    poses
        Rigid motions of the block, from its place (the first) to a pose away from all blocks in
        place. Between two poses it moves with a constant twist.
    turning
        Whether it rotates.
    clearance : (p,) [m]
        Distance of the block from the blocks in place at each pose, at most its size.
    """

    block: int
    poses: tuple[Pose, ...]
    turning: bool
    clearance: Floats

    @property
    def matrices(self) -> Floats:
        """(p, 4, 4), homogeneous, from its place outwards."""
        return np.stack([pose.matrix for pose in self.poses])

    @property
    def approach(self) -> Floats:
        """(p, 4, 4), homogeneous, from outside to its place."""
        return self.matrices[::-1]


@dataclass(frozen=True, eq=False)
class NoPath(OneLine):
    """Why a block cannot be removed from its place.

    Attributes
    ----------
    block
        Position of the block.
    reason
        One sentence, with blocks and faces.
    faces
        The blocking faces.
    proved
        Whether the joints alone block every small motion. Otherwise paths begin, and all that were
        tried end at the named faces.
    """

    block: int
    reason: str
    faces: tuple[Obstacle, ...]
    proved: bool


STEP = 0.1
"""Longest straight step along a path with rotation, relative to the size of the block. Chosen."""


def find_path(
    model: Model,
    block: int | str,
    placed: Iterable[int | str] | None = None,
    *,
    options: PathOptions | None = None,
) -> RemovalPath | NoPath:
    """A path on which one block is removed from the others, or why there is none.

    Parameters
    ----------
    model
    block
        Name or position.
    placed
        Free blocks that are in place; all when left out. Supports always are.
    options

    Examples
    --------
    A block on another one can be lifted:

    >>> from drystone.models import tower
    >>> path = find_path(Model.of(tower(2)), "block-1")
    >>> path.turning, path.poses[-1].shift.round(6).tolist()[:2]
    (False, [0.0, 0.0])
    """
    finder = PathFinder(model, options)
    which = int(model.assembly.indices([block])[0])
    if model.assembly.fixed[which]:
        raise InputError(
            "it is a support, which stays",
            where=f"block '{model.assembly.names[which]}'",
            remedy="name a free block",
        )
    here = np.array(model.assembly.fixed)
    everything = range(len(model.assembly)) if placed is None else placed
    here[model.assembly.indices(everything)] = True
    return finder.path(which, here)


@dataclass(order=True)
class _PathNode:
    """A pose that was reached, the steps to it, and its priority."""

    cost: tuple[int, float]
    number: int
    poses: tuple[Pose, ...] = field(compare=False)


class PathFinder:
    """Paths of the blocks of one model; solids and convex pieces are made once.

    Parameters
    ----------
    model
    options
    """

    def __init__(self, model: Model, options: PathOptions | None = None) -> None:
        self.model = model
        self.options = options if options is not None else PathOptions()
        self.up = np.asarray(self.options.up) / np.linalg.norm(self.options.up)
        self._solids = Solids(model.assembly)
        self._mover: dict[int, Mover] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return PathFinder, (self.model, self.options)  # solids do not travel

    def path(self, block: int, here: Bools) -> RemovalPath | NoPath:
        """A path of removal for one block.

        Parameters
        ----------
        block
        here : (n,)
            Blocks in place; the entry of the block itself is ignored.
        """
        around = np.array(here)
        around[block] = False
        joints = Joints.of(self.model.contacts, block, around)
        search = _PathSearch(self, block, joints, np.flatnonzero(around).tolist())
        return search.run()

    def clearance(self, block: int, here: Bools, pose: Pose) -> float:
        """Distance [m] of a block in a pose from the others in place (n,), at most its size."""
        others = [other for other in np.flatnonzero(here).tolist() if other != block]
        body = self.model.assembly.blocks[block]
        return Surroundings(self._solids, others).gap(self.mover(block), pose, body.size)

    def mover(self, block: int) -> Mover:
        """The moving block."""
        if block not in self._mover:
            body = self.model.assembly.blocks[block]
            self._mover[block] = Mover(body, self.options.play * body.size)
        return self._mover[block]


class _PathSearch:
    """The search for the path of one block."""

    def __init__(
        self, finder: PathFinder, block: int, joints: Joints, others: Sequence[int]
    ) -> None:
        self.finder = finder
        self.block = block
        self.joints = joints
        self.assembly = finder.model.assembly
        self.body = self.assembly.blocks[block]
        self.mover = finder.mover(block)
        self.around = Surroundings(finder._solids, others)
        self.rows = joints.rows(self.body)
        middle, radius = self.around.extent
        self.far = (
            float(np.linalg.norm(middle - self.body.centroid)) + radius + 2.0 * self.body.size
        )
        self.met: Counter[Obstacle] = Counter()

    def run(self) -> RemovalPath | NoPath:
        """A straight path, else one with rotation, else the reason."""
        straight = freedom(self.joints.normal, self.finder.up)
        for direction in self._straight(straight.generators, straight.preferred):
            if self._leaves(HERE, direction):
                return self._found((HERE,), direction, turning=False)
        free = free_twists(self.rows)
        if free.blocked:
            return self._refusal(self._facing(self.joints.interface[free.blocking]), True)
        if self.finder.options.turning:
            path = self._turning(free.twist)
            if path is not None:
                return path
        elif straight.blocked:
            return self._refusal(self._facing(free_twists(self.joints.normal).blocking), False)
        faces = tuple(face for face, _ in self.met.most_common(NAMED))
        return self._refusal(faces, False)

    def _facing(self, joint: Ints) -> tuple[Obstacle, ...]:
        return obstacles(self.assembly, self.joints, np.unique(joint).tolist())

    def _straight(self, generators: Floats, preferred: Floats | None) -> Iterator[Floats]:
        """Free directions: nearest to up, away from all joints, generators and sums of two."""
        if preferred is None:
            return
        away = self.joints.normal.sum(axis=0)
        pairs = [a + b for a, b in itertools.combinations(generators, 2)]
        seen: set[tuple[float, ...]] = set()
        for vector in (preferred, away, *generators, *pairs, -self.finder.up):
            length = float(np.linalg.norm(vector))
            if length < 1e-6:
                continue
            unit = vector / length
            key = tuple((unit.round(4) + 0.0).tolist())
            if key in seen or (self.joints.normal @ unit < -1e-3).any():
                continue
            seen.add(key)
            yield unit

    def _leaves(self, pose: Pose, direction: Floats) -> bool:
        """Whether a straight path from a pose to the outside is free."""
        near = Pose(np.eye(3), direction * STEP * self.body.size)
        if self._blocked(pose, pose.then(near), direction):
            return False
        out = Pose(np.eye(3), direction * (self.far + float(np.linalg.norm(pose.shift))))
        return not self._blocked(pose, pose.then(out), direction)

    def _blocked(self, first: Pose, second: Pose, direction: Floats | None = None) -> bool:
        hit = self.around.hit(self.mover, first, second)
        if hit is not None:
            self.met[self._face(hit, direction)] += 1
        return hit is not None

    def _face(self, hit: Hit, direction: Floats | None) -> Obstacle:
        """The face that was hit: near the collision, and facing the motion."""
        towards = None if direction is None else -direction
        face, normal = face_at(self.assembly.blocks[hit.block], hit.point, towards)
        return Obstacle(hit.block, face, self.assembly.names[hit.block], normal)

    def _turning(self, free: Floats) -> RemovalPath | None:
        """Follow free twists until a collision; then try straight paths or further twists."""
        number = itertools.count()
        queue = [_PathNode((0, 0.0), next(number), (HERE,))]
        seen: list[Pose] = []
        while queue and not self._spent:
            node = heapq.heappop(queue)
            pose = node.poses[-1]
            if self._known(pose, seen):
                continue
            seen.append(pose)
            for twist in self._twists(pose, free):
                if self._spent:
                    break
                reached = self._follow(pose, twist)
                last = len(reached) - 1
                for i in sorted({*range(3, last, 3), last} - {0}):
                    out = self._exit(reached[i])
                    if out is not None:
                        return self._found((*node.poses, *reached[1 : i + 1]), out, turning=True)
                if last:
                    lifted = float(self._centre(reached[-1]) @ self.finder.up)
                    cost = (node.cost[0] + 1, -lifted)
                    heapq.heappush(
                        queue, _PathNode(cost, next(number), (*node.poses, *reached[1:]))
                    )
        return None

    def _twists(self, pose: Pose, free: Floats) -> Iterator[Floats]:
        """Twists (6,) [m / s, rad / s] of the centroid to try from a pose.

        In the block's place, twists that close a joint are omitted.
        """
        start, unit = pose is HERE, np.repeat([self.body.size, 1.0], 3)
        if start:
            yield from free * unit
        axes, centre, still = self._axes(pose), self._centre(pose), np.zeros(3)
        shifts = ((self.body.size * axis, still) for axis in axes)
        turns = ((np.cross(axis, centre - at), axis) for axis, at in self._lines(pose, axes))
        for motion in itertools.chain(shifts, turns):
            for sign in (1.0, -1.0):
                twist = sign * np.concatenate(motion)
                if not start or opens(self.rows, twist / unit):
                    yield twist

    def _centre(self, pose: Pose) -> Floats:
        """The centroid (3,) of the block in a pose."""
        return pose.of(self.body.centroid[None])[0]

    @property
    def _spent(self) -> bool:
        """Whether as many swept volumes were tested as are allowed."""
        return self.around.sweeps >= self.finder.options.effort

    def _axes(self, pose: Pose) -> list[Floats]:
        """Unit axes: up and across, the normals of the joints, and the edges between them."""
        normal = self.joints.normal
        _, first = np.unique(normal.round(2), axis=0, return_index=True)
        normal = normal[np.sort(first)][:8]
        edges = [np.cross(a, b) for a, b in itertools.combinations(normal, 2)]
        found: list[Floats] = []
        turned = [] if pose is HERE else list(normal @ pose.turn.T)
        for vector in (self.finder.up, *np.eye(3), *normal, *edges, *turned):
            length = float(np.linalg.norm(vector))
            if length > 1e-3 and not any(abs(a @ vector) > 0.9998 * length for a in found):
                found.append(vector / length)
        return found[:12]

    def _lines(self, pose: Pose, axes: Sequence[Floats]) -> Iterator[tuple[Floats, Floats]]:
        """Axes of rotation: through the centroid and the corners of joints, in place and moved."""
        corner = np.unique(self.joints.corner.round(9), axis=0)
        middle = self.body.centroid[None]
        points = np.concatenate([middle, corner] if pose is HERE else
                                [pose.of(middle), corner, pose.of(corner)])  # fmt: skip
        for axis in axes:
            found: list[Floats] = []
            for point in points:
                flat = point - (point @ axis) * axis
                if all(np.linalg.norm(foot - flat) > 0.01 * self.body.size for foot in found):
                    found.append(flat)
                    yield axis, point

    def _follow(self, pose: Pose, twist: Floats) -> list[Pose]:
        """Poses along a constant twist until a collision, half a turn or the block's size."""
        spin, speed = float(np.linalg.norm(twist[3:])), float(np.linalg.norm(twist[:3]))
        size, play = self.body.size, self.finder.options.play * self.body.size
        radius = self.mover.reach + speed / spin if spin > 1e-9 else 0.0
        by_turn = float(np.sqrt(2.0 * play / radius)) / spin if radius else np.inf
        by_shift = STEP * size / speed if speed > 1e-9 else np.inf
        step = min(by_turn, by_shift)
        last = min(np.pi / spin if radius else np.inf, 1.5 / STEP * by_shift)
        reached, amount, centre = [pose], 0.0, self._centre(pose)
        finest = min(step, play / (2.0 * self.mover.reach * spin)) if radius else step
        while amount < last and not self._spent:
            free = self._free_until(pose, twist, centre, (amount, amount + step), finest)
            if free > amount:
                reached.append(pose.then(moved_along(twist, centre, free)))
            if free < amount + step:
                break
            amount = free
        return reached

    def _free_until(
        self, pose: Pose, twist: Floats, centre: Floats, span: tuple[float, float], finest: float
    ) -> float:
        """The distance within a span that a twist is free of collision.

        The hull of two poses is larger than the volume that a rotating block sweeps. The difference
        decreases with the step. A step with a collision is halved until the difference is below the
        play.
        """
        begin, end = span
        first, second = (pose.then(moved_along(twist, centre, at)) for at in span)
        if not self._blocked(first, second):
            return end
        if end - begin <= finest or self._spent:
            return begin
        middle = 0.5 * (begin + end)
        reached = self._free_until(pose, twist, centre, (begin, middle), finest)
        if reached < middle:
            return reached
        return self._free_until(pose, twist, centre, (middle, end), finest)

    def _exit(self, pose: Pose) -> Floats | None:
        """A direction of a straight path from a pose to the outside."""
        for axis in self._axes(pose):
            for sign in (1.0, -1.0):
                if self._leaves(pose, sign * axis):
                    return sign * axis
        return None

    def _known(self, pose: Pose, seen: Sequence[Pose]) -> bool:
        """Whether the search has reached this pose before, to a few hundredths of the size."""
        for other in seen:
            there = other.of(self.body.vertices) - pose.of(self.body.vertices)
            if np.abs(there).max() < 0.02 * self.body.size:
                return True
        return False

    def _found(self, poses: tuple[Pose, ...], out: Floats, *, turning: bool) -> RemovalPath:
        away = self.far + float(np.linalg.norm(poses[-1].shift))
        near = Pose(np.eye(3), out * self.body.size)
        far = Pose(np.eye(3), out * away)
        every = (*poses, poses[-1].then(near), poses[-1].then(far))
        gaps = [self.around.gap(self.mover, pose, self.body.size) for pose in every]
        return RemovalPath(self.block, every, turning, np.array(gaps))

    def _refusal(self, faces: tuple[Obstacle, ...], proved: bool) -> NoPath:
        names = in_words(faces)
        if proved:
            reason = f"its joints block every motion, straight or with rotation: {names}"
        elif self.finder.options.turning:
            reason = f"a first step is free, but all paths that were tried end at {names}"
        else:
            reason = f"no straight path is free: {names}"
        return NoPath(self.block, reason, faces, proved)
