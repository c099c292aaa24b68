"""Verdicts where the contact stiffness decides: the blocks are followed."""

import itertools
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.workloads import random_pile
from drystone import Assembly, CheckOptions, LoadCase, Model, Verdict, check, settle, solve_cra
from drystone.assembly import replace_block
from drystone.checks import check_forces
from drystone.design import MendOptions, find_mends
from drystone.geometry.frames import rotation_about
from drystone.limits.limit_types import every_stiffness
from drystone.models import (
    box,
    bridge,
    concave,
    cube_curve,
    dome,
    h_model,
    random_pack,
    snake,
    wall,
    wedge,
)
from drystone.models.simple import prism
from drystone.results import Sensitivity
from drystone.settlement import Carrier, Outcome, SettlementOptions
from drystone.settlement.settling import settle_for_verdict
from drystone.stability import try_rest

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
MOVING = CheckOptions(settlement=SettlementOptions(carrier=Carrier.MOVING))


def tilted(
    assembly: Assembly, axis: tuple[float, float, float], angle: float, friction: float = 0.84
) -> Model:
    return Model.of(assembly, friction=friction, load=LoadCase.tilt(assembly, axis, angle))


def taper(degrees: float) -> Assembly:
    """A plug between two walls that lean outwards."""
    lean = float(np.tan(np.deg2rad(degrees)))
    y = (-0.5, 0.5)
    wall = [(0.5, 0.0), (1.5, 0.0), (1.5 + lean, 1.0), (0.5 + lean, 1.0)]
    plug = [(-0.5, 0.0), (0.5, 0.0), (0.5 + lean, 1.0), (-0.5 - lean, 1.0)]
    blocks = (
        prism([(-x, z) for x, z in wall], y, "left"),
        prism(wall, y, "right"),
        prism(plug, y, "plug"),
    )
    return Assembly(blocks, np.array([True, True, False]))


@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_a_plug_that_hardly_tapers_stands_and_one_that_does_not_falls(friction: float) -> None:
    # statics: N = W / (2 sin a) on either face, at any friction
    found = check(Model.of(taper(0.05), friction=friction))
    assert found.verdict is Verdict.STABLE
    assert check(Model.of(taper(0.0), friction=friction)).verdict is Verdict.UNSTABLE
    assert check(Model.of(h_model(), friction=friction)).verdict is Verdict.UNSTABLE


@pytest.mark.parametrize(("degrees", "friction"), [(0.005, 0.5), (0.03, 0.0)])
def test_springs_that_move_a_plug_far_are_replaced_by_stiffer_ones(
    degrees: float, friction: float
) -> None:
    # statics: N = W / (2 (sin a + mu cos a))
    model = Model.of(taper(degrees), friction=friction)
    assert check(model).stable
    settled = settle(model)
    assert settled.outcome is Outcome.RESTS
    assert settled.path.overlap < SettlementOptions().overlap


def test_a_plug_that_was_not_followed_to_an_end_is_undecided() -> None:
    # it was said that nothing presses on it; it comes to rest
    model = Model.of(taper(0.05), friction=0.0)
    for calls in (0, 5, 60):
        left = iter(range(calls))
        found = check(model, stop=lambda left=left: next(left, None) is None)  # type: ignore[misc]
        assert found.verdict is Verdict.UNDECIDED
        assert found.stopped
    few = CheckOptions(settlement=SettlementOptions(step_limit=20))
    assert check(model, options=few).verdict is Verdict.UNDECIDED
    assert check(model).stable


def test_a_plug_that_presses_little_and_moves_on_is_told_so() -> None:
    found = check(Model.of(taper(1e-5), friction=0.1))
    assert found.verdict is Verdict.UNSTABLE
    assert "hardly anything presses on some of its blocks at first, and it falls" in found.message


def test_what_comes_to_rest_stands_after_settling_and_is_sensitive() -> None:
    model = tilted(wedge("b", longer=0.2), X, 55.0)
    found = check(model)
    assert found.verdict is solve_cra(model).verdict is Verdict.STABLE
    assert "it comes to rest after settling by" in found.message
    assert "sensitive" in found.message
    assert found.samples.standing < found.samples.tried
    assert found.settlement.outcome is Outcome.RESTS
    assert found.residuals is not None
    assert found.residuals.largest < 1e-8
    assert found.force is not None
    total = found.resultants.force.sum(axis=0)
    weight = found.load.wrench[2, :3]
    # on the moved blocks, told in the axes of the first joints
    assert total == pytest.approx(-weight, abs=1e-6 * np.linalg.norm(weight))


