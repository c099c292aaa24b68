"""Rest states: the tangent, closed forms on one block, and what the ground carries."""

from dataclasses import replace

import numpy as np
import pytest

from drystone import LoadCase, find_contacts
from drystone.assembly import Assembly
from drystone.mechanics import law
from drystone.mechanics.maps import SparseMaps
from drystone.mechanics.rest import _Path, find_rest
from drystone.mechanics.rest_state import RestOptions
from drystone.model import Model
from drystone.models import arch, box, shelf, tower, wall
from drystone.stability.problem import Problem


def problem_of(assembly, friction, load=None):
    contacts = find_contacts(assembly, friction=friction).contacts
    return Problem.build(Model(assembly, contacts, load))


@pytest.mark.parametrize("model", [arch(0.15, voussoirs=7), shelf(), tower(4)])
def test_assembled_tangent_is_the_product_of_its_factors(model):
    problem = problem_of(model, 0.7)
    statics = problem.statics
    system = SparseMaps(statics.block_a, statics.block_b, statics.length, statics.position)
    system.at(statics.frame, statics.lever_a, statics.lever_b)
    rng = np.random.default_rng(0)
    tangent = rng.normal(size=(statics.corner_count, 3, 3))
    weight = rng.uniform(size=(statics.free_count, 6))
    blocks = system.blocks(tangent, weight)
    n = 6 * statics.free_count
    dense = np.zeros((statics.free_count, 6, statics.free_count, 6))
    dense[system.row, :, system.column, :] = blocks
    matrix = statics.matrix.toarray().reshape(n, -1, 3)
    expected = np.einsum("nki,kij,mkj->nm", matrix, tangent, matrix) + np.diag(weight.ravel())
    assert np.allclose(dense.reshape(n, n), expected, atol=1e-12 * np.abs(expected).max())


def test_newton_tangent_is_the_derivative_of_the_unbalanced_wrench():
    problem = problem_of(arch(0.15, voussoirs=7), 0.5)
    statics = problem.statics
    for springs in (law.uniform(statics), law.uniform(statics, slip=0.7)):
        path = _Path(problem.statics, springs, RestOptions(ground=0.1))
        rng = np.random.default_rng(1)
        motion = rng.normal(size=(statics.free_count, 6))

        def unbalanced(q, path=path):
            gap = statics.displacement(q)[:, 0]
            return path.evaluate(q, path.kn * np.maximum(0.0, -gap), 0.0)

        point = unbalanced(motion)
        step, _, _ = path.step(point, True)
        h = 1e-6 / np.abs(step).max()
        change = (
            unbalanced(motion + h * step).unbalanced - unbalanced(motion - h * step).unbalanced
        ) / (2.0 * h)
        assert np.allclose(change, -point.unbalanced, atol=1e-5 * np.abs(point.unbalanced).max())


def test_a_block_on_the_ground_sinks_by_weight_over_stiffness():
    problem = problem_of(tower(2), 0.5)
    statics = problem.statics
    springs = law.uniform(statics)
    state = find_rest(problem.statics, springs, RestOptions(ground=1e-14))
    assert state.converged
    assert state.motion[0, 2] == pytest.approx(-1.0 / springs.normal.sum(), rel=1e-9)
    assert state.force[:, 0] == pytest.approx(np.full(4, 0.25), rel=1e-9)


def test_a_block_in_the_air_leans_on_the_ground_with_its_whole_weight():
    pair = Assembly(
        (box((1, 1, 1), name="base"), box((1, 1, 1), (0, 0, 3.0), name="floating")),
        np.array([True, False]),
    )
    problem = problem_of(pair, 0.5)
    state = find_rest(problem.statics, law.uniform(problem.statics))
    assert state.converged
    assert state.ground[0] == pytest.approx([0, 0, -1.0, 0, 0, 0], abs=1e-9)


