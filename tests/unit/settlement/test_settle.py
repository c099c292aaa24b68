"""Blocks followed by finite steps to rest or into a fall."""

import numpy as np
import pytest

import drystone
from benchmarks.leaning import card_house
from drystone import Assembly, InputError, LoadCase, Model
from drystone.geometry.frames import rotation_about
from drystone.mechanics import follow
from drystone.mechanics.bodies import gyration
from drystone.models import arch, box, concave, h_model, incline, tower, wedge
from drystone.models.simple import prism, welded
from drystone.settlement import Outcome, Settlement, SettlementOptions, settle
from drystone.settlement.settling import settle_for_verdict

MOVING = SettlementOptions(carrier="moving", fall=0.1)  # type: ignore[arg-type]
X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def tilted(
    assembly: Assembly,
    axis: tuple[float, float, float],
    angle: float,
    friction: float = 0.84,
    options: SettlementOptions = MOVING,
) -> Settlement:
    load = LoadCase.tilt(assembly, axis, angle)
    return settle(Model.of(assembly, friction=friction, load=load), options=options)


@pytest.mark.parametrize(
    ("assembly", "axis", "stands", "falls"),
    [
        (wedge("a"), Y, 99.5, 100.6),
        (wedge("b"), X, 57.0, 60.0),
        (wedge("c"), X, 43.5, 45.0),
        (concave("short"), Y, 38.5, 44.0),
    ],
    ids=["a about y", "b about x", "c about x", "concave"],
)
def test_published_limits_lie_between_what_rests_and_what_falls(
    assembly: Assembly, axis: tuple[float, float, float], stands: float, falls: float
) -> None:
    # Kao 2023, 3DEC: 100, 58.7, 44.1 and 40 degrees
    assert tilted(assembly, axis, stands).outcome is Outcome.RESTS
    assert tilted(assembly, axis, falls).outcome is Outcome.FALLS


@pytest.mark.parametrize(("angle", "outcome"), [(30.9, Outcome.RESTS), (31.1, Outcome.FALLS)])
def test_a_block_slides_where_the_slope_is_the_friction(angle: float, outcome: Outcome) -> None:
    block = incline(0.0)
    assert tilted(block, Y, angle, float(np.tan(np.deg2rad(31.0)))).outcome is outcome


@pytest.mark.parametrize(("angle", "outcome"), [(18.3, Outcome.RESTS), (18.6, Outcome.FALLS)])
def test_a_tower_topples_where_its_weight_leaves_the_foot(angle: float, outcome: Outcome) -> None:
    # three free cubes: atan(1/3) = 18.43 degrees
    assert tilted(tower(4), X, angle).outcome is outcome


def test_what_nothing_presses_falls_and_what_tapers_wedges_itself() -> None:
    assert settle(Model.of(h_model(), friction=0.9), options=MOVING).outcome is Outcome.FALLS
    lean = float(np.tan(np.deg2rad(0.05)))
    y = (-0.5, 0.5)
    wall = [(0.5, 0.0), (1.5, 0.0), (1.5 + lean, 1.0), (0.5 + lean, 1.0)]
    plug = [(-0.5, 0.0), (0.5, 0.0), (0.5 + lean, 1.0), (-0.5 - lean, 1.0)]
    blocks = (
        prism([(-x, z) for x, z in wall], y, "left"),
        prism(wall, y, "right"),
        prism(plug, y, "plug"),
    )
    taper = Assembly(blocks, np.array([True, True, False]))
    for friction in (0.0, 0.6):
        settled = settle(Model.of(taper, friction=friction), options=MOVING)
        assert settled.outcome is Outcome.RESTS
    # N = W / (2 sin a) on either face
    weight = taper.mass[2] * 9.81
    settled = settle(Model.of(taper, friction=0.0), options=MOVING)
    normal = settled.path.force[:, 0].sum()
    assert normal == pytest.approx(weight / np.sin(np.deg2rad(0.05)), rel=1e-2)


