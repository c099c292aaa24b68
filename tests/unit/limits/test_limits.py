"""Public limits: what they take, refuse and tell; sweeps, thrust bounds, imperfections."""

import itertools
import json
import pickle
import re
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from drystone import (
    Assembly,
    InputError,
    JointCapacity,
    LoadCase,
    Result,
    Verdict,
    check,
    solve_rbe,
)
from drystone.answer import Role
from drystone.formulations.nearest_mechanism import NearestMechanism, nearest_mechanism
from drystone.limits import (
    Bracket,
    Evaluation,
    Imperfections,
    Limit,
    LimitOptions,
    LoadFactor,
    Quantity,
    Tilt,
    imperfect,
    imperfections,
    limit_friction,
    limit_load,
    limit_shrink,
    limit_strength,
    limit_thickness,
    limit_tilt,
    thrust_bounds,
    tilt_sweep,
)
from drystone.mechanics.statics import Statics
from drystone.model import Model
from drystone.models import (
    arch,
    box,
    concave,
    h_model,
    incline,
    segmental_bridge,
    tower,
    wall,
    wedge,
)
from drystone.programs import FrictionCone, RBEOptions
from drystone.report import assess
from drystone.virtual import joint_sections
from tests.oracle import touching_faces

FALLS = Verdict.UNSTABLE

TOWER = tower(2)
JOINTS = touching_faces(TOWER, 0.4)
QUICK = LimitOptions(scan=1, width=0.01)
LEANING = LoadCase.tilt(TOWER, (1.0, 0.0, 0.0), 10.0)
SLIDE = float(np.rad2deg(np.arctan(0.4)))


def test_a_limit_as_plain_values_can_be_written_as_json() -> None:
    told = json.loads(json.dumps(limit_tilt(Model(TOWER, JOINTS), "x", options=QUICK).to_dict()))
    assert told["unit"] == "deg"
    assert told["range"] == [0.0, 180.0]
    assert told["equilibrium"]["stands"] < SLIDE < told["equilibrium"]["falls"]
    assert told["rest"]["value"] == pytest.approx(SLIDE, abs=0.01)
    assert told["falling"] == ["block-1"]
    assert {one["verdict"] for one in told["evaluations"]} <= {"stable", "unstable", "undecided"}
    assert set(told["time_s"]) == {"equilibrium", "rest"}


def test_a_limit_of_tilt_says_that_other_loads_do_not_turn() -> None:
    only = LimitOptions(equilibrium_only=True)
    weight = LoadCase.gravity(TOWER)
    push = LoadCase.point_load(TOWER, "block-1", (0.0, 500.0, 0.0))
    for load, told in ((weight, False), (weight + LoadCase.seismic(TOWER, 0.1), False),
                       (weight + push, True)):  # fmt: skip
        found = limit_tilt(Model(TOWER, JOINTS, load), "x", options=only)
        said = " ".join(one.text for one in found.sentences())
        assert ("keep their direction" in said) == told
    swept = tilt_sweep(Model(TOWER, JOINTS, weight + push), directions=3, options=only)
    assert "keep their direction" in " ".join(one.text for one in swept.sentences())


def test_the_equilibrium_limit_alone_asks_no_verdict() -> None:
    def never(*arguments: object) -> None:
        raise AssertionError(arguments)

    limit = limit_tilt(
        Model(TOWER, JOINTS), check=never, options=LimitOptions(equilibrium_only=True, width=0.01)
    )  # type: ignore[arg-type]
    assert limit.rest is None
    assert limit.best is limit.equilibrium
    assert limit.to_dict()["rest"] is None


def test_a_tilt_axis_is_a_name_or_any_vector() -> None:
    values = [
        limit_tilt(
            Model(TOWER, JOINTS), axis, options=LimitOptions(equilibrium_only=True, width=0.01)
        ).equilibrium.value
        for axis in ("x", "-y", (2.0, 0.0, 0.0), (3.0, 1.0, 0.0))
    ]
    assert values == pytest.approx([SLIDE] * 4, abs=0.01)


def test_a_limit_of_equilibrium_alone_does_not_say_that_it_stands() -> None:
    """The block of the H falls at every friction, though forces could balance it."""
    least = limit_friction(h_model(), options=LimitOptions(equilibrium_only=True))
    assert least.title.startswith("Forces balance down to friction 0.0005")


def test_forces_of_the_rest_state_balance_the_loads_at_the_least_friction() -> None:
    limit = limit_friction(arch(), friction=0.9)
    state, rest = limit.equilibrium.standing, limit.uniform and limit.uniform.standing
    assert state is not None
    assert rest is not None
    np.testing.assert_array_equal(state.force, rest.force)
    assert state.verdict is Verdict.EQUILIBRIUM_EXISTS


