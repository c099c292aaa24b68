"""Solutions from rough factors."""

import numpy as np
import pytest

from drystone.solvers.factors import Refined


def matrix_of(digits: float) -> np.ndarray:
    """A matrix whose condition number has so many digits."""
    rng = np.random.default_rng(0)
    turn, _ = np.linalg.qr(rng.normal(size=(40, 40)))
    return (turn * np.logspace(0.0, -digits, 40)) @ turn.T


def single(matrix):
    few = matrix.astype(np.float32)
    return lambda right: np.linalg.solve(few, right.astype(np.float32)).astype(float)


def never():
    raise AssertionError("rough factors lead on")


def test_a_solution_from_single_precision_leaves_a_millionth_at_most():
    matrix, right = matrix_of(4.0), np.random.default_rng(1).normal(size=40)
    found = Refined(single(matrix), lambda x: matrix @ x, never)(right)
    assert np.linalg.norm(right - matrix @ found) <= 1e-6 * np.linalg.norm(right)


@pytest.mark.parametrize("factor", [0.0, np.inf])
def test_exact_factors_are_made_once_where_rough_ones_do_not_lead_on(factor):
    matrix, made = matrix_of(4.0), []

    def exact():
        made.append(1)
        return lambda right: np.linalg.solve(matrix, right)

    with np.errstate(invalid="ignore"):
        inverse = Refined(lambda right: factor * right, lambda x: matrix @ x, exact)
        for seed in range(2):
            right = np.random.default_rng(seed).normal(size=40)
            np.testing.assert_allclose(matrix @ inverse(right), right, atol=1e-9)
    assert len(made) == 1
