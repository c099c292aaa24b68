"""Models that strain the numbers: the right verdict, no warning, no traceback."""

import numpy as np
import pytest

from drystone import Assembly, CheckOptions, LoadCase, Verdict, check, find_contacts, models
from drystone.geometry.frames import rotation_about
from drystone.model import Model
from drystone.models import box
from drystone.programs import solve_cra, solve_cra_penalty, solve_rbe
from drystone.results import Sensitivity

X = (1.0, 0.0, 0.0)


def on_ground(*blocks):
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


def ground(size=4.0, thickness=0.5):
    return box((size, size, thickness), (-size / 2, -size / 2, -thickness), name="ground")


def pebble_on_boulder():
    return on_ground(
        ground(2e3, 1e3),
        box((1e3, 1e3, 1e3), (-500, -500, 0), name="boulder"),
        box((1e-3, 1e-3, 1e-3), (0, 0, 1e3), name="pebble"),
    )


def boulder_on_pebbles():
    pebbles = [
        box((1e-3, 1e-3, 1e-3), (x, y, 0), name=f"pebble {x} {y}") for x in (-1, 1) for y in (-1, 1)
    ]
    return on_ground(
        ground(2e3, 1e3), *pebbles, box((1e3, 1e3, 1e3), (-500, -500, 1e-3), name="boulder")
    )


def cube_on_its_edge(angle):
    cube = box((1, 1, 1), name="cube").transformed(rotation_about(X, angle))
    return on_ground(ground(), cube.transformed(None, (0, 0, -cube.bounds[0, 2])))


def cube_on_its_vertex():
    cube = box((1, 1, 1), name="cube").transformed(rotation_about(X, 45.0))
    cube = cube.transformed(rotation_about((0, 1, 0), np.rad2deg(np.arctan(np.sqrt(0.5)))))
    return on_ground(ground(), cube.transformed(None, (0, 0, -cube.bounds[0, 2])))


def overhanging(offset):
    return on_ground(box((1, 1, 1), name="base"), box((1, 1, 1), (offset, 0, 1), name="upper"))


def verdict(model, friction=0.6, load=None):
    contacts = find_contacts(model, friction=friction).contacts
    return check(Model(model, contacts, load)).verdict


@pytest.mark.parametrize(
    ("model", "friction"),
    [
        (pebble_on_boulder(), 0.6),
        (boulder_on_pebbles(), 0.6),
        (cube_on_its_edge(45.0), 0.6),
        (cube_on_its_vertex(), 0.6),
        (overhanging(0.5 - 1e-6), 0.6),
        (on_ground(ground(), box((1, 1, 1), name="a")), 0.0),
        (models.arch(0.15), 1e6),
        (on_ground(ground(), box((1e-3, 1e-3, 1), name="needle")), 0.6),
        (
            on_ground(ground(), *(box((1, 1, 1e-4), (0, 0, i * 1e-4), f"{i}") for i in range(6))),
            0.6,
        ),
        (
            on_ground(
                ground(),
                box((1, 1, 1), name="feather", density=1e-6),
                box((1, 1, 1), (0, 0, 1), name="lead", density=1e6),
            ),
            0.6,
        ),
        (
            on_ground(ground(), box((1, 1, 1), (-2, 0, 0), "a"), box((1, 1, 1), (0.5, 0, 0), "b")),
            0.6,
        ),
    ],
    ids=lambda value: "",
)
def test_what_stands_on_paper_stands_in_numbers(model, friction):
    assert verdict(model, friction) is Verdict.STABLE


@pytest.mark.parametrize(
    ("model", "friction"),
    [
        (cube_on_its_edge(30.0), 0.6),
        (overhanging(0.5 + 1e-3), 0.6),
        (overhanging(0.9999), 0.6),
        (models.arch(0.15), 1e-9),
        (
            on_ground(ground(), box((1, 1, 1), (-2, 0, 0), "a"), box((1, 1, 1), (0.5, 0, 5), "b")),
            0.6,
        ),
        (Assembly(models.tower(3).blocks, np.zeros(3, dtype=bool)), 0.6),
    ],
    ids=lambda value: "",
)
def test_what_falls_on_paper_falls_in_numbers(model, friction):
    assert verdict(model, friction) is Verdict.UNSTABLE


@pytest.mark.parametrize(("angle", "expected"), [(29.0, Verdict.STABLE), (32.0, Verdict.UNSTABLE)])
def test_a_pebble_a_million_times_smaller_than_its_boulder_has_its_own_tolerance(angle, expected):
    model = pebble_on_boulder()
    assert verdict(model, 0.6, LoadCase.tilt(model, X, angle)) is expected


