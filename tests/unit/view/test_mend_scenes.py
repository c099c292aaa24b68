"""Why a model falls and what it became, as scenes; blocks that are pushed; what was asked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

import drystone
from drystone.answer.question import asked_line
from drystone.assembly import Assembly, replace_block
from drystone.base.arrays import lengths
from drystone.checks import corner_motion
from drystone.design import Changed, DiagnosisOptions, MendOptions, find_mends
from drystone.design.changes import ballasted, glued
from drystone.design.props import PropSeat, with_props
from drystone.joint_capacity import JointCapacity
from drystone.model import Origin
from drystone.models import arch, box, incline, tower, wall
from drystone.settlement import push
from drystone.ties import tied
from drystone.view import LayerKind, State, scene_of
from drystone.view.page import panel


def test_a_diagnosis_shows_the_props_that_would_hold_it_and_nothing_else_pulls():
    model = drystone.Model.of(arch(0.2, 5), friction=0.2)
    found = drystone.diagnose(replace(model, origin=Origin("folder/arch.json")))
    scene = scene_of(found)
    (stage,) = scene.stages
    assert not [layer for layer in stage.layers if layer.kind is LayerKind.ARROWS]
    (props,) = [layer for layer in stage.layers if layer.key == "help"]
    assert (props.kind, props.colour) == (LayerKind.LINES, "help")
    assert props.vector is not None
    point, force = found.props
    np.testing.assert_array_equal(props.position, point)
    along = (props.vector * force).sum(axis=1)  # a post stands where its force comes from
    np.testing.assert_allclose(along, -np.prod([lengths(props.vector), lengths(force)], axis=0))
    assert scene.facts["File"] == "arch.json"
    assert "friction" in stage.message
    assert (stage.state == State.FALLING).any()


def test_blocks_that_were_turned_and_the_pins_of_a_tie_are_not_in_the_heading():
    one, two = tower(2).blocks
    turned = replace_block(two, vertices=two.vertices, faces=tuple(f[::-1] for f in two.faces))
    model = drystone.Model.of(replace(tower(2), blocks=(one, turned)), friction=0.6)
    note = f"block 'block-1': {turned.repairs[0]}"
    scene = scene_of(replace(tied(model, 1, 0), notes=(note, "mortar")))
    assert scene.stages[0].message == "mortar"
    assert (scene.facts["Notes"], scene.facts["Friction"]) == (f"{note}; mortar", "0.6")


def test_a_mended_model_says_what_was_changed_and_shows_the_edges_of_what_it_was():
    before = drystone.Model.of(tower(2), friction=0.6)
    lower = box((1.0, 1.0, 0.5), (0.0, 0.0, 1.0), "block-1")
    changed = replace(before.assembly, blocks=(before.assembly.blocks[0], lower))
    after = drystone.check(drystone.Model.of(changed, friction=0.6))
    scene = Changed.by_hand(before, after, "block 'block-1' lower").layers()
    (was,) = [layer for layer in scene.stages[0].layers if layer.label.startswith("edges")]
    assert was.count == 8  # the upper half of one box; a block has its own edges as it is now
    assert was.width < 1.0
    assert (was.position[:, 2] + was.vector[:, 2] * 0.5 >= 1.75).all()
    assert scene.facts["Changed"] == "block 'block-1' lower"
    assert asked_line(scene.facts).endswith("changed: block 'block-1' lower")


def test_hinges_of_a_pushed_model_are_carried_to_where_they_are_at_the_end():
    found = push(drystone.Model.of(arch(0.2, 6), friction=0.9))
    last = found.states[-1]
    (stage,) = scene_of(found).stages
    (marks,) = [layer for layer in stage.layers if layer.key == "hinges"]
    motion = last.positions[marks.block]
    centroid = found.assembly.centroid[marks.block]
    arm = Rotation.from_rotvec(motion[:, 3:]).apply(marks.position - centroid)
    place = last.resultants.position[list(last.hinges)]
    np.testing.assert_allclose(centroid + motion[:, :3] + arm, place, atol=1e-9)
    assert stage.headline == f"Push: {found.message}"


def test_what_was_asked_is_told_in_one_line():
    model = replace(drystone.Model.of(tower(2), friction=0.5), origin=Origin("a/b/tower.json"))
    scene = scene_of(drystone.check(model))
    line = asked_line(scene.facts, "2026, drystone 1")
    assert line == (
        "tower.json · 2 blocks · free mass 2.4 t · density 2400 kg/m³"
        " · friction 0.5 · gravity · supports: block-0 · 2026, drystone 1"
    )
    numbered = [replace(one, name=str(i)) for i, one in enumerate(tower(2).blocks)]
    told = asked_line(scene_of(replace(tower(2), blocks=tuple(numbered))).facts)
    assert "supports: block 0" in told  # not a count
    bare = replace(tower(2), fixed=np.zeros(2, dtype=bool))
    assert "no supports" in asked_line(scene_of(bare).facts)


def test_the_hinges_of_a_thin_arch_are_those_that_its_sentence_counts() -> None:
    model = drystone.Model.of(arch(0.09, 12), friction=0.7)
    found = drystone.check(model)
    options = DiagnosisOptions(kinds=())
    (sentence,) = drystone.diagnose(model, result=found, options=options).reasons
    assert "5 joints are hinges" in sentence
    (stage,) = scene_of(found).stages
    (hinges,) = (layer for layer in stage.layers if layer.key == "hinges")
    assert hinges.count == 5
    assert stage.motion is not None
    moved = corner_motion(model.assembly, model.contacts, stage.motion)
    assert moved[:, 0].min() > -1e-5 * np.abs(moved).max()  # no block enters another


def test_a_hinge_is_a_joint_that_turns_about_an_edge_in_words_and_in_the_picture() -> None:
    """Slabs far out on lintels over four posts: forces act at the edges of four joints, and the
    lintels turn on two posts."""
    blocks = [box((8.0, 8.0, 1.0), (-2.0, -2.0, -1.0), "ground")]
    places = [(0.0, 0.0), (3.0, 0.0), (0.0, 3.0), (3.0, 3.0)]
    blocks += [box((0.4, 0.4, 2.0), (*at, 0.0), f"post-{i}") for i, at in enumerate(places)]
    blocks += [box((6.9, 0.4, 0.3), (0.0, 3.0 * i, 2.0), f"lintel-{i}") for i in range(2)]
    blocks += [box((1.2, 3.4, 0.2), (5.7 + 1.2 * i, 0.0, 2.3), f"slab-{i}") for i in range(3)]
    model = drystone.Model.of(Assembly(tuple(blocks), np.arange(len(blocks)) < 1), friction=0.6)
    found = drystone.check(model)
    (region,) = drystone.diagnose(model, result=found, options=DiagnosisOptions(kinds=())).regions
    assert "hinge about edges of 'post-1' and 'post-3'" in region.sentence
    assert "2 joints are hinges" in region.sentence
    (stage,) = scene_of(found).stages
    (hinges,) = (layer for layer in stage.layers if layer.key == "hinges")
    assert hinges.count == 2


def test_what_a_mend_added_is_marked_and_what_was_there_is_not() -> None:
    before = drystone.Model.of(tower(4), friction=0.6)
    before = before.with_capacity(JointCapacity.of(before.contacts, tension=[0.0, 0.0, 9.0]))
    seat = PropSeat(3, box((0.1, 0.1, 0.1), (1.0, 0.0, 3.2)).vertices[[0, 3, 7, 4]], (-1.0, 0, 0))
    after = with_props(tied(glued(before, np.array([0]), 50.0), 2, 1), [seat])
    friction = np.array(after.contacts.friction)
    friction[1] = 0.9
    after = after.with_friction(friction).with_load(ballasted(after, 3, 100.0).load)
    (stage,) = Changed.by_hand(before, drystone.check(after)).layers().stages
    layers = {layer.key: layer for layer in stage.layers}
    assert (layers["glued"].label, layers["glued"].count) == ("1 glued joint", 4)
    assert layers["rougher"].label == "1 rougher joint"
    np.testing.assert_allclose(layers["tie-forces"].position[0], after.assembly.centroid[1])
    np.testing.assert_allclose(layers["weights"].vector, [[0.0, 0.0, -100.0]])
    assert after.assembly.names[4] == "prop-1"
    assert (stage.state == State.ADDED).tolist() == [False] * 4 + [True]
    nothing = Changed.by_hand(after, drystone.check(after)).layers().stages[0]
    assert not {"glued", "rougher", "weights"} & {one.key for one in nothing.layers}
    assert "1 tie" not in {one.label for one in nothing.layers}
    assert not (nothing.state == State.ADDED).any()


def test_the_picture_of_a_prop_has_its_force_and_the_page_its_option_unbroken() -> None:
    found = find_mends(incline(20.0), friction=0.2, options=MendOptions(kinds=("prop",)))
    scene = scene_of(found)
    (post,) = [layer for layer in scene.stages[1].layers if layer.key == "help"]
    assert "a prop of 1.45 kN" in scene.stages[1].headline
    assert post.label == "1 prop, 1.45 kN"  # W (sin 20 - 0.2 cos 20)
    assert post.vector is not None
    assert post.vector[0, 0] > 0.0  # its force is towards -x, as its sentence says
    assert "<code>--apply 1</code>" in panel(scene.charts[0])
    assert scene.opens == 1  # the first mend is seen, and why it falls is before it
    assert any("drystone plan mended.json" in one.text for one in found.sentences())


def test_a_wall_opens_in_elevation_and_where_it_falls_out_of_its_plane_from_the_side() -> None:
    model = drystone.Model.of(wall(3, 3), friction=0.6)
    assert scene_of(drystone.check(model)).plane == 1
    assert scene_of(drystone.check(model.with_load((4.0, 0.0, -9.81)))).plane == 1
    assert scene_of(drystone.check(model.with_load((0.0, 5.5, -9.81)))).plane is None
