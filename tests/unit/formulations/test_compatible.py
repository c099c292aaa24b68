"""Forces that agree with a motion, and the steps that turn a motion until they balance."""

import numpy as np
import pytest

from drystone import LoadCase, models
from drystone.detection import find_contacts
from drystone.formulations import compatible
from drystone.formulations.compatible import compatible_forces, compatible_motion
from drystone.formulations.corner_blocks import NORMAL, CornerBlocks
from drystone.formulations.improvement import improve
from drystone.model import Model
from drystone.solvers.triplets import Triplets
from drystone.stability.problem import Problem

X = (1.0, 0.0, 0.0)


def wedge(tilt=40.0, kind="a", friction=0.84):
    model = models.wedge(kind)
    contacts = find_contacts(model, friction=friction).contacts
    return Problem.build(Model(model, contacts, LoadCase.tilt(model, X, tilt))).statics


def test_blocks_of_corners_are_the_columns_of_the_equilibrium_matrix():
    statics = wedge()
    corner = np.array([1, 4, 5])
    blocks = CornerBlocks(statics, corner)
    direction = np.random.default_rng(0).normal(size=(3, 3))
    built = Triplets(6 * statics.free_count, 3)
    built.add(blocks.freedom, blocks.local, blocks.along(direction))
    force = np.zeros((statics.corner_count, 3))
    for column, (at, along) in enumerate(zip(corner, direction, strict=True)):
        force[:] = 0.0
        force[at] = along
        expected = statics.wrench(force).ravel()
        assert built.csc()[:, [column]].toarray().ravel() == pytest.approx(expected, abs=1e-14)


def test_crossed_blocks_are_the_sum_of_outer_products():
    statics = Problem.build(
        Model((wall := models.wall(3, 3)), find_contacts(wall, friction=0.6).contacts, None)
    ).statics
    corner = np.arange(statics.corner_count)
    blocks = CornerBlocks(statics, corner)
    left, right = blocks.along(NORMAL), blocks.along(np.array([0.3, -1.0, 0.5]))
    size = 6 * statics.free_count
    built = Triplets(size, size)
    built.add(*blocks.crossed(left, right))
    columns = Triplets(size, len(corner)), Triplets(size, len(corner))
    for one, values in zip(columns, (left, right), strict=True):
        one.add(blocks.freedom, blocks.local, values)
    expected = columns[0].csc() @ columns[1].csc().T
    assert abs(built.csc() - expected).max() < 1e-13


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
