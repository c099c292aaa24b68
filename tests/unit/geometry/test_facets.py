"""Facets joined and divided."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely

from drystone.geometry import facets
from drystone.geometry.facets import Facet


def level(*corners: tuple[float, float], z: float = 0.0, member: int = 0) -> Facet:
    """A horizontal facet."""
    shape = shapely.Polygon(corners)
    point = np.array([(x, y, z) for x, y in corners])
    return Facet(point, np.array([0.0, 0.0, 1.0]), shape.area, (member,))


def row(*ends: float) -> list[Facet]:
    """Unit-deep rectangles side by side along x."""
    return [
        level((a, 0), (b, 0), (b, 1), (a, 1), member=i) for i, (a, b) in enumerate(pairwise(ends))
    ]


def arc(count: int, angle: float) -> list[Facet]:
    """Strips of a unit cylinder about y."""
    turn = np.linspace(0.0, angle, count + 1)
    x, z = np.sin(turn), np.cos(turn)
    point = [
        [(x[i], 0, z[i]), (x[i + 1], 0, z[i + 1]), (x[i + 1], 1, z[i + 1]), (x[i], 1, z[i])]
        for i in range(count)
    ]
    return facets.facets_of(np.array(point).reshape(-1, 3), 4 * np.arange(count + 1, dtype=np.intp))


def common_edge(one: Facet, other: Facet, size: float) -> float:
    """Common edge of one pair."""
    length = facets.common_edges([one, other], np.array([0]), np.array([1]), size)
    return float(length[0])


def test_facets_know_their_normal_area_and_width() -> None:
    (facet,) = facets.facets_of(
        np.array([[0, 0, 1.0], [4, 0, 1], [4, 1, 1], [0, 1, 1]]), np.array([0, 4])
    )
    np.testing.assert_allclose(facet.normal, [0, 0, 1])
    assert facet.area == pytest.approx(4.0)
    assert facet.width == pytest.approx(0.8)


def test_common_edge_has_its_length() -> None:
    one, two = row(0.0, 1.0, 3.0)
    assert common_edge(one, two, 1.0) == pytest.approx(1.0, abs=0.01)


def test_facets_that_meet_in_a_corner_or_at_a_crease_are_no_neighbours() -> None:
    one = level((0, 0), (1, 0), (1, 1), (0, 1))
    assert common_edge(one, level((1, 1), (2, 1), (2, 2), (1, 2)), 1.0) == 0.0
    steep = facets.facets_of(
        np.array([[1.0, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]]), np.array([0, 4])
    )[0]
    assert common_edge(one, steep, 1.0) == 0.0


def test_cells_of_a_grid_have_the_neighbours_across_their_edges() -> None:
    cells = [
        level((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)) for i in range(8) for j in range(8)
    ]
    assert len(facets.neighbours(cells, 1.0)) == 2 * 7 * 8


def test_slivers_go_into_their_neighbours() -> None:
    merged = facets.merge_slivers(row(0.0, 1.0, 1.03, 2.0), 0.2, 1.0)
    assert sorted(len(facet.members) for facet in merged) == [1, 2]
    assert sum(facet.area for facet in merged) == pytest.approx(2.0)
    assert all(len(facet.point) == 4 for facet in merged)


def test_flat_row_becomes_one_rectangle() -> None:
    (whole,) = facets.join_to_count(row(0.0, 0.5, 1.2, 2.0, 3.0), 1, 1.0)
    assert whole.members == (0, 1, 2, 3)
    assert len(whole.point) == 4
    np.testing.assert_allclose(whole.point.min(axis=0), [0, 0, 0], atol=1e-6)
    np.testing.assert_allclose(whole.point.max(axis=0), [3, 1, 0], atol=1e-6)


def test_half_a_cylinder_is_not_made_plane() -> None:
    assert len(facets.join_to_count(arc(20, np.pi), 1, 1.0)) > 3


def test_joining_by_angle_stops_at_the_angle() -> None:
    given = arc(20, np.pi / 2)
    for joined in facets.join_by_angle(given, np.deg2rad(8.0), 1.0):
        turns = [
            np.degrees(np.arccos(min(given[m].normal @ joined.normal, 1.0))) for m in joined.members
        ]
        assert max(turns) <= 8.0 + 1e-6
        assert len(joined.members) > 1


def test_ring_is_not_closed_into_a_polygon_with_a_hole() -> None:
    sides = [
        level((0, 0), (3, 0), (3, 1), (0, 1), member=0),
        level((2, 1), (3, 1), (3, 3), (2, 3), member=1),
        level((0, 2), (2, 2), (2, 3), (0, 3), member=2),
        level((0, 1), (1, 1), (1, 2), (0, 2), member=3),
    ]
    joined = facets.join_to_count(sides, 1, 1.0)
    assert len(joined) == 2
    assert sum(facet.area for facet in joined) == pytest.approx(8.0)


@pytest.mark.parametrize("count", [2, 3, 8])
def test_dividing_keeps_the_area(count: int) -> None:
    corner = level((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))
    parts = facets.divide_to_count([corner], count)
    assert len(parts) >= count
    assert sum(part.area for part in parts) == pytest.approx(3.0)
    assert all(part.members == (0,) for part in parts)
