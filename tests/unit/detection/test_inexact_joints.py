"""Joints that small errors of the drawing keep apart are found, and the report says so."""

import numpy as np
import pytest

from drystone import Assembly, Model, Verdict, check, find_contacts
from drystone.detection import DetectionOptions
from drystone.detection.misses import Error
from drystone.geometry.frames import rotation_about
from drystone.models import arch, box, tower, wall

FLOOR = box((2.0, 2.0, 0.1), (-1.0, -1.0, -0.1), name="floor")


def table(sunk: float) -> Assembly:
    """A seat of 30 mm on four legs of 40 mm that reach into the floor."""
    legs = [
        box((0.04, 0.04, 0.45 + sunk), (x, y, -sunk), name=f"leg {x} {y}")
        for x in (-0.19, 0.15)
        for y in (-0.19, 0.15)
    ]
    seat = box((0.4, 0.4, 0.03), (-0.2, -0.2, 0.45), name="seat")
    return Assembly((FLOOR, *legs, seat)).with_fixed(["floor"])


def cube(sunk: float) -> Assembly:
    return Assembly((FLOOR, box((0.4, 0.4, 0.4), (0.0, 0.0, -sunk), name="cube"))).with_fixed(
        ["floor"]
    )


@pytest.mark.parametrize("sunk", [1e-4, 2e-4, 3e-4, 5e-4, 1e-3, 2e-3, 3e-3])
def test_a_table_whose_legs_are_drawn_into_the_floor_stands(sunk: float) -> None:
    model = Model.of(table(sunk))
    exact = Model.of(table(0.0))
    assert check(model).verdict is Verdict.STABLE
    assert model.contacts.block_a.tolist() == exact.contacts.block_a.tolist()
    assert model.contacts.block_b.tolist() == exact.contacts.block_b.tolist()
    assert np.allclose(model.contacts.area, exact.contacts.area)
    assert np.abs(model.contacts.point - exact.contacts.point).max() <= 0.5 * sunk + 1e-12


@pytest.mark.parametrize("sunk", [1e-4, 1e-3, 2e-3, 5e-3])
def test_a_cube_that_is_drawn_into_the_floor_stands(sunk: float) -> None:
    assert check(cube(sunk)).verdict is Verdict.STABLE


def test_what_is_joined_all_the_same_is_told_with_its_depth() -> None:
    model = Model.of(table(5e-4))
    assert model.report is not None
    assert [(pair.block_a, pair.error) for pair in model.report.inexact] == [(0, Error.OVERLAP)] * 4
    assert [pair.off for pair in model.report.inexact] == pytest.approx([5e-4] * 4)
    assert "4 pairs of blocks are drawn up to 0.5 mm deep into each other" in model.notes[0]
    assert "not for the blocks as they are drawn" in model.notes[1]
    assert model.report.to_dict()["inexact"][0]["off"] == pytest.approx(5e-4)
    assert not model.report.missed


def test_what_is_too_deep_is_undecided() -> None:
    found = check(cube(0.012))
    assert found.verdict is Verdict.UNDECIDED
    assert "'floor' and 'cube' are 12 mm deep in each other" in found.message


def test_joining_the_inexact_can_be_left_out() -> None:
    assert find_contacts(cube(5e-3), options=DetectionOptions(inexact=False)).contacts.count == 0


@pytest.mark.parametrize("model", [arch(0.15), tower(4), wall(4, 5)])
def test_nothing_is_changed_of_an_exact_drawing(model: Assembly) -> None:
    found = find_contacts(model)
    assert not found.report.inexact
    exact = find_contacts(model, options=DetectionOptions(inexact=False))
    assert np.array_equal(found.contacts.point, exact.contacts.point)


def test_a_gap_alone_is_not_closed() -> None:
    found = find_contacts(cube(-5e-3))
    assert found.contacts.count == 0
    assert not found.report.inexact


def test_a_gap_is_closed_where_as_deep_an_overlap_of_its_block_shows_that_it_is_off() -> None:
    low = box((0.3, 0.3, 0.3), (0.0, 0.0, -4e-3), name="low")
    for gap, joined in ((3e-3, 2), (14e-3, 1)):
        upper = box((0.3, 0.3, 0.3), (0.0, 0.0, 0.296 + gap), name="upper")
        found = find_contacts(Assembly((FLOOR, low, upper)).with_fixed(["floor"])).report
        told = [(pair.block_b, pair.error) for pair in found.inexact]
        assert told == [(1, Error.OVERLAP), (2, Error.GAP)][:joined]


