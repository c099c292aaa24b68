"""Loads and reactions as layers of pictures, and as tables."""

from pathlib import Path

import numpy as np
import pytest
import shapely

import drystone
from drystone import LoadCase
from drystone.answer.drawing import bare_scene, load_layers
from drystone.joint_capacity import JointCapacity
from drystone.loads import Fill
from drystone.loads.applied import applied_loads
from drystone.models import arch, box, bridge, segmental_bridge, tower
from drystone.view import Layer, save_cad
from drystone.view.palette import is_shown

MODEL = drystone.Model.of(arch(0.3, 12), friction=0.9)
KEY = "voussoir-05"
TOP = MODEL.assembly.bounds[:, 1, 2].max()


def layers(result: drystone.Result) -> dict[str, Layer]:
    """Those of a result, by their keys."""
    return {layer.key: layer for layer in result.stage().layers}


@pytest.fixture(scope="module")
def loaded() -> drystone.Result:
    """The arch with a force, a moment and an earthquake."""
    assembly = MODEL.assembly
    return drystone.check(
        MODEL.with_load(
            LoadCase.gravity(assembly)
            + LoadCase.seismic(assembly, 0.05)
            + LoadCase.point_load(assembly, KEY, (0.0, 0.0, -500.0), at=(0.0, 0.1, 0.9))
            + LoadCase.moment(assembly, 3, (0.0, 30.0, 0.0))
        )
    )


def test_reactions_and_loads_are_in_balance(loaded: drystone.Result) -> None:
    reactions, free = loaded.reactions(), ~loaded.assembly.fixed
    assert reactions["support"].tolist() == [
        loaded.assembly.names[i] for i in np.flatnonzero(~free)
    ]
    wrench, at = loaded.load.wrench[free], loaded.assembly.centroid[free]
    near = 1e-6 * np.abs(wrench[:, 2]).sum()
    assert reactions["force"].sum(axis=0) == pytest.approx(-wrench[:, :3].sum(axis=0), abs=near)
    turned = np.cross(reactions["point"], reactions["force"]) + reactions["moment"]
    loads = np.cross(at, wrench[:, :3]) + wrench[:, 3:]
    assert turned.sum(axis=0) == pytest.approx(-loads.sum(axis=0), abs=near)


def test_a_reaction_is_drawn_at_each_support_toward_the_free_block(loaded: drystone.Result) -> None:
    drawn = layers(loaded)["reactions"]
    assert drawn.single
    assert drawn.vector is not None
    assert (drawn.vector[:, 2] > 0.0).all()
    total = loaded.reactions()["force"].sum(axis=0)
    assert drawn.vector.sum(axis=0) == pytest.approx(total, rel=1e-9)


def test_a_force_ends_where_its_line_enters_the_block(loaded: drystone.Result) -> None:
    drawn = layers(loaded)["loads"]
    assert drawn.position[0, :2] == pytest.approx([0.0, 0.1])
    assert drawn.position[0, 2] == pytest.approx(TOP, abs=0.02)
    assert drawn.vector is not None
    assert drawn.vector[0] == pytest.approx([0.0, 0.0, -500.0])
    table = loaded.loads()
    assert table["block"].tolist() == ["earthquake", KEY, loaded.assembly.names[3]]
    assert table["moment"][2] == pytest.approx([0.0, 30.0, 0.0])
    assert dict(table.units) == {"point": "m", "force": "N", "moment": "N m"}


def test_a_moment_is_drawn_beside_a_force_on_the_same_block() -> None:
    """Together they are a force 0.8 m beside the block."""
    assembly = tower(3)
    load = LoadCase.gravity(assembly) + LoadCase.moment(assembly, 1, (800.0, 0.0, 0.0))
    load += LoadCase.point_load(assembly, 1, (0.0, 0.0, -1000.0))
    drawn = {one.key: one for one in load_layers(assembly, load)}
    assert drawn["moments"].label == "moments, up to 800 N m"
    load += LoadCase.moment(assembly, 2, (1e-27, 0.0, 0.0))  # rounding, as of fill on a crown
    rounded = {one.key: one for one in load_layers(assembly, load)}["moments"]
    np.testing.assert_array_equal(rounded.position, drawn["moments"].position)
    assert drawn["loads"].position[0] == pytest.approx([*assembly.centroid[1, :2], 2.0])


