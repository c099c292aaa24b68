"""The verdict, begun at the rest states of a similar model."""

import numpy as np
import pytest

from drystone import CheckOptions, LoadCase, Model, Verdict, check
from drystone.checks import check_forces
from drystone.models import arch, tower, wedge

X = (1.0, 0.0, 0.0)


def test_a_neighbouring_verdict_is_found_in_fewer_steps():
    model = Model.of(arch(0.2, 9), friction=0.8)
    tilted = model.with_load(LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), 0.2))
    cold, warm = check(tilted), check(tilted, start=check(model).displacement)
    assert warm.message == cold.message == "stands"
    assert warm.iterations <= 0.5 * cold.iterations
    assert check_forces(tilted, warm.force, warm.displacement).largest <= 1e-8
    np.testing.assert_allclose(warm.force, cold.force, atol=1e-6 * abs(warm.force).max())


@pytest.mark.parametrize("degrees", [0.0, 40.0])
def test_a_wrong_start_does_not_change_the_verdict(degrees):
    load = LoadCase.tilt(tower(3), X, degrees)
    model = Model.of(tower(3), friction=0.6, load=load)
    wrong = np.random.default_rng(0).standard_normal((3, 6))
    found, cold = check(model, start=wrong), check(model)
    assert (found.verdict, found.falling) == (cold.verdict, cold.falling)


@pytest.mark.parametrize(("degrees", "verdict"), [(40.0, Verdict.UNSTABLE), (10.0, Verdict.STABLE)])
def test_uniform_stiffness_can_be_demanded(degrees, verdict):
    # at 40 degrees the wedge comes to rest after settling only
    assembly = wedge("c", longer=0.2)
    load = LoadCase.tilt(assembly, X, degrees)
    model = Model.of(assembly, friction=0.84, load=load)
    assert check(model).stable
    found = check(model, options=CheckOptions(uniform=True))
    assert found.verdict is verdict
    assert found.options.uniform


def test_without_friction_one_stiffness_decides():
    found = check(Model.of(tower(3), friction=0.0))
    assert found.message == "stands"
    assert found.samples.tried == 1
