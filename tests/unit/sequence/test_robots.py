"""Plans as work for robots: who places, who holds, on which path, and by which faces."""

import csv
import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drystone import InputError, Model, Structure, Verdict, plan
from drystone.answer import Role, State
from drystone.assembly import Assembly, replace_block
from drystone.base.display import rounded_up
from drystone.geometry.frames import rotation_about
from drystone.models import (
    arch,
    bayonet,
    box,
    bridge,
    corbelled_bridge,
    prism,
    tower,
    wall,
    welded,
)
from drystone.sequence import (
    Plan,
    PlanOptions,
    Robot,
    Rules,
    handling,
    margins,
    scaffolding,
    take_turns,
    without_robot,
)
from drystone.sequence.freedom import Joints
from drystone.sequence.handling import grip_faces

LEFT, RIGHT = Robot("left", (-2.0, 0.0, 0.0), 3.0), Robot("right", (2.0, 0.0, 0.0), 3.0)
UNEQUAL = [Robot("a", (-3.0, 0.0, 0.0), 3.2), Robot("b", (3.0, 0.0, 0.0), 2.2)]


@cache
def shallow() -> Plan:
    """Of an arch as deep as it is thick."""
    return plan(arch(0.2, 11, depth=0.2), friction=0.7)


def test_two_robots_place_blocks_in_turn():
    work = handling(plan(tower(5)), [Robot("a"), Robot("b")])
    assert [one.robot for one in work.placements] == ["a", "b", "a", "b"]
    assert work.notes == ()


def test_a_block_goes_to_a_robot_that_reaches_it():
    found = plan(bridge(), friction=0.5)
    work = handling(found, [LEFT, RIGHT])
    far = {one.name: one for one in handling(found).placements}
    for one in work.placements:
        robot = LEFT if one.robot == "left" else RIGHT
        away = np.linalg.norm(one.approach[:, :3, 3] - np.array(robot.base), axis=1)
        assert (away <= robot.reach + 1e-9).all()
        # the whole path comes from far outside; this is its last part
        assert away[0] == pytest.approx(robot.reach)
        start, end = far[one.name].approach[-len(one.approach) :][:2, :3, 3]
        np.testing.assert_allclose(
            np.cross(one.approach[0, :3, 3] - start, end - start), 0, atol=1e-9
        )
        np.testing.assert_allclose(
            one.approach[1:], far[one.name].approach[1 - len(one.approach) :]
        )
    assert work.notes == ()


def test_the_clearance_where_a_path_enters_the_reach_is_that_of_its_pose():
    """The block comes down on the tower: as far above it as it is above its place."""
    team = (Robot("arm", reach=4.0),)
    (*_, last) = handling(plan(tower(4)), team).placements
    above = last.approach[0, 2, 3] - last.frame[2, 3]
    assert len(last.approach) == 2
    assert 0.2 < above < 1.0
    assert last.clearance.tolist() == [pytest.approx(above), 0.0]


def test_what_no_robot_can_place_is_said():
    weak = Robot("weak", payload=1.0)
    work = handling(plan(tower(3)), [weak])
    assert [one.robot for one in work.placements] == ["", ""]
    assert "too heavy" in work.notes[0]
    assert "'block-1'" in work.notes[0]


def test_what_no_robot_can_place_carries_nothing_in_the_search():
    near = Rules(robots=(Robot("a", base=(-1, -1, 0), reach=2.0, payload=60.0),))
    found = plan(wall(), friction=0.6, options=PlanOptions(rules=near))
    assert found.counts["impossible"] == 21
    # with 'c02-b01', which is out of reach, beside it 'c02-b00' would do without 'c01-b01'
    assert found.order[:3] == ("c01-b00", "c01-b01", "c02-b00")
    assert not found.on_edge
    far = Rules(robots=(Robot("a", base=(-1, -1, 0), reach=3.0, payload=100.0),))
    found = plan(wall(), friction=0.6, options=PlanOptions(rules=far))
    assert (found.counts["free"], found.counts["unsure"]) == (22, 0)


