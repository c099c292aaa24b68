"""Vectorised clipping against shapely."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from drystone.geometry import clip, planar


def convex(random: np.random.Generator, corners: int) -> np.ndarray:
    angle = np.sort(random.random(corners)) * 2.0 * np.pi
    radius = random.uniform(0.3, 1.0, 2)
    centre = random.uniform(-0.7, 0.7, 2)
    return centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def padded(polygons: list[np.ndarray]) -> clip.Padded:
    count = np.array([len(p) for p in polygons])
    first = np.cumsum(count) - count
    return clip.pad(np.concatenate(polygons), first, count)


def test_convex_intersections_agree_with_shapely() -> None:
    random = np.random.default_rng(4)
    one = [convex(random, int(random.integers(3, 9))) for _ in range(300)]
    two = [convex(random, int(random.integers(3, 7))) for _ in range(300)]
    corner, start = clip.flatten(clip.intersect_convex(padded(one), padded(two)))
    expected = [
        shapely.Polygon(a).intersection(shapely.Polygon(b)) for a, b in zip(one, two, strict=True)
    ]
    filled = np.diff(start) > 0
    assert [not e.is_empty for e in expected] == filled.tolist()
    begin = start[np.concatenate([[True], filled])]
    areas = np.array([e.area for e in expected])
    np.testing.assert_allclose(clip.areas(corner, begin), areas[filled], atol=1e-12)
    lengths = [e.length for e in expected if not e.is_empty]
    np.testing.assert_allclose(clip.perimeters(corner, begin), lengths, atol=1e-9)


def test_intersection_with_itself_is_itself() -> None:
    random = np.random.default_rng(5)
    shapes = [convex(random, 6) for _ in range(50)]
    flat = clip.flatten(clip.intersect_convex(padded(shapes), padded(shapes)))
    corner, start = clip.cleaned(*flat, np.full(50, 1e-9))
    assert (np.diff(start) == 6).all()
    for i, shape in enumerate(shapes):  # the first corner may be another one
        found = corner[start[i] : start[i + 1]]
        turned = np.roll(found, -int(np.argmin(np.hypot(*(found - shape[0]).T))), axis=0)
        np.testing.assert_allclose(turned, shape, atol=1e-9)


def test_reversed_ranges_run_backwards() -> None:
    corner = np.array([[0.0, 0], [0, 1], [1, 1]])
    one = clip.pad(corner, np.array([0]), np.array([3]), reverse=True)[0]
    np.testing.assert_allclose(one[0], corner[::-1])


def test_cleaning_leaves_true_corners() -> None:
    square = [[0, 0], [0.5, 0], [1, 0], [1, 1e-9], [1, 1], [0.4, 1], [0, 1], [0, 0.2]]
    needle = [[0, 0], [1, 0], [0.5, 1e-9]]
    corner = np.array(square + needle, dtype=float)
    cleaned, start = clip.cleaned(corner, np.array([0, 8, 11]), np.full(2, 1e-6))
    assert np.diff(start).tolist() == [4, 0]
    assert clip.areas(cleaned, start[[0, 1]]) == pytest.approx([1.0])


def test_corners_all_near_each_other_vanish() -> None:
    corner = 1e-9 * np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    assert clip.cleaned(corner, np.array([0, 4]), np.array([1e-6]))[1].tolist() == [0, 0]


def test_spikes_are_cut_off() -> None:
    corner = np.array([[0.0, 0], [2, 0], [1, 0], [1, 1], [0, 1]])
    cleaned, start = clip.cleaned(corner, np.array([0, 5]), np.array([1e-9]))
    assert clip.areas(cleaned, start) == pytest.approx([1.0])
    assert len(cleaned) == 4


def test_holes_are_cut_open() -> None:
    plate = shapely.box(0, 0, 4, 2)
    for hole in (shapely.box(0.5, 0.5, 1, 1.5), shapely.box(2, 0.5, 3, 1)):
        plate = plate.difference(hole)
    corner, start, row = planar.pieces_of(np.array([plate], dtype=object))
    assert (row == 0).all()
    assert clip.areas(corner, start).sum() == pytest.approx(plate.area)
    for i in range(len(row)):
        assert shapely.Polygon(corner[start[i] : start[i + 1]]).is_valid


def test_rings_make_regions_with_holes() -> None:
    outline = np.array([[0.0, 0], [3, 0], [3, 3], [0, 3]])
    hole = np.array([[1.0, 1], [1, 2], [2, 2], [2, 1]])
    corner = np.concatenate([outline, hole, outline])
    shapes = planar.regions(corner, np.array([0, 4, 8, 12]), np.array([0, 0, 1]))
    assert shapely.area(shapes) == pytest.approx([8.0, 9.0])


def test_pieces_of_lines_and_points_are_none() -> None:
    shapes = np.array([shapely.Point(0, 0), shapely.LineString([(0, 0), (1, 1)])], dtype=object)
    assert len(planar.pieces_of(shapes)[2]) == 0
