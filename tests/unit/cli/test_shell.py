"""What ``drystone shell`` builds, writes and refuses."""

import csv
from pathlib import Path

import numpy as np
import pytest

from drystone import io
from drystone.cli import main
from drystone.shells.shell_families import shell_by_name
from tests.unit.cli.running import Capsys, answer

DOME = ("shell", "dome", "--courses", "4", "--blocks", "8", "--thickness", "0.4")


def test_three_vaults_can_be_built_from_their_name_alone() -> None:
    """With the 12 courses of other surfaces blocks overlap by 0.3 mm."""
    assert len(shell_by_name("three-vaults").voussoirs) == 183


def test_shell_builds_checks_and_writes(tmp_path: Path, capsys: Capsys) -> None:
    model, table = tmp_path / "dome.json", tmp_path / "dome.csv"
    flat, folder = tmp_path / "dome.svg", tmp_path / "blocks"
    code, told = answer(
        capsys,
        *DOME,
        *("--out", str(model), "--schedule", str(table), "--unrolled", str(flat)),
        *("--block-files", str(folder), "--ground", "blocks"),
    )
    assert code == 0
    assert told["verdict"] == "stable"
    assert told["shell"]["voussoirs"] == 32
    assert told["shell"]["ground_blocks"] == 8
    assert told["shell"]["planar"] is True
    assert told["shell"]["warp_after"] < 1e-6
    assert len(told["files"]) == 4
    assert len(io.read(model).assembly) == 40
    with table.open() as file:
        assert len(list(csv.DictReader(file))) == 32
    assert flat.read_text().startswith("<svg")
    assert len(list(folder.iterdir())) == 32


def test_joints_are_made_plane_or_kept_as_triangles(tmp_path: Path, capsys: Capsys) -> None:
    flat = tmp_path / "flat.svg"
    vault = ("shell", "tri-dome", "--courses", "4", "--width", "1.6", "--thickness", "0.3")
    drawn = []
    for joints in ("plane", "faceted"):
        code, told = answer(capsys, *vault, "--joints", joints, "--unrolled", str(flat))
        assert (code, told["verdict"]) == (0, "stable")
        assert told["shell"]["planar"] is (joints == "plane")
        drawn.append(flat.read_text().count("<polygon"))
    assert drawn[1] > 1.3 * drawn[0]


def test_files_of_single_blocks_have_the_format_asked_for(tmp_path: Path, capsys: Capsys) -> None:
    folder = tmp_path / "blocks"
    answer(capsys, *DOME, "--block-files", str(folder), "--block-format", "stl")
    assert {path.suffix for path in folder.iterdir()} == {".stl"}
    (block,) = io.read(folder / "c01-b03.stl").assembly.blocks
    assert block.name == "c01-b03"
    assert np.abs(block.centroid).max() < 1e-9


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path, capsys: Capsys) -> None:
    taken = tmp_path / "taken"
    taken.write_text("a file")
    assert main([*DOME, "--block-files", str(taken / "blocks")]) == 2
    err = capsys.readouterr().err
    assert "--block-files" in err
    assert "taken' is no folder; name another folder" in err
    assert err.count("\n") == 1


def test_shell_tells_a_person_what_was_built(capsys: Capsys) -> None:
    assert main(list(DOME)) == 0
    out = capsys.readouterr().out
    assert "STABLE" in out
    assert "32 voussoirs in 4 courses, 8 of them supports" in out


def test_a_form_is_found_for_a_plan(capsys: Capsys) -> None:
    code, told = answer(
        capsys, "shell", "free-edge", "--courses", "5", "--width", "1.2", "--wedge", "0.2"
    )
    assert code == 0
    assert told["notes"][0].startswith("form found in")


@pytest.fixture
def barrel_file(tmp_path: Path) -> str:
    """The mesh of a semicircular barrel of 2 m radius, 4 m long."""
    angle, y = np.meshgrid(np.linspace(0, np.pi, 13), np.linspace(0, 4, 9), indexing="ij")
    points = np.stack([-2 * np.cos(angle), y, 2 * np.sin(angle)], axis=-1).reshape(-1, 3)
    n = np.arange(13 * 9).reshape(13, 9) + 1
    quads = np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]], axis=-1).reshape(-1, 4)
    lines = [f"v {x} {y} {z}" for x, y, z in points.tolist()]
    lines += ["f " + " ".join(map(str, quad)) for quad in quads.tolist()]
    path = tmp_path / "barrel.obj"
    path.write_text("\n".join(lines))
    return str(path)


def test_a_mesh_file_is_a_surface(barrel_file: str, capsys: Capsys) -> None:
    _, told = answer(
        capsys,
        *("shell", barrel_file, "--courses", "9", "--blocks", "3", "--supports", "left,right"),
        *("--thickness", "0.4"),
    )
    assert "mm from the patch" in told["notes"][0]
    assert told["shell"]["voussoirs"] == 31
    assert told["shell"]["supports"] == ["patch 0, left", "patch 0, right"]
    assert not any("assumed" in note for note in told["notes"])


