"""Moments of plane sections and their kern."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from drystone.base.arrays import Floats
from drystone.geometry.kern import (
    convex_hull,
    edge_ratio,
    kern,
    kern_ratio,
    sections,
)

RECTANGLE = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [0.0, 3.0]])
L_SHAPE = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]])


def one(corners: Floats) -> tuple[Floats, Floats]:
    return corners, np.array([0, len(corners)])


def test_moments_of_a_rectangle() -> None:
    made = sections(*one(RECTANGLE))
    assert made.area[0] == pytest.approx(18.0)
    np.testing.assert_allclose(made.centroid[0], [3.0, 1.5])
    np.testing.assert_allclose(made.inertia[0], np.diag([36.0 / 12.0, 9.0 / 12.0]), atol=1e-12)


def test_moments_of_a_concave_polygon_add_up_from_its_parts() -> None:
    made = sections(*one(L_SHAPE))
    low = sections(*one(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]])))
    high = sections(*one(np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]])))
    area = low.area[0] + high.area[0]
    centre = (low.area[0] * low.centroid[0] + high.area[0] * high.centroid[0]) / area
    inertia = sum(
        part.area[0]
        * (part.inertia[0] + np.outer(part.centroid[0] - centre, part.centroid[0] - centre))
        for part in (low, high)
    )
    np.testing.assert_allclose(made.centroid[0], centre)
    np.testing.assert_allclose(made.inertia[0], inertia / area, atol=1e-14)


def test_moments_do_not_depend_on_the_sense_of_rotation() -> None:
    forth, back = sections(*one(L_SHAPE)), sections(*one(L_SHAPE[::-1]))
    assert forth.area[0] == pytest.approx(back.area[0])
    np.testing.assert_allclose(forth.inertia, back.inertia, atol=1e-14)


def test_many_sections_at_once_equal_one_at_a_time() -> None:
    together = sections(np.concatenate([RECTANGLE, L_SHAPE]), np.array([0, 4, 10]))
    for i, shape in enumerate((RECTANGLE, L_SHAPE)):
        alone = sections(*one(shape))
        np.testing.assert_allclose(together.inverse[i], alone.inverse[0])


def test_kern_of_a_rectangle_is_the_rhombus_of_the_middle_thirds() -> None:
    np.testing.assert_allclose(
        kern(RECTANGLE), [[3.0, 2.0], [2.0, 1.5], [3.0, 1.0], [4.0, 1.5]], atol=1e-12
    )


def test_kern_of_a_circle_has_a_quarter_of_its_radius() -> None:
    angle = 2.0 * np.pi * np.arange(400) / 400
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    radius = np.linalg.norm(kern(circle), axis=1)
    np.testing.assert_allclose(radius, 0.25, atol=2e-5)


def test_kern_of_a_triangle_is_a_quarter_of_it() -> None:
    triangle = np.array([[0.0, 0.0], [4.0, 1.0], [1.0, 3.0]])
    centre = triangle.mean(axis=0)
    expected = centre + 0.25 * (triangle - centre)
    made = kern(triangle)
    for corner in expected:
        assert np.linalg.norm(made - corner, axis=1).min() < 1e-12


def test_kern_of_a_line_is_its_middle_third_and_of_a_point_itself() -> None:
    line = kern(np.array([[0.0, 0.0], [3.0, 3.0]]))
    np.testing.assert_allclose(line[np.argsort(line[:, 0])], [[1.0, 1.0], [2.0, 2.0]])
    np.testing.assert_allclose(kern(np.array([[2.0, 5.0]])), [[2.0, 5.0]])


@pytest.mark.parametrize("angle", [0.0, 90.0, 180.0, 37.0])
def test_a_hull_keeps_its_corners_whatever_their_rounding(angle: float) -> None:
    """The feet of a facade and its return walls: the corner (0, 0) was lost by 1e-15."""
    points = np.array([
        [6.0, 0.0], [6.0, 0.6], [1.3322676295501878e-15, 0.6], [8.881784197001252e-16, 0.0],
        [0.5, 0.6], [0.5, 2.1], [0.0, 2.1], [0.0, 0.6], [6.0, 2.1], [5.5, 2.1],
    ])  # fmt: skip
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turned = convex_hull(points @ [[c, s], [-s, c]]) @ [[c, -s], [s, c]]
    corners = {tuple(one) for one in turned.round(9) + 0.0}
    assert corners == {(0.0, 0.0), (6.0, 0.0), (6.0, 2.1), (0.0, 2.1)}


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(3, 9), st.integers(0, 10_000))
def test_a_force_on_the_rim_of_the_kern_leaves_one_side_without_pressure(
    count: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    hull = convex_hull(rng.normal(size=(count, 2)) * [1.0, 3.0] + 10.0)
    if len(hull) < 3 or Polygon(hull).area < 0.05:
        return
    made = sections(*one(hull))
    for pole in kern(hull):
        assert kern_ratio(made, *one(hull), pole[None])[0] == pytest.approx(1.0)
        pressure = 1.0 + (hull - made.centroid[0]) @ made.inverse[0] @ (pole - made.centroid[0])
        assert np.sort(pressure)[:2] == pytest.approx(0.0, abs=1e-9)
        assert Polygon(hull).contains(Polygon(kern(hull)).representative_point())


def test_ratios_are_zero_at_the_centroid_and_one_on_kern_and_rim() -> None:
    made = sections(*one(RECTANGLE))
    for x, inner, outer in ((3.0, 0.0, 0.0), (4.0, 1.0, 1.0 / 3.0), (6.0, 3.0, 1.0)):
        at = np.array([[x, 1.5]])
        assert kern_ratio(made, *one(RECTANGLE), at)[0] == pytest.approx(inner)
        assert edge_ratio(made, *one(RECTANGLE), at)[0] == pytest.approx(outer)


@pytest.mark.parametrize("more", [[3.0, 0.0], [6.0, 1e-15], [6.0, 0.0], [3.0, 1e-14]])
def test_edge_ratio_is_that_of_the_outline_whatever_corners_are_on_it(more: list[float]) -> None:
    """On a straight edge, twice, or off by rounding."""
    corners = np.insert(RECTANGLE, 1, more, axis=0)
    made = sections(*one(corners))
    for x, y in ((0.0, 1.5), (6.5, 1.5), (3.0, 0.0), (4.0, 2.0)):
        at = np.array([[x, y]])
        expected = max(abs(x - 3.0) / 3.0, abs(y - 1.5) / 1.5)
        assert edge_ratio(made, *one(corners), at)[0] == pytest.approx(expected)


def test_edge_ratio_of_a_concave_section_is_that_of_its_hull() -> None:
    made = sections(*one(L_SHAPE))
    notch = np.array([[2.0, 1.5]])  # half way between the corners (3, 1) and (1, 2)
    assert edge_ratio(made, *one(L_SHAPE), notch)[0] == pytest.approx(1.0)
