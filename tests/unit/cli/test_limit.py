"""What the limits, the loads and the joint tables answer on the command line."""

import csv
import json
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest

from drystone import LoadCase, io
from drystone.cli import main
from drystone.cli.application import limit
from drystone.io import Contents
from drystone.limits import LIMITS
from drystone.mcp.answers import TOOLS
from drystone.mcp.answers import answer as ask_tool
from drystone.mcp.folder import Folder
from drystone.models import tower
from tests.unit.cli.running import Capsys, answer, refused

TOWER = tower(2)
SLIDE = float(np.rad2deg(np.arctan(0.6)))


@pytest.fixture
def model(tmp_path: Path) -> str:
    path = tmp_path / "tower.json"
    io.write(TOWER, path)
    return str(path)


def test_tilt_has_both_definitions_and_the_blocks_that_fall(model: str, capsys: Capsys) -> None:
    code, told = answer(capsys, "limit", "tilt", model, "--axis", "1,0,0", "--scan", "1")
    assert code == 0
    for key in ("equilibrium", "rest"):
        assert told[key]["stands"] < SLIDE < told[key]["falls"]
    assert told["falling"] == ["block-1"]
    assert told["parameter"] == "tilt"
    assert told["islands"] == told["notes"] == told["files"] == []


def test_a_sweep_writes_its_plot(model: str, tmp_path: Path, capsys: Capsys) -> None:
    plot = tmp_path / "polar.png"
    code, told = answer(
        capsys,
        "limit",
        "sweep",
        model,
        "--directions",
        "3",
        "--equilibrium-only",
        "--png",
        str(plot),
    )
    assert code == 0
    assert told["azimuth"] == [0.0, 120.0, 240.0]
    assert plot.read_bytes()[:4] == b"\x89PNG"
    assert told["files"] == [str(plot)]


def test_a_limit_and_a_sweep_write_a_page_and_a_figure_at_once(
    model: str, tmp_path: Path, capsys: Capsys
) -> None:
    page, figure = tmp_path / "fall.html", tmp_path / "fall.svg"
    files = ("--html", str(page), "--png", str(figure))
    for name, *more in (("tilt", "--axis", "y"), ("sweep", "--directions", "2")):
        _, told = answer(capsys, "limit", name, model, "--scan", "1", *more, *files)
        assert told["files"] == [str(page), str(figure)]
        assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
        assert "<svg" in figure.read_text(encoding="utf-8")
        page.unlink()
        figure.unlink()


def test_friction_and_its_page(model: str, tmp_path: Path, capsys: Capsys) -> None:
    page = tmp_path / "fall.html"
    code, told = answer(
        capsys, "limit", "friction", model, "--seismic", "0.3,0", "--html", str(page),
        "--width", "0.01", "--scan", "1",
    )  # fmt: skip
    assert code == 0
    assert told["rest"]["value"] == pytest.approx(0.3, abs=0.01)
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")


def test_a_load_grows_until_the_block_topples(model: str, capsys: Capsys) -> None:
    code, told = answer(
        capsys, "limit", "load", model, "block-1:100,0,0@0.5,0.5,2.2", "--scan", "1"
    )
    assert code == 0
    expected = 2400.0 * 9.81 * 0.5 / 1.2 / 100.0
    assert told["rest"]["value"] == pytest.approx(expected, rel=1e-3)
    assert told["notes"] == ["the point 0.5, 0.5, 2.2 is 0.2 m off block 'block-1'"]
    assert "next" not in told
    code, told = answer(capsys, "limit", "load", model, "seismic:1,0", "--scan", "1")
    assert (code, "next" in told) == (0, False)  # 1 g is a unit
    code, told = answer(capsys, "limit", "load", model, "seismic:2,0", "--scan", "1")
    assert code == 0
    assert told["next"] == f"drystone mend {model} --seismic 2,0"


def test_a_load_case_of_the_file_can_grow(tmp_path: Path, capsys: Capsys) -> None:
    wind = LoadCase.point_load(TOWER, 1, (1000.0, 0.0, 0.0))
    loads = (LoadCase.gravity(TOWER), LoadCase(wind.wrench, "wind"))
    path = tmp_path / "loaded.json"
    io.write(Contents(TOWER, None, loads, ()), path)
    code, told = answer(capsys, "limit", "load", str(path), "wind", "--equilibrium-only")
    assert code == 0
    assert told["rest"] is None
    assert told["equilibrium"]["value"] == pytest.approx(0.6 * 2.4 * 9.81, rel=1e-3)


