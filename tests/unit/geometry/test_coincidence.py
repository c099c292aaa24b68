import numpy as np
import pytest

from drystone.geometry.coincidence import duplicates, first_coincident, weld


@pytest.mark.parametrize("offset", [0.0, 0.3, 0.999999, 1e4])
def test_points_nearer_than_the_distance_coincide_wherever_they_lie(offset: float) -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform(0.0, 100.0, (300, 3)) + offset
    near = points + rng.uniform(-1.0, 1.0, points.shape) * 1e-6 / np.sqrt(3.0)
    first = first_coincident(np.concatenate([points, near]), 1e-6)
    assert first.tolist() == 2 * list(range(300))


def test_points_farther_than_four_distances_do_not_coincide() -> None:
    points = np.arange(50)[:, None] * np.array([4.1e-6, 0.0, 0.0])
    assert first_coincident(points, 1e-6).tolist() == list(range(50))


def test_without_a_distance_only_equal_points_coincide() -> None:
    points = np.array([[0.0, 0, 0], [1e-300, 0, 0], [0, 0, 0]])
    assert first_coincident(points, 0.0).tolist() == [0, 1, 0]


def test_many_points_at_one_place_take_no_more_memory_than_points() -> None:
    assert first_coincident(np.zeros((200_000, 3)), 1e-9).max() == 0


def test_welding_drops_corners_and_faces_that_collapse() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1e-12, 0], [0, 1, 0], [1, 0, 1e-12]])
    faces, merged = weld(vertices, [(0, 1, 2, 3), (1, 2, 4)], 1e-9)
    assert faces == ((0, 1, 3),)
    assert merged == 2


def test_welding_leaves_distinct_vertices_alone() -> None:
    vertices = np.eye(3)
    assert weld(vertices, [(0, 1, 2)], 1e-9) == (((0, 1, 2),), 0)


def test_doubles_are_found_in_any_order_of_vertices() -> None:
    rng = np.random.default_rng(2)
    bodies = [rng.uniform(size=(9, 3)) + 3.0 * i for i in range(20)]
    shuffled = rng.permutation(bodies[7]) + 1e-12
    moved = bodies[8] + 1e-3
    assert duplicates([*bodies, shuffled, moved, bodies[7]], 1e-9) == [(7, 20), (7, 22)]


def test_bodies_with_one_box_and_other_vertices_are_no_doubles() -> None:
    corners = np.array([[0.0, 0, 0], [1, 1, 1], [0.3, 0.6, 0.2], [0.1, 0.9, 0.4]])
    assert duplicates([corners, np.array([1.0, 1, 1]) - corners], 1e-9) == []


def test_a_doubled_vertex_does_not_hide_a_missing_one() -> None:
    one = np.array([[0.0, 0, 0], [1, 1, 1], [0.5, 0, 0], [0.5, 0, 0]])
    other = np.array([[0.0, 0, 0], [1, 1, 1], [0.5, 0, 0], [0.25, 0, 0]])
    assert duplicates([one, other], 1e-9) == []


def test_points_of_different_bodies_do_not_coincide() -> None:
    points = np.zeros((4, 3))
    assert first_coincident(points, 1.0, np.array([0, 1, 0, 1])).tolist() == [0, 1, 0, 1]


def test_each_body_has_a_distance_of_its_own() -> None:
    points = np.array([[0.0, 0, 0], [1e-3, 0, 0], [0, 0, 0], [1e-3, 0, 0]])
    body = np.array([0, 0, 1, 1])
    distance = np.array([1e-2, 1e-2, 1e-5, 1e-5])
    assert first_coincident(points, distance, body).tolist() == [0, 0, 2, 3]
