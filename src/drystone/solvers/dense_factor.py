"""Factors of a full matrix."""

from __future__ import annotations

from collections.abc import Callable

from scipy.linalg.lapack import dgetrf, dgetrs

from drystone.base.arrays import Floats
from drystone.base.errors import SolverError


def inverse(matrix: Floats) -> Callable[[Floats], Floats]:
    """The solution of ``matrix @ x = right`` as a function of the right side.

    Parameters
    ----------
    matrix : (n, n)
        Row by row in memory; overwritten. A right side of any shape with n numbers is taken, and
        the solution has its shape.

    Raises
    ------
    SolverError
        The matrix is exactly singular.
    """
    # the factors are those of the transpose, so that nothing is copied
    lu, pivots, failed = dgetrf(matrix.T, overwrite_a=True)
    if failed:
        raise SolverError("the tangent is singular")

    def solve(right: Floats) -> Floats:
        solution, _ = dgetrs(lu, pivots, right.ravel(), trans=1)
        result: Floats = solution.reshape(right.shape)
        return result

    return solve


__all__ = ["inverse"]
