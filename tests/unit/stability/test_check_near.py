"""Checks that begin at the rest states of a similar model prove as much as those from nothing."""

from dataclasses import replace

import numpy as np
import pytest

from drystone.base.progress import Clock
from drystone.formulations.rest.compliance import samples, uniform
from drystone.model import Model
from drystone.models import bridge, leaning_column
from drystone.sequence.stages import BOTH, Stage, mask_of
from drystone.sequence.structure import Structure
from drystone.settlement import SettlementOptions
from drystone.stability import check, check_near, try_rest
from drystone.stability.attempts import Attempts
from drystone.stability.problem import Problem
from drystone.stability.screening import QUICK, SMOOTH
from drystone.stability.stiffness_samples import NONE_FOUND, several_nearby
from drystone.stability.verdict.each_stiffness import SLIDES_FAR
from drystone.stability.verdict.following import FOLLOWED, SETTLES_ALIKE

LEANING = Model.of(leaning_column(), friction=0.6)
HARD = 2
"""A sample that is not found at once from the uniform stiffness."""


def known(model: Model) -> dict[int, np.ndarray]:
    return check_near(model, {}, options=BOTH)[1]


def test_a_rest_state_of_the_smooth_law_proves_where_stick_slip_finds_none():
    structure = Structure(Model.of(bridge(), friction=0.6))
    free = structure.assembly.free.tolist()
    for placed, *_ in structure.parts(Stage(mask_of(free[:6]))):  # both arms, without the middle
        assert not structure.solve(Stage(placed, 0, QUICK)).stands
        near = structure.solve(Stage(placed, 0, SMOOTH))
        found = structure.solve(Stage(placed), {0: whole(structure, placed, near.rests[0])})
        cold = structure.solve(Stage(placed))
        assert found.verdict is cold.verdict
        assert found.message == cold.message


def whole(structure: Structure, placed: int, motion: np.ndarray) -> np.ndarray:
    out = np.zeros((len(structure.assembly), 6))
    out[[b for b in range(len(out)) if placed >> b & 1]] = motion
    return out


@pytest.mark.parametrize("friction", [0.1, 0.6])
def test_a_wrong_rest_state_proves_nothing(friction):
    model = Model.of(leaning_column(), friction=friction)
    rng = np.random.default_rng(0)
    wrong = {number: rng.normal(size=(len(model.assembly), 6)) for number in range(5)}
    found, rests = check_near(model, wrong, options=BOTH)
    assert found.verdict is check(model).verdict
    assert bool(rests) is (friction == 0.6)


def test_blocks_are_followed_where_a_stiffness_is_looked_for_briefly():
    near = known(LEANING)
    found, rests = check_near(LEANING, {0: near[0], HARD: NONE_FOUND}, options=BOTH)
    assert found.stable
    assert found.settlement is not None
    assert list(rests) == [0, 1, HARD, FOLLOWED]
    assert not len(rests[HARD])
    assert rests[FOLLOWED] is rests[1]


def test_blocks_that_slide_on_a_way_that_was_followed_to_rest_are_not_followed_again():
    near = known(LEANING)
    doubted = {0: near[0], HARD: NONE_FOUND}
    followed, rests = check_near(LEANING, doubted, options=BOTH)
    again, kept = check_near(LEANING, {**doubted, FOLLOWED: 0.5 * rests[FOLLOWED]}, options=BOTH)
    assert followed.settlement is not None
    assert again.settlement is None
    assert again.verdict is followed.verdict
    assert again.message.startswith(SETTLES_ALIKE)
    assert again.samples.standing < again.samples.tried
    np.testing.assert_array_equal(kept[FOLLOWED], 0.5 * rests[FOLLOWED])


def test_blocks_that_slide_off_the_way_that_was_followed_are_followed():
    problem, near = Problem.build(LEANING), known(LEANING)

    def across(times):
        """As pressed as before, slid across."""
        motion = np.array(near[1])
        motion[problem.statics.free, 1] += times * np.abs(near[1]).max()
        return motion

    slide = problem.slide_by_overlap(across(100.0))
    assert slide > SLIDES_FAR
    assert problem.slide_beyond(near[1], near[1]) == pytest.approx(0.0, abs=1e-9)
    assert problem.slide_beyond(0.3 * near[1], 2.0 * near[1]) == pytest.approx(0.0, abs=1e-9)
    assert problem.slide_beyond(across(100.0), near[1]) > SLIDES_FAR
    # shorter or little longer on the same way, and much longer
    for times in (50.0, 105.0):
        assert problem.slide_beyond(across(times), across(100.0)) < 0.02 * slide
    assert problem.slide_beyond(across(150.0), across(100.0)) > 0.3 * slide
    # of a block that was not there, all of its slide counts
    assert problem.slide_beyond(across(100.0), np.zeros_like(near[1])) == slide


def test_a_stiffness_is_looked_for_again_where_following_the_blocks_does_not_decide():
    near = known(LEANING)
    hurried = replace(BOTH, settlement=SettlementOptions(fall=0.05, step_limit=1))
    found, rests = check_near(LEANING, {0: near[0], HARD: NONE_FOUND}, options=hurried)
    assert found.stable
    assert found.samples.standing == found.samples.tried == 5
    assert all(len(motion) for motion in rests.values())


def test_several_stiffnesses_at_once_are_those_one_by_one():
    problem = Problem.build(LEANING)
    rests = known(LEANING)
    springs = list(samples(problem.statics, 4, 0, tangential=0.2))
    near = [*(1.01 * rests[i] for i in (1, 2, 3)), np.ones_like(rests[0])]
    tries = Attempts(problem, Clock(np.inf))
    together = several_nearby(tries, springs, near)
    alone = [
        tries.nearby(one, tries.start(one, motion))
        for one, motion in zip(springs, near, strict=True)
    ]
    assert [one is None for one in together] == [one is None for one in alone]
    assert 0 < sum(one is not None for one in together) < 4
    for one, other in zip(together, alone, strict=True):
        if one is not None and other is not None:
            scale = np.abs(other.force).max()
            np.testing.assert_allclose(one.force, other.force, atol=1e-8 * scale)
            assert one.residuals.largest < 1e-8


def test_a_rest_state_that_is_known_is_not_looked_for_again():
    near, problem = known(LEANING), Problem.build(LEANING)
    tries = Attempts(problem, Clock(np.inf))
    springs = uniform(problem.statics)
    rest = tries.nearby(springs, tries.start(springs, 1.01 * near[0]))
    found, rests = check_near(problem, {}, options=BOTH, rest=rest)
    without, _ = check_near(problem, {}, options=BOTH)
    assert rest is not None
    assert rests[0] is rest.displacement
    assert found.stable
    assert found.samples == without.samples
    assert found.iterations < without.iterations


def test_a_problem_may_be_given_in_place_of_its_model():
    problem = Problem.build(LEANING)
    assert try_rest(problem).stable
    assert check_near(problem, {}, options=BOTH)[0].stable
