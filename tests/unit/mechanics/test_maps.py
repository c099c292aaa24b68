"""The tangent assembled block by block, against products of full matrices."""

import numpy as np
import pytest
from scipy import sparse

from drystone import Assembly, Model, models
from drystone.mechanics.maps import SparseMaps
from drystone.mechanics.statics import build_statics
from drystone.models import box


def stiffness(count, rng):
    """Tangents (k, 3, 3) of corners that stick, slide or are open; not symmetric."""
    tangent = np.zeros((count, 3, 3))
    tangent[:, 0, 0] = rng.random(count)
    tangent[:, 1:, 0] = 0.6 * rng.standard_normal((count, 2))
    tangent[:, 1:, 1:] = 0.2 * np.eye(2)
    tangent[rng.random(count) < 0.3] = 0.0
    return tangent


def sparse_maps(statics, rng):
    """The maps as those of many blocks."""
    position = rng.random((statics.free_count, 3))
    found = SparseMaps(statics.block_a, statics.block_b, statics.length, position)
    found.at(statics.frame, statics.lever_a, statics.lever_b)
    return found


def largest_error(model, seed=0):
    """Of each block of the tangent, by the largest number of the block; the largest of these."""
    statics = build_statics(model)
    rng = np.random.default_rng(seed)
    tangent = stiffness(statics.corner_count, rng)
    weight = 1e-3 * rng.random((statics.free_count, 6))
    system = sparse_maps(statics, rng)
    found = system.blocks(tangent, weight)
    matrix = statics.matrix
    blocks = sparse.block_diag([sparse.coo_array(one) for one in tangent])
    whole = matrix @ blocks @ matrix.T + sparse.diags_array(weight.ravel())
    n = statics.free_count
    exact = np.asarray(whole.todense()).reshape(n, 6, n, 6).transpose(0, 2, 1, 3)
    exact = exact[system.row, system.column]
    scale = np.abs(exact).max(axis=(1, 2))
    scale = np.where(scale > 0.0, scale, 1.0)
    return float((np.abs(found - exact).max(axis=(1, 2)) / scale).max())


@pytest.mark.parametrize(
    "model", [models.wall(3, 3), models.arch(0.15, 12), models.vault(), models.tower(5)]
)
def test_the_tangent_is_the_product_of_full_matrices(model):
    assert largest_error(Model.of(model, friction=0.6)) < 1e-12


@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("small_first", [True, False])
def test_a_small_block_on_a_large_one_costs_no_digits(size, small_first):
    ground = box((2.0, 2.0, 1.0), (-1.0, -1.0, -1.0), name="ground")
    large = box((1.0, 1.0, 1.0), (-0.5, -0.5, 0.0), name="large")
    small = box((size, size, size), (0.1, 0.2, 1.0), name="small")
    blocks = [ground, small, large] if small_first else [ground, large, small]
    model = Model.of(Assembly(blocks, np.array([True, False, False])), friction=0.6)
    assert len(model.contacts) == 2
    assert largest_error(model) < 1e-12


def test_a_tangent_stays_as_it_was_when_the_next_one_is_made():
    statics = build_statics(Model.of(models.vault(), friction=0.6))
    rng = np.random.default_rng(2)
    system = sparse_maps(statics, rng)
    given = [stiffness(statics.corner_count, rng) for _ in range(2)]
    weight = np.ones((statics.free_count, 6))
    first = system.blocks(given[0], weight)
    kept = first.copy()
    second = system.blocks(given[1], weight)
    np.testing.assert_array_equal(first, kept)
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("model", [models.arch(0.3, 5), models.vault(), models.dome(12, 4)])
def test_maps_between_blocks_and_corners_are_the_equilibrium_matrix(model):
    statics = build_statics(Model.of(model, friction=0.6))
    rng = np.random.default_rng(3)
    force = rng.standard_normal((statics.corner_count, 3))
    motion = rng.standard_normal((statics.free_count, 6))
    wrench, moved = statics.matrix @ force.ravel(), statics.matrix_transposed @ motion.ravel()
    for made in (statics.maps, sparse_maps(statics, rng)):
        np.testing.assert_allclose(made.wrench(force).ravel(), wrench, atol=1e-12)
        np.testing.assert_allclose(made.moved(motion).ravel(), moved, atol=1e-12)
