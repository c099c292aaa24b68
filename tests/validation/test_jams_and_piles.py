"""Jams, wedges, piles and counterweights against closed forms, on both sides of each."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, Block, LoadCase, Model, Verdict, check
from drystone.models import box, prism


def brick(right: float, level: int, name: str) -> Block:
    """A brick of length 1 that ends at x."""
    return box((1.0, 0.5, 0.2), (right - 1.0, 0.0, 0.2 * level), name)


@pytest.mark.parametrize(("shift", "stands"), [(-0.002, True), (0.002, False)])
@pytest.mark.parametrize("edge", ["table", "spine"])
def test_four_bricks_with_a_counterweight_overhang_by_nine_eighths(
    edge: str, shift: float, stands: bool
) -> None:
    """Paterson and Zwick 2009: two bricks on the ends of the spine balance about its middle.

    So three of them stand on the end of the lowest one, whose end is an eighth beyond the table.
    """
    of_table, of_spine = (shift, -0.001) if edge == "table" else (-0.05, shift)
    lowest = 0.125 + of_table
    middle = lowest + of_spine
    blocks = (
        box((2.0, 0.5, 1.0), (-2.0, 0.0, -1.0), "table"),
        brick(lowest, 0, "lowest"),
        brick(middle + 0.5, 1, "spine"),
        brick(middle + 1.0, 2, "out"),
        brick(middle, 2, "counterweight"),
    )
    found = check(Assembly(blocks).with_fixed([0]), friction=0.6)
    assert found.stable is stands


@pytest.mark.parametrize("friction", [0.3, 0.5, 0.8])
@pytest.mark.parametrize("share", [0.98, 1.02])
def test_a_drawer_jams_where_it_is_pulled_off_its_middle_by_its_length_over_twice_the_friction(
    friction: float, share: float
) -> None:
    """The pull F at e presses two corners with F e / L, which resist with twice the friction."""
    off = 0.5 / friction * share
    blocks = (
        box((6.0, 3.0, 0.5), (-3.0, -1.5, -0.5), "floor"),
        box((6.0, 1.0, 0.5), (-3.0, -1.3, 0.0), "right"),
        box((6.0, 1.0, 0.5), (-3.0, 0.3, 0.0), "left"),
        box((1.0, 0.6, 0.2), (-0.5, -0.3, 0.0), "drawer"),
    )
    assembly = Assembly(blocks).with_fixed([0, 1, 2])
    pull = LoadCase.point_load(assembly, "drawer", (500.0, 0.0, 0.0), (0.0, off, 0.1))
    model = Model.of(assembly, load=LoadCase.gravity(assembly) + pull)
    sides = (model.contacts.block_a != 0) & (model.contacts.block_b != 0)
    model = model.with_friction(np.where(sides, friction, 0.0))
    assert check(model).stable is (share > 1.0)


@pytest.mark.parametrize(("margin", "stands"), [(-0.3, True), (0.3, False)])
@pytest.mark.parametrize("heavy", [1.0, 4.0])
def test_a_wedge_is_pressed_out_where_its_angle_is_above_those_of_both_frictions(
    margin: float, stands: bool, heavy: float
) -> None:
    """Coulomb 1776: W tan(angle - phi) <= mu (W + w), W guided by smooth walls."""
    mu, thick = 0.3, 0.4
    lean = np.deg2rad(15.0)
    for _ in range(60):  # the weight of the wedge depends on the angle
        rise = float(np.tan(lean))
        ratio = (0.5 * rise + thick) / heavy
        lean = np.arctan(mu) + np.arctan(mu * (1.0 + ratio))
    rise = float(np.tan(lean + np.deg2rad(margin)))
    weight = heavy / (2.0 - 0.5 * rise)  # density of the guided block, of area 2 - rise / 2
    wedge = [(0.0, 0.0), (1.0, 0.0), (1.0, thick), (0.0, thick + rise)]
    guided = [
        (0.0, thick + rise),
        (1.0, thick),
        (1.0, 2.0 + thick + rise * 0.0),
        (0.0, 2.0 + thick),
    ]
    blocks = (
        box((6.0, 1.0, 0.5), (-3.0, 0.0, -0.5), "floor"),
        box((0.5, 1.0, 3.0), (-0.5, 0.0, thick + rise), "left"),
        box((0.5, 1.0, 3.0), (1.0, 0.0, thick + 0.3), "right"),
        prism(wedge, (0.0, 1.0), "wedge"),
        prism(guided, (0.0, 1.0), "guided", 2400.0 * weight),
    )
    model = Model.of(Assembly(blocks).with_fixed([0, 1, 2]))
    smooth = np.isin(model.contacts.block_a, [1, 2]) | np.isin(model.contacts.block_b, [1, 2])
    assert check(model.with_friction(np.where(smooth, 0.0, mu))).stable is stands


def hexagon(x: float, z: float, name: str) -> Block:
    """A hexagonal log of side 1 with a face below."""
    angles = np.deg2rad(60.0 * np.arange(6))
    return prism([(x + np.cos(a), z + np.sin(a)) for a in angles], (0.0, 3.0), name)


@pytest.mark.parametrize(("friction", "expected"), [(0.301, False), (0.317, True)])
def test_a_hexagonal_log_on_two_others_needs_the_root_of_a_quadratic(
    friction: float, expected: bool
) -> None:
    """The faces lean by 60 degrees: cot(30 + phi) = 3 tan(phi), or 3 mu^2 + 4 mu / sqrt(3) = 1."""
    half = np.sqrt(3.0) / 2.0
    limit = (-4.0 / np.sqrt(3.0) + np.sqrt(16.0 / 3.0 + 12.0)) / 6.0
    assert limit == pytest.approx(0.30899, abs=1e-5)
    blocks = (
        box((12.0, 3.0, 1.0), (-6.0, 0.0, -1.0), "floor"),
        hexagon(-1.5, half, "left"),
        hexagon(1.5, half, "right"),
        hexagon(0.0, 2.0 * half, "top"),
    )
    found = check(Assembly(blocks).with_fixed([0]), friction=friction)
    assert found.stable is expected
    if not expected:
        assert found.verdict is Verdict.UNSTABLE


@pytest.mark.parametrize(
    ("out", "back", "table", "stands"),
    [
        (-0.003, -0.003, -0.003, True),
        (0.003, 0.0, -0.003, False),
        (-0.003, 0.003, -0.003, False),
        (-0.003, -0.003, 0.006, False),
    ],
)
def test_four_bricks_without_a_spine_overhang_by_15_less_4_roots_of_2_by_8(
    out: float, back: float, table: float, stands: bool
) -> None:
    """Ainley 1979: a diamond, its top brick presses on the tails of both middle ones.

    It presses on the outer one with f. Moments about the end of the lowest brick put the outer one
    at (1 / 2 + f) / (1 + f) beyond it, those about its other end put the inner one there, and those
    about the table put its end at (5 / 2 - f) / 4; f = sqrt(2) - 1 is best. At the largest overhang
    all three edges are about to turn: beyond any of them it falls. Friction would let the top
    brick tie the middle ones, so there is hardly any.
    """
    press = np.sqrt(2.0) - 1.0
    lowest = (2.5 - press) / 4.0
    outer = lowest + (0.5 + press) / (1.0 + press)
    inner = lowest - 1.0 + 0.5 / (2.0 - press)
    top = press * (outer - 1.0) + (1.0 - press) * inner + 0.5
    assert outer == pytest.approx((15.0 - 4.0 * np.sqrt(2.0)) / 8.0)
    blocks = (
        box((2.0, 0.5, 1.0), (-2.0, 0.0, -1.0), "table"),
        brick(lowest + table, 0, "lowest"),
        brick(outer + table + out, 1, "outer"),
        brick(inner + table - back, 1, "inner"),
        brick(top + table + 0.5 * (out - back), 2, "top"),
    )
    assert check(Assembly(blocks).with_fixed([0]), friction=0.01).stable is stands


@pytest.mark.parametrize(("share", "stands"), [(0.97, True), (1.03, False)])
@pytest.mark.parametrize("friction", [0.5, 0.6])
def test_an_arch_of_three_hinges_carries_a_load_on_a_hinge_until_its_other_foot_slides(
    friction: float, share: float, stands: bool
) -> None:
    """Moments about the feet and the crown, with faces so narrow that they are hinges.

    Halves of weight W, as wide as high; W acts at d from the crown, the load Q at e from the left
    foot. The right foot carries V = W + Q e / 2 and thrusts with V - W d, which is friction times
    V where V = W d / (1 - friction). A beam brings Q on a hinge without friction.
    """
    narrow, at, pier = 1e-3, -0.5, -1.7
    left = prism(
        [(-1.0, 0.0), (narrow - 1.0, 0.0), (0.0, 1.0 - narrow), (0.0, 1.0), (-1.0, 1.0)],
        (0.0, 1.0),
        "left",
    )
    right = left.transformed(np.diag([-1.0, 1.0, 1.0])).renamed("right")
    weight = left.volume * left.density
    carried = weight * -left.centroid[0] / (1.0 - friction)
    load = share * 2.0 / (1.0 + at) * (carried - weight)
    outline = [
        (at, 1.0),
        (at + narrow, 1.0),
        (at + 0.1, 1.1),
        (at + 0.1, 1.3),
        (pier, 1.3),
        (pier, 1.1),
        (at - 0.1, 1.1),
    ]
    beam = prism(outline, (0.0, 1.0), "beam")
    portion = beam.volume * (beam.centroid[0] - pier) / (at - pier)
    blocks = (
        box((6.0, 1.0, 0.5), (-3.0, 0.0, -0.5), "floor"),
        box((narrow, 1.0, 1.1), (pier, 0.0, 0.0), "pier"),
        left,
        right,
        prism(outline, (0.0, 1.0), "beam", load / portion),
    )
    model = Model.of(Assembly(blocks).with_fixed([0, 1]))
    joints = list(zip(model.contacts.block_a, model.contacts.block_b, strict=True))
    of_joint = {(2, 3): 2.0, (2, 4): 0.0}
    found = check(model.with_friction([of_joint.get(joint, friction) for joint in joints]))
    assert found.stable is stands
