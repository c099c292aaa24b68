"""Other contact stiffnesses begin with the forces of a rest state."""

import numpy as np
import pytest

from drystone import CheckOptions, LoadCase, find_contacts, models
from drystone.formulations.rest import compliance
from drystone.formulations.rest.compliance import Compliance
from drystone.formulations.rest.friction import MOBILISED, FrictionBound, SlipLength, StickSlip
from drystone.formulations.rest.interior_point import find_rest
from drystone.formulations.rest.nearby import find_rest_nearby
from drystone.formulations.rest.rest_state import RestOptions
from drystone.formulations.rest.same_forces import sliding_share, start_of_forces, unbalanced_share
from drystone.model import Model
from drystone.stability import check
from drystone.stability.problem import Problem

OPTIONS = RestOptions(ground=1e-14)
ARCH = models.arch()
LEANING = Model(
    ARCH,
    find_contacts(ARCH, friction=0.93).contacts,
    LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 8.0),
)


def test_a_slide_and_its_force_belong_together():
    rng = np.random.default_rng(3)
    normal, slide = rng.uniform(0.5, 2.0, 40), rng.normal(size=(40, 2))
    bound = FrictionBound(np.full(40, 0.6))
    smooth = SlipLength(bound, np.full(40, 2.0))
    force = smooth(normal, slide).force
    mobilised = np.linalg.norm(force, axis=1) / bound(normal)
    found = smooth.slide_of(normal, force, slide)
    below = mobilised < MOBILISED
    assert 5 < below.sum() < 40
    assert np.allclose(found[below], slide[below])
    held = np.linalg.norm(smooth(normal, found).force, axis=1)
    assert np.allclose(held, np.minimum(mobilised, MOBILISED) * bound(normal))
    sharp = StickSlip(bound, np.full(40, 0.5))
    force = sharp(normal, slide).force
    assert np.allclose(sharp.slide_of(normal, force, slide), slide)


@pytest.mark.parametrize("number", range(4))
def test_every_sample_is_near_the_forces_of_the_uniform_one(number):
    problem = Problem.build(LEANING)
    statics, system = problem.statics, problem.system
    path = find_rest(system, compliance.uniform(statics), OPTIONS).before
    assert path is not None
    springs = list(compliance.samples(statics, 4, 0, tangential=0.1))[number]
    start, steps, share = start_of_forces(system, springs, OPTIONS, path)
    assert share == unbalanced_share(system, springs, statics.displacement(start.motion))
    assert share < unbalanced_share(system, springs, statics.displacement(path.motion)) < np.inf
    found = find_rest_nearby(system, springs, OPTIONS, start)
    assert found is not None
    assert found.unbalanced <= OPTIONS.tolerance
    assert steps + found.iterations < find_rest(system, springs, OPTIONS).iterations


def test_all_stiffnesses_cost_little_more_than_one():
    alone = check(LEANING, options=CheckOptions(samples=0, settle=False))
    whole = check(LEANING, options=CheckOptions.robust())
    assert (whole.samples.tried, whole.samples.standing) == (5, 5)
    assert whole.iterations <= 5.0 * alone.iterations


def test_the_share_of_the_force_at_corners_that_slide():
    bound = FrictionBound(np.full(3, 0.5))
    moved = np.array([[-1.0, 0.0, 6.0], [-3.0, 6.0, 0.0], [1.0, 8.0, 0.0]])
    sharp = Compliance(np.ones(3), StickSlip(bound, np.full(3, 0.1)))
    assert sliding_share(sharp, moved) == 0.25
    assert sliding_share(Compliance(np.ones(3), SlipLength(bound, np.ones(3))), 0.0 * moved) == 1.0


def test_where_few_corners_slide_other_springs_begin_at_the_rest_state():
    thick = models.arch(0.2)
    load = LoadCase.tilt(thick, (0.0, 1.0, 0.0), 2.0)
    model = Model(thick, find_contacts(thick, friction=0.93).contacts, load)
    alone, whole = (check(model, options=CheckOptions(samples=n, settle=False)) for n in (0, 1))
    assert whole.samples.standing == 2
    assert whole.iterations <= alone.iterations + 2
