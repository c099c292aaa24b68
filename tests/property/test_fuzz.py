"""Damaged files of every format; ``python -m benchmarks.fuzz`` does a hundred thousand."""

from pathlib import Path

import pytest

from benchmarks import fuzz, side_files
from drystone import io


@pytest.mark.parametrize("name", fuzz.SHARES)
def test_a_file_that_is_not_damaged_is_read(tmp_path: Path, name: str) -> None:
    for data in fuzz.samples().get(name, []):
        assert io.read_file(fuzz.file_of(name, data, tmp_path)).assembly


@pytest.mark.parametrize("name", sorted(fuzz.SHARES))
def test_a_damaged_file_gives_a_model_or_one_clear_error(name: str) -> None:
    if name not in fuzz.samples():
        pytest.skip(f"{fuzz.OUTSIDE[name]} is not installed")
    count = 8 if name in fuzz.OUTSIDE else 60  # a fork for each takes a fifth of a second
    tally = fuzz.run(count, seed=2026, only=(name,), outside_s=2)
    assert tally.failures == []
    assert sum(tally.outcomes.values()) == count
    assert {kind for _, kind in tally.outcomes} <= {"model", "FormatError", "InputError"}


def test_damaged_side_files_are_used_or_refused_in_one_line() -> None:
    tally = side_files.run(80, seed=2026)
    assert tally.failures == []
    assert len({name for name, _ in tally.outcomes}) == 14
