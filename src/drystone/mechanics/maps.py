"""Motions of corners by those of blocks, wrenches by corner forces, and the tangent ``A D A'``.

A motion of a block is its translation, and its rotation times a length of the block; a wrench is a
force, and a moment divided by that length. Few blocks have full matrices. For many the corners of
two blocks are first summed about the centroid of the smaller one, then taken to that of the other:
to take a wrench to a smaller block loses digits.
"""

from __future__ import annotations

from threading import local

import numpy as np
from scipy.sparse import csr_matrix

from drystone.base.arrays import Floats, Ints, cross
from drystone.base.errors import SolverError
from drystone.base.ragged import runs_by_length
from drystone.geometry.frames import skew
from drystone.solvers.factors import Refined, Solve, inverse
from drystone.solvers.multifrontal import ordering_of

FULL = 12_000
"""Corners, times the square of the number of free blocks, up to which matrices are full. Measured:
an increment takes as long with sparse ones there; with full ones a third of that at 6 blocks of 32
corners, and seven times as long at 16 blocks of 1,200 corners."""

SINGLE_FROM = 200
"""Free blocks from which on factors have single precision: fewer gain no time."""

FAINT = 1e-16
"""Number of a matrix in single precision below which it is left out: products of such numbers are
denormal, which processors multiply slowly. Measured: factors of a dome of 2,000 blocks take 38 ms
in place of 60 to 83, its check 0.55 of the time, tilted by 28 degrees 0.7, in as many steps."""


class FullMaps:
    """The maps of few blocks, as a full matrix.

    Parameters
    ----------
    block_a, block_b : (k,) free numbers of the blocks of each corner, -1 for a support
    count
        Number of free blocks, n.
    """

    def __init__(self, block_a: Ints, block_b: Ints, count: int) -> None:
        self.shape = 3 * len(block_a), 6 * count
        both = np.concatenate([block_a, block_b])
        self.meets = np.flatnonzero(both >= 0)
        row = 3 * (self.meets % max(len(block_a), 1))[:, None] + np.arange(3)
        column = 6 * both[self.meets][:, None] + np.arange(6)
        self.place = 6 * count * row[:, :, None] + column[:, None]
        self.rows = np.zeros(self.shape)

    def at(self, axes: Floats, arm_a: Floats, arm_b: Floats) -> None:
        """Give the maps, or renew them.

        Parameters
        ----------
        axes : (k, 3, 3) rows n, u, v
        arm_a, arm_b : (k, 3)
            From the centroids of a and b to the corner, by the lengths of the blocks.
        """
        parts = corner_rows(axes, np.array([arm_a, arm_b]))
        parts[0] *= -1.0
        self.rows.reshape(-1)[self.place] = parts.reshape(-1, 3, 6)[self.meets]

    def moved(self, motion: Floats) -> Floats:
        """A'q: local motion (k, 3) of b over a at each corner, from motions (n, 6)."""
        return (self.rows @ motion.ravel()).reshape(-1, 3)

    def wrench(self, force: Floats) -> Floats:
        """A f: wrenches (n, 6) of corner forces (k, 3) on the free blocks."""
        return (force.ravel() @ self.rows).reshape(-1, 6)

    def factorise(self, tangent: Floats, weight: Floats, rough: bool = True) -> Solve:
        """The inverse of ``A D A' + W``, of D (k, 3, 3) and weights, see :func:`times`.

        ``rough``: whether the factors may have fewer digits. Those of few blocks have all.

        Raises
        ------
        SolverError
            The matrix is singular.
        """
        del rough
        size = self.shape[1]
        matrix = self.rows.T @ (tangent @ self.rows.reshape(-1, 3, size)).reshape(-1, size)
        if weight.ndim == 2:
            matrix.reshape(-1)[:: size + 1] += weight.ravel()
        else:
            at = np.arange(len(weight))
            matrix.reshape(len(at), 6, -1, 6)[at, :, at] += weight
        return inverse(matrix)