@pytest.mark.parametrize(
    ("structure", "friction", "team", "missing", "waiting"),
    [
        # the ends are too heavy, and the key hangs between them
        (corbelled_bridge(depth=0.2, height=0.3, tail=0.6, reach=0.35), 0.5,
         [Robot("a", (-2.0, 0.0, 0.0), 3.0, 200.0), Robot("b", (2.0, 0.0, 0.0), 3.0, 200.0)],
         2, {"key"}),
        # a ring that never closes: its lower voussoirs stand alone
        (arch(), 0.5, UNEQUAL,
         12, {f"voussoir-{i:02d}" for i in range(6, 18)}),
        (arch(voussoirs=4), 0.6, UNEQUAL, 1, {"voussoir-00", "voussoir-01", "voussoir-03"}),
    ],
)  # fmt: skip
def test_what_waits_for_a_block_that_nobody_places_is_not_placed_in_the_air(
    structure: Assembly, friction: float, team: list[Robot], missing: int, waiting: set[str]
) -> None:
    found = plan(structure, friction=friction, options=PlanOptions(rules=Rules(robots=team)))
    names = structure.names
    why = {names[b]: one for b, one in found.impossible.items()}
    assert {name for name, one in why.items() if one.startswith("waiting for them")} == waiting
    assert len(why) == missing + len(waiting)
    assert {*found.order} == {names[b] for b in structure.free} - {*why}
    assert all(step.answer.stands for step in found.steps)
    assert not found.counts["unsure"]
    assert not found.props
    assert all(row for row in found.table()["robot"])
    first, *others = found.sentences()
    assert first.role is Role.BAD
    assert not any("every stage stands" in one.text for one in others)
    last = found.layers().stages[-1]
    assert last.headline == found.title
    assert "left-out" in {layer.key for layer in last.layers}


def test_the_note_of_what_is_out_of_reach_tells_the_farthest() -> None:
    arm = Robot("arm", reach=1.6)
    found = plan(tower(4), options=PlanOptions(rules=Rules(robots=[arm])))
    away = float(arm.distance(found.model.assembly.centroid[3])) - 1.6
    told = rounded_up(away, 3)
    assert f"'block-3' is {told:g} m too far for 'arm', the robot that comes" in found.notes[0]
    enough = PlanOptions(rules=Rules(robots=[Robot("arm", reach=1.6 + told)]))
    assert not plan(tower(4), options=enough).impossible


def test_what_comes_after_a_block_that_nobody_places_is_not_placed() -> None:
    lower = Robot("low", reach=3.0)
    rules = Rules(robots=[lower], before=[("block-3", "block-1")])
    found = plan(tower(4), options=PlanOptions(rules=rules))
    assert found.impossible[1].startswith("waiting for them: to come after 'block-3'")
    assert found.order == ()


def test_each_block_of_a_step_has_a_robot_of_its_own() -> None:
    """Two stones that hold each other, and a second robot that reaches neither."""
    near, far = Robot("a", (-1.0, 0.0, 0.0), 5.0), Robot("b", (9.0, 0.0, 0.0), 2.2)
    both = replace(far, base=(1.0, 0.0, 0.0), reach=5.0)
    for second, held in ((both, 2), (far, 0)):
        team = [near, second]
        chosen = PlanOptions(rules=Rules(robots=team))
        found = plan(arch(0.25, 2), friction=0.7, options=chosen)
        assert found.counts["held"] == held
        assert without_robot(found, team) == []


def test_the_table_of_a_plan_names_the_robot_of_each_block():
    team = [Robot("left", base=(-2, 0, 0)), Robot("right", base=(2, 0, 0))]
    found = plan(bridge(), friction=0.5, options=PlanOptions(rules=Rules(robots=tuple(team))))
    table = found.table()
    assert table["robot"].tolist() == [one.robot for one in handling(found, team).placements]
    assert "robot" not in table.hidden
    assert {"robot", "with", "hold_force", "prop_force", "margin"} <= {
        *plan(tower(2)).table().hidden
    }