def test_an_earthquake_is_one_arrow_with_the_force_of_all_masses(loaded: drystone.Result) -> None:
    drawn = layers(loaded)["acceleration"]
    mass = loaded.assembly.mass[~loaded.assembly.fixed].sum()
    assert drawn.vector is not None
    assert drawn.vector.tolist() == [pytest.approx([0.05 * 9.81 * mass, 0.0, 0.0])]
    assert "0.05 g" in drawn.label


def test_weight_alone_and_a_tilt_are_not_drawn_as_loads() -> None:
    for load in (LoadCase.gravity(MODEL.assembly), LoadCase.tilt(MODEL.assembly, (0, 1, 0), 4.0)):
        found = layers(drystone.check(MODEL.with_load(load)))
        assert not {"loads", "moments", "acceleration"} & set(found)


def test_a_tilted_model_with_a_force_is_drawn_tilted() -> None:
    assembly = MODEL.assembly
    tilted = LoadCase.tilt(assembly, (0, 1, 0), 4.0)
    force = LoadCase.point_load(assembly, KEY, (0.0, 0.0, -50.0))
    stage = drystone.check(MODEL.with_load(tilted + force)).stage()
    assert stage.up @ [0.0, 0.0, 1.0] == pytest.approx(np.cos(np.deg2rad(4.0)))
    assert stage.gravity == pytest.approx(-stage.up)


def test_reactions_of_two_blocks_on_one_slab_are_drawn_apart() -> None:
    slab = box((4.0, 1.0, 1.0), (-2.0, 0.0, 0.0), "slab")
    two = [box((1.0, 1.0, 1.0), (x, 0.0, 1.0), name=f"at {x:g}") for x in (-1.5, 1.5)]
    assembly = drystone.Assembly((slab, *two), np.array([True, False, False]))
    result = drystone.check(drystone.Model.of(assembly))
    drawn = layers(result)["reactions"]
    assert sorted(drawn.position[:, 0].tolist()) == [pytest.approx(-1.0), pytest.approx(2.0)]
    assert len(result.reactions()) == 1


def test_the_lines_of_forces_pass_where_they_act() -> None:
    assembly = tower(2)
    push = LoadCase.point_load(assembly, "block-1", (10.0, 0.0, 0.0), at=(9.0, 0.5, 1.2))
    found = applied_loads(assembly, LoadCase.gravity(assembly) + push)
    assert found.point.tolist() == [pytest.approx([9.0, 0.5, 1.2])]  # as given
    assert not found.moment.any()


def test_names_of_many_loads_stay_short() -> None:
    assembly = tower(2)
    load = LoadCase.gravity(assembly)
    for _ in range(40):
        load = load + LoadCase.point_load(assembly, "block-1", (1.0, 0.0, 0.0))
    assert load.name.endswith(" + 38 more")
    assert len(load.name) < 80
    both = LoadCase.gravity(assembly) + LoadCase.seismic(assembly, 0.1)
    assert (2.0 * both).name == "2 (gravity + seismic 0.1, 0 g)"


def test_loads_and_reactions_are_in_cad_files(loaded: drystone.Result, tmp_path: Path) -> None:
    save_cad(loaded, tmp_path / "arch.glb")
    content = (tmp_path / "arch.glb").read_bytes()
    for name in (b"loads", b"moments, up to 30 N m", b"reactions at joints of supports", b"0.05 g"):
        assert name in content


def test_of_many_hinges_those_of_the_largest_forces_are_marked() -> None:
    model = drystone.Model.of(tower(32))
    force = np.zeros((model.contacts.corner_count, 3))
    lower = model.contacts.point[:, 0] < 0.5  # each joint presses on one edge
    force[lower, 0] = 100.0 + model.contacts.interface[lower]
    drawn = layers(drystone.Result("rest", drystone.Verdict.STABLE, model, force=force))["edges"]
    assert drawn.label == "force at an edge, where it would turn first, the most loaded of 31"
    assert drawn.interface is not None
    assert sorted(drawn.interface.tolist()) == list(range(7, 31))


