import numpy as np
import pytest

from drystone import InputError
from drystone.shells import (
    Patch,
    barrel_vault,
    dome,
    patch_from_function,
    patch_from_grid,
    patch_from_sections,
)
from drystone.shells.patch import curvatures

LINE = [(0.0, 0.0, 0.0), (0.0, 3.0, 0.0)]


def test_normals_of_a_dome_are_radial_and_look_outwards():
    patch = dome(5.0, 1.0).patches[0]
    u, v = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 9), indexing="ij")
    assert np.allclose(patch.normal(u, v), patch.point(u, v) / 5.0, atol=1e-9)


def test_normals_do_not_depend_on_the_direction_of_u():
    patch = barrel_vault(6.0, 4.0).patches[0]
    other = Patch(lambda u, v: patch.function(1.0 - u, v))
    assert np.allclose(patch.normal(0.3, 0.5), other.normal(0.7, 0.5), atol=1e-9)


def test_curvatures_of_a_sphere_and_a_cylinder():
    sphere = curvatures(dome(5.0, 1.0).patches[0], 0.4, 0.3)
    cylinder = curvatures(barrel_vault(6.0, 4.0).patches[0], 0.4, 0.3)
    assert np.allclose(sphere, 0.2, atol=1e-4)
    assert np.allclose(cylinder, [0.0, 1.0 / 3.0], atol=1e-4)


def test_a_grid_patch_runs_through_its_points():
    x, y = np.meshgrid(np.linspace(0, 3, 5), np.linspace(0, 2, 6), indexing="ij")
    grid = np.stack([x, y, np.random.default_rng(3).uniform(0, 0.2, (5, 6))], axis=-1)
    patch = patch_from_grid(grid)
    u, v = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 6), indexing="ij")
    assert np.allclose(patch.point(u, v), grid)


def test_a_closed_grid_is_smooth_where_it_closes():
    angle = np.linspace(0.0, 2.0 * np.pi, 33)
    ring = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    grid = np.stack([ring * [3.0 - 0.4 * k, 3.0 - 0.4 * k, 1.0] + [0, 0, k] for k in range(5)])
    patch = patch_from_grid(grid, closed=True)
    before, after = patch.normal(0.5, 1.0 - 1e-6), patch.normal(0.5, 1e-6)
    assert np.linalg.norm(before - after) < 1e-4


def test_a_break_keeps_a_corner_sharp():
    grid = np.zeros((4, 5, 3))
    grid[..., 0] = np.arange(4)[:, None]
    grid[..., 1] = np.arange(5)
    grid[..., 2] = -np.abs(np.arange(5) - 2.0)
    patch = patch_from_grid(grid, breaks=[2])
    assert np.allclose(patch.point(0.5, [0.3, 0.45, 0.6])[:, 2], [-0.8, -0.2, -0.4])


def test_a_loft_runs_through_its_sections():
    patch = patch_from_sections([LINE, [(1, 0, 1), (1, 3, 1)], [(2, 0, 0), (2, 3, 0)]])
    assert np.allclose(patch.point(0.5, 0.5), [1.0, 1.5, 1.0])


def test_a_folded_patch_is_refused():
    with pytest.raises(InputError, match=r"folded on itself near u 0\.38"):
        patch_from_function(lambda u, v: np.stack([np.sin(4.0 * u), v, 0.0 * u], axis=-1))


def test_a_patch_that_shrinks_to_a_line_is_refused():
    with pytest.raises(InputError, match="no tangent plane"):
        patch_from_function(lambda u, v: np.stack([u, 0.0 * v, 0.0 * u], axis=-1))


def test_a_function_that_is_not_finite_is_refused():
    with pytest.raises(InputError, match=r"not finite at u 0\.\d+"):
        patch_from_function(lambda u, v: np.stack([np.where(u > 0.5, u, np.nan), v, u], axis=-1))


@pytest.mark.parametrize("shape", [(3,), (1, 4, 3), (4, 4, 2)])
def test_a_control_grid_of_another_shape_is_refused(shape):
    with pytest.raises(InputError, match="control grid has shape"):
        patch_from_grid(np.zeros(shape))