def test_a_tilt_without_an_axis_is_the_least_of_four() -> None:
    """An arch swings along its span long before it overturns to a side."""
    model = Model.of(arch(thickness_ratio=0.15), friction=0.7)
    least = limit_tilt(model)
    each = {axis: limit_tilt(model, axis).best for axis in ("x", "-x", "y", "-y")}
    assert each["y"].stands == pytest.approx(min(one.stands for one in each.values()), abs=0.05)
    assert least.stands == pytest.approx(each["y"].stands, rel=1e-9)
    assert least.title.endswith("degrees about y")
    assert least.end == 180.0
    said = [one.text for one in least.sentences()]
    assert "the least of the tilts about x, -x, y and -y" in said
    calls: list[str] = []

    def progress(stage: str, done: int, total: int) -> None:
        del done, total
        calls.append(stage)

    late = limit_tilt(model, progress=progress, stop=lambda: calls.count("done") > 0)
    assert late.title.endswith("degrees about y")  # the first: forces balance the least about it
    said = [one.text for one in late.sentences()]
    assert "about other axes it may fall before: not all are searched" in said


def test_a_tilt_that_is_stopped_at_once_asks_for_no_forces(monkeypatch: pytest.MonkeyPatch) -> None:
    def asked(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("drystone.limits.limits.tilt_factor", asked)
    late = limit_tilt(Model(TOWER, JOINTS), stop=lambda: True)
    assert late.stopped == "it was interrupted"
    with pytest.raises(AssertionError):
        limit_tilt(Model(TOWER, JOINTS))


def test_loads_keep_their_direction_while_the_model_turns() -> None:
    load = LoadCase.gravity(TOWER) + LoadCase.moment(TOWER, 1, (1.0, 2.0, 3.0))
    turned = Tilt(Model(TOWER, JOINTS, load), np.array([0.0, 1.0, 0.0])).turned(90.0)
    np.testing.assert_allclose(turned.wrench[1, :3], [2400.0 * 9.81, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(turned.wrench[1, 3:], [-3.0, 2.0, 1.0], atol=1e-9)
    plain = Tilt(Model(TOWER, JOINTS, LoadCase.gravity(TOWER)), np.array([1.0, 2.0, 0.0]))
    np.testing.assert_allclose(
        plain.turned(20.0).wrench, LoadCase.tilt(TOWER, (1.0, 2.0, 0.0), 20.0).wrench, atol=1e-9
    )


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: limit_tilt(Model(TOWER, JOINTS), (0.0, 0.0, 0.0)), "axis is zero"),
        (lambda: limit_tilt(Model(TOWER, JOINTS), "w"), "no axis is called 'w'"),
        (lambda: limit_tilt(Model(TOWER, JOINTS), upper=0.0), "upper is 0; give"),
        (lambda: limit_friction(Model(TOWER, JOINTS), upper=-1.0), "upper is -1"),
        (lambda: limit_friction(Model(TOWER, JOINTS), upper=float("nan")), "is nan"),
        (
            lambda: limit_load(Model(TOWER, JOINTS), 0.0 * LoadCase.gravity(TOWER)),
            "live load is zero",
        ),
        (
            lambda: limit_load(Model(TOWER, JOINTS), LoadCase.gravity(TOWER), upper=-2.0),
            "upper is -2",
        ),
        (lambda: limit_tilt(Model(TOWER.with_fixed([0, 1]), JOINTS)), "every block is fixed"),
        (lambda: limit_tilt(Model(TOWER, JOINTS, 0.0 * LoadCase.gravity(TOWER))), "nothing loads"),
        (lambda: limit_thickness(lambda t: TOWER, 1.0, 1.0), "no length"),
        (lambda: LimitOptions(width=0.0), "width is 0"),
        (lambda: LimitOptions(scan=0), "scan is 0"),
        (lambda: tilt_sweep(Model(TOWER, JOINTS), 0), "directions is 0"),
        (lambda: imperfections(Model(TOWER, JOINTS), Imperfections(), draws=0), "draws is 0"),
        (
            lambda: imperfections(Model(TOWER, JOINTS), Imperfections(), confidence=1.0),
            "confidence is 1",
        ),
        (lambda: Imperfections(friction_range=(0.5, 0.4)), "friction from 0.5 to 0.4"),
        (lambda: Imperfections(corner_loss=1.5), "corner_loss is 1.5"),
        (lambda: Imperfections(turn=-1.0), "turn is -1"),
        (
            lambda: thrust_bounds(Model(TOWER, JOINTS), "block-9", (1.0, 0.0, 0.0)),
            "no block is called",
        ),
        (lambda: thrust_bounds(Model(TOWER, JOINTS), 0, (0.0, 0.0, 0.0)), "direction is zero"),
    ],
)
def test_what_cannot_be_asked_is_refused(call, words) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=words):
        call()


def test_friction_can_be_searched_as_a_share_of_each_joint() -> None:
    slope = incline(20.0)
    joints = touching_faces(slope, 0.8)
    limit = limit_friction(Model(slope, joints), scaled=True, options=LimitOptions(scan=1))
    assert limit.quantity.name == "share of friction"
    assert limit.best.value == pytest.approx(np.tan(np.deg2rad(20.0)) / 0.8, abs=1e-3)


