"""Direct solution of block-sparse systems with all numbers near the diagonal: arches, small models.

The order of Cuthill and McKee keeps nodes that are coupled near each other. The band is one matrix
of LAPACK with partial pivoting, without fronts that take tens of microseconds however small.

Source: Cuthill and McKee 1969.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from drystone.base.arrays import Floats, Ints, Singles
from drystone.base.errors import SolverError


class BandFactor(NamedTuple):
    """Factors of a band: what solves with them, and the rows (n, w) of each node in it."""

    substitute: Callable[[Floats], Floats]
    rows: Ints

    def solve(self, right: Floats) -> Floats:
        """X (n, w) with ``matrix @ x = right``."""
        ordered = np.empty(right.size)
        ordered[self.rows] = right
        return self.substitute(ordered)[self.rows]


class Band:
    """The place of every number of a matrix in its band, for a fixed graph.

    ``reach`` rows of it are on each side of the diagonal.

    Parameters
    ----------
    count
        Number of nodes, n.
    row, column : (e,) node pairs of the matrix blocks: (i, j), (j, i) and (i, i), once each
    width
        Rows per node.
    """

    def __init__(self, count: int, row: Ints, column: Ints, width: int) -> None:
        graph = coo_array((np.ones(len(row)), (row, column)), shape=(count, count))
        # the reverse is as wide; without it the steps of a wall of 10 courses are as with fronts
        order = reverse_cuthill_mckee(graph.tocsr(), symmetric_mode=True)[::-1]
        self.rows = np.empty((count, width), dtype=np.intp)
        self.rows[order] = np.arange(width * count).reshape(count, width)
        first, second = self.rows[row], self.rows[column]
        self.reach = int((first - second).max(initial=0)) + width - 1
        below = first + 2 * self.reach
        self.entry = below[:, :, None] + 3 * self.reach * second[:, None, :]

    def factorise(self, blocks: Floats | Singles, rough: bool = True) -> BandFactor:
        """Factors of the matrix with the given blocks (e, w, w), in double precision in any case.

        Raises
        ------
        SolverError
            The matrix is exactly singular.
        """
        del rough
        reach, size = self.reach, self.rows.size
        flat = np.zeros((3 * reach + 1) * size)
        flat[self.entry] = blocks
        lu, pivots, failed = dgbtrf(flat.reshape(size, -1).T, reach, reach, overwrite_ab=True)
        if failed:
            raise SolverError("the band of the elimination is singular")
        return BandFactor(lambda right: dgbtrs(lu, reach, reach, right, pivots)[0], self.rows)