def test_what_is_followed_into_a_fall_is_unstable_though_it_could_be_wedged() -> None:
    model = tilted(concave("short"), Y, 50.0)
    found = check(model)
    assert found.verdict is Verdict.UNSTABLE
    assert found.falling_names == ("plank",)
    assert found.mechanism is not None
    assert "forces could balance the loads, but the loads alone do not" in found.message
    assert found.message.endswith("shims or prestress might hold it")
    assert not found.sensitive_to


def test_a_box_that_slides_off_onto_slivers_of_its_joints_falls() -> None:
    steeper = tilted(random_pack(16, seed=11), X, 31.0, 0.6)  # than the friction, 30.96 degrees
    found = check(steeper)
    assert found.verdict is Verdict.UNSTABLE
    assert "has moved by 0.05" in found.message


def test_a_stiffness_that_does_not_hold_what_stands_makes_it_sensitive_to_the_joints() -> None:
    leaning = tilted(random_pack(16, seed=16), X, 26.0, 0.6)
    found = check(leaning, options=CheckOptions.robust())
    assert found.verdict is Verdict.STABLE
    assert found.sensitive_to == (Sensitivity.JOINTS,)
    # it is known then, and no further one is tried
    assert found.samples.standing == found.samples.tried - 1


def test_a_corner_that_only_just_touches_is_no_reason_to_refuse_a_rest_state() -> None:
    found = check(Model.of(random_pack(20, seed=2), friction=0.5), options=CheckOptions.robust())
    assert found.verdict is Verdict.STABLE
    assert not found.sensitive_to


def test_what_shear_stiffness_decides_is_undecided_with_both_motions() -> None:
    model = tilted(wedge("b"), X, 57.8)
    one = replace(MOVING, stiff_shear=None)
    assert check(model, options=one).falls
    stiff = replace(one.settlement, tangential=0.5)
    assert check(model, options=replace(one, settlement=stiff)).stable
    found = check(model, options=MOVING)
    assert found.verdict is Verdict.UNDECIDED
    assert "it depends on the shear stiffness of the joints: at 0.17" in found.message
    assert Sensitivity.SHEAR in found.sensitive_to
    assert found.settlement.outcome is Outcome.SHEAR_DECIDES
    assert [path.tangential for path in found.settlement.paths] == [0.17, 0.5]
    takes = "it would stand at 0.46 and not at 0.42, and both ways with 1.02 times the friction"
    assert takes in found.message
    between = replace(one, settlement=replace(one.settlement, tangential=0.46))
    assert check(model, options=between).stable
    assert check(model.with_friction(1.02 * 0.84), options=MOVING).stable


@pytest.mark.parametrize("degrees", [60.0, 62.0])
def test_with_another_shear_stiffness_blocks_are_followed_until_they_go_on_as_before(
    degrees: float,
) -> None:
    model, falls = tilted(wedge("a"), X, degrees), {}
    soft = replace(MOVING.settlement, fall=0.05)
    stiff = replace(soft, tangential=0.5)
    alone = settle_for_verdict(model, options=stiff)
    first, then = (settle_for_verdict(model, options=one, falls=falls) for one in (soft, stiff))
    assert {one.outcome for one in (alone, first, then)} == {Outcome.FALLS}
    assert then.travel < 0.01 * alone.travel


def test_workers_tell_the_course_of_what_falls_as_one_process_does() -> None:
    model = tilted(wedge("a"), X, 60.0)
    chosen = SettlementOptions(fall=0.05)
    alone, shared = {}, {}
    settle_for_verdict(model, options=chosen, falls=alone)
    with ProcessPoolExecutor(2) as workers:
        settle_for_verdict(model, options=chosen, executor=workers, falls=shared)
    assert set(shared) == set(alone) == {Carrier.MOVING, Carrier.RESTING}
    for carrier, course in alone.items():
        for (there, left), (far, drag) in zip(shared[carrier], course, strict=True):
            assert there == far
            assert np.array_equal(left, drag)


