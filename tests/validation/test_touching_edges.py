"""Blocks that touch with edges and corners, beside the faces by which they stand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from benchmarks.leaning import card_house as leaning_cards
from benchmarks.leaning import reciprocal_frame
from drystone import (
    Assembly,
    Block,
    JointCapacity,
    LoadCase,
    Model,
    Verdict,
    check,
    limits,
    models,
    plan,
    read,
    solve_rbe,
    write,
)
from drystone.detection import DetectionOptions
from drystone.geometry.frames import rotation_about
from drystone.mechanics.meeting import further_contacts
from drystone.models import box, prism
from drystone.sequence import Structure
from drystone.settlement import End, SettlementOptions, push, reduce_friction, settle

FLOOR = box((20.0, 8.0, 1.0), (-10.0, -4.0, -1.0), "floor")


def slab(degrees: float, length: float = 2.0, thick: float = 0.15) -> Block:
    """A slab that leans to the right, its foot cut flat on z = 0."""
    lean = np.deg2rad(degrees)
    along = length * np.array([np.cos(lean), np.sin(lean)])
    foot = thick / np.sin(lean)
    across = thick * np.array([-np.sin(lean), np.cos(lean)])
    outline = [(0.0, 0.0), (foot, 0.0), tuple(foot * np.array([1.0, 0.0]) + along)]
    head = np.array(outline[2]) + across
    return prism([*outline, tuple(head)], (-0.2, 0.2), "slab")


def wall_beside(block: Block) -> Block:
    """A wall that the highest right edge of a block touches."""
    return box((1.0, 4.0, 4.0), (float(block.bounds[1, 0]), -2.0, 0.0), "wall")


def leaning(degrees: float) -> Assembly:
    block = slab(degrees)
    return Assembly((FLOOR, wall_beside(block), block)).with_fixed([0, 1])


@pytest.mark.parametrize("degrees", [40.0, 50.0, 60.0, 70.0, 75.0])
def test_a_leaning_slab_with_a_flat_foot_stands_by_its_upper_edge(degrees: float) -> None:
    found = check(leaning(degrees), friction=0.9)
    assert found.verdict is Verdict.STABLE
    assert any("slab-wall" in note or "wall-slab" in note for note in found.model.notes)
    assert found.contacts.corner_count > Model.of(leaning(degrees)).contacts.corner_count
    assert not solve_rbe(leaning(degrees), friction=0.9).falls


def slab_near_a_wall() -> Assembly:
    """Its upper edge is 4 mm from the wall."""
    block = slab(70.0)
    wall = wall_beside(block.transformed(translation=(0.004, 0.0, 0.0)))
    return Assembly((FLOOR, wall, block)).with_fixed([0, 1])


@pytest.mark.parametrize(("friction", "falls"), [(0.6, False), (0.05, True)])
def test_no_proof_of_falling_rests_on_an_edge_that_is_near(friction: float, falls: bool) -> None:
    """Slippery feet slide away from it anyway."""
    found = check(slab_near_a_wall(), friction=friction)
    assert found.verdict is (Verdict.UNSTABLE if falls else Verdict.UNDECIDED)
    assert ("'wall' and 'slab' are 4 mm apart" in found.message) is not falls
    assert plan(found.model).complete.verdict is found.verdict
    assert Structure(found.model).stands(["slab"]).verdict is found.verdict


def test_a_leaning_slab_slips_where_friction_is_too_low_for_its_edge_as_well() -> None:
    found = check(leaning(60.0), friction=0.1)
    assert found.verdict is Verdict.UNSTABLE
    assert found.mechanism is not None


@pytest.mark.parametrize("pull", [0.0, 1.0])
def test_edges_carry_nothing_where_joints_crush(pull: float) -> None:
    """Nor do those that are found later, beside joints that pull as well."""
    model = Model.of(leaning(60.0), friction=0.9)
    strong = {"tension": pull, "cohesion": pull, "compression": 1e9}
    found = check(
        model.with_capacity(JointCapacity.of_stress(model.contacts, **strong, brittle=False))
    )
    assert found.verdict is Verdict.UNSTABLE
    assert "edges and corners have no area and carry nothing" in found.message
    assert found.contacts.capacity is not None
    assert found.contacts.capacity.compression[found.contacts.area == 0.0].tolist() == [0.0]


def test_a_floor_and_a_wall_of_one_block_are_touched_in_both_places() -> None:
    block = slab(60.0)
    corner = prism(
        [(-4.0, -1.0), (4.0, -1.0), (4.0, 3.0), (float(block.bounds[1, 0]), 3.0),
         (float(block.bounds[1, 0]), 0.0), (-4.0, 0.0)],
        (-2.0, 2.0), "corner",
    )  # fmt: skip
    assert check(Assembly((corner, block)).with_fixed([0]), friction=0.6).stable


def card(degrees: float, length: float, thick: float, foot: Sequence[float], name: str) -> Block:
    """A card cut square, leaning by an angle from level, its lowest edge at a place (x, z)."""
    lean = np.deg2rad(degrees)
    along = length * np.array([np.cos(lean), np.sin(lean)])
    across = thick * np.array([-np.sin(lean), np.cos(lean)])
    if degrees > 90.0:
        across = -across
    at = np.array(foot)
    outline = [tuple(at), tuple(at + along), tuple(at + along + across), tuple(at + across)]
    return prism(outline if degrees < 90.0 else outline[::-1], (-0.5, 0.5), name)


def card_house(storeys: int, degrees: float = 70.0, thick: float = 0.02) -> Assembly:
    """Pairs of cards that lean on each other, with level cards between the storeys."""
    half = np.cos(np.deg2rad(degrees))
    blocks, level = [FLOOR], 0.0
    for storey in range(storeys):
        pairs = storeys - storey
        for i in range(pairs):
            x = 2.2 * half * (i - 0.5 * (pairs - 1))
            blocks.append(card(degrees, 1.0, thick, (x - half, level), f"left-{storey}-{i}"))
            blocks.append(
                card(180.0 - degrees, 1.0, thick, (x + half, level), f"right-{storey}-{i}")
            )
        top = float(blocks[-1].bounds[1, 2])
        for i in range(pairs - 1):
            x = 2.2 * half * (i - 0.5 * (pairs - 2))
            blocks.append(
                box(
                    (2.2 * half - 1e-3, 1.0, thick),
                    (x - 1.1 * half, -0.5, top),
                    f"flat-{storey}-{i}",
                )
            )
        level = top + thick
    return Assembly(tuple(blocks)).with_fixed([0])


@pytest.mark.parametrize("storeys", [1, 2, 3, 4, 5])
def test_a_card_house_stands_by_the_edges_of_its_cards(storeys: int) -> None:
    assert check(card_house(storeys), friction=0.5).stable


def test_two_cards_need_half_the_cotangent_of_their_lean_and_all_of_it_whichever_way() -> None:
    """Moments about a foot: the thrust at the head is half the weight times the cotangent.

    The normal of their edges may lie as far from level as the cards from upright.
    """
    house = card_house(1, 65.0, 1e-3)
    cotangent = 1.0 / np.tan(np.deg2rad(65.0))
    assert check(house, friction=0.5 * cotangent - 0.005).falls
    assert check(house, friction=0.5 * cotangent + 0.005).verdict is Verdict.UNDECIDED
    assert check(house, friction=cotangent - 0.005).verdict is Verdict.UNDECIDED
    assert check(house, friction=cotangent + 0.005).stable


@pytest.mark.parametrize("degrees", [60.0, 75.0])
def test_the_thrust_of_three_hinges_is_half_the_weight_times_the_cotangent(degrees: float) -> None:
    """Two thin cards, a hinge at the head and one at each foot: moments about a foot."""
    found = check(card_house(1, degrees, 1e-4), friction=1.0)
    assert found.stable
    assert found.force is not None
    contacts = found.contacts
    world = np.einsum("ki,kij->kj", found.force, contacts.frame[contacts.interface])
    of_floor = (contacts.block_a == 0)[contacts.interface]
    weight = float(found.assembly.blocks[1].mass) * 9.81
    thrust = 0.5 * weight / np.tan(np.deg2rad(degrees))
    assert np.abs(world[of_floor, 0]).sum() == pytest.approx(2.0 * thrust, rel=1e-3)
    assert np.abs(world[of_floor, 2]).sum() == pytest.approx(2.0 * weight, rel=1e-8)
    assert np.abs(world[~of_floor, 0]).sum() == pytest.approx(thrust, rel=1e-3)


def test_cards_that_lean_at_45_degrees_depend_on_the_direction_of_their_edges() -> None:
    """The normal may lie 45 degrees to either side: friction of less holds the middle one only."""
    found = check(card_house(1, 45.0), friction=0.7)
    assert found.verdict is Verdict.UNDECIDED
    assert "the direction in which edges press" in found.message
    assert check(card_house(1, 45.0), friction=1.1).stable


def test_planks_of_an_a_frame_with_flat_feet_lean_on_each_other() -> None:
    left = slab(65.0).renamed("left")
    mirror = np.diag([-1.0, 1.0, 1.0])
    reach = float(left.bounds[1, 0])
    right = left.transformed(mirror, (2.0 * reach, 0.0, 0.0)).renamed("right")
    frame = Assembly((FLOOR, left, right)).with_fixed([0])
    assert check(frame, friction=0.6).stable
    assert check(frame, friction=0.15).falls


def ladder(mu_margin: float) -> tuple[Assembly, float]:
    """A thin ladder of two rails and five rungs as one body, and the friction that it needs."""
    degrees = 60.0
    rails = [slab(degrees, 4.0, 0.01).transformed(translation=(0.0, y, 0.0)) for y in (-0.8, 0.8)]
    thin = np.tan(np.deg2rad(degrees))
    least = np.sqrt(thin**2 + 1.0) - thin
    wall = wall_beside(rails[0])
    blocks = (FLOOR, wall, *(rail.renamed(f"rail-{i}") for i, rail in enumerate(rails)))
    return Assembly(blocks).with_fixed([0, 1]), float(least) + mu_margin


@pytest.mark.parametrize(("margin", "expected"), [(0.01, True), (-0.01, False)])
def test_a_thin_ladder_needs_friction_at_both_ends(margin: float, expected: bool) -> None:
    """tan(lean) = (1 - mu^2) / (2 mu)."""
    assembly, friction = ladder(margin)
    assert check(assembly, friction=friction).stable is expected


def spike(at: tuple[float, float], height: float, name: str) -> Block:
    """A pyramid on z = 0."""
    x, y = at
    base = [(x - 0.2, y - 0.2, 0.0), (x + 0.2, y - 0.2, 0.0), (x + 0.2, y + 0.2, 0.0),
            (x - 0.2, y + 0.2, 0.0)]  # fmt: skip
    faces = ((3, 2, 1, 0), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))
    return Block(np.array([*base, (x, y, height)]), faces, name=name)


@pytest.mark.parametrize(("x", "stands"), [(0.0, True), (0.9, False)])
def test_a_plate_on_three_points_carries_a_stone_between_them_only(x: float, stands: bool) -> None:
    points = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 0.0)]
    spikes = [spike(at, 0.6, f"spike-{i}") for i, at in enumerate(points)]
    plate = box((2.4, 2.4, 0.1), (-1.2, -1.2, 0.6), "plate")
    stone = box((0.4, 0.4, 6.0), (x - 0.2, x - 0.2, 0.7), "stone")
    trial = Assembly((FLOOR, *spikes, plate, stone)).with_fixed([0])
    assert check(trial, friction=0.6).stable is stands


def test_a_stone_on_two_ridges_carries_another_one() -> None:
    ridges = [
        prism([(x - 0.3, 0.0), (x + 0.3, 0.0), (x, 0.4)], (-0.5, 0.5), f"ridge-{x:g}")
        for x in (-0.6, 0.6)
    ]
    stones = (
        box((1.8, 0.8, 0.3), (-0.9, -0.4, 0.4), "stone"),
        box((0.5, 0.5, 0.5), (-0.25, -0.25, 0.7), "top"),
    )
    assert check(Assembly((FLOOR, *ridges, *stones)).with_fixed([0]), friction=0.6).stable


def tripod() -> Assembly:
    """Three legs, their feet cut flat, that lean with an edge each on a hub between them."""
    leg = slab(60.0, 1.0, 0.1)
    leg = leg.transformed(translation=(-0.2 - float(leg.bounds[1, 0]), 0.0, 0.0))
    top = float(leg.vertices[:, 2][leg.vertices[:, 0] > -0.2 - 1e-9].max())
    turns = [rotation_about(np.array([0.0, 0.0, 1.0]), 120.0 * i) for i in range(3)]
    corner = [turn @ np.array([0.4, 0.0, 0.0]) for turn in turns]
    points = np.array(
        [c + np.array([0.0, 0.0, z]) for z in (top - 0.05, top + 0.05) for c in corner]
    )
    faces = ((2, 1, 0), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
    hub = Block(points, faces, name="hub")
    legs = [leg.transformed(turn).renamed(f"leg-{i}") for i, turn in enumerate(turns)]
    return Assembly((FLOOR, *legs, hub)).with_fixed([0])


def test_a_tripod_stands_by_the_edges_of_its_legs_on_a_hub() -> None:
    """A third of the hub's weight w on each leg W: moments about the inner edge of the foot."""
    assert check(tripod(), friction=0.6).stable
    assert check(tripod(), friction=0.5).falls
    # an edge has no area: a rounding of 1e-18 m2 left one leg of three without its springs
    assert settle(tripod(), friction=0.8).rests
    assert not settle(tripod(), friction=0.5).rests


