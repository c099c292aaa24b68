"""Plans as scenes and as printed instructions."""

import re

import numpy as np
import pytest

from drystone.answer import Role
from drystone.detection import find_contacts
from drystone.model import Model
from drystone.models import arch, box, bridge, corbelled_bridge, prism, tower
from drystone.report import save_instructions
from drystone.sequence import Plan, PlanOptions, Robot, Rules, Status, handling, plan
from drystone.view import State, page_text
from drystone.view.encode import encode
from drystone.view.figure import draw
from drystone.view.sheet import shown_middle


@pytest.fixture(scope="module")
def planned() -> Plan:
    assembly = arch(0.3, 7)
    contacts = find_contacts(assembly, friction=0.4).contacts
    return plan(Model(assembly, contacts), options=PlanOptions(rules=Rules(hands=2)))


def test_a_plan_is_played_step_by_step_and_summed_up(planned):
    scene = planned.layers()
    holding = sum(len(step.during) for step in planned.steps)
    assert holding > 0
    assert len(scene.stages) == len(planned.steps) + holding + 1


def test_blocks_appear_as_they_are_placed(planned):
    scene = planned.layers()
    present = [int((stage.state != State.ABSENT).sum()) for stage in scene.stages]
    assert present[0] >= 3
    assert present == sorted(present)
    assert present[-1] == len(planned.model.assembly)