def test_flush_ends_leave_it_undecided_with_both_motions_and_longer_grooves_do_not() -> None:
    flush = tilted(wedge("c"), X, 40.0)
    found = check(flush)
    assert found.verdict is Verdict.UNDECIDED
    assert "the ends of the joints decide" in found.message
    assert [path.outcome for path in found.settlement.paths] == [Outcome.RESTS, Outcome.FALLS]
    assert check(flush, options=MOVING).verdict is Verdict.STABLE
    assert check(flush, ends="longer").verdict is Verdict.STABLE
    assert check(flush, ends="exact").verdict is Verdict.UNSTABLE
    assert check(tilted(wedge("c", longer=0.2), X, 40.0)).verdict is Verdict.STABLE


def test_coupled_analysis_finds_the_published_state_that_the_ends_of_joints_leave_open() -> None:
    # Kao 2023, table 6.2: up to 44.1 degrees; it was undecided from 36.5 on
    found = solve_cra(tilted(wedge("c"), X, 43.6))
    assert found.verdict is Verdict.STABLE
    assert found.method == "cra"
    assert found.residuals.largest < 1e-6
    assert found.eta < 1000.0


def test_no_verdict_depends_on_seed_place_direction_numbering_or_the_last_digits() -> None:
    # of six seeds three found a state of the first, of which only the stiffest joints know
    steep = np.array([9.185616325, 0.0, 3.434361215])
    for assembly, pull, expected in (
        (wedge("b"), steep, Verdict.UNSTABLE),
        (wedge("b", longer=0.2), LoadCase.tilt(wedge("b"), X, 55.0).wrench[2, :3] / 1e4,
         Verdict.STABLE),
    ):  # fmt: skip
        turn = rotation_about((1.0, 2.0, 3.0), 77.0)
        copies = [
            (assembly, pull * (1.0 + 3e-10), 1),
            (assembly.transformed(turn, (12.3, -45.6, 7.89)), turn @ pull, 0),
            (Assembly(assembly.blocks[::-1], assembly.fixed[::-1]), pull, 2),
        ]
        for copy, load, seed in copies:
            model = Model.of(copy, friction=0.84, load=load)
            assert check(model, options=CheckOptions(seed=seed)).verdict is expected


def test_who_asks_for_one_stiffness_is_not_kept_waiting_for_steps() -> None:
    model = tilted(wedge("b"), X, 50.0)
    found = check(model, options=CheckOptions(samples=0, settle=False))
    assert found.verdict is Verdict.UNSTABLE
    assert found.settlement is None


def plate(density: float = 2000.0) -> Assembly:
    """A plate, wider below by 0.6 degrees, between blocks that stand on two ramps without it."""
    slope, lean, y = np.tan(np.deg2rad(30.0)), np.tan(np.deg2rad(0.3)), (0.0, 0.5)
    wide, narrow = 0.05 + 0.25 * lean, 0.05 - 0.25 * lean
    ramp = [(wide, 0.0), (wide + 1.0, 0.0), (wide + 1.0, 0.5 + slope), (wide, 0.5)]
    beside = [(wide, 0.5), (wide + 1.0, 0.5 + slope), (wide + 1.0, 0.6 + slope), (narrow, 1.0)]
    between = [(-wide, 0.5), (wide, 0.5), (narrow, 1.0), (-narrow, 1.0)]
    blocks = (
        *(prism([(s * x, z) for x, z in ramp], y, f"ramp {s}") for s in (-1, 1)),
        *(prism([(s * x, z) for x, z in beside], y, f"beside {s}") for s in (-1, 1)),
        prism(between, y, "plate", density),
    )
    return Assembly(blocks, np.array([True, True, False, False, False]))


@pytest.mark.parametrize("degrees", [-1.0, -0.2, 0.0, 0.2, 1.0])
def test_a_block_that_its_free_neighbours_settle_against_does_not_fall_freely(
    degrees: float,
) -> None:
    # within 0.3 degrees of upright the plate's own weight opens both of its joints
    model = tilted(plate(), Y, degrees, friction=0.7)
    found = check(model)
    assert found.verdict is Verdict.STABLE
    # a rest state in which both neighbours press on it: nothing is followed
    assert found.settlement is None
    assert try_rest(model).verdict is Verdict.STABLE