def test_settling_pushes_and_friction_that_decays_begin_with_the_edges_that_touch() -> None:
    soon = SettlementOptions(fall=0.02)
    decay = reduce_friction(leaning(60.0), friction=0.6, options=soon)
    least = 0.6 * float(decay.load[-1])
    assert check(leaning(60.0), friction=least + 0.01).stable
    assert check(leaning(60.0), friction=least - 0.01).falls
    assert any("edges and corners touch" in note for note in decay.model.notes)
    assert push(card_house(1), to=1e-4, friction=0.5, options=soon).end is End.REACHED
    assert settle(card_house(1), friction=0.5).rests


def test_a_subset_knows_the_edges_that_touch() -> None:
    beside = box((1.0, 1.0, 1.0), (-8.0, 0.0, 0.0), "beside")
    blocks = leaning(60.0).blocks
    model = Model.of(Assembly((beside, *blocks)).with_fixed([1, 2]), friction=0.9)
    assert check(model).stable
    some = model.subset([3, 1, 2])
    assert check(some).stable
    assert some.report is not None
    again = Model.of(some.assembly, friction=0.9).report
    assert again is not None
    assert some.report.names == again.names == ("slab", "floor", "wall")
    assert some.report.pair_count == again.pair_count == 2
    assert some.report.isolated == again.isolated
    assert model.without(["slab"]).report is not None


