"""Stress blocks of rectangles by formula, of other polygons against a search."""

import numpy as np
import pytest
from scipy.optimize import minimize

from drystone.geometry.stress_block import cut_off, stress_block

WALL = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [0.0, 3.0]])
START = np.array([0, 4])


@pytest.mark.parametrize(
    ("point", "area"),
    [
        ((0.5, 1.5), 3.0),
        ((0.5, 0.4), 0.8),  # twice the distance from the edge, over the width
        ((0.1, 0.2), 4.5 * 0.1 * 0.2),  # a triangle at the corner
        ((0.5, 1e-7), 2e-7),
        ((0.5, 0.0), 0.0),
        ((-0.1, 0.2), 0.0),
    ],
)
def test_of_a_rectangle(point, area):
    found, plane = stress_block(WALL, START, np.array([point]))
    assert found == pytest.approx([area], rel=1e-9, abs=1e-12)
    if area > 1e-9:
        part = cut_off(WALL, START, plane)[0]
        assert part[0] == pytest.approx(area)
        assert part[1:] / part[0] == pytest.approx(point)


def test_several_polygons_at_once_also_with_notches():
    """The area is the least integral of max(0, 1 + b . (x - c)) over all b."""
    made = np.random.default_rng(3)
    loops, points = [], []
    for corners in (5, 6, 7, 8):
        angle = 2.0 * np.pi * (np.arange(corners) + made.uniform(0.0, 0.8, corners)) / corners
        reach = made.uniform(0.4, 1.0, corners)
        loops.append(np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1))
        points.append(0.6 * loops[-1][0])
    start = np.cumsum([0, *(len(one) for one in loops)])
    found, _ = stress_block(np.concatenate(loops), start, np.array(points))
    for loop, point, area in zip(loops, points, found, strict=True):

        def value(b, loop=loop, point=point):
            plane = np.array([[1.0 - b @ point, *b]])
            return float(cut_off(loop, np.array([0, len(loop)]), plane)[0] @ plane[0])

        best = minimize(value, point * 3.0, method="Nelder-Mead", options={"xatol": 1e-9}).fun
        assert area == pytest.approx(best, rel=1e-6)
        assert area < cut_off(loop, np.array([0, len(loop)]), np.array([[1.0, 0.0, 0.0]]))[0, 0]


def test_lines_and_points_have_none():
    line = np.array([[0.0, 0.0], [1.0, 0.0]])
    assert stress_block(line, np.array([0, 2]), np.array([[0.5, 0.0]]))[0].tolist() == [0.0]