def test_a_block_that_is_drawn_into_the_floor_closes_no_gaps_of_others() -> None:
    sunk = box((0.3, 0.3, 0.3), (-0.8, 0.0, -4e-3), name="sunk")
    low = box((0.3, 0.3, 0.3), name="low")
    for first, gap in ((low, 3e-3), (None, 3e-3)):
        height = gap if first is None else 0.3 + gap
        upper = box((0.3, 0.3, 0.3), (0.0, 0.0, height), name="upper")
        blocks = (FLOOR, *([low] if first else []), upper)
        alone = Assembly(blocks).with_fixed(["floor"])
        beside = Assembly((*blocks, sunk)).with_fixed(["floor"])
        assert not find_contacts(alone).report.inexact
        assert [pair.block_b for pair in find_contacts(beside).report.inexact] == [len(blocks)]
        assert check(beside).verdict is Verdict.UNDECIDED


def table_with_a_leg(thick: float, short: float) -> Assembly:
    """A table with legs of 0.45 m, one of them short."""
    far = 0.19 - thick
    legs = [
        box((thick, thick, 0.45 - low), (x, y, low), name=f"leg {x:g} {y:g}")
        for x, y, low in ((-0.19, -0.19, short), (-0.19, far, 0), (far, -0.19, 0), (far, far, 0))
    ]
    seat = box((0.4, 0.4, 0.03), (-0.2, -0.2, 0.45), name="seat")
    return Assembly((FLOOR, *legs, seat)).with_fixed(["floor"])


@pytest.mark.parametrize("short", [3e-4, 1e-3, 3e-3, 5e-3, 8e-3])
@pytest.mark.parametrize("thick", [0.02, 0.03, 0.04, 0.06])
def test_a_leg_that_is_drawn_too_short_is_no_proof_of_a_fall(thick: float, short: float) -> None:
    model = table_with_a_leg(thick, short)
    found = check(model)
    if found.verdict is not Verdict.STABLE:  # within tolerance
        assert found.verdict is Verdict.UNDECIDED
        assert f"'floor' and '{model.names[1]}' are {1e3 * short:g} mm apart" in found.message
        assert "--gap" in found.message


def beam_on_bearings(thick: float, low: float) -> Assembly:
    """A beam of a metre on two bearings, one of them low."""
    ends = (box((0.1, 0.1, 0.1), name="left"), box((0.1, 0.1, 0.1 - low), (0.9, 0, 0), "right"))
    beam = box((1.0, thick, thick), (0.0, 0.0, 0.1), name="beam")
    return Assembly((*ends, beam)).with_fixed(["left", "right"])


@pytest.mark.parametrize("low", [5e-4, 3e-3, 5e-3, 8e-3])
@pytest.mark.parametrize("thick", [0.02, 0.03, 0.06])
def test_a_bearing_that_is_drawn_too_low_is_no_proof_of_a_fall(thick: float, low: float) -> None:
    found = check(beam_on_bearings(thick, low))
    assert found.verdict is Verdict.UNDECIDED
    assert f"'right' and 'beam' are {1e3 * low:g} mm apart; join them with --gap" in found.message


@pytest.mark.parametrize("size", [0.05, 0.2])
def test_a_cube_hovers_a_quarter_of_its_edge_before_it_surely_falls(size: float) -> None:
    for share, verdict in ((0.2, Verdict.UNDECIDED), (0.26, Verdict.UNSTABLE)):
        hovering = box((size, size, size), (0.0, 0.0, share * size), name="cube")
        assert check(Assembly((FLOOR, hovering)).with_fixed(["floor"])).verdict is verdict


@pytest.mark.parametrize(
    "model",
    [
        table_with_a_leg(0.04, 0.015),
        table_with_a_leg(0.02, 0.011),
        beam_on_bearings(0.02, 0.02),
        beam_on_bearings(0.06, 0.03),
        cube(-1.0),
    ],
)
def test_what_is_clearly_apart_falls(model: Assembly) -> None:
    assert check(model).verdict is Verdict.UNSTABLE


@pytest.mark.parametrize(("below", "verdict"), [(0.019, "undecided"), (0.022, "unstable")])
def test_a_plank_that_hangs_over_falls_if_the_next_one_is_far_below(
    below: float, verdict: str
) -> None:
    plank = (1.0, 0.1, 0.02)
    low, spacer = box(plank, name="low"), box((0.1, 0.1, below), (0.0, 0.0, 0.02), "spacer")
    upper = box(plank, (0.0, 0.0, 0.02 + below), "upper")
    found = check(Assembly((low, spacer, upper)).with_fixed(["low"]))
    assert found.verdict is Verdict(verdict)


