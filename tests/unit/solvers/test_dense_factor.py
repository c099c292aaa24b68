import numpy as np
import pytest

from drystone.base.errors import SolverError
from drystone.solvers.factors import inverse


def test_the_solution_has_the_shape_of_the_right_side() -> None:
    rng = np.random.default_rng(0)
    matrix = rng.normal(size=(12, 12))
    right = rng.normal(size=(2, 6))
    solution = inverse(matrix.copy())(right)
    assert solution.shape == right.shape
    np.testing.assert_allclose(matrix @ solution.ravel(), right.ravel(), atol=1e-12)


def test_a_singular_matrix_is_refused() -> None:
    with pytest.raises(SolverError, match="singular"):
        inverse(np.zeros((3, 3)))
