"""Flush ends as drawn beside an explicit program whose faces are clipped at every step."""

from __future__ import annotations

import pytest

from benchmarks.clipped import ends, ours
from drystone.models import wedge


@pytest.mark.parametrize(
    ("degrees", "shear", "end"),
    [(36.0, 1.0, "rests"), (60.0, 1.0, "falls"), (42.0, 0.02, "rests")],
)
def test_a_wedge_in_a_groove_that_ends_with_it(degrees: float, shear: float, end: str) -> None:
    assert ends(wedge("b"), degrees, shear) == ours(wedge("b"), degrees, shear) == end