def test_the_table_of_a_plan_says_which_way_a_block_comes_in_that_does_not_come_down():
    at = {"floor": (-1, -1, -1), "roof": (-1, -1, 1), "end": (1, 0, 0), "left": (0, 1, 0),
          "right": (0, -1, 0), "drawer": (0, 0, 0), "top": (0, 0, 2)}  # fmt: skip
    blocks = [box((3, 3, 1) if z in (-1, 1) else (1, 1, 1), (x, y, z), name)
              for name, (x, y, z) in at.items()]  # fmt: skip
    table = plan(Assembly(tuple(blocks), np.arange(7) < 5)).table()
    assert table["insertion"].tolist() == ["1, 0, 0", ""]
    assert "insertion" not in table.hidden
    assert "insertion" in plan(tower(2)).table().hidden


def test_the_approach_ends_in_place_and_begins_away():
    work = handling(plan(tower(3)))
    for one in work.placements:
        np.testing.assert_allclose(one.approach[-1], one.frame, atol=1e-12)
        assert np.linalg.norm(one.approach[0][:3, 3] - one.frame[:3, 3]) > 1.0
        assert one.clearance[-1] == 0.0
        assert one.clearance[0] > 0.5


def test_a_block_that_turns_in_has_turning_poses():
    (one,) = handling(plan(Model.of(bayonet()))).placements
    assert one.turning
    turns = [pose[:3, :3] for pose in one.approach]
    assert any(np.abs(turn - np.eye(3)).max() > 0.5 for turn in turns)
    for turn in turns:
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)


def test_a_block_on_a_tower_is_gripped_at_all_but_its_bottom():
    model = Model.of(tower(2))
    joints = Joints.of(model.contacts, 1, np.array([True, False]))
    grips = grip_faces(model.assembly.blocks[1], joints)
    assert len(grips) == 5
    assert all(grip.normal[2] > -0.5 for grip in grips)
    (top,) = handling(plan(tower(2))).placements
    assert [round(width, 9) for _, _, width in top.pairs] == [1.0, 1.0]


def test_a_plan_says_before_which_block_each_permanent_prop_must_stand():
    shelf = box((3.0, 1.0, 1.0), name="base")
    blocks = [shelf]
    blocks += [box((1.0, 1.0, 0.2), (x, 0.0, 1.0), name) for x, name in ((-0.8, "a"), (2.8, "b"))]
    blocks += [box((0.2, 1.0, 0.2), (x, 0.0, 0.8), f"prop-{i}") for i, x in ((1, -0.8), (2, 3.6))]
    found = plan(Model.of(Assembly(tuple(blocks), [True, False, False, True, True])))
    needs = "2 permanent props, which must be there before the first block on each: 'a', 'b'"
    assert needs in [one.text for one in found.sentences()]
    assert found.layers().stages[-1].force.any()  # the page opens with these


def test_triangles_in_one_plane_are_gripped_as_one_face():
    def work_of(shape):
        return handling(plan(Model.of(Assembly((box((1.0, 1.0, 0.1)), shape), [True, False]))))

    lintel = box((0.12, 0.06, 0.04), (0.3, 0.3, 0.1), name="lintel")
    halves = [half for a, b, c, d in lintel.faces for half in ((a, b, c), (a, c, d))]
    (one,), (other,) = (
        work_of(replace_block(lintel, faces=faces)).placements
        for faces in (lintel.faces, tuple(halves))
    )
    assert len(other.grips) == 5
    for grip, same in zip(other.grips, one.grips, strict=True):
        np.testing.assert_allclose(grip.centre, same.centre, atol=1e-12)
    np.testing.assert_allclose(other.pairs, one.pairs, atol=1e-12)


