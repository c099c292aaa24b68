"""Elimination of one dense front, and the factors of all fronts.

Fronts are C-ordered arrays of the transposed matrix: column by column in memory, as LAPACK takes
them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg.blas import dgemm, dsyrk, dtrsm, dtrsv, sgemm
from scipy.linalg.lapack import dgetrf, dgetrs, dpotrf, sgetrf, sgetrs

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import SolverError

Precision = type[np.float64] | type[np.float32]
"""Of the numbers in a factorisation."""


class Routines(NamedTuple):
    """BLAS and LAPACK for one type of number."""

    gemm: Callable[..., Any]
    getrf: Callable[..., Any]
    getrs: Callable[..., Any]


ROUTINES: dict[Precision, Routines] = {
    np.float64: Routines(dgemm, dgetrf, dgetrs),
    np.float32: Routines(sgemm, sgetrf, sgetrs),
}


class Run(NamedTuple):
    """Nodes that follow each other both in the boundary of a front and in the next front.

    Attributes
    ----------
    inner
        Whether they are eliminated in the next front.
    here, there
        Place in the boundary, and among the pivots or in the boundary of the next front. Places
        are those of matrix rows: slices, or indices where the nodes are scattered.
    """

    inner: bool
    here: slice
    there: slice | Ints


@dataclass(frozen=True, eq=False)
class Front:
    """One dense step of the elimination.

    Attributes
    ----------
    pivots, boundary
        Nodes eliminated here, and later nodes that they are coupled with.
    children
        Earlier fronts, with the place of their boundary in this front.
    own_rows, later_rows
        Places of the pivots and of the boundary among all rows, in the order of elimination.
    """

    pivots: Ints
    boundary: Ints
    children: tuple[tuple[int, tuple[Run, ...]], ...]
    own_rows: slice
    later_rows: Ints


class BlockFactor:
    """Triangular factors of all fronts of a matrix, as :func:`eliminated` gives them.

    ``order`` has the nodes in the order of elimination.
    """

    def __init__(
        self,
        fronts: Sequence[Front],
        order: Ints,
        factors: list[tuple[Any, ...]],
        precision: Precision,
    ) -> None:
        self.fronts = fronts
        self.order = order
        self.factors = factors
        self.precision = precision

    def solve(self, right: Floats) -> Floats:
        """X (n, w) with ``matrix @ x = right``."""
        getrs = ROUTINES[self.precision].getrs
        x: Any = right[self.order].astype(self.precision, copy=False).ravel()
        for front, (lu, pivots, below, _) in zip(self.fronts, self.factors, strict=True):
            part = x[front.own_rows] = getrs(lu, pivots, x[front.own_rows])[0]
            if len(front.boundary):
                x[front.later_rows] -= below @ part
        backwards = zip(self.fronts[::-1], self.factors[::-1], strict=True)
        for front, (_, _, _, coupling) in backwards:
            if len(front.boundary):
                x[front.own_rows] -= coupling @ x[front.later_rows]
        return _in_order(x, self.order, right)


class SymmetricFactor:
    """Cholesky factors of all fronts of a matrix, as :func:`eliminated_symmetric` gives them.

    ``order`` has the nodes in the order of elimination.
    """

    def __init__(
        self, fronts: Sequence[Front], order: Ints, factors: list[tuple[Any, ...]]
    ) -> None:
        self.fronts = fronts
        self.order = order
        self.factors = factors

    def solve(self, right: Floats) -> Floats:
        """X (n, w) with ``matrix @ x = right``."""
        x = right[self.order].astype(np.float64, copy=False).ravel()
        for front, (root, multiple) in zip(self.fronts, self.factors, strict=True):
            part = x[front.own_rows] = dtrsv(root, x[front.own_rows], lower=1)
            if len(front.boundary):
                x[front.later_rows] -= multiple @ part
        backwards = zip(self.fronts[::-1], self.factors[::-1], strict=True)
        for front, (root, multiple) in backwards:
            part = x[front.own_rows]
            if len(front.boundary):
                part = part - x[front.later_rows] @ multiple
            x[front.own_rows] = dtrsv(root, part, lower=1, trans=1)
        return _in_order(x, self.order, right)


def _in_order(x: Floats, order: Ints, like: Floats) -> Floats:
    """The rows x, in the order of elimination, by node (n, w)."""
    solved = np.empty(like.shape)
    solved[order] = x.reshape(like.shape)
    return solved


def eliminated(
    first: Floats, right: Floats, below: Floats, rest: Floats
) -> tuple[tuple[Any, ...], Floats]:
    """Factors of a front, and what it adds to later ones; the parts are overwritten.

    Raises
    ------
    SolverError
        The pivots are exactly singular.
    """
    routine = ROUTINES[first.dtype.type]
    lu, pivots, info = routine.getrf(first.T, overwrite_a=True)
    if info != 0:
        raise SolverError("singular")
    coupling = right.T
    if len(rest):
        coupling, _ = routine.getrs(lu, pivots, coupling, overwrite_b=True)
        rest = routine.gemm(-1.0, below.T, coupling, 1.0, rest.T, overwrite_c=True).T
    return (lu, pivots, below.T, coupling), rest


def eliminated_symmetric(
    first: Floats, below: Floats, rest: Floats
) -> tuple[tuple[Any, ...], Floats]:
    """As :func:`eliminated` of a symmetric front, of which only the upper half is read and changed.

    Raises
    ------
    SolverError
        The pivots are not positive definite.
    """
    root, info = dpotrf(first.T, lower=1, clean=0, overwrite_a=True)
    if info != 0:
        raise SolverError("not positive definite")
    multiple = below.T
    if len(rest):
        multiple = dtrsm(1.0, root, multiple, side=1, lower=1, trans_a=1, overwrite_b=True)
        rest = dsyrk(-1.0, multiple, beta=1.0, c=rest.T, lower=1, overwrite_c=True).T
    return (root, multiple), rest
