"""Forces by a form of the source, from Python and from the command line."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Assembly, InputError, LoadCase, Model, Verdict
from drystone.cli import main
from drystone.models import (
    arch,
    box,
    buttressed_arch,
    h_model,
    overhang,
    shelf,
    tower,
    two_blocks_on_incline,
    wedge,
)
from drystone.programs import (
    FrictionCone,
    FrictionRule,
    Objective,
    RBEOptions,
    find_forces,
    solve_cra,
)

LEVEL = Model.of(two_blocks_on_incline(0.0), friction=0.8)
INCLINED = Model.of(two_blocks_on_incline(23.6), friction=0.8)


def pressing(found: drystone.programs.Forces) -> int:
    force = found.result.force
    assert force is not None
    return int((force[:, 0] > 1e-6 * force.max()).sum())


def test_squares_press_on_all_corners_and_a_vertex_on_two() -> None:
    assert pressing(find_forces(LEVEL)) == 4
    most = find_forces(LEVEL).tables()[0]
    assert most.title == "most loaded"
    weight = 9.81 * LEVEL.assembly.mass[~LEVEL.assembly.fixed].sum()
    assert most["normal"][0] == pytest.approx(weight, rel=1e-6)
    assert pressing(find_forces(LEVEL, objective=Objective.LINEAR)) == 4
    vertex = find_forces(LEVEL, objective=Objective.VERTEX)
    assert pressing(vertex) == 2
    weight = -LEVEL.load.wrench[1, 2]
    assert vertex.result.resultants.normal == pytest.approx([weight])
    assert vertex.result.solver == "HiGHS dual simplex"


def test_a_vertex_costs_as_little_as_the_middle_of_the_solutions() -> None:
    model = Model.of(arch(0.2, 10), friction=0.7)
    cone = FrictionCone.octagon()
    middle, vertex = (
        find_forces(model, objective=one, cone=cone).result.force[:, 0].sum()
        for one in (Objective.LINEAR, Objective.VERTEX)
    )
    assert vertex == pytest.approx(middle, rel=1e-5)


def test_a_vertex_of_the_penalised_form_has_the_least_tension_too() -> None:
    found = find_forces(overhang([0.6]), friction=0.8, objective=Objective.VERTEX)
    assert found.pull == pytest.approx(find_forces(overhang([0.6]), friction=0.8).pull, rel=1e-3)


def test_a_round_cone_has_no_vertex() -> None:
    with pytest.raises(InputError, match="the cone octagon"):
        RBEOptions(objective=Objective.VERTEX)


@pytest.mark.parametrize(("share", "pulls"), [(0.25, False), (0.49, False), (0.51, True)])
def test_a_block_pulls_when_its_centre_is_beyond_the_edge(share: float, pulls: bool) -> None:
    found = find_forces(overhang([share]), friction=0.8)
    assert bool(found.pull.any()) is pulls
    assert found.code == int(pulls)
    lever = share - 0.5  # tension at the far edge, by the length of the joint 1 - share
    weight = -found.model.load.wrench[1, 2]
    assert found.pull[0] == pytest.approx(max(0.0, weight * lever / (1.0 - share)), rel=1e-3)


def test_the_threshold_is_held_against_the_resultant_and_not_the_corners() -> None:
    tangent = float(np.tan(np.radians(23.6)))
    for threshold, code in ((0.6, 0), (0.44, 0), (0.43, 1), (0.2, 1)):
        found = find_forces(INCLINED, rule=FrictionRule.NET, threshold=threshold)
        assert found.friction[0] == pytest.approx(tangent, rel=1e-5)
        assert found.code == code
        keys = {layer.key for layer in found.layers().stages[0].layers}
        assert ("within" in keys, "beyond" in keys) == (code == 0, code == 1)
        assert "joint-force" not in keys


def test_joints_at_supports_are_reduced_towards_their_middle_and_away_from_it() -> None:
    model = Model.of(arch(0.4, 10), friction=0.8)
    reach = {}
    for side in ("in", "out"):
        made = find_forces(model, virtual=[f"{side}=0.1@supports"]).contacts
        foot = np.isclose(made.area, 0.1 * model.contacts.area)
        assert foot.sum() == 2  # the other joints stay as they are
        assert made.area[~foot] == pytest.approx(model.contacts.area[~foot])
        reach[side] = np.abs(made.centroid[foot, 0])
    assert reach["out"] - reach["in"] == pytest.approx(0.9 * 0.4)


@pytest.mark.parametrize(
    ("model", "name"),
    [
        (Model.of(two_blocks_on_incline(40.0), friction=0.3), "upper"),
        (Model.of(h_model(), friction=0.84), "block"),
    ],
)
def test_tension_holds_no_block_that_slides_along_its_joints(model: Model, name: str) -> None:
    found = find_forces(model, form="penalty")
    assert found.unheld == (name,)
    assert found.title == f"Tension in the joints does not hold {name}"
    assert found.code == 1
    assert not found.pull.any()


def test_friction_net_has_no_forces_where_friction_plus_pulls() -> None:
    slippery = INCLINED.with_friction(0.2)
    net = find_forces(slippery, rule=FrictionRule.NET)
    assert net.title == "No forces balance the loads"
    assert find_forces(slippery).pull[0] > 0.0


def test_joints_shrunk_to_their_kerns_pull_at_mid_span() -> None:
    model = Model.of(buttressed_arch(), friction=0.8)
    assert find_forces(model).code == 0
    found = find_forces(model, virtual=["kern"])
    told = [one.text for one in found.sentences()]
    assert "no contact forces can balance the loads within the reduced joints" in told
    names, joints = found.assembly.names, found.contacts.joints
    worst = int(np.argmax(found.pull))
    pair = names[joints.block_a[worst]], names[joints.block_b[worst]]
    assert pair in (("voussoir-06", "voussoir-07"), ("voussoir-07", "voussoir-08"))
    keys = [layer.key for layer in found.layers().stages[0].layers]
    assert {"interfaces", "virtual", "tension"} <= set(keys)
    assert len(set(keys)) == len(keys)


def test_a_joint_compressed_to_its_edge_moves_the_thrust_there() -> None:
    model = Model.of(tower(2), friction=0.6)
    found = find_forces(model, virtual=["x=0.2@block-0,block-1"])
    assert sorted(found.contacts.point[:, 0]) == pytest.approx([0.8, 0.8, 1.0, 1.0])
    weight = -model.load.wrench[1, 2]  # at 0.5, beyond the edge at 0.8
    assert found.pull == pytest.approx([1.5 * weight], rel=1e-3)
    same = find_forces(model, virtual=["1,0,0=0.2"])
    assert same.contacts.point == pytest.approx(found.contacts.point)
    assert find_forces(model, virtual=["-y"]).title == "No forces balance the loads"


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("kenr", "no virtual interface"),
        ("x=much", "no virtual interface"),
        ("2", "give 0 or more, up to 1"),
        ("z", "normal to the interface"),
        ("kern@block-0,block-2", "no joint of"),
        ("kern@blok", "no block"),
    ],
)
def test_words_that_mean_no_virtual_interface_are_refused(word: str, told: str) -> None:
    with pytest.raises(InputError, match=told) as caught:
        find_forces(tower(3), virtual=[word])
    assert caught.value.where == "virtual"


def test_options_of_another_form_are_refused() -> None:
    with pytest.raises(InputError, match="is for form rbe"):
        find_forces(tower(2), form="cra", objective=Objective.LINEAR)
    with pytest.raises(InputError, match="has no cost"):
        find_forces(tower(2), form="cra", gamma=2.0)
    with pytest.raises(InputError, match="1 or more"):
        find_forces(tower(2), form="penalty", gamma=0.5)


def test_the_penalty_form_pulls_less_the_more_tension_costs() -> None:
    model = Model.of(shelf(), friction=0.9)
    cheap, usual, steep = (
        find_forces(model, form="penalty", gamma=gamma) for gamma in (10.0, 1e3, 1e6)
    )
    assert cheap.pull.sum() > usual.pull.sum() > steep.pull.sum() > 100.0
    assert find_forces(model, form="penalty").pull.sum() == pytest.approx(usual.pull.sum())
    for found in (cheap, usual, steep):
        assert found.result.falling_names == ("block-9", "block-10")
        assert found.result.residuals is not None
        assert found.result.residuals.equilibrium < 1e-6
        keys = [layer.key for layer in found.layers().stages[0].layers]
        assert {"tension", "help", "network"} <= set(keys)
        assert len(set(keys)) == len(keys)


def test_a_resultant_far_from_its_joint_is_not_drawn() -> None:
    """Tilted almost flat, the joints pull and press, and their resultants are 100 m away."""
    bricks = overhang([0.0, 0.0])
    model = Model.of(bricks).with_load(LoadCase.tilt(bricks, (0.0, 1.0, 0.0), 89.9))
    found = find_forces(model)
    assert np.abs(found.result.resultants.position).max() > 100.0
    lines = next(one for one in found.layers().stages[0].layers if one.key == "network")
    assert np.abs(lines.position).max(initial=0.0) < 2.0


def test_coupled_analysis_has_forces_where_a_motion_fits_them() -> None:
    assert find_forces(tower(2), form="cra").code == 0
    for falls, friction in ((shelf(), 0.9), (h_model(), 1.0)):
        none = find_forces(falls, form="cra", friction=friction)
        assert none.title.startswith("No forces that fit a motion were found; states that jam")


def test_eta_is_the_length_of_the_largest_displacement_and_eps_the_size_of_free_blocks() -> None:
    """A wedge that sinks by s in a groove of 30 degrees overlaps by s cos 30 degrees."""
    model = Model.of(wedge("d"), friction=0.4)
    found = solve_cra(model)
    assert found.method == "cra"
    assert found.eta == pytest.approx(1.0 / math.cos(math.radians(30.0)), rel=1e-6)
    assert found.displacement is not None
    free = ~model.assembly.fixed
    sunk = model.assembly.size[free].mean() / math.cos(math.radians(30.0))
    assert found.displacement[free] == pytest.approx(np.array([[0, 0, -sunk, 0, 0, 0]]), abs=1e-5)


def test_the_command_prints_tension_and_writes_a_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "pushed.json"
    drystone.write(overhang([0.75]), file)
    table = tmp_path / "a.csv"
    asked = ["forces", str(file), "--friction", "0.8", "--joints", str(table)]
    assert main(asked) == 1
    assert "Tension is needed: 2.94 kN in 1 of 1 joint" in capsys.readouterr().out
    assert table.read_text("utf-8").count("\n") == 2
    assert main([*asked[:4], "--form", "penalty", "--gamma", "1e4", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["form"] == "penalty"
    assert told["tension_in_all"] == pytest.approx(2943.0, rel=1e-3)
    assert main([*asked[:4], "--objective", "vertex", "--cone", "exact"]) == 2
    assert "--objective" in capsys.readouterr().err


def test_forces_of_a_solved_compas_file_are_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "solved.json"
    drystone.write(drystone.check(tower(3)), file, format="compas-assembly")
    assert main(["forces", str(file), "--form", "file", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["title"] == "Compression alone balances the loads"
    assert "a gravity of 9.81 m/s2" in told["sentences"][1]
    content = file.read_text("utf-8").replace('"c_np":', '"c_np":1e6,"old":', 1)
    file.write_text(content, "utf-8")
    assert find_forces(file, form="file").title == "These forces do not balance the loads"
    drystone.write(tower(3), file, format="compas-assembly")
    assert main(["forces", str(file), "--form", "file"]) == 2
    assert "has no forces" in capsys.readouterr().err
    with pytest.raises(InputError, match="has no forces"):
        find_forces(tower(3), form="file")


@pytest.mark.parametrize(("virtual", "told"), [("out", "prop them"), ("kern", "glue would do")])
def test_the_penalty_form_praises_glue_only_where_its_forces_balance(
    virtual: str, told: str
) -> None:
    found = find_forces(arch(0.15, 7), friction=0.7, form="penalty", virtual=[virtual])
    fails = "Tension in the joints does not hold 7 blocks"
    assert found.title.startswith("Tension is needed" if virtual == "kern" else fails)
    assert found.result.message.endswith(told)


def test_rounding_is_no_force_and_no_place() -> None:
    """What an iteration leaves beside the weight is not drawn, and not told."""
    found = find_forces(h_model(), friction=0.0, form="penalty")
    assert found.unheld == ("block",)
    assert not found.result.force.any()
    assert not found.result.tension.any()
    arrows = [one for one in found.layers().stages[0].layers if one.vector is not None]
    assert max((one.largest for one in arrows if one.group == "forces"), default=0.0) == 0.0
    assert [one.key for one in arrows if one.group == "reactions"] == []
    assert "most loaded" not in [one.title for one in found.result.tables()]
    base = box((0.3, 0.7, 1.0), (-0.15, -0.35, -1.0), "base")
    top = box((0.3, 0.7, 1.0), (-0.15 + 1e-17, -0.35, 0.0), "top")
    stands = drystone.check(Assembly((base, top)).with_fixed([0]), friction=0.6)
    (place,) = stands.reactions()["point"]
    assert place.tolist() == [0.0, 0.0, 0.0]


def test_coupled_analysis_names_itself_only_where_it_found_a_state() -> None:
    falls = solve_cra(overhang([0.75]), friction=0.6)
    assert (falls.verdict, falls.method, falls.force) == (Verdict.UNSTABLE, "check", None)
    assert solve_cra(tower(3), friction=0.6).method == "cra"