def test_a_plate_too_heavy_for_the_friction_of_its_neighbours_falls() -> None:
    assert check(Model.of(plate(density=40_000.0), friction=0.7)).verdict is Verdict.UNSTABLE


@pytest.mark.parametrize(("tilt", "seed"), [(65.7, 5), (66.3, 1)])
def test_where_friction_decides_the_verdict_is_that_of_the_steps_with_every_seed(
    tilt: float, seed: int
) -> None:
    # each of five stiffnesses has a rest state at some of these tilts and with some seeds
    model = tilted(cube_curve("short"), (1.0, 1.0, 0.0), tilt)
    assert check(model, options=CheckOptions(seed=seed)).verdict is Verdict.UNSTABLE


@pytest.mark.parametrize("tilt", [38.0, 40.0])
def test_a_rest_state_to_which_no_path_converges_is_found_by_way_of_smooth_friction(
    tilt: float,
) -> None:
    model = tilted(cube_curve("tall"), (1.0, 1.0, 0.0), tilt)
    found = check(model, options=CheckOptions.robust())
    assert found.stable
    assert found.settlement is None
    assert (found.samples.tried, found.samples.standing) == (5, 5)


def test_a_rest_state_that_slides_far_is_followed() -> None:
    # close to its limit the hood slides 100 times its overlap; with other friction it falls
    model = tilted(cube_curve("short"), (-1.0, 0.0, 0.0), 72.7)
    assert every_stiffness(model).verdict is Verdict.UNSTABLE
    found = check(model)
    assert found.verdict is Verdict.UNSTABLE
    assert found.samples.standing == found.samples.tried
    rests = tilted(cube_curve("short"), (-1.0, 0.0, 0.0), 72.3)
    assert every_stiffness(rests).verdict is Verdict.STABLE
    found = check(rests)
    assert found.stable
    assert found.samples.standing == found.samples.tried
    # one that comes to rest is as certain as any other
    near = check(tilted(wedge("a"), X, 59.1), options=CheckOptions.robust())
    assert near.settlement is None
    assert "whichever joints press more" in near.message


@pytest.mark.parametrize(
    "model",
    [tilted(snake(), X, 15.0, 0.7), tilted(dome(slices=20, rings=8, bonded=True), Y, 36.0)],
    ids=["snake", "dome"],
)
def test_what_rests_while_friction_goes_back_and_forth_is_not_followed(model: Model) -> None:
    """Many corners stick and slip in turn: given the friction, each round has one state."""
    found = check(model)
    assert (found.stable, found.settlement, found.sensitive) == (True, None, False)
    assert check_forces(found.model, found.force, found.displacement).largest < 1e-8


def flat_arch(depth: float) -> Assembly:
    """Nine stones between two supports; their joints point to a line so far below [m] the middle.

    Forces along the arch balance them without friction: the weight of a stone is as its width.
    """
    stones = []
    ends = [-2.5, *np.linspace(-1.5, 1.5, 10), 2.5]
    for i, (left, right) in enumerate(itertools.pairwise(ends)):
        corners = [(left, -1.0), (right, -1.0), (right, 1.0), (left, 1.0)]
        section = [(x * (1.0 + 0.25 * up / depth), 0.25 * up) for x, up in corners]
        stones.append(prism(section, (0.0, 0.5), name=str(i)))
    return Assembly(tuple(stones)).with_fixed([0, 10])


@pytest.mark.parametrize("depth", [2.0, 7.0])
def test_a_flat_arch_without_friction_is_a_chain_on_its_head(depth: float) -> None:
    """Its forces balance, and what moves a little moves on: as by steps, so by the verdict."""
    slippery = Model.of(flat_arch(depth), friction=0.0)
    assert try_rest(slippery).stable
    found = check(slippery)
    assert found.falls
    assert "without friction nothing brings it back" in found.message
    assert check(Model.of(flat_arch(depth), friction=0.3)).stable


