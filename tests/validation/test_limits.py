"""Limits against closed forms and published figures."""

from functools import cache, partial

import numpy as np
import pytest

from drystone import (
    Assembly,
    Contacts,
    LoadCase,
    Model,
    Verdict,
    check,
    limit_friction,
    limit_load,
    limit_shrink,
    limit_thickness,
    limit_tilt,
    solve_rbe,
)
from drystone.formulations.equilibrium import FrictionCone, Objective
from drystone.limits import Limit, LimitOptions, Tilt, thrust_bounds
from drystone.models import (
    arch,
    box,
    buttressed_arch,
    dome,
    ferris_wall,
    h_model,
    incline,
    lune,
    tower,
)
from drystone.programs import RBEOptions
from drystone.virtual import shift, shrink, to_kern
from tests.oracle import touching_faces

BOUND = LimitOptions(equilibrium_only=True)
QUICK = LimitOptions(scan=2, width=0.01)
FINE = LimitOptions(scan=2, width=1e-3)
WEIGHT = 2400.0 * 9.81


@cache
def joined(blocks: Assembly) -> Contacts:
    """Their joints."""
    return touching_faces(blocks, 0.6)


def both(limit: Limit, width: float) -> tuple[float, float]:
    """Limits of equilibrium and of rest, with states on both sides that fit them."""
    for bracket in (limit.equilibrium, limit.rest):
        assert bracket is not None
        assert bracket.standing is not None
        assert bracket.falling is not None
        assert bracket.falling.verdict is Verdict.UNSTABLE
        assert bracket.stands is not None
        assert bracket.falls is not None
        assert abs(bracket.falls - bracket.stands) <= 1.01 * width
    assert limit.equilibrium.value is not None
    assert limit.best.value is not None
    return limit.equilibrium.value, limit.best.value


# -- closed forms -----------------------------------------------------------------------------


@pytest.mark.parametrize(("friction", "expected"), [(0.4, 21.801), (2.0, 45.0)])
def test_a_cube_on_a_cube_slides_or_topples(friction: float, expected: float) -> None:
    assembly = tower(2)
    limit = limit_tilt(Model(assembly, touching_faces(assembly, friction)), "x", options=QUICK)
    assert both(limit, 0.01) == pytest.approx((expected, expected), abs=0.01)


def test_least_friction_of_a_block_on_an_incline_is_the_tangent_of_its_angle() -> None:
    assembly = incline(20.0)
    limit = limit_friction(Model(assembly, touching_faces(assembly, 0.6)), options=FINE)
    assert both(limit, 1e-3) == pytest.approx(np.tan(np.deg2rad([20.0, 20.0])), abs=1e-3)


def test_a_load_on_a_corbel_overturns_it_about_the_edge() -> None:
    wall = box((1.0, 1.0, 1.0), name="wall")
    corbel = box((2.0, 1.0, 0.5), (-0.6, 0.0, 1.0), "corbel")  # reaches 0.4 over the edge at x = 1
    assembly = Assembly((wall, corbel), np.array([True, False]))
    live = LoadCase.point_load(assembly, "corbel", (0.0, 0.0, -1000.0), (1.4, 0.5, 1.5))
    limit = limit_load(
        Model(assembly, touching_faces(assembly, 0.6)),
        live,
        options=LimitOptions(scan=2, width=1e-3),
    )
    expected = 1.0 * WEIGHT * (1.0 - 0.4) / 0.4 / 1000.0
    assert both(limit, 1e-3) == pytest.approx((expected, expected), abs=1e-3)


def test_a_block_pulled_sideways_slides_at_friction_times_weight() -> None:
    assembly = tower(2)
    live = LoadCase.point_load(assembly, 1, (3.0, 4.0, 0.0), (0.5, 0.5, 1.0))
    limit = limit_load(
        Model(assembly, touching_faces(assembly, 0.35)),
        live,
        upper=1e4,
        options=LimitOptions(scan=2),
    )
    expected = 0.35 * WEIGHT / 5.0
    assert both(limit, 1e-4 * expected) == pytest.approx((expected, expected), rel=1e-4)


