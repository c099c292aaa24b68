"""Forces that agree with a motion, and the steps that turn a motion until they balance."""

import numpy as np
import pytest

from drystone import LoadCase, models
from drystone.detection import find_contacts
from drystone.formulations import compatible
from drystone.formulations.compatible import (
    compatible_forces,
    compatible_motion,
    slide_directions,
)
from drystone.formulations.improvement import improve, turned_friction
from drystone.model import Model
from drystone.stability.problem import Problem

X = (1.0, 0.0, 0.0)


def wedge(tilt=40.0, kind="a", friction=0.84):
    model = models.wedge(kind)
    contacts = find_contacts(model, friction=friction).contacts
    return Problem.build(Model(model, contacts, LoadCase.tilt(model, X, tilt))).statics


def test_unit_wrenches_are_columns_of_the_equilibrium_matrix():
    statics = wedge()
    corner = np.array([1, 4, 5])
    direction = np.random.default_rng(0).normal(size=(3, 3))
    found = statics.unit_wrenches(corner, direction)
    columns = np.zeros((6 * statics.free_count, 3))
    np.add.at(columns, (found.row, found.column), found.value)
    force = np.zeros((statics.corner_count, 3))
    for column, (at, along) in enumerate(zip(corner, direction, strict=True)):
        force[:] = 0.0
        force[at] = along
        assert columns[:, column] == pytest.approx(statics.wrench(force).ravel(), abs=1e-14)


def test_friction_turns_with_the_slide():
    """The derivative of wrenches by the motion against a finite difference."""
    statics = wedge()
    rng = np.random.default_rng(1)
    motion, change = rng.normal(size=(2, statics.free_count, 6))
    corner = np.arange(statics.corner_count)
    size = rng.uniform(0.5, 1.0, len(corner))

    def wrench(motion):
        force = np.zeros((len(corner), 3))
        force[:, 1:] = -size[:, None] * slide_directions(statics.displacement(motion))
        return statics.wrench(force).ravel()

    moved = statics.displacement(motion)
    held = size / np.linalg.norm(moved[:, 1:], axis=1)
    turned = turned_friction(statics, moved, corner, held)
    slope = np.zeros(6 * statics.free_count)
    np.add.at(slope, turned.row, turned.value * change.ravel()[turned.column])
    step = 1e-6
    found = (wrench(motion + step * change) - wrench(motion - step * change)) / (2.0 * step)
    assert slope == pytest.approx(found, rel=1e-5, abs=1e-7)


def test_forces_press_only_closing_corners_and_oppose_the_slide():
    statics = wedge()
    motion = np.random.default_rng(3).normal(size=(statics.free_count, 6))
    moved = statics.displacement(motion)
    force, unbalanced = compatible_forces(statics, motion)
    assert (force[moved[:, 0] >= 0.0] == 0.0).all()
    assert (force[:, 0] >= 0.0).all()
    friction = np.linalg.norm(force[:, 1:], axis=1)
    assert (friction <= 0.84 * force[:, 0] + 1e-12).all()
    assert np.einsum("ki,ki->k", force[:, 1:], moved[:, 1:]) == pytest.approx(
        -friction * np.linalg.norm(moved[:, 1:], axis=1), abs=1e-12
    )
    assert unbalanced == pytest.approx(np.linalg.norm(statics.wrench(force) + statics.load))


def test_active_set_and_interior_point_agree(monkeypatch):
    statics = wedge()
    rng = np.random.default_rng(5)
    for _ in range(5):
        motion = rng.normal(size=(statics.free_count, 6))
        _, first = compatible_forces(statics, motion)
        with monkeypatch.context() as patch:
            patch.setattr(compatible, "DENSE", 0)
            _, second = compatible_forces(statics, motion)
        assert first == pytest.approx(second, rel=1e-6, abs=1e-9)


def test_the_motion_for_balanced_forces_closes_where_they_press():
    statics = wedge(30.0)
    settled = improve(statics, compatible_motion(statics, _balanced(statics)))
    motion = compatible_motion(statics, settled.force)
    assert motion is not None
    loaded = settled.force[:, 0] > 1e-2 * settled.force[:, 0].max()
    assert (statics.displacement(motion)[loaded, 0] < 0.0).all()


def test_the_state_found_balances_and_overlaps_alike():
    statics = wedge(57.0)
    start = compatible_motion(statics, _balanced(statics))
    found = improve(statics, start)
    assert found.unbalanced < 1e-8 * np.linalg.norm(statics.load)
    gap = statics.displacement(found.motion)[:, 0]
    loaded = found.force[:, 0] > 0.0
    assert gap.min() > -1.0 - 1e-5
    assert gap[loaded].max() < -1.0 + 1e-5


def test_nothing_is_found_where_no_forces_balance():
    statics = wedge(22.2, "b", 0.2)
    motion = np.random.default_rng(1).normal(size=(statics.free_count, 6))
    found = improve(statics, motion)
    assert found.unbalanced > 1e-4


def _balanced(statics):
    from drystone.formulations.corner_forces import FrictionCone
    from drystone.formulations.equilibrium import solve_equilibrium

    return solve_equilibrium(statics, cone=FrictionCone.exact()).force
