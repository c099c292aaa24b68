"""Rest with given friction laws: a yes is a proof, a no says nothing."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from drystone import Assembly, CheckOptions, InputError, LoadCase, Verdict, find_contacts, models
from drystone.checks import check_forces, mechanism_defects
from drystone.formulations.equilibrium import EquilibriumSolution
from drystone.mechanics.law import uniform
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions, RestState
from drystone.model import Model
from drystone.programs import (
    CRAOptions,
    PenaltyOptions,
    RBEOptions,
    solve_cra,
    solve_cra_penalty,
    solve_rbe,
)
from drystone.solvers.program import ConicSolution, ConicStatus
from drystone.stability import check, try_rest
from drystone.stability.attempts import NEAREST, PATIENT, QUICK
from drystone.stability.problem import Problem, checked_mechanism, first_motion

ARCH = models.arch(0.15)
JOINTS = find_contacts(ARCH, friction=0.9).contacts
BOTH_LAWS = PATIENT.with_slip_lengths(None, 1.0)


def test_what_rests_has_forces_and_a_motion_that_pass_the_checks():
    found = try_rest(Model(ARCH, JOINTS))
    assert found.verdict is Verdict.STABLE
    assert found.residuals is not None
    assert found.residuals.largest < 1e-8
    assert found.samples.standing == found.samples.tried == 1


@pytest.mark.parametrize(
    ("assembly", "steps"),
    [(models.wall(6, 5), 1), (models.arch(0.2, 28), 7), (models.barrel_vault(), 5)],
)
def test_what_plainly_stands_is_near_where_no_corner_opens_or_slips(assembly, steps):
    found = check(assembly, friction=0.6, options=CheckOptions(settle=False))
    assert found.stable
    assert found.iterations <= steps


def leaning(angle):
    turned = LoadCase.tilt(models.concave("short"), (0.0, 1.0, 0.0), angle)
    return Model.of(models.concave("short"), friction=0.84, load=turned)


def stands_for_all(model, stop=None):
    found = check(model, options=CheckOptions(samples=4, uniform=True), stop=stop)
    return found.stable and not found.stopped and found.samples.standing == found.samples.tried


def test_what_is_stopped_on_the_way_does_not_stand_for_all():
    asked = itertools.count()
    assert stands_for_all(Model(ARCH, JOINTS), stop=lambda: next(asked) < 0)
    last = next(asked) - 1
    for left in (last // 2, last - 2):
        asked = itertools.count()
        assert not stands_for_all(Model(ARCH, JOINTS), stop=lambda: next(asked) > left)  # noqa: B023


def test_what_does_not_rest_is_undecided_after_every_law():
    leaning = LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 20.0)
    found = try_rest(Model(ARCH, JOINTS, leaning), screening=BOTH_LAWS)
    assert found.verdict is Verdict.UNDECIDED
    assert found.samples.tried == 2
    assert check(Model(ARCH, JOINTS, leaning)).verdict is Verdict.UNSTABLE


@pytest.mark.parametrize(("count", "angle"), [(200, 0.2), (400, 0.0)])
def test_a_high_tower_that_leans_on_the_ground_for_a_while_stands(count, angle):
    tower = models.tower(count)
    contacts = find_contacts(tower, friction=0.6).contacts
    load = LoadCase.tilt(tower, (1.0, 0.0, 0.0), angle)
    found = check(Model(tower, contacts, load), options=CheckOptions(samples=0, settle=False))
    assert found.verdict is Verdict.STABLE


@pytest.mark.parametrize("friction", [0.2, 2.0])
def test_what_presses_on_nothing_is_not_called_resting(friction):
    wedged = models.h_model()
    contacts = find_contacts(wedged, friction=friction).contacts
    assert try_rest(Model(wedged, contacts), screening=BOTH_LAWS).verdict is Verdict.UNDECIDED
    start = np.tile([0.0, 0.0, -1e-3, 0.0, 0.0, 0.0], (len(wedged), 1))
    assert try_rest(Model(wedged, contacts), start=start).verdict is Verdict.UNDECIDED


def test_a_start_at_the_rest_state_of_a_neighbour_changes_no_force():
    whole = try_rest(Model(ARCH, JOINTS))
    nearly = LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 1.0)
    cold = try_rest(Model(ARCH, JOINTS, nearly))
    for size in (1.0, 1e3):
        warm = try_rest(Model(ARCH, JOINTS, nearly), start=size * whole.displacement)
        assert warm.verdict is Verdict.STABLE
        assert np.allclose(warm.force, cold.force, rtol=0.0, atol=1e-8 * np.abs(cold.force).max())


def test_what_has_no_rest_near_its_start_is_given_up_soon_where_that_is_hopeless():
    start, asked, steps = try_rest(Model(ARCH, JOINTS)).displacement, [], []
    for angle, hopeless in itertools.product((1.0, 14.0), (False, True)):
        load = LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), angle)
        found = try_rest(
            Model(ARCH, JOINTS, load),
            screening=QUICK,
            start=start,
            hopeless=lambda at=(angle, hopeless): asked.append(at) or at[1],
        )
        assert found.stable == (angle < 14.0)
        steps.append(found.iterations)
    assert asked == list(itertools.product((1.0, 14.0), (False, True)))
    assert 10 * steps[3] < steps[2]


def test_a_check_from_a_similar_rest_state_has_the_same_verdict_sooner():
    whole = check(Model(ARCH, JOINTS))
    nearly = Model(ARCH, JOINTS, LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 1.0))
    cold, warm = check(nearly), check(nearly, start=whole.displacement)
    assert (warm.message, warm.samples) == (cold.message, cold.samples)
    assert warm.iterations < cold.iterations
    assert np.allclose(warm.force, cold.force, rtol=0.0, atol=1e-8 * np.abs(cold.force).max())
    leaning = Model(ARCH, JOINTS, LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 40.0))
    fallen = check(leaning, start=whole.displacement)
    assert (fallen.verdict, fallen.message) == (Verdict.UNSTABLE, check(leaning).message)
    with pytest.raises(InputError, match="start"):
        check(nearly, start=np.zeros((3, 6)))


def test_over_many_joints_one_random_stiffness_is_enough():
    model = Model.of(models.wall(7, 8), friction=0.6)
    assert len(model.contacts) > 120
    found = check(model, options=CheckOptions.robust())
    assert found.message == "stands, whichever joints press more (4 contact stiffnesses tried)"


def test_a_path_that_does_not_converge_goes_over_longer_slips():
    """Least thickness 0.1075: the path of one of five friction laws leads away, far above it."""
    model = Model.of(models.arch(0.112, 100), friction=0.8)
    found = check(model, options=CheckOptions(samples=4, settle=False))
    assert found.message == "stands, whichever joints press more (5 contact stiffnesses tried)"
    assert stands_for_all(model)
    assert not stands_for_all(Model.of(models.arch(0.107, 100), friction=0.8))


def test_forces_that_balance_the_loads_lead_to_rest_where_the_path_does_not_converge():
    """Part of a bridge, one block held: it need not be followed to be known to stand."""
    bridge = Model.of(models.bridge(), friction=0.66)
    names = ["block-2", *(f"block-{i}" for i in range(4, 10))]
    supports = bridge.assembly.fixed.nonzero()[0].tolist()
    part = bridge.with_supports([*supports, "block-9"]).subset([*supports, *names])
    found = check(part)
    assert (found.verdict, found.message, found.settlement) == (Verdict.STABLE, "stands", None)
    assert found.residuals.largest < 1e-8


@pytest.mark.parametrize("start", [np.zeros((3, 6)), np.full((len(ARCH), 6), np.nan)])
def test_a_start_of_another_assembly_is_refused(start):
    with pytest.raises(InputError, match="start"):
        try_rest(Model(ARCH, JOINTS), start=start)


def test_a_poor_start_is_dropped():
    rng = np.random.default_rng(0)
    for start in (np.zeros((len(ARCH), 6)), rng.standard_normal((len(ARCH), 6))):
        assert try_rest(Model(ARCH, JOINTS), start=start).verdict is Verdict.STABLE


def test_a_quick_screening_finds_the_same_forces_and_names_what_falls():
    quick, whole = try_rest(Model(ARCH, JOINTS), screening=QUICK), try_rest(Model(ARCH, JOINTS))
    assert quick.verdict is Verdict.STABLE
    assert np.array_equal(quick.force, whole.force)
    leaning = LoadCase.tilt(models.tower(4), (0.0, 1.0, 0.0), 30.0)
    found = try_rest(
        Model(models.tower(4), find_contacts(models.tower(4)).contacts, leaning), screening=QUICK
    )
    assert found.verdict is Verdict.UNDECIDED
    assert found.falling_names == ("block-1", "block-2", "block-3")


def test_the_nearest_level_finds_what_rests_near_its_start_and_proves_no_fall():
    whole = try_rest(Model(ARCH, JOINTS))
    nearly = LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 1.0)
    seen = try_rest(Model(ARCH, JOINTS, nearly), screening=NEAREST, start=whole.displacement)
    assert seen.verdict is Verdict.STABLE
    falling = LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 20.0)
    for level in (NEAREST, QUICK):
        found = try_rest(Model(ARCH, JOINTS, falling), screening=level, start=whole.displacement)
        assert found.verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("slip", [0.0, -1.0, float("inf")])
def test_a_slip_length_that_is_none_is_refused(slip):
    with pytest.raises(InputError, match="slip_lengths is"):
        QUICK.with_slip_lengths(slip)


def test_fixed_blocks_rest():
    still = ARCH.with_fixed(range(len(ARCH)))
    assert try_rest(Model(still, JOINTS)).verdict is Verdict.STABLE


def test_a_load_of_another_assembly_is_refused():
    with pytest.raises(InputError):
        try_rest(Model(ARCH, JOINTS, LoadCase.gravity(models.tower(3))))


@pytest.mark.parametrize("tilt", [0.0, 8.0, 20.0])
def test_any_forces_exist_where_the_least_ones_do(tilt):
    leaning = LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), tilt)
    least = solve_rbe(Model(ARCH, JOINTS, leaning), options=RBEOptions(tension=False))
    some = solve_rbe(Model(ARCH, JOINTS, leaning), options=RBEOptions.feasibility())
    assert some.verdict is least.verdict


def test_a_certificate_of_any_size_is_a_mechanism():
    problem = Problem.build(Model(ARCH, JOINTS, LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 20.0)))
    found = solve_rbe(problem.model, options=RBEOptions.feasibility())
    assert found.mechanism is not None
    scaled = problem.statics.scaled_motion(found.mechanism, problem.statics.mean_length)
    raw = ConicSolution(ConicStatus.INFEASIBLE, np.zeros(0), np.zeros(0), 0, "", "")
    for size in (1e-200, 1.0, 1e200):
        claim = EquilibriumSolution(np.zeros((0, 3)), np.zeros(0), size * scaled, raw)
        assert checked_mechanism(problem, claim) == pytest.approx(found.mechanism, rel=1e-6)


def flat_arch(voussoirs):
    """Cubes in a row between two piers, their joints vertical."""
    at = np.linspace(-2.0, 2.0, voussoirs + 1)
    spans = [(-3.0, -2.0), (2.0, 3.0), *itertools.pairwise(at)]
    blocks = [
        models.prism([(a, 0.0), (b, 0.0), (b, 1.0), (a, 1.0)], (0.0, 1.0), f"block-{i}")
        for i, (a, b) in enumerate(spans)
    ]
    return Assembly(tuple(blocks), np.arange(len(blocks)) < 2)


@pytest.mark.parametrize("voussoirs", [1, 2, 3, 4])
@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1e-6])
def test_voussoirs_between_vertical_joints_slide_down_together(voussoirs, tilt):
    """Nothing presses on them, whatever the friction and the last digits of the load."""
    arch = flat_arch(voussoirs)
    contacts = find_contacts(arch, friction=2.0).contacts
    leaning = LoadCase.tilt(arch, (0.0, 1.0, 0.0), tilt)
    assert check(Model(arch, contacts, leaning)).verdict is Verdict.UNSTABLE
    assert try_rest(Model(arch, contacts, leaning)).verdict is Verdict.UNDECIDED


@pytest.mark.parametrize(
    ("voussoirs", "verdict"), [(1, Verdict.UNSTABLE), (2, Verdict.STABLE), (3, Verdict.STABLE)]
)
def test_voussoirs_that_lean_by_a_thousandth_of_a_degree_are_followed(voussoirs, verdict):
    """A single one slides down; several sag by less than a thousandth and carry each other."""
    arch = flat_arch(voussoirs)
    contacts = find_contacts(arch, friction=2.0).contacts
    found = check(Model(arch, contacts, LoadCase.tilt(arch, (0.0, 1.0, 0.0), 1e-3)))
    assert found.verdict is verdict
    if verdict is Verdict.STABLE:
        assert found.settlement.travel < 1e-3
        assert "sensitive" in found.message


@pytest.mark.parametrize("voussoirs", [2, 3])
def test_voussoirs_that_lean_on_their_piers_press_and_stand(voussoirs):
    arch = flat_arch(voussoirs)
    contacts = find_contacts(arch, friction=2.0).contacts
    leaning = LoadCase.tilt(arch, (0.0, 1.0, 0.0), 1.0)
    assert check(Model(arch, contacts, leaning)).verdict is Verdict.STABLE


@pytest.mark.parametrize("friction", [0.3, 2.0, 1e4])
def test_a_single_block_between_two_piers_falls(friction):
    wedged = flat_arch(1)
    contacts = find_contacts(wedged, friction=friction).contacts
    assert check(Model(wedged, contacts)).verdict is Verdict.UNSTABLE


@pytest.mark.parametrize("friction", [0.5, 0.6, 0.7])
def test_that_nothing_balances_is_proved_where_the_multiplier_is_too_coarse(friction):
    shelf = models.shelf()
    contacts = find_contacts(shelf, friction=friction).contacts
    found = solve_rbe(Model(shelf, contacts), options=RBEOptions.feasibility())
    assert found.verdict is Verdict.UNSTABLE
    assert "no contact forces" in check(Model(shelf, contacts)).message


@pytest.mark.parametrize(
    ("friction", "axis", "angle"),
    [(0.44, (1.0, -1.0, 0.0), 6.0), (0.62, (1.0, 0.5, 0.0), 7.4), (0.7, (-1.0, 0.3, 0.0), 46.0)],
)
def test_that_nothing_balances_is_proved_where_most_blocks_stand_still(friction, axis, angle):
    shelf = models.shelf()
    contacts = find_contacts(shelf, friction=friction).contacts
    load = LoadCase.tilt(shelf, axis, angle)
    found = solve_rbe(Model(shelf, contacts, load), options=RBEOptions.feasibility())
    assert found.verdict is Verdict.UNSTABLE
    assert found.mechanism is not None
    violation, power = mechanism_defects(Model(shelf, contacts, load), found.mechanism)
    assert violation <= 1e-8
    assert power > 0.1
    assert "no contact forces" in check(Model(shelf, contacts, load)).message


@pytest.mark.parametrize(
    ("options", "wrong"),
    [
        (CheckOptions, {"samples": -1}),
        (CheckOptions, {"seed": -1}),
        (CRAOptions, {"tolerance": float("nan")}),
        (CRAOptions, {"slide_limit": -1.0}),
        (CRAOptions, {"slips": (1.0, -1.0)}),
        (PenaltyOptions, {"ground": 0.0}),
    ],
)
def test_options_out_of_range_are_refused(options, wrong):
    with pytest.raises(InputError):
        options(**wrong)


def test_contacts_of_a_larger_assembly_are_refused():
    with pytest.raises(InputError, match="does not have"):
        Model(models.tower(2), JOINTS)


@pytest.mark.parametrize("analyse", [check, solve_cra, solve_cra_penalty, solve_rbe])
def test_what_is_no_model_is_refused(analyse):
    with pytest.raises(InputError, match=r"given is Contacts.*give Model"):
        analyse(JOINTS)


def test_a_motion_that_the_joints_resist_is_no_first_motion():
    """A block that stands on a slope, said to slide down: no gap closes and gravity does work."""
    block = models.incline(10.0)
    problem = Problem.build(Model(block, find_contacts(block, friction=0.6).contacts, None))
    statics = problem.statics
    slide = statics.load.copy()
    slide[:, 3:] = 0.0
    normal = statics.frame[0, 0]
    slide[:, :3] -= (slide[:, :3] @ normal)[:, None] * normal
    claim = RestState(
        slide,
        np.zeros(statics.corner_count),
        np.zeros((statics.corner_count, 3)),
        np.zeros(statics.corner_count),
        slide,
        0.0,
        True,
        0,
    )
    assert first_motion(problem, claim) is None


def test_the_first_motion_of_a_block_that_slides_is_the_slide():
    block = models.incline(35.0)
    problem = Problem.build(Model(block, find_contacts(block, friction=0.6).contacts, None))
    system = problem.statics
    state = find_rest(system, uniform(problem.statics), RestOptions(ground=1e-7, tolerance=1e-7))
    motion = first_motion(problem, state)
    assert motion is not None
    assert motion[-1, 2] < 0.0


def test_a_quick_screening_finds_that_a_thin_lune_rests_although_it_leans_on_the_ground():
    """The least thickness of a lune of 60 voussoirs came out 5 % too large."""
    model = models.lune(0.0435, rings=60)
    contacts = find_contacts(model, friction=1.0).contacts
    wall = np.isin(contacts.block_a, (1, 2)) | np.isin(contacts.block_b, (1, 2))
    contacts = contacts.with_friction(np.where(wall, 0.0, 1.0))
    assert try_rest(Model(model, contacts), screening=QUICK).verdict is Verdict.STABLE


def test_no_forces_are_told_of_what_falls_but_those_beside_its_props():
    falling = Model.of(models.incline(35.0), friction=0.2)
    found = check(falling)
    assert found.falls
    assert found.force is None
    assert found.residuals is None
    assert found.force_with_props is not None
    rest = check_forces(falling, found.force_with_props, prop=found.prop)
    assert rest.equilibrium < 1e-5
    with pytest.raises(InputError, match="no forces"):
        found.joints()


def test_props_of_free_fall_are_the_loads_reversed():
    found = check(Model.of(models.h_model(), friction=0.3))
    (block,) = found.falling
    np.testing.assert_allclose(found.prop[block], -found.load.wrench[block], atol=1e-9)
    assert not np.signbit(found.prop[~np.isin(np.arange(3), block)]).any()


@pytest.mark.parametrize("analysis", [check, solve_rbe, solve_cra, solve_cra_penalty])
def test_every_analysis_takes_the_same_keywords(analysis):
    told = []
    found = analysis(
        Model(ARCH, JOINTS),
        progress=lambda *step: told.append(step),
        stop=lambda: False,
        time_limit_s=60.0,
    )
    assert found.stopped == ""
    assert told
    assert all(0 <= done <= total for _, done, total in told)
    assert analysis(Model(ARCH, JOINTS), time_limit_s=0.0).stopped == "the time was up"
    for limit in (-1.0, float("nan")):
        with pytest.raises(InputError, match="time"):
            analysis(Model(ARCH, JOINTS), time_limit_s=limit)


def test_a_last_state_that_proves_nothing_is_followed_further():
    roughly = replace(PATIENT.numerics, end=RestOptions(ground=1e-5, tolerance=1e-7))
    problem = Problem.build(Model(ARCH, JOINTS))
    state = find_rest(problem.statics, uniform(problem.statics), roughly)
    assert state.ended
    assert problem.ground_share(state.ground).max() > 1e-6
    found = try_rest(problem, screening=replace(PATIENT, numerics=roughly))
    assert found.stable
    assert found.residuals.largest < 1e-8
