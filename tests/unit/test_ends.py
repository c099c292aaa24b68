"""What becomes of flush ends of joints is said of the model, and every analysis hears it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import drystone
from drystone import InputError, LoadCase, Model, Verdict, io, limits
from drystone.cli.application import main
from drystone.design import BuildableOptions, CutOptions, cut_until_free
from drystone.models import prism, wedge
from drystone.settlement import End, FlushEnds, push
from drystone.shells import Layout, barrel_vault, build_shell
from tests.unit.cli.running import commands

NO_PART = {"convert", "demo", "inspect", "mcp", "models", "poses", "reproduce"}
"""Commands that read no model to check it, or make their own."""
MODEL = Model.of(wedge("c"), friction=0.84, load=LoadCase.tilt(wedge("c"), (1.0, 0.0, 0.0), 40.0))
"""It stands where the groove is a little longer than the wedge, and falls where it is not."""


def test_every_command_that_checks_a_model_takes_them() -> None:
    with_ends = {
        name for name, one in commands().items() if any("--ends" in x.opts for x in one.params)
    }
    assert {*commands()} - with_ends - {"study"} == NO_PART  # a study takes --set ends=exact


@pytest.mark.parametrize(("ends", "end"), [("longer", End.SPENT), ("exact", End.FALLS)])
def test_a_push_begins_with_the_ends_that_are_chosen(ends: str, end: End) -> None:
    along = LoadCase.gravity(MODEL.assembly, direction=(1.0, 0.0, 0.0))
    assert push(MODEL, along, ends=ends).end is end


def test_a_model_keeps_them_in_its_file_and_in_its_parts(tmp_path: Path) -> None:
    path = tmp_path / "wedge.json"
    io.write(Model(MODEL.assembly, MODEL.contacts, MODEL.load, ends=FlushEnds.LONGER), path)
    model = drystone.read(path)
    assert model.ends is model.subset([0, 1]).ends is FlushEnds.LONGER
    assert drystone.check(path).stable
    assert drystone.read(path, ends="exact").ends is FlushEnds.EXACT
    path.write_text(json.dumps(json.loads(path.read_text()) | {"ends": "round"}))
    with pytest.raises(InputError, match=r"ends is 'round'.*'longer', 'exact'"):
        drystone.read(path)


def test_what_follows_no_blocks_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    io.write(MODEL, tmp_path / "wedge.json")
    assert main(["interlock", str(tmp_path / "wedge.json"), "--ends", "longer"]) == 2
    assert "--ends: a search for motions follows no blocks" in capsys.readouterr().err


def test_a_shell_and_a_monolith_that_is_cut_keep_them() -> None:
    sides = BuildableOptions(ends="exact")  # type: ignore[arg-type]
    assert sides.ends is FlushEnds.EXACT
    shell = build_shell(barrel_vault(span=6.0, length=6.0), Layout(courses=3, blocks=1))
    assert shell.model(ends=FlushEnds.LONGER).ends is FlushEnds.LONGER
    tower = prism([(0, 0), (1, 0), (1, 2), (0, 2)], (0, 1), "tower")
    assert cut_until_free(tower, options=CutOptions(2, ends=FlushEnds.EXACT)).model.ends == "exact"


def checked(degrees: float, longer: float, **how: str) -> drystone.Result:
    groove = wedge("b", longer=longer)
    load = LoadCase.tilt(groove, (1.0, 0.0, 0.0), degrees)
    return drystone.check(Model.of(groove, friction=0.84, load=load), **how)  # type: ignore[arg-type]


@pytest.mark.parametrize("degrees", [41.0, 46.0])
def test_faces_as_much_longer_as_a_check_says_hold_it(degrees: float) -> None:
    flush = checked(degrees, 0.0)
    assert flush.verdict is Verdict.UNDECIDED
    told = re.search(r"go on more than ([0-9.]+) mm beyond those ends", flush.message)
    assert told is not None
    far = 1e-3 * float(told[1])
    assert checked(degrees, 1.05 * far).verdict is Verdict.STABLE
    assert checked(degrees, 0.8 * far).verdict is not Verdict.STABLE


@pytest.mark.parametrize(
    ("degrees", "longer", "ends", "verdict"),
    [
        (41.0, 0.5e-3, None, Verdict.UNSTABLE),
        (41.0, 1e-3, None, Verdict.UNDECIDED),  # with stiff joints it falls
        (46.0, 0.0, "exact", Verdict.UNSTABLE),
    ],
)
def test_what_falls_over_ends_of_faces_says_how_much_farther_they_have_to_go(
    degrees: float, longer: float, ends: str | None, verdict: Verdict
) -> None:
    how = {} if ends is None else {"ends": ends}
    found = checked(degrees, longer, **how)
    assert found.verdict is verdict
    told = re.search(r"ends of faces, and stands where these go on ([0-9.]+) mm", found.message)
    assert told is not None
    far = 1e-3 * float(told[1])
    assert checked(degrees, longer + 1.05 * far, **how).verdict is Verdict.STABLE
    assert checked(degrees, longer + 0.8 * far, **how).verdict is not Verdict.STABLE


def test_what_falls_without_sliding_over_an_end_says_nothing_of_ends() -> None:
    assert "ends of faces" not in checked(70.0, 0.1).message


def test_a_tilt_that_is_undecided_names_all_that_decides() -> None:
    load = limits.LimitOptions(width=1.0)
    found = limits.limit_tilt(wedge("b"), (1.0, 0.0, 0.0), friction=0.84, options=load)
    told = " ".join(found.remarks)
    assert "which block carries the ends of the joints (--ends)" in told


@pytest.mark.parametrize(("strength", "falls"), [("100kPa", True), ("161kPa", False)])
def test_joints_that_crush_fall_whatever_the_ends_are(strength: str, falls: bool) -> None:
    """Of the loads 0.00633 are carried for each kPa."""
    found = drystone.check(MODEL, strength=strength)
    assert found.falls is falls
    assert found.message.startswith("it crushes" if falls else "the ends of the joints decide")