def test_what_falls_though_forces_balance_is_mended() -> None:
    """No force is missing, so no region was looked at: a little friction holds it."""
    slippery = Model.of(flat_arch(7.0), friction=0.0)
    found = find_mends(slippery, options=MendOptions(kinds="friction"))
    assert "missing" not in {layer.key for layer in found.layers().stages[0].layers}
    (rough,) = found.mends
    assert rough.result.stable
    assert rough.change.value <= 0.05


def test_what_slides_far_is_followed_whatever_stands_beside_it() -> None:
    """Blocks beside it that overlap more once hid that it slides: they were said to stand."""
    whole = Model.of(bridge(), friction=0.66).with_supports([0, 1, 8])
    alone, beside = [0, 2, 6, 8], [1, 5, 7, 10]
    assert check(whole.subset([8, *beside])).stable
    assert check(whole.subset(alone)).falls
    assert check(whole.subset([*alone, *beside])).falls


@pytest.mark.parametrize("tilt", [50.0, 57.0])
def test_blocks_that_were_not_followed_to_an_end_are_undecided(tilt: float) -> None:
    model = tilted(wedge("b"), X, tilt)
    assert check(model, options=MOVING).stable
    few = CheckOptions(settlement=SettlementOptions(carrier=Carrier.MOVING, step_limit=20))
    found = check(model, options=few)
    assert found.verdict is Verdict.UNDECIDED
    assert "after 20 steps" in found.message


def test_an_interrupted_check_claims_no_fall_of_what_comes_to_rest() -> None:
    model = tilted(wedge("c"), X, 42.0)
    verdicts = []
    for calls in range(0, 40, 4):
        asked = itertools.count()
        found = check(model, options=MOVING, stop=lambda asked=asked, at=calls: next(asked) >= at)  # type: ignore[misc]
        verdicts.append(found.verdict)
        assert found.verdict is not Verdict.UNSTABLE
    assert Verdict.UNDECIDED in verdicts
    assert check(model, options=MOVING).stable


def beside_heavy_ones() -> Assembly:
    """Two light blocks, which lean on a stack of 67 and 12 t and would tip without its friction."""
    boxes = {
        "ground": (2e3, (-0.5, -0.25, -0.3), (4.0, 1.5, 0.3)),
        "heavy": (1.57e5, (1.11, 0.07, 0.0), (0.91, 0.83, 0.57)),
        "upper": (4.79e4, (1.11, 0.2, 0.57), (0.91, 0.54, 0.51)),
        "foot": (7.07, (2.02, 0.36, 0.0), (0.76, 0.49, 0.41)),
        "light": (26.5, (2.02, 0.05, 0.41), (0.76, 0.77, 0.38)),
    }
    blocks = [box(size, at, name=name, density=d) for name, (d, at, size) in boxes.items()]
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


def test_light_blocks_that_fall_on_much_softer_joints_only_are_decided() -> None:
    """Softer joints of light blocks are there to tell rest from rounding; they prove no fall."""
    model, axis = beside_heavy_ones(), (3.0**0.5, 1.0, 0.0)
    assert check(tilted(model, axis, 15.0, 0.6)).stable
    found = [check(tilted(model, axis, tilt, 0.6)) for tilt in (21.0, 21.5, 22.5)]
    assert all(one.stable for one in found)
    assert any(Sensitivity.WEIGHTS in one.sensitive_to for one in found)
    assert check(tilted(model, axis, 28.0, 0.6)).falls


@pytest.mark.parametrize("margin", [0.03, -0.03])
def test_light_blocks_that_topple_on_a_heavy_one_fall_by_a_mechanism(margin: float) -> None:
    """Four blocks lean out over the edge of one that is 1e8 times heavier, which stands."""
    steps = [0.0, 0.05, *(np.array([0.25, 0.45, 0.65, 0.85]) - margin)]
    density = [2400.0, 2.4e11, *[2400.0] * 4]
    blocks = [
        box((1.0, 1.0, 0.2), (x, 0.0, 0.2 * i), f"b{i}", rho)
        for i, (x, rho) in enumerate(zip(steps, density, strict=True))
    ]
    ground = box((6.0, 6.0, 1.0), (-3.0, -3.0, -1.0), "ground")
    found = check(Assembly((ground, *blocks)).with_fixed([0]), friction=0.6)
    assert found.stable == (margin > 0.0)
    if margin < 0.0:
        assert found.message == "no contact forces can balance the loads"
        assert found.mechanism is not None
        assert not found.mechanism[:3].any()
        assert found.falling == (3, 4, 5, 6)