def test_a_wider_gap_is_told_of_blocks_that_touch_nothing() -> None:
    report = find_contacts(cube(-0.04)).report
    assert not report.missed
    assert report.suggestions() == (
        "'floor' and 'cube' are 40 mm apart: --gap 0.15 joins 1 pair of blocks that touch nothing",
    )
    assert find_contacts(cube(-0.04), options=DetectionOptions(gap=0.15)).contacts.count == 1
    assert [miss.gap for miss in report.farther] == pytest.approx([0.04])


def test_a_tilted_foot_in_the_floor_touches_with_all_of_its_face() -> None:
    column = box((0.1, 0.1, 1.0), (-0.05, -0.05, 0.0), name="column")
    turn = rotation_about(np.array([0.0, 1.0, 0.0]), 1.0)
    tilted = column.transformed(turn, (0.0, 0.0, -0.001))
    model = Model.of(Assembly((FLOOR, tilted)).with_fixed(["floor"]))
    assert model.contacts.area.sum() == pytest.approx(0.01, rel=1e-2)
    assert check(model).verdict is Verdict.STABLE


def test_corners_of_blocks_beside_each_other_are_no_joints() -> None:
    blocks = (
        box((1.0, 1.0, 1.0), name="low"),
        box((1.0, 1.0, 1.0), (0.99, 0.0, 0.99), name="high"),
    )
    assert find_contacts(Assembly(blocks)).contacts.count == 0


def test_an_edge_that_is_a_little_in_the_floor_touches_along_it() -> None:
    turned = box((0.2, 0.2, 0.2), name="cube").transformed(
        rotation_about(np.array([0.0, 1.0, 0.0]), 45.0)
    )
    low = float(turned.vertices[:, 2].min())
    sunk = turned.transformed(translation=(0.0, 0.0, -low - 0.004))
    found = find_contacts(Assembly((FLOOR, sunk)))
    assert found.report.interfaces.kind.tolist() == [2]
    assert found.report.inexact[0].off == pytest.approx(0.004)


def test_gaps_are_closed_where_hardly_any_joint_is_exact() -> None:
    leans = (0.1, -0.15, 0.12, -0.08)
    lifts = (0.2e-3, 0.5e-3, 0.8e-3, 0.4e-3)  # 0.8 mm is beyond the tolerance of 0.5 mm
    blocks = [box((0.1, 0.1, 0.1), name="block-0")]
    for i, (lean, lift) in enumerate(zip(leans, lifts, strict=True), start=1):
        turn = rotation_about(np.array([1.0, 0.0, 0.0]), lean)
        one = box((0.1, 0.1, 0.1), name=f"block-{i}").transformed(turn)
        low = float(one.vertices[:, 2].min())
        top = float(blocks[-1].vertices[:, 2].max())
        blocks.append(one.transformed(translation=(0.0, 0.0, top - low + lift)))
    found = find_contacts(Assembly(tuple(blocks)))
    assert found.report.pair_count == 4
    assert {pair.error for pair in found.report.inexact} == {Error.GAP}


def test_an_opened_joint_of_an_exact_drawing_stays_open() -> None:
    blocks = list(tower(4).blocks)
    turn = rotation_about(np.array([0.0, 1.0, 0.0]), 1.5)
    top = blocks[-1].transformed(turn)
    low = float(top.vertices[:, 2].min())
    blocks[-1] = top.transformed(translation=(0.0, 0.0, 3.0 - low))
    found = find_contacts(Assembly(tuple(blocks)))
    assert not found.report.inexact
    assert found.report.interfaces.clipped.tolist() == [False, False, True]
    assert check(Assembly(tuple(blocks)).with_fixed([0])).verdict is not Verdict.UNSTABLE


def test_cubes_stand_as_a_simulator_leaves_them() -> None:
    """Six cubes of 50 mm, each 0.68 mm deep in the one below and hardly turned."""
    blocks = [FLOOR]
    for i in range(6):
        turn = rotation_about(np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0), 0.01 * (i - 2))
        cube = box((0.05, 0.05, 0.05), (-0.025, -0.025, 0.0), name=f"cube {i}")
        blocks.append(cube.transformed(turn, (1e-4 * i, -5e-5 * i, i * 0.05 - 6.8e-4 * (i + 1))))
    model = Model.of(Assembly(tuple(blocks)).with_fixed(["floor"]))
    assert check(model).verdict is Verdict.STABLE
    assert model.contacts.count == 6


def test_the_clearance_of_a_peg_between_two_walls_stays_open() -> None:
    walls = [box((0.1, 0.3, 0.3), (x, 0.0, 0.0), name=f"wall {x}") for x in (0.0, 0.202)]
    peg = box((0.1, 0.3, 0.5), (0.101, 0.0, 0.0), name="peg")
    found = find_contacts(Assembly((FLOOR, *walls, peg)))
    assert found.contacts.block_a.tolist() == [0, 0, 0]
    assert not found.report.inexact
