"""The equilibrium matrix: from forces at corners to wrenches on the blocks that meet there.

Its transpose gives the displacements of corners from the motions of blocks.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from drystone.base.arrays import Floats, Ints


def transfer(frame: Floats, lever: Floats, block: Ints) -> Floats:
    """Wrench on a block per unit force at each corner (k, 6, 3): the axes, and lever x axis.

    Parameters
    ----------
    frame : (k, 3, 3) rows n, u, v
    lever : (k, 3) from the block's centroid to the corner
    block : (k,) number of the block, -1 for a fixed one: its entries are zero
    """
    axes = np.swapaxes(frame, 1, 2)
    out = np.empty((len(block), 6, 3))
    out[:, :3] = axes
    arm = lever[:, :, None]
    for i, j, m in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, 3 + i] = arm[:, j] * axes[:, m] - arm[:, m] * axes[:, j]
    out[block < 0] = 0.0
    return out


def sparse_rows(pair: Ints, transfers: Floats, count: int) -> sparse.csr_matrix:
    """A^T (3 k, 6 n): three rows for each corner, with six numbers for each free block there.

    Parameters
    ----------
    pair : (k, 2) numbers of the blocks of each corner, -1 for a fixed one
    transfers : (k, 2, 6, 3) wrench on each block per unit force
    count
        Number of free blocks, n.
    """
    k, shape = len(pair), (3 * len(pair), 6 * count)
    values = transfers.transpose(0, 3, 1, 2).copy()
    pair, descending = pair.copy(), np.flatnonzero(pair[:, 0] > pair[:, 1])
    pair[descending] = pair[descending, ::-1]
    values[descending] = values[descending, :, ::-1]
    wide = max(36 * k, *shape) >= 2**31
    index: np.dtype[np.signedinteger] = np.dtype(np.int64 if wide else np.int32)
    column = np.empty(values.shape, dtype=index)
    column[:] = (6 * pair[:, :, None] + np.arange(6))[:, None]
    meets = pair >= 0
    if not meets.all():
        kept = np.broadcast_to(meets[:, None], (k, 3, 2))
        values, column = values[kept], column[kept]
    start = np.zeros(3 * k + 1, dtype=index)
    np.cumsum(np.repeat(6 * meets.sum(axis=1), 3), out=start[1:])
    return sparse.csr_matrix((values.ravel(), column.ravel(), start), shape=shape)