class SparseMaps:
    """The maps of many blocks, by the blocks of the tangent that are not zero.

    Corners of the same two blocks that follow each other are one joint. They have rows for the
    motion of the near, smaller block; that of the far one is carried to it.

    Parameters
    ----------
    block_a, block_b : (k,) free numbers of the blocks of each corner, -1 for a support
    length : (n,) by which motions and wrenches of the free blocks are scaled
    position : (n, 3) of the free blocks, for the order of elimination
    """

    def __init__(self, block_a: Ints, block_b: Ints, length: Floats, position: Floats) -> None:
        n, k = len(position), len(block_a)
        self.count = n
        begins = np.ones(k, dtype=bool)
        begins[1:] = (np.diff(block_a) != 0) | (np.diff(block_b) != 0)
        self.first, joint = np.flatnonzero(begins), np.cumsum(begins) - 1
        m = len(self.first)
        sizes = np.append(length, np.inf)  # a support has the number -1
        self.swapped = sizes[block_a] < sizes[block_b]
        near = np.where(self.swapped, block_a, block_b)[self.first]
        far = np.where(self.swapped, block_b, block_a)[self.first]
        self.ratio = np.ones(m)
        np.divide(sizes[near], sizes[far], out=self.ratio, where=far >= 0)
        self.runs, self.joint = runs_by_length(self.first, k), joint
        self.near, self.far = near, far
        # that of supports goes to one more block
        self.place = (6 * np.append(near, far) + np.arange(6)[:, None]).ravel()
        self.place[self.place < 0] += 6 * (n + 1)
        row, column, source, kind = _pattern(far, near)
        key = np.concatenate([np.arange(n) * (n + 1), row * n + column])
        unique, where = np.unique(key, return_inverse=True)
        self.row, self.column = unique // n, unique % n
        self.diagonal = where[:n]
        order = np.argsort(where[n:], kind="stable")
        ends = np.append(0, np.cumsum(np.bincount(where[n:], minlength=len(unique))))
        # a sum as a sparse product: ten times as fast as reduceat
        shape = len(unique), 4 * m
        self.of_block = csr_matrix((np.ones(len(order)), (kind * m + source)[order], ends), shape)
        self.ordering = ordering_of(position, self.row, self.column, 6)
        self.memory = _Memory(m, k)

    def at(self, axes: Floats, arm_a: Floats, arm_b: Floats) -> None:
        """As for few blocks."""
        swapped = self.swapped[:, None]
        near_arm, far_arm = np.where(swapped, arm_a, arm_b), np.where(swapped, arm_b, arm_a)
        rows = corner_rows(axes, near_arm)
        rows[self.swapped] *= -1.0
        apart = far_arm[self.first] - self.ratio[:, None] * near_arm[self.first]
        self.carry = np.tile(np.eye(6), (len(self.first), 1, 1))
        self.carry[:, :3, 3:] = -skew(apart)
        self.carry[:, 3:, 3:] *= self.ratio[:, None, None]
        # joints, and corners, side by side
        self.carried = np.ascontiguousarray(self.carry.transpose(1, 2, 0))
        self.gather = np.ascontiguousarray(rows.transpose(1, 2, 0))
        self.groups = [
            (joints, corners, rows[corners].reshape(len(joints), -1, 6).swapaxes(1, 2))
            for joints, corners in self.runs
        ]

    def moved(self, motion: Floats) -> Floats:
        """As for few blocks."""
        still = np.zeros((6, len(motion) + 1))  # the last one is that of supports
        still[:, :-1] = motion.T
        far = still.take(self.far, axis=1)
        over = still.take(self.near, axis=1) - np.einsum("ijm,jm->im", self.carried, far)
        return np.einsum("ijk,jk->ik", self.gather, over.take(self.joint, axis=1)).T

    def wrench(self, force: Floats) -> Floats:
        """As for few blocks."""
        of_corner = np.einsum("ijk,ik->jk", self.gather, np.ascontiguousarray(force.T))
        count, m = self.count, len(self.first)
        both = np.empty((6, 2 * m))
        near = np.add.reduceat(of_corner, self.first, axis=1, out=both[:, :m])
        np.negative(np.einsum("ijm,im->jm", self.carried, near), out=both[:, m:])
        found = np.bincount(self.place, both.ravel(), 6 * (count + 1)).reshape(-1, 6)
        return np.asarray(found[:count], dtype=np.float64)

    def factorise(self, tangent: Floats, weight: Floats, rough: bool = True) -> Solve:
        """As for few blocks. Rough factors of many have single precision; solutions are refined."""

        def product(motion: Floats) -> Floats:
            local = np.einsum("kij,kj->ki", tangent, self.moved(motion))
            return self.wrench(local) + times(weight, motion)

        def exact() -> Solve:
            return self.ordering.factorise(self.blocks(tangent, weight), rough).solve

        if len(weight) < SINGLE_FROM or not rough:
            return exact()
        try:
            blocks = self.blocks(tangent, weight).astype(np.float32)
            blocks[np.abs(blocks) < FAINT] = 0.0
            return Refined(self.ordering.factorise(blocks).solve, product, exact)
        except SolverError:  # singular to so few digits
            return exact()

    def blocks(self, tangent: Floats, weight: Floats) -> Floats:
        """Matrix blocks (e, 6, 6) for D (k, 3, 3) and weights of the blocks."""
        # corners side by side: products of small matrices, one by one, take twice as long
        parts, local = self.memory.parts, self.memory.local
        np.einsum("kij,jlk->kil", tangent, self.gather, out=local)
        for joints, corners, spread in self.groups:
            parts[3, joints] = spread @ local[corners].reshape(len(joints), -1, 6)
        np.matmul(self.carry.swapaxes(1, 2), parts[3], out=parts[1])
        np.matmul(parts[1], self.carry, out=parts[0])
        np.matmul(parts[3], self.carry, out=parts[2])
        np.negative(parts[1:3], out=parts[1:3])
        out: Floats = (self.of_block @ parts.reshape(-1, 36)).reshape(-1, 6, 6)
        if weight.ndim == 2:
            out.reshape(-1, 36)[self.diagonal, ::7] += weight
        else:
            out[self.diagonal] += weight
        return out


