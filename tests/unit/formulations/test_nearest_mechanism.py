"""The mechanism nearest to free fall, and the cones of its iteration."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.workloads import random_pile, voronoi_stones
from drystone import Assembly, LoadCase, Model, check, find_contacts
from drystone.checks import check_forces, mechanism_defects
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import STILL, held_still, solve_equilibrium
from drystone.formulations.nearest_mechanism import (
    NearestMechanism,
    Scaling,
    inner,
    nearest_mechanism,
    product,
    quotient,
    step_lengths,
)
from drystone.models import arch, barrel_vault, box, shelf, tower
from drystone.solvers.program import ConicStatus
from drystone.stability.problem import Problem, balanced, checked_mechanism, sound_mechanism


def answer(model: Model) -> tuple[Problem, NearestMechanism]:
    problem = Problem.build(model)
    return problem, nearest_mechanism(problem.statics)


def tilted(assembly: Assembly, friction: float, degrees: float) -> Model:
    contacts = find_contacts(assembly, friction=friction).contacts
    return Model(assembly, contacts, LoadCase.tilt(assembly, (0.0, 1.0, 0.0), degrees))


def points(rng: np.random.Generator, count: int = 200) -> np.ndarray:
    """Inside the cones, some very near to their boundary."""
    across = rng.normal(size=(count, 2)) * 10.0 ** rng.uniform(-3.0, 3.0, (count, 1))
    margin = 10.0 ** rng.uniform(-6.0, 1.0, count)
    first = np.hypot(across[:, 0], across[:, 1]) * (1.0 + margin)
    return np.column_stack([first, across])


@pytest.mark.parametrize("degrees", [35.0, 40.0, 60.0])
def test_a_flat_block_slides_with_the_part_of_gravity_beyond_the_angle_of_friction(
    degrees: float,
) -> None:
    """Free fall projected onto the edge of the cone: ``g sin(slope - angle of friction)``."""
    friction = 0.6
    ground = box((4.0, 4.0, 1.0), (-2.0, -2.0, -1.0), name="ground")
    plate = box((1.0, 1.0, 0.01), (-0.5, -0.5, 0.0), name="plate")
    assembly = Assembly((ground, plate), np.array([True, False]))
    _, found = answer(tilted(assembly, friction, degrees))
    assert found.motion is not None
    beyond = np.deg2rad(degrees) - np.arctan(friction)
    assert np.linalg.norm(found.motion[0, :3]) == pytest.approx(np.sin(beyond), rel=1e-2)


def test_below_the_angle_of_friction_forces_balance_the_block() -> None:
    problem, found = answer(tilted(tower(3), 0.6, 10.0))
    assert found.motion is None
    assert balanced(problem, found.force)


def test_forces_out_of_balance_or_not_finite_are_no_equilibrium() -> None:
    problem, found = answer(tilted(tower(3), 0.6, 10.0))
    assert not balanced(problem, 1.01 * found.force)
    assert not balanced(problem, np.full_like(found.force, np.nan))


@pytest.mark.parametrize(("degrees", "falls"), [(8.0, False), (8.4, True)])
def test_an_arch_falls_just_beyond_its_limit(degrees: float, falls: bool) -> None:
    problem, found = answer(tilted(arch(), float(np.tan(np.deg2rad(43.0))), degrees))
    assert (found.motion is not None) is falls
    assert balanced(problem, found.force) is not falls


def test_a_mechanism_is_found_sooner_on_the_way_to_one_with_less_friction() -> None:
    vault = Model.of(barrel_vault(courses=9, blocks=4), friction=0.05)
    _, less = answer(vault)
    problem, alone = answer(vault.with_friction(0.1))
    after = nearest_mechanism(problem.statics, after=less)
    assert after.motion is not None
    assert sound_mechanism(problem, after.motion) is not None
    assert after.iterations < alone.iterations


def test_random_piles_get_the_answer_of_the_conic_solver() -> None:
    decided = 0
    for seed in range(12):
        problem, found = answer(random_pile(seed))
        solved = solve_equilibrium(problem.statics, cone=FrictionCone.exact())
        if found.motion is None:
            assert solved.raw.status is ConicStatus.SOLVED
            decided += balanced(problem, found.force)
        else:
            assert checked_mechanism(problem, solved) is not None
            decided += sound_mechanism(problem, found.motion) is not None
    assert decided == 12


def test_blocks_that_stand_take_no_part_in_the_mechanism_of_others() -> None:
    """The upper cube of two topples; a tower beside it stands."""
    places = ((1.5, 0.0), (1.5, 1.0), (-1.5, 0.0), (-2.1, 1.0))
    cubes = [
        box((1.0, 1.0, 1.0), (x, -0.5, z), name=f"cube-{number}")
        for number, (x, z) in enumerate(places)
    ]
    ground = box((6.0, 4.0, 1.0), (-3.0, -2.0, -1.0), name="ground")
    assembly = Assembly((ground, *cubes), np.arange(5) == 0)
    problem, found = answer(Model.of(assembly, friction=0.6))
    assert found.motion is not None
    speed = np.abs(found.motion).max(axis=1)
    assert (speed[:3] < 1e-5 * speed[3]).all()
    motion = sound_mechanism(problem, found.motion)
    assert motion is not None
    assert mechanism_defects(problem.model, motion)[0] < 1e-6


def test_props_against_a_mechanism_and_its_forces_balance_the_loads() -> None:
    """A fall that is proved before the rest state on ground springs has converged."""
    model = random_pile(5)
    found = check(model)
    assert found.falls
    assert found.force_with_props is not None
    left = check_forces(model, found.force_with_props, prop=found.prop)
    assert max(left.equilibrium, left.tension, left.cone) < 1e-9


def test_a_vault_with_sparse_fronts_gets_a_sound_mechanism() -> None:
    vault = barrel_vault(courses=15, blocks=6, length=4.0)
    problem, found = answer(tilted(vault, 0.6, 20.8))
    assert found.motion is not None
    assert sound_mechanism(problem, found.motion) is not None


def test_a_request_to_stop_ends_the_iteration_at_once() -> None:
    problem = Problem.build(random_pile(0))
    assert nearest_mechanism(problem.statics, stop=lambda: True).iterations == 0


def test_the_scaling_takes_a_point_and_its_dual_to_one_point() -> None:
    rng = np.random.default_rng(1)
    x, z = points(rng), points(rng)
    scaling = Scaling.of(x, z)
    size = np.abs(scaling.apply(x)).max(axis=1, keepdims=True)
    np.testing.assert_allclose(scaling.apply(x) / size, scaling.undo(z) / size, atol=1e-5)
    y = rng.normal(size=x.shape)
    np.testing.assert_allclose(scaling.undo(scaling.apply(y)), y, rtol=1e-4, atol=1e-4)


def test_the_tangent_is_the_inverse_of_the_squared_scaling_and_the_softness() -> None:
    rng = np.random.default_rng(2)
    x, z = (np.abs(rng.normal(size=(50, 1))) * (1.0, 0.3, -0.5) + (0.1, 0.0, 0.0) for _ in "xz")
    scaling, soft, y = Scaling.of(x, z), rng.uniform(0.0, 1.0, 50), rng.normal(size=x.shape)
    back = scaling.apply(scaling.apply(y)) + soft[:, None] * y
    np.testing.assert_allclose((scaling.tangent(soft) @ back[:, :, None])[:, :, 0], y, rtol=1e-9)


def test_the_quotient_undoes_the_jordan_product() -> None:
    rng = np.random.default_rng(3)
    x = np.column_stack([rng.uniform(2.0, 3.0, 50), rng.uniform(-1.0, 1.0, (50, 2))])
    y = rng.normal(size=x.shape)
    np.testing.assert_allclose(quotient(x, product(x, y)), y, rtol=1e-9)


def test_the_longest_step_ends_at_the_boundary_of_a_cone() -> None:
    rng = np.random.default_rng(4)
    for _ in range(200):
        x = points(rng, 3)
        step = rng.normal(size=x.shape) * np.abs(x).max()
        length = step_lengths(x, step).min()
        size = np.abs(x + length * step).max() + np.abs(x).max()
        assert inner(x + 0.999 * length * step).min() > -1e-12 * size
        if length < 1.0:
            assert inner(x + 1.001 * length * step).min() < 1e-12 * size


def test_a_step_through_the_apex_is_cut_there() -> None:
    x = np.array([[1.0, 0.6, 0.3]])
    assert step_lengths(x, -2.0 * x)[0] == pytest.approx(0.5)


@pytest.mark.parametrize("build", [shelf, arch])
def test_forces_that_nearly_balance_the_loads_are_changed_until_they_do(
    build: Callable[[], Assembly],
) -> None:
    """Without this the iteration takes ten steps more, in which it only comes to rest."""
    problem, found = answer(tilted(build(), 0.9, 0.0))
    assert found.motion is None
    assert found.iterations <= 6
    assert balanced(problem, found.force)


def test_corners_that_hardly_move_are_held_still_and_the_others_keep_their_motion() -> None:
    statics = Problem.build(tilted(arch(), 0.9, 8.4)).statics
    exact = np.zeros((statics.free_count, 6))
    exact[-1] = 1.0
    motion = exact + 1e-6 * np.random.default_rng(1).normal(size=exact.shape)
    solution = solve_equilibrium(statics, cone=FrictionCone.exact())
    given = replace(solution, multiplier=motion)
    held = held_still(statics, given).multiplier
    moved = np.abs(statics.displacement(motion)).max(axis=1)
    still = moved < STILL * moved.max()
    assert still.any()
    assert np.abs(statics.displacement(held)[still]).max() < 1e-12
    assert held == pytest.approx(motion, abs=1e-5)


@pytest.mark.parametrize(("count", "seed", "friction"), [(60, 4, 0.6), (150, 2, 0.5)])
def test_the_fastest_of_irregular_stones_fall_while_the_others_slowly_come_to_rest(
    count: int, seed: int, friction: float
) -> None:
    model = Model.of(voronoi_stones(count, seed), friction=friction)
    problem, found = answer(model)
    assert found.motion is not None
    motion = sound_mechanism(problem, found.motion)
    assert motion is not None
    violation, power = mechanism_defects(model, motion)
    assert violation <= 1e-5
    assert power > 0.1