def test_a_gravity_wall_overturns_about_its_toe() -> None:
    base, wall = box((3.0, 4.0, 0.3), name="base"), box((1.0, 4.0, 3.0), (1.0, 0.0, 0.3), "wall")
    assembly = Assembly((base, wall), np.array([True, False]))
    # earth pressure of 1 Pa at mid-height on the back of the wall, width 4 m, height 3 m
    live = LoadCase.surface_load(assembly, "wall", 1.0, facing=(-1.0, 0.0, 0.0))
    limit = limit_load(
        Model(assembly, touching_faces(assembly, 0.9)),
        live,
        upper=1e6,
        options=LimitOptions(width=0.1),
    )
    expected = 12.0 * WEIGHT * 0.5 / (12.0 * 1.5)
    assert both(limit, 0.1) == pytest.approx((expected, expected), abs=0.1)


def test_a_tower_stands_on_joints_shrunk_to_the_lean_of_its_load() -> None:
    assembly = tower(3)
    load = LoadCase.tilt(assembly, (0.0, 1.0, 0.0), np.rad2deg(np.arctan(0.25)))
    limit = limit_shrink(Model(assembly, touching_faces(assembly, 0.6), load), options=FINE)
    # two cubes: their centre of mass, 1 m up, leans by 0.25 m out of 0.5 m
    assert both(limit, 1e-3) == pytest.approx((0.5, 0.5), abs=1e-3)


def test_a_block_between_walls_balances_at_any_tilt_but_never_rests() -> None:
    assembly = h_model()
    limit = limit_tilt(Model(assembly, touching_faces(assembly, 0.6)), "x", options=QUICK)
    assert limit.equilibrium.stands == 180.0
    assert limit.equilibrium.falls is None
    assert limit.rest is not None
    assert limit.rest.stands is None
    assert limit.rest.falling is not None
    assert limit.rest.falling.falling_names == ("block",)


def test_a_tilt_about_an_axis_that_is_not_horizontal_is_bisected() -> None:
    assembly = tower(2)
    contacts = touching_faces(assembly, 0.4)
    axis = np.array([1.0, 0.0, 1.0])
    assert not Tilt(Model(assembly, contacts, LoadCase.gravity(assembly)), axis).is_planar()
    options = LimitOptions(equilibrium_only=True, width=0.01)
    limit = limit_tilt(Model(assembly, contacts), axis, options=options)
    # down turns about the axis to a slope a with cos a = (1 + cos t) / 2
    slope = np.arctan(0.4)
    expected = np.rad2deg(np.arccos(2.0 * np.cos(slope) - 1.0))
    assert limit.equilibrium.value == pytest.approx(expected, abs=0.01)


# -- published --------------------------------------------------------------------------------


def thinnest_arch(voussoirs: int, friction: float, options: LimitOptions) -> Limit:
    return limit_thickness(
        lambda ratio: arch(ratio, voussoirs), 0.2, 0.05, friction=friction, options=options
    )


def test_least_thickness_of_the_semicircular_arch() -> None:
    # Milankovitch 1907; Cocchetti and Rizzi 2020; 36 voussoirs by an independent linear program
    limit = thinnest_arch(36, 1.0, LimitOptions(scan=2, width=2e-5))
    assert both(limit, 5e-5) == pytest.approx((0.107424, 0.107424), abs=1e-4)


@pytest.mark.parametrize(("friction", "stands"), [(0.3082, False), (0.3102, True)])
def test_friction_below_which_no_thickness_of_the_arch_stands(
    friction: float, stands: bool
) -> None:
    # Cocchetti and Rizzi 2020: 0.309215, a little above the least thickness; any thicker, the same
    thicknesses = (0.15, 0.19, 0.23, 0.3)
    verdicts = []
    for ratio in thicknesses:
        assembly = arch(ratio, 80)
        contacts = touching_faces(assembly, friction)
        verdicts.append(
            solve_rbe(Model(assembly, contacts), options=RBEOptions(tension=False)).verdict
        )
    assert (Verdict.EQUILIBRIUM_EXISTS in verdicts) == stands