@pytest.mark.parametrize("format", ["drystone", "compas-assembly", "compas-dem"])
@pytest.mark.parametrize(
    "made", [slab_near_a_wall, partial(leaning, 60.0), partial(card_house, 2), tripod]
)
def test_what_is_read_again_has_the_same_verdict(
    made: Callable[[], Assembly], format: str, tmp_path: Path
) -> None:
    """Written before the check, which may find edges, and with its result."""
    model = Model.of(made(), friction=0.6)
    found = check(model)
    for written in (model, found):
        write(written, tmp_path / "again.json", format=format)
        again = read(tmp_path / "again.json")
        assert again.detection == DetectionOptions()
        assert check(again).verdict is found.verdict
    write(replace(model, report=None), tmp_path / "given.json", format=format)
    given = read(tmp_path / "given.json")  # contacts that nobody searched are all there are
    assert given.detection is None
    assert check(given).stable is (made is tripod)  # whose hub touches nothing else


def test_limits_and_plans_count_the_edges_that_touch() -> None:
    tilt = limits.limit_tilt(leaning(60.0), "y", friction=0.6)
    assert tilt.rest is not None
    assert tilt.rest.stands is not None
    assert tilt.rest.stands > 45.0
    found = plan(leaning(60.0), friction=0.6)
    assert found.order == ("slab",)
    assert found.counts["free"] == 1