def test_joints_that_carry_nothing_do_not_use_most_friction() -> None:
    model = drystone.Model.of(tower(3), friction=0.5)
    force = np.zeros((model.contacts.corner_count, 3))
    force[model.contacts.interface == 0] = (1000.0, 100.0, 0.0)
    force[model.contacts.interface == 1] = (1.0, 0.5, 0.0)
    result = drystone.Result("rest", drystone.Verdict.STABLE, model, force=force)
    (table,) = [one for one in result.tables() if one.key == "most_loaded"]
    assert table["interface"].tolist() == [0, 0]


def test_equal_loads_without_weights_are_loads_and_no_acceleration() -> None:
    assembly = tower(4)
    load = LoadCase.point_load(assembly, 1, (0.0, 0.0, -500.0))
    load += LoadCase.point_load(assembly, 2, (0.0, 0.0, -500.0))
    told = drystone.check(assembly, friction=0.6, load=load).loads()
    assert list(told["block"]) == ["block-1", "block-2"]
    assert np.allclose(told["force"], (0.0, 0.0, -500.0))


def test_edges_that_carry_have_one_name_and_are_no_part_of_a_picture_of_stones_alone() -> None:
    model = drystone.Model.of(arch(0.12), friction=0.7)
    limit = drystone.limit_tilt(model, "y").layers()
    for scene in (drystone.check(model).layers(), limit):
        (mark,) = (one for one in scene.stages[0].layers if one.key == "edges")
        assert mark.label == "force at an edge, where it would turn first"
        assert is_shown(mark, "forces")
        assert not is_shown(mark, "solid")
    (turns,) = (one for one in limit.stages[1].layers if one.key == "hinges")
    assert is_shown(turns, "solid")


def test_a_dry_joint_of_two_planes_is_a_hinge_at_its_edge() -> None:
    """Its rim is measured in one plane: the force at an edge of the other one is beyond it."""
    result = drystone.check(bridge())
    joints = result.joints()
    beyond = np.flatnonzero(joints["edge_ratio"] > 1.01)
    assert beyond.tolist() == [17, 18]
    first = np.unique(result.contacts.joint, return_index=True)[1]
    assert np.isin(first[beyond], layers(result)["edges"].interface).all()


def test_glued_joints_pull_at_corners_and_are_no_hinges_where_their_force_is_outside() -> None:
    model = drystone.Model.of(arch(0.05), friction=0.7)
    assert drystone.check(model).falls
    glued = model.with_capacity(JointCapacity.of(model.contacts, tension=1e4, shear=1e4))
    result = drystone.check(glued)
    assert result.stable
    drawn, joints = layers(result), result.joints()
    assert drawn["tension"].label == "tension that joints carry at a corner"
    assert is_shown(drawn["tension"], "forces")
    assert not is_shown(drawn["tension"], "solid")
    outside = set(np.flatnonzero(joints["edge_ratio"] > 1.01).tolist())
    assert outside
    marked = drawn["edges"].interface if "edges" in drawn else ()
    assert not outside & set(np.ravel(marked).tolist())


def test_the_field_of_fill_does_not_cross_itself_where_a_ring_meets_its_backing() -> None:
    bridge = segmental_bridge(8.0, 2.0, 0.5, 20, height=3.0, backing=0.6)
    fill = Fill(cover=0.4, weight=19e3, k=0.3).on(bridge)
    model = drystone.Model.of(bridge, friction=0.6, load=LoadCase.gravity(bridge) + fill)
    (field,) = (one for one in bare_scene(model).stages[0].layers
                if one.key == "surface")  # fmt: skip
    assert field.vector is not None
    count = len(field.position) // 7
    arrows = np.stack([field.position, field.position + field.vector], axis=1)[: 3 * count, :, ::2]
    drawn = shapely.linestrings(arrows)
    pairs = shapely.STRtree(drawn).query(drawn, predicate="crosses").T
    deep = [shapely.intersection(*drawn[[i, j]]) for i, j in pairs.tolist()]
    ends = [shapely.MultiPoint([*drawn[i].coords, *drawn[j].coords]) for i, j in pairs.tolist()]
    assert all(one.distance(end) < 1e-6 for one, end in zip(deep, ends, strict=True))


def test_gravity_is_drawn_upright_beside_an_earthquake() -> None:
    stage = drystone.check(tower(2), friction=0.6, seismic=(0.2, 0.0)).stage()
    assert stage.gravity.tolist() == [0.0, 0.0, -1.0]
    assert any(one.group == "acceleration" for one in stage.layers)
