"""Degenerate assemblies that ended in a fault or in a contradiction once."""

import pytest

from benchmarks.degenerate import Tally, one


@pytest.mark.parametrize("number", [430, 932, 1569, 1691, 3059])
def test_they_end_in_an_answer_that_rbe_does_not_contradict(number: int) -> None:
    tally = Tally()
    one(number, 48, tally)
    assert tally.failures == []