def test_a_structure_that_never_stood_has_no_limit() -> None:
    slope = incline(50.0)
    limit = limit_tilt(Model(slope, touching_faces(slope, 0.4)), "x", options=QUICK)
    assert limit.equilibrium.stands is None
    assert limit.best.value is None


def test_a_sweep_is_the_same_with_one_and_two_workers() -> None:
    alone = tilt_sweep(Model(TOWER, JOINTS), 3, options=QUICK)
    with ProcessPoolExecutor(2) as executor:
        together = tilt_sweep(Model(TOWER, JOINTS), 3, options=QUICK, executor=executor)
    np.testing.assert_array_equal(alone.rest, together.rest)
    np.testing.assert_array_equal(alone.equilibrium, together.equilibrium)
    assert alone.rest == pytest.approx([SLIDE] * 3, abs=0.01)
    assert json.loads(json.dumps(alone.to_dict()))["azimuth"] == [0.0, 120.0, 240.0]


def test_an_azimuth_is_the_direction_of_the_lean() -> None:
    # a plate that reaches beyond its foot towards +x falls first when it leans that way
    slope = incline(10.0)  # slides towards +x
    sweep = tilt_sweep(
        Model(slope, touching_faces(slope, 0.4)),
        4,
        options=LimitOptions(equilibrium_only=True, width=0.1),
    )
    assert sweep.azimuth[sweep.weakest] == 0.0
    assert sweep.equilibrium[0] == pytest.approx(SLIDE - 10.0, abs=0.1)
    assert sweep.equilibrium[2] == pytest.approx(SLIDE + 10.0, abs=0.1)


def test_progress_counts_to_its_end() -> None:
    told: list[tuple[str, int, int]] = []
    limit_tilt(Model(TOWER, JOINTS), options=QUICK, progress=lambda *step: told.append(step))
    tilt_sweep(
        Model(TOWER, JOINTS),
        2,
        options=LimitOptions(equilibrium_only=True, width=0.01),
        progress=lambda *step: told.append(step),
    )
    assert told[-1][1:] == (2, 2)
    assert all(0 <= done <= total for _, done, total in told)


def test_thrust_bounds_contain_every_equilibrium_and_are_met_by_their_states() -> None:
    assembly = arch(0.2, 10)
    joints = touching_faces(assembly, 0.8)
    bounds = thrust_bounds(Model(assembly, joints), "springer-right", (1.0, 0.0, 0.0))
    foot = joints.block_b == assembly.index("springer-right")
    result = solve_rbe(Model(assembly, joints))
    assert bounds.least_state is not None
    assert bounds.sentences()[1].text == "measured along (1, 0, 0); forces by equilibrium alone"
    left = thrust_bounds(Model(assembly, joints), "springer-left", "x")
    assert left.most == pytest.approx(-bounds.least, rel=1e-4)
    assert "(1, 0, 0), negative the other way (as at the far end" in left.sentences()[1].text
    assert not any("only support" in one.text for one in left.sentences())
    thrust = [float(each.resultants.force[foot][0, 0]) for each in (result, bounds.least_state)]
    assert bounds.least - 1e-3 <= thrust[0] <= bounds.most + 1e-3
    assert thrust[1] == pytest.approx(bounds.least, rel=1e-6)


def test_no_thrust_is_told_as_none_and_not_as_rounding() -> None:
    model = Model.of(tower(3), friction=0.6)
    for block in (0, 1):
        bounds = thrust_bounds(model, block, "x")
        assert (bounds.least, bounds.most) == (0.0, 0.0)
        assert "is free, or the only support" in bounds.sentences()[2].text


def test_prestress_has_no_largest_thrust_and_a_falling_block_no_thrust_at_all() -> None:
    wedged = h_model()
    bounds = thrust_bounds(Model(wedged, touching_faces(wedged, 0.6)), 0, (1.0, 0.0, 0.0))
    assert np.isinf([bounds.least, bounds.most]).any()
    slope = incline(45.0)
    none = thrust_bounds(Model(slope, touching_faces(slope, 0.2)), 0, (1.0, 0.0, 0.0))
    assert np.isnan([none.least, none.most]).all()


def test_the_size_of_joints_that_a_straight_tower_needs_is_nothing() -> None:
    limit = limit_shrink(Model(TOWER, JOINTS), options=QUICK)
    assert limit.equilibrium.stands == 0.0


def test_the_share_of_strength_is_that_of_a_stress_block_and_stands_in_the_assessment() -> None:
    """A pier whose joints carry twice its weight stands at half of that strength."""
    pier = Model.of(tower(2), friction=0.6)
    weight = float(pier.assembly.mass[1]) * 9.81
    strong = pier.with_capacity(JointCapacity.of(pier.contacts, compression=2.0 * weight))
    limit = limit_strength(strong)
    assert (limit.rest.stands, limit.rest.falls) == pytest.approx((0.5, 0.5), abs=1e-3)
    assert "factor on the strength: 2" in [one.text for one in limit.sentences()]
    assert "strength" in assess(strong)[-1].title
    weak = strong.with_capacity(JointCapacity.of(pier.contacts, compression=0.5 * weight))
    told = "Falls at 1 of the strength of the joints, where the search starts"
    assert limit_strength(weak).title.startswith(told)
    with pytest.raises(InputError, match="no joint has a strength"):
        limit_strength(pier)


