"""Blocks of unit cubes overlap where they have a cube in common, and nowhere else."""

from __future__ import annotations

from benchmarks.overlaps import KINDS, random_pairs, right


def test_overlaps_of_random_blocks_are_those_of_their_cubes() -> None:
    """As many more as one likes: ``python -m benchmarks.overlaps``."""
    pairs = list(random_pairs(80, 0))
    assert [pair for pair in pairs if not right(pair)] == []
    assert {pair.kind for pair in pairs} == set(KINDS)
    assert 30 < sum(pair.shared > 0 for pair in pairs) < 60