def test_a_warm_start_takes_fewer_steps():
    model = arch(0.15)
    contacts = find_contacts(model, friction=0.9).contacts
    level = Problem.build(Model(model, contacts, None))
    tilted = Problem.build(Model(model, contacts, LoadCase.tilt(model, (0, 1, 0), 0.2)))
    springs = law.uniform(level.statics)
    cold = find_rest(tilted.statics, springs)
    warm = find_rest(tilted.statics, springs, start=find_rest(level.statics, springs))
    assert cold.converged
    assert warm.converged
    assert np.allclose(cold.force, warm.force, atol=1e-8)


def test_stopping_returns_what_is_there():
    problem = problem_of(arch(0.15), 0.9)
    state = find_rest(problem.statics, law.uniform(problem.statics), stop=lambda: True)
    assert not state.converged
    assert state.iterations == 0


def test_newton_steps_on_the_unrelaxed_law_go_on_after_a_first_step_that_makes_it_worse():
    # and no fall is sought on a path that makes progress
    problem, asked = problem_of(wall(10, 10), 0.6), []
    even, uneven = law.samples(problem.statics, 4, 0, tangential=0.2)
    for springs in (*even, *uneven):
        state = find_rest(
            problem.statics, springs, RestOptions(ground=1e-14), falls=lambda: asked.append(1)
        )
        assert state.converged
        assert state.iterations <= 15  # 11 to 15: with another order of elimination one more
    assert not asked


def test_a_path_leads_to_rest_where_all_joints_of_some_blocks_slip():
    # the tangent is almost singular there; the wall rests up to 0.7 of its friction as from 0.5 on
    blocks = wall(20, 8)
    problem = problem_of(blocks, 0.6, LoadCase.tilt(blocks, (0.0, 1.0, 0.0), 16.0))
    state = find_rest(
        problem.statics, law.uniform(problem.statics), RestOptions(ground=1e-7, iteration_limit=60)
    )
    assert state.converged
    assert state.iterations <= 30


def test_a_fall_is_sought_where_the_ground_carries_much():
    blocks, asked = tower(3), []
    problem = problem_of(blocks, 0.6, LoadCase.tilt(blocks, (1.0, 0.0, 0.0), 35.0))

    def falls():
        asked.append(1)
        return True

    springs = law.uniform(problem.statics)
    state = find_rest(problem.statics, springs, RestOptions(ground=1e-7), falls=falls)
    assert len(asked) == 1
    assert not state.converged
    assert state.iterations <= 12


def test_no_fall_is_sought_where_a_high_tower_leans_on_the_ground():
    problem, asked = problem_of(tower(400), 0.6), []
    springs = law.uniform(problem.statics)
    state = find_rest(
        problem.statics, springs, RestOptions(ground=1e-7), falls=lambda: bool(asked.append(1))
    )
    assert state.converged
    assert problem.ground_share(state.ground).max() > 1e-3
    assert not asked


@pytest.mark.parametrize(("degrees", "rests"), [(0.0, True), (8.0, True), (30.0, False)])
def test_the_last_state_is_looked_for_at_once_where_the_ground_carries_little(degrees, rests):
    model = arch()
    problem = problem_of(model, 0.93, LoadCase.tilt(model, (0.0, 1.0, 0.0), degrees))
    springs = law.uniform(problem.statics)
    strong, weak = RestOptions(ground=1e-7, tolerance=1e-7), RestOptions(ground=1e-14)
    twice = find_rest(problem.statics, springs, strong)
    once = find_rest(problem.statics, springs, replace(strong, end=weak))
    assert once.ended is rests
    assert not twice.ended
    if rests:
        last = find_rest(problem.statics, springs, weak, start=twice)
        assert once.unbalanced <= weak.tolerance
        assert np.abs(once.ground).max() < 1e-9
        assert once.iterations <= twice.iterations + last.iterations
        np.testing.assert_allclose(once.force, last.force, atol=1e-7 * np.abs(last.force).max())
    else:
        # a first motion on the given ground, as without the other options
        assert problem.ground_share(once.ground).max() > 0.1
        np.testing.assert_allclose(once.motion, twice.motion, rtol=1e-5, atol=1e-5)
