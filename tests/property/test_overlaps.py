"""Blocks of unit cubes overlap where they have a cube in common, and nowhere else."""

from __future__ import annotations

import pytest

from benchmarks.overlaps import KINDS, random_pairs, right


@pytest.mark.parametrize("seed", range(2))
def test_overlaps_of_random_blocks_are_those_of_their_cubes(seed: int) -> None:
    pairs = list(random_pairs(80, seed))
    assert [pair for pair in pairs if not right(pair)] == []
    assert {pair.kind for pair in pairs} == set(KINDS)
    assert 30 < sum(pair.shared > 0 for pair in pairs) < 60