def test_load_cases_of_the_file_combine_with_factors(tmp_path: Path, capsys: Capsys) -> None:
    wind = LoadCase(LoadCase.point_load(TOWER, 1, (1000.0, 0.0, 0.0)).wrench, "wind")
    path = tmp_path / "loaded.json"
    io.write(Contents(TOWER, None, (LoadCase.gravity(TOWER), wind), ()), path)
    cases = ("--case", "1.35*gravity", "--case", "wind")
    code, told = answer(capsys, "check", str(path), *cases)
    assert code == 0
    force = told["most_loaded"][0]
    assert force["normal"] == pytest.approx(1.35 * 2400.0 * 9.81)
    assert force["tangential"] == pytest.approx(1000.0)
    assert "no load case is called 'snow'" in refused(capsys, "check", str(path), "--case", "snow")
    given = ("--case", "wind", "--gravity", "9.81")
    assert "leave out --gravity" in refused(capsys, "check", str(path), *given)
    assert "'x' is not a number" in refused(capsys, "check", str(path), "--case", "x*wind")


def test_limits_take_the_load_cases_of_the_file_with_factors(
    tmp_path: Path, capsys: Capsys
) -> None:
    wind = LoadCase(LoadCase.point_load(TOWER, 1, (1000.0, 0.0, 0.0)).wrench, "wind")
    path = tmp_path / "loaded.json"
    io.write(Contents(TOWER, None, (LoadCase.gravity(TOWER), wind), ()), path)
    cases = ("--case", "2*gravity", "--case", "4*wind")
    code, told = answer(capsys, "limit", "friction", str(path), *cases, "--equilibrium-only")
    assert code == 0
    assert told["equilibrium"]["value"] == pytest.approx(4.0 / (2.0 * 2.4 * 9.81), abs=1e-3)


def test_shrink_imperfections_and_thickness_answer(model: str, capsys: Capsys) -> None:
    code, told = answer(capsys, "limit", "shrink", model, "--seismic", "0.25", "--scan", "1")
    assert code == 0
    assert told["rest"]["value"] == pytest.approx(0.25, abs=1e-3)
    assert told["geometric_safety_factor"] == pytest.approx(1.0 / told["rest"]["stands"])
    code, told = answer(
        capsys, "limit", "imperfections", model, "--friction-range", "0.2,0.4", "--seismic", "0.3",
        "--draws", "8",
    )  # fmt: skip
    assert code == 1
    assert (told["draws"], 0 < told["standing"] < 8) == (8, True)
    code, told = answer(
        capsys, "limit", "thickness", "arch", "--set", "voussoirs=8", "--friction", "1",
        "--width", "0.001", "--equilibrium-only",
    )  # fmt: skip
    assert code == 0
    assert told["equilibrium"]["value"] == pytest.approx(0.09997, abs=1e-3)
    assert told["parameter"] == "thickness_ratio"


def test_what_never_stood_has_exit_code_one(model: str, capsys: Capsys) -> None:
    code, told = answer(
        capsys, "limit", "tilt", model, "--load", "block-1:9e9,0,0", "--scan", "1", "--upper", "9"
    )
    assert code == 1
    assert told["rest"]["stands"] is None


def test_a_person_reads_the_same(model: str, capsys: Capsys) -> None:
    assert main(["limit", "tilt", model, "--scan", "1"]) == 0
    out = capsys.readouterr().out
    assert "degrees about x" in out
    assert "[deg]" in out  # brackets are no markup
    assert "equilibrium, check" in out  # three values that agree are one row
    assert "gives way: block-1\nfirst motion: slides towards -y\n" in out
    assert main(["limit", "sweep", model, "--directions", "2", "--equilibrium-only"]) == 0
    assert "weakest" in capsys.readouterr().out
    assert main(["limit", "imperfections", model, "--offset", "0.01", "--draws", "2"]) == 0
    assert "2 of 2" in capsys.readouterr().out