def test_what_falls_at_its_own_friction_may_stand_with_more() -> None:
    """The slope of 35 degrees is 0.70."""
    found = limit_friction(incline(35.0), friction=0.4, options=LimitOptions(equilibrium_only=True))
    told = "Falls at friction 0.4, where the search starts: more was not tried: --friction, "
    assert found.title.startswith(told)
    again = limit_friction(incline(35.0), upper=1.0, options=LimitOptions(equilibrium_only=True))
    assert again.equilibrium.stands == pytest.approx(np.tan(np.deg2rad(35.0)), abs=2e-3)


def test_draws_depend_on_their_seed_only() -> None:
    kinds = Imperfections(friction_range=(0.3, 0.5))
    slope = incline(np.rad2deg(np.arctan(0.4)))
    joints = touching_faces(slope, 0.4)
    alone = imperfections(Model(slope, joints), kinds, draws=12, seed=3)
    with ProcessPoolExecutor(2) as executor:
        together = imperfections(Model(slope, joints), kinds, draws=12, seed=3, executor=executor)
    assert alone.verdicts == together.verdicts
    assert {Verdict.STABLE, Verdict.UNSTABLE} == set(alone.verdicts)
    low, high = alone.interval
    assert 0.0 <= low < alone.share < high <= 1.0
    assert alone.to_dict()["standing"] == round(12 * alone.share)


def test_perfect_joints_all_stand() -> None:
    answer = imperfections(Model(TOWER, JOINTS), Imperfections(), draws=3)
    assert answer.share == 1.0
    assert answer.interval[1] == 1.0


def test_a_lost_corner_leaves_two_and_a_smaller_joint_inside_the_old_one() -> None:
    chipped = imperfect(JOINTS, Imperfections(corner_loss=1.0, loss_reach=0.25), 0)
    assert chipped.corner_count == 2 * JOINTS.corner_count
    assert chipped.area[0] == pytest.approx(1.0 - 4.0 * 0.5 * 0.25**2)
    assert chipped.point.min() >= 0.0
    assert chipped.point.max() <= 1.0


def test_offset_and_tilt_keep_joints_plane_and_their_size() -> None:
    drawn = imperfect(JOINTS, Imperfections(offset=0.1, turn=3.0), 1)
    origin, _, made = joint_sections(drawn)
    assert made.area[0] == pytest.approx(1.0)
    away = (drawn.point - origin[drawn.interface]) @ drawn.frame[0, 0]
    np.testing.assert_allclose(away, 0.0, atol=1e-12)
    assert not np.allclose(drawn.frame, JOINTS.frame)


def test_blocks_travel_to_other_processes_as_they_are() -> None:
    copy: Assembly = pickle.loads(pickle.dumps(TOWER))
    assert copy.names == TOWER.names
    assert not copy.blocks[0].vertices.flags.writeable
    assert dict(copy.blocks[0].metadata) == dict(TOWER.blocks[0].metadata)
    np.testing.assert_array_equal(copy.mass, TOWER.mass)


def test_one_stiffness_and_some_stiffness_are_told_apart() -> None:
    # a wedge in a groove: where uniform stiffness falls, another share of the forces stands
    from drystone.models import wedge

    assembly = wedge("c", longer=0.2)
    joints = Model.of(assembly, friction=0.84).contacts
    limit = limit_tilt(Model(assembly, joints), "x", options=LimitOptions(scan=1, width=6.0))
    assert limit.uniform is not None
    assert limit.rest is not None
    assert limit.uniform.stands is not None
    assert limit.rest.stands is not None
    assert limit.uniform.stands < limit.rest.stands
    assert limit.is_sensitive
    assert limit.equilibrium.value == pytest.approx(47.0, abs=6.0)


def after(calls: int) -> Callable[[], bool]:
    """Says so once only: who hears it must remember."""
    left = iter([False] * calls + [True])
    return lambda: next(left, False)


@pytest.mark.parametrize(
    "find",
    [
        lambda stop: limit_tilt(Model(TOWER, JOINTS), "x", options=QUICK, stop=stop),
        lambda stop: limit_friction(Model(TOWER, JOINTS, LEANING), options=QUICK, stop=stop),
        lambda stop: limit_shrink(Model(TOWER, JOINTS, LEANING), options=QUICK, stop=stop),
        lambda stop: limit_load(
            Model(TOWER, JOINTS),
            LoadCase.point_load(TOWER, 1, (1e3, 0.0, 0.0)),
            options=QUICK,
            stop=stop,
        ),
    ],
)
def test_a_stopped_limit_is_a_wider_bracket_around_the_same(
    find: Callable[[Callable[[], bool] | None], Limit],
) -> None:
    whole = find(None).best
    assert whole.stands is not None
    assert whole.falls is not None
    low, high = sorted((whole.stands, whole.falls))
    calls, answers = 0, [find(after(0))]
    assert (answers[0].equilibrium.stands, answers[0].rest) == (None, None)
    while answers[-1].stopped:
        calls = max(calls + 1, int(1.4 * calls))
        answers.append(find(after(calls)))
    assert len(answers) > 8
    for found in answers[:-1]:
        assert found.stopped == "it was interrupted"
        for bracket in (found.equilibrium, found.best):
            one, two = bracket.stands, bracket.falls
            if one is not None and two is not None:
                assert min(one, two) <= low + 0.011
                assert max(one, two) >= high - 0.011
    assert (answers[-1].best.stands, answers[-1].best.falls) == (whole.stands, whole.falls)


