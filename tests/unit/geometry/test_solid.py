"""Points and segments against triangulated solids."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Block
from drystone.geometry import solid
from drystone.geometry.frames import rotation_about
from drystone.geometry.polyhedron import stack_faces
from drystone.geometry.triangulate import triangulate
from drystone.models import box, prism, stool


def triangles_of(block: Block) -> np.ndarray:
    faces = stack_faces([block.vertices], [block.faces])
    corner = faces.point[faces.loop]
    return corner[triangulate(corner, faces.start)[0]]


CORNER = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], (0.0, 1.0))


def test_inside_of_a_concave_solid() -> None:
    random = np.random.default_rng(0)
    points = random.uniform(-0.5, 2.5, (500, 3))
    expected = ((points > 0.0) & (points < [2.0, 1.0, 2.0])).all(axis=1)
    expected &= ~((points[:, 0] > 1.0) & (points[:, 2] > 1.0))
    assert np.array_equal(solid.winding_number(points, triangles_of(CORNER)) > 0.5, expected)


def test_the_winding_number_counts_the_way_round() -> None:
    block = box((1, 2, 3))
    triangles = triangles_of(block)
    points = np.stack([block.centroid, block.bounds[1] + 1.0])
    turns = [solid.winding_number(points, each) for each in (triangles, triangles[:, ::-1])]
    np.testing.assert_allclose(turns, [[1.0, 0.0], [-1.0, 0.0]], atol=1e-12)


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((0.5, 0.5, 0.5), 0.0),
        ((1.0, 1.0, 1.0), 0.0),
        ((0.5, 0.5, 1.5), 0.5),
        ((2.0, 0.5, 2.0), np.sqrt(2.0)),
        ((-1.0, -1.0, -1.0), np.sqrt(3.0)),
    ],
)
def test_inside_a_solid_there_is_no_distance(point: tuple[float, ...], expected: float) -> None:
    found = solid.outside_distance(np.array([point]), triangles_of(box((1.0, 1.0, 1.0))))
    np.testing.assert_allclose(found, [expected], atol=1e-12)


def test_the_hollow_of_a_concave_block_is_outside_it() -> None:
    triangles = triangles_of(stool().blocks[1])
    found = solid.outside_distance(np.array([[0.2, 0.2, 0.1]]), triangles)
    np.testing.assert_allclose(found, [0.12 * np.sqrt(2)])


def test_distance_from_a_box() -> None:
    random = np.random.default_rng(1)
    points = random.uniform(-1.0, 2.0, (300, 3))
    outside = np.linalg.norm(np.maximum(np.maximum(-points, points - 1.0), 0.0), axis=1)
    depth = np.minimum(points, 1.0 - points).min(axis=1)
    expected = np.where(outside > 0.0, outside, depth)
    np.testing.assert_allclose(
        solid.distance(points, triangles_of(box((1, 1, 1)))), expected, atol=1e-12
    )


def test_segments_cross_where_they_enter_and_leave() -> None:
    start, end = (
        np.array([[0.3, 0.4, -1.0], [5.0, 5.0, 5.0]]),
        np.array([[0.3, 0.4, 3.0], [6.0, 5.0, 5.0]]),
    )
    hit, share = solid.crossings(start[:, None], end[:, None], triangles_of(box((1, 1, 1))))
    assert hit.sum(axis=1).tolist() == [2, 0]
    np.testing.assert_allclose(np.sort(share[hit]), [0.25, 0.5])


def test_a_segment_through_the_diagonals_of_faces_crosses_however_the_box_is_turned() -> None:
    for angle in np.linspace(0.0, 360.0, 50):
        turned = box((1, 1.3, 0.7)).transformed(rotation_about((1.0, 2.0, 3.0), angle))
        way = turned.vertices[list(turned.faces[0])].mean(axis=0) - turned.centroid
        start, end = turned.centroid - 2.0 * way, turned.centroid + 2.0 * way
        hit, share = solid.crossings(start, end, triangles_of(turned))
        assert np.unique(share[hit].round(9)).tolist() == [0.25, 0.75]


@pytest.mark.parametrize("least", [0.0, 0.3, 9.0])
def test_farthest_is_the_largest_of_all_distances(least: float) -> None:
    points = np.random.default_rng(5).uniform(-1.0, 3.0, (4000, 3))
    surface = triangles_of(CORNER)
    away = solid.distance(points, surface).max()
    assert solid.farthest(points, surface, least) == (away if away > least else 0.0)
    beside = solid.distance(points[:1], surface)[0]
    assert solid.farthest(points[:1], surface, least) == (beside if beside > least else 0.0)
