"""The picture of the directions of gravity in which an assembly holds."""

from pathlib import Path

import numpy as np
import pytest

from drystone.answer.chart import Chart
from drystone.models import tower
from drystone.sequence import GravityRegion, gravity_region
from drystone.view import save_chart


@pytest.fixture(scope="module")
def region() -> GravityRegion:
    return gravity_region(tower(2), directions=40, friction=0.6)


def test_every_direction_is_drawn_once(region: GravityRegion) -> None:
    assert sum(len(one.x) for one in region.figure().marks) == len(region.direction)


def test_straight_down_lies_in_the_middle_and_straight_up_at_the_rim() -> None:
    directions = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    holds, falls = gravity_region(tower(2), directions=directions, friction=0.6).figure().marks
    np.testing.assert_allclose(holds.y, [0.0])
    np.testing.assert_allclose(falls.x, [90.0, 0.0])
    np.testing.assert_allclose(falls.y, [90.0, 180.0])


def test_what_only_prestress_holds_has_its_own_colour() -> None:
    found = gravity_region(tower(2), directions=40, friction=0.6, stands=True)
    prestressed = GravityRegion(
        found.model, found.direction, found.frictionless, found.balanced, found.frictionless
    )
    labels = {one.label: one.ink for one in prestressed.figure().marks}
    assert labels["only shims or prestress might hold it"] == "unsure"
    assert "unsure" not in {one.ink for one in found.figure().marks}


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_the_chart_is_written(tmp_path: Path, suffix: str, region: GravityRegion) -> None:
    path = tmp_path / f"gravity.{suffix}"
    save_chart(region.figure(), path, title="tower")
    assert path.stat().st_size > 1000


def test_a_long_title_of_a_chart_is_not_cut() -> None:
    figure = save_chart(Chart("factor", caption=12 * "least at the crown, ", across="place"))
    figure.draw_without_rendering()
    title = figure.axes[0].title.get_window_extent()
    assert 0.0 <= title.x0 < title.x1 <= figure.bbox.width
