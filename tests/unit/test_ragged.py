"""Rows that belong to owners, against plain loops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drystone import InputError
from drystone.base.arrays import unit
from drystone.base.ragged import Ragged

COUNTS = st.lists(st.integers(0, 4), max_size=8)


@given(COUNTS, st.integers(0, 2**32 - 1))
def test_sums_means_and_extremes_are_those_of_a_loop(counts: list[int], seed: int) -> None:
    rows = Ragged.from_counts(counts)
    values = np.random.default_rng(seed).normal(size=(sum(counts), 3))
    parts = [values[begin : begin + count] for begin, count in zip(rows.first, counts, strict=True)]
    for i, part in enumerate(parts):
        np.testing.assert_array_equal(rows.split(values)[i], part)
        np.testing.assert_allclose(rows.sum(values)[i], part.sum(axis=0), atol=1e-12)
        if len(part):
            np.testing.assert_allclose(rows.mean(values)[i], part.mean(axis=0), atol=1e-12)
        else:
            assert np.isnan(rows.mean(values)[i]).all()
        np.testing.assert_array_equal(rows.min(values)[i], part.min(axis=0, initial=np.inf))
        np.testing.assert_array_equal(rows.max(values)[i], part.max(axis=0, initial=-np.inf))
        np.testing.assert_array_equal(rows.any(values > 0.0)[i], (part > 0.0).any(axis=0))
        np.testing.assert_array_equal(rows.all(values > 0.0)[i], (part > 0.0).all(axis=0))
        np.testing.assert_array_equal(rows.sum(values > 0.0)[i], (part > 0.0).sum(axis=0))
    full, row = rows.take(rows.counts > 0)
    largest = [part[:, 0].max() for part in parts if len(part)]
    np.testing.assert_array_equal(values[row, 0][full.argmax(values[row, 0])], largest)


@given(COUNTS)
def test_start_counts_and_owners_say_the_same(counts: list[int]) -> None:
    rows = Ragged.from_counts(counts)
    assert len(rows) == len(counts)
    assert rows.rows == sum(counts)
    assert rows.counts.tolist() == counts
    assert rows.owner.tolist() == [i for i, count in enumerate(counts) for _ in range(count)]
    again = Ragged.from_owners(rows.owner, len(counts))
    assert again.start.tolist() == rows.start.tolist()
    assert Ragged.of([range(count) for count in counts]).start.tolist() == rows.start.tolist()
    assert [part.stop - part.start for part in rows] == counts


@given(COUNTS.filter(lambda counts: len(counts) > 0), st.data())
def test_taking_owners_takes_their_rows_in_their_order(
    counts: list[int], data: st.DataObject
) -> None:
    rows = Ragged.from_counts(counts)
    chosen = data.draw(st.lists(st.integers(0, len(counts) - 1), max_size=6))
    part, row = rows.take(chosen)
    assert part.counts.tolist() == [counts[i] for i in chosen]
    assert rows.owner[row].tolist() == [i for i in chosen for _ in range(counts[i])]
    assert row.tolist() == [r for i in chosen for r in range(rows.start[i], rows.start[i + 1])]
    mask = np.isin(np.arange(len(counts)), chosen)
    assert rows.take(mask)[1].tolist() == rows.take(sorted(set(chosen)))[1].tolist()


def test_the_row_after_the_last_is_the_first_of_the_same_owner() -> None:
    assert Ragged.from_counts([3, 0, 1, 2]).following.tolist() == [1, 2, 0, 3, 5, 4]


def test_rows_that_are_dropped_leave_their_owners() -> None:
    rows = Ragged.from_counts([2, 1, 3])
    kept = rows.keep(np.array([True, False, False, True, True, True]))
    assert kept.counts.tolist() == [1, 0, 3]


def test_no_owner_and_no_row() -> None:
    none = Ragged.from_counts([])
    assert len(none) == none.rows == 0
    assert none.sum(np.zeros((0, 3))).shape == (0, 3)
    assert none.take([])[1].tolist() == []


def test_what_is_written_to_the_given_array_later_does_not_change_the_rows() -> None:
    start = np.array([0, 2, 3])
    view = start.view()
    view.setflags(write=False)
    of_array, of_view = Ragged(start), Ragged(view)
    start[1] = 1
    assert of_array.counts.tolist() == of_view.counts.tolist() == [2, 1]


def test_wrong_input_is_refused() -> None:
    for start in ([], [1, 2], [0, 2, 1]):
        with pytest.raises(InputError):
            Ragged(start)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="4 values for 3 rows"):
        Ragged.from_counts([3]).sum(np.zeros(4))
    with pytest.raises(IndexError):
        Ragged.from_counts([3])[1]
    with pytest.raises(ValueError, match="read-only"):
        Ragged.from_counts([3]).start[0] = 1


def test_directions_of_vectors_and_zero_stays_zero() -> None:
    direction, length = unit(np.array([[0.0, 3.0, 4.0], [0.0, 0.0, 0.0]]))
    assert direction.tolist() == [[0.0, 0.6, 0.8], [0.0, 0.0, 0.0]]
    assert length.tolist() == [5.0, 0.0]
