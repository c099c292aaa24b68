"""What ``drystone settle`` answers on the command line, and what a file can say of settlements."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import pytest

from drystone import Assembly, Block, LoadCase, io
from drystone.cli import main
from drystone.io import Contents
from drystone.models import arch, box, wedge
from tests.unit.cli.running import Capsys, answer

FEET = [box((0.2, 1.0, 0.2), (x, 0.0, 0.0), n) for n, x in zip("abc", (0.0, 1.9, 3.8), strict=True)]
BEAM = Assembly((*FEET, box((4.0, 1.0, 0.2), (0.0, 0.0, 0.2), "beam"))).with_fixed(list("abc"))
WEIGHT = 0.8 * 2400.0 * 9.81
DROP = ("--move", "b:0,0,-0.01")


@pytest.fixture
def model(tmp_path: Path) -> str:
    path = tmp_path / "beam.json"
    io.write(BEAM, path)
    return str(path)


def given(told: Any, when: str) -> dict[str, float]:
    """Vertical force that each support gives, by the weight of the beam."""
    return {row["block"]: row[when][2] / WEIGHT for row in told["supports"]}


def test_a_support_that_goes_down_opens_its_joint_and_the_others_carry(
    model: str, capsys: Capsys
) -> None:
    code, told = answer(capsys, "settle", model, *DROP)
    assert (code, told["verdict"]) == (0, "stable")
    assert told["motion"] == [
        {"block": "b", "translation": [0.0, 0.0, -0.01], "rotation": [0.0, 0.0, 0.0]}
    ]
    (opened,) = told["open"]
    assert (opened["block_a"], opened["block_b"]) == ("b", "beam")
    assert opened["distance"] == pytest.approx(0.01, rel=1e-3)
    assert told["sliding"] == []
    assert given(told, "before") == pytest.approx({"a": 1 / 3, "b": 1 / 3, "c": 1 / 3}, abs=1e-6)
    assert given(told, "after") == pytest.approx({"a": 0.5, "b": 0.0, "c": 0.5}, abs=1e-6)
    changes = {row["block_a"]: row["change"][2] / WEIGHT for row in told["joints"]}
    assert changes == pytest.approx({"a": 1 / 6, "b": -1 / 3, "c": 1 / 6}, abs=1e-6)


def test_a_load_case_of_the_file_settles_with_its_factor(model: str, capsys: Capsys) -> None:
    path = Path(model)
    content = json.loads(path.read_text(encoding="utf-8"))
    content["loads"] = [
        {"name": "dead", "parts": [{"kind": "gravity"}]},
        {"name": "pier", "parts": [{"kind": "settlement", "block": "b", "motion": [0, 0, -0.01]}]},
    ]
    path.write_text(json.dumps(content), encoding="utf-8")
    code, told = answer(capsys, "settle", model, "--case", "2*dead", "--case", "-0.5*pier", *DROP)
    assert code == 0
    assert told["motion"][0]["translation"] == pytest.approx([0.0, 0.0, -0.005])
    assert given(told, "after") == pytest.approx({"a": 1.0, "b": 0.0, "c": 1.0}, abs=1e-6)


def test_what_is_no_settlement_refuses_a_case_that_moves_supports(
    tmp_path: Path, capsys: Capsys
) -> None:
    pier = LoadCase.gravity(BEAM) + LoadCase.settlement(BEAM, "b", (0.0, 0.0, -0.01))
    path = tmp_path / "moving.json"
    io.write(Contents(BEAM, None, (LoadCase(pier.wrench, "pier", motion=pier.motion),), ()), path)
    for command in (["check"], ["limit", "tilt"], ["plan"]):
        assert main([*command, str(path)]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert "the load case 'pier' moves supports; ask 'drystone settle'" in err
    assert answer(capsys, "settle", str(path))[0] == 0


def test_its_files_are_a_page_of_two_stages_a_figure_and_the_joints_after(
    tmp_path: Path, capsys: Capsys
) -> None:
    path, page, figure, joints = (
        tmp_path / name for name in ("arch.json", "arch.html", "arch.png", "arch.csv")
    )
    io.write(arch(0.2, 8), path)
    code, told = answer(
        capsys, "settle", str(path), "--move", "springer-right:0.01,0,0", "--friction", "0.7",
        "--html", str(page), "--png", str(figure), "--joints", str(joints),
    )  # fmt: skip
    assert code == 0
    assert told["files"] == [str(page), str(figure), str(joints)]
    text = page.read_text(encoding="utf-8")
    assert '"label":"before"' in text.replace(": ", ":")
    assert "joints that open" in text
    assert figure.read_bytes()[:4] == b"\x89PNG"
    with joints.open(encoding="utf-8") as file:
        normal = [float(row["normal [N]"]) for row in csv.DictReader(file)]
    rows = sorted(told["joints"], key=lambda row: row["interface"])
    assert normal == pytest.approx([row["normal"] for row in rows])


def test_lengths_of_a_motion_have_units(tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "arch.json"
    io.write(arch(0.2, 8), path)
    plain, unit = (
        answer(capsys, "settle", str(path), "--move", f"springer-right:{way}", "--friction", "0.7")
        for way in ("0.03,0,0", "30,0,0mm")
    )
    assert plain[1]["motion"] == unit[1]["motion"]
    for options in (["springer-right:30,0,0"], ["springer-right:1,0,0", "--to", "30"]):
        assert main(["settle", str(path), "--move", *options]) == 2
        assert "write it in m or with its unit: 30mm" in capsys.readouterr().err


def test_a_support_turns_by_degrees(tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "arch.json"
    io.write(arch(0.2, 8), path)
    motion = ("--move", "springer-right:0,0,0,0,0.2,0", "--friction", "0.7")
    code, told = answer(capsys, "settle", str(path), *motion)
    assert code == 0
    assert told["motion"][0]["rotation"] == pytest.approx([0.0, math.radians(0.2), 0.0])
    assert main(["settle", str(path), *motion]) == 0
    small = capsys.readouterr().out
    assert "springer-right by 0, 0, 0 m, turned by 0, 0.2, 0 degrees" in small
    assert "joints that open" in small


@pytest.mark.parametrize("ground", [[], [box((60.0, 60.0, 40.0), (-30.0, -30.0, -40.0), "g")]])
def test_what_falls_on_the_way_of_a_support_is_no_settlement(
    ground: list[Block], tmp_path: Path, capsys: Capsys
) -> None:
    """A lintel falls where its bearing of 0.2 m is gone; to first order it follows any way."""
    path = tmp_path / "lintel.json"
    posts = [box((0.5, 0.3, 1.0), (x, 0.0, 0.0), name) for x, name in ((0.0, "a"), (1.5, "b"))]
    lintel = box((1.4, 0.3, 0.3), (0.3, 0.0, 1.0), "lintel")
    io.write(
        Assembly([*posts, lintel, *ground], [True, True, False, *(True for _ in ground)]), path
    )
    far = ["settle", str(path), "--move", "b:0.25,0,0"]
    assert main(far) == 1
    assert "it falls at 20" in capsys.readouterr().out
    assert main([*far, "--joints", str(tmp_path / "joints.csv")]) == 2
    assert "tables of joints are of what stands" in capsys.readouterr().err


def test_without_a_motion_the_blocks_are_followed_until_they_rest_or_fall(
    tmp_path: Path, capsys: Capsys
) -> None:
    """The flush wedge at 50 degrees rests with one carrier and falls with the other."""
    path, page = tmp_path / "wedge.json", tmp_path / "wedge.html"
    io.write(wedge("b"), path)
    gravity = ("--gravity", "0,-7.515,-6.306", "--friction", "0.84")
    code, told = answer(capsys, "settle", str(path), *gravity, "--html", str(page))
    assert (code, told["outcome"]) == (1, "the ends of the joints decide")
    ends = {one["carrier"]: one["outcome"] for one in told["paths"]}
    assert ends == {"moving": "comes to rest", "resting": "falls"}
    for chosen, outcome in (("longer", "comes to rest"), ("exact", "falls")):
        _, alone = answer(capsys, "settle", str(path), *gravity, "--ends", chosen)
        assert alone["outcome"] == outcome
    (moved,) = (row for row in told["paths"][0]["blocks"] if row["block"] == "wedge")
    assert moved["travel"] == told["paths"][0]["travel"]
    assert moved["move"][1] < 0.0
    assert "Undecided: falls with the ends" in page.read_text(encoding="utf-8")
    assert main(["settle", str(path), "--friction", "0.84"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("COMES TO REST")
    assert out.count(" wedge ") == 1


def test_a_person_reads_joints_supports_and_changes(model: str, capsys: Capsys) -> None:
    assert main(["settle", model, *DROP]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith("SETTLED")
    for words in ("moved: b by 0, 0, -0.01 m", "joints that open: 1", "beam", "joints that sl"):
        assert words in out
    assert main(["settle", model, *DROP, "--time-limit", "1e-9"]) == 0
    assert "followed by finite steps: Not decided" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--move", "nope:0,0,1"], "--move: no block is called 'nope'"),
        (["--move", "beam:0,0,1"], "block 'beam' is not fixed"),
        (["--move", "b:0,1"], "--move: the motion of block 'b' does not have 3 or 6 numbers"),
        (["--move", "b:0,x,1"], "--move: 'x' is not a number"),
        (["--move", "b:0,nan,1"], "--move: is nan"),
        (["--move", "0,0,1"], "--move: '0,0,1' names no block"),
        (["--move", "b:0,0,0"], "--move: no support moves"),
        (["--to", "0.1"], "--move: no support moves"),
        (["--joints", "a.csv"], "there is no table of joints or corners without --move"),
        ([*DROP, "--compliance", "0"], "--compliance: is 0;"),
        ([*DROP, "--html", "nowhere/a.html"], "--html: there is no folder"),
    ],
)
def test_motions_that_cannot_be_used_are_one_line(
    model: str, options: list[str], words: str, capsys: Capsys
) -> None:
    assert main(["settle", model, *options]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert words in err


def test_what_cannot_balance_has_exit_code_one(model: str, capsys: Capsys) -> None:
    code, told = answer(capsys, "settle", model, *DROP, "--seismic", "0.7,0")
    assert (code, told["verdict"], "joints" in told) == (1, "undecided", False)
    assert "balance" in told["message"]
