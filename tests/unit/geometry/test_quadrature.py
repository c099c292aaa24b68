"""Points that stand for a face carry its force, its moments and its torsion."""

from __future__ import annotations

import numpy as np
import pytest

from drystone.geometry.kern import sections
from drystone.geometry.quadrature import ACCURATE, FacePoints, face_points

ANGLE = 2.0 * np.pi * np.arange(24) / 24.0
SHAPES = {
    "square": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "strip": [(0, 0), (1, 0), (1, 0.01), (0, 0.01)],
    "triangle": [(0, 0), (1, 0), (0.2, 0.7)],
    "trapezium": [(0, 0), (1, 0), (0.8, 0.5), (0.1, 0.5)],
    "angle": [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)],
    "disc": list(zip(np.cos(ANGLE), np.sin(ANGLE), strict=True)),
}


def torsion(corners: np.ndarray, pole: np.ndarray) -> float:
    """Mean distance of the points inside a polygon from a pole, by rays across its box."""
    import shapely

    low, high = corners.min(axis=0), corners.max(axis=0)
    at = (np.arange(300) + 0.5) / 300.0
    x, y = np.meshgrid(*(low[i] + at * (high[i] - low[i]) for i in (0, 1)))
    inside = shapely.contains_xy(shapely.Polygon(corners), x, y)
    return float(np.hypot(x - pole[0], y - pole[1])[inside].mean())


def evenly(corners: np.ndarray, start: np.ndarray, pole: np.ndarray) -> FacePoints:
    """Points of polygons under an even pressure that slip about poles (m, 2)."""
    plane = np.tile([1.0, 0.0, 0.0], (len(pole), 1))
    return face_points(corners, start, plane, pole)


@pytest.mark.parametrize("name", SHAPES)
def test_points_carry_what_the_face_carries(name: str) -> None:
    corners = np.array(SHAPES[name], dtype=float)
    start = np.array([0, len(corners)])
    made = sections(corners, start)
    area, middle = float(made.area[0]), made.centroid[0]
    for pole in (middle, 0.5 * (middle + corners[0]), corners[0], 3.0 * corners[1]):
        found = evenly(corners, start, pole[None])
        assert (found.area >= 0.0).all()
        assert found.area.sum() == pytest.approx(area, rel=1e-3)
        assert found.area @ found.place / area == pytest.approx(middle, rel=1e-3)
        assert np.allclose(found.place[: len(corners)], corners)
        arm = float(found.area @ np.hypot(*(found.place - pole).T)) / area
        assert arm == pytest.approx(torsion(corners, pole), rel=1.5 * ACCURATE)


def test_faces_are_divided_one_by_one() -> None:
    shapes = [np.array(one, dtype=float) for one in SHAPES.values()]
    start = np.concatenate([[0], np.cumsum([len(one) for one in shapes])])
    pole = np.array([one[0] for one in shapes])
    together = evenly(np.concatenate(shapes), start, pole)
    for i, one in enumerate(shapes):
        alone = evenly(one, np.array([0, len(one)]), pole[[i]])
        assert np.allclose(together.place[together.loops[i]], alone.place)
        assert np.allclose(together.area[together.loops[i]], alone.area)
    assert evenly(np.zeros((0, 2)), np.array([0]), np.zeros((0, 2))).loops.rows == 0