@pytest.mark.parametrize(
    ("start", "end", "stands", "falls", "told"),
    [
        (0.0, 3.0, 1.44189, 1.44281, ("1.441", "1.443")),
        (1.0, 0.0, 0.36242, 0.36218, ("0.3625", "0.3621")),
    ],
)
def test_what_is_told_to_stand_stands_and_what_is_told_to_fall_falls(
    start: float, end: float, stands: float, falls: float, told: tuple[str, str]
) -> None:
    found = limit_friction(tower(2), options=LimitOptions(equilibrium_only=True))
    best = replace(found.equilibrium, stands=stands, falls=falls)
    near = replace(found, start=start, end=end, equilibrium=best)
    assert near.title.endswith(f"to friction {told[0]}")
    table = near.tables()[0]
    assert (table["stands_at"][0], table["gives_way_at"][0]) == told
    assert f"stands at {stands:g}, falls at {falls:g}" in repr(near)


def test_a_limit_says_why_values_between_its_sides_are_undecided() -> None:
    """A cube slides at 0.6 g, and a kerb 50 mm away, if it touches, holds it up to its edge."""
    cube, kerb = box((1.0, 1.0, 1.0), name="cube"), box((1.0, 1.0, 0.2), (1.05, 0.0, 0.0), "kerb")
    ground = box((4.0, 1.0, 1.0), (-1.0, 0.0, -1.0), "ground")
    near = Assembly((ground, cube, kerb)).with_fixed(["ground", "kerb"])
    options = LimitOptions(width=1.0, equilibrium_only=True)
    found = limit_load(near, (9.81, 0.0, 0.0), friction=0.6, upper=13.0, options=options)
    (remark,) = found.remarks
    assert "g it is undecided: it falls as drawn, and may stand if near blocks touch" in remark
    assert "'cube' and 'kerb' are 50 mm apart" in remark


def test_an_unknown_value_has_no_unit_and_one_value_is_no_range() -> None:
    tower_of_two = Model.of(tower(2), friction=0.6)
    assert "stands at none that was tried, falls" in repr(
        limit_tilt(tower_of_two, stop=lambda: True)
    )
    stable, unsure = (
        Evaluation(x, v) for x, v in ((1.0, Verdict.STABLE), (2.0, Verdict.UNDECIDED))
    )
    bracket = Bracket(stands=1.0)
    limit = Limit(Quantity("tilt", "deg"), 0.0, 9.0, bracket, evaluations=(stable, unsure))
    assert limit.remarks == ("at 2 deg it is undecided",)
    assert limit.title == "Forces balance up to tilt 1 deg; beyond undecided"
    closed = replace(limit, equilibrium=Bracket(1.0, 4.0), stopped="time limit")
    assert (
        closed.title
        == "Forces balance up to tilt 1 deg, falls from 4\N{DEGREE SIGN}; between them undecided"
    )
    told = [one.text for one in closed.sentences()]
    assert "not finished: time limit; between 1 and 4 deg it is open" in told
    rough = replace(limit, quantity=Quantity("friction"), start=0.6, end=0.0, evaluations=())
    least = replace(rough, equilibrium=Bracket(0.001, 0.0))
    assert least.title.endswith("down to friction 0.001, the least above 0 that was tried")


def test_a_live_load_may_be_a_vector_or_a_multiple_of_the_weight() -> None:
    model = Model.of(tower(2), friction=0.6)
    sideways = limit_load(model, (9.81, 0.0, 0.0))
    assert sideways.best.stands == pytest.approx(0.6, rel=1e-3)
    case = LoadCase.gravity(model.assembly, 9.81, (1.0, 0.0, 0.0))
    assert limit_load(model, case).best.stands == sideways.best.stands
    assert limit_load(model, 1.0, upper=5.0).best.stands == 5.0


def test_a_live_load_may_be_words_as_in_the_command() -> None:
    """A block of 23,544 N slides at 0.6 of it; a point load along gravity is along that given."""
    model = Model.of(tower(2), friction=0.6)
    assert limit_load(model, "seismic:1").best.stands == pytest.approx(0.6, rel=1e-3)
    pushed = limit_load(model, "block-1:1kN,0,0", options=LimitOptions(equilibrium_only=True))
    assert pushed.equilibrium.value == pytest.approx(0.6 * 23.544, rel=1e-3)
    case = LoadCase(LoadCase.seismic(model.assembly, 0.5).wrench, "wind")
    named = Model(model.assembly, model.contacts, cases=(LoadCase.gravity(model.assembly), case))
    assert limit_load(named, "wind").best.stands == pytest.approx(1.2, rel=1e-3)


