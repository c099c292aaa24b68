"""Friction of faces that turn, against closed forms for a uniform pressure.

Each limit is held by the utilisation, by the word robust below it and sensitive above it, and by
what the message says.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from drystone import Assembly, Block, CheckOptions, LoadCase, Model, Result, check, limits
from drystone.models import box, dome, prism, tower, wall
from drystone.results import Sensitivity, Verdict

FRICTION = 0.5
SQUARE = (np.sqrt(2.0) + np.arcsinh(1.0)) / 6.0
"""Mean distance of the points of a unit square from its centre."""


def regular(count: int, radius: float) -> np.ndarray:
    angle = 2.0 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def rectangle(x: tuple[float, float], z: tuple[float, float]) -> list[tuple[float, float]]:
    return [(x[0], z[0]), (x[1], z[0]), (x[1], z[1]), (x[0], z[1])]


def standing(floor: list[Block], above: list[Block]) -> Model:
    """Blocks on supports whose faces are in the plane y = 0, with gravity along -y."""
    assembly = Assembly((*floor, *above), np.arange(len(floor) + len(above)) < len(floor))
    down = LoadCase.gravity(assembly, direction=(0.0, -1.0, 0.0))
    return Model.of(assembly, friction=FRICTION, load=down)


def plate(section: object, name: str = "plate") -> Block:
    return prism(np.asarray(section), (0.0, 0.2), name)


def ground(section: object, name: str = "ground") -> Block:
    return prism(np.asarray(section), (-0.2, 0.0), name)


WIDE = rectangle((-9.0, 9.0), (-9.0, 9.0))


def loaded(model: Model, wrench: object, block: int = -1) -> Model:
    """A model with one more wrench (6,) on a block."""
    total = np.array(model.load.wrench)
    total[block] += np.asarray(wrench)
    return model.with_load(LoadCase(total))


def weight(model: Model) -> float:
    return float(-model.load.wrench[-1, 1])


def asked(model: Model) -> Result:
    return check(model, options=CheckOptions.robust())


def holds_up_to(model: Model, wrench: object, limit: float, within: float = 0.01) -> None:
    """A multiple of a wrench on the last block is carried by pressure spread over the faces."""
    at_limit = asked(loaded(model, limit * np.asarray(wrench)))
    assert at_limit.utilisation.max() == pytest.approx(1.0, abs=within)
    below = asked(loaded(model, (1.0 - within - 0.005) * limit * np.asarray(wrench)))
    above = asked(loaded(model, (1.0 + within + 0.005) * limit * np.asarray(wrench)))
    assert below.stable
    assert not below.sensitive
    assert above.stable
    assert above.sensitive
    assert above.sensitive_to == (Sensitivity.PRESSURE,)
    assert "with pressure spread over the faces it" in above.message


TORQUE = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])


def test_a_square_turns_on_uniform_pressure() -> None:
    side = 1.3
    model = standing([ground(WIDE)], [plate(rectangle((0.0, side), (0.0, side)))])
    limit = FRICTION * weight(model) * side * SQUARE
    holds_up_to(model, TORQUE, limit)
    # its corners carry up to mu W b / sqrt 2
    corners = FRICTION * weight(model) * side / np.sqrt(2.0)
    assert check(loaded(model, 0.999 * corners * TORQUE)).stable
    assert check(loaded(model, 1.001 * corners * TORQUE)).falls


def test_a_disc_of_24_sides() -> None:
    radius, half = 0.7, np.pi / 24.0
    model = standing([ground(WIDE)], [plate(regular(24, radius))])
    tangent, apothem = np.tan(half), radius * np.cos(half)
    arm = apothem / 3.0 * (1.0 / np.cos(half) + np.arcsinh(tangent) / tangent)
    assert arm == pytest.approx(2.0 / 3.0 * radius, rel=0.01)
    holds_up_to(model, TORQUE, FRICTION * weight(model) * arm)


def test_a_block_turns_on_two_ridges() -> None:
    """Pressure along each line resists with half of what its ends would."""
    ridges = [
        prism([(x, 0.0), (x - 0.2, -0.2), (x + 0.2, -0.2)], (0.0, 1.0), f"ridge {x}")
        for x in (0.45, 0.55)
    ]
    block = box((1.0, 1.2, 0.2), (0.0, -0.1, 0.0), "block")
    model = Model.of(Assembly((*ridges, block)).with_fixed([0, 1]), friction=FRICTION)
    arm = np.hypot(np.linspace(-0.5, 0.5, 100_001), 0.05).mean()
    limit = FRICTION * float(-model.load.wrench[-1, 2] * arm)
    turn = np.array([0.0, 0.0, 0.0, 0.0, 0.0, limit])
    robust, sensitive = (asked(loaded(model, share * turn)) for share in (0.98, 1.03))
    assert robust.stable
    assert not robust.sensitive
    assert sensitive.stable
    assert sensitive.sensitive_to == (Sensitivity.PRESSURE,)
    assert sensitive.utilisation.max() > 1.0


def test_a_ring() -> None:
    outer, inner = regular(24, 1.0), regular(24, 0.6)
    turn = [*range(24), 0]
    parts = [
        ground([inner[i], inner[j], outer[j], outer[i]], f"ground {i}") for i, j in pairwise(turn)
    ]
    model = standing(parts, [plate(regular(24, 1.2))])
    arm = 2.0 / 3.0 * (1.0 - 0.6**3) / (1.0 - 0.6**2) * 0.9943  # of 24 sides
    limit = FRICTION * weight(model) * arm
    # each face by itself resists force and torque in another proportion than the whole
    below = asked(loaded(model, 0.97 * limit * TORQUE))
    assert below.utilisation.max() > 1.0
    assert Sensitivity.PRESSURE not in below.sensitive_to
    above = asked(loaded(model, 1.01 * limit * TORQUE))
    assert Sensitivity.PRESSURE in above.sensitive_to


def test_two_feet() -> None:
    feet = [ground(rectangle((x, x + 0.2), (0.0, 0.2)), f"foot {x}") for x in (0.0, 0.8)]
    model = standing(feet, [plate(rectangle((0.0, 1.0), (0.0, 0.2)))])
    x, z = np.meshgrid(np.linspace(0.3005, 0.4995, 200), np.linspace(-0.0995, 0.0995, 200))
    arm = float(np.hypot(x, z).mean())
    below = asked(loaded(model, 0.85 * FRICTION * weight(model) * arm * TORQUE))
    assert below.stable
    assert not below.sensitive
    above = asked(loaded(model, 1.005 * FRICTION * weight(model) * arm * TORQUE))
    assert Sensitivity.PRESSURE in above.sensitive_to


def test_a_bar_that_is_pulled_across_at_its_end() -> None:
    long = 2.0
    model = standing([ground(WIDE)], [plate(rectangle((0.0, long), (0.0, 0.02)))])
    pull = np.array([0.0, 0.0, 1.0, -0.1, -0.5 * long, 0.0])  # at the height of the ground
    limit = (np.sqrt(2.0) - 1.0) * FRICTION * weight(model)
    holds_up_to(model, pull, limit)
    corners = 0.5 * FRICTION * weight(model)
    assert check(loaded(model, 0.999 * corners * pull)).stable
    assert check(loaded(model, 1.01 * corners * pull)).falls


def test_a_lever_on_a_slope() -> None:
    """A bar across a slope, pulled down at its end: half of the friction is used by its weight."""
    long = 2.0
    flat = standing([ground(WIDE)], [plate(rectangle((0.0, long), (0.0, 0.02)))])
    slope = np.arctan(0.5 * FRICTION)
    down = (0.0, -np.cos(slope), np.sin(slope))
    model = flat.with_load(LoadCase.gravity(flat.assembly, direction=down))
    along, half = model.load.wrench[-1, 2], 0.5 * long
    per_length = FRICTION * weight(model) / long
    # pole at p from the middle: 2 q p = V + F, and q (h^2 - p^2) = F h
    pole = np.roots([per_length, 2.0 * per_length * half, -(per_length * half**2 + along * half)])
    limit = 2.0 * per_length * float(pole.max()) - along
    assert 0.0 < limit < FRICTION * weight(model) - along
    # the tilt moves the pressure, by half of the height of the bar, beyond its width
    low = loaded(model, [0.0, 0.0, 0.0, -0.1 * along, 0.0, 0.0])
    holds_up_to(low, [0.0, 0.0, 1.0, -0.1, -half, 0.0], limit, within=0.05)


def test_an_eccentric_load_with_a_torque() -> None:
    """A linear pressure from zero to twice the mean, about the centre of pressure."""
    model = standing([ground(WIDE)], [plate(rectangle((0.0, 1.0), (0.0, 1.0)))])
    at = (np.arange(400) + 0.5) / 400.0
    x, z = np.meshgrid(at, at, indexing="ij")
    arm = float((2.0 * x * np.hypot(x - 2.0 / 3.0, z - 0.5)).mean())
    # the weight acts a sixth of the side off the middle
    tipped = loaded(model, [0.0, 0.0, 0.0, 0.0, 0.0, -weight(model) / 6.0])
    holds_up_to(tipped, TORQUE, FRICTION * weight(model) * arm)


def arm_in_a_corner(leg: float) -> float:
    """Mean distance from the centre of pressure, a quarter of the leg from both edges.

    The pressure falls from a right angle to zero at the other side of a triangle.
    """
    at = (np.arange(400) + 0.5) / 400.0 * leg
    x, z = np.meshgrid(at, at, indexing="ij")
    pressure = np.maximum(leg - x - z, 0.0)
    return float((pressure * np.hypot(x - 0.25 * leg, z - 0.25 * leg)).sum() / pressure.sum())


def arm_along_an_edge(depth: float) -> float:
    """Mean distance from the centre of pressure, a third of the depth of a strip from its edge."""
    at = (np.arange(400) + 0.5) / 400.0
    x, z = np.meshgrid(depth * at, at, indexing="ij")
    pressure = depth - x
    return float((pressure * np.hypot(x - depth / 3.0, z - 0.5)).sum() / pressure.sum())


@pytest.mark.parametrize("near", [0.15, 0.08, 0.03, 0.01])
def test_a_face_that_is_pressed_near_its_rim_resists_what_its_pressed_part_does(
    near: float,
) -> None:
    model = standing([ground(WIDE)], [plate(rectangle((0.0, 1.0), (0.0, 1.0)))])
    off = weight(model) * (0.5 - near)
    corner = loaded(model, [0.0, 0.0, 0.0, -off, 0.0, off])
    limit = FRICTION * weight(model) * arm_in_a_corner(4.0 * near)
    used = check(loaded(corner, limit * TORQUE)).utilisation.max()
    assert used == pytest.approx(1.0, abs=0.02)
    edge = loaded(model, [0.0, 0.0, 0.0, 0.0, 0.0, off])
    limit = FRICTION * weight(model) * arm_along_an_edge(3.0 * near)
    used = check(loaded(edge, limit * TORQUE)).utilisation.max()
    assert used == pytest.approx(1.0, abs=0.02)


def test_a_face_that_is_pressed_near_its_corner_needs_its_corners() -> None:
    model = standing([ground(WIDE)], [plate(rectangle((0.0, 1.0), (0.0, 1.0)))])
    off = 0.48 * weight(model)
    corner = loaded(model, [0.0, 0.0, 0.0, -off, 0.0, off])
    limit = FRICTION * weight(model) * arm_in_a_corner(0.08)
    assert not asked(loaded(corner, 0.95 * limit * TORQUE)).sensitive
    above = asked(loaded(corner, 1.05 * limit * TORQUE))
    assert above.sensitive_to == (Sensitivity.PRESSURE,)


def test_a_concave_face_is_pressed_in_part() -> None:
    legs = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.2), (0.2, 0.2), (0.2, 1.0), (0.0, 1.0)]
    model = standing([ground(WIDE)], [plate(legs)])
    x, _, z = model.assembly.centroid[-1]
    # the last 0.3 m of a leg, since the pressure falls from its end to zero
    end = loaded(model, weight(model) * np.array([0.0, 0.0, 0.0, 0.1 - z, 0.0, x - 0.9]))
    at = (np.arange(400) + 0.5) / 400.0
    away, across = np.meshgrid(0.3 * at, 0.2 * at, indexing="ij")
    arm = ((0.3 - away) * np.hypot(away - 0.1, across - 0.1)).sum() / (0.3 - away).sum()
    used = check(loaded(end, FRICTION * weight(model) * arm * TORQUE)).utilisation.max()
    assert used == pytest.approx(1.0, abs=0.02)


def test_points_of_thin_parts_press_by_their_areas() -> None:
    """The end of a leg of an L is pressed; another program finds its limit with 20,000 points."""
    legs = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.0521), (0.1076, 0.0521), (0.1076, 0.6211), (0, 0.6211)]
    model = standing([ground(WIDE)], [plate(legs)]).with_friction(0.4)
    x, y, z = model.assembly.centroid[-1]
    at = np.array([0.01853, 0.0, 0.61187])
    down, limit = 24539.0, 1.0118
    force = limit * np.array([818.0, 0.0, -900.932])
    wrench = np.array([*force, *np.cross(at - [x, y, z], force)])
    wrench[4] -= limit * 135.02
    pressed = np.array([0.0, -down, 0.0])
    held = loaded(model, [0.0, weight(model) - down, 0.0, *np.cross(at - [x, y, z], pressed)])
    for share, sensitive in ((0.94, False), (1.1, True)):
        found = asked(loaded(held, share * wrench))
        assert found.utilisation.max() == pytest.approx(share, abs=0.02)
        assert found.sensitive == sensitive


THIN = (0, 0), (1, 0), (1, 63), (0.5315, 63), (0.5315, 1e3), (0.4685, 1e3), (0.4685, 63), (0, 63)
"""A T of legs of 63 mm [m, mm]."""


@pytest.mark.parametrize(
    ("section", "friction", "centre", "pull", "torque", "limit"),
    [
        ((0.4663, 1.6753), 0.88, (0.39632, 1.42403), (0.36038, 0.93281), 0.70104, 771.46),
        ((1.9745, 0.4225), 0.60, (0.29617, 0.35909), (0.0, 0.0), 1.0, 456.39),
        (None, 0.41, (0.5, 0.273385), (0.99985, 0.01726), 0.44158, 127.94),
    ],
    ids=["pulled", "turned", "T"],
)
def test_a_pull_with_a_torque(
    section: tuple[float, float] | None,
    friction: float,
    centre: tuple[float, float],
    pull: tuple[float, float],
    torque: float,
    limit: float,
) -> None:
    """Another program finds the limits [N, N m] with 1,100 points a side, by searching slips."""
    thin = np.array(THIN) * [1.0, 1e-3]
    sides = thin if section is None else rectangle((0.0, section[0]), (0.0, section[1]))
    model = standing([ground(WIDE)], [plate(sides)]).with_friction(friction)
    arm = np.array([centre[0], 0.0, centre[1]]) - model.assembly.centroid[-1]
    at_centre = np.array([0.0, -weight(model), 0.0])
    pressed = loaded(model, [0.0, 0.0, 0.0, *np.cross(arm, at_centre)])
    force = np.array([pull[0], 0.0, pull[1]])
    holds_up_to(pressed, [*force, *(np.cross(arm, force) + torque * np.eye(3)[1])], limit)


def test_a_stack_that_is_twisted_in_the_middle() -> None:
    model = Model.of(tower(4), friction=FRICTION)
    block = float(-model.load.wrench[-1, 2])
    # the joint under the block that is twisted carries all, those above nothing
    limit = FRICTION * 2.0 * block * SQUARE
    turned = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    below = asked(loaded(model, 0.97 * limit * turned, block=2))
    above = asked(loaded(model, 1.03 * limit * turned, block=2))
    assert below.stable
    assert not below.sensitive
    assert above.sensitive_to == (Sensitivity.PRESSURE,)
    assert above.utilisation.argmax() == 1


def test_without_torsion_no_points_are_spread() -> None:
    result = asked(Model.of(tower(4), friction=FRICTION))
    assert result.samples.tried == 5
    assert "spread" not in result.message


def test_what_needs_its_corners_says_so_without_being_asked_for_more() -> None:
    model = standing([ground(WIDE)], [plate(rectangle((0.0, 1.0), (0.0, 1.0)))])
    result = check(loaded(model, 1.3 * FRICTION * weight(model) * SQUARE * TORQUE))
    assert result.stable
    assert result.utilisation.max() == pytest.approx(1.3, abs=0.03)
    for found in (result, asked(result.model)):
        assert found.sensitive_to == (Sensitivity.PRESSURE,)
        assert "with pressure spread over the faces it falls" in found.message
        assert found.title == "Stands on the corners of its joints"
        said = [one.text for one in found.sentences()]
        assert any("the joint of 'ground' and 'plate' needs its corners" in one for one in said)
    quick = check(result.model, options=CheckOptions(settle=False))
    assert not quick.sensitive
    assert any("may need its corners: with these" in one.text for one in quick.sentences())


def test_a_plate_on_two_feet_may_need_its_corners_until_other_forces_were_tried() -> None:
    feet = [ground(rectangle((x, x + 0.2), (0.0, 0.2)), f"foot at {x}") for x in (0.0, 0.4)]
    held = standing(feet, [plate(rectangle((0.0, 0.6), (0.0, 0.2)))])
    arm = 0.2035  # mean distance from the middle, of both feet
    model = loaded(held, 0.9 * FRICTION * weight(held) * arm * TORQUE)
    quick = check(model, options=CheckOptions(settle=False))
    said = [one.text for one in quick.sentences()]
    assert any("may need its corners: with these forces it turns with 10" in one for one in said)
    for found in (check(model), asked(model)):
        assert not found.sensitive
        assert not any("its corners" in one.text for one in found.sentences())
    assert check(model).message == "stands"


def test_no_joint_is_said_to_need_its_corners_where_spread_pressure_was_tried_and_holds() -> None:
    blocks = dome(slices=8, rings=4)
    load = LoadCase.tilt(blocks, (0.0, 1.0, 0.0), 20.0)
    model = Model.of(blocks, friction=0.6, load=load)
    quick = check(model, options=CheckOptions(settle=False))
    assert any("may need its corners" in one.text for one in quick.sentences())
    assert not any("its corners" in one.text for one in check(model).sentences())
    robust = check(model, options=CheckOptions.robust())
    assert "one with pressure spread over the faces" in robust.message
    assert not any("its corners" in one.text for one in robust.sentences())


def test_a_limit_says_that_it_needs_corners_and_with_every_stiffness_from_where_on() -> None:
    model = standing([ground(WIDE)], [plate(rectangle((0.0, 1.0), (0.0, 1.0)))])
    spread, corners = (FRICTION * weight(model) * arm for arm in (SQUARE, np.sqrt(0.5)))
    torque = LoadCase(loaded(model, spread * TORQUE).load.wrench - model.load.wrench, "torque")
    plain = limits.limit_load(model, torque, upper=10.0)
    said = [one.text for one in plain.sentences()]
    assert plain.best.stands == pytest.approx(corners / spread, rel=1e-3)
    assert any("needs its corners: it turns with 18" in one and "--robust" in one for one in said)
    assert "first motion: turns on a joint" in said
    standing_there = plain.best.standing
    assert standing_there is not None
    assert standing_there.sensitive_to == (Sensitivity.PRESSURE,)
    assert "spread over" not in standing_there.message  # which takes longer and changes no limit
    robust = limits.limit_load(model, torque, upper=10.0, options=limits.LimitOptions(robust=True))
    assert robust.robust is not None
    assert robust.robust.stands == pytest.approx(1.0, abs=0.01)
    assert robust.best.stands == plain.best.stands
    said = [one.text for one in robust.sentences()]
    assert any("the answer depends on the pressure within joints" in one for one in said)


def test_of_joints_that_turn_the_one_that_carries_is_named_before_a_faint_one() -> None:
    """The torques are those of two plates whose areas are as 400 to 1."""
    large, small = rectangle((0.0, 2.0), (0.0, 2.0)), rectangle((4.0, 4.1), (0.0, 0.1))
    model = standing([ground(WIDE)], [plate(large, "large"), plate(small, "small")])
    for block, side, share in ((1, 2.0, 1.1), (2, 0.1, 1.3)):
        own = float(-model.load.wrench[block, 1])
        model = loaded(model, share * FRICTION * own * side * SQUARE * TORQUE, block)
    result = check(model)
    _, used = (one["friction_used"] for one in result.tables()[0])
    assert used == pytest.approx(1.1, abs=0.03)
    (said,) = [one.text for one in result.sentences() if "its corners" in one.text]
    assert said.startswith("the joint of 'ground' and 'large'")
    assert f"turns with {100.0 * used:.0f} %" in said


def test_what_settles_on_its_corners_is_followed_on_spread_points_as_well() -> None:
    blocks = wall(6, 5)
    model = Model.of(blocks, friction=0.6)
    twisted = blocks.names.index("c04-b00")
    turned = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    for torque, verdict, what in (
        (100.0, Verdict.STABLE, ()),
        (112.0, Verdict.STABLE, (Sensitivity.PRESSURE,)),
        (120.0, Verdict.UNSTABLE, ()),
        (113.2, Verdict.STABLE, (Sensitivity.JOINTS, Sensitivity.PRESSURE)),
    ):
        found = check(loaded(model, torque * turned, block=twisted))
        assert (found.verdict, found.sensitive_to) == (verdict, what)
    assert found.settlement is not None
    assert found.message.startswith("it comes to rest")
    assert "with pressure spread over the faces it falls: 'c05-b00'" in found.message