def test_a_face_with_a_hole_is_gripped_on_its_material():
    outer, inner = ([(x, y) for x, y in ((-a, -a), (a, -a), (a, a), (-a, a))] for a in (1.0, 0.5))
    quads = [[outer[i], outer[i - 1], inner[i - 1], inner[i]] for i in range(4)]
    flat = [[(*p, z) for p in quad] for z in (0.0, 1.0) for quad in quads]
    sides = [
        [(*ring[i], 0.0), (*ring[i - 1], 0.0), (*ring[i - 1], 1.0), (*ring[i], 1.0)]
        for ring in (outer, inner) for i in range(4)
    ]  # fmt: skip
    frame = welded([*flat, *sides], "frame")
    joints = Joints.of(Model.of(tower(2)).contacts, 1, np.array([False, False]))
    top, bottom = (one for one in grip_faces(frame, joints) if abs(one.normal[2]) > 0.5)
    assert 0.5 < np.abs(top.centre[:2]).max() < 1.0
    np.testing.assert_allclose(top.centre[:2], bottom.centre[:2], atol=1e-9)


@pytest.mark.parametrize("turn", [-45.0, 45.0, 135.0])
def test_opposite_faces_of_a_turned_fork_are_gripped_at_the_same_prong(turn):
    outline = [(0, 0), (3, 0), (3, 3), (2.6, 3), (2.6, 0.4), (0.4, 0.4), (0.4, 3), (0, 3)]
    fork = prism(outline, (0.0, 1.0)).transformed(rotation_about(np.array([0.0, 0.0, 1.0]), turn))
    joints = Joints.of(Model.of(tower(2)).contacts, 1, np.array([False, False]))
    one, other = (grip for grip in grip_faces(fork, joints) if len(fork.faces[grip.face]) == 8)
    across = one.centre - other.centre
    np.testing.assert_allclose(across, one.normal, atol=1e-8)


def test_held_blocks_have_a_hold_until_their_partner_is_in():
    found = plan(arch(0.3, 7), friction=0.4, options=PlanOptions(rules=Rules(hands=2)))
    work = handling(found, [Robot("a"), Robot("b")])
    held = [step for step in found.steps if len(step.blocks) > 1]
    assert len(work.holds) == sum(len(step.blocks) - 1 for step in held) > 0
    told = {row["block"]: row["hold_force"] for row in found.table() if row["hold_force"]}
    assert told == {one.name: np.linalg.norm(one.force) for one in work.holds}
    for hold in work.holds:
        placed = {one.name: one for one in work.placements}
        assert placed[hold.name].robot == hold.robot
        assert placed[hold.until].robot != hold.robot
        assert np.linalg.norm(hold.force) > 0.0