def test_a_parametric_limit_counts_the_edges_that_touch() -> None:
    """It stands by its upper edge until its feet slip."""
    found = limits.limit_thickness(leaning, 75.0, 35.0, friction=0.3, parameter="lean")
    assert found.rest is not None
    assert found.rest.stands is not None
    assert found.rest.falls is not None
    middle = 0.5 * (found.rest.stands + found.rest.falls)
    assert check(leaning(middle + 0.5), friction=0.3).stable
    assert not check(leaning(middle - 0.5), friction=0.3).stable


def test_edges_of_four_blocks_that_meet_in_a_line_hold_nothing() -> None:
    """A dome without bond under a sideways load: its joints decide."""
    shell = models.dome(slices=8, rings=4)
    load = LoadCase.gravity(shell) + 1.03 * LoadCase.seismic(shell, 1.0)
    model = Model.of(shell, friction=0.7, load=load)
    further = further_contacts(shell, model.contacts, DetectionOptions())
    assert not len(further.parallel)
    assert check(model).falls


@pytest.mark.parametrize(
    ("beams", "opening", "least"),
    [(5, 0.1, 0.627), (6, 0.1, 0.7985), (6, 0.12, 0.5775)],
)
def test_a_reciprocal_frame_stands_with_more_friction_than_the_least(
    beams: int, opening: float, least: float
) -> None:
    """Where following begins with a fall, beams that hardly roll slip off each other instead."""
    frame = reciprocal_frame(beams, opening)
    scan = [*least * np.array([0.8, 0.98]), *np.arange(1.01 * least, 1.5, 0.1)]
    for friction in map(float, scan):
        model = Model.of(frame, friction=friction)
        assert check(model).verdict is (Verdict.STABLE if friction > least else Verdict.UNSTABLE)
        for shear in (0.17, 0.5):
            options = SettlementOptions(tangential=shear)
            assert settle(model, options=options).rests is (friction > least)


