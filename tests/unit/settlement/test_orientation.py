"""Blocks that are driven go the same way whatever the axes of the model."""

from dataclasses import replace

import numpy as np
import pytest

from drystone import Assembly, LoadCase, Model
from drystone.base.arrays import Floats
from drystone.geometry.frames import rotation_about
from drystone.mechanics.corners import turned_joints
from drystone.mechanics.increments import longest_way, travelled
from drystone.models import arch, box, tower
from drystone.settlement import move_supports, push


def turned(model: Model, turn: Floats) -> Model:
    """A model and its load, turned."""
    wrench = np.concatenate(
        [model.load.wrench[:, :3] @ turn.T, model.load.wrench[:, 3:] @ turn.T], axis=1
    )
    assembly = model.assembly.transformed(turn)
    return Model.of(assembly, friction=0.7, load=LoadCase(wrench))


def column() -> Model:
    blocks = (
        box((3.0, 3.0, 1.0), (-1.0, -1.0, -1.0), "base"),
        box((1.0, 1.0, 2.0), (0.0, 0.0, 0.0), "block"),
    )
    return Model.of(Assembly(blocks).with_fixed(["base"]), friction=0.7)


def test_a_push_takes_the_same_increments_in_every_direction() -> None:
    # 239 increments at 0 degrees and 175 at 45, where lengths were measured along the axes
    plain = column()
    first = push(plain, (1.0, 0.0, 0.0), to=0.2)
    for angle in (30.0, 45.0):
        turn = rotation_about((0.0, 0.0, 1.0), angle)
        second = push(turned(plain, turn), turn[:, 0], to=0.2)
        assert len(second.displacement) == len(first.displacement)
        np.testing.assert_allclose(second.load, first.load, rtol=1e-6)


def test_supports_that_move_take_the_same_increments_in_every_direction() -> None:
    plain = Model.of(tower(3), friction=0.7)
    turn = rotation_about((1.0, 2.0, -1.0), 40.0)
    motion = np.array([0.02, 0.0, 0.0, 0.0, 0.1, 0.0])
    other = np.concatenate([turn @ motion[:3], turn @ motion[3:]])
    first = move_supports(plain, {0: tuple(motion)})
    second = move_supports(turned(plain, turn), {0: tuple(other)})
    assert len(second.displacement) == len(first.displacement)
    np.testing.assert_allclose(second.displacement, first.displacement, rtol=1e-6)


def test_a_length_is_the_same_in_every_direction() -> None:
    rng = np.random.default_rng(1)
    motion = rng.normal(size=(4, 6))
    turn = rotation_about((1.0, 2.0, 3.0), 50.0)
    other = np.concatenate([motion[:, :3] @ turn.T, motion[:, 3:] @ turn.T], axis=1)
    assert longest_way(other) == pytest.approx(longest_way(motion), rel=1e-12)
    assert longest_way(np.zeros((0, 6))) == 0.0


@pytest.mark.parametrize("angle", [1e-9, 1e-5, 0.3, 3.0, np.pi])
def test_small_rotations_keep_their_digits(angle: float) -> None:
    turn = rotation_about((1.0, -2.0, 0.5), float(np.rad2deg(angle)))[None]
    one = np.ones(1)
    assert travelled(np.zeros((1, 3)), turn, one, one)[0] == pytest.approx(angle, rel=1e-7)


def test_loads_that_balance_have_no_direction() -> None:
    # the sum of such loads is rounding: it decided which block is the lower one
    plain = arch(0.15, 8)
    rng = np.random.default_rng(2)
    wrench = np.zeros((len(plain), 6))
    wrench[plain.free, :3] = rng.normal(size=(len(plain.free), 3)) * 1e3
    wrench[plain.free, :3] -= wrench[plain.free, :3].mean(axis=0)
    model = Model.of(plain, friction=0.7, load=LoadCase(wrench))
    expected = turned_joints(model.with_load(replace(model.load, wrench=0.0 * wrench)))
    for block in plain.free:
        nudged = wrench.copy()
        nudged[block] *= 1.0 + 1e-13
        found = turned_joints(model.with_load(replace(model.load, wrench=nudged)))
        np.testing.assert_array_equal(found, expected)