def test_a_placement_says_how_a_cell_places_it(tmp_path):
    """Status, direction, what is left of the reach, props, and the margins of its stage."""
    found = plan(arch(0.3, 7), friction=0.7)
    known = margins(found, tilt_width=5.0, directions=1)
    work = handling(found, [LEFT, RIGHT], margins=known)
    status = {row["block"]: row["status"] for row in found.table()}
    for one in work.placements:
        robot, step = (LEFT if one.robot == "left" else RIGHT), found.steps[one.step - 1]
        assert one.status == status[one.name]
        last = one.approach[-1, :3, 3] - one.approach[-2, :3, 3]
        np.testing.assert_allclose(one.insertion, last / np.linalg.norm(last))
        away = np.linalg.norm(one.frame[:3, 3] - np.array(robot.base))
        assert one.reach_spare == pytest.approx(robot.reach - away)
        assert one.props == tuple(found.model.assembly.names[b] for b in step.props)
        assert one.margins == known.stages[one.step - 1]
    assert "propped" in status.values()
    work.table().to_csv(tmp_path / "work.csv")
    with (tmp_path / "work.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["status"] for row in rows] == [one.status for one in work.placements]
    assert float(rows[0]["tilt [deg]"]) == known.stages[0].tilt
    assert float(rows[0]["insertion_z"]) == pytest.approx(work.placements[0].insertion[2])


def test_props_of_the_step_before_stay_while_a_block_is_held():
    """With them and the hold what is in place stands; without them some of it falls."""
    found = plan(arch(0.2, 9), friction=0.5, options=PlanOptions(rules=Rules(hands=3)))
    work = handling(found, [LEFT, RIGHT])
    names, structure = found.model.assembly.names, Structure(found.model.model)
    without = []
    for hold in work.holds:
        number = found.step_of[names.index(hold.name)]
        placed = found.steps[number].blocks
        held = placed[: placed.index(names.index(hold.name)) + 1]
        here = [i for i in range(len(names)) if found.before(number) >> i & 1] + [*held]
        stay = [names.index(one) for one in work.props_during(hold)]
        assert structure.stands(here, held=[*held, *stay]).stands
        without.append(structure.stands(here, held=held).stands)
    assert without == [True, False, False]
    numbers = work.to_dict()
    told = [one["props"] for one in numbers["holds"]]
    assert [tuple(one) for one in told] == [work.props_during(one) for one in work.holds]
    stand: set[str] = set()  # props are set up and taken away step by step
    for one, placed in zip(work.placements, numbers["placements"], strict=True):
        gone = work.props_removed(one)
        assert list(gone) == placed["props_removed"]
        stand = (stand | {*one.props}) - {*gone}
        if one.name == names[found.steps[one.step - 1].blocks[-1]]:
            assert stand == {*one.props}
    assert any(work.props_removed(one) for one in work.placements)


def test_work_lists_the_struts_of_propped_blocks_and_when_they_stand():
    found = plan(arch(0.2, 7), friction=0.7)
    made = scaffolding(found, "strut")
    work = handling(found, scaffolding=made).to_dict()
    struts, props = work["scaffold"], {one["block"]: one for one in work["props"]}
    assert len(struts) == len(made.items) > 0
    for one in struts:
        prop = props[one["block"]]
        assert one["kind"] == "strut"
        assert [one["first_step"], one["last_step"]] == [prop["first_step"], prop["last_step"]]
        assert one["length"] == pytest.approx(np.linalg.norm(np.subtract(one["head"], one["foot"])))


def test_json_and_csv_hold_what_was_found(tmp_path):
    work = handling(plan(tower(3)), [LEFT, Robot("strong", payload=5000.0)])
    work.save_json(tmp_path / "work.json")
    work.table().to_csv(tmp_path / "work.csv")
    data = json.loads((tmp_path / "work.json").read_text())
    assert data["format"] == "drystone-handling"
    assert [one["name"] for one in data["placements"]] == ["block-1", "block-2"]
    assert data["robots"][0]["payload"] is None
    assert np.array(data["placements"][0]["approach"]).shape[1:] == (4, 4)
    with (tmp_path / "work.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["robot"] for row in rows] == ["left", "strong"]
    assert float(rows[0]["mass [kg]"]) == pytest.approx(2400.0)
    assert (
        [int(row["step"]) for row in rows] == [one["step"] for one in data["placements"]] == [1, 2]
    )
    assert sorted(p.name for p in tmp_path.iterdir()) == ["work.csv", "work.json"]


def test_robots_in_the_rules_decide_what_can_be_placed():
    near = Rules(robots=[Robot("low", reach=1.6)])
    found = plan(tower(4), options=PlanOptions(rules=near))
    assert found.counts["impossible"] == 3  # the topmost is out of reach, and none can go before
    assert "out of reach" in found.impossible[3]
    weak = Rules(robots=[Robot("weak", payload=2000.0), Robot("weaker", payload=1500.0)])
    assert "carries 2000 kg" in plan(tower(2), options=PlanOptions(rules=weak)).impossible[1]
    able = Rules(robots=[Robot("arm", reach=5.0, payload=2500.0)])
    assert plan(tower(4), options=PlanOptions(rules=able)).counts["free"] == 3


def test_two_robots_that_take_turns_build_an_arch_without_centring():
    found = take_turns(arch(0.3, 7), friction=0.7)
    assert found.works
    assert [turn.robot for turn in found.turns] == ["left", "right"] * 3 + ["left"]
    assert found.largest > 0.0


def test_the_robot_bears_what_balances_the_blocks_before():
    # the first voussoir is held by itself: its robot carries its weight
    assembly = arch(0.3, 7)
    found = take_turns(assembly, friction=0.7)
    first = found.turns[0]
    assert first.force[2] == pytest.approx(assembly.blocks[first.block].mass * 9.81)
    weak = [Robot("a", payload=10.0), Robot("b", payload=10.0)]
    stopped = take_turns(assembly, robots=weak, friction=0.7)
    assert not stopped.works
    assert not stopped.turns[-1].carried
    # it does not lift the first block, so there is no hold
    assert np.isnan(stopped.table()["hold"]).all()
    assert (stopped.largest, stopped.numbers()["holds"]) == (0.0, [])


def test_a_robot_bears_no_more_than_weight_where_the_stage_stands_without_it() -> None:
    """The last voussoir rests on its springer: with its joint there left out it took 1748 N."""
    thin = arch(0.15, 11)
    found = take_turns(thin, robots=[Robot("a", payload=152.0), Robot("b", payload=152.0)],
                       friction=0.7)  # fmt: skip
    assert found.works
    hold = found.table()["hold"]
    weight = thin.mass[thin.free] * 9.81
    assert hold[-1] == pytest.approx(weight[-1])
    assert (hold >= weight * (1.0 - 1e-9)).all()  # it lifts its block, also where this needs less
    assert hold[9] == pytest.approx(1476.14, abs=0.1)


def test_without_enough_friction_turns_end_where_blocks_fall():
    found = take_turns(arch(0.3, 7), friction=0.1)
    assert not found.works
    assert found.complete.verdict is Verdict.UNSTABLE  # no other order does
    assert found.turns[-1].answer.falling
    assert len(found.layers().stages) == len(found.turns) < 7


def test_robots_and_orders_that_make_no_sense_are_refused():
    for bad in (
        {"name": ""},
        {"name": "a", "reach": 0.0},
        {"name": "a", "payload": -1.0},
        {"name": "a", "reach": "3 m"},
        {"name": "a", "base": "here"},
        {"name": "a", "base": (0.0, float("nan"), 0.0)},
    ):
        with pytest.raises(InputError):
            Robot(**bad)
    with pytest.raises(InputError, match="two robots have the same name"):
        handling(plan(tower(2)), [Robot("a"), Robot("a")])
    with pytest.raises(InputError, match="cannot take turns"):
        take_turns(tower(2), robots=[Robot("a")])
    with pytest.raises(InputError, match="does not name all free blocks"):
        take_turns(tower(3), order=["block-1"])


def test_a_robot_that_holds_leaves_what_only_it_reaches_without_one() -> None:
    found = shallow()
    near = [Robot("a", (-1.0, 1.0, 0.0), 1.8, 30.0), Robot("b", (1.0, 1.0, 0.0), 1.8, 30.0)]
    work = handling(found, near)
    assert work.title == "9 of 11 blocks placed by 2 robots"
    told = without_robot(found, near)
    assert told == [f"'{one.name}': 'a' could place it, and must hold another block" if k == 0 else
                    f"'{one.name}': 'b' could place it, and must hold another block"
                    for k, one in enumerate(p for p in work.placements if not p.robot)]  # fmt: skip
    assert set(told) <= set(work.notes)


def test_robots_of_one_step_are_chosen_together() -> None:
    """One reaches everything, the other only the first of two blocks, whoever's turn it is."""
    found = shallow()
    team = [Robot("everywhere"), Robot("left", (-1.0, 0.1, 0.0), 1.2)]
    assert without_robot(found, team) == without_robot(found, team[::-1])
    placed = [
        [one.robot for one in handling(found, some).placements] for some in (team, team[::-1])
    ]
    assert [sum(map(bool, one)) for one in placed] == [10, 10]


def test_a_plan_with_props_names_turns_without_and_what_is_proved() -> None:
    thin = arch(0.15, 11)
    found = plan(thin, friction=0.7)
    assert found.counts["propped"] == 3
    assert found.proved
    assert "need no prop: --turns" in found.message
    said = "".join(one.text for one in found.sentences())
    assert "no order has fewer blocks propped or held, of hands that let go after each step" in said
    assert "forces were not compared" in said
    columns = found.table().columns
    row = {name: i for i, name in enumerate(columns["block"])}
    props = [row[one["block"]] for one in found.numbers()["props"]]
    assert columns["prop_set"][props].tolist() == [3, 4, 5]
    assert columns["prop_goes"][props].tolist() == [4, 5, 8]
    assert columns["prop_goes"].tolist().count(None) == len(row) - 3
    gone = [
        [one.step for one in work.placements if name in work.props_removed(one)]
        for work in [handling(found)]
        for name in (one["block"] for one in found.numbers()["props"])
    ]
    assert gone == [[4], [5], [8]]
    weak = PlanOptions(rules=Rules(payload=60.0))
    assert "--turns" not in plan(thin, friction=0.7, options=weak).message
    alone = PlanOptions(rules=Rules(hands=1))
    assert "--turns" not in plan(thin, friction=0.7, options=alone).message


def test_turns_are_an_answer_with_a_page() -> None:
    robots = [Robot("a", (-2.0, 0.0, 0.0)), Robot("b", (2.0, 0.0, 0.0))]
    found = take_turns(arch(0.15, 11), robots=robots, friction=0.7)
    scene = found.layers()
    assert [len(scene.stages), scene.stages[-1].headline] == [12, found.title]
    assert found.table()["hold"].max() == found.largest == pytest.approx(1476.14, abs=0.1)
    (holds,) = (one for one in scene.stages[-1].layers if one.key == "help")
    np.testing.assert_allclose(np.linalg.norm(holds.vector, axis=1), found.table()["hold"])
    assert found.to_dict()["holds"][0]["force"][2] == pytest.approx(298.49, abs=0.01)
    weak = [Robot("a", payload=60.0), Robot("b", payload=60.0)]
    failed = take_turns(arch(0.15, 11), robots=weak, friction=0.7)
    told = "'a' would hold 'voussoir-06' with 774 N, and its payload is 589 N"
    assert failed.sentences()[-1].text == told
    assert failed.layers().stages[-1].role is Role.BAD
    stopped = take_turns(arch(0.15, 11), friction=0.7, time_limit_s=0.0)
    assert len(stopped.turns) == 1
    assert stopped.news is Role.UNSURE


def test_a_turn_whose_robot_cannot_place_its_block_is_told_and_drawn_so() -> None:
    """The other robot reaches it, and holds the block before; the picture has it as missing."""
    team = [Robot("a", (-1.2, -0.5, 0.0), 1.6, 120.0), Robot("b", (1.2, -0.5, 0.0), 1.6, 120.0)]
    found = take_turns(arch(0.15, 11), robots=team, friction=0.7)
    told = "'voussoir-01' is 0.639 m too far for 'b', whose turn it is;"
    assert told in found.sentences()[-1].text
    placed, last = found.layers().stages
    block = found.turns[-1].block
    layers = {layer.key: layer for layer in last.layers}
    assert last.state.tolist() == placed.state.tolist()
    assert last.state[block] == State.ABSENT
    assert layers["arms"].label == "'a' holds voussoir-00"
    assert layers["left-out"].label == "cannot be placed"
    weak = [Robot("a", (-2.0, 0.0, 0.0), payload=20.0), Robot("b", (2.0, 0.0, 0.0))]
    found = take_turns(arch(0.15, 11), robots=weak, friction=0.7)
    assert "'a', whose turn it is, carries 20 kg" in found.sentences()[-1].text
    (last,) = found.layers().stages
    layers = {layer.key for layer in last.layers}
    assert "left-out" in layers
    assert not {"arms", "help"} & layers