class _Memory(local):
    """Numbers of a product, kept for each thread.

    Pages that are new each time take two thirds of it. Measured: the first check of the Armadillo
    vault with all stiffnesses in a process takes 0.33 s in place of 0.36, of a wall of 2,000 blocks
    1.13 in place of 1.23.

    Attributes
    ----------
    parts : (4, m, 6, 6)
    local : (k, 3, 6)
    """

    def __init__(self, joints: int, corners: int) -> None:
        self.parts = np.empty((4, joints, 6, 6))
        self.local = np.empty((3, 6, corners)).transpose(2, 0, 1)  # corners side by side


Maps = FullMaps | SparseMaps


def times(weight: Floats, motion: Floats) -> Floats:
    """Wrenches (n, 6) by motions (n, 6): of weights (n, 6, 6), or of diagonal ones (n, 6)."""
    return weight * motion if weight.ndim == 2 else (weight @ motion[:, :, None])[:, :, 0]


def maps_between(block_a: Ints, block_b: Ints, length: Floats, position: Floats) -> Maps:
    """Full matrices for few blocks, sparse ones for many; see :class:`SparseMaps`."""
    if len(block_a) * len(length) ** 2 <= FULL:
        return FullMaps(block_a, block_b, len(length))
    return SparseMaps(block_a, block_b, length, position)


def corner_rows(axes: Floats, arm: Floats) -> Floats:
    """(..., k, 3, 6) local motion of corners with axes (k, 3, 3) by the motion of a block.

    ``arm`` (..., k, 3) goes from the centroid of a block to the corner, by the length of the block.
    """
    out = np.empty((*arm.shape, 6))
    out[..., :3] = axes
    cross(arm[..., None, :], axes, out[..., 3:])
    return out


def _pattern(a: Ints, b: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Row, column, joint and kind (aa, ab, ba, bb) of every matrix block that joints fill."""
    pairs = np.array([(a, a), (a, b), (b, a), (b, b)])
    kind, joint = np.nonzero((pairs >= 0).all(axis=1))
    return pairs[kind, 0, joint], pairs[kind, 1, joint], joint, kind