@pytest.mark.parametrize(
    ("build", "least"),
    [
        (partial(reciprocal_frame, 3, 0.1), 0.394),
        (partial(reciprocal_frame, 4, 0.1), 0.500),
        (partial(reciprocal_frame, 5, 0.12), 0.477),
        (partial(reciprocal_frame, 6, 0.12), 0.578),
        (partial(leaning_cards, 2, 60.0), 0.432),
        (partial(leaning_cards, 3, 70.0), 0.295),
    ],
)
@pytest.mark.parametrize("share", [0.97, 1.03])
def test_reciprocal_frames_and_card_houses_need_the_friction_that_a_simulator_confirms(
    build: Callable[[], Assembly], least: float, share: float
) -> None:
    """Source: simulation by MuJoCo at 0.9 and 1.1 of it, ``python -m benchmarks.leaning``."""
    found = check(build(), friction=share * least)
    assert found.stable is (share > 1.0)
    assert found.falls is (share < 1.0)


@pytest.mark.parametrize(
    ("higher", "verdict"),
    [(-1e-3, Verdict.STABLE), (0.0, Verdict.UNDECIDED), (1e-3, Verdict.UNSTABLE)],
)
def test_edges_that_meet_are_held_against_both_ends_of_their_directions(
    higher: float, verdict: Verdict
) -> None:
    """A slab on the upper edge of a wall: a lower one presses across, a higher one level."""
    block = slab(60.0)
    edge = block.vertices[block.vertices[:, 0].argmax()]
    wall = box((1.0, 4.0, edge[2] + higher), (edge[0], -2.0, 0.0), "wall")
    if higher < 0.0:
        wall = wall.transformed(translation=(higher / np.tan(np.deg2rad(60.0)), 0.0, 0.0))
    found = check(Assembly((FLOOR, wall, block)).with_fixed([0, 1]), friction=0.21)
    assert found.verdict is verdict
    if verdict is Verdict.UNDECIDED:
        assert "parallel edges of 'wall' and 'slab' meet" in found.message


def test_near_pairs_that_are_tried_rub_as_the_joints_do() -> None:
    """A slab on pebbles slides from 31 degrees on, were the floor below it touched or not."""
    pebbles = [
        box((0.2, 0.2, 0.1), (x, y, 0.0), f"pebble {x} {y}") for x, y in ((-0.9, -0.9), (0.7, 0.0))
    ]
    above = box((2.0, 2.0, 0.5), (-1.0, -1.0, 0.1), "slab")
    model = Model.of(Assembly((FLOOR, *pebbles, above)).with_fixed([0]), friction=0.6)
    steep = check(model.with_load(LoadCase.tilt(model.assembly, (1.0, 0.0, 0.0), 33.0)))
    assert steep.verdict is Verdict.UNSTABLE