def test_many_plugs_that_taper_wedge_themselves() -> None:
    # more blocks than full matrices are used for; springs are too soft as for one plug
    lean, y = float(np.tan(np.deg2rad(0.05))), (-0.5, 0.5)
    blocks = []
    for i in range(26):
        x = 4.0 * i
        wall = [(0.5, 0.0), (1.5, 0.0), (1.5 + lean, 1.0), (0.5 + lean, 1.0)]
        plug = [(x - 0.5, 0.0), (x + 0.5, 0.0), (x + 0.5 + lean, 1.0), (x - 0.5 - lean, 1.0)]
        blocks.append(prism([(x - a, z) for a, z in wall], y, f"left-{i}"))
        blocks.append(prism([(x + a, z) for a, z in wall], y, f"right-{i}"))
        blocks.append(prism(plug, y, f"plug-{i}"))
    row = Assembly(tuple(blocks), np.arange(len(blocks)) % 3 < 2)
    settled = settle(Model.of(row, friction=0.0), options=MOVING)
    assert settled.outcome is Outcome.RESTS
    assert settled.path.overlap < MOVING.overlap
    normal = settled.path.force[:, 0].sum() / 26
    assert normal == pytest.approx(row.mass[2] * 9.81 / np.sin(np.deg2rad(0.05)), rel=1e-2)


