"""From one rest state to the next, without the relaxed law."""

import numpy as np
import pytest

from drystone import LoadCase, find_contacts, models
from drystone.mechanics import maps
from drystone.mechanics.law import samples, uniform
from drystone.mechanics.maps import SparseMaps
from drystone.mechanics.nearby import find_rest_nearby, with_forces
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions, Start
from drystone.model import Model
from drystone.stability.problem import Problem

ARCH = models.arch(0.15)
JOINTS = find_contacts(ARCH, friction=0.9).contacts
OPTIONS = RestOptions(ground=1e-14)


def leaning(degrees):
    return Problem.build(Model(ARCH, JOINTS, LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), degrees)))


def upright(problem, slip, glue):
    springs = uniform(problem.statics, slip=slip, glue=glue)
    state = find_rest(problem.statics, springs, OPTIONS)
    assert state.converged
    return springs, Start(state.motion, state.normal)


@pytest.mark.parametrize("slip", [None, 10.0])
@pytest.mark.parametrize("glue", [0.0, 1e-3])
def test_the_state_is_that_of_the_relaxed_law(slip, glue):
    _, start = upright(leaning(0.0), slip, glue)
    problem = leaning(1.0)
    springs = uniform(problem.statics, slip=slip, glue=glue)
    found = find_rest_nearby(problem.statics, springs, OPTIONS, start)
    relaxed = find_rest(problem.statics, springs, OPTIONS)
    assert found is not None
    assert found.unbalanced <= OPTIONS.tolerance
    assert np.allclose(found.force, relaxed.force, rtol=0.0, atol=1e-8)
    assert np.allclose(found.tension, relaxed.tension, rtol=0.0, atol=1e-8)


def test_a_rest_state_is_next_to_itself():
    springs, start = upright(leaning(0.0), None, 0.0)
    found = find_rest_nearby(leaning(0.0).statics, springs, OPTIONS, start)
    assert found is not None
    assert found.iterations == 0


def test_what_falls_has_no_rest_state_nearby():
    springs, start = upright(leaning(0.0), None, 0.0)
    assert not find_rest_nearby(leaning(20.0).statics, springs, OPTIONS, start).converged


def test_a_random_stiffness_is_reached_from_the_uniform_one_of_a_leaning_wall():
    wall = models.wall(8, 6)
    load = LoadCase.tilt(wall, (0.0, 1.0, 0.0), 20.0)
    statics = Problem.build(Model.of(wall, friction=0.6, load=load)).statics
    rest = find_rest(statics, uniform(statics), OPTIONS)
    assert rest.converged
    _, (springs,) = samples(statics, 2, 0, tangential=0.5)
    start = with_forces(statics, springs, OPTIONS, rest.force, rest.motion)
    assert find_rest_nearby(statics, springs, OPTIONS, start).converged


def test_what_rests_with_other_springs_as_well_takes_no_step(monkeypatch):
    wall = models.wall(8, 6)
    statics = Problem.build(Model.of(wall, friction=0.6)).statics
    rest = find_rest(statics, uniform(statics), OPTIONS)
    monkeypatch.setattr(SparseMaps, "factorise", None)
    start = with_forces(statics, uniform(statics, slip=10.0), OPTIONS, rest.force, rest.motion)
    assert np.array_equal(start.motion, rest.motion)


def test_the_wish_to_stop_is_heard():
    springs, start = upright(leaning(0.0), None, 0.0)
    stopped = find_rest_nearby(leaning(1.0).statics, springs, OPTIONS, start, lambda: True)
    assert not stopped.converged


def test_the_last_steps_have_the_factors_of_the_one_before(monkeypatch):
    factors = []
    factorise = SparseMaps.factorise

    def counted(maps, tangent, weight, **options):
        factors.append(tangent)
        return factorise(maps, tangent, weight, **options)

    monkeypatch.setattr(SparseMaps, "factorise", counted)
    _, start = upright(leaning(0.0), 10.0, 0.0)
    problem = leaning(1.0)
    springs = uniform(problem.statics, slip=10.0)
    factors.clear()
    found = find_rest_nearby(problem.statics, springs, OPTIONS, start)
    assert found is not None
    assert 0 < len(factors) < found.iterations
    assert found.unbalanced <= OPTIONS.tolerance


def test_rough_steps_end_at_the_same_state(monkeypatch):
    _, start = upright(leaning(0.0), 10.0, 0.0)
    problem = leaning(1.0)
    springs = uniform(problem.statics, slip=10.0)
    expected = find_rest_nearby(problem.statics, springs, OPTIONS, start)
    monkeypatch.setattr(maps, "SINGLE_FROM", 1)
    problem = leaning(1.0)
    found = find_rest_nearby(problem.statics, springs, OPTIONS, start)
    assert expected is not None
    assert found is not None
    assert found.unbalanced <= OPTIONS.tolerance
    assert np.allclose(found.force, expected.force, rtol=0.0, atol=1e-8)
