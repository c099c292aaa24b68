"""Motions of corners by those of blocks, wrenches by corner forces, and the tangent matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse

from drystone.base.arrays import Floats, Ints
from drystone.mechanics.bodies import Bodies
from drystone.mechanics.positions import BlockPositions, Placed
from drystone.mechanics.tangent import SparseTangent, full_factors

DENSE = 24
"""Largest number of free blocks with a dense tangent matrix: from timings."""


class DenseMaps:
    """Maps between corners and the motions of few free blocks, as full matrices."""

    def __init__(self, bodies: Bodies) -> None:
        self.bodies = bodies
        self.width = 6 * len(bodies.free)
        k = len(bodies.block_a)
        both = np.concatenate([bodies.block_a, bodies.block_b])
        here = np.flatnonzero(bodies.slot[both] >= 0)
        self.corner, self.block = here % k, both[here]
        self.sign = np.where(here < k, -1.0, 1.0)[:, None, None]
        row = 3 * self.corner[:, None] + np.arange(3)
        column = 6 * bodies.slot[self.block][:, None] + np.arange(6)
        self.place = self.width * row[:, :, None] + column[:, None]

    def at(self, pose: BlockPositions, placed: Placed) -> None:
        """Renew the maps for a pose."""
        rows = np.zeros((len(placed.gap), 3, self.width))
        part = corner_rows(self.bodies, pose, placed, self.corner, self.block, self.sign)
        rows.reshape(-1)[self.place] = part
        self.flat = rows.reshape(-1, self.width)

    def moved(self, motion: Floats) -> Floats:
        """(k, 3) local motion of b over a at each corner, from motions (f, 6)."""
        result: Floats = (self.flat @ motion.ravel()).reshape(-1, 3)
        return result

    def wrench(self, force: Floats) -> Floats:
        """(f, 6) of the corner forces (k, 3) on the free blocks."""
        result: Floats = (force.ravel() @ self.flat).reshape(-1, 6)
        return result

    def factorise(self, tangent: Floats, weight: Floats) -> Callable[[Floats], Floats]:
        """From wrenches to motions (f, 6), with ``tangent`` (k, 3, 3) and a diagonal (f, 6).

        Raises
        ------
        SolverError
            The matrix is singular.
        """
        return full_factors(self.flat, tangent, weight)


class SparseMaps:
    """As :class:`DenseMaps`, for many blocks, as sparse matrices.

    All corners of two blocks have rows for the motion of b; the motion of a is taken to the
    centroid of b first.
    """

    def __init__(self, bodies: Bodies) -> None:
        self.bodies = bodies
        f, k = len(bodies.free), len(bodies.block_a)
        begins = np.ones(k, dtype=bool)
        begins[1:] = (np.diff(bodies.block_a) != 0) | (np.diff(bodies.block_b) != 0)
        first, joint = np.flatnonzero(begins), np.cumsum(begins) - 1
        m = len(first)
        self.block_a, self.block_b = bodies.block_a[first], bodies.block_b[first]
        self.a, self.b = bodies.slot[self.block_a], bodies.slot[self.block_b]
        near, far = bodies.slot[bodies.block_b], bodies.slot[bodies.block_a]
        self.tangent = SparseTangent(near, far, joint, bodies.centroid[bodies.free])
        self.gather = [
            sparse.csr_matrix(
                (np.ones(int((slot >= 0).sum())), (slot[slot >= 0], np.flatnonzero(slot >= 0))),
                shape=(f, m),
            )
            for slot in (self.a, self.b)
        ]
        self.carry = np.tile(np.eye(6), (m, 1, 1))
        columns = (6 * joint[:, None, None] + np.arange(6)).repeat(3, axis=1)
        ends = np.arange(0, 18 * k + 1, 6)
        self.across = sparse.csr_matrix(
            (np.zeros(18 * k), columns.ravel(), ends), shape=(3 * k, 6 * m)
        )
        self.back = self.across.T  # of the same numbers

    def at(self, pose: BlockPositions, placed: Placed) -> None:
        """Renew the maps for a pose."""
        bodies, corner = self.bodies, np.arange(len(placed.gap))
        rows = corner_rows(bodies, pose, placed, corner, bodies.block_b, 1.0)
        self.across.data[:] = rows.ravel()
        # motion of a as if it were fixed to the centroid of b
        radius = bodies.radius[self.block_a]
        x, y, z = ((pose.place[self.block_b] - pose.place[self.block_a]) / radius[:, None]).T
        carry = self.carry
        carry[:, 0, 4], carry[:, 0, 5] = z, -y
        carry[:, 1, 3], carry[:, 1, 5] = -z, x
        carry[:, 2, 3], carry[:, 2, 4] = y, -x
        turned = bodies.radius[self.block_b] / radius
        carry[:, 3, 3] = carry[:, 4, 4] = carry[:, 5, 5] = turned
        self.tangent.at(rows, carry)

    def moved(self, motion: Floats) -> Floats:
        """As in :class:`DenseMaps`."""
        every = np.concatenate([motion, np.zeros((1, 6))])  # a support has the number -1
        joint = every[self.b] - (self.carry @ every[self.a, :, None])[:, :, 0]
        return np.asarray(self.across @ joint.ravel()).reshape(-1, 3)

    def wrench(self, force: Floats) -> Floats:
        """As in :class:`DenseMaps`."""
        on_b = np.asarray(self.back @ force.ravel()).reshape(-1, 6)
        on_a = (on_b[:, None] @ self.carry)[:, 0]
        return np.asarray(self.gather[1] @ on_b - self.gather[0] @ on_a)

    def factorise(self, tangent: Floats, weight: Floats) -> Callable[[Floats], Floats]:
        """As in :class:`DenseMaps`."""
        return self.tangent.factorise(tangent, weight)


def imposed(bodies: Bodies, pose: BlockPositions, placed: Placed, motion: Floats) -> Floats:
    """Local motion (k, 3) of b over a at each corner due to moving supports (n, 6).

    Rotations are multiplied by the radius of gyration, like those of the free blocks.
    """
    corner = np.arange(len(placed.gap))
    moving = np.where((bodies.slot < 0)[:, None], motion, 0.0)
    result = np.zeros((len(corner), 3))
    for block, sign in ((bodies.block_a, -1.0), (bodies.block_b, 1.0)):
        rows = corner_rows(bodies, pose, placed, corner, block, sign)
        result += np.einsum("kij,kj->ki", rows, moving[block])
    return result


Maps = DenseMaps | SparseMaps


def maps_of(bodies: Bodies) -> Maps:
    """Full matrices for few blocks, sparse ones for many."""
    return DenseMaps(bodies) if len(bodies.free) <= DENSE else SparseMaps(bodies)


def corner_rows(
    bodies: Bodies,
    pose: BlockPositions,
    placed: Placed,
    corner: Ints,
    block: Ints,
    sign: Floats | float,
) -> Floats:
    """(c, 3, 6) local motion of a corner per translation and rotation by radius of its block."""
    axes = placed.axes[corner]
    arm = (placed.point[corner] - pose.place[block]) / bodies.radius[block, None]
    out = np.empty((len(corner), 3, 6))
    out[:, :, :3] = axes
    x, y, z = arm.T[:, :, None]
    u, v, w = axes[:, :, 0], axes[:, :, 1], axes[:, :, 2]
    out[:, :, 3] = y * w - z * v
    out[:, :, 4] = z * u - x * w
    out[:, :, 5] = x * v - y * u
    out *= sign
    return out
