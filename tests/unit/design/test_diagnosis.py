"""Why structures fall: regions, first motions, and what is missing, against closed forms."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Assembly, InputError, LoadCase, Model, Verdict, check
from drystone.answer.drawing import load_layers
from drystone.checks import check_forces
from drystone.cli import main
from drystone.design import (
    DesignMargin,
    Diagnosis,
    DiagnosisOptions,
    JointMotion,
    diagnose,
    thicken_blocks,
)
from drystone.design.props import find_props, with_props
from drystone.design.regions import regions_of, with_wrenches
from drystone.joint_capacity import JointCapacity
from drystone.models import arch, barrel_vault, box, h_model, prism, shelf, tower, wedge

G = 9.81


def slope(angle: float, friction: float = 0.6, size: float = 1.0) -> Model:
    """A flat block on a fixed ramp that rises along x."""
    rise = np.tan(np.deg2rad(angle))
    x = np.array([0.0, 4.0, 4.0])
    z = np.array([0.0, 0.0, 4.0 * rise])
    ramp = prism(size * np.column_stack([x, z]), (0.0, size), "ramp")
    along = np.array([1.0, rise]) / np.hypot(1.0, rise)
    up = np.array([-along[1], along[0]])
    corner = np.array([1.0, rise])
    section = [corner, corner + along, corner + along + 0.2 * up, corner + 0.2 * up]
    block = prism(size * np.array(section), (0.0, size), "block")
    return Model.of(Assembly((ramp, block), np.array([True, False])), friction=friction)


def only(found: Diagnosis) -> drystone.design.Region:
    (region,) = found.regions
    return region


def test_a_block_that_a_torque_turns_is_not_said_to_slide() -> None:
    model = Model.of(tower(2), friction=0.5)
    weight = -float(model.load.wrench[1, 2])
    wrench = np.array(model.load.wrench)
    wrench[1, 5] = 0.5 * weight * np.sqrt(0.5) * 1.02  # the corners carry all, and a little more
    found = diagnose(model.with_load(LoadCase(wrench)))
    region, (stage,) = only(found), found.layers().stages
    assert "missing" not in {one.key for one in stage.layers}  # no arrow of 0 N
    turns = "block 'block-1' turns about the normal of its joint with 'block-0'"
    assert region.sentence.startswith(turns)
    assert re.search(r"a moment of \d+ N m is missing", region.sentence)
    wrench[1, :1] = weight  # the centre of the turn is outside then
    assert "slides along" in only(diagnose(model.with_load(LoadCase(wrench)))).sentence


@pytest.mark.parametrize("size", [1.0, 0.01])
def test_a_block_on_a_steep_ramp_slides_down_and_needs_the_tangent_of_its_angle(
    size: float,
) -> None:
    model = slope(40.0, 0.6, size)
    region = only(diagnose(model))
    (joint,) = region.joints
    assert joint.motion is JointMotion.SLIDES
    assert joint.spent
    assert not joint.idle
    angle = np.deg2rad(40.0)
    np.testing.assert_allclose(joint.direction, [-np.cos(angle), 0.0, -np.sin(angle)], atol=1e-6)
    assert region.needs.friction == pytest.approx(np.tan(angle), rel=0.011)
    assert region.needs.friction >= np.tan(angle)
    weight = model.assembly.mass[1] * G
    missing = weight * (np.sin(angle) - 0.6 * np.cos(angle))
    assert np.linalg.norm(region.needs.force) == pytest.approx(missing, rel=1e-4)
    assert "slides down along 'ramp'" in region.sentence
    assert "friction of 0.84 there" in region.sentence
    short = diagnose(model, options=DiagnosisOptions(kinds=())).reasons[0]
    for told in (short, region.sentence):  # what is missing, and a support: both up the ramp
        assert "N (40 degrees above level towards +x) at " in told


def test_a_block_that_slides_on_level_ground_is_not_said_to_slide_up() -> None:
    """The proof lifts it by the angle of friction, 39 degrees; its joint is level."""
    ground, slab = (
        box((3.0, 1.0, 1.0), name="ground"),
        box((1.0, 1.0, 0.2), (0.5, 0.0, 1.0), "slab"),
    )
    pushed = Assembly([ground, slab]).with_fixed(["ground"])
    region = only(diagnose(pushed, friction=0.8, load=LoadCase.seismic(pushed, 0.9, 0.0)))
    assert region.sentence.startswith("block 'slab' slides along 'ground'")
    np.testing.assert_allclose(region.joints[0].direction, [1.0, 0.0, 0.0], atol=1e-6)


def test_a_friction_that_was_told_is_not_told_again() -> None:
    first, second = diagnose(slope(40.0)).reasons
    assert "friction of 0.84 there" in first
    assert second == "the same friction in all joints would hold the whole model"


def test_a_block_that_lies_too_far_out_hinges_about_the_edge_that_it_turns_over() -> None:
    base = box((1.0, 1.0, 1.0), name="base")
    out = box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    found = diagnose(Assembly((base, out), np.array([True, False])), friction=0.6)
    (joint,) = only(found).joints
    assert joint.motion is JointMotion.HINGES
    assert joint.edge is not None
    assert joint.edge is not None
    edge = float(base.bounds[1, 0])
    np.testing.assert_allclose(joint.edge[:, [0, 2]], [[edge, base.bounds[1, 2]]] * 2, atol=1e-6)
    needs = only(found).needs
    assert needs.friction is None
    (prop,) = needs.props.props
    reach = float(out.bounds[1, 0]) - edge
    arm = float(prop.point[0]) - edge
    assert 0.0 < arm <= reach
    balance = (float(out.centroid[0]) - edge) * out.mass * G
    assert prop.force[2] * arm == pytest.approx(balance, rel=1e-3)


def test_a_block_between_walls_needs_its_whole_weight_and_no_friction_holds_it() -> None:
    found = diagnose(h_model(), friction=0.9)
    region = only(found)
    assert region.verdict is Verdict.UNSTABLE
    assert {joint.motion for joint in region.joints} == {JointMotion.SLIDES}
    assert all(joint.idle for joint in region.joints)
    needs = region.needs
    weight = found.model.assembly.mass[region.blocks[0]] * G
    np.testing.assert_allclose(needs.force, [0.0, 0.0, weight], rtol=1e-6, atol=1e-6 * weight)
    (prop,) = needs.props.props
    assert prop.force[2] == pytest.approx(weight, rel=1e-6)
    assert needs.friction is None
    assert needs.ballast is None
    assert found.friction is None


@pytest.fixture(scope="module")
def fallen() -> Diagnosis:
    """The shelf of the source, in which two pieces fall."""
    return diagnose(shelf(), friction=0.9)


def test_both_pieces_of_the_shelf_that_fall_are_named_with_their_cause(fallen: Diagnosis) -> None:
    found = fallen
    assert [region.blocks for region in found.regions] == [(9,), (10,)]
    for region, lower in zip(found.regions, (5, 8), strict=True):
        assert set(region.neighbours) == {0, lower}
        states = {joint.neighbour: joint for joint in region.joints}
        assert states[lower].motion is JointMotion.SLIDES
        assert states[lower].spent
        assert states[0].motion is JointMotion.DROPS
        assert states[0].idle
        assert len(region.needs.props.props) == 1
    needs = found.regions[1].needs
    assert needs.friction == pytest.approx(np.tan(np.deg2rad(50.08)), rel=0.012)
    assert needs.turn is not None
    assert needs.turn.value == pytest.approx(50.08 - np.rad2deg(np.arctan(0.9)), abs=0.1)
    assert found.model.contacts[needs.turn.at[0]].blocks == (8, 10)
    assert "the lower joint, with 'block-8', turned by 8.1 degrees" in found.reasons[1]


def test_the_props_that_are_named_hold_the_whole_shelf(fallen: Diagnosis) -> None:
    model = fallen.model
    for region in fallen.regions:
        alone = model.with_supports(sorted(set(range(len(model))) - set(region.blocks)))
        (held,) = find_props(alone, region.blocks, fallen.motion).props
        (told,) = region.needs.props.props
        assert held.size == pytest.approx(told.size, rel=1e-6)
        model = with_props(model, [held.seat])
    assert drystone.check(model).stable


def test_a_prop_stands_where_the_least_force_holds_level_or_upright_and_in_the_middle() -> None:
    """A portal that a push tips is held at its lintel, a thin arch at its crown."""
    portal = (
        box((3.0, 0.5, 0.1), (-0.5, 0.0, -0.1), "ground"), box((0.3, 0.5, 2.0), name="left"),
        box((0.3, 0.5, 2.0), (1.7, 0.0, 0.0), "right"),
        box((2.4, 0.5, 0.3), (-0.2, 0.0, 2.0), "top"),
    )  # fmt: skip
    model = Model.of(Assembly(portal).with_fixed([0]), friction=0.6)
    push = LoadCase.point_load(model.assembly, 3, (2500.0, 0.0, 0.0))
    pushed = model.with_load(model.load + push)
    thin = Model.of(arch(0.08, voussoirs=5), friction=0.7)
    for one, name, way in ((pushed, "top", (-1, 0, 0)), (thin, "voussoir-02", (0, 0, 1))):
        fallen = drystone.diagnose(one, options=DiagnosisOptions.brief())
        blocks = fallen.regions[0].blocks
        (held,) = find_props(one, blocks, fallen.motion, shares=(0.0,)).props
        assert one.assembly.names[held.block] == name
        assert held.force / held.size == pytest.approx(np.array(way), abs=1e-9)


def test_no_prop_stands_where_earth_or_fill_lies_on_a_face() -> None:
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    assembly = Assembly((base, out)).with_fixed([0])
    plain = Model.of(assembly, friction=0.6)
    below = LoadCase.surface_load(assembly, 1, (0.0, 0.0, 1.0), facing=(0.0, 0.0, -1.0))
    for model, upright in ((plain, True), (plain.with_load(plain.load + below), False)):
        fallen = drystone.diagnose(model, options=DiagnosisOptions.brief())
        found = find_props(model, [1], fallen.motion, shares=(0.0, 0.4)).props
        assert any(one.seat.normal[2] > 0.9 for one in found) == upright


def test_blocks_that_fall_together_are_one_region_and_others_are_another() -> None:
    assert regions_of(Model.of(tower(6)), [1, 2, 4, 5]) == [(1, 2), (4, 5)]


def test_an_arch_that_is_too_thin_turns_about_hinges_and_ballast_or_glue_is_named() -> None:
    model = Model.of(arch(0.05, voussoirs=11), friction=0.7)
    region = only(diagnose(model))
    hinges = [joint for joint in region.joints if joint.motion is JointMotion.HINGES]
    assert len(hinges) >= 4
    assert region.needs.friction is None
    assert region.needs.pulls
    assert region.needs.pulls[0].force > 0.0


def test_a_model_that_stands_is_said_to_stand() -> None:
    found = diagnose(tower(3), friction=0.6)
    assert found.regions == ()
    assert found.reasons == ("it stands: nothing is missing",)


def test_regions_beyond_the_number_asked_for_are_named_only() -> None:
    found = diagnose(shelf(), friction=0.9, options=DiagnosisOptions(kinds=(), regions=1))
    assert [region.blocks for region in found.regions] == [(9,)]
    assert found.others == (10,)
    assert "1 more block falls: 'block-10'" in found.reasons
    assert found.regions[0].needs.friction is None


def test_the_least_wrench_with_cohesion_is_the_distance_from_the_cone_of_friction() -> None:
    model = slope(40.0, 0.3)
    weight, angle, friction = model.assembly.mass[1] * G, np.deg2rad(40.0), np.arctan(0.3)
    cohesion = 0.1 * weight
    model = model.with_capacity(JointCapacity(np.zeros(1), np.array([cohesion])))
    fallen = replace(check(model), prop=None, falling=())  # a check may end with a mechanism alone
    found = with_wrenches(fallen, lambda: False)
    assert found.falling == (1,)
    assert found.prop is not None
    assert found.force_with_props is not None
    missing = weight * np.sin(angle - friction) - cohesion * np.cos(friction)
    assert np.linalg.norm(found.prop[1, :3]) == pytest.approx(missing, rel=1e-4)
    left = check_forces(model, found.force_with_props, prop=found.prop)
    assert max(left.equilibrium, left.tension, left.cone) < 1e-6


def test_a_structure_that_falls_although_it_is_glued_is_diagnosed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = box((1.0, 1.0, 1.0), name="base")
    out = box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    model = Model.of(Assembly((base, out), np.array([True, False])), friction=0.6)
    model = model.with_capacity(JointCapacity(np.ones(1), np.ones(1)))
    region = only(diagnose(model))
    assert region.verdict is Verdict.UNSTABLE
    assert region.needs.props.props
    assert region.needs.pulls[0].force > 0.0
    path = tmp_path / "glued.json"
    drystone.write(model, path)
    assert main(["check", str(path)]) == 1
    assert "'out' hinges about an edge of 'base'" in capsys.readouterr().out.replace("\n", " ")


def test_without_time_it_tells_what_falls_and_why_it_ended() -> None:
    found = diagnose(h_model(), friction=0.9, time_limit_s=0.0)
    assert found.stopped == "the time was up"
    with pytest.raises(InputError, match="the time limit is -1"):
        diagnose(h_model(), time_limit_s=-1.0)


def test_a_result_of_another_model_is_refused() -> None:
    result = drystone.check(tower(2))
    with pytest.raises(InputError, match="another model"):
        diagnose(tower(2), result=result)
    with pytest.raises(InputError, match="regions is 0"):
        DiagnosisOptions(regions=0)
    with pytest.raises(InputError, match="no kind of need 'proop'; choose from prop, friction"):
        DiagnosisOptions(kinds=("proop",))


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "ramp.json"
    drystone.write(slope(40.0), path)
    return str(path)


def test_check_tells_the_cause_and_mend_what_would_hold_it(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", file]) == 1
    said = capsys.readouterr().out
    assert "'block' slides down along 'ramp'" in said.replace("\n", " ")
    assert said.endswith(f"next: drystone mend {file}\n")
    main(["check", file, "--friction", "35deg", "--only", "block,ramp"])
    then = f"next: drystone mend {file} --friction 0.700208 --only block,ramp\n"
    assert capsys.readouterr().out.endswith(then)
    assert main(["check", file, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["diagnosis"]["regions"][0]["blocks"] == ["block"]
    page = Path(file).with_suffix(".html")
    assert main(["mend", file, "--json", "--html", str(page)]) == 1
    (region,) = json.loads(capsys.readouterr().out)["regions"]
    assert region["neighbours"] == ["ramp"]
    assert [joint["motion"] for joint in region["joints"]] == ["slides"]
    assert region["needs"]["supports"][0]["block"] == "block"
    assert "1 prop that would hold it" in page.read_text(encoding="utf-8")


def test_forces_on_several_blocks_that_balance_each_other_are_not_added_up() -> None:
    thin = Model.of(arch(voussoirs=11, thickness_ratio=0.1), friction=0.7)
    (told,) = diagnose(thin, options=DiagnosisOptions(kinds=())).reasons
    assert "missing" not in told


def test_mend_says_that_a_model_stands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "tower.json"
    drystone.write(Model.of(tower(2), friction=0.6), path)
    assert main(["mend", str(path), "--apply", "1", "--out", str(tmp_path / "out.json")]) == 0
    told = capsys.readouterr().out
    assert "out.json is not written: no mend is needed" in told
    assert "it stands already: ask for a margin" in told
    assert "it stands: " not in told  # which says no more
    assert main(["mend", str(path), "--apply", "1", "--time-limit", "1e-9"]) == 1
    assert "no mend is made: no mend is known" in capsys.readouterr().out


def test_a_diagnosis_has_the_verdict_of_the_check() -> None:
    """The penalty form, which says where help is needed, says that this wedge falls."""
    shape = wedge("c")
    tilted = LoadCase.tilt(shape, (1.0, 0.0, 0.0), 41.0)
    model = Model.of(shape, friction=0.84, load=tilted)
    found = diagnose(model, options=DiagnosisOptions(kinds=()))
    assert found.result.verdict is check(model).verdict is Verdict.UNDECIDED
    assert found.regions


@pytest.mark.parametrize("load", [None, (3.0, 0.0, -9.81)])
def test_a_block_whose_centre_is_beyond_its_support_is_told_how_far(load: object) -> None:
    """The force that is missing is told at the block, where its line passes beside the block."""
    base = box((1.0, 1.0, 0.2), name="base")
    out = box((1.0, 1.0, 0.2), (0.65, 0.0, 0.2), "out")
    model = Model.of(Assembly((base, out), (True, False)), friction=0.9, load=load)
    told = only(diagnose(model, options=DiagnosisOptions(kinds=()))).sentence
    where = "its centre is 150 mm beyond the edge of its joint with 'base'"
    assert (where in told) == (load is None)
    assert re.search(r" at its centre and a moment of [\d.]+ k?N m are missing", told)


def test_what_crushes_is_said_to_crush_its_loads_are_drawn_and_thicker_it_stands() -> None:
    ring = arch(0.25, 6)
    load = LoadCase.gravity(ring) + LoadCase.point_load(ring, 3, (0.0, 0.0, -2e3))
    load += LoadCase.surface_load(ring, 4, (0.0, 0.0, -1e2), facing=(0.0, 0.0, 1.0))
    fallen = check(Model.of(ring, friction=0.7, load=load), strength=1e5)
    found = diagnose(fallen.model, result=fallen, options=DiagnosisOptions.brief())
    assert "move by crushing on" in found.reasons[0]
    assert "loads" in {layer.key for layer in found.layers().stages[0].layers}
    thick = thicken_blocks(fallen.model, ring.free.tolist(), 0.3)
    assert DesignMargin().stands(thick, quick=True)
    assert "moments" not in {one.key for one in load_layers(thick.assembly, thick.load)}


def test_the_words_tell_the_motion_that_the_picture_shows() -> None:
    """With what is around it held still, the block would hinge."""
    found = diagnose(shelf(), friction=0.6, options=DiagnosisOptions.brief())
    (stage,) = found.layers().stages
    drawn = {layer.key for layer in stage.layers}
    assert ("sliding" in drawn, "hinges" in drawn) == (True, False)
    assert "slides" in only(found).sentence
    assert "hinges" not in only(found).sentence


def test_a_large_region_of_a_known_mechanism_is_not_checked_alone() -> None:
    """A vault of 46 blocks that falls beside a block that stands."""
    vault = barrel_vault(courses=15, blocks=3, length=2.0)
    beside = (
        box((0.5, 0.5, 0.2), (9.0, 0.0, 0.0), "base"),
        box((0.5, 0.5, 0.2), (9.0, 0.0, 0.2)),
    )
    whole = Assembly((*vault.blocks, *beside))
    whole = whole.with_fixed([*np.flatnonzero(vault.fixed).tolist(), "base"])
    falls = Model.of(whole, friction=0.6, load=LoadCase.tilt(whole, (0.0, 1.0, 0.0), 21.0))
    steps: list[None] = []

    def stop() -> bool:
        """Asked in each step of a check."""
        steps.append(None)
        return False

    options = DiagnosisOptions(kinds=())
    found = diagnose(falls, options=options, result=check(falls), stop=stop)
    (region,) = found.regions
    assert (region.verdict, len(steps)) == (Verdict.UNSTABLE, 0)
    assert len(region.blocks) > 40
