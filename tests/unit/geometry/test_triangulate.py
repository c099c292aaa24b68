import numpy as np
import pytest
import shapely

from drystone.geometry.frames import rotation_about
from drystone.geometry.triangulate import triangulate

SHAPES = {
    "triangle": [(0, 0), (1, 0), (0, 1)],
    "square": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "square with a straight corner": [(0, 0), (0.5, 0), (1, 0), (1, 1), (0, 1)],
    "dart": [(2, 0), (0.5, 0.5), (0, 2), (0, 0)],
    "L": [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)],
    "comb": [
        (0, 0), (5, 0), (5, 2), (4, 2), (4, 1), (3, 1), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2),
        (0, 2),
    ],
    "star": [
        ((1 + i % 2) * np.cos(i * np.pi / 7), (1 + i % 2) * np.sin(i * np.pi / 7))
        for i in range(14)
    ],
    "spiral": [
        (0, 0), (6, 0), (6, 6), (1, 6), (1, 2), (4, 2), (4, 4), (3, 4), (3, 3), (2, 3), (2, 5),
        (5, 5), (5, 1), (0, 1),
    ],
}  # fmt: skip


def in_space(shape: list[tuple[float, float]], angle: float = 40.0) -> np.ndarray:
    flat = np.column_stack([np.array(shape, dtype=float), np.zeros(len(shape))])
    return flat @ rotation_about(np.array([1.0, 2.0, 0.5]), angle).T + [1e4, -1e4, 3.0]


def area_vectors(corners: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    a, b, c = (corners[triangle[:, i]] - corners[0] for i in range(3))
    return 0.5 * np.cross(b - a, c - a)


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_cover_a_polygon_exactly_once(name: str) -> None:
    shape = SHAPES[name]
    for turn in range(len(shape)):
        turned = shape[turn:] + shape[:turn]
        triangle, polygon = triangulate(in_space(turned), np.array([0, len(shape)]))
        assert len(triangle) == len(shape) - 2
        assert (polygon == 0).all()
        parts = [shapely.Polygon([turned[i] for i in t]) for t in triangle]
        whole = shapely.Polygon(turned)
        assert sum(p.area for p in parts) == pytest.approx(whole.area, rel=1e-9)
        assert shapely.union_all(parts).symmetric_difference(whole).area < 1e-9


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_turn_like_their_polygon(name: str) -> None:
    corners = in_space(SHAPES[name])
    triangle, _ = triangulate(corners, np.array([0, len(corners)]))
    area = area_vectors(corners, triangle)
    assert (area @ area.sum(axis=0) >= -1e-9).all()


def test_several_polygons_keep_their_own_corners() -> None:
    loops = [in_space(SHAPES[name]) for name in ("square", "L", "dart", "triangle")]
    start = np.concatenate([[0], np.cumsum([len(x) for x in loops])])
    triangle, polygon = triangulate(np.concatenate(loops), start)
    assert np.bincount(polygon).tolist() == [2, 4, 2, 1]
    assert (triangle >= start[polygon][:, None]).all()
    assert (triangle < start[polygon + 1][:, None]).all()


def test_a_slightly_warped_concave_face_is_triangulated_as_it_appears() -> None:
    corners = np.column_stack([np.array(SHAPES["L"], float), [0.0, 0.02, -0.02, 0.01, 0.0, -0.01]])
    triangle, _ = triangulate(corners, np.array([0, 6]))
    flat_area = area_vectors(corners, triangle)[:, 2]
    assert (flat_area > 0.0).all()
    assert flat_area.sum() == pytest.approx(5.0)


def test_no_polygon_has_no_triangle() -> None:
    triangle, polygon = triangulate(np.zeros((0, 3)), np.array([0]))
    assert triangle.shape == (0, 3)
    assert len(polygon) == 0


def test_a_crossed_loop_still_gives_two_triangles_less_than_corners() -> None:
    bow = np.array([(0, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0), (3, 2, 0)], dtype=float)
    assert len(triangulate(bow, np.array([0, 5]))[0]) == 3


@pytest.mark.parametrize("first", range(5))
def test_a_straight_corner_makes_no_triangle_of_nothing(first: int) -> None:
    corners = np.array([(0.0, 0, 0), (1, 1e-5, 0), (2, 0, 0), (2, 1, 0.1), (0, 1, 0)])
    corners = np.roll(corners, first, axis=0)
    triangle = corners[triangulate(corners, np.array([0, 5]))[0]]
    sides = triangle[:, 1:] - triangle[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    assert area.min() > 0.1
    assert area.sum() == pytest.approx(2.0, rel=0.01)