@pytest.mark.parametrize(("angle", "expected"), [(43.0, 8.246), (21.8, 3.006)])
def test_tilt_of_the_semicircular_arch(angle: float, expected: float) -> None:
    # Kao et al. 2022: 8.2 and 3.0 degrees by RBE, CRA and a discrete-element program
    assembly = arch(0.15)
    contacts = touching_faces(assembly, float(np.tan(np.deg2rad(angle))))
    limit = limit_tilt(Model(assembly, contacts), "y", options=QUICK)
    equilibrium, rest = both(limit, 0.01)
    assert equilibrium == pytest.approx(expected, abs=0.02)
    assert rest == pytest.approx(expected, abs=0.05)


BUTTRESSED = buttressed_arch()


def test_least_friction_and_tilt_of_the_buttressed_arch() -> None:
    # Whiting et al. 2009: 0.31 and 12 degrees
    friction = limit_friction(Model(BUTTRESSED, joined(BUTTRESSED)), options=BOUND)
    assert friction.equilibrium.value == pytest.approx(0.309, abs=2e-3)
    tilt = limit_tilt(Model(BUTTRESSED, joined(BUTTRESSED)), "y", options=BOUND)
    assert tilt.equilibrium.value == pytest.approx(12.1, abs=0.1)


def beside(block: str) -> np.ndarray:
    i = BUTTRESSED.index(block)
    joints = joined(BUTTRESSED)
    return np.flatnonzero((joints.block_a == i) | (joints.block_b == i))


def crown_thrust(contacts: Contacts) -> float:
    result = solve_rbe(Model(BUTTRESSED, contacts))
    assert result.verdict is Verdict.EQUILIBRIUM_EXISTS
    return float(result.resultants.normal[beside("voussoir-07")].mean())


def test_a_smaller_joint_at_the_keystone_raises_the_thrust() -> None:
    key = beside("voussoir-07")
    full, half, none = (crown_thrust(shrink(joined(BUTTRESSED), f, key)) for f in (1.0, 0.5, 0.0))
    assert full < half < none


def test_the_least_thrust_stands_at_the_extrados_of_the_crown() -> None:
    key = beside("voussoir-07")
    up = thrust_bounds(
        Model(BUTTRESSED, shift(joined(BUTTRESSED), (0.0, 0.0, 1.0), 0.0, key)),
        "right-0",
        (1.0, 0, 0),
    )
    free = thrust_bounds(Model(BUTTRESSED, joined(BUTTRESSED)), "right-0", (1.0, 0, 0))
    assert up.least == pytest.approx(free.least, rel=1e-5)
    assert up.most < free.most


def test_the_crown_of_the_buttressed_arch_leaves_its_kern() -> None:
    table = solve_rbe(Model(BUTTRESSED, joined(BUTTRESSED))).joints()
    assert (table["kern_ratio"][beside("voussoir-07")] > 1.0).all()
    fitted = solve_rbe(Model(BUTTRESSED, to_kern(joined(BUTTRESSED))))
    assert fitted.verdict is Verdict.UNSTABLE
    assert fitted.tension is not None
    pull = np.bincount(fitted.contacts.interface, fitted.tension)
    assert set(np.argsort(-pull)[:2]) == set(beside("voussoir-07"))


@pytest.mark.parametrize(("friction", "alike"), [(0.4, False), (0.6, True)])
def test_quadratic_and_linear_resultants_of_the_buttressed_arch_differ_a_little(
    friction: float, alike: bool
) -> None:
    # where friction leaves the least thrust free, both choose it and agree
    joints = joined(BUTTRESSED).with_friction(friction)
    quadratic = solve_rbe(Model(BUTTRESSED, joints)).resultants
    options = RBEOptions(objective=Objective.LINEAR)
    linear = solve_rbe(Model(BUTTRESSED, joints), options=options).resultants
    apart = float(np.linalg.norm(quadratic.position - linear.position, axis=1).max())
    assert (apart < 1e-6) == alike
    assert apart < 0.02


