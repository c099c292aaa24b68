"""The corner springs at one position of the blocks: gaps, directions, forces and tangents."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.base.arrays import Bools, Floats, Ints, cross
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
    a, b = bodies.block_a, bodies.block_b
    turn_a, turn_b = pose.turn[a], pose.turn[b]
    on_a = pose.place[a] + (turn_a @ bodies.arm_a[:, :, None])[:, :, 0]
    # columns: from the corner of a to that of b, and the normal of the face of b
    world = turn_b @ np.stack([bodies.arm_b, bodies.frame[:, 0]], axis=2)
    world[:, :, 0] += pose.place[b] - on_a
    frame = bodies.frame @ turn_a.transpose(0, 2, 1)
    local = frame @ world
    slide, lean = local[:, 1:, 0], local[:, 1:, 1]
    carried, tangent, on = slid(bodies.ends, slide)
    normal = local[:, :, 1].copy()
    normal[:, 1:] -= (lean[:, None] @ tangent)[:, 0]
    left = slide - carried
    gap = normal[:, 0] * local[:, 0, 0] + lean[:, 0] * left[:, 0] + lean[:, 1] * left[:, 1]
    gap = np.where(on, gap, OUT_OF_REACH)
    point = on_a + (carried[:, None] @ frame[:, 1:])[:, 0]
    return Placed(point, _inclined(normal) @ frame, gap)


def _inclined(normal: Floats) -> Floats:
    """Rows n, u, v (k, 3, 3), orthonormal: n along (k, 3), u in the plane of n and the second axis.

    Every v is normal to the second axis.
    """
    n, u = normal / _sizes(normal)[:, None], np.zeros_like(normal)
    u[:, 1] = 1.0
    u -= n[:, 1:2] * n
    u /= _sizes(u)[:, None]
    return np.stack([n, u, cross(n, u)], axis=1)


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
