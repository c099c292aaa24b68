"""Joints and blocks changed in place: volumes, contacts, friction and loads follow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drystone import Assembly, InputError, LoadCase, Model, find_contacts
from drystone.design import (
    cut_block,
    faces_toward,
    insert_block,
    merge_blocks,
    move_face,
    move_joint,
    still_edge,
    thicken_blocks,
    turn_joint,
    wedge_joint,
)
from drystone.geometry.frames import rotation_about
from drystone.geometry.glue import cut_cell, glue
from drystone.joint_capacity import NO_LIMIT, JointCapacity
from drystone.loads import Earth
from drystone.models import arch, box, prism, shelf, snake, tower, wall
from drystone.ties import tied

CHANGES: list[tuple[Callable[..., Model], tuple[Any, ...], list[float]]] = [
    (turn_joint, (20.0,), [1.0 / np.cos(np.deg2rad(20.0))]),
    (turn_joint, (-7.0,), [1.0 / np.cos(np.deg2rad(7.0))]),
    (move_joint, (0.1,), [1.0]),
    (move_joint, (-0.1,), [1.0]),
    (wedge_joint, (20.0,), [0.5 / np.cos(np.deg2rad(20.0))] * 2),
    (wedge_joint, (-20.0,), [0.5 / np.cos(np.deg2rad(20.0))] * 2),
]
"""A change of the joint of two unit cubes, and the areas of the joint that it makes."""


@pytest.mark.parametrize("turned", [0.0, 2.3, 33.0])
@pytest.mark.parametrize(("change", "values", "areas"), CHANGES)
def test_a_joint_cut_anew_keeps_the_volume_and_has_the_area_of_its_planes(
    change: Callable[..., Model], values: tuple[Any, ...], areas: list[float], turned: float
) -> None:
    rotation = rotation_about(np.array([1.0, 2.0, 3.0]), turned)
    model = Model.of(tower(2).transformed(rotation, (3.0, 2.0, 1.0)), friction=0.6)
    more = {} if change is move_joint else {"axis": rotation @ np.array([0.0, 1.0, 0.0])}
    made = change(model, 0, *values, **more)
    assert made.assembly.volume.sum() == pytest.approx(2.0, rel=1e-12)
    np.testing.assert_allclose(sorted(made.contacts.area), sorted(areas), rtol=1e-9)
    assert model.contacts.count == 1  # the given model is as it was


def test_the_joint_is_turned_by_the_angle_that_is_asked_for() -> None:
    model = Model.of(tower(2), friction=0.6)
    made = turn_joint(model, 0, 12.5, (0.0, 1.0, 0.0))
    normal = rotation_about(np.array([0.0, 1.0, 0.0]), 12.5) @ model.contacts.frame[0, 0]
    np.testing.assert_allclose(made.contacts.frame[0, 0], normal, atol=1e-12)


def test_the_same_change_of_the_same_blocks_is_computed_once_and_no_other_is_taken_for_it() -> None:
    model = Model.of(tower(2), friction=0.6)
    made = turn_joint(model, 0, 10.0, (0.0, 1.0, 0.0))
    rougher = turn_joint(Model.of(model.assembly, friction=0.8), 0, 10.0, (0.0, 1.0, 0.0))
    assert rougher.assembly.blocks[1] is made.assembly.blocks[1]
    assert set(rougher.contacts.friction) == {0.8}
    for other in (
        turn_joint(model, 0, 10.0, (0.0, 1.0, 0.0), 0.1),
        turn_joint(model, 0, 10.0, (1.0, 0.0, 0.0)),
        turn_joint(Model.of(tower(2), friction=0.6), 0, 10.0, (0.0, 1.0, 0.0)),
    ):
        assert other.assembly.blocks[1] is not made.assembly.blocks[1]


@pytest.mark.parametrize("joint", [0, 4, 7])
def test_only_the_joints_of_the_two_blocks_of_an_arch_are_found_anew(joint: int) -> None:
    model = Model.of(arch(0.1, 7), friction=0.7)
    wedged = wedge_joint(model, joint, 15.0)
    assert wedged.assembly.volume.sum() == pytest.approx(model.assembly.volume.sum(), rel=1e-12)
    assert wedged.contacts.count == model.contacts.count + 1
    anew = find_contacts(wedged.assembly).contacts
    np.testing.assert_allclose(sorted(wedged.contacts.area), sorted(anew.area), rtol=1e-9)
    assert set(wedged.contacts.friction) == {0.7}
    pair = {int(model.contacts.block_a[joint]), int(model.contacts.block_b[joint])}
    away = [i for i in range(len(model)) if i not in pair]
    assert all(wedged.assembly.blocks[i] is model.assembly.blocks[i] for i in away)


def test_a_piece_of_the_shelf_is_let_into_the_other_and_its_step_is_a_joint() -> None:
    model = Model.of(shelf(), friction=0.9)
    (joint,) = [i for i in range(model.contacts.count) if model.contacts[i].blocks == (5, 9)]
    made = move_joint(model, joint, -0.02)
    areas = [made.contacts.area[i] for i in range(made.contacts.count)
             if made.contacts[i].blocks == (5, 9)]  # fmt: skip
    assert len(areas) == 3
    gained = made.assembly.volume - model.assembly.volume
    assert gained[9] > 0.0
    assert gained[9] == pytest.approx(-gained[5], rel=1e-3)
    assert made.assembly.volume.sum() == pytest.approx(model.assembly.volume.sum(), rel=1e-6)


@pytest.mark.parametrize("angle", [10.0, -10.0])
def test_turned_about_the_still_edge_a_joint_stays_one_plane(angle: float) -> None:
    model = Model.of(shelf(), friction=0.9)
    (joint,) = [i for i in range(model.contacts.count) if model.contacts[i].blocks == (8, 10)]
    one = turn_joint(model, joint, angle, pivot=still_edge(model, joint, angle))
    other = turn_joint(model, joint, angle, pivot=-still_edge(model, joint, angle))
    assert one.contacts.count == model.contacts.count
    assert other.contacts.count == model.contacts.count + 1


def test_what_would_swallow_a_face_is_refused() -> None:
    model = Model.of(tower(2), friction=0.6)
    with pytest.raises(InputError, match="would remove a whole face; make it smaller"):
        turn_joint(model, 0, 70.0)
    with pytest.raises(InputError, match="remove a whole face"):
        move_joint(model, 0, 1.5)
    with pytest.raises(InputError, match="give a number above -80, below 80"):
        wedge_joint(model, 0, 85.0)
    with pytest.raises(InputError, match="no interface 3"):
        move_joint(model, 3, 0.1)
    with pytest.raises(InputError, match="normal to the joint"):
        turn_joint(model, 0, 5.0, (0.0, 0.0, 1.0))
    with pytest.raises(InputError, match="remove a whole face; move it less"):
        move_face(model, 1, 0, -5.0)


def test_a_block_cut_in_two_and_merged_again_is_what_it_was() -> None:
    model = Model.of(tower(3), friction=0.5)
    middle = model.assembly.centroid[1]
    cut = cut_block(model, "block-1", middle, (1.0, 0.0, 1.0))
    assert len(cut) == 4
    assert cut.assembly.names[3] == "block-1-part-1"
    assert cut.assembly.volume.sum() == pytest.approx(3.0)
    again = merge_blocks(cut, "block-1", "block-1-part-1")
    block, was = again.assembly["block-1"], model.assembly["block-1"]
    assert (len(block.vertices), len(block.faces)) == (8, 6)
    np.testing.assert_allclose(block.bounds, was.bounds, atol=1e-12)
    np.testing.assert_allclose(again.contacts.area, model.contacts.area)
    with pytest.raises(InputError, match="do not touch"):
        merge_blocks(model, 0, 2)
    with pytest.raises(InputError, match="misses block"):
        cut_block(model, 1, middle + 9.0, (0.0, 0.0, 1.0))


def test_a_support_that_is_merged_stays_a_support() -> None:
    made = merge_blocks(Model.of(tower(3), friction=0.5), 1, 0)
    assert made.assembly.names == ("block-1", "block-2")
    assert made.assembly.fixed.tolist() == [True, False]


def test_faces_move_and_thickness_grows_by_its_share() -> None:
    model = Model.of(tower(2), friction=0.5)
    (top,) = faces_toward(model.assembly.blocks[1], np.array([0.0, 0.0, 1.0]))
    assert move_face(model, 1, top, 0.25).assembly.volume[1] == pytest.approx(1.25)
    ring = Model.of(arch(0.1, 7), friction=0.7)
    free = ring.assembly.free.tolist()
    thick = thicken_blocks(ring, free, 0.5)
    # plane intrados and extrados: the depth of the ring grows with it, its middle does not move
    np.testing.assert_allclose(
        thick.assembly.volume[free], 1.5 * ring.assembly.volume[free], rtol=1e-9
    )


def test_which_faces_move_does_not_depend_on_rounding() -> None:
    ground = box((4.0, 4.0, 1.0), (-2.0, -2.0, -1.0), "ground")
    # a square pier that turns about its diagonal
    pier = Model.of(Assembly((ground, box((1.0, 1.0, 3.0)))).with_fixed([0]), friction=0.6)
    axes = [np.array([[1.0, 1.0 + off, 0.0]]) for off in (-1e-12, 0.0, 1e-12)]
    ends = [thicken_blocks(pier, [1], 0.5, axis).assembly.bounds[1] for axis in axes]
    np.testing.assert_allclose(ends, [ends[0]] * 3, atol=1e-9)
    # a hexagonal column: between opposite faces, two of which grow by half their distance together
    for turned in (0.0, 11.0, 40.0):
        angles = np.deg2rad(turned + 60.0 * np.arange(6))
        corners = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        column = prism(corners, (0.0, 1.0), "column")
        behind = box((4.0, 1.0, 4.0), (-2.0, 1.0, -2.0), "behind")
        model = Model.of(Assembly((behind, column)).with_fixed([0]), friction=0.6)
        wide = thicken_blocks(model, [1], 0.2).assembly.blocks[1].vertices
        across = [np.ptp(wide @ (np.cos(at), 0.0, np.sin(at))) for at in angles + np.pi / 6.0]
        assert max(across) == pytest.approx(1.2 * np.sqrt(3.0))
    # without weight no face is steeper than another
    beside = box((1.0, 1.0, 3.0), (1.0, 0.0, 0.0), "beside")
    walled = Assembly((ground, box((1.0, 1.0, 3.0)), beside)).with_fixed([0, 2])
    still = Model.of(walled, load=LoadCase.gravity(walled, g=0.0), friction=0.6)
    thick = thicken_blocks(still, [1], 0.5, np.array([[0.0, 1.0, 0.0]]))
    assert thick.assembly.volume[1] == pytest.approx(4.5)


def test_loads_that_are_no_weight_stay_where_they_act() -> None:
    assembly = tower(2)
    push = LoadCase.point_load(assembly, "block-1", (100.0, 0.0, 0.0), (0.5, 0.0, 2.0))
    model = Model.of(assembly, friction=0.6)
    model = replace(model, load=model.load + push)
    made = move_joint(model, 0, 0.2)
    weight = made.assembly.mass[1] * 9.81
    np.testing.assert_allclose(made.load.wrench[1, :3], [100.0, 0.0, -weight])
    arm = np.array([0.5, 0.0, 2.0]) - made.assembly.centroid[1]
    np.testing.assert_allclose(made.load.wrench[1, 3:], np.cross(arm, [100.0, 0.0, 0.0]), atol=1e-9)
    # a push on every block, as of earth, is no weight either
    loose = assembly.with_fixed([])
    below = LoadCase.moment(loose, "block-0", (0.0, 10.0, 0.0))
    pushed = Model.of(loose, load=LoadCase.gravity(loose) + push + below, friction=0.6)
    thick = thicken_blocks(pushed, [1], 0.5)
    assert thick.load.wrench[1, 0] == pytest.approx(100.0)


def glued_tower() -> Model:
    """Three unit cubes on one another, glued below and above the middle one."""
    model = Model.of(tower(3), friction=0.6)
    return model.with_capacity(JointCapacity.of(model.contacts, tension=100.0, cohesion=40.0))


@pytest.mark.parametrize(
    "change",
    [
        lambda model: wedge_joint(model, 0, 20.0),
        lambda model: turn_joint(model, 1, 10.0),
        lambda model: merge_blocks(model, "block-1", "block-2"),
        lambda model: cut_block(model, "block-1", (0.0, 0.0, 1.5), (1.0, 0.0, 1.0)),
    ],
)
def test_glue_stays_in_the_joints_of_blocks_that_are_cut_anew(
    change: Callable[[Model], Model],
) -> None:
    model = glued_tower()
    made = change(model)
    contacts = made.contacts
    assert contacts.capacity is not None
    below = (contacts.block_a == 0) | (contacts.block_b == 0)
    assert contacts.capacity.tension[below].sum() == pytest.approx(100.0)
    assert contacts.capacity.cohesion[below].sum() == pytest.approx(40.0)
    assert contacts.capacity.shear.min() >= NO_LIMIT
    assert contacts.friction.tolist() == [0.6] * contacts.count


def test_glue_is_weaker_where_less_of_the_joint_is_left() -> None:
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.5, 0.0, 1.0), "out")
    model = Model.of(Assembly((base, out)).with_fixed([0]), friction=0.6)
    model = model.with_capacity(JointCapacity.of(model.contacts, tension=100.0))
    toward = faces_toward(model.assembly.blocks[1], (-1.0, 0.0, 0.0))[0]
    shorter = move_face(model, "out", toward, -0.25)
    assert shorter.contacts.capacity is not None
    assert shorter.contacts.capacity.tension.sum() == pytest.approx(50.0)
    with pytest.raises(InputError, match="would no longer be there"):
        move_face(model, "out", toward, -0.75)


@pytest.mark.parametrize(
    "change", [lambda m: wedge_joint(m, 4, 20.0), lambda m: turn_joint(m, 4, 5.0)]
)
def test_glue_far_from_a_change_stays_as_it_is(change: Callable[[Model], Model]) -> None:
    model = Model.of(tower(6), friction=0.6)
    strength = np.array([100.0, 0.0, 0.0, 0.0, 0.0])
    contacts = change(model.with_capacity(JointCapacity(strength, strength))).contacts
    assert contacts.capacity is not None
    far = (contacts.block_a == 0) & (contacts.block_b == 1)
    assert contacts.capacity.tension[far].tolist() == [100.0]
    assert contacts.capacity.tension[~far].max() == 0.0


def test_a_block_with_a_tie_is_not_changed() -> None:
    model = tied(Model.of(tower(4), friction=0.6), 3, 2)
    with pytest.raises(InputError, match="'block-3' and 'block-2': have a tie between them"):
        wedge_joint(model, 1, 10.0)
    made = wedge_joint(model, 0, 10.0)
    assert made.contacts.count == model.contacts.count + 1


def test_a_block_that_is_inserted_finds_its_contacts() -> None:
    model = Model.of(tower(2), friction=0.6)
    top = float(model.assembly.bounds[1, 1, 2])
    low = model.assembly.bounds[1, 0]
    hat = box((1.0, 1.0, 0.2), (float(low[0]), float(low[1]), top), "hat")
    made = insert_block(model, hat)
    assert made.contacts.count == 2
    assert made.contacts.friction.tolist() == [0.6, 0.6]
    weak = model.with_capacity(JointCapacity.of_stress(model.contacts, compression=5e6))
    crushing = insert_block(weak, hat).contacts
    assert crushing.capacity is not None
    assert crushing.capacity.compression.tolist() == pytest.approx(5e6 * crushing.area)
    drawn = tied(model, 0, 1, strength=1e4)
    for other in (drawn, model.with_capacity(JointCapacity.of(model.contacts, tension=1e3))):
        small = insert_block(other, box((0.1, 0.1, 0.1), tuple(hat.vertices.min(axis=0)), "hat"))
        assert small.contacts.capacity is not None
        assert small.contacts.capacity.compression[-1] == NO_LIMIT
    with pytest.raises(InputError, match="same name"):
        insert_block(model, hat.renamed("block-0"))


def test_pieces_of_a_concave_body_are_put_together_again() -> None:
    section = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
    turn = rotation_about(np.array([3.0, 1.0, 2.0]), 41.0)
    body = prism(section, (0.0, 1.0)).transformed(turn)
    piece = (np.array(body.vertices), list(body.faces))
    below, above = cut_cell([piece], (turn @ [0.0, 0.0, 1.0])[None], np.array([1.5]))
    assert len(above) == 2
    assert len(below) == 1
    assert glue([]) == []
    (whole,) = glue([*below, *above])
    assert (len(whole[0]), len(whole[1])) == (16, 10)
    assert Assembly((replace_body(body, whole),)).volume[0] == pytest.approx(body.volume)


def replace_body(block: Any, piece: Any) -> Any:
    return type(block)(piece[0], tuple(piece[1]), block.name, block.density)


def test_blocks_that_would_overlap_are_refused_and_those_that_did_before_are_not() -> None:
    beside = box((1.0, 1.0, 1.0), (1.2, 0.0, 0.0), "beside")
    model = Model.of(Assembly((*tower(2).blocks, beside)).with_fixed([0]), friction=0.6)
    low = model.assembly.bounds[0, 0]
    toward = faces_toward(model.assembly.blocks[2], (-1.0, 0.0, 0.0))[0]
    reach = float(1.2 - low[0] - 1.0)
    assert move_face(model, "beside", toward, 0.9 * reach).contacts.count == 1
    with pytest.raises(InputError, match="'block-0' and 'beside': would overlap by"):
        move_face(model, "beside", toward, reach + 0.1)
    sunk = box((1.0, 1.0, 1.0), (0.0, 0.0, 0.97), "sunk")
    both = Assembly((box((1.0, 1.0, 1.0), name="base"), sunk)).with_fixed([0])
    deep = Model.of(both, friction=0.6)
    upward = faces_toward(sunk, (0.0, 0.0, 1.0))[0]
    assert move_face(deep, "sunk", upward, 0.1).assembly.volume[1] == pytest.approx(1.1)


def test_a_face_that_runs_back_over_itself_where_it_is_cut_is_glued() -> None:
    model = Model.of(snake(), friction=0.4)
    made = turn_joint(wedge_joint(model, 2, 20.0, first=2), 6, 10.0, pivot=1.0, first=3)
    assert made.assembly.volume.sum() == pytest.approx(model.assembly.volume.sum())


def test_what_earth_presses_gets_thicker_on_the_side_that_it_does_not_press() -> None:
    made = wall(3, 2, ground=True)
    load = LoadCase.gravity(made) + Earth(side="-y", weight=18e3, k=0.33).on(made)
    thick = thicken_blocks(Model.of(made, load=load), made.free.tolist(), 0.5).assembly
    (low, high), (was, far) = (np.moveaxis(x.bounds[made.free, :, 1], 1, 0) for x in (thick, made))
    assert (low == was).all()
    assert high == pytest.approx(1.5 * far)
