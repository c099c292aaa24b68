"""The checks of one value of a limit."""

import pytest

from drystone import LoadCase, Model, Verdict, check
from drystone.limits.limit_checks import RestStates, every_stiffness, verdict
from drystone.models import wedge
from drystone.settlement import Outcome


def tilted(kind: str, angle: float, longer: float = 0.0) -> Model:
    block = wedge(kind, longer=longer)
    return Model.of(block, friction=0.84, load=LoadCase.tilt(block, (1.0, 0.0, 0.0), angle))


def test_a_robust_check_ends_at_the_first_stiffness_that_does_not_hold() -> None:
    stands, decides, falls = (tilted("b", angle, 0.2) for angle in (20.0, 55.0, 59.5))
    found, whole = every_stiffness(stands), check(stands)
    assert found.verdict is whole.verdict is Verdict.STABLE
    assert found.samples == whole.samples
    for model in (decides, falls):
        found = every_stiffness(model)
        assert found.verdict is Verdict.UNDECIDED
        assert found.samples.tried < 5
        assert found.settlement is None


def test_a_robust_check_begins_at_the_rest_states_of_the_last_model_that_stood() -> None:
    first, second, falls = (tilted("b", angle, 0.2) for angle in (20.0, 20.5, 59.5))
    near = RestStates()
    assert every_stiffness(first, near=near).stable
    assert set(near.displacement) == {0, 1, 2, 3, 4}
    found, alone = every_stiffness(second, near=near), every_stiffness(second)
    assert found.verdict is alone.verdict is Verdict.STABLE
    assert found.samples == alone.samples
    assert found.iterations < alone.iterations
    kept = near.displacement
    assert every_stiffness(falls, near=near).verdict is Verdict.UNDECIDED
    assert near.displacement is kept
    assert verdict(falls, near=near).verdict is Verdict.UNSTABLE


def test_a_robust_check_keeps_the_proof_that_no_forces_balance_the_loads() -> None:
    found = every_stiffness(tilted("c", 47.5))
    assert found.verdict is Verdict.UNSTABLE
    assert found.mechanism is not None


@pytest.mark.parametrize("angle", [20.0, 55.0, 59.5])
def test_the_verdict_is_that_of_the_check(angle: float) -> None:
    model = tilted("b", angle, 0.2)
    found, whole = verdict(model), check(model)
    assert found.verdict is whole.verdict
    assert (found.mechanism is None) is (whole.mechanism is None)
    assert found.samples.tried <= whole.samples.tried


def test_the_verdict_tries_no_stiffness_after_one_that_does_not_hold() -> None:
    model = tilted("b", 41.0, 0.2)
    found, whole = verdict(model), check(model)
    assert found.verdict is whole.verdict is Verdict.STABLE
    assert found.settlement.outcome is Outcome.RESTS
    assert found.settlement.travel == whole.settlement.travel
    assert found.samples.standing == found.samples.tried - 1
    assert found.samples.tried < whole.samples.tried