def test_a_plug_rests_beside_blocks_that_it_does_not_touch_as_it_does_alone() -> None:
    # statics: N = W / (2 (sin a + mu cos a)); the springs of a plug alone are made stiffer
    lean, y = float(np.tan(np.deg2rad(0.01))), (-0.5, 0.5)
    wall = [(0.5, 0.0), (1.5, 0.0), (1.5 + lean, 1.0), (0.5 + lean, 1.0)]
    sides = prism([(-x, z) for x, z in wall], y, "left"), prism(wall, y, "right")
    plug = prism([(-0.5, 0.0), (0.5, 0.0), (0.5 + lean, 1.0), (-0.5 - lean, 1.0)], y, "plug")
    slab = box((9.0, 1.0, 0.5), (4.0, -0.5, -0.5), name="slab")
    away = [
        box((1.0, 1.0, 0.5), (5.0 + 2.0 * (i % 4), -0.5, 0.5 * (i // 4)), name=f"box-{i}")
        for i in range(24)
    ]
    fixed = np.arange(28) < 3
    model = Model.of(Assembly((*sides, slab, plug, *away), fixed), friction=0.1)
    alone = settle(model.subset([0, 1, 3]), options=MOVING)
    beside = settle_for_verdict(model, options=MOVING)
    assert alone.outcome is beside.outcome is Outcome.RESTS
    assert beside.path.displacement[3] == pytest.approx(alone.displacement[2])
    assert beside.path.residuals is not None
    assert beside.path.residuals.largest < 1e-9


@pytest.mark.parametrize(("angle", "outcome"), [(8.0, Outcome.RESTS), (8.4, Outcome.FALLS)])
def test_for_the_verdict_many_blocks_are_followed_until_one_leaves(
    angle: float, outcome: Outcome
) -> None:
    # 36 voussoirs: statics balances them up to 8.22 degrees
    whole, friction = arch(0.15, 37), float(np.tan(np.deg2rad(43.0)))
    load = LoadCase.tilt(whole, Y, angle)
    model = Model.of(whole, friction=friction, load=load)
    found = settle_for_verdict(model, options=MOVING)
    assert found.outcome is outcome
    within = MOVING.rest_within
    if outcome is Outcome.RESTS:
        assert found.path.residuals is not None
        assert found.path.residuals.largest < 1e-8
        assert found.travel == pytest.approx(settle(model, options=MOVING).travel, rel=1e-9)
    else:
        assert within < found.travel < 2.0 * within


def test_the_ends_of_joints_decide_only_where_the_faces_end_flush() -> None:
    both = SettlementOptions(fall=0.1)
    flush = tilted(wedge("c"), X, 40.0, options=both)
    assert flush.outcome is Outcome.ENDS_DECIDE
    assert "the ends of the joints decide" in flush.message
    assert [path.outcome for path in flush.paths] == [Outcome.RESTS, Outcome.FALLS]
    longer = tilted(wedge("c", longer=0.2), X, 40.0, options=both)
    assert longer.outcome is Outcome.RESTS


def test_flush_ends_say_by_how_much_the_other_face_has_to_be_longer() -> None:
    flush = tilted(wedge("b"), X, 50.0, options=SettlementOptions(fall=0.1))
    assert (
        "the faces of the resting block go on more than 3.5 mm beyond those ends" in flush.message
    )
    exact = SettlementOptions(carrier="exact", fall=0.1)  # type: ignore[arg-type]
    assert tilted(wedge("b"), X, 50.0, options=exact).outcome is Outcome.FALLS
    for share, outcome in ((0.97, Outcome.FALLS), (1.03, Outcome.RESTS)):
        groove = wedge("b", longer=share * flush.path.beyond)
        assert tilted(groove, X, 50.0, options=exact).outcome is outcome


def test_where_faces_hardly_slide_the_other_carrier_would_say_the_same() -> None:
    for tilt, outcome in ((10.0, Outcome.RESTS), (30.0, Outcome.FALLS)):
        one = tilted(tower(3), Y, tilt, options=SettlementOptions(fall=0.1))
        assert (one.outcome, len(one.paths)) == (outcome, 1)
        resting = SettlementOptions(carrier="resting", fall=0.1)  # type: ignore[arg-type]
        other = tilted(tower(3), Y, tilt, options=resting)
        assert other.outcome is outcome
        assert other.travel == pytest.approx(one.travel, rel=0.01)


def test_forces_at_rest_are_proven_on_the_moved_blocks() -> None:
    settled = tilted(wedge("b"), X, 50.0)
    path = settled.path
    assert path.residuals is not None
    assert path.residuals.largest < 1e-8
    assert 1e-3 < settled.travel < 0.02
    moved = path.moved_model()
    shift = moved.assembly.centroid[2] - settled.assembly.centroid[2]
    assert shift == pytest.approx(path.displacement[2, :3])
    world = np.einsum("ki,kij->kj", path.force, path.axes)
    assert world.sum(axis=0) == pytest.approx(-settled.model.load.wrench[2, :3], rel=1e-7, abs=1e-6)
    assert (path.gap[path.force[:, 0] > 0.0] < 0.0).all()
    np.testing.assert_array_equal(path.positions[0], np.zeros((3, 6)))
    np.testing.assert_array_equal(path.positions[-1], path.displacement)


def test_where_a_wedge_rests_it_stands_as_a_model_of_its_own() -> None:
    # its joints end where its edges are: were they farther out, these would belong to neither block
    settled = tilted(wedge("c"), X, 40.0)
    assert drystone.check(settled.path.moved_model()).verdict is drystone.Verdict.STABLE


def test_the_way_depends_on_no_unit_place_density_direction_or_numbering() -> None:
    turn = rotation_about((1.0, 2.0, 3.0), 77.0)
    plain = wedge("b")
    reference = tilted(plain, X, 55.0).travel
    copies = {
        "larger": plain.transformed(1e3 * np.eye(3)),
        "elsewhere": plain.transformed(translation=(300.0, -200.0, 100.0)),
        "denser": plain.with_density(1.0),
        "renumbered": Assembly(plain.blocks[::-1], plain.fixed[::-1]),
    }
    for name, copy in copies.items():
        assert tilted(copy, X, 55.0).travel == pytest.approx(reference, rel=1e-6), name
    load = LoadCase.tilt(plain, X, 55.0).wrench[2, :3] / plain.mass[2]
    turned = plain.transformed(turn)
    model = Model.of(turned, friction=0.84, load=turn @ load)
    assert settle(model, options=MOVING).travel == pytest.approx(reference, rel=1e-6)


@pytest.mark.parametrize(
    "changed",
    [{"overlap": 1e-7}, {"pace": 2.0}, {"pace": 0.5}],
    ids=["stiffer", "longer steps", "shorter steps"],
)
def test_stiffness_and_steps_change_no_answer_half_a_degree_from_the_limit(
    changed: dict[str, float],
) -> None:
    options = SettlementOptions(carrier="moving", fall=0.1, **changed)  # type: ignore[arg-type]
    assert tilted(wedge("c"), X, 43.7, options=options).outcome is Outcome.RESTS
    assert tilted(wedge("c"), X, 44.7, options=options).outcome is Outcome.FALLS


@pytest.mark.parametrize("pace", [1.0, 0.3])
def test_no_long_step_before_rest_lets_corners_go_together(pace: float) -> None:
    # with one it falls at 49.5 and 49.6, with shorter steps at 49.65 and not at 49.7
    options = SettlementOptions(carrier="moving", fall=0.1, pace=pace)  # type: ignore[arg-type]
    axis = (np.sqrt(3.0), 1.0, 0.0)
    for tilt, outcome in ((49.5, Outcome.RESTS), (49.65, Outcome.RESTS), (49.8, Outcome.FALLS)):
        assert tilted(wedge("d"), axis, tilt, options=options).outcome is outcome


def test_many_blocks_are_followed_like_few() -> None:
    slender = tower(30, 0.5)
    slope = np.rad2deg(np.arctan(1.0 / 29.0))
    assert tilted(slender, X, 0.95 * slope).outcome is Outcome.RESTS
    assert tilted(slender, X, 1.05 * slope).outcome is Outcome.FALLS


def test_a_fall_tells_who_moves_and_how_it_ended_early_is_told() -> None:
    fall = tilted(tower(3), X, 40.0)
    assert "it falls: 'block-2'" in fall.message
    assert fall.path.moving[-1] == 2
    late = settle(tower(3), time_limit_s=0.0)
    assert late.outcome is Outcome.UNKNOWN
    assert late.stopped == "the time was up"
    stopped = settle(tower(3), stop=lambda: True)
    assert stopped.message.startswith("it was interrupted")
    told: list[tuple[str, int, int]] = []
    settle(tower(3), progress=lambda *one: told.append(one))
    assert all(0 <= done <= total for _, done, total in told)
    assert told[-1][1] == told[-1][2]


def test_what_plainly_stands_rests_after_few_increments() -> None:
    found = settle(Model.of(arch(0.15, 8), friction=0.9))
    assert found.rests
    assert found.path.steps <= 25  # begun with ten times the drag it takes 41


def test_a_run_that_takes_too_many_newton_steps_has_no_end(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = tilted(wedge("b"), X, 50.0)
    assert whole.rests
    monkeypatch.setattr(follow, "NEWTON_EACH", 0.5 * whole.path.iterations / MOVING.step_limit)
    half = tilted(wedge("b"), X, 50.0)
    assert half.outcome is Outcome.UNKNOWN
    assert half.path.iterations < whole.path.iterations
    assert half.path.steps < whole.path.steps


def test_there_may_be_nothing_to_follow() -> None:
    with pytest.raises(InputError, match="every block is fixed"):
        settle(tower(2).with_fixed([0, 1]))
    assert settle(Model.of(tower(2), load=0.0)).rests
    apart = Assembly((box((1, 1, 1), name="a"), box((1, 1, 1), (0, 0, 5), "b"))).with_fixed(["a"])
    assert settle(apart, options=MOVING).outcome is Outcome.FALLS
    with pytest.raises(TypeError, match="neither true nor false"):
        bool(settle(tower(2)))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"fall": -1.0}, "fall is -1"),
        ({"rest_within": 0.5}, "rest_within is 0.5, above fall"),
        ({"overlap": 0.5}, "overlap is 0.5"),
        ({"pace": float("inf")}, "pace is inf"),
        ({"carrier": "upper"}, "carrier is 'upper'; give one of 'moving', 'resting'"),
        ({"step_limit": 0}, "step_limit is 0"),
    ],
)
def test_options_that_cannot_be_meant_are_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        SettlementOptions(**given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ({"block-1": (0.0, 0.0, 1.0)}, "'block-1' is not fixed"),
        ({"block-0": (0.0, 1.0)}, "does not have 3 or 6 numbers"),
        ({"other": (0.0, 0.0, 1.0)}, "no block is called"),
    ],
)
def test_motions_that_cannot_be_used_are_refused(
    motion: dict[str, tuple[float, ...]], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        drystone.settle(tower(2), motion)


def test_a_block_slides_over_the_edge_of_a_table_and_tips_where_its_weight_leaves_it() -> None:
    # the table ends 0.1 beyond the block: its weight passes the edge after 0.1 + 0.5 (1 - tan 17.5)
    table, block = box((4, 3, 1), (-2.9, -1, -1), "table"), box((1, 1, 1), name="block")
    on_the_table = Assembly((table, block), np.array([True, False]))
    far = SettlementOptions(carrier="moving", fall=0.6)  # type: ignore[arg-type]
    for one in (on_the_table, on_the_table.transformed(rotation_about((0.0, 0.0, 1.0), 180.0))):
        way_down = Y if one is on_the_table else (0.0, -1.0, 0.0)
        settled = tilted(one, way_down, 17.5, friction=0.3, options=far)
        assert settled.outcome is Outcome.FALLS
        motion = settled.path.positions[:, 1]
        gone, turned = np.abs(motion[:, 0]), np.linalg.norm(motion[:, 3:], axis=1)
        edge = 0.1 + 0.5 * (1.0 - np.tan(np.deg2rad(17.5)))
        assert turned[gone < edge - 0.01].max() < 1e-4
        assert turned[-1] > 0.01
        assert gone[turned > 1e-3].min() == pytest.approx(edge, abs=0.02)


def test_what_is_too_slow_to_be_followed_to_a_fall_is_given_up_early() -> None:
    ground = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), name="ground")
    cube = box((1.0, 1.0, 1.0), name="cube")
    pebble = box((1e-5, 1e-5, 1e-5), (1.5, 1.5, 0.0), name="pebble")
    assembly = Assembly((ground, cube, pebble), np.array([True, False, False]))
    model = Model.of(assembly, load=LoadCase.tilt(assembly, Y, 30.0))
    found = settle(model.with_friction([0.2, 0.9]), options=MOVING)  # the cube slides alone
    assert found.outcome is Outcome.UNKNOWN
    assert found.paths[0].steps == 1000


