"""What a result says of itself."""

import pytest

import drystone
from drystone import Model, Result, Verdict
from drystone.models import tower

MODEL = Model.of(tower(3))


@pytest.mark.parametrize("verdict", list(Verdict))
def test_it_is_stable_or_falls_where_that_was_shown(verdict: Verdict) -> None:
    result = Result("check", verdict, MODEL)
    assert result.stable is (verdict is Verdict.STABLE)
    assert result.falls is (verdict is Verdict.UNSTABLE)


def test_it_is_neither_true_nor_false() -> None:
    with pytest.raises(TypeError, match=r"ask for \.stable"):
        assert Result("check", Verdict.STABLE, MODEL)


def test_resultants_are_found_once_and_cannot_be_changed() -> None:
    result = drystone.check(MODEL)
    assert result.resultants is result.resultants
    assert result.utilisation is result.utilisation
    with pytest.raises(ValueError, match="read-only"):
        result.resultants.normal[0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        result.utilisation[0] = 0.0
