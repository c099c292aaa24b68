"""Block elimination against dense algebra."""

from weakref import ref

import numpy as np
import pytest

from drystone.base.errors import SolverError
from drystone.solvers.multifrontal import BlockOrdering, ordering_of


def random_system(count, width, rng, reach):
    """Points in space coupled with their neighbours; unsymmetric, diagonally dominant."""
    position = rng.uniform(size=(count, 3))
    distance = np.linalg.norm(position[:, None] - position[None], axis=2)
    row, column = np.nonzero(distance < reach)
    blocks = rng.normal(size=(len(row), width, width))
    blocks[row == column] += 3.0 * count * np.eye(width)
    dense = np.zeros((count, width, count, width))
    dense[row, :, column, :] = blocks
    return position, row, column, blocks, dense.reshape(count * width, count * width)


@pytest.mark.parametrize(
    ("count", "reach"), [(1, 1.0), (7, 0.8), (60, 0.3), (300, 0.15), (90, 0.0)]
)
def test_solution_is_that_of_the_dense_matrix(count, reach):
    rng = np.random.default_rng(count)
    position, row, column, blocks, dense = random_system(count, 3, rng, max(reach, 1e-9))
    factor = BlockOrdering(position, row, column, 3).factorise(blocks)
    right = rng.normal(size=(count, 3))
    assert np.allclose(dense @ factor.solve(right).ravel(), right.ravel(), atol=1e-9)


def test_blocks_in_single_precision_are_solved_to_six_digits():
    rng = np.random.default_rng(3)
    position, row, column, blocks, dense = random_system(120, 3, rng, 0.25)
    factor = BlockOrdering(position, row, column, 3).factorise(blocks.astype(np.float32))
    right = rng.normal(size=(120, 3))
    x = factor.solve(right)
    assert x.dtype == np.float64
    np.testing.assert_allclose(dense @ x.ravel(), right.ravel(), atol=1e-5)


@pytest.mark.parametrize("last", range(59))
def test_parts_that_nothing_couples_are_solved_side_by_side(last):
    # a chain of 60 nodes, broken after one of them: some part ends where no separator is
    link = np.delete(np.arange(59), last)
    row = np.concatenate([np.arange(60), link, link + 1])
    column = np.concatenate([np.arange(60), link + 1, link])
    blocks = np.where(row == column, 4.0, -1.0)[:, None, None]
    position = np.column_stack([np.arange(60.0), np.zeros(60), np.zeros(60)])
    dense = np.zeros((60, 60))
    dense[row, column] = blocks[:, 0, 0]
    x = BlockOrdering(position, row, column, 1).factorise(blocks).solve(np.ones((60, 1)))
    np.testing.assert_allclose(dense @ x.ravel(), 1.0, atol=1e-12)


def test_the_order_of_a_small_graph_depends_on_no_position():
    rng = np.random.default_rng(9)
    position, row, column, blocks, _ = random_system(150, 3, rng, 0.25)
    right = rng.normal(size=(150, 3))
    alone = BlockOrdering(position, row, column, 3).factorise(blocks).solve(right)
    for place in (position, rng.uniform(size=(150, 3))):
        found = ordering_of(place, row, column, 3).factorise(blocks).solve(right)
        np.testing.assert_array_equal(found, alone)


def test_the_order_of_a_large_graph_is_made_once_for_one_check_after_another():
    position, row, column, _, _ = random_system(401, 3, np.random.default_rng(7), 0.1)
    made = ref(ordering_of(position, row, column, 3))
    assert ordering_of(position.copy(), row.copy(), column, 3) is made()
    assert ordering_of(position + 1.0, row, column, 3) is not made()


def test_later_factors_change_no_earlier_ones():
    rng = np.random.default_rng(8)
    position, row, column, blocks, _ = random_system(300, 3, rng, 0.25)
    ordering, right = BlockOrdering(position, row, column, 3), rng.normal(size=(300, 3))
    first = ordering.factorise(blocks)
    expected = first.solve(right)
    second = ordering.factorise(2.0 * blocks)
    assert np.array_equal(first.solve(right), expected)
    np.testing.assert_allclose(second.solve(right), expected / 2.0, rtol=1e-12)


def test_every_node_is_eliminated_once_after_all_its_children():
    rng = np.random.default_rng(5)
    position, row, column, _, _ = random_system(200, 1, rng, 0.2)
    fronts = BlockOrdering(position, row, column, 1).fronts
    pivots = np.concatenate([front.pivots for front in fronts])
    assert sorted(pivots.tolist()) == list(range(200))
    seen: set[int] = set()
    for front in fronts:
        assert not seen & set(front.boundary.tolist())
        seen |= set(front.pivots.tolist())


def test_points_on_top_of_each_other_are_still_divided():
    count = 100
    row = np.concatenate([np.arange(count), np.arange(count - 1), np.arange(1, count)])
    column = np.concatenate([np.arange(count), np.arange(1, count), np.arange(count - 1)])
    blocks = np.where(row == column, 4.0, -1.0)[:, None, None]
    ordering = BlockOrdering(np.zeros((count, 3)), row, column, 1)
    x = ordering.factorise(blocks).solve(np.ones((count, 1)))
    assert np.allclose(4.0 * x[1:-1] - x[:-2] - x[2:], 1.0)


def test_a_singular_matrix_is_an_error_with_the_front_named():
    index = np.arange(4)
    ordering = BlockOrdering(np.eye(4)[:, :3], index, index, 2)
    with pytest.raises(SolverError, match="singular"):
        ordering.factorise(np.zeros((4, 2, 2)))


def test_a_long_grid_is_cut_across_its_few_nodes_however_far_apart_they_are():
    # 4 columns at a distance of 100, 64 rows at a distance of 1
    x, y = (each.ravel() for each in np.meshgrid(np.arange(4), np.arange(64), indexing="ij"))
    near = np.abs(x[:, None] - x) + np.abs(y[:, None] - y) <= 1
    row, column = np.nonzero(near)
    position = np.column_stack([100.0 * x, y, np.zeros(256)])
    ordering = BlockOrdering(position, row, column, 6)
    assert max(len(front.boundary) for front in ordering.fronts) == 4