DOME = dome()


def test_tilt_of_the_dome_with_the_pyramid_of_the_source_and_with_the_cone() -> None:
    # Kao et al. 2022: 32 degrees, with a pyramid that grants up to 8.2 % more friction
    loose = LimitOptions(equilibrium_only=True, width=0.1, cone=FrictionCone.octagon())
    pyramid = limit_tilt(Model(DOME, joined(DOME)), "y", options=loose).equilibrium.value
    tight = LimitOptions(equilibrium_only=True, width=0.1)
    exact = limit_tilt(Model(DOME, joined(DOME)), "y", options=tight).equilibrium.value
    assert pyramid == pytest.approx(32.0, abs=1.0)
    assert exact is not None
    assert pyramid is not None
    assert exact < pyramid


def test_hoops_of_the_dome_are_idle_below_and_alike_all_around() -> None:
    ring = np.array([int(name[1:3]) for name in DOME.names])
    row = ring[joined(DOME).block_a]
    hoop = row == ring[joined(DOME).block_b]
    quadratic = solve_rbe(Model(DOME, joined(DOME))).resultants.normal
    linear = solve_rbe(Model(DOME, joined(DOME)), options=RBEOptions(objective=Objective.LINEAR))
    largest = quadratic.max()
    assert quadratic[hoop & (row < 3)].max() < 1e-6 * largest
    assert quadratic[hoop & (row > 6)].min() > 1e-2 * largest

    def uneven(normal: np.ndarray) -> float:
        return max(
            float(np.ptp(normal[(row == r) & (hoop == h)])) for r in range(9) for h in (0, 1)
        )

    assert uneven(quadratic) < 1e-6 * largest
    assert uneven(linear.resultants.normal) > 1e-6 * largest


def slippery_walls(assembly: Assembly) -> Contacts:
    contacts = touching_faces(assembly, 1.0)
    wall = np.isin(contacts.block_a, (1, 2)) | np.isin(contacts.block_b, (1, 2))
    return contacts.with_friction(np.where(wall, 0.0, 1.0))


def test_least_thickness_of_the_hemispherical_dome() -> None:
    # 0.0428 without hoop tension, by an independent linear program
    limit = limit_thickness(
        partial(lune, rings=30),
        0.05,
        0.035,
        find=slippery_walls,
        options=LimitOptions(equilibrium_only=True, width=1e-4),
    )
    assert limit.equilibrium.value == pytest.approx(0.0428, abs=5e-4)


@pytest.mark.parametrize(("number", "expected"), [(1, 0.64286), (2, 0.58000)])
def test_associative_load_factors_of_the_walls(number: int, expected: float) -> None:
    # Ferris and Tin-Loi 2001
    assembly = ferris_wall(number)
    contacts = touching_faces(assembly, 0.65)
    limit = limit_load(Model(assembly, contacts), LoadCase.seismic(assembly, 1.0), options=BOUND)
    assert limit.equilibrium.value == pytest.approx(expected, abs=1e-4)


def test_the_compatible_load_factor_of_a_wall_is_not_above_the_associative_one() -> None:
    assembly = ferris_wall(1)
    contacts = touching_faces(assembly, 0.65)
    limit = limit_load(
        Model(assembly, contacts),
        LoadCase.seismic(assembly, 1.0),
        options=LimitOptions(scan=2, width=0.02),
    )
    assert limit.rest is not None
    assert limit.rest.stands is not None
    assert limit.rest.stands > 0.5
    above = LoadCase.gravity(assembly) + 0.6440 * LoadCase.seismic(assembly, 1.0)
    assert check(Model(assembly, contacts, above)).verdict is Verdict.UNSTABLE
