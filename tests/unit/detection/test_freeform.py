"""Curved joints: meshed differently on both sides, merged, regrouped, given by the user."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, InputError, find_contacts
from drystone.assembly import replace_block
from drystone.detection import DetectionOptions, contacts_from_mesh, regroup
from drystone.geometry.frames import rotation_about
from drystone.models import box, concave, cube_curve, curve_three_blocks, tower

AREA = 2.460


def mixed(base: int, cradle: int, roller: int) -> Assembly:
    """Curve-3-blocks with another number of strips on every block."""
    strips = (base, cradle, roller)
    blocks = tuple(curve_three_blocks(s).blocks[i] for i, s in enumerate(strips))
    return Assembly(blocks, np.array([True, False, False]))


@pytest.mark.parametrize("strips", [(20, 13, 17), (5, 7, 9), (40, 39, 41), (10, 40, 20)])
def test_differently_meshed_sides_keep_their_area(strips: tuple[int, int, int]) -> None:
    report = find_contacts(mixed(*strips)).report
    for joint, area in ((1, 1.2130), (2, 1.2469)):
        assert report.area[report.block_b == joint].sum() == pytest.approx(area, rel=0.02)
    assert report.area.sum() == pytest.approx(AREA, rel=0.02)
    assert report.overlaps == ()


def test_differently_meshed_rims_keep_their_area() -> None:
    blocks = (cube_curve(strips=18).blocks[0], cube_curve(strips=14).blocks[1])
    assert find_contacts(Assembly(blocks)).contacts.area.sum() == pytest.approx(0.4708, rel=0.02)


def test_slivers_are_merged_into_their_neighbours() -> None:
    model = mixed(20, 21, 20)
    raw = find_contacts(model, options=DetectionOptions(merge=0.0))
    merged = find_contacts(model)
    assert merged.contacts.count < raw.contacts.count
    assert merged.contacts.area.min() > 2.0 * raw.contacts.area.min()
    assert merged.contacts.area.sum() == pytest.approx(raw.contacts.area.sum(), rel=1e-3)
    assert merged.report.merged.sum() == raw.contacts.count
    assert any("merged" in line for line in merged.report.summary())


def test_joints_of_exact_models_are_not_merged() -> None:
    for model in (concave(), cube_curve(), tower(3)):
        raw = find_contacts(model, options=DetectionOptions(merge=0.0)).contacts
        assert np.array_equal(find_contacts(model).contacts.point, raw.point)


@pytest.mark.parametrize("count", [10, 20, 40, 70])
def test_regrouping_to_a_number_keeps_the_area(count: int) -> None:
    contacts = regroup(find_contacts(curve_three_blocks()).contacts, count=count)
    assert contacts.count == 2 * count
    assert contacts.area.sum() == pytest.approx(AREA, rel=0.02)
    assert np.diff(contacts.block_b).min() >= 0


def test_strong_curvature_is_not_flattened() -> None:
    contacts = regroup(find_contacts(curve_three_blocks()).contacts, count=1)
    assert contacts.count > 2
    assert contacts.area.sum() == pytest.approx(AREA, rel=0.02)


def test_regrouping_by_angle_bounds_the_turn() -> None:
    fine = find_contacts(curve_three_blocks(40)).contacts
    counts = [regroup(fine, angle=angle).count for angle in (1.0, 3.0, 6.0, 12.0)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[-1]


def test_regrouped_normals_still_point_from_a_to_b() -> None:
    fine = find_contacts(curve_three_blocks()).contacts
    coarse = regroup(fine, count=6)
    for pair in ((0, 1), (1, 2)):
        means = [
            (c.area[:, None] * c.frame[:, 0])[(c.block_a == pair[0]) & (c.block_b == pair[1])].sum(
                axis=0
            )
            for c in (fine, coarse)
        ]
        np.testing.assert_allclose(means[0], means[1], rtol=0.02, atol=0.02)


def test_only_the_chosen_pairs_are_regrouped() -> None:
    contacts = find_contacts(curve_three_blocks()).contacts
    part = regroup(contacts, count=10, pairs=[(2, 1)])
    assert int((part.block_b == 2).sum()) == 10
    assert int((part.block_b == 1).sum()) == int((contacts.block_b == 1).sum())


def test_lines_survive_regrouping() -> None:
    slab = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), "slab")
    cube = box((1.0, 1.0, 1.0)).transformed(rotation_about([1.0, 0.0, 0.0], 45.0))
    contacts = find_contacts(Assembly((slab, cube))).contacts
    assert np.array_equal(regroup(contacts, count=3).point, contacts.point)


@pytest.mark.parametrize("wrong", [{}, {"count": 2, "angle": 3.0}, {"count": 0}, {"angle": 60.0}])
def test_impossible_regrouping_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError):
        regroup(find_contacts(tower(2)).contacts, **wrong)  # type: ignore[arg-type]


def test_given_mesh_becomes_the_joint() -> None:
    model = curve_three_blocks(8)
    found = find_contacts(model).contacts.select(find_contacts(model).contacts.block_b == 1)
    faces = [list(range(found.start[i], found.start[i + 1])) for i in range(found.count)]
    turned = [face[::-1] if i % 2 else face for i, face in enumerate(faces)]
    given = contacts_from_mesh(model, "base", "cradle", found.point, turned, friction=0.3)
    np.testing.assert_allclose(given.area, found.area, rtol=1e-9)
    np.testing.assert_allclose(given.frame[:, 0], found.frame[:, 0], atol=1e-9)
    np.testing.assert_allclose(given.friction, 0.3)


def test_mesh_normals_follow_the_order_of_the_blocks() -> None:
    square = [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    for model, up in ((tower(2), 1.0), (Assembly(tower(2).blocks[::-1]), -1.0)):
        contacts = contacts_from_mesh(model, "block-1", "block-0", square, [(0, 1, 2, 3)])  # type: ignore[arg-type]
        assert contacts.block_a.tolist() == [0]
        np.testing.assert_allclose(contacts.frame[0, 0], [0.0, 0.0, up])


@pytest.mark.parametrize("faces", [[(0, 1, 9)], [(0, 1)], [(0, 1, 1)]])
def test_broken_mesh_is_refused(faces: list[tuple[int, ...]]) -> None:
    square = np.array([(0.0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    with pytest.raises(InputError, match="joint of"):
        contacts_from_mesh(tower(2), 0, 1, square, faces)


def test_joint_of_a_block_with_itself_is_refused() -> None:
    with pytest.raises(InputError, match="two blocks"):
        contacts_from_mesh(tower(2), 0, 0, np.zeros((3, 3)), [(0, 1, 2)])


def test_mesh_away_from_its_blocks_is_refused_with_the_distance() -> None:
    far = np.array([(0.0, 0, 8), (1, 0, 8), (1, 1, 8)])
    with pytest.raises(InputError, match="face 0 is 7 m away from block 'block-0'"):
        contacts_from_mesh(tower(2), 0, 1, far, [(0, 1, 2)])


def test_strongly_warped_face_of_a_mesh_is_refused() -> None:
    cube = box((1.0, 1.0, 1.0))
    warped = np.array([(0.0, 0, 0), (1, 0, 1), (1, 1, 0), (0, 1, 1)])
    model = Assembly((replace_block(cube, name="a"), replace_block(cube, name="b")))
    with pytest.raises(InputError, match=r"a corner lies 0\.5 m from its plane"):
        contacts_from_mesh(model, 0, 1, warped, [(0, 1, 2, 3)])
