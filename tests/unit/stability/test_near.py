"""The verdict, begun at the rest states of a similar model."""

import numpy as np
import pytest

from drystone import Assembly, CheckOptions, LoadCase, Model, Verdict, check
from drystone.checks import check_forces
from drystone.models import arch, tower, wedge
from drystone.reproduce.cases import niche
from drystone.stability import check_near

X = (1.0, 0.0, 0.0)


def test_a_neighbouring_verdict_is_found_in_fewer_steps():
    model = Model.of(arch(0.2, 9), friction=0.8)
    cold, rests = check_near(model, {}, options=CheckOptions())
    assert sorted(rests) == [0, 1, 2, 3, 4]
    tilted = model.with_load(LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), 0.2))
    warm, _ = check_near(tilted, rests, options=CheckOptions())
    assert (
        warm.message
        == cold.message
        == "stands, whichever joints press more (5 contact stiffnesses tried)"
    )
    assert warm.iterations <= 2 * len(rests)
    assert warm.iterations <= 0.5 * check(tilted).iterations
    assert check_forces(tilted, warm.force, warm.displacement).largest <= 1e-8
    np.testing.assert_allclose(warm.force, check(tilted).force, atol=1e-6 * abs(warm.force).max())


@pytest.mark.parametrize("degrees", [0.0, 40.0])
def test_a_wrong_start_does_not_change_the_verdict(degrees):
    load = LoadCase.tilt(tower(3), X, degrees)
    model = Model.of(tower(3), friction=0.6, load=load)
    rng = np.random.default_rng(0)
    wrong = {number: rng.standard_normal((3, 6)) for number in range(5)}
    found, _ = check_near(model, wrong, options=CheckOptions())
    cold = check(model)
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


def test_a_part_whose_joints_keep_their_stiffness_is_near_the_whole():
    built = niche(0.3)  # turned round: the last block is the first, and all interfaces move up
    whole = Model.of(Assembly(built.blocks[::-1], built.fixed[::-1]), friction=0.6)
    _, rests = check_near(whole, {}, options=CheckOptions())
    out = whole.assembly.index("c04-b00")
    kept = np.arange(len(whole.assembly)) != out
    number = np.cumsum(whole.active) - 1
    joins = (whole.contacts.block_a != out) & (whole.contacts.block_b != out)
    part, known = whole.without([out]), {number: one[kept] for number, one in rests.items()}
    steps = [
        check_near(part, known, options=CheckOptions(), within=within)[0].iterations
        for within in (None, (number[joins], int(whole.active.sum())))
    ]
    assert steps[1] < 0.8 * steps[0]
