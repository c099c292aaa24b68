"""The polar plot of tilt limits."""

from pathlib import Path

import numpy as np
import pytest

from drystone import FormatError
from drystone.limits import Bracket, Limit, Quantity, TiltSweep
from drystone.view import save_figure


def sweep(*stands: float | None) -> TiltSweep:
    limits = tuple(
        Limit(Quantity("tilt", "deg"), 0.0, 180.0, Bracket(20.0, 20.1), Bracket(angle, 20.1))
        for angle in stands
    )
    return TiltSweep(360.0 * np.arange(len(stands)) / len(stands), limits)


def test_both_definitions_are_closed_rings_and_the_weakest_is_marked() -> None:
    axes = save_figure(sweep(10.0, 5.0, 12.0, 20.0)).axes[0]
    balances, stands, weakest = (line.get_xydata() for line in axes.lines)
    np.testing.assert_allclose(balances[:, 1], 20.0)
    np.testing.assert_allclose(stands[:, 1], [10.0, 5.0, 12.0, 20.0, 10.0])
    np.testing.assert_allclose(weakest, [[np.pi / 2.0, 5.0]])
    assert "weakest towards 90 deg: 5.00 deg" in axes.get_title()


def test_a_direction_that_never_stands_is_the_weakest_and_leaves_a_gap() -> None:
    missing = sweep(10.0, None, 12.0)
    assert missing.weakest == 1
    axes = save_figure(missing).axes[0]
    assert len(axes.lines) == 2
    assert np.isnan(axes.lines[1].get_xydata()[1, 1])


def test_an_unfinished_sweep_has_no_weakest_direction_and_no_closed_ring() -> None:
    known = sweep(10.0, 5.0, 12.0)
    part = TiltSweep(known.azimuth, known.limits, (270.0,), stopped="stopped")
    axes = save_figure(part).axes[0]
    assert [len(line.get_xydata()) for line in axes.lines] == [3, 3]
    assert "3 of 4 directions are known" in axes.get_title()
    assert "weakest" not in axes.get_title()


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_a_plot_is_written_whole(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"polar.{suffix}"
    save_figure(sweep(10.0, 5.0, 12.0), path)
    assert path.stat().st_size > 1000
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_another_suffix_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"cannot be written as '\.gif'"):
        save_figure(sweep(1.0), tmp_path / "polar.gif")
