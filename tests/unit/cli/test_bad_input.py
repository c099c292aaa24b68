"""Bad input: one line that says what, where and what to do, exit 2, no file left behind."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drystone import Assembly, io
from drystone.cli import main
from drystone.models import box, tower

CUBE = box((1.0, 1.0, 1.0))


def block(name: str = "a", x: float = 0.0, **changes: Any) -> dict[str, Any]:
    vertices = (CUBE.vertices + np.array([x, 0.0, 0.0])).tolist()
    content = {"name": name, "vertices": vertices, "faces": [list(f) for f in CUBE.faces]}
    return content | changes


def scaled(factors: list[float]) -> list[list[float]]:
    rows: list[list[float]] = (CUBE.vertices * factors).tolist()
    return rows


FACES = [list(f) for f in CUBE.faces]
OUTLINE = [(0, 0), (4, 0), (4, 1.5), (3, 1), (1, 1), (1, 2), (3, 2), (4, 1.5), (4, 3), (0, 3)]
SELF_TOUCHING = {
    "name": "a",
    "vertices": [[x, y, z] for z in (0, 1) for x, y in OUTLINE],
    "faces": [list(range(10))[::-1], list(range(10, 20))]
    + [[i, (i + 1) % 10, (i + 1) % 10 + 10, i + 10] for i in range(10)],
}
NAN = float("nan")

MODELS: dict[str, tuple[str, bytes | list[dict[str, Any]], list[str]]] = {
    "wrong suffix": ("model.doc", b"x", [".doc", ".obj"]),
    "empty": ("model.obj", b"", ["the file is empty"]),
    "truncated": ("model.json", b'{"blocks": [{"name"', ["ends too early", "line 1"]),
    "nan": (
        "model.json",
        [block(), block("b", vertices=[[0, 0, NAN], *CUBE.vertices[1:].tolist()])],
        ["blocks[1].vertices[0][2]", "nan", "finite"],
    ),
    "infinite": (
        "model.json",
        [block(vertices=[[0, float("inf"), 0], *CUBE.vertices[1:].tolist()])],
        ["blocks[0].vertices[0][1]", "inf"],
    ),
    "open": ("model.json", [block(faces=FACES[1:])], ["block 'a'", "open mesh", "0-1"]),
    "non-manifold": ("model.json", [block(faces=[*FACES, [0, 1, 6, 7]])], ["non-manifold", "0-1"]),
    "self-touching": ("model.json", [SELF_TOUCHING], ["block 'a'", "itself", "separate"]),
    "one name twice": ("model.json", [block(), block("a", 2.0)], ["same name, 'a'", "rename"]),
    "zero volume": ("model.json", [block(vertices=scaled([1, 1, 0]))], ["volume is zero"]),
    "doubled": ("model.json", [block(), block("b")], ["'a' and 'b'", "twice", "remove"]),
    "no support": (
        "model.json",
        [block()],
        ["no block is fixed; --supports: 'lowest' would fix 1 block (a)", "'below:0.1' 1 block"],
    ),
}


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = main(arguments)
    out, err = capsys.readouterr()
    return code, out, err


@pytest.mark.parametrize("case", MODELS)
def test_a_bad_model_gets_one_line_and_exit_2(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, content, words = MODELS[case]
    path = tmp_path / name
    data = content if isinstance(content, bytes) else json.dumps({"blocks": content}).encode()
    path.write_bytes(data)
    code, out, err = answer(capsys, "check", str(path), "--html", str(tmp_path / "page.html"))
    assert (code, out) == (2, "")
    assert err.startswith("drystone: ")
    assert err.count("\n") == 1
    for word in (name, *words):
        assert word in err
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--supports", "blok-1"], ["'blok-1'", "did you mean block-1"]),
        (["--supports", "pier*"], ["'pier*'", "names are like"]),
        (["--supports", "below:-3"], ["no block reaches down to -3 m"]),
        (["--friction", "-0.1"], ["--friction", "-0.1", "zero or more"]),
        (["--friction", "nan"], ["--friction", "nan"]),
        (["--friction", "inf"], ["--friction", "inf"]),
        (["--friction", "much"], ["--friction", "number"]),
        (["--density", "0"], ["--density", "above zero"]),
        (["--density", "nan"], ["--density", "nan"]),
        (["--units", "parsec"], ["--units: is 'parsec'", "mm, cm, m, in, ft"]),
        (["--gravity", "down"], ["--gravity", "'down'"]),
        (["--gravity", "0,0,0"], ["--gravity", "zero"]),
        (["--gravity", "-9.81"], ["--gravity", "above zero"]),
        (["--gravity", "9810"], ["--gravity", "up to 5000 m/s2"]),
        (["--gravity", "0,0,-9810"], ["--gravity", "up to 5000 m/s2"]),
        (["--seismic", "1e9"], ["--seismic", "up to 500"]),
        (["--gravity", "1,2"], ["--gravity", "three"]),
        (["--gravity", "0,0,nan"], ["--gravity", "finite"]),
        (["--time-limit", "-1"], ["--time-limit", "above zero"]),
        (["--html", "page.pdf"], ["--html", "page.pdf", ".html"]),
        (["--html", "no/folder/page.html"], ["--html", "no/folder"]),
        (["--png", "figure.jpg"], ["--png", "figure.jpg", ".png, .svg or .pdf"]),
        (["--html", "one.html", "--joints", "./one.html"], ["one.html", "named twice"]),
        (["--joints", "one.csv", "--joints", "one.csv"], ["one.csv", "named twice"]),
        (["--colour", "red"], ["--colour", "check --help"]),
        (["another.obj"], ["another.obj", "no such file"]),
    ],
)
def test_a_bad_option_gets_one_line_and_exit_2(
    options: list[str], words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tower.json"
    io.write(tower(2), path)
    code, out, err = answer(capsys, "check", str(path), *options)
    assert (code, out) == (2, "")
    assert err.startswith("drystone: ")
    assert err.count("\n") == 1
    for word in words:
        assert word in err
    assert list(tmp_path.iterdir()) == [path]


def test_a_missing_file_gets_one_line_and_exit_2(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = answer(capsys, "check", "missing.obj")
    assert (code, out) == (2, "")
    assert err == "drystone: missing.obj: there is no such file; check the path\n"


def test_a_study_takes_friction_as_a_parameter(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = answer(capsys, "study", "arch", "--friction", "0.5")
    assert code == 2
    assert "--set friction=VALUE" in err


def test_an_unknown_command_gets_one_line_and_exit_2(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = answer(capsys, "chekc")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert "did you mean 'check'" in err.lower()


@pytest.mark.parametrize("command", ["check", "inspect"])
def test_errors_are_objects_where_json_is_asked_for(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = answer(capsys, command, "missing.obj", "--json")
    assert code == 2
    assert err.count("\n") == 1
    told = json.loads(out)
    assert told["exit_code"] == 2
    assert told["error"]["type"] == "FormatError"
    assert told["error"]["where"] == "missing.obj"
    assert told["error"]["remedy"] == "check the path"


def test_wrong_usage_is_an_object_where_json_is_asked_for(
    capsys: pytest.CaptureFixture[str],
) -> None:
    code, out, _ = answer(capsys, "check", "--json")
    assert code == 2
    assert "MODEL" in json.loads(out)["error"]["message"]


def test_inspect_lists_every_defect_and_exits_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.json"
    blocks = [block(), block("b", 2.0, faces=FACES[1:]), block("a", 4.0)]
    path.write_text(json.dumps({"blocks": blocks}), encoding="utf-8")
    code, out, _ = answer(capsys, "inspect", str(path), "--json")
    told = json.loads(out)
    assert code == 2
    assert [one["block"] for one in told["blocks"]] == ["a", "a"]
    assert ["open mesh" in one["what"] for one in told["defects"]] == [True, False]
    page = tmp_path / "page.html"
    code, out, _ = answer(capsys, "inspect", str(path), "--html", str(page))
    assert code == 2
    assert out.count("defect:") == 2
    assert "found among the 1 block that can be used, 2 blocks left out" in " ".join(out.split())
    assert "faces at holes" in page.read_text(encoding="utf-8")


def test_contacts_among_good_blocks_are_found_beside_defective_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.json"
    blocks = [block(), block("b", 1.0), block("open", 4.0, faces=FACES[1:])]
    path.write_text(json.dumps({"blocks": blocks}), encoding="utf-8")
    code, out, _ = answer(capsys, "inspect", str(path), "--supports", "gone", "--json")
    told = json.loads(out)
    assert code == 2
    assert told["contacts"]["pairs"] == 1
    (defect,) = told["defects"]
    assert "of faces " in defect["what"]
    assert any("--supports waits" in note for note in told["notes"])


def test_nothing_is_looked_for_without_a_good_block(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.json"
    path.write_text(json.dumps({"blocks": [block(faces=FACES[1:])]}), encoding="utf-8")
    code, out, _ = answer(capsys, "inspect", str(path))
    assert code == 2
    assert "once the defects are mended" in out


def test_a_folder_is_checked_and_so_are_several_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for i, name in enumerate(("base", "top")):
        stone = box((1.0, 1.0, 1.0), (0.0, 0.0, float(i)))
        io.write(Assembly((stone,)), tmp_path / f"{name}.obj")
    both = [str(tmp_path / f"{name}.obj") for name in ("base", "top")]
    for given in ([str(tmp_path)], both):
        code, out, _ = answer(capsys, "check", *given, "--supports", "base", "--json")
        assert code == 0
        told = json.loads(out)
        assert (told["verdict"], told["asked"]["blocks"]) == ("stable", 2)
    assert told["model"] == "2 files"
