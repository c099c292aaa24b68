"""Published tilt limits: Kao 2023, dissertation, ETH Zurich; Kao et al. 2022.

Pairs of verdicts 0.2 degree inside and outside of a figure given to a tenth, and on both sides of a
figure given in whole degrees.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from benchmarks.shims.shims import could_hold
from drystone import (
    Assembly,
    CheckOptions,
    LoadCase,
    Model,
    Verdict,
    check,
    find_contacts,
    models,
    solve_rbe,
)
from drystone.checks import corner_motion
from drystone.programs import FrictionCone, RBEOptions

Axis = tuple[float, float, float]
X, Y, XY30 = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.7320508075688772, 1.0, 0.0)


StandsCheck = Callable[[Model], Verdict]


def uniform(model: Model) -> Verdict:
    options = CheckOptions(samples=0, settle=False)
    return check(model, options=options).verdict


def balanced_on_the_octagon(model: Model) -> Verdict:
    options = RBEOptions(cone=FrictionCone.octagon(), tension=False)
    return solve_rbe(model, options=options).verdict


def decided(model: Model) -> Verdict:
    return check(model).verdict


def searched(model: Model) -> Verdict:
    # 8 motions to start from: `python -m benchmarks.thesis` takes 250
    return Verdict.STABLE if could_hold(model, tries=8) else Verdict.UNSTABLE


def sides(
    check: StandsCheck, model: Assembly, friction: float, axis: Axis, below: float, above: float
) -> list[Verdict]:
    contacts = find_contacts(model, friction=friction).contacts
    return [
        check(Model(model, contacts, LoadCase.tilt(model, axis, tilt))) for tilt in (below, above)
    ]


@pytest.mark.parametrize(
    ("kind", "axis", "friction", "dem"),
    [
        ("a", X, 0.20, 21.8),
        ("a", Y, 0.20, 71.3),
        ("a", XY30, 0.20, 24.8),
        ("a", X, 0.84, 59.2),
        ("a", Y, 0.84, 100.0),
        ("a", XY30, 0.84, 62.7),
        ("b", X, 0.20, 21.8),
        ("b", XY30, 0.20, 24.8),
        ("b", Y, 0.84, 109.1),
        ("c", X, 0.20, 13.0),
        ("c", Y, 0.20, 41.3),
        ("c", XY30, 0.20, 14.9),
        ("c", Y, 0.84, 64.5),
        ("d", X, 0.20, 13.0),
        ("d", Y, 0.20, 41.3),
        ("d", XY30, 0.20, 14.9),
        ("d", X, 0.84, 44.1),
        ("d", Y, 0.84, 70.0),
    ],
)
def test_wedges_with_uniform_stiffness_tilt_as_far_as_discrete_elements(
    kind: str, axis: Axis, friction: float, dem: float
) -> None:
    model = models.wedge(kind)  # type: ignore[arg-type]
    found = sides(uniform, model, friction, axis, dem - 0.2, dem + 0.2)
    assert found == [Verdict.STABLE, Verdict.UNSTABLE]


@pytest.mark.parametrize(
    ("kind", "axis", "friction", "rbe"),
    [
        ("a", X, 0.20, 25),
        ("a", XY30, 0.20, 28),
        ("b", X, 0.20, 25),
        ("c", X, 0.20, 13),
        ("c", XY30, 0.20, 15),
        ("d", X, 0.84, 50),
        ("c", XY30, 0.84, 51),
        ("d", XY30, 0.84, 54),
    ],
)
def test_wedges_with_the_octagon_balance_to_the_published_whole_degree(
    kind: str, axis: Axis, friction: float, rbe: int
) -> None:
    model = models.wedge(kind)  # type: ignore[arg-type]
    found = sides(balanced_on_the_octagon, model, friction, axis, rbe, rbe + 1)
    assert found == [Verdict.EQUILIBRIUM_EXISTS, Verdict.UNSTABLE]


@pytest.mark.parametrize(
    ("axis", "below", "above"),
    [((0.0, 1.0, 0.0), 8, 9), ((0.0, -1.0, 0.0), 53, 54), ((1.0, 1.0, 0.0), 11, 12.5)],
)
def test_curved_joints_tilt_to_the_published_whole_degree(
    axis: Axis, below: float, above: float
) -> None:
    model = models.curve_three_blocks()
    found = sides(decided, model, 0.84, axis, below, above)
    assert found == [Verdict.STABLE, Verdict.UNSTABLE]


def test_the_search_finds_rest_where_one_stiffness_has_none() -> None:
    found = sides(searched, models.wedge("c"), 0.84, XY30, 48.0, 50.5)
    assert found == [Verdict.STABLE, Verdict.UNSTABLE]


@pytest.mark.parametrize(("height", "stands"), [("short", (60, 50, 70)), ("tall", (37, 34, 48))])
def test_hooded_blocks_stand_well_inside_the_published_limits(
    height: str, stands: tuple[float, float, float]
) -> None:
    model = models.cube_curve(height)  # type: ignore[arg-type]
    contacts = find_contacts(model, friction=0.84).contacts
    axes = ((-1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, -1.0, 0.0))
    for axis, angle in zip(axes, stands, strict=True):
        assert (
            check(Model(model, contacts, LoadCase.tilt(model, axis, angle))).verdict
            is Verdict.STABLE
        )


@pytest.mark.parametrize(
    ("length", "friction", "angle"),
    [("short", 0.84, 39), ("short", 0.10, 5), ("long", 0.84, 53), ("long", 0.10, 9)],
)
def test_hooked_plank_stands_to_the_published_angle(
    length: str, friction: float, angle: float
) -> None:
    model = models.concave(length)  # type: ignore[arg-type]
    contacts = find_contacts(model, friction=friction).contacts
    assert check(Model(model, contacts, LoadCase.tilt(model, Y, angle))).verdict is Verdict.STABLE


@pytest.mark.parametrize(
    ("length", "friction", "angle"),
    [("short", 0.84, 50), ("short", 0.10, 12), ("long", 0.84, 65), ("long", 0.10, 15)],
)
def test_hooked_plank_slides_out_well_above_the_published_angle(
    length: str, friction: float, angle: float
) -> None:
    """Turned a little it could jam between the walls beside it, but nothing leads there."""
    model = models.concave(length)  # type: ignore[arg-type]
    contacts = find_contacts(model, friction=friction).contacts
    found = check(Model(model, contacts, LoadCase.tilt(model, Y, angle)))
    assert found.verdict is Verdict.UNSTABLE


@pytest.mark.parametrize(("length", "angle"), [("short", 5.0), ("long", 9.0)])
def test_forces_press_only_where_blocks_overlap(length: str, angle: float) -> None:
    """Eq. 5.6: a force needs an overlap that is larger than rounding."""
    model = models.concave(length)  # type: ignore[arg-type]
    contacts = find_contacts(model, friction=0.10).contacts
    found = check(Model(model, contacts, LoadCase.tilt(model, Y, angle)))
    assert found.verdict is Verdict.STABLE
    assert found.force is not None
    assert found.displacement is not None
    moved = corner_motion(model, contacts, found.displacement)
    pressed = found.force[:, 0] > 1e-6 * found.force[:, 0].max()
    assert (-moved[pressed, 0]).min() > 1e-9 * abs(moved).max()
