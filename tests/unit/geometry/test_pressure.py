"""Peak pressure on sections that carry no tension."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from drystone.base.arrays import Floats
from drystone.geometry.kern import EDGE, edge_ratio, peak_pressure, sections

RECTANGLE = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [0.0, 3.0]])
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def peak(corners: Floats, normal: float, x: float, y: float) -> float:
    start = np.array([0, len(corners)])
    made = sections(corners, start)
    found = peak_pressure(made, corners, start, np.array([normal]), np.array([[x, y]]))
    return float(found[0])


def test_within_the_kern_the_pressure_is_that_of_a_section_that_could_pull() -> None:
    assert peak(RECTANGLE, 36.0, 3.0, 1.5) == pytest.approx(2.0)
    assert peak(RECTANGLE, 36.0, 3.5, 1.5) == pytest.approx(3.0)
    assert peak(RECTANGLE, 36.0, 4.0, 1.5) == pytest.approx(4.0)


@pytest.mark.parametrize("gap", [0.9, 0.5, 0.1, 1e-2, 1e-4, 1e-6])
def test_beyond_the_kern_a_rectangle_presses_three_times_the_distance_to_the_edge(
    gap: float,
) -> None:
    assert peak(RECTANGLE, 36.0, gap, 1.5) == pytest.approx(2.0 * 36.0 / (3.0 * gap * 3.0))
    assert peak(RECTANGLE, 36.0, 3.0, gap / 2) == pytest.approx(2.0 * 36.0 / (1.5 * gap * 6.0))


@pytest.mark.parametrize("gap", [0.2, 1e-2, 1e-4, 1e-6])
def test_near_a_corner_a_triangle_presses_four_times_the_distances(gap: float) -> None:
    # the centre of pressure of the pyramid over a right triangle is a quarter of its legs away
    legs = 4.0 * gap, 2.0 * gap
    expected = 3.0 / (0.5 * legs[0] * legs[1])
    assert peak(SQUARE, 1.0, gap, 0.5 * gap) == pytest.approx(expected, rel=1e-6)


def test_on_the_rim_the_pressure_is_infinite_and_without_compression_zero() -> None:
    assert peak(RECTANGLE, 1.0, 0.0, 1.5) == float("inf")
    assert peak(RECTANGLE, 1.0, -1.0, 1.5) == float("inf")
    assert peak(RECTANGLE, 1.0, 0.1 * EDGE, 1.5) == float("inf")
    assert peak(RECTANGLE, 0.0, 3.0, 1.5) == 0.0
    assert peak(RECTANGLE, -1.0, 3.0, 1.5) == 0.0
    assert peak(RECTANGLE[:2], 1.0, 3.0, 0.0) == float("inf")


def test_no_sections_have_no_pressure() -> None:
    none, start = np.zeros((0, 2)), np.array([0])
    assert len(peak_pressure(sections(none, start), none, start, np.zeros(0), none)) == 0


def moments(shape: Polygon) -> Floats:
    """Integral (3, 3) of y y', y = (1, x, y): fans of triangles with the rule of mid-points."""
    out = np.zeros((3, 3))
    for part in getattr(shape, "geoms", [shape]):
        ring = (
            np.array(part.exterior.coords)[:-1] if part.geom_type == "Polygon" else np.zeros((0, 2))
        )
        sign = 1.0 if len(ring) and part.exterior.is_ccw else -1.0
        for a, b in pairwise(ring[1:]):
            (ax, ay), (bx, by) = a - ring[0], b - ring[0]
            for middle in (0.5 * (ring[0] + a), 0.5 * (a + b), 0.5 * (ring[0] + b)):
                y = np.array([1.0, *middle])
                out += sign * (ax * by - ay * bx) / 6.0 * np.outer(y, y)
    return out


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.integers(3, 8), st.floats(-2.0, 0.0), st.integers(0, 10_000))
def test_random_polygons_convex_or_not_balance_the_force(
    count: int, depth: float, seed: int
) -> None:
    # choose the pressure, integrate it by another rule, and ask for it again
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, count))
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.3, 1.0, (count, 1))
    shape = Polygon(corners)
    if not shape.is_valid or shape.area < 1e-3:
        return
    turn = rng.uniform(0.0, 2.0 * np.pi)
    up, side = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    height = corners @ up
    largest = 10.0**depth * float(np.ptp(height))
    line = height.max() - largest
    half = Polygon(
        [line * up + 9 * side, line * up - 9 * side, 9 * up - 9 * side, 9 * up + 9 * side]
    )
    force = moments(shape.intersection(half)) @ np.array([-line, *up])
    if force[0] < 1e-9:
        return
    at = force[1:] / force[0]
    assert peak(corners, force[0], *at) == pytest.approx(largest, rel=1e-6)


def test_many_sections_at_once_equal_one_at_a_time() -> None:
    shapes = [RECTANGLE, SQUARE, RECTANGLE[::-1]]
    at = np.array([[0.5, 1.0], [0.2, 0.2], [0.5, 1.0]])
    corners, start = np.concatenate(shapes), np.array([0, 4, 8, 12])
    together = peak_pressure(sections(corners, start), corners, start, np.ones(3), at)
    alone = [peak(shape, 1.0, *where) for shape, where in zip(shapes, at, strict=True)]
    np.testing.assert_allclose(together, alone, rtol=1e-7)
    assert together[0] == pytest.approx(together[2])
    made = sections(corners, start)
    assert (edge_ratio(made, corners, start, at) < 1.0).all()
