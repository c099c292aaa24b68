"""The corners at one position of the blocks: where they are, their directions and gaps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats, Ints, lengths
from drystone.geometry.frames import rotations
from drystone.mechanics.bodies import Bodies
from drystone.mechanics.corners import slid

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
    blocks = bodies.block_a, bodies.block_b
    turn_a, turn_b = (_of_corners(pose.turn, block) for block in blocks)
    place_a, place_b = (_of_corners(pose.place, block) for block in blocks)
    of_a, of_b = bodies.by_corner
    turned = _product(turn_a, of_a)
    on_a, frame = place_a + turned[0], turned[1:]
    # from the corner of a to that of b, and the normal of the face of b
    there = _product(turn_b, of_b)
    there[0] += place_b - on_a
    apart, normal = _product(frame, there)
    carried, tangent, on = slid(bodies.ends, bodies.outlines, np.ascontiguousarray(apart[1:].T))
    lean, left = normal[1:].copy(), apart[1:] - carried.T
    gap = normal[0] * apart[0] + lean[0] * left[0] + lean[1] * left[1]
    normal[1:] -= np.einsum("ik,kij->jk", lean, tangent)
    point = on_a + np.einsum("ki,ijk->jk", carried, frame[1:])
    axes = _product(frame.swapaxes(0, 1), _inclined(normal))
    last = np.ascontiguousarray(point.T), np.ascontiguousarray(axes.transpose(2, 0, 1))
    return Placed(*last, np.where(on, gap, OUT_OF_REACH))


def _of_corners(values: Floats, block: Ints) -> Floats:
    """The values (n, ...) of the block of each corner (..., k).

    With the corner as the last index sums over k take a fifth of the time of products of matrices.
    """
    return values.transpose(*range(1, values.ndim), 0).take(block, axis=-1)


def _product(matrix: Floats, vectors: Floats) -> Floats:
    """(m, 3, k) of matrices (3, 3, k) and m vectors of each (m, 3, k)."""
    return np.einsum("ijk,mjk->mik", matrix, vectors)


def _inclined(normal: Floats) -> Floats:
    """Axes n, u, v (3, 3, k), orthonormal: n along (3, k), u in the plane of n and the second axis.

    Every v is normal to the second axis.
    """
    axes = np.zeros((3, *normal.shape))
    n, u, v = axes
    np.divide(normal, lengths(normal.T), out=n)
    np.multiply(-n[1], n, out=u)
    u[1] += 1.0
    size = lengths(u.T)
    u /= size
    np.divide(-n[2], size, out=v[0])
    np.divide(n[0], size, out=v[2])
    return axes


def rotation_vectors(turn: Floats) -> Floats:
    """(n, 3) of rotation matrices (n, 3, 3)."""
    from scipy.spatial.transform import Rotation  # slow to import

    return np.asarray(Rotation.from_matrix(turn).as_rotvec())