def test_check_takes_loads_and_an_earthquake(model: str, capsys: Capsys) -> None:
    mass = ("--load", "block-1:100kg", "--load", "block-1:m=0,0,5")
    code, told = answer(capsys, "check", model, *mass, "--seismic", "0.1,0.1")
    assert code == 0
    force = told["most_loaded"][0]
    assert force["normal"] == pytest.approx(2500.0 * 9.81)
    assert force["tangential"] == pytest.approx(2500.0 * 9.81 * 0.1 * np.sqrt(2.0))
    assert answer(capsys, "check", model, "--seismic", "0.7,0")[0] == 1


def test_check_writes_joint_tables(model: str, tmp_path: Path, capsys: Capsys) -> None:
    names = [str(tmp_path / f"joints.{suffix}") for suffix in ("csv", "json", "html")]
    options = [part for name in names for part in ("--joints", name)]
    code, told = answer(capsys, "check", model, *options, "--strength", "0.1MPa")
    assert code == 0
    assert told["files"] == names
    rows = list(csv.DictReader(Path(names[0]).read_text(encoding="utf-8").splitlines()))
    assert float(rows[0]["normal [N]"]) == pytest.approx(2400.0 * 9.81)
    assert float(rows[0]["strength_use"]) == pytest.approx(0.024 * 9.81)


