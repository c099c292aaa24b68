"""Elimination in a band against dense algebra."""

import numpy as np
import pytest

from drystone.base.errors import SolverError
from drystone.solvers.banded import Band
from drystone.solvers.multifrontal import BlockOrdering, ordering_of
from tests.unit.solvers.test_multifrontal import random_system


@pytest.mark.parametrize(("count", "reach"), [(1, 1.0), (7, 0.8), (60, 0.3), (90, 0.0)])
def test_solution_is_that_of_the_dense_matrix(count, reach):
    rng = np.random.default_rng(count)
    _, row, column, blocks, dense = random_system(count, 3, rng, max(reach, 1e-9))
    factor = Band(count, row, column, 3).factorise(blocks)
    right = rng.normal(size=(count, 3))
    assert np.allclose(dense @ factor.solve(right).ravel(), right.ravel(), atol=1e-9)


def test_a_pivot_of_another_node_is_taken_where_its_own_is_zero():
    pair = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    blocks = np.array([0.0, 2.0, 4.0, 0.0])[:, None, None]
    x = Band(2, *pair, 1).factorise(blocks).solve(np.array([[6.0], [8.0]]))
    np.testing.assert_array_equal(x, [[2.0], [3.0]])


def test_nodes_of_a_chain_in_any_order_have_a_narrow_band():
    order = np.random.default_rng(2).permutation(300)
    row = np.concatenate([order, order[1:], order[:-1]])
    column = np.concatenate([order, order[:-1], order[1:]])
    made = ordering_of(np.zeros((300, 3)), row, column, 6)
    assert isinstance(made, Band)
    assert made.reach == 11


def test_nodes_that_are_all_coupled_have_no_band():
    row, column = (each.ravel() for each in np.indices((30, 30)))
    assert isinstance(ordering_of(np.zeros((30, 3)), row, column, 6), BlockOrdering)


def test_a_singular_matrix_is_an_error():
    index = np.arange(4)
    with pytest.raises(SolverError, match="singular"):
        Band(4, index, index, 2).factorise(np.zeros((4, 2, 2)))
