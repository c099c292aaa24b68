"""The tangent ``A D A'`` of blocks on contact springs, assembled block by block.

The corners of an interface are first summed about the centroid of its smaller free block,
(m, 6, 6), then taken to that of the other one. The sparsity pattern is that of the contact graph;
it is computed once per model.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import SolverError
from drystone.base.ragged import runs_by_length
from drystone.geometry.frames import skew
from drystone.solvers.dense_factor import inverse
from drystone.solvers.multifrontal import BlockOrdering
from drystone.statics import Statics

SINGLE_FROM = 200
"""Free blocks from which on a rough step is computed in single precision: fewer gain no time."""

FULL = 60
"""Largest number of unknowns with a full matrix: from timings."""


SIDE_BY_SIDE = 8192
"""Corners whose maps are multiplied at once: from timings with 512 to all, at 4,800, 23,000 and
119,000 corners."""


class TangentSystem:
    """Assembles and factorises ``A D A' + diag(weight)`` for one model.

    Parameters
    ----------
    statics
    position : (n, 3) [m] of the free blocks, for the elimination order
    """

    def __init__(self, statics: Statics, position: Floats) -> None:
        self.statics = statics
        self.position = position

    @cached_property
    def sparse(self) -> SparseTangent:
        """The tangent by its blocks, for models that are not small."""
        statics, k = self.statics, self.statics.corner_count
        begins = np.ones(k, dtype=bool)
        np.not_equal(statics.interface[1:], statics.interface[:-1], out=begins[1:])
        # about the centroid of the smaller block: to take a wrench to a smaller one loses digits
        length = np.append(statics.length, np.inf)  # a support has the number -1
        a, b = statics.block_a, statics.block_b
        of_a = length[a] < length[b]
        near, far = np.where(of_a, a, b), np.where(of_a, b, a)
        lever = np.where(of_a[:, None], statics.lever_a, statics.lever_b)
        axes = np.swapaxes(statics.frame, 1, 2)
        rows = np.concatenate([axes, skew(lever) @ axes], axis=1).swapaxes(1, 2)
        first = np.flatnonzero(begins)
        ratio = np.ones(len(first))
        np.divide(length[near[first]], length[far[first]], out=ratio, where=far[first] >= 0)
        other = np.where(of_a[:, None], statics.lever_b, statics.lever_a)[first]
        made = SparseTangent(near, far, np.cumsum(begins) - 1, self.position)
        made.at(rows, _carry(other - ratio[:, None] * lever[first], ratio))
        return made

    @property
    def small(self) -> bool:
        """Whether the tangent is taken as a full matrix."""
        few = 6 * self.statics.free_count <= FULL
        return few and self.statics.full_transposed is not None

    def factorise(
        self, tangent: Floats, weight: Floats, *, rough: bool = False
    ) -> Callable[[Floats], Floats]:
        """From wrenches to motions (n, 6): the inverse of ``A D A' + diag(weight)``.

        ``rough``: of many blocks, single precision will do.

        Raises
        ------
        SolverError
            The matrix is singular.
        """
        few = self.statics.full_transposed
        if few is not None and self.small:
            return full_factors(few, tangent, weight)
        return self.sparse.factorise(tangent, weight, rough=rough)


def full_factors(rows: Floats, tangent: Floats, weight: Floats) -> Callable[[Floats], Floats]:
    """From wrenches to motions (n, 6), with full rows (3 k, 6 n) of few blocks.

    Parameters
    ----------
    rows
        Corner displacements by motions.
    tangent : (k, 3, 3)
    weight : (n, 6)
        On the diagonal.

    Raises
    ------
    SolverError
        The matrix is singular.
    """
    size = rows.shape[1]
    matrix = rows.T @ (tangent @ rows.reshape(-1, 3, size)).reshape(-1, size)
    matrix.reshape(-1)[:: size + 1] += weight.ravel()
    return inverse(matrix)


class _Parts(NamedTuple):
    """Memory of the parts of a tangent.

    Attributes
    ----------
    corner : (k, 3, 6)
    joint : (4, m, 6, 6)
    """

    corner: Floats
    joint: Floats


class SparseTangent:
    """The blocks of the tangent that are not zero, and their elimination order.

    Corners of a joint follow each other. Their motions are rows for the motion of one block of the
    joint, the near one; that of the far one is carried to it.

    Parameters
    ----------
    near, far : (k,) free numbers of the blocks of each corner, -1 for a support
    joint : (k,) in order, from 0
    position : (n, 3) of the free blocks, for the elimination order
    """

    def __init__(self, near: Ints, far: Ints, joint: Ints, position: Floats) -> None:
        n, k = len(position), len(joint)
        self.first = first = np.flatnonzero(np.diff(joint, prepend=-1))
        self.joints, self.count = len(first), n
        self.runs = runs_by_length(first, k)
        row, column, source, kind = _pattern(far[first], near[first])
        key = np.concatenate([np.arange(n) * (n + 1), row * n + column])
        unique, where = np.unique(key, return_inverse=True)
        self.row, self.column = unique // n, unique % n
        self.diagonal = where[:n]
        order = np.argsort(where[n:], kind="stable")
        ends = np.cumsum(np.bincount(where[n:], minlength=len(unique)))
        # a sum as a sparse product: ten times as fast as reduceat
        self.of_block = _sums(
            (kind * len(first) + source)[order], np.append(0, ends), (len(unique), 4 * len(first))
        )
        self.ordering = BlockOrdering(position, self.row, self.column, 6)
        self._free: list[_Parts] = []

    def at(self, rows: Floats, carry: Floats) -> None:
        """Give the maps, or renew them.

        Parameters
        ----------
        rows : (k, 3, 6)
            Motion of each corner by that of its near block.
        carry : (m, 6, 6)
            Motion of the near block that moves corners as a motion of the far one.
        """
        self.carry, self.back = carry, np.ascontiguousarray(carry.swapaxes(1, 2))
        self.gather = np.ascontiguousarray(rows.transpose(1, 2, 0))
        self.groups = [
            (joints, corners, rows[corners].reshape(len(joints), -1, 6).swapaxes(1, 2))
            for joints, corners in self.runs
        ]

    def factorise(
        self, tangent: Floats, weight: Floats, *, rough: bool = False
    ) -> Callable[[Floats], Floats]:
        """As :meth:`TangentSystem.factorise`."""
        blocks = self.blocks(tangent, weight)
        if rough and self.count >= SINGLE_FROM:
            try:
                return self.ordering.factorise(blocks.astype(np.float32)).solve
            except SolverError:
                pass  # singular only to so few digits
        return self.ordering.factorise(blocks).solve

    def blocks(self, tangent: Floats, weight: Floats) -> Floats:
        """Matrix blocks (e, 6, 6) for D (k, 3, 3) and a diagonal (n, 6)."""
        out = np.zeros((len(self.row), 6, 6))
        if self.joints:
            memory = self._memory()
            local, parts = memory
            self._gathered(tangent, local)
            for joints, corners, spread in self.groups:
                parts[3, joints] = spread @ local[corners].reshape(len(joints), -1, 6)
            np.matmul(self.back, parts[3], out=parts[1])
            np.matmul(parts[1], self.carry, out=parts[0])
            np.matmul(parts[3], self.carry, out=parts[2])
            np.negative(parts[1:3], out=parts[1:3])
            out = (self.of_block @ parts.reshape(-1, 36)).reshape(-1, 6, 6)
            self._free.append(memory)
        index = np.arange(6)
        out[self.diagonal[:, None], index, index] += weight
        return out

    def _gathered(self, tangent: Floats, out: Floats) -> None:
        """Write the products (k, 3, 6) of D (k, 3, 3) with the maps of its corners.

        The numbers of many corners lie side by side. It takes half of the time of a product of
        small matrices at 4,800 corners, seven tenths at 23,000, and as long at 119,000.
        """
        size = min(SIDE_BY_SIDE, len(tangent))
        row, term = np.empty((6, size)), np.empty((6, size))
        for begin in range(0, len(tangent), SIDE_BY_SIDE):
            part = slice(begin, begin + SIDE_BY_SIDE)
            entry = np.ascontiguousarray(tangent[part].transpose(1, 2, 0))
            count = entry.shape[2]
            total, more = row[:, :count], term[:, :count]
            for i in range(3):
                np.multiply(entry[i, 0], self.gather[0, :, part], out=total)
                for j in (1, 2):
                    np.multiply(entry[i, j], self.gather[j, :, part], out=more)
                    total += more
                out[part, i] = total.T

    def _memory(self) -> _Parts:
        """Memory that is kept for the next tangent, or new memory."""
        try:
            return self._free.pop()
        except IndexError:  # none is left, or another thread was faster
            corners = self.gather.shape[2]
            return _Parts(np.empty((corners, 3, 6)), np.empty((4, self.joints, 6, 6)))


def _sums(column: Ints, start: Ints, shape: tuple[int, int]) -> sparse.csr_matrix:
    """The matrix whose row i sums the entries ``column[start[i]:start[i + 1]]`` of a vector."""
    wide = max(len(column), *shape) >= 2**31
    index: np.dtype[np.signedinteger] = np.dtype(np.int64 if wide else np.int32)
    parts = np.ones(len(column)), column.astype(index), start.astype(index)
    return sparse.csr_matrix(parts, shape=shape)


def _carry(apart: Floats, ratio: Floats) -> Floats:
    """Motions (m, 6, 6) about one centroid that move corners as motions about another.

    Each block has its own unit of length, by which its lever arms and moments are divided.

    Parameters
    ----------
    apart : (m, 3) from the second centroid to the first, in the second unit
    ratio : (m,) first unit by the second
    """
    maps = np.tile(np.eye(6), (len(ratio), 1, 1))
    maps[:, :3, 3:] = -skew(apart)
    maps[:, 3:, 3:] *= ratio[:, None, None]
    return maps


def _pattern(a: Ints, b: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Row, column, interface and kind (aa, ab, ba, bb) of every block that interfaces fill."""
    rows, columns, sources, kinds = [], [], [], []
    for kind, (i, j) in enumerate(((a, a), (a, b), (b, a), (b, b))):
        here = np.flatnonzero((i >= 0) & (j >= 0))
        rows.append(i[here])
        columns.append(j[here])
        sources.append(here)
        kinds.append(np.full(len(here), kind, dtype=np.intp))
    return (
        np.concatenate(rows),
        np.concatenate(columns),
        np.concatenate(sources),
        np.concatenate(kinds),
    )
