"""The margin of tilt that a check tells."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

import drystone
from drystone.cli import main
from drystone.limits.bounds import tilt_margin
from drystone.models import dovetail, tower


def test_the_margin_of_a_column_is_the_tilt_at_which_it_overturns() -> None:
    model = drystone.Model.of(tower(5), friction=0.9)
    assert tilt_margin(model) == pytest.approx(math.degrees(math.atan(0.25)), abs=1e-4)
    assert tilt_margin(model.with_friction(0.1)) == pytest.approx(
        math.degrees(math.atan(0.1)), abs=1e-4
    )


def test_it_is_not_asked_where_it_takes_long_or_has_no_meaning() -> None:
    model = drystone.Model.of(tower(5), friction=0.9)
    assert tilt_margin(model, most=4) is None
    assert tilt_margin(model.with_load(drystone.LoadCase.seismic(model.assembly, 0.01))) is None


def test_loads_that_are_not_vertical_stay_and_the_blocks_are_pushed_beside_them() -> None:
    model = drystone.Model.of(tower(5), friction=0.9)
    push = drystone.LoadCase.seismic(model.assembly, 0.05)
    loaded = model.with_load(model.load + push)
    margin = tilt_margin(loaded)
    assert margin == pytest.approx(math.degrees(math.atan(0.25 - 0.05)), abs=1e-4)
    told = replace(drystone.check(loaded), tilt_margin=margin).sentences()
    assert "push along x or y of 0.1999 of the weight" in "".join(one.text for one in told)


def test_wedged_blocks_that_forces_balance_at_every_tilt_have_no_margin() -> None:
    assert tilt_margin(drystone.Model.of(dovetail(), friction=0.6)) is None


def test_the_page_of_a_check_has_the_margin_that_the_command_tells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    drystone.write(tower(3), "tower.json")
    drystone.save_page(drystone.check("tower.json", friction=0.6), "python.html")
    assert main(["check", "tower.json", "--friction", "0.6", "--html", "command.html"]) == 0
    for page in ("python.html", "command.html"):
        told = "forces balance a tilt about x or y of 26.56 degrees"
        assert told in Path(page).read_text("utf-8"), page