def test_the_limit_of_a_load_that_acts_already_tells_what_stands_in_all() -> None:
    """A block of 23,544 N slides at 14,126 N: 10 kN that act are 1.4126 times, and carried."""
    only, model = LimitOptions(equilibrium_only=True), Model.of(tower(2), friction=0.6)
    push = LoadCase.point_load(model.assembly, "block-1", (1e4, 0.0, 0.0))
    for factor, more, every in ((1.0, "0.4126", "1.4126"), (0.5, "0.9125", "1.4125")):
        found = limit_load(model.with_load(model.load + factor * push), push, options=only)
        assert found.title.endswith(f" load factor {more} on top of what acts: {every} in all")
        assert found.news is Role.GOOD
    other = limit_load(model, (9.81, 0.0, 0.0), options=only)  # it is called gravity too
    assert "on top" not in other.title


def test_a_load_that_forces_could_always_balance_has_a_bracket_by_its_own_limit() -> None:
    # jammed in its slab the plank could carry any load, so the convex limit tells no scale
    plank = Model.of(concave("short"), friction=0.3)
    asked = LimitOptions(robust=True, width=0.04)
    limit = limit_load(plank, (9.81, 0.0, 0.0), options=asked)
    assert limit.equilibrium.falls is None
    assert limit.robust is not None
    assert limit.robust.stands is not None
    assert limit.robust.falls is not None
    assert limit.robust.falls - limit.robust.stands <= 8e-2
    near = limit_load(plank, (9.81, 0.0, 0.0), upper=1e9, options=LimitOptions(width=0.1)).best
    assert near.stands is not None
    assert near.falls is not None
    assert near.stands < limit.robust.falls
    assert limit.robust.stands < near.falls


def test_a_least_friction_does_not_depend_on_the_largest() -> None:
    plank = concave("short")
    model = Model.of(plank, friction=0.8, load=LoadCase.tilt(plank, (0.0, 1.0, 0.0), 10.0))
    coarse = LimitOptions(width=0.02)
    near, far = (limit_friction(model, upper=upper, options=coarse).best for upper in (0.8, 200.0))
    assert near.stands is not None
    assert near.falls is not None
    assert far.stands == pytest.approx(near.stands, abs=4e-2)
    assert far.falls == pytest.approx(near.falls, abs=4e-2)


def test_a_least_friction_takes_few_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def counted(statics: Statics, **how: Any) -> NearestMechanism:
        asked.append(statics)
        return nearest_mechanism(statics, **how)

    for module in ("drystone.limits.bounds", "drystone.programs.rbe"):
        monkeypatch.setattr(f"{module}.nearest_mechanism", counted)
    column = tower(2)
    for model, upper, expected in (
        (
            Model.of(column, load=LoadCase.tilt(column, (0.0, 1.0, 0.0), 10.0)),
            0.9,
            np.tan(np.pi / 18),
        ),
        (Model.of(arch(0.15), friction=0.9), 0.9, 0.3516),
    ):
        asked.clear()
        bound = limit_friction(
            model, upper=upper, options=LimitOptions(equilibrium_only=True)
        ).equilibrium
        assert bound.falls < expected < bound.stands < bound.falls + 1.001e-3
        assert len(asked) <= 5


def test_a_finer_bracket_keeps_the_islands_that_were_found_beyond_it() -> None:
    plank = Model.of(concave("short"), friction=0.3)
    stands = check(plank)
    weight = plank.load.wrench[1, 2]

    def island(model: Model) -> Result:
        factor = -model.load.wrench[1, 0] / weight
        return stands if factor < 0.3 or factor > 600.0 else replace(stands, verdict=FALLS)

    limit = limit_load(plank, (9.81, 0.0, 0.0), check=island)
    assert limit.best.stands == pytest.approx(0.3, rel=2e-4)
    assert limit.islands == ((pytest.approx(2000.0 / 3.0), 1000.0),)
    assert limit.evaluations[-1].value == 1000.0


def test_a_check_that_allows_more_than_the_exact_cone_is_asked_beyond_its_limit() -> None:
    """The octagon of friction of a published wedge, which the exact cone lets fall at 13.1."""
    octagon = FrictionCone.octagon()
    ask = partial(solve_rbe, options=RBEOptions(cone=octagon))
    model = Model.of(wedge("d"), friction=0.2)
    both = LimitOptions(cone=octagon, equilibrium_only=True)
    own, known = limit_tilt(model, "x", check=ask), limit_tilt(model, "x", options=both)
    assert own.stands == pytest.approx(known.stands, abs=0.05)
    assert own.falls == pytest.approx(known.falls, abs=0.05)


def test_what_stands_to_the_end_for_every_stiffness_is_not_sensitive() -> None:
    limit = limit_load(Model.of(concave("short"), friction=0.3), (-9.81, 0.0, 0.0))
    assert limit.best.stands == limit.end
    assert limit.best.falls is None
    assert not limit.is_sensitive
    assert limit.remarks == ()


