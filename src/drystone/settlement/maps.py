"""Motions of corners by those of blocks, wrenches by corner forces, and the tangent matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse

from drystone.base.arrays import Floats, Ints
from drystone.base.ragged import runs_by_length
from drystone.settlement.bodies import Bodies
from drystone.settlement.springs import BlockPositions, Placed
from drystone.solvers.dense_factor import inverse
from drystone.solvers.multifrontal import BlockOrdering

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
        self.rows = rows
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
        matrix = self.flat.T @ (tangent @ self.rows).reshape(-1, self.width)
        matrix.reshape(-1)[:: self.width + 1] += weight.ravel()
        return inverse(matrix)


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
        self.first = first = np.flatnonzero(begins)
        self.joint = np.cumsum(begins) - 1
        self.groups = runs_by_length(first, k)
        m = len(first)
        self.block_a, self.block_b = bodies.block_a[first], bodies.block_b[first]
        self.a, self.b = a, b = bodies.slot[self.block_a], bodies.slot[self.block_b]
        keys, sources = [np.arange(f) * (f + 1)], []
        for kind, (i, j) in enumerate(((a, a), (a, b), (b, a), (b, b))):
            here = np.flatnonzero((i >= 0) & (j >= 0))
            keys.append(i[here] * f + j[here])
            sources.append(kind * m + here)
        unique, where = np.unique(np.concatenate(keys), return_inverse=True)
        source = np.concatenate(sources)
        self.diagonal = where[:f]
        self.sum = sparse.csr_matrix(
            (np.ones(len(source)), (where[f:], source)), shape=(len(unique), 4 * m)
        )
        self.ordering = BlockOrdering(bodies.centroid[bodies.free], unique // f, unique % f, 6)
        self.gather = [
            sparse.csr_matrix(
                (np.ones(int((slot >= 0).sum())), (slot[slot >= 0], np.flatnonzero(slot >= 0))),
                shape=(f, m),
            )
            for slot in (a, b)
        ]
        self.carry = np.tile(np.eye(6), (m, 1, 1))
        columns = (6 * self.joint[:, None, None] + np.arange(6)).repeat(3, axis=1)
        ends = np.arange(0, 18 * k + 1, 6)
        self.across = sparse.csr_matrix(
            (np.zeros(18 * k), columns.ravel(), ends), shape=(3 * k, 6 * m)
        )
        self.back = self.across.T  # of the same numbers
        self.parts = np.zeros((4, m, 6, 6))
        self.tangent: Floats | None = None  # that of the parts, unless the rows have changed

    def at(self, pose: BlockPositions, placed: Placed) -> None:
        """Renew the maps for a pose."""
        bodies, corner = self.bodies, np.arange(len(placed.gap))
        self.rows = corner_rows(bodies, pose, placed, corner, bodies.block_b, 1.0)
        self.across.data[:] = self.rows.ravel()
        self.tangent = None
        # motion of a as if it were fixed to the centroid of b
        radius = bodies.radius[self.block_a]
        x, y, z = ((pose.place[self.block_b] - pose.place[self.block_a]) / radius[:, None]).T
        carry = self.carry
        carry[:, 0, 4], carry[:, 0, 5] = z, -y
        carry[:, 1, 3], carry[:, 1, 5] = -z, x
        carry[:, 2, 3], carry[:, 2, 4] = y, -x
        turned = bodies.radius[self.block_b] / radius
        carry[:, 3, 3] = carry[:, 4, 4] = carry[:, 5, 5] = turned

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
        self._renew(tangent)
        blocks = np.asarray(self.sum @ self.parts.reshape(-1, 36)).reshape(-1, 6, 6)
        index = np.arange(6)
        blocks[self.diagonal[:, None], index, index] += weight
        return self.ordering.factorise(blocks).solve

    def _renew(self, tangent: Floats) -> None:
        """The stiffness of each joint. Where no tangent has changed it is that of the last time.

        Between two steps of Newton's method more than half of the joints of a vault do not change.
        """
        last, self.tangent = self.tangent, tangent
        if last is None:
            changed = np.ones(len(self.first), dtype=bool)
        else:
            differs = (tangent != last).any(axis=(1, 2))
            changed = np.logical_or.reduceat(differs, self.first)
        for joints, corners in self.groups:
            here = changed[joints]
            corner = corners.reshape(len(joints), -1)[here]
            rows = self.rows[corner]
            along = tangent[corner] @ rows
            shape = len(rows), 3 * corner.shape[1], 6
            back = rows.reshape(shape).swapaxes(1, 2)
            self.parts[3, joints[here]] = back @ along.reshape(shape)
        part, carry = self.parts[3, changed], self.carry[changed]
        back = carry.swapaxes(1, 2)
        on_a = -(part @ carry)
        self.parts[:3, changed] = -(back @ on_a), -(back @ part), on_a


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
