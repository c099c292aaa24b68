"""Known optima that a search for a shape finds from a poor start."""

import numpy as np

from benchmarks.optima import again, hung


def test_a_thin_half_circle_is_shaped_to_the_catenary_within_a_hundredth_of_its_rise() -> None:
    found, before, after = hung(5, 0.005)
    assert np.abs(before).max() > 0.2
    assert np.abs(after).max() < 0.01
    assert found.stands
    assert again(found) == "stable"
