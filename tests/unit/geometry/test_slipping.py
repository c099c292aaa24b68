"""Force and torque that friction resists, against other ways to find them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from drystone.base.ragged import Ragged
from drystone.geometry.kern import sections
from drystone.geometry.pressure import linear_pressure
from drystone.geometry.quadrature import cut_face_points
from drystone.geometry.slipping import pressed_points, slip_use


def by_program(place: np.ndarray, bound: np.ndarray, force: np.ndarray, torque: float) -> float:
    """The largest multiple by a linear program with 64 directions of friction."""
    angle = 2.0 * np.pi * np.arange(64) / 64
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    count = len(place)
    columns = np.repeat(place, 64, axis=0), np.tile(way, (count, 1))
    turn = columns[0][:, 0] * columns[1][:, 1] - columns[0][:, 1] * columns[1][:, 0]
    balance = np.vstack([columns[1].T, turn, np.zeros(0).reshape(0, 64 * count)])
    left = np.column_stack([balance, [-force[0], -force[1], -torque]])
    sums = np.kron(np.eye(count), np.ones(64))
    found = linprog(
        np.append(np.zeros(64 * count), -1.0),
        A_ub=np.column_stack([sums, np.zeros(count)]),
        b_ub=bound,
        A_eq=left,
        b_eq=np.zeros(3),
    )
    return float(-found.fun)


def test_the_largest_multiple_is_that_of_a_linear_program() -> None:
    rng = np.random.default_rng(3)
    place, bound = rng.normal(size=(12, 2)), rng.uniform(0.1, 1.0, 12)
    for _ in range(5):
        force, torque = rng.normal(size=2), float(rng.normal())
        used = slip_use(Ragged.from_counts([12]), place, bound, force[None], np.array([torque]))
        assert 1.0 / used[0] == pytest.approx(by_program(place, bound, force, torque), rel=3e-3)


def test_what_is_asked_up_to_a_use_is_on_the_same_side_of_it() -> None:
    rng = np.random.default_rng(5)
    loops = Ragged.from_counts([12] * 40)
    place, bound = rng.normal(size=(480, 2)), rng.uniform(0.1, 1.0, 480)
    force, torque = 2.0 * rng.normal(size=(40, 2)), rng.normal(size=40)
    used = slip_use(loops, place, bound, force, torque)
    asked = slip_use(loops, place, bound, force, torque, enough=0.4)
    assert 0 < np.count_nonzero(used > 0.4) < 40
    assert ((asked > 0.4) == (used > 0.4)).all()
    assert (asked <= used).all()
    alone = slip_use(Ragged.from_counts([12]), place[:12], bound[:12], force[:1], torque[:1])
    assert alone[0] == pytest.approx(used[0], rel=1e-12)  # whatever other faces need


def test_what_carries_nothing_is_not_used() -> None:
    none = slip_use(
        Ragged.from_counts([2, 2]),
        np.array([[0.0, 0.0], [1.0, 0.0]] * 2),
        np.array([0.0, 0.0, 1.0, 1.0]),
        np.array([[1.0, 0.0], [0.0, 0.0]]),
        np.zeros(2),
    )
    assert none.tolist() == [0.0, 0.0]


def test_pressure_is_linear_and_does_not_pull() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    corners, start = np.tile(square, (2, 1)), np.array([0, 4, 8])
    centre = np.array([[0.2, 0.5], [0.5, 0.5]])
    plane = linear_pressure(sections(corners, start), corners, start, centre)
    assert plane == pytest.approx(np.array([[10.0 / 3.0, -50.0 / 9.0, 0.0], [1.0, 0.0, 0.0]]))
    points = cut_face_points(corners, start, plane)
    assert points.loops.sum(points.area) == pytest.approx([1.0, 1.0])
    share = pressed_points(points, plane, centre)
    assert (share >= 0.0).all()
    assert points.loops.sum(share) == pytest.approx([1.0, 1.0])
    assert points.loops.sum(share[:, None] * points.place) == pytest.approx(centre)
    tipped, even = points.loops.split(share)
    assert (tipped[points.place[points.loops[0], 0] > 0.6001] == 0.0).all()
    assert even == pytest.approx(points.area[points.loops[1]])
