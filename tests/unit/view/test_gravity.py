"""The picture of the directions of gravity in which an assembly holds."""

from pathlib import Path

import numpy as np
import pytest

from drystone import FormatError
from drystone.models import tower
from drystone.sequence import GravityRegion, gravity_region
from drystone.view.plots import save_gravity


def region(stands: bool = False) -> GravityRegion:
    return gravity_region(tower(2), directions=40, friction=0.6, stands=stands)


def test_every_direction_is_drawn_once() -> None:
    found = region()
    axes = save_gravity(found, title="tower").axes
    drawn = sum(len(dots.get_offsets()) for one in axes for dots in one.collections)
    assert drawn == len(found.direction)


def test_straight_down_lies_in_the_middle_of_the_left_disc_and_the_edge_is_horizontal() -> None:
    directions = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    found = gravity_region(tower(2), directions=directions, friction=0.6)
    left = save_gravity(found, title="").axes[0]
    holds, _, falls = (dots.get_offsets() for dots in left.collections)
    np.testing.assert_allclose(holds, [[0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(falls, [[1.0, 0.0]], atol=1e-12)


def test_what_only_prestress_holds_has_its_own_colour() -> None:
    axes = save_gravity(region(stands=True)).axes[0]
    labels = {dots.get_label() for dots in axes.collections}
    assert "only shims or prestress might hold it" in labels


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_a_plot_is_written_whole(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"gravity.{suffix}"
    save_gravity(region(), path, title="tower")
    assert path.stat().st_size > 1000
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_another_suffix_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"cannot be written as '\.gif'"):
        save_gravity(region(), tmp_path / "gravity.gif")
