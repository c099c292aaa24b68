"""Damaged files of every format; ``python -m benchmarks.fuzz`` does a hundred thousand."""

import pytest

from benchmarks import fuzz


@pytest.mark.parametrize("name", [name for name in fuzz.SHARES if name != "3dm"])
def test_a_damaged_file_gives_a_model_or_one_clear_error(name: str) -> None:
    tally = fuzz.run(60, seed=2026, only=(name,))
    assert tally.failures == []
    assert sum(tally.outcomes.values()) == 60
    assert {kind for _, kind in tally.outcomes} <= {"model", "FormatError", "InputError"}
