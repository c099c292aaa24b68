"""The margin of tilt that a check tells."""

import math
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone.cli import main
from drystone.geometry.frames import AXES, rotation_about
from drystone.limits.bounds import tilt_margin, with_margins
from drystone.models import dovetail, tower


def test_the_margin_of_a_column_is_the_tilt_at_which_it_overturns() -> None:
    model = drystone.Model.of(tower(5), friction=0.9)
    assert tilt_margin(model)[0] == pytest.approx(math.degrees(math.atan(0.25)), abs=1e-4)
    assert tilt_margin(model.with_friction(0.1))[0] == pytest.approx(
        math.degrees(math.atan(0.1)), abs=1e-4
    )


def test_it_is_not_asked_where_it_takes_long_or_has_no_meaning() -> None:
    model = drystone.Model.of(tower(5), friction=0.9)
    assert tilt_margin(model, most=4) == (None, "")
    assert tilt_margin(model.with_load(drystone.LoadCase.seismic(model.assembly, 0.01)))[0] is None


@pytest.mark.parametrize(
    ("kx", "ky", "along"), [(0.05, 0, "x"), (-0.05, 0, "-x"), (0, 0.05, "y"), (0, -0.05, "-y")]
)
def test_loads_that_are_not_vertical_stay_and_the_blocks_are_pushed_beside_them(
    kx: float, ky: float, along: str
) -> None:
    model = drystone.Model.of(tower(5), friction=0.9)
    push = drystone.LoadCase.seismic(model.assembly, kx, ky)
    found = with_margins(drystone.check(model.with_load(model.load + push)))
    assert found.tilt_margin == pytest.approx(math.degrees(math.atan(0.25 - 0.05)), abs=1e-4)
    told = "".join(one.text for one in found.sentences())
    assert "push along x or y of 0.1999 of the weight" in told
    assert f"on top of the loads (least along {along})" in told


@pytest.mark.parametrize("name", ["x", "-x", "y", "-y"])
def test_the_safety_names_the_axis_of_the_least_tilt(name: str) -> None:
    """A tower that leans tilts least about the axis about which it leans, as the limit says."""
    lean = rotation_about(np.array(AXES[name]), 3.0)
    tall = tower(5)
    tall = tall.transformed(np.array([[1, 0, lean[0, 2]], [0, 1, lean[1, 2]], [0, 0, 1.0]]))
    found = with_margins(drystone.check(drystone.Model.of(tall, friction=0.9)))
    assert found.tilt_about == name
    assert f"degrees (least about {name}): a bound" in "".join(x.text for x in found.sentences())
    assert drystone.limit_tilt(found.model, axis=name).stands == pytest.approx(
        found.tilt_margin, abs=0.1
    )


def test_wedged_blocks_that_forces_balance_at_every_tilt_have_no_margin() -> None:
    assert tilt_margin(drystone.Model.of(dovetail(), friction=0.6)) == (None, "")


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


def test_the_margin_of_friction_is_told_beside_that_of_tilt_and_large_models_name_commands() -> (
    None
):
    """A block on a slope of 1 in 4 slides at a friction of 0.25."""
    slope = drystone.Model.of(tower(2), friction=0.5).with_load((9.81 / 4, 0.0, -9.81))
    found = with_margins(drystone.check(slope))
    assert found.friction_margin == pytest.approx(0.5, abs=1e-3)
    assert any("with 0.5" in one.text for one in found.sentences())
    assert "and the loads with 0.5" in found.layers().facts["Safety"]
    many = drystone.Model.of(tower(151), friction=0.5)
    stands = with_margins(drystone.check(many))
    assert (stands.tilt_margin, stands.friction_margin) == (None, None)
    assert "drystone limit friction" in stands.layers().facts["Safety"]