def test_a_wall_with_one_heavy_stone_is_followed_with_what_its_blocks_feel_from_the_start() -> None:
    """The check asks 589 times whether to stop; 2,962 times where that is not known."""
    blocks, asked = wall(5, 4), itertools.count()
    density = np.where(np.array(blocks.names) == "c02-b00", 2e11, 2000.0)
    model = Model.of(blocks.with_density(density.tolist()), friction=0.7)
    assert check(model, stop=lambda: next(asked) < 0).stable
    assert next(asked) < 1000


def test_each_shear_stiffness_is_followed_with_what_light_blocks_feel() -> None:
    """The check asks 2,597 times whether to stop; 15,300 times where a fall is followed again."""
    pile, random = random_pile(9, 12).assembly, np.random.default_rng(9)
    asked = itertools.count()
    model = tilted(
        pile.with_density((10.0 ** random.uniform(0.0, 6.0, len(pile))).tolist()),
        (1.0, 0.3, 0.0),
        12.0,
        friction=0.3,
    )
    found = check(model, stop=lambda: next(asked) < 0)
    assert found.verdict is Verdict.UNDECIDED
    # at rest three joints need their corners, by 14 to 33 %
    assert set(found.sensitive_to) == {Sensitivity.WEIGHTS, Sensitivity.SHEAR, Sensitivity.PRESSURE}
    assert next(asked) < 5000


@pytest.mark.parametrize("seed", [0, 5])
def test_blocks_whose_weights_span_eight_decades_are_decided(seed: int) -> None:
    """What is left of the load of a light block counts by what it feels, not by the whole load."""
    pack, random = random_pack(9, seed=seed), np.random.default_rng(seed)
    density = 10.0 ** random.uniform(-1.0, 7.0, len(pack))
    blocks = zip(pack.blocks, density.tolist(), strict=True)
    pack = Assembly(tuple(replace_block(one, density=d) for one, d in blocks), pack.fixed)
    found = check(tilted(pack, (1.0, 0.3, 0.0), 15.0, friction=0.35))
    assert found.verdict is Verdict.STABLE
    assert found.settlement is not None
    assert found.settlement.path.residuals is not None
    assert found.settlement.path.residuals.largest < 1e-8
    # not to the stiffness between joints: uniform springs show nothing beside such weights
    assert found.sensitive_to == (Sensitivity.PRESSURE, Sensitivity.WEIGHTS)
    assert found.utilisation.max() > 1.02
    said = "sensitive to the pressure within joints and light blocks beside heavy ones"
    assert said in found.message


@pytest.mark.parametrize("torque", [0.2, 0.45, 0.6])
@pytest.mark.parametrize(("over", "stands"), [(-1e-4, True), (0.0, True), (1e-4, False)])
def test_an_end_brick_over_exactly_half_stands_whatever_is_followed_beside_it(
    over: float, stands: bool, torque: float
) -> None:
    row = [box((0.4, 0.2, 0.2), (0.4 * i, 0.0, 0.0), f"brick {i}") for i in range(10)]
    ground = box((4.0, 0.2, 0.2), (0.0, 0.0, -0.2), "ground")
    end = box((0.4, 0.2, 0.2), (3.8 + over, 0.0, 0.2), "end")
    assembly = Assembly((ground, *row, end), np.arange(12) < 1)
    model = Model.of(assembly, friction=0.6)
    load = np.array(model.load.wrench)
    # eight bricks away one is turned up between its neighbours, [m] by its weight
    load[2, 4] += torque * load[2, 2]
    found = check(model.with_load(LoadCase(load)))
    assert found.verdict is (Verdict.STABLE if stands else Verdict.UNSTABLE)
    said = [one.text for one in found.margins() if "the margin is zero: 'end'" in one.text]
    assert bool(said) == (over == 0.0)
    assert (found.settlement is not None) == (stands and torque > 0.2)