@pytest.mark.parametrize(
    ("assembly", "axis", "friction"), [(h_model(), "y", 0.6), (incline(30.0), "-y", 0.1)]
)
def test_what_falls_at_the_start_for_every_stiffness_is_not_sensitive(
    assembly: Assembly, axis: str, friction: float
) -> None:
    limit = limit_tilt(assembly, axis, friction=friction)
    assert limit.best.falls == limit.start
    assert not limit.is_sensitive
    assert limit.remarks == ()


def test_a_stopped_sweep_has_the_directions_that_are_complete() -> None:
    none = tilt_sweep(Model(TOWER, JOINTS), 4, options=QUICK, stop=lambda: True)
    assert (none.limits, none.to_dict()["weakest_azimuth"]) == ((), None)
    with pytest.raises(InputError, match="0 of 4 directions are known"):
        _ = none.weakest
    ended = False

    def tell(*_: Any) -> None:
        nonlocal ended
        ended = True

    some = tilt_sweep(Model(TOWER, JOINTS), 4, options=QUICK, progress=tell, stop=lambda: ended)
    assert some.azimuth.tolist() == [0.0]
    assert some.missing == (90.0, 180.0, 270.0)
    assert some.stopped == "it was interrupted after 1 of 4 directions (degrees: 0)"
    assert some.to_dict()["stopped"] == some.stopped
    assert some.sentences()[0].role is Role.UNSURE
    # one direction is no weakest one
    assert some.to_dict()["weakest_azimuth"] is None
    assert "1 of 4 directions" in repr(some)
    with pytest.raises(InputError, match="1 of 4 directions are known"):
        _ = some.weakest


def test_a_time_limit_ends_every_search_with_what_is_known() -> None:
    model = Model(TOWER, JOINTS)
    push = LoadCase.seismic(TOWER, 1.0)
    for found in (
        limit_tilt(model, time_limit_s=0.0),
        limit_friction(model, time_limit_s=0.0),
        limit_load(model, push, time_limit_s=0.0),
        limit_shrink(model, time_limit_s=0.0),
        limit_thickness(lambda t: arch(t, 8), 0.2, 0.05, time_limit_s=0.0),
        tilt_sweep(model, 2, time_limit_s=0.0),
    ):
        assert found.stopped.startswith("the time was up")
    drawn = imperfections(model, Imperfections(offset=0.01), draws=50, time_limit_s=0.0)
    assert len(drawn.verdicts) == 1


def test_stopped_draws_are_those_made() -> None:
    kinds = Imperfections(offset=0.01)
    some = imperfections(Model(TOWER, JOINTS), kinds, draws=50, stop=after(2))
    assert (len(some.verdicts), some.share) == (3, 1.0)
    assert some.verdicts == imperfections(Model(TOWER, JOINTS), kinds, draws=3).verdicts


@pytest.mark.parametrize(
    ("family", "start", "guess"),
    [
        (Tilt(Model.of(wedge("c", longer=0.2), friction=0.84), np.array([1.0, 0.0, 0.0])), 0, 60.0),
        (Tilt(Model.of(wedge("a"), friction=0.3), np.array([0.0, 1.0, 0.0])), 0, 90.0),
        (LoadFactor(Model.of(tower(2), friction=0.4), LoadCase.seismic(tower(2), 1.0)), 0, 1.0),
    ],
)
def test_check_says_the_same_on_both_sides_of_a_limit(
    family: Tilt | LoadFactor, start: float, guess: float
) -> None:
    options = LimitOptions(scan=2, width=0.05 * guess)
    if isinstance(family, Tilt):
        limit = limit_tilt(family.model, family.axis, upper=guess, options=options)
    else:
        limit = limit_load(family.model, family.live, upper=guess, options=options)
    stands, falls = limit.best.stands, limit.best.falls
    assert stands is not None
    assert falls is not None
    margin = 0.01 * guess
    assert check(family(max(stands - margin, start))).stable
    assert check(family(stands)).stable
    assert check(family(falls)).falls
    assert check(family(falls + margin)).falls


def test_a_limit_tells_where_stiffness_decides_and_for_every_stiffness_if_asked() -> None:
    # wedge b: 3DEC falls at 58.7 degrees (Kao 2023), uniform stiffness holds it to 42
    model = Model.of(wedge("b", longer=0.2), friction=0.84)
    limit = limit_tilt(model, "x", options=LimitOptions(scan=1, width=1.0, robust=True))
    assert (limit.stands, limit.falls) == (limit.rest.stands, limit.rest.falls)
    assert limit.stands == pytest.approx(57.5, abs=1.5)
    assert limit.robust.stands <= limit.uniform.stands + 1.0
    assert limit.uniform.stands == pytest.approx(42.0, abs=1.5)
    low, high = limit.sensitive_between
    assert low == pytest.approx(limit.robust.stands)
    assert high == pytest.approx(limit.falls)
    assert "depends on the stiffness of the joints" in limit.remarks[0]
    safe = re.search(r"; for design use ([\d.]+)°$", limit.remarks[0])
    assert float(safe[1]) == pytest.approx(limit.robust.stands, abs=0.01)
    assert limit.to_dict()["sensitive_between"] == [low, high]
    plain = limit_tilt(Model(TOWER, JOINTS), "x", options=LimitOptions(scan=1, width=20.0))
    assert plain.robust is None


