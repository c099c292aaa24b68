"""Overlapping boxes against all pairs."""

from __future__ import annotations

import numpy as np
import pytest

from drystone.base.ragged import expand
from drystone.geometry.boxes import batches, between, overlapping


def all_pairs(low_a, high_a, low_b, high_b):
    touch = ((low_a[:, None] <= high_b[None]) & (low_b[None] <= high_a[:, None])).all(axis=2)
    return np.argwhere(touch)


@pytest.mark.parametrize("ratio", [1.0, 1e2, 1e5])
def test_the_tree_finds_what_all_pairs_find(ratio: float) -> None:
    random = np.random.default_rng(7)
    low = 3.0 * random.random((300, 3)) - 1.0
    extent = 0.5 * ratio ** -random.random((300, 1)) * random.random((300, 3))
    extent[:40, 1] = 0.0
    high = low + extent
    expected = all_pairs(low, high, low, high)
    expected = expected[expected[:, 0] < expected[:, 1]]
    assert np.array_equal(np.stack(overlapping(low, high), axis=1), expected)
    some = slice(0, 120)
    found = np.stack(between(low[some], high[some], low[120:], high[120:]), axis=1)
    assert np.array_equal(found, all_pairs(low[some], high[some], low[120:], high[120:]))


def test_boxes_that_touch_overlap() -> None:
    low = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.5, 0.0, 0.0]])
    first, second = overlapping(low, low + 1.0)
    assert (first.tolist(), second.tolist()) == ([0], [1])


def test_points_and_nothing_are_boxes_too() -> None:
    point = np.zeros((2, 3))
    assert [x.tolist() for x in overlapping(point, point)] == [[0], [1]]
    none = np.zeros((0, 3))
    assert [len(x) for x in between(none, none, point, point)] == [0, 0]


def test_result_does_not_depend_on_place() -> None:
    random = np.random.default_rng(1)
    low = random.integers(0, 20, (100, 3)).astype(float)
    high = low + random.integers(0, 4, (100, 3))
    here = np.stack(overlapping(low, high))
    assert np.array_equal(here, np.stack(overlapping(low - 4096.0, high - 4096.0)))


def test_empty_ranges_expand_to_nothing() -> None:
    source, value = expand(np.array([3, 7, 1]), np.array([0, 2, 0]))
    assert source.tolist() == [1, 1]
    assert value.tolist() == [7, 8]


def test_batches_are_bounded_and_hold_every_pair() -> None:
    low = np.random.default_rng(2).random((2000, 3))
    parts = list(batches(low - 0.4, low + 0.4, low, low))
    found = np.concatenate([np.stack(part, axis=1) for part in parts])
    expected = np.stack(between(low - 0.4, low + 0.4, low, low), axis=1)
    assert np.array_equal(found[np.lexsort(found.T[::-1])], expected)
    assert max(len(i) for i, _ in parts) < 0.5 * len(expected)
