"""The corner springs at one position of the blocks: gaps, directions, forces and tangents."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.base.arrays import Bools, Floats, Ints
from drystone.settlement.bodies import Bodies
from drystone.settlement.faces.corners import slid

OUT_OF_REACH = 1.0
"""Gap of a corner that slid off a face, by the mean size of a block: it carries nothing."""


@dataclass(frozen=True, eq=False)
class BlockPositions:
    """The positions of all n blocks, scaled.

    Attributes
    ----------
    place : (n, 3) centroids
    turn : (n, 3, 3) rotation from the beginning
    """

    place: Floats
    turn: Floats

    def moved(self, blocks: Ints, motion: Floats) -> BlockPositions:
        """Some blocks moved by translations and rotation vectors (f, 6)."""
        place, turn = self.place.copy(), self.turn.copy()
        place[blocks] += motion[:, :3]
        turn[blocks] = rotations(motion[:, 3:]) @ turn[blocks]
        return BlockPositions(place, turn)


class Placed(NamedTuple):
    """The corners at one pose.

    Attributes
    ----------
    point : (k, 3) where the force acts
    axes : (k, 3, 3) rows n, u, v: n is the direction in which the gap grows
    gap : (k,) between the faces
    """

    point: Floats
    axes: Floats
    gap: Floats


def place_corners(bodies: Bodies, pose: BlockPositions) -> Placed:
    """Corners on the moved faces.

    The corner slides over the face of a by x(s), where s is the slide of b; the gap is that of the
    face of b there. A corner that is no longer on both faces is out of reach.
    """
    turn_a, turn_b = (_of_corners(pose.turn, block) for block in (bodies.block_a, bodies.block_b))
    place_a, place_b = (
        _of_corners(pose.place, block) for block in (bodies.block_a, bodies.block_b)
    )
    arm_a, arm_b, begin = bodies.by_corner
    on_a = place_a + _product(turn_a, arm_a)
    frame = np.stack([_product(turn_a, axis) for axis in begin])
    # from the corner of a to that of b, and the normal of the face of b
    apart = _product(frame, place_b + _product(turn_b, arm_b) - on_a)
    normal = _product(frame, _product(turn_b, begin[0]))
    carried, tangent, on = slid(bodies.ends, np.ascontiguousarray(apart[1:].T))
    lean, left = normal[1:].copy(), apart[1:] - carried.T
    gap = normal[0] * apart[0] + lean[0] * left[0] + lean[1] * left[1]
    normal[1:] -= lean[0] * tangent[:, 0].T + lean[1] * tangent[:, 1].T
    point = on_a + carried[:, 0] * frame[1] + carried[:, 1] * frame[2]
    axes = np.empty((len(gap), 3, 3))
    for number, axis in enumerate(_inclined(normal)):
        axes[:, number] = (axis[0] * frame[0] + axis[1] * frame[1] + axis[2] * frame[2]).T
    return Placed(np.ascontiguousarray(point.T), axes, np.where(on, gap, OUT_OF_REACH))


def _of_corners(values: Floats, block: Ints) -> Floats:
    """The values (n, ...) of the block of each corner (..., k).

    With the corner as the last index sums over k take a fifth of the time of products of matrices.
    """
    return np.moveaxis(values, 0, -1).take(block, axis=-1)


def _product(matrix: Floats, vector: Floats) -> Floats:
    """(3, k) of matrices (3, 3, k) and vectors (3, k)."""
    result: Floats = matrix[:, 0] * vector[0] + matrix[:, 1] * vector[1] + matrix[:, 2] * vector[2]
    return result


def _inclined(normal: Floats) -> Floats:
    """Axes n, u, v (3, 3, k), orthonormal: n along (3, k), u in the plane of n and the second axis.

    Every v is normal to the second axis.
    """
    n = normal / _sizes(normal.T)
    u = -n[1] * n
    u[1] += 1.0
    u /= _sizes(u.T)
    v = np.stack([n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]])
    return np.stack([n, u, v])


def _sizes(vectors: Floats) -> Floats:
    """Lengths (k,) of rows (k, 3)."""
    x, y, z = vectors.T
    size: Floats = np.sqrt(x * x + y * y + z * z)
    return size


def rotations(vectors: Floats) -> Floats:
    """Matrices (n, 3, 3) of rotation vectors (n, 3). Source: Rodrigues 1840."""
    angle = _sizes(vectors)
    x, y, z = (vectors / np.where(angle > 0.0, angle, 1.0)[:, None]).T
    skew = np.zeros((len(vectors), 3, 3))
    skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0] = x, y, z
    skew -= skew.transpose(0, 2, 1).copy()
    result: Floats = (
        np.eye(3)
        + np.sin(angle)[:, None, None] * skew
        + (1.0 - np.cos(angle))[:, None, None] * (skew @ skew)
    )
    return result


def rotation_vectors(turn: Floats) -> Floats:
    """(n, 3) of rotation matrices (n, 3, 3)."""
    return np.asarray(Rotation.from_matrix(turn).as_rotvec())


class Response(NamedTuple):
    """Forces of the corners after an increment of motion.

    Attributes
    ----------
    force : (k, 3) local n, u, v, on block b
    pressed, sliding : (k,)
    direction : (k, 2) of the friction
    softening : (k,) friction limit by trial friction, where it slides
    """

    force: Floats
    pressed: Bools
    sliding: Bools
    direction: Floats
    softening: Floats


class Springs(Protocol):
    """What the forces of k corners depend on, (k,) each."""

    @property
    def normal(self) -> Floats:
        """Stiffness."""

    @property
    def tangential(self) -> Floats:
        """Stiffness."""

    @property
    def friction(self) -> Floats:
        """Coefficient."""


def respond(bodies: Springs, gap: Floats, friction: Floats, moved: Floats) -> Response:
    """Coulomb friction from increments of slide.

    Parameters
    ----------
    gap : (k,) before the increment
    friction : (k, 2) before the increment
    moved : (k, 3) of block b over block a, local
    """
    opening = gap + moved[:, 0]
    pressed = opening < 0.0
    normal = np.where(pressed, -bodies.normal * opening, 0.0)
    trial = np.where(pressed[:, None], friction - bodies.tangential[:, None] * moved[:, 1:], 0.0)
    size = np.sqrt(trial[:, 0] ** 2 + trial[:, 1] ** 2)
    limit = bodies.friction * normal
    sliding = size > limit
    safe = np.where(size > 0.0, size, 1.0)
    ratio = np.where(sliding, limit / safe, 1.0)
    force = np.concatenate([normal[:, None], ratio[:, None] * trial], axis=1)
    return Response(force, pressed, sliding & pressed, trial / safe[:, None], ratio)


def tangents(bodies: Springs, response: Response) -> Floats:
    """Tangent stiffness (k, 3, 3) of each corner."""
    out = np.zeros((len(response.pressed), 3, 3))
    pressed, sliding, along = response.pressed, response.sliding, response.direction
    normal = np.where(pressed, bodies.normal, 0.0)
    out[:, 0, 0] = normal
    stiffness = np.where(pressed, bodies.tangential * response.softening, 0.0)
    lost = np.where(sliding, stiffness, 0.0)
    x, y = along[:, 0], along[:, 1]
    out[:, 1, 1] = stiffness - lost * x * x
    out[:, 2, 2] = stiffness - lost * y * y
    out[:, 1, 2] = out[:, 2, 1] = -lost * x * y
    coupling = np.where(sliding, bodies.friction * normal, 0.0)
    out[:, 1, 0] = coupling * x
    out[:, 2, 0] = coupling * y
    return out