def test_a_stopped_search_keeps_the_fall_that_was_followed() -> None:
    model = Model.of(wedge("b", longer=0.2), friction=0.84)
    few = LimitOptions(scan=1, width=8.0)
    calls = itertools.count()
    whole = limit_tilt(model, "x", options=few, stop=lambda: next(calls) < 0)
    late = iter([False] * (next(calls) - 2))
    limit = limit_tilt(model, "x", options=few, stop=lambda: next(late, True))
    assert limit.stopped
    assert limit.rest.stands <= whole.rest.stands
    assert limit.rest.falls >= whole.rest.falls
    assert limit.rest.falls < limit.equilibrium.stands


def test_what_falls_at_the_start_has_no_limit_farther_on() -> None:
    """Turned back by 18.4 degrees the tower would stand, as its load slopes by 45."""
    sloping = Model.of(tower(3), friction=0.6, load=(6.0, 0.0, -6.0))
    limit = limit_tilt(sloping, "-y")
    assert limit.best.stands is None
    assert (limit.equilibrium.stands, limit.equilibrium.falls) == (None, 0.0)


def test_a_tilt_is_told_about_its_own_axis() -> None:
    model = Model.of(tower(2), friction=0.6)
    pushed = model.with_load(model.load + 0.1 * LoadCase.of(model.assembly, (9.81, 0.0, 0.0)))
    assert limit_tilt(pushed, "x").title.endswith("degrees about x")
    assert limit_tilt(model, (1.0, 1.0, 0.0)).title.endswith("towards 315 degrees from x")


def test_blocks_that_slide_apart_slide_towards_no_side() -> None:
    one = incline(40.0)
    turn = 0.5 * np.diag([-1.0, -1.0, 1.0])
    other = [block.transformed(turn, (-5.0, 0.0, 0.0)).renamed(f"{block.name}-2") for block in one]
    found = limit_friction(Assembly((*one, *other), [True, False, True, False]))
    assert "first motion: slides" in [sentence.text for sentence in found.sentences()]


def test_what_stands_where_the_search_ends_is_told_as_a_bound() -> None:
    """A cap of the search is no limit of the model; friction does not go below zero."""
    small = limit_load(tower(2), "block-1:0,0,-1", upper=7.0)
    assert small.title == "Stands up to load factor 7 at least, where the search ends"
    assert small.sentences()[-1].text == "searched from 0 to 7; --upper goes on"
    assert limit_load(tower(2), (9.81, 0.0, 0.0), friction=0.5).title.endswith("factor 0.49997 g")
    short = limit_load(tower(2), "block-1:100kN,0,0", friction=0.5)
    told = "Does not stand under the load as given, only up to load factor 0.11771"
    assert short.title == told
    assert (short.news, short.code) == (Role.UNSURE, 0)
    assert short.layers().stages[0].role is Role.UNSURE  # its headline is not green
    assert limit_friction(tower(2)).title == "Stands down to friction 0"
    swept = tilt_sweep(tower(2), 2, upper=5.0)
    told = "Stands up to 5 degrees at least, where the search ends, towards each of 2 directions"
    assert swept.title == told


def test_a_search_of_a_large_model_that_is_stopped_says_what_it_knows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The convex program of so many joints takes minutes; values near the start do not."""
    monkeypatch.delattr("drystone.limits.limits.tilt_bound")  # and is not begun when it is late
    model, seen = Model.of(wall(2, 3200), friction=0.6), set()

    def progress(stage: str, done: int, total: int) -> None:
        del done, total
        seen.add(stage)

    found = limit_tilt(model, progress=progress, stop=lambda: "limit of equilibrium" in seen)
    assert found.stopped == "it was interrupted"
    assert found.title == "Stands up to 0.45 degrees about x at least"
    assert found.rest is not None
    assert found.falls is None
    nothing = limit_tilt(tower(2), stop=lambda: True)
    assert nothing.title == "No verdict is known yet"
    assert nothing.sentences()[0].role is Role.UNSURE


def test_edges_that_only_the_state_that_falls_counts_are_no_error_of_its_picture() -> None:
    two = segmental_bridge(span=3.0, rise=1.0, ring=0.3, voussoirs=5, rings=2)
    model = Model.of(two, friction=0.6)
    weak = model.with_capacity(JointCapacity.of_stress(model.contacts, compression=8e6))
    found = limit_shrink(weak, options=LimitOptions(equilibrium_only=True))
    stands, falls = (state.contacts.corner_count for state, _, _ in found.states)
    assert stands < falls
    assert found.layers().contacts.corner_count == stands + falls
