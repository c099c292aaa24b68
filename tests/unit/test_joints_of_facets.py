"""Joints of several facets: one row, one line of force, one thing to click."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, Contacts, JointCapacity, Model, Result, check, find_contacts
from drystone.geometry.frames import rotation_about
from drystone.geometry.halfedge import sharp_edges
from drystone.models import box, curve_three_blocks, prism, tower
from drystone.view.encode import encode


@pytest.fixture(scope="module")
def curved() -> Result:
    return check(Model.of(curve_three_blocks(), friction=0.84))


def test_facets_of_a_curve_are_one_joint(curved: Result) -> None:
    contacts = curved.contacts
    assert contacts.count == 39
    assert contacts.joint.tolist() == contacts.block_a.tolist()
    whole = contacts.joints
    assert whole.count == 2
    assert whole.area.sum() == pytest.approx(contacts.area.sum())
    assert [len(whole.polygon(i)) for i in range(2)] == [4, 4]


def test_separate_areas_of_two_blocks_are_separate_joints() -> None:
    legs = [box((1.0, 1.0, 0.2), (x, 0.0, 0.0), name) for x, name in ((0.0, "one"), (3.0, "two"))]
    top = box((4.0, 1.0, 0.2), (0.0, 0.0, 0.2), "top")
    contacts = find_contacts(Assembly((*legs, top))).contacts
    assert contacts.joint.tolist() == [0, 1]
    assert contacts.joints is contacts
    both = Contacts(
        np.zeros(2, dtype=np.intp), np.full(2, 1), contacts.frame, contacts.area,
        contacts.friction, contacts.point, contacts.interface,
    )  # fmt: skip
    assert both.joint.tolist() == [0, 1]


def test_the_table_has_a_row_for_each_joint_and_carries_the_weight(curved: Result) -> None:
    table = curved.joints()
    assert table["joint"].tolist() == [0, 1]
    force = np.stack([table[f"force_{axis}"] for axis in "xyz"], axis=1)
    weight = curved.assembly.mass * 9.81
    np.testing.assert_allclose(force[0], [0, 0, weight[1] + weight[2]], atol=1e-3 * weight[2])
    np.testing.assert_allclose(force[1], [0, 0, weight[2]], atol=1e-3 * weight[2])
    at = np.stack([table[axis] for axis in "xyz"], axis=1)
    arm = np.cross(at[1] - curved.assembly.centroid[2], force[1])
    np.testing.assert_allclose(arm[:2], 0.0, atol=1e-3 * weight[2])
    assert ((table["friction_use"] >= 0.0) & (table["friction_use"] <= 1.0 + 1e-6)).all()


def test_pictures_have_one_line_and_one_resultant_for_each_joint(curved: Result) -> None:
    layers = {layer.key: layer for layer in curved.stage().layers}
    first = [0, int(np.flatnonzero(curved.contacts.joint == 1)[0])]
    for key in ("network", "resultants"):
        assert sorted(set(layers[key].interface.tolist())) == first
    assert len(layers["joint-pressure"].start) == 40  # the map is that of the facets


def test_the_page_knows_joints_and_no_facets(curved: Result) -> None:
    data = encode(curved.layers())
    assert data["contacts"]["a"]["shape"] == [2]
    (stage,) = data["stages"]
    assert stage["normal"]["shape"] == [2]
    assert stage["force"]["shape"] == [8, 3]
    assert stage["pressureCentre"]["shape"] == [2, 3]


def test_capacities_of_facets_add_up() -> None:
    contacts = find_contacts(curve_three_blocks()).contacts
    glue = JointCapacity(np.ones(39), np.full(39, 2.0))
    whole = contacts.with_capacity(glue).joints.capacity
    assert whole is not None
    assert whole.tension.tolist() == np.bincount(contacts.joint).tolist()
    assert (whole.shear >= 1e30).all()


def test_plane_joints_are_what_they_were() -> None:
    result = check(Model.of(tower(3)))
    assert result.contacts.joints is result.contacts


def test_edges_of_smooth_surfaces_are_not_drawn_and_outlines_are() -> None:
    roller = Assembly(curve_three_blocks(40).blocks[2:])
    faces = roller.faces
    edge, _, _ = sharp_edges(faces)
    assert len(edge) == 2 * (faces.count - 2)  # the rims of the two ends
    front = faces.normals @ np.array([1.0, 0.2, 0.3]) > 0.0
    assert len(sharp_edges(faces, front)[0]) == len(edge) + 2
    assert len(sharp_edges(Assembly((box((1.0, 1.0, 1.0)),)).faces)[0]) == 12


def test_a_block_exactly_above_an_edge_is_told() -> None:
    base, top = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 1.0), (0.5, 0.0, 1.0), "top")
    result = check(Model.of(Assembly((base, top), np.array([True, False]))))
    assert result.stable
    (said,) = (one.text for one in result.sentences() if "margin is zero" in one.text)
    assert "'top' stands exactly above an edge of its joint with 'base'" in said
    turn = rotation_about(np.array([1.0, 0.0, 0.0]), 45.0)
    floor, cube = box((4.0, 4.0, 1.0), (-2.0, -2.0, -1.0), "floor"), box((1.0, 1.0, 1.0))
    balanced = Assembly((floor, cube.transformed(turn, np.zeros(3))), np.array([True, False]))
    said = str([one.text for one in check(Model.of(balanced)).sentences()])
    assert "the margin is zero" in said  # it stands on an edge of its own
    for model in (tower(3), curve_three_blocks()):
        told = check(Model.of(model, friction=0.84)).sentences()
        assert not any("margin" in one.text for one in told)


def across_ridges(turned: float) -> Assembly:
    """A bar on two ridges, turned about its length."""
    floor = box((6.0, 6.0, 1.0), (-3.0, -3.0, -1.0), "floor")
    ridges = [
        prism([(x - 0.3, 0.0), (x + 0.3, 0.0), (x, 0.4)], (-0.5, 0.5), f"ridge-{i}")
        for i, x in enumerate((-0.6, 0.6))
    ]
    bar = box((1.8, 0.5, 0.5), (-0.9, -0.25, -0.25), "bar")
    bar = bar.transformed(rotation_about(np.array([1.0, 0.0, 0.0]), turned), np.zeros(3))
    bar = bar.transformed(translation=(0.0, 0.0, 0.4 - float(bar.bounds[0, 2])))
    return Assembly((floor, *ridges, bar)).with_fixed([0])


def test_a_block_on_points_in_one_line_is_told() -> None:
    """Its edge crosses two ridges: two joints, each a point."""
    result = check(across_ridges(45.0), friction=0.6)
    assert result.stable
    (said,) = (one.text for one in result.sentences() if "margin is zero" in one.text)
    assert "'bar' stands exactly on the line of its joints with 'ridge-0' and 'ridge-1'" in said
    for push in (-0.1, 0.1):
        assert check(across_ridges(45.0), friction=0.6, load=f"bar:0,{push},0").falls
    flat = check(across_ridges(0.0), friction=0.6)
    assert flat.stable
    assert not any("margin" in one.text for one in flat.sentences())


def test_what_stands_on_a_line_with_what_it_carries_is_told() -> None:
    """The joint of a beam with the stone on it is no part of the line."""
    piers = [box((0.4, 0.5, 0.5), (x, -0.5, -0.5), f"pier-{x:g}") for x in (-1.0, 0.6)]
    beam = box((2.0, 0.5, 0.5), (-1.0, -0.25, 0.0), "beam")
    stone = box((0.5, 0.5, 0.5), (-0.25, -0.25, 0.5), "stone")
    result = check(Assembly((*piers, beam, stone)).with_fixed([0, 1]), friction=0.6)
    assert result.stable
    told = [one.text for one in result.sentences() if "margin is zero" in one.text]
    assert len(told) == 1
    assert (
        "'beam' stands exactly on the line of its joints with 'pier--1' and 'pier-0.6'" in told[0]
    )
    held = box((2.0, 0.5, 0.5), (-1.0, -0.26, 0.0), "beam")
    more = check(Assembly((*piers, held)).with_fixed([0, 1]), friction=0.6)
    assert not any("margin" in one.text for one in more.sentences())
