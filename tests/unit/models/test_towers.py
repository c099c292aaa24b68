"""Towers that lean, and piers that are pushed, against rigid bodies by hand."""

import math

import pytest

import drystone
from drystone import InputError, Model, limit_tilt
from drystone.loads import LoadCase
from drystone.models import buttressed_wall, tower

FREE_HEIGHT = 8 * 0.5


def overturns(width: float) -> float:
    return math.degrees(math.atan(width / FREE_HEIGHT))


def test_what_a_tower_leans_is_no_longer_to_be_tilted() -> None:
    for lean in (0.0, 4.0):
        leaning = tower(9, 1.0, course=0.5, lean=lean)
        limit = limit_tilt(leaning, "y", friction=0.7).best
        assert limit.stands <= overturns(1.0) - lean <= limit.falls
        assert limit.falls - limit.stands < 0.1


@pytest.mark.parametrize("less", [-0.2, 0.2])
def test_a_hollow_square_tower_overturns_as_its_outline(less: float) -> None:
    lean = overturns(1.0) + less
    hollow = tower(9, 1.0, course=0.5, thickness=0.3, stones=2, lean=lean)
    assert drystone.check(hollow, friction=1.5).stable == (less < 0.0)


def test_an_octagon_slides_beyond_its_friction_and_has_the_volume_of_its_walls() -> None:
    octagon = tower(5, 2.0, course=0.5, thickness=0.5, lean=10.0)
    limit = math.tan(math.radians(10.0))
    assert drystone.check(octagon, friction=1.01 * limit).stable
    assert not drystone.check(octagon, friction=0.99 * limit).stable
    area = 8.0 * math.tan(math.pi / 8.0) * (1.0**2 - 0.5**2)
    assert octagon.volume.sum() == pytest.approx(5 * 0.5 * area)


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_a_thrust_overturns_a_pier_without_the_stone_it_does_not_lift(factor: float) -> None:
    """A thrust H, 1.5 H at 0.25 m behind the face of a pier of 1.3 m, 1.8 m over its joint."""
    pier = Model.of(buttressed_wall(0, courses=7), friction=0.7)
    weight = pier.assembly.mass * 9.80665
    free = weight[~pier.assembly.fixed].sum()
    held = free * 1.3 / 2.0 - weight[pier.assembly.names.index("c01-w0")] * (1.3 - 0.25)
    push = factor * held / (1.8 - 1.5 * (1.3 - 0.25))
    top, place = len(weight) - 1, (0.3, 0.25, 2.1)
    thrust = LoadCase.point_load(pier.assembly, top, (0.0, push, -1.5 * push), place)
    own = LoadCase.gravity(pier.assembly)
    assert drystone.check(Model(pier.assembly, pier.contacts, own + thrust)).stable == (factor < 1)


@pytest.mark.parametrize("push", [0.6, -0.6])
def test_buttresses_hold_a_wall_that_is_pushed_towards_them_only(push: float) -> None:
    wall = buttressed_wall(1, courses=7, stones=1)
    assert drystone.check(wall, friction=0.7, seismic=(0.0, push)).stable == (push > 0.0)


@pytest.mark.parametrize(
    "make",
    [
        lambda: tower(0),
        lambda: tower(3, thickness=0.5),
        lambda: tower(3, thickness=0.2, stones=1),
        lambda: tower(3, lean=90.0),
        lambda: buttressed_wall(-1),
        lambda: buttressed_wall(spacing=0.5),
    ],
)
def test_towers_and_buttresses_that_do_not_fit_are_refused(make: object) -> None:
    with pytest.raises(InputError):
        make()  # type: ignore[operator]