def test_a_block_whose_volume_is_lost_in_rounding_has_a_radius_of_gyration():
    far = 1e9 * np.array([1.0, -1.0, 1.0]) + [0.0, 0.0, 1.0]
    a, b, c = far + 4.914514780044556 * np.eye(3)
    inside = far + 1.6381716
    thin = [(a, b, c), (a, b, inside), (b, c, inside), (a, c, inside)]
    inertia, radius = gyration(Assembly((welded(thin, "thin"),), np.array([True])))
    assert 0.0 < radius[0] < 4.9
    assert (np.linalg.eigvalsh(inertia[0]) > 0.0).all()


def test_blocks_are_dragged_by_their_own_moments_of_inertia():
    turn = rotation_about((1.0, 2.0, -0.5), 40.0)
    bar = box((4.0, 0.5, 0.25), name="bar").transformed(turn, (3.0, -2.0, 1.0))
    inertia, radius = gyration(Assembly((bar,), np.array([False])))
    square = np.array([4.0, 0.5, 0.25]) ** 2
    moments = (square.sum() - square) / 12.0  # closed form, by mass
    assert radius[0] ** 2 == pytest.approx(moments.mean())
    assert radius[0] ** 2 * inertia[0] == pytest.approx(turn @ np.diag(moments) @ turn.T)


def test_what_drifts_without_resistance_is_followed_to_the_last_step():
    """Cards of three storeys just below their least friction: the drag comes near zero."""
    model = Model.of(card_house(3, 70.0, apart=0.0), friction=0.29452442423502606)
    options = SettlementOptions(carrier="moving", step_limit=500)  # type: ignore[arg-type]
    assert settle(model, options=options).outcome is Outcome.UNKNOWN