def test_check_writes_the_forces_of_corners(model: str, tmp_path: Path, capsys: Capsys) -> None:
    names = [str(tmp_path / f"corners.{suffix}") for suffix in ("csv", "json")]
    options = [part for name in names for part in ("--corners", name)]
    code, told = answer(capsys, "check", model, *options)
    assert (code, told["files"]) == (0, names)
    rows = list(csv.DictReader(Path(names[0]).read_text(encoding="utf-8").splitlines()))
    assert sum(float(row["force_n [N]"]) for row in rows) == pytest.approx(2400.0 * 9.81)
    made = json.loads(Path(names[1]).read_text(encoding="utf-8"))
    assert made["units"]["force_n"] == "N"
    for row, same in zip(made["rows"], rows, strict=True):
        assert row["point"][2] == float(same["point_z [m]"])
        assert row["force_n"] == float(same["force_n [N]"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["limit", "tilt", "MODEL", "--axis", "0,0,0"], "--axis: axis is zero"),
        (["limit", "tilt", "MODEL", "--axis", "w"], "no axis is called 'w'"),
        (["limit", "sweep", "MODEL", "--directions", "0"], "--directions: is 0"),
        (["limit", "tilt", "MODEL", "--width", "0"], "--width: is 0"),
        (["limit", "tilt", "MODEL", "--scan", "0"], "--scan: is 0"),
        (["limit", "tilt", "MODEL", "--workers", "0"], "--workers: is 0"),
        (["limit", "tilt", "MODEL", "--cone", "square"], "exact, octagon"),
        (["limit", "load", "MODEL", "wind"], "no load case is called 'wind'"),
        (["limit", "load", "MODEL", "block-0:1,0,0"], "'block-0' is fixed"),
        (["limit", "load", "MODEL", "block-7:1,0,0"], "no block is called 'block-7'"),
        (["limit", "thickness", "cube"], "there is no 'cube'"),
        (["limit", "thickness", "arch", "--set", "voussoirs"], "not NAME=VALUE"),
        (["limit", "thickness", "arch", "--set", "voussoirs=x"], "not a whole number"),
        (["limit", "thickness", "arch", "--set", "colour=1"], "no parameter 'colour'"),
        (["limit", "thickness", "arch", "--set", "thickness_ratio=1"], "what is searched"),
        (["limit", "imperfections", "MODEL"], "nothing is imperfect"),
        (
            ["limit", "imperfections", "MODEL", "--friction-range", "1"],
            "--friction-range: has 1 values; give 2",
        ),
        (["limit", "imperfections", "MODEL", "--turn", "nan"], "--turn: is nan"),
        (["limit", "friction", "MODEL", "--case", "wind"], "no load case is called 'wind'"),
        (["check", "MODEL", "--load", "block-1"], "names no block"),
        (
            ["check", "MODEL", "--load", "block-1:5kgs"],
            "write a force 0,0,-500 or 2kN, a mass 80kg",
        ),
        (["check", "MODEL", "--load", "block-1:1,2"], "not three finite numbers"),
        (["check", "MODEL", "--load", "block-1:xkg"], "mass 'xkg' is not a number with a unit"),
        (["check", "MODEL", "--load", "block-1:m=1,0,0@0,0,0"], "acts at no point"),
        (["check", "MODEL", "--load", "block-0:1,0,0"], "'block-0' is fixed"),
        (["check", "MODEL", "--seismic", "1,2,3"], "not KX,KY"),
        (["check", "MODEL", "--joints", "joints.xls"], "does not end in"),
        (["check", "MODEL", "--strength", "-1MPa"], "--strength: is -1MPa; give more than zero"),
        (["check", "MODEL", "--strength", "0Pa"], "--strength: is 0Pa"),
        (["check", "MODEL", "--strength", "0"], "is 0; give more than zero, such as 5MPa"),
        (
            ["check", "MODEL", "--gravity", "1,0,-9.7", "--load", "fill:cover=1m,weight=20kN/m3"],
            "load fill: weighs along -z, and gravity is turned; leave out --gravity X,Y,Z",
        ),
        (["check", "MODEL", "--strength", "5"], "strength '5' is not a number with a unit"),
        (["limit", "tilt", "MODEL", "--strength", "5kN"], "--strength: "),
        (["limit", "train", "MODEL", "--train", "no.toml"], "--train no.toml: there is no such"),
        (["limit", "train", "MODEL", "--train", "lm71"], "--train: 'lm71' is 4.8 m long, the"),
        (
            ["limit", "train", "MODEL", "--fill", "cover=-0.1m,weight=20kN/m3"],
            "--fill: cover is -0.1; give 0 or more",
        ),
        (
            ["limit", "train", "MODEL", "--fill", "cover=0.1m,weight=20"],
            "--fill: weight: '20' has no unit",
        ),
        (
            ["limit", "train", "MODEL", "--fill", "cover=0m,weight=20kN/m3,k=2,passive=1"],
            "--fill: passive is 1, k 2; give more than k",
        ),
        (
            ["check", "MODEL", "--strength", "5MPa", "--joint-capacity", "compression=5MPa"],
            "--strength: the joints have a strength already",
        ),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_line(
    model: str, capsys: Capsys, arguments: list[str], words: str
) -> None:
    given = [model if argument == "MODEL" else argument for argument in arguments]
    assert words in refused(capsys, *given)


def test_every_limit_of_the_table_is_a_command_and_a_choice_of_programs() -> None:
    assert {*limit.list_commands(click.Context(limit))} == {*LIMITS, "thickness"}
    assert {*TOOLS["limit"].arguments["of"].choices} == {*LIMITS}


@pytest.mark.parametrize(
    ("of", "given", "key"),
    [
        ("imperfections", {"offset": 0.01, "draws": 2}, "share"),
        ("thrust", {"block": "block-0"}, "least"),
        ("sweep", {"directions": 2, "equilibrium_only": True}, "azimuth"),
        ("load", {"live": "seismic:1,0", "equilibrium_only": True}, "stands"),
    ],
)
def test_programs_ask_for_every_limit_by_the_options_of_its_function(
    model: str, of: str, given: dict[str, Any], key: str
) -> None:
    folder = Folder.of(Path(model).parent, 1.0)
    asked = {"model": {"file": Path(model).name}, "of": of, **given}
    told = ask_tool("limit", asked, folder, 60.0)
    assert key in told, told
    assert "is not used" in ask_tool("limit", {**asked, "scaled": True}, folder, 60.0)["error"]


def test_the_range_that_was_searched_is_told_and_both_sides_differ(capsys: Capsys) -> None:
    asked = ["limit", "thickness", "arch", "--set", "voussoirs=8", "--friction", "1"]
    assert main(asked) == 0
    said = capsys.readouterr().out
    assert "searched from 0.2 to 0.05" in said
    assert "--from and --to search another range" in said
    row = next(line for line in said.splitlines() if "equilibrium," in line)
    stands, falls = row.split()[-2:]
    assert float(stands) > float(falls)