@pytest.mark.parametrize("friction", [0.0, 0.6])
@pytest.mark.parametrize("density", [1e-7, 1e-10, 1e-13])
def test_a_block_of_hardly_any_weight_stands_on_heavy_ones_that_turn(density, friction):
    lower, upper = box((1, 1, 1), name="lower"), box((1, 1, 1), (0.1, 0, 1), name="upper")
    light = box((1, 1, 1), (0.3, 0.2, 2), name="light", density=density)
    beyond = box((1, 1, 1), (0.9, 0.2, 2), name="light", density=density)
    beside = box((0.5, 0.5, 0.5), (1, 0.1, 0), name="beside", density=density)
    leaning = box((1, 1, 1), (0.2, 0, 1), name="leaning")
    for blocks in ((lower, upper, light), (lower, beside, leaning)):
        found = check(Model.of(on_ground(ground(), *blocks), friction=friction))
        assert found.verdict is Verdict.STABLE
        assert found.residuals.largest < 1e-8
        # without friction every stiffness gives the same answer
        assert set(found.sensitive_to) <= ({Sensitivity.WEIGHTS} if friction else set())
    falls = check(Model.of(on_ground(ground(), lower, upper, beyond), friction=friction))
    assert falls.verdict is Verdict.UNSTABLE
    assert falls.falling == (3,)


def test_a_light_block_that_uniform_joints_do_not_show_to_stand_is_told():
    lower, leaning = box((1, 1, 1), name="lower"), box((1, 1, 1), (0.2, 0, 1), name="leaning")
    beside = box((0.5, 0.5, 0.5), (1, 0.1, 0), name="beside", density=1e-7)
    found = check(Model.of(on_ground(ground(), lower, beside, leaning), friction=0.6))
    assert found.stable
    assert found.sensitive_to == (Sensitivity.WEIGHTS,)
    assert "softer, by what these blocks feel" in found.message


@pytest.mark.parametrize("density", [1e-3, 1e-10])
def test_a_boulder_stands_on_pebbles_whatever_their_density(density):
    pebbles = [
        box((0.2, 0.2, 0.2), (*place, 0), name=f"pebble {place}", density=density)
        for place in ((0, 0), (0.8, 0), (0.4, 0.8))
    ]
    boulder = box((1, 1, 1), (0, 0, 0.2), name="boulder")
    top = box((0.2, 0.2, 0.2), (0.2, 0.1, 1.2), name="top", density=density)
    model = on_ground(ground(), *pebbles, boulder, top)
    tilted = LoadCase.tilt(model, (1.0, 0.3, 0.0), 15.0)
    found = check(Model.of(model, friction=0.6, load=tilted))
    assert found.verdict is Verdict.STABLE
    assert found.residuals.largest < 1e-8


@pytest.mark.parametrize(("angle", "expected"), [(15.0, "stable"), (35.0, "unstable")])
def test_joints_without_a_limit_have_none_under_any_load(angle, expected):
    model = on_ground(ground(), box((1, 1, 1), name="heavy", density=1e33))
    tilted = LoadCase.tilt(model, X, angle)
    assert check(Model.of(model, friction=0.6, load=tilted)).verdict == expected


@pytest.mark.parametrize("g", [1e-12, 1e12])
def test_the_strength_of_gravity_does_not_matter(g):
    tower = models.tower(10)
    assert verdict(tower, 0.6, LoadCase.gravity(tower, g=g)) is Verdict.STABLE


def test_no_load_is_no_danger():
    tower = models.tower(3)
    assert verdict(tower, 0.6, LoadCase(np.zeros((3, 6)))) is Verdict.STABLE


def test_gravity_upside_down_lifts_all_that_is_loose():
    tower = models.tower(3)
    contacts = find_contacts(tower, friction=0.6).contacts
    result = check(Model(tower, contacts, LoadCase.gravity(tower, direction=(0, 0, 1))))
    assert result.verdict is Verdict.UNSTABLE
    assert result.falling == (1, 2)


def test_nothing_free_is_stable():
    tower = Assembly(models.tower(3).blocks, np.ones(3, dtype=bool))
    assert verdict(tower) is Verdict.STABLE


@pytest.mark.parametrize(
    "analyse",
    [
        lambda *model: check(Model(*model), time_limit_s=0.0),
        lambda *model: check(Model(*model), stop=lambda: True),
        lambda *model: solve_cra(Model(*model), time_limit_s=0.0),
        lambda *model: solve_cra(Model(*model), stop=lambda: True),
        lambda *model: solve_cra_penalty(Model(*model), time_limit_s=0.0),
    ],
)
def test_out_of_time_is_undecided_with_a_reason(analyse):
    model = models.arch(0.15)
    result = analyse(model, find_contacts(model, friction=0.9).contacts)
    assert result.verdict is Verdict.UNDECIDED
    assert result.message


@pytest.mark.parametrize(("angle", "verdict"), [(0.14, "stable"), (0.15, "unstable")])
def test_a_tower_of_four_hundred_cubes_stands_until_it_topples(angle, verdict):
    # it topples over an edge at atan(1 / 399), 0.1436 degrees
    tower = models.tower(400)
    model = Model.of(tower, friction=0.6, load=LoadCase.tilt(tower, X, angle))
    assert check(model, options=CheckOptions(samples=0, settle=False)).verdict == verdict


@pytest.mark.parametrize("friction", [1e4, 1e6])
def test_equilibrium_is_decided_with_friction_of_any_size(friction):
    tower, arch = (Model.of(one, friction=friction) for one in (models.tower(3), models.arch()))
    assert solve_rbe(tower).verdict is Verdict.EQUILIBRIUM_EXISTS
    assert solve_rbe(arch).verdict is Verdict.EQUILIBRIUM_EXISTS
    tilted = arch.with_load(LoadCase.tilt(arch.assembly, X, 30.0))
    assert solve_rbe(tilted).verdict is Verdict.UNSTABLE
