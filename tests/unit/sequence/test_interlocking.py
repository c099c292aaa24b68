"""Assemblies that hold under every load without friction, and those that do not."""

import numpy as np
import pytest

from drystone import InputError, LoadCase, Model
from drystone.models import arch, box, burr, dovetail, tower, wall
from drystone.sequence import gravity_region, interlocking
from drystone.sequence.freedom import opening_rows

DOWN, UP = [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]
X, Y = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]


def test_a_burr_interlocks_once_its_key_is_held_to_another_piece():
    model = Model.of(burr())
    for other in ("x-low", "y-high", "z-low"):
        assert interlocking(model, ("key", other)).holds


def test_the_key_of_a_burr_is_what_moves_first():
    found = interlocking(Model.of(burr()), "x-low")
    assert not found.holds
    assert found.names == ("key",)
    assert found.moving == (0,)
    np.testing.assert_allclose(np.abs(found.motion[0, :3]), [1.0, 0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("model", [tower(4), wall()])
def test_stacked_boxes_do_not_interlock(model):
    found = interlocking(model)
    assert not found.holds
    assert found.first


def test_a_dovetail_moves_in_one_direction():
    found = interlocking(dovetail())
    assert not found.holds
    assert found.names == ("tenon",)
    motion = found.motion[1]
    np.testing.assert_allclose(np.abs(motion[:3]), [0.0, 1.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(motion[3:], 0.0, atol=1e-6)


def test_the_motion_that_is_shown_closes_no_joint():
    for model in (Model.of(arch(0.2, 9)), Model.of(wall()), Model.of(tower(3))):
        found = interlocking(model)
        free = model.assembly.free
        scaled = found.motion[free].copy()
        scaled[:, :3] /= model.assembly.size[free][:, None]
        assert (opening_rows(model) @ scaled.ravel()).min() > -1e-6


def test_a_box_in_a_box_interlocks_and_one_side_open_does_not():
    sides = [
        box((1.0, 1.0, 1.0), np.array(axis) * side, f"{name}{side:+d}")
        for name, axis in zip("xyz", np.eye(3).tolist(), strict=True)
        for side in (-1, 1)
    ]
    from drystone import Assembly

    inside = box((1.0, 1.0, 1.0), name="inside")
    closed = Assembly((*sides, inside), np.arange(7) < 6)
    assert interlocking(closed).holds
    opened = closed.without(["z+1"])
    found = interlocking(opened)
    assert not found.holds
    assert found.motion[-1, 2] > 0.9


def test_nothing_fixed_is_refused():
    with pytest.raises(InputError, match="nothing is fixed"):
        interlocking(burr())
    with pytest.raises(InputError, match="no block is held"):
        gravity_region(tower(2), ())


def test_a_block_on_another_holds_without_friction_for_gravity_straight_down_only():
    found = gravity_region(tower(2), directions=np.array([DOWN, UP, X, [0.1, 0.0, -1.0]]))
    assert found.frictionless.tolist() == [True, False, False, False]


def test_friction_widens_the_region_to_its_cone():
    friction = 0.5
    angle = np.arctan(friction)
    tilts = [0.98 * angle, 1.02 * angle]
    directions = np.array([[np.sin(t), 0.0, -np.cos(t)] for t in tilts])
    found = gravity_region(tower(2), directions=directions, friction=friction)
    assert found.balanced.tolist() == [True, False]


def test_an_interlocking_burr_holds_in_all_directions_without_friction():
    found = gravity_region(Model.of(burr()), ("key", "x-low"), directions=24)
    assert found.frictionless.all()
    assert found.shares == {"frictionless": 1.0, "balanced": 1.0}


def test_a_dovetail_holds_across_its_groove_and_not_along_it():
    found = gravity_region(dovetail(), directions=np.array([DOWN, UP, X, Y, [0, -1, 0.0]]))
    assert found.frictionless.tolist() == [True, True, True, False, False]


def test_an_arch_between_two_supports_stands_on_its_feet_but_not_on_its_head():
    found = gravity_region(
        arch(0.2, 9), directions=np.array([DOWN, UP, Y]), friction=0.7, stands=True
    )
    assert found.balanced.tolist() == [True, False, False]
    assert found.stands.tolist() == [True, False, False]
    assert not found.frictionless.any()


def test_directions_must_be_directions():
    with pytest.raises(InputError):
        gravity_region(tower(2), directions=np.zeros((1, 3)))
    with pytest.raises(InputError):
        gravity_region(tower(2), directions=0)


def test_loads_beside_the_weights_do_not_turn_with_gravity() -> None:
    model = tower(3)
    load = LoadCase.gravity(model) + LoadCase.point_load(model, 2, (0.0, 0.0, 1e6))
    with pytest.raises(InputError, match="'block-2' has a load beside its weight"):
        gravity_region(model, friction=0.6, load=load)
