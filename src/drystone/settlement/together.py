"""Several runs of the steps side by side, as one calculation with stacked arrays.

For one block with a dozen corners each operation on arrays takes far longer to start than to do.
The runs go on independently. What they ask for at the same time is computed at once, with the same
functions as for one run.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import SolverError
from drystone.settlement.bodies import Bodies
from drystone.settlement.faces.corners import Ends
from drystone.settlement.follow import Follower, Track
from drystone.settlement.maps import DenseMaps, corner_rows
from drystone.settlement.springs import (
    BlockPositions,
    Placed,
    Response,
    place_corners,
    respond,
    tangents,
)
from drystone.settlement.steps.increments import (
    Asked,
    Place,
    ResponseAsked,
    StepAsked,
    Steps,
    travelled,
)
from drystone.solvers.dense_factor import inverse
from drystone.solvers.threads import one_blas_thread

LEAST = 6
"""Runs from which on they are faster together than one by one: from timings."""


class Union(NamedTuple):
    """Many models side by side as one, and which block and corner belongs to which.

    Attributes
    ----------
    bodies
    of_block, of_corner
        The case of each.
    of_free
        The case of each free block.
    """

    bodies: Bodies
    of_block: Ints
    of_corner: Ints
    of_free: Ints


def joined(parts: Sequence[Bodies]) -> Union:
    """The scaled bodies of many models as those of one."""
    blocks = [len(one.centroid) for one in parts]
    corners = [len(one.block_a) for one in parts]
    frees = [len(one.free) for one in parts]
    first, first_free = np.cumsum([0, *blocks])[:-1], np.cumsum([0, *frees])[:-1]
    shifted = {
        "free": [one.free + at for one, at in zip(parts, first, strict=True)],
        "block_a": [one.block_a + at for one, at in zip(parts, first, strict=True)],
        "block_b": [one.block_b + at for one, at in zip(parts, first, strict=True)],
        "slot": [
            np.where(one.slot >= 0, one.slot + at, -1)
            for one, at in zip(parts, first_free, strict=True)
        ],
    }
    same = {
        field.name: np.concatenate(
            shifted.get(field.name) or [getattr(one, field.name) for one in parts]
        )
        for field in dataclasses.fields(Bodies)
        if field.name not in ("ends", "overlap", "length_unit", "force_unit")
    }
    ends = _joined_ends([one.ends for one in parts])
    case = np.arange(len(parts))
    return Union(
        Bodies(**same, ends=ends, overlap=parts[0].overlap, length_unit=1.0, force_unit=1.0),
        np.repeat(case, blocks),
        np.repeat(case, corners),
        np.repeat(case, frees),
    )


def _joined_ends(parts: Sequence[Ends]) -> Ends:
    corners = np.cumsum([0, *(len(one.joint) for one in parts)])
    joints = np.cumsum([0, *(int(one.joint.max(initial=-1)) + 1 for one in parts)])
    shifted = [
        one._replace(joint=one.joint + joint, after=one.after + corner)
        for one, joint, corner in zip(parts, joints[:-1], corners[:-1], strict=True)
    ]
    return Ends(*(np.concatenate(arrays) for arrays in zip(*shifted, strict=True)))


class _Springs(NamedTuple):
    """Corners of some runs."""

    normal: Floats
    tangential: Floats
    friction: Floats


def shape_of(follower: Follower) -> tuple[int, ...]:
    """Numbers of blocks, free blocks, corners and interfaces.

    Runs with the same ones can be computed together.
    """
    bodies = follower.bodies
    joints = int(bodies.ends.joint.max(initial=-1)) + 1
    return len(bodies.centroid), len(bodies.free), len(bodies.block_a), joints


class Together:
    """Runs of one shape, each with full matrices, side by side.

    Parameters
    ----------
    runs
        Each follower and its work, not begun.
    """

    def __init__(self, runs: Sequence[tuple[Follower, Steps[Track]]]) -> None:
        self.runs = list(runs)
        parts = [follower.bodies for follower, _ in self.runs]
        many = len(parts)
        self.blocks, self.frees, self.corners, self.joints = shape_of(self.runs[0][0])
        whole = joined(parts).bodies
        # one row for each run; numbers of blocks and corners count from its beginning
        first = np.arange(many)[:, None]
        self.mass = np.repeat(whole.mass.reshape(many, -1), 6, axis=1)
        self.size = np.array([follower.load_size for follower, _ in self.runs])
        self.stack = {
            name: getattr(whole, name).reshape(many, -1, *getattr(whole, name).shape[1:])
            for name in (
                *("centroid", "radius", "size", "arm_a", "arm_b", "frame"),
                *("friction", "normal", "tangential", "turned"),
            )
        }
        self.stack["block_a"] = whole.block_a.reshape(many, -1) - self.blocks * first
        self.stack["block_b"] = whole.block_b.reshape(many, -1) - self.blocks * first
        self.stack["slot"] = np.stack([one.slot for one in parts])
        self.stack["free"] = np.stack([one.free for one in parts])
        ends = zip(*(one.ends for one in parts), strict=True)
        self.ends = Ends(*(np.stack(arrays) for arrays in ends))
        self.bodies = whole
        self.rows = np.stack([_flat(follower) for follower, _ in self.runs])
        self.matrix = np.zeros((many, 6 * self.frees, 6 * self.frees))

    def tracks(self) -> list[Track]:
        """The tracks of all runs, when the last one has ended."""
        found: dict[int, Track] = {}
        waiting: dict[type[Asked], dict[int, Any]] = {ResponseAsked: {}, StepAsked: {}, Place: {}}
        given: dict[int, Any] = dict.fromkeys(range(len(self.runs)))
        kinds: dict[type[Asked], Callable[..., list[Any]]]
        kinds = {ResponseAsked: self._answers, StepAsked: self._steps, Place: self._places}
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            while True:
                for number, what in given.items():
                    try:
                        next_one = self.runs[number][1].send(what)
                    except StopIteration as end:
                        found[number] = end.value
                    else:
                        waiting[type(next_one)][number] = next_one
                left = sum(map(len, waiting.values()))
                if left < LEAST:
                    for asking in waiting.values():
                        found |= {one: self._alone(one, asked) for one, asked in asking.items()}
                    return [found[number] for number in range(len(self.runs))]
                kind = max(waiting, key=lambda one: len(waiting[one]))
                now, waiting[kind] = waiting[kind], {}
                answers = kinds[kind](np.fromiter(now, dtype=np.intp), list(now.values()))
                given = dict(zip(now, answers, strict=True))

    def _alone(self, number: int, asked: Asked) -> Track:
        """Go on with one run, as few are left."""
        follower, work = self.runs[number]
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            follower.maps.at(follower.pose, follower.placed)
            with suppress(SolverError):
                follower.solve = inverse(self.matrix[number].copy())
            return follower.alone(work, follower.evaluate(asked))

    def _springs(self, chosen: Ints) -> _Springs:
        stack = self.stack
        names = _Springs._fields
        return _Springs(*(stack[name][chosen].ravel() for name in names))

    def _bodies(self, chosen: Ints) -> Bodies:
        """Some of the runs as one."""
        local = np.arange(len(chosen))[:, None]
        part = {name: array[chosen] for name, array in self.stack.items()}
        for name in ("block_a", "block_b", "free"):
            part[name] = part[name] + self.blocks * local
        part["slot"] = np.where(part["slot"] >= 0, part["slot"] + self.frees * local, -1)
        ends = Ends._make(array[chosen] for array in self.ends)
        ends = ends._replace(
            joint=ends.joint + self.joints * local, after=ends.after + self.corners * local
        )
        flat = {name: array.reshape(-1, *array.shape[2:]) for name, array in part.items()}
        ends = Ends._make(array.reshape(-1, *array.shape[2:]) for array in ends)
        return dataclasses.replace(self.bodies, ends=ends, **flat)

    def _answers(self, chosen: Ints, asked: Sequence[ResponseAsked]) -> list[Any]:
        followers = [self.runs[number][0] for number in chosen]
        many, rows = len(chosen), self.rows[chosen]
        wide = rows.shape[2]
        motion = np.array([one.motion for one in asked]).reshape(many, wide)
        load = np.array([one.load for one in asked]).reshape(many, wide)
        drag = np.array([one.drag for one in asked])
        gap = np.concatenate([one.placed.gap for one in followers])
        friction = np.concatenate([one.friction for one in followers])
        moved = (rows @ motion[:, :, None]).reshape(-1, 3)
        response = respond(self._springs(chosen), gap, friction, moved)
        carried = (response.force.reshape(many, 1, -1) @ rows)[:, 0]
        left = carried + load - drag[:, None] * self.mass[chosen] * motion
        size = (np.sqrt((left * left).sum(axis=1)) / self.size[chosen]).tolist()
        parts = [part.reshape(many, -1, *part.shape[1:]) for part in response]
        responses = map(Response, *parts)
        return list(zip(responses, left.reshape(many, -1, 6), size, strict=True))

    def _steps(self, chosen: Ints, asked: Sequence[StepAsked]) -> list[Any]:
        new = [i for i, one in enumerate(asked) if one.response is not None]
        if new:
            self._tangents(chosen[new], [asked[i] for i in new])
        left = np.array([one.left for one in asked])
        matrix, right = self.matrix[chosen], left.reshape(len(asked), -1, 1)
        try:
            return list(np.linalg.solve(matrix, right).reshape(left.shape))
        except np.linalg.LinAlgError:  # one of them is singular
            return [_solved(*one) for one in zip(matrix, left, strict=True)]

    def _tangents(self, chosen: Ints, asked: Sequence[StepAsked]) -> None:
        """New tangent matrices."""
        responses = [one.response for one in asked if one.response is not None]
        response = Response(*map(np.concatenate, zip(*responses, strict=True)))
        rows, drag = self.rows[chosen], np.array([one.drag for one in asked])
        many, high, wide = rows.shape
        tangent = tangents(self._springs(chosen), response)
        pushed = (tangent @ rows.reshape(-1, 3, wide)).reshape(many, high, wide)
        matrix = rows.swapaxes(1, 2) @ pushed
        index = np.arange(wide)
        matrix[:, index, index] += drag[:, None] * self.mass[chosen]
        self.matrix[chosen] = matrix

    def _places(self, chosen: Ints, asked: Sequence[Place]) -> list[Any]:
        bodies, many = self._bodies(chosen), len(chosen)
        free, radius = bodies.free, bodies.radius[bodies.free]
        step = np.concatenate([one.motion for one in asked])
        step[:, 3:] /= radius[:, None]
        pose = BlockPositions(
            np.concatenate([one.pose.place for one in asked]),
            np.concatenate([one.pose.turn for one in asked]),
        ).moved(free, step)
        placed = place_corners(bodies, pose)
        gone = pose.place[free] - bodies.centroid[free]
        travel = travelled(gone, pose.turn[free], radius, bodies.size[free])
        rows = np.zeros((many * self.corners, 3, self.frees, 6))
        for block, sign in ((bodies.block_a, -1.0), (bodies.block_b, 1.0)):
            here = np.flatnonzero(bodies.slot[block] >= 0)
            part = corner_rows(bodies, pose, placed, here, block[here], sign)
            rows[here, :, bodies.slot[block[here]] % self.frees] += part
        self.rows[chosen] = rows.reshape(many, 3 * self.corners, -1)
        poses = map(
            BlockPositions, pose.place.reshape(many, -1, 3), pose.turn.reshape(many, -1, 3, 3)
        )
        corners = map(Placed, *(part.reshape(many, -1, *part.shape[1:]) for part in placed))
        return list(zip(poses, corners, travel.reshape(many, -1), strict=True))


@one_blas_thread()
def tracks_of(runs: Sequence[tuple[Follower, Steps[Track]]]) -> list[Track]:
    """The tracks of runs; those of one shape together, where they are enough to be faster so."""
    found: dict[int, Track] = {}
    shapes: dict[tuple[int, ...], list[int]] = {}
    for number, (follower, work) in enumerate(runs):
        if isinstance(follower.maps, DenseMaps):
            shapes.setdefault(shape_of(follower), []).append(number)
        else:
            found[number] = follower.alone(work)
    for numbers in shapes.values():
        if len(numbers) < LEAST:
            found |= {number: runs[number][0].alone(runs[number][1]) for number in numbers}
        else:
            tracks = Together([runs[number] for number in numbers]).tracks()
            found |= dict(zip(numbers, tracks, strict=True))
    return [found[number] for number in range(len(runs))]


def _flat(follower: Follower) -> Floats:
    if not isinstance(follower.maps, DenseMaps):
        raise TypeError("only runs with full matrices are computed together")
    return follower.maps.flat


def _solved(matrix: Floats, left: Floats) -> Floats | None:
    try:
        return np.asarray(np.linalg.solve(matrix, left.ravel())).reshape(left.shape)
    except np.linalg.LinAlgError:
        return None