def test_robots_stand_at_every_stage_and_lines_go_to_what_they_place_and_hold():
    """As the placements and holds of the same team; where each reach ends is near the model."""
    team = (Robot("left", (-2.0, 0.0, 0.0), 2.9), Robot("right", (2.0, 0.0, 0.0)))
    rules = Rules(hands=2, robots=team)
    found = plan(arch(0.3, 7), options=PlanOptions(rules=rules), friction=0.4)
    centroid, names = found.model.assembly.centroid, found.model.assembly.names
    work = handling(found, team)
    holds = 0
    for stage, one in zip(found.layers().stages, work.placements, strict=False):
        layers = {layer.key: layer for layer in stage.layers}
        np.testing.assert_allclose(layers["robots"].position, [arm.base for arm in team])
        ends = layers["arms"].position + layers["arms"].vector
        blocks = [int(np.argmin(np.linalg.norm(centroid - end, axis=1))) for end in ends]
        np.testing.assert_allclose(ends, centroid[blocks], atol=1e-12)
        held = [b for b in blocks if names[b] != one.name]
        assert stage.message.startswith(f"'{one.robot}' places {one.name}")
        holds += len(held)
        places = dict(zip(blocks, layers["arms"].position, strict=True))
        base = next(arm.base for arm in team if arm.name == one.robot)
        np.testing.assert_allclose(places[names.index(one.name)], base)
        edge = layers["reach"].position
        np.testing.assert_allclose(np.linalg.norm(edge - team[0].base, axis=1), 2.9)
    assert holds == sum(len(step.blocks) * (len(step.blocks) - 1) // 2 for step in found.steps) > 0
    last = {layer.key for layer in found.layers().stages[-1].layers}
    assert {"robots", "reach"} <= last
    assert "arms" not in last


def test_a_reach_ends_in_the_plane_of_the_blocks_and_what_is_out_of_it_is_outlined() -> None:
    """From a base aside the sphere of reach meets the plane of the blocks in a smaller circle."""
    arm = Robot("arm", (0.0, -2.0, 0.0), 3.0)
    found = plan(tower(4), options=PlanOptions(rules=Rules(robots=[arm])))
    last = found.layers().stages[-1]
    layers = {layer.key: layer for layer in last.layers}
    edge = layers["reach"].position
    np.testing.assert_allclose(edge[:, 1], 0.5, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(edge - arm.base, axis=1), arm.reach)
    assert found.title == last.headline == "2 blocks cannot be placed: 2 out of reach"
    ends = layers["left-out"].position
    bounds = found.model.assembly.bounds[[*found.impossible]]
    np.testing.assert_allclose([ends.min(axis=0), ends.max(axis=0)],
                               [bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])  # fmt: skip


@pytest.mark.parametrize(
    ("shape", "base", "reach"),
    [(corbelled_bridge(), (-2.5, -1.0, 0.0), 2.5), (arch(0.15, 11), (0.0, -0.8, 0.0), 2.0)],
)
def test_the_end_of_a_reach_is_one_line(shape, base, reach) -> None:
    """It leaves the picture at its top and comes back; below the ground nothing is drawn."""
    team = [Robot("arm", base, reach), Robot("else")]
    found = plan(shape, friction=0.7, options=PlanOptions(rules=Rules(robots=team)))
    (edge,) = (one for one in found.layers().stages[-1].layers if one.key == "reach")
    np.testing.assert_allclose((edge.position + edge.vector)[:-1], edge.position[1:], atol=1e-12)
    ring = np.sqrt(reach**2 - (edge.position[0, 1] - base[1]) ** 2)
    assert edge.position[:, 2].max() == pytest.approx(ring)
    assert edge.position[:, 2].min() > found.model.assembly.bounds[:, 0, 2].min() - 0.01


def test_bases_and_ends_of_reach_have_the_names_of_their_robots() -> None:
    team = [Robot("left", (-2.0, 0.0, 0.0), 2.9), Robot("right", (2.0, 0.0, 0.0), 2.9)]
    found = plan(bridge(), friction=0.5, options=PlanOptions(rules=Rules(robots=team)))
    scene = found.layers()
    layers = {layer.key: layer for layer in scene.stages[-1].layers}
    assert layers["robots"].text == ("left", "right")
    edge = layers["reach"]
    assert sorted(filter(None, edge.text)) == ["reach of left", "reach of right"]
    for place, name in zip(edge.position, edge.text, strict=True):
        base = np.array(team[name == "reach of right"].base)
        if name:
            assert np.linalg.norm(place - base) == pytest.approx(2.9)
    written = [one.get_text() for one in draw(scene, (9.0, 6.5)).axes[0].texts]
    assert [written.count(one) for one in (*layers["robots"].text, *edge.text) if one] == [1] * 4
    sent = [one for one in encode(scene)["stages"][-1]["layers"] if "text" in one]
    told = [sorted(text for _, text in one["text"]) for one in sent]
    assert told == [["left", "right"], ["reach of left", "reach of right"]]


def test_the_names_of_two_reaches_that_end_on_one_line_lie_apart() -> None:
    """One lay on the other in a figure, and was left out on a page."""
    team = [Robot("left", (0.5, -2.0, 0.0), 3.8), Robot("right", (0.5, 3.0, 0.0), 3.8)]
    found = plan(tower(3), options=PlanOptions(rules=Rules(robots=team)))
    (edge,) = (one for one in found.layers().stages[-1].layers if one.key == "reach")
    first, second = (edge.position[i] for i, name in enumerate(edge.text) if name)
    assert first[2] == edge.position[:, 2].max()
    assert 0.5 < np.linalg.norm(second - first) < 1.0


def test_the_base_of_a_robot_behind_blocks_is_hollow() -> None:
    """In a figure it lay on them as if it stood before them."""
    team = [Robot("front", (0.5, -3.0, 0.5)), Robot("back", (0.5, 3.0, 0.5))]
    scene = plan(tower(2), options=PlanOptions(rules=Rules(robots=team))).layers()
    for eye, filled in ((-1.0, [True, False]), (1.0, [False, True])):
        drawn = draw(scene, (4.0, 3.0), toward=np.array([0.0, eye, 0.0])).axes[0].collections
        (bases,) = (one for one in drawn if len(one.get_offsets()) == 2)
        assert (bases.get_facecolors()[:, 3] > 0.0).tolist() == filled


def test_the_last_stage_shows_every_status(planned):
    state = planned.layers().stages[-1].state
    wanted = {Status.SUPPORT: State.SUPPORT, Status.FREE: State.FREE, Status.HELD: State.HELD,
              Status.PROPPED: State.PROPPED}  # fmt: skip
    np.testing.assert_array_equal(state, [wanted[one] for one in planned.status])


def test_a_block_has_its_colour_while_it_is_propped_and_is_hatched_before(planned):
    scene = planned.layers()
    for step, stage in zip(planned.steps, _ends(scene.stages[:-1]), strict=True):
        assert set(np.flatnonzero(stage.state == State.PROPPED)) == set(step.props)
    for prop in planned.props:
        seen = [stage.state[prop.block] for stage in scene.stages[:-1]]
        later = [state for state in seen if state in (State.LATER, State.COMING)]
        assert seen.index(State.PROPPED) == seen.count(State.ABSENT) + len(later)


def test_what_carries_while_a_block_is_held_is_told(planned):
    """A prop of the step before stays until the hold ends."""
    helped = [stage for stage in planned.layers().stages[:-1] if stage.prop.any()]
    for stage in helped:
        told = np.isin(stage.state, (State.HELD, State.PROPPED))
        assert told[np.abs(stage.prop).max(axis=1) > 0.0].all()
    assert any("prop and a hand" in stage.headline for stage in helped)


def test_a_hand_lets_go_when_its_step_has_ended(planned):
    scene = planned.layers()
    assert any((stage.state == State.HELD).any() for stage in scene.stages[:-1])
    for stage in _ends(scene.stages[:-1]):
        assert not (stage.state == State.HELD).any()
        assert "hand" not in stage.headline


def test_stages_and_blocks_are_numbered_alike_and_each_block_comes_in_along_its_way(planned):
    scene = planned.layers()
    rows = planned.table()
    assert planned.sentences()[0].role is Role.UNSURE  # two props: the title has its colour
    assert scene.stages[-1].role is Role.UNSURE
    assert max(rows["step"]) < len(rows["step"])  # some steps place several blocks
    for name, position, stage in zip(rows["block"], rows["step"], scene.stages[:-1], strict=True):
        (block,) = np.flatnonzero(np.linalg.norm(stage.motion, axis=1))
        assert planned.model.assembly.names[block] == name
        assert scene.number[block] == position
        assert stage.label.startswith(f"step {position} of {len(planned.steps)}")
        assert stage.headline.startswith(f"Step {position} of {len(planned.steps)}: ")
        step = planned.steps[position - 1]
        way = step.motion[step.blocks.index(block)]
        along = stage.motion[block, :3] / np.linalg.norm(stage.motion[block, :3])
        np.testing.assert_allclose(along, -way, atol=1e-9)


def test_stages_carry_their_own_forces(planned):
    scene = planned.layers()
    for step, stage in zip(planned.steps, _ends(scene.stages[:-1]), strict=True):
        here = stage.state != State.ABSENT
        contacts = scene.contacts
        away = ~(here[contacts.block_a] & here[contacts.block_b])
        assert stage.normal is not None
        assert not stage.normal[away].any()
        assert (stage.normal.sum() > 0.0) == bool(step.answer.force.any())


def test_the_page_holds_all_stages_and_names_them(planned):
    text = page_text(planned.layers())
    assert "step 1 of" in text
    assert "all blocks" in text
    assert "props and hands" in text


def test_instructions_number_the_blocks_in_order_and_need_nothing_else(planned, tmp_path):
    path = tmp_path / "instructions.html"
    save_instructions(planned, path)
    text = path.read_text(encoding="utf-8")
    rows = planned.table()
    for name, step in zip(rows["block"], rows["step"], strict=True):
        assert f"<td><bdi>{step}</bdi></td><td><bdi>{name}</bdi></td>" in text
    assert "moved along" in text
    assert text.count(f"{len(planned.steps)} steps: ") == 1
    assert "<script" not in text
    assert not re.search(r"https?://|@import", text)


def test_a_number_lies_on_the_side_of_its_block_that_is_seen():
    # a wedge of which four of six vertices are near, on the slope that faces up and to the left
    ramp = prism([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)], (0.0, 1.0), "ramp")
    slope = np.array([-1.0, 0.0, 2.0]) / np.sqrt(5.0)
    np.testing.assert_allclose(shown_middle(ramp, slope), [1.0, 0.5, 0.5], atol=1e-9)
    np.testing.assert_allclose(
        shown_middle(box((1.0, 2.0, 3.0)), np.array([0.1, -0.9, 0.2])), [0.5, 0.0, 1.5], atol=1e-9
    )


def _ends(stages):  # type: ignore[no-untyped-def]
    return [stage for stage in stages if "held while" not in stage.message]