def test_assumed_supports_of_a_mesh_are_told(barrel_file: str, capsys: Capsys) -> None:
    """Both long sides, which rise by 0.4 m in their middle: neither is lower than the other."""
    path = Path(barrel_file)
    bent = []
    for line in path.read_text().splitlines():
        word = line.split()
        if word[0] == "v":
            x, y, z = map(float, word[1:])
            line = f"v {x} {y} {z + 0.1 * y * (4.0 - y)}"
        bent.append(line)
    path.write_text("\n".join(bent))
    assert main(["shell", barrel_file, "--courses", "9", "--blocks", "3"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    note = "stands on its lowest sides (bottom, top: names, not heights), assumed: "
    assert note + "--supports names others" in told


def test_the_numbers_of_a_mesh_file_have_a_unit(barrel_file: str, capsys: Capsys) -> None:
    arguments = ["shell", barrel_file, "--courses", "9", "--blocks", "3"]
    _, metres = answer(capsys, *arguments, "--thickness", "0.4")
    _, feet = answer(capsys, *arguments, "--thickness", "0.12192", "--units", "ft")
    assert feet["shell"]["volume"] == pytest.approx(0.3048**3 * metres["shell"]["volume"])


def test_a_mesh_file_may_have_y_up(barrel_file: str, tmp_path: Path, capsys: Capsys) -> None:
    lines = Path(barrel_file).read_text().splitlines()
    turned = tmp_path / "lying.obj"
    told = [line.split() for line in lines]
    turned.write_text("\n".join(
        f"v {w[1]} {w[3]} {-float(w[2])}" if w and w[0] == "v" else " ".join(w) for w in told
    ))  # fmt: skip
    options = ["--courses", "9", "--blocks", "3", "--thickness", "0.4"]
    _, upright = answer(capsys, "shell", barrel_file, *options)
    _, lying = answer(capsys, "shell", str(turned), *options, "--up", "y")
    assert lying["verdict"] == upright["verdict"]
    assert lying["asked"]["size"] == pytest.approx(upright["asked"]["size"], abs=1e-6)


def test_a_large_drift_is_a_note(capsys: Capsys) -> None:
    _, told = answer(
        capsys, "shell", "free-edge", "--courses", "12", "--width", "0.4", "--time-limit", "5"
    )
    assert told["shell"]["drift"] > 0.25
    assert any("the surface twists at block" in note for note in told["notes"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("bogus", ["surface 'bogus' is not known", "three-vaults"]),
        ("missing.obj", ["missing.obj", "no such file"]),
        ("dome --eye 7", ["an eye of 3.5 m radius"]),
        ("dome --eye -1", ["--eye", "number above zero"]),
        ("dome --blocks 2", ["course 0", "2 blocks in a course are too few"]),
        ("barrel --wedge 0.7", ["block 'c00-b00'", "inside out"]),
        ("barrel --thickness 8", ["larger than the radius of curvature 3 m"]),
        ("barrel --rise 5", ["more than half the span"]),
        ("barrel --supports left", ["--supports", "mesh files"]),
        ("barrel --courses 0", ["one or more courses"]),
        ("barrel --blocks 4 --width 1", ["--blocks and --width"]),
        ("barrel --out shell.doc", ["--out", "shell.json"]),
        ("barrel --joggle 45", ["the joggle is 45.0 degrees", "give 10 to 25"]),
        ("barrel --joggle nan", ["--joggle", "is nan", "finite"]),
        ("dome --wedge nan", ["--wedge", "is nan", "finite"]),
        ("dome --blocks 1", ["1 block in a course is too few"]),
        ("dome --width 1e-9", ["blocks in a course are too many"]),
        ("dome --courses 9000", ["more than 5,000 courses"]),
        ("dome --rise 2", ["--rise", "is for barrel, free-edge, three-vaults, tri-dome"]),
        ("three-vaults --length 3", ["--length", "leave it out for 'three-vaults'"]),
        ("barrel --keystone", ["--keystone", "is for pavilion, dome"]),
        ("barrel --eye 1", ["--eye", "is for pavilion, dome"]),
        ("barrel --block-files x --block-format doc", ["--block-format", "use one of obj, stl"]),
        ("barrel --block-format stl", ["--block-format", "is for --block-files"]),
        ("barrel --units mm", ["--units", "is for mesh files"]),
        ("missing.obj --span 3", ["--span", "leave it out for a mesh file"]),
    ],
)
def test_bad_input_is_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capsys,
    arguments: str,
    words: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["shell", *arguments.split()]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert all(word in err for word in words)
    assert not list(tmp_path.iterdir())


def test_a_mesh_of_an_improbable_size_is_asked_about(barrel_file: str, capsys: Capsys) -> None:
    """As the blocks of a file are: before the work, with the option to type."""
    numbers = [
        " ".join([line[0], *(str(1e3 * float(x)) for x in line[2:].split())])
        if line[0] == "v"
        else line
        for line in Path(barrel_file).read_text().splitlines()
    ]
    Path(barrel_file).write_text("\n".join(numbers))
    arguments = ["shell", barrel_file, "--courses", "9", "--blocks", "3"]
    assert main(arguments) == 0
    told = capsys.readouterr()
    assert "no unit was given, metres assumed: is the unit right (--units mm)?" in told.err
    assert main([*arguments, "--units", "mm"]) == 0
    told = capsys.readouterr()
    assert "is the unit right" not in told.err + told.out
    assert "mm thick, a thirtieth of its size: --thickness gives another" in told.out
    assert "safety: forces balance a tilt about x or y of " in told.out


def test_the_thickness_of_a_shell_is_told(capsys: Capsys) -> None:
    sentences = [
        answer(capsys, "shell", "barrel", "--courses", "5", "--blocks", "2", *more)[1]["shell"]
        for more in ((), ("--thickness", "0.6"))
    ]
    assert "450 mm thick, usual of its form: --thickness gives another" in sentences[0]["sentences"]
    assert "600 mm thick" in sentences[1]["sentences"]
