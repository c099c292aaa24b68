"""Facets in smooth runs, and joined."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from drystone.geometry import facets

Polygons = tuple[np.ndarray, np.ndarray, np.ndarray]


def polygons(*loops: object) -> Polygons:
    """Corners, starts and the one pair of blocks of polygons."""
    arrays = [np.asarray(loop, dtype=np.float64) for loop in loops]
    start = np.cumsum([0, *(len(loop) for loop in arrays)])
    return np.concatenate(arrays), start, np.zeros(len(arrays), dtype=np.intp)


def level(x: tuple[float, float], y: tuple[float, float], z: float = 0.0) -> np.ndarray:
    """A horizontal rectangle."""
    return np.array([(x[0], y[0], z), (x[1], y[0], z), (x[1], y[1], z), (x[0], y[1], z)])


def arc(turn: np.ndarray) -> Polygons:
    """Strips of a unit cylinder about y."""
    x, z = np.sin(turn), np.cos(turn)
    strips = [
        [(x[i], 0, z[i]), (x[i], 1, z[i]), (x[j], 1, z[j]), (x[j], 0, z[j])]
        for i, j in pairwise(range(len(turn)))
    ]
    return polygons(*strips)


def runs(given: Polygons) -> list[int]:
    return facets.smooth_runs(*given).tolist()


def joined(given: Polygons, angle_deg: float) -> facets.JoinedFacets:
    made = facets.joined(*given, np.deg2rad(angle_deg))
    assert made is not None
    return made


def test_facets_with_a_common_edge_are_one_run() -> None:
    assert runs(polygons(level((0, 1), (0, 1)), level((1, 3), (0, 1)))) == [0, 0]
    assert runs(polygons(level((0, 1), (0, 1)), level((1, 3), (0.5, 4)))) == [0, 0]


def test_facets_that_meet_in_a_corner_or_at_a_crease_are_not() -> None:
    one = level((0, 1), (0, 1))
    assert runs(polygons(one, level((1, 2), (1, 2)))) == [0, 1]
    assert runs(polygons(one, [[1.0, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]])) == [0, 1]


def test_facets_on_two_levels_and_of_two_pairs_of_blocks_are_not() -> None:
    low, high = level((0, 1), (0, 1)), level((1, 2), (0, 1), 0.1)
    turned = np.array([[1.0, 0, 1], [0, 1, 0], [-1, 0, 1]])  # their boxes overlap
    assert runs(polygons(low, high)) == [0, 1]
    assert runs(polygons(low @ turned.T, high @ turned.T)) == [0, 1]
    point, start, _ = polygons(low, level((1, 2), (0, 1)))
    assert runs((point, start, np.array([0, 1]))) == [0, 1]


def test_plane_runs_stay_as_they_are() -> None:
    assert facets.joined(*polygons(level((0, 1), (0, 1)), level((1, 3), (0, 1))), 0.1) is None


@pytest.mark.parametrize("angle", [2.0, 8.0, 20.0])
def test_pieces_are_within_the_angle_and_keep_the_area(angle: float) -> None:
    given = arc(np.linspace(0.0, np.pi / 2, 41))
    made = joined(given, angle)
    assert np.rad2deg(made.turn).max() <= angle + 1e-9
    wanted = int(np.ceil(90.0 / (2.0 * angle)))
    assert 0.9 * wanted <= len(made.normal) <= 2 * wanted
    assert sorted(made.facet.tolist()) == list(range(40))
    assert len(made.point) == 4 * len(made.normal)
    box = np.ptp(made.point, axis=0)
    np.testing.assert_allclose(box, [1.0, 1.0, 1.0], atol=0.05)


def test_joined_facets_say_how_far_they_are_off() -> None:
    made = joined(arc(np.linspace(0.0, 0.4, 9)), 30.0)
    (turn,), (moved,) = made.turn, made.moved
    assert turn == pytest.approx(0.4 / 2 * 7 / 8, rel=0.01)
    assert 0.5 * (1.0 - np.cos(0.2)) < moved < 1.0 - np.cos(0.2)


def test_slivers_go_into_their_neighbours_and_nothing_else() -> None:
    made = joined(arc(np.array([0.0, 0.1, 0.103, 0.2, 0.3])), 0.0)
    assert sorted(made.facets.counts.tolist()) == [1, 1, 2]


def test_a_ring_is_not_closed_into_a_polygon_with_a_hole() -> None:
    sides = [
        level((0, 3), (0, 1)),
        level((2, 3), (1, 3)),
        level((0, 2), (2, 3)),
        level((0, 1), (1, 2)),
    ]
    sides[1] = sides[1] + [[0, 0, 0], [0, 0, 0], [0, 0, 0.01], [0, 0, 0.01]]
    made = joined(polygons(*sides), 5.0)
    assert len(made.normal) == 4
