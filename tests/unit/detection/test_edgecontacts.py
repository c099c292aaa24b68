"""Blocks on an edge or a corner."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, Block, find_contacts
from drystone.detection import DetectionOptions, EdgeContacts
from drystone.geometry.frames import rotation_about
from drystone.models import box, prism, tower, wall

SLAB = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), "slab")
ON_CORNER = rotation_about([1.0, -1.0, 0.0], float(np.rad2deg(np.arccos(1.0 / np.sqrt(3.0)))))


def standing(
    rotation: np.ndarray, at: tuple[float, float] = (0.0, 0.0), name: str = "cube"
) -> Block:
    """A unit cube, turned, its lowest point on z = 0."""
    cube = box((1.0, 1.0, 1.0), (-0.5, -0.5, -0.5), name).transformed(rotation)
    return cube.transformed(translation=(*at, -cube.bounds[0, 2]))


@pytest.mark.parametrize("angle", [3.0, 20.0, 45.0])
def test_cube_on_its_edge_touches_along_a_line(angle: float) -> None:
    cube = standing(rotation_about([1.0, 0.0, 0.0], angle))
    detection = find_contacts(Assembly((SLAB, cube)))
    contacts, report = detection.contacts, detection.report
    assert contacts.count == 1
    assert contacts.corner_count == 2
    assert contacts.area.tolist() == [0.0]
    np.testing.assert_allclose(contacts.frame[0, 0], [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(np.sort(contacts.point[:, 0]), [-0.5, 0.5], atol=1e-12)
    assert report.interfaces.kind.tolist() == [2]
    assert report.isolated == ()
    assert "1 line" in report.summary()[0]


def test_cube_on_its_corner_touches_in_a_point() -> None:
    contacts = find_contacts(Assembly((SLAB, standing(ON_CORNER, (0.3, 0.2))))).contacts
    assert contacts.corner_count == 1
    np.testing.assert_allclose(contacts.point, [[0.3, 0.2, 0.0]], atol=1e-9)


def test_normal_points_from_a_to_b_in_either_order() -> None:
    cube = standing(rotation_about([1.0, 0.0, 0.0], 45.0))
    contacts = find_contacts(Assembly((cube, SLAB))).contacts
    np.testing.assert_allclose(contacts.frame[0, 0], [0.0, 0.0, -1.0], atol=1e-12)


def test_edge_beyond_the_face_is_cut_off() -> None:
    cube = standing(rotation_about([1.0, 0.0, 0.0], 45.0), (2.0, 0.0))
    contacts = find_contacts(Assembly((SLAB, cube))).contacts
    np.testing.assert_allclose(np.sort(contacts.point[:, 0]), [1.5, 2.0], atol=1e-12)


def test_crossed_ridges_touch_in_a_point() -> None:
    ridge = box((4.0, 0.7, 0.7), (-2.0, -0.35, -0.35), "lower").transformed(
        rotation_about([1.0, 0.0, 0.0], 45.0)
    )
    top = 2.0 * float(ridge.bounds[1, 2])
    over = ridge.transformed(rotation_about([0.0, 0.0, 1.0], 70.0), (0.0, 0.0, top)).renamed(
        "upper"
    )
    contacts = find_contacts(Assembly((ridge, over))).contacts
    assert contacts.corner_count == 1
    np.testing.assert_allclose(contacts.frame[0, 0], [0.0, 0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(contacts.point, [[0.0, 0.0, 0.5 * top]], atol=1e-9)


def test_block_in_a_groove_touches_both_flanks() -> None:
    rise = np.tan(np.deg2rad(30.0))
    left = [(-2.0, -1.0), (0.0, -1.0), (0.0, 0.0), (-2.0, 2.0 * rise)]
    flanks = (
        prism(left, (0.0, 1.0), "left"),
        prism([(-x, z) for x, z in left], (0.0, 1.0), "right"),
    )
    cube = box((1.0, 0.5, 1.0), (-0.5, 0.25, 0.5 * rise), "cube")
    contacts = find_contacts(Assembly((*flanks, cube))).contacts
    lines = contacts.block_b == 2
    assert contacts.block_a[lines].tolist() == [0, 1]
    assert np.diff(contacts.start)[lines].tolist() == [2, 2]
    expected = [[0.5, 0.0, np.sqrt(0.75)], [-0.5, 0.0, np.sqrt(0.75)]]
    np.testing.assert_allclose(contacts.frame[lines, 0], expected, atol=1e-9)


def test_never_asked_never_found() -> None:
    options = DetectionOptions(edges=EdgeContacts.NEVER)
    report = find_contacts(
        Assembly((SLAB, standing(rotation_about([1.0, 0.0, 0.0], 45.0)))), options=options
    ).report
    assert report.isolated == (0, 1)


def test_on_request_blocks_that_touch_others_get_edge_contacts_too() -> None:
    leaning = box((0.2, 1.0, 2.0)).transformed(rotation_about([0.0, 1.0, 0.0], 30.0))
    leaning = leaning.transformed(
        translation=(-leaning.bounds[0, 0] - 1.5, 0.0, -leaning.bounds[0, 2])
    )
    on_slab = box((0.5, 0.5, 0.5), (-2.0, -2.0, 0.0), "other")
    tall = Assembly((SLAB, on_slab, box((1.0, 1.0, 0.5), (-2.0, 0.0, -1.0), "below"), leaning))
    found = find_contacts(tall, options=DetectionOptions(edges=EdgeContacts.ALWAYS)).report
    joined = found.interfaces.block_a.tolist(), found.interfaces.block_b.tolist()
    assert (0, 3) in set(zip(*joined, strict=True))


def test_on_request_face_contacts_stay_as_they_are() -> None:
    for model in (tower(3), wall(3, 3)):
        plain = find_contacts(model).contacts
        every = find_contacts(model, options=DetectionOptions(edges=EdgeContacts.ALWAYS)).contacts
        assert np.array_equal(plain.point, every.point)


def test_line_contacts_do_not_depend_on_scale_or_place() -> None:
    model = Assembly((SLAB, standing(rotation_about([1.0, 0.0, 0.0], 30.0))))
    turned = model.transformed(1e-3 * rotation_about([1.0, 2.0, 3.0], 50.0), (10.0, 20.0, 30.0))
    for each in (model, turned):
        contacts = find_contacts(each).contacts
        assert np.diff(contacts.start).tolist() == [2]
