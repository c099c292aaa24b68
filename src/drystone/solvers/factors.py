"""Solutions from rough factors: iterative refinement.

Factors in single precision take half of the time and memory. What a solution with them leaves is
computed in double precision, and solved for again: each turn leaves a few thousandths of it.

Source: Wilkinson 1963; Carson and Higham 2018 (factors of low precision).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from drystone.base.arrays import Floats
from drystone.base.errors import SolverError

REFINED = 1e-5
"""What a solution may leave of its right side. Measured: without a turn 5e-5 is left in domes, 7e-4
in a wall of 100 courses and 7e-3 in one of 316. A wall of 48,510 blocks then takes 14 Newton steps,
and 10 with exact factors. With 1e-6 checks of twelve walls, domes and vaults of 400 to 2,000 blocks
take 1.05 times as long, and the same steps but two; with 1e-4 a wall of 410 takes 31 factorisations
in place of 25."""

SLOWLY = 0.3
"""What a turn leaves of what was left, from which on exact factors are sooner there: a turn takes
an eighth of the time of rough factors, exact ones one and a half times as long. Measured: most
turns leave 1e-3 to 1e-5."""

Solve = Callable[[Floats], Floats]
"""From right sides to solutions of the same shape."""


class Refined:
    """The inverse of a matrix.

    Parameters
    ----------
    rough
        An inverse with few digits.
    product
        The product with the matrix, in all digits.
    exact
        Makes an inverse with all digits; called once, where the rough one does not lead on.
    """

    def __init__(self, rough: Solve, product: Solve, exact: Callable[[], Solve]) -> None:
        self._inverse, self._product, self._exact = rough, product, exact
        self.leads = True

    def __call__(self, right: Floats) -> Floats:
        """The solution with a right side."""
        if not self.leads:
            return self._inverse(right)
        before = float(np.linalg.norm(right))
        goal, enough = REFINED * before, False
        solution, left = np.zeros_like(right), right
        while True:
            solution += self._inverse(left)
            if enough:
                return solution
            left = right - self._product(solution)
            size = float(np.linalg.norm(left))
            if size <= goal:
                return solution
            if not size < SLOWLY * before:
                self._inverse, self.leads = self._exact(), False
                return self._inverse(right)
            enough = size * size < SLOWLY * goal * before  # if it leaves as large a share again
            before = size


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
        return solution.reshape(right.shape)

    return solve
