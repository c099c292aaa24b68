import numpy as np
import pytest

from drystone.shells import planarise
from tests.oracle import largest_warp


def crumpled(rows=6, columns=7, seed=1):
    """A hexagon-free test case: quadrilaterals of a bumpy net, with every other corner shared."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(columns, dtype=float), np.arange(rows, dtype=float))
    point = np.stack([x, y, 0.3 * np.sin(x) + 0.05 * rng.standard_normal(x.shape)], axis=-1)
    number = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack(
        [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1
    ).reshape(-1, 4)
    return point.reshape(-1, 3), [tuple(q) for q in quads.tolist()]


def test_planar_polygons_stay_where_they_are():
    points, quads = crumpled()
    points[:, 2] = 0.4 * points[:, 0] - 0.1 * points[:, 1]
    moved, report = planarise(points, quads, scale=1.0)
    assert np.array_equal(moved, points)
    assert (report.steps, report.drift) == (0, 0.0)


def test_every_polygon_becomes_planar_and_stays_near():
    points, quads = crumpled()
    moved, report = planarise(points, quads, scale=1.0)
    assert report.reached
    assert report.warp_before > 1e-2
    assert largest_warp(moved, quads) < 1e-10
    assert report.drift < 5.0 * report.warp_before


def test_the_report_is_of_the_points_returned():
    points, quads = crumpled()
    moved, report = planarise(points, quads, scale=2.0)
    assert np.isclose(report.warp_before, largest_warp(points, quads) / 2.0)
    assert np.isclose(report.drift, np.linalg.norm(moved - points, axis=1).max() / 2.0)


def test_few_steps_reach_the_tolerance():
    points, quads = crumpled()
    _, report = planarise(points, quads, scale=1.0)
    assert report.reached
    assert report.steps <= 8


def test_polygons_of_many_corners_become_planar():
    rng = np.random.default_rng(4)
    angle = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), 0.05 * rng.standard_normal(8)], axis=1)
    moved, report = planarise(ring, [tuple(range(8))], scale=1.0)
    assert report.reached
    assert np.linalg.matrix_rank(moved - moved.mean(axis=0), tol=1e-8) == 2


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_the_result_scales_with_the_lengths(factor):
    points, quads = crumpled()
    one, _ = planarise(points, quads, scale=1.0)
    other, _ = planarise(factor * points, quads, scale=factor)
    assert np.allclose(other, factor * one, rtol=0.0, atol=1e-8 * factor)
