"""Values lowered one by one: each one that is left is needed, whatever holds the structure."""

from collections.abc import Callable

import numpy as np
import pytest

from drystone.base.arrays import Floats
from drystone.design.search import each_needed

CLOSE = 0.5


def leaning(sharpness: Floats) -> bool:
    """Two wedges that differ by little hold it: each allows the other to be a little flatter."""
    return bool(abs(sharpness[0] - sharpness[1]) < 0.7 and sharpness.sum() > 20.0)


def with_gaps(sharpness: Floats) -> bool:
    """It stands with a sharpness in some ranges only, so bisection finds the end of one of them."""
    value = sharpness[0]
    return bool(value > 40.0 or 32.0 < value < 39.9 or 31.0 < value < 31.9 or 5.0 < value < 5.2)


def one_for_two(sharpness: Floats) -> bool:
    """The first or both of the others."""
    return bool(sharpness[0] > 45.0 or (sharpness[1:] > 45.0).all())


@pytest.mark.parametrize("stands", [leaning, with_gaps, one_for_two])
def test_each_wedge_that_is_left_is_needed(stands: Callable[[Floats], bool]) -> None:
    found, known = each_needed(np.full(3, 50.0), stands, close=CLOSE, late=lambda: False)
    assert known
    assert stands(found)
    assert (found > 0.0).any()
    for k in np.flatnonzero(found):
        for value in (max(found[k] - CLOSE, 0.0), 0.0):
            less = found.copy()
            less[k] = value
            assert not stands(less)


def barely(sharpness: Floats) -> bool:
    """The first wedge, and a trace of the second; the third is not needed."""
    return bool(sharpness[0] > 45.0 and sharpness[1] > 0.1)


def test_no_wedge_is_flatter_than_the_smallest_that_is_built() -> None:
    given, late = np.array([50.0, 50.0, 0.2]), bool
    trace, _ = each_needed(given, barely, close=CLOSE, late=late)
    assert 0.0 < trace[1] <= CLOSE
    assert trace[2] == 0.0
    built, known = each_needed(given, barely, close=CLOSE, late=late, smallest=5.0)
    assert known
    assert built[1:].tolist() == [5.0, 0.0]
    assert built[0] == pytest.approx(45.0, abs=CLOSE)


def test_the_given_sharpness_is_left_as_it_is() -> None:
    given = np.full(3, 50.0)
    each_needed(given, one_for_two, close=CLOSE, late=lambda: False)
    np.testing.assert_array_equal(given, 50.0)


def test_where_it_is_stopped_it_stands_and_no_wedge_is_known_to_be_needed() -> None:
    asked = iter(range(100))
    found, known = each_needed(
        np.full(3, 50.0), leaning, close=CLOSE, late=lambda: next(asked) > 30
    )
    assert not known
    assert leaning(found)
    assert found.sum() < 150.0
