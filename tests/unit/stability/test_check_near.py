"""Checks that begin at the rest states of a similar model prove as much as those from nothing."""

from dataclasses import replace

import numpy as np
import pytest

from drystone.model import Model
from drystone.models import bridge, leaning_column
from drystone.sequence.stage.stage_checks import BOTH
from drystone.sequence.stage.stages import Stage, mask_of
from drystone.sequence.stage.structure import Structure
from drystone.settlement import SettlementOptions
from drystone.stability import check, check_near, try_rest
from drystone.stability.cascade import NONE_FOUND
from drystone.stability.problem import Problem
from drystone.stability.screening import QUICK, SMOOTH

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
    assert list(rests) == [0, 1, HARD]
    assert not len(rests[HARD])


def test_a_stiffness_is_looked_for_again_where_following_the_blocks_does_not_decide():
    near = known(LEANING)
    hurried = replace(BOTH, settlement=SettlementOptions(fall=0.05, step_limit=1))
    found, rests = check_near(LEANING, {0: near[0], HARD: NONE_FOUND}, options=hurried)
    assert found.stable
    assert found.samples.standing == found.samples.tried == 5
    assert all(len(motion) for motion in rests.values())


def test_a_problem_may_be_given_in_place_of_its_model():
    problem = Problem.build(LEANING)
    assert try_rest(problem).stable
    assert check_near(problem, {}, options=BOTH)[0].stable
