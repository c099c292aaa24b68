"""Files that were made to do harm, and names of files that are none: one line each."""

import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import FormatError, InputError, LoadCase, Model, io, save_page
from drystone.cli import main
from drystone.loads import Train
from drystone.models import box, tower
from drystone.report import TitleBlock
from drystone.seismic import SeismicDemand
from drystone.studies import read_combinations

LONG = int("1" * 400)
CUBE = box((1.0, 1.0, 1.0))
posix = pytest.mark.skipif(os.name == "nt", reason="pipes and links")


def block(name: str, z: float, **more: Any) -> dict[str, Any]:
    vertices = (CUBE.vertices + np.array([0.0, 0.0, z])).tolist()
    return {"name": name, "vertices": vertices, "faces": CUBE.faces, "fixed": z == 0.0} | more


@pytest.mark.parametrize(
    "more",
    [
        {"metadata": {"friction": LONG}},
        {"metadata": {"friction": -1.0}},
        {"density": LONG},
        {"density": 1e308},
        {"density": 1e-300},
        {"vertices": [[0, 0, LONG], *CUBE.vertices[1:].tolist()]},
        {"faces": [[3, 2, 1, LONG], *CUBE.faces[1:]]},
    ],
)
def test_numbers_that_no_float_holds_are_refused_in_one_line(
    tmp_path: Path, more: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.json"
    content = {"blocks": [block("a", 0.0), block("b", 1.0, **more)]}
    path.write_text(json.dumps(content), encoding="utf-8")
    assert main(["check", str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("drystone: ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("size", [1e-110, 1e101, 1e110])
def test_a_load_at_the_ends_of_what_a_float_holds_is_refused(size: float) -> None:
    model = Model.of(tower(2))
    with pytest.raises(InputError, match="cannot be calculated with"):
        model.with_load((0.0, 0.0, -size))
    assert drystone.check(model.with_load(LoadCase(np.zeros((2, 6))))).stable


def test_endless_continuation_lines_take_no_longer_than_their_length(tmp_path: Path) -> None:
    path = tmp_path / "model.obj"
    path.write_text("v 0 0 0\n" + "f 1 \\\n" * 200_000 + "1 1 1\n", encoding="ascii")
    with pytest.raises(FormatError, match="face corner"):
        io.read_file(path)


def test_digits_of_other_scripts_are_no_numbers(tmp_path: Path) -> None:
    path = tmp_path / "model.obj"
    for text in ("v \u0661 0 0\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf \u0661 2 3\n"):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(FormatError, match=r"is not three numbers|is no vertex"):
            io.read_file(path)


def glb(content: dict[str, Any], binary: bytes = b"") -> bytes:
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<3I", 0x46546C67, 2, 28 + len(text) + len(binary))
    parts = (
        struct.pack("<2I", len(text), 0x4E4F534A),
        text,
        struct.pack("<2I", len(binary), 0x4E4942),
    )
    return head + b"".join(parts) + binary


TRIANGLE = {
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36}],
    "nodes": [{"mesh": 0}],
    "scenes": [{"nodes": [0]}],
}


@pytest.mark.parametrize(
    "changes",
    [
        {"bufferViews": [{"buffer": 0, "byteLength": 36, "byteStride": 2**40}]},
        {"bufferViews": [{"buffer": 0, "byteLength": 36, "byteStride": LONG}]},
        {"accessors": [{"bufferView": 0, "componentType": 5126, "count": LONG, "type": "VEC3"}]},
        {"nodes": [{"mesh": 0, "children": [0]}]},
        {"nodes": [{"children": [1]}, {"children": [0]}]},
        {"buffers": [{"byteLength": 36, "uri": "file:///etc/hostname"}]},
        {"nodes": [{}] * 100_002, "scenes": [{"nodes": list(range(100_002))}]},
    ],
)
def test_scenes_that_lie_or_never_end_are_refused(tmp_path: Path, changes: dict[str, Any]) -> None:
    path = tmp_path / "model.glb"
    points = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    path.write_bytes(glb(TRIANGLE | changes, points))
    with pytest.raises(FormatError):
        io.read_file(path)


def test_a_larger_file_is_read_where_it_is_allowed(tmp_path: Path) -> None:
    path = tmp_path / "tower.obj"
    io.write(tower(2), path)
    with pytest.raises(FormatError, match="allow more"):
        io.read_file(path, max_size=1e-4)
    assert len(io.read_file(path, max_size=1.0).assembly) == 2


@posix
@pytest.mark.parametrize("kind", ["pipe", "device", "loop"])
def test_what_is_no_plain_file_is_neither_read_nor_replaced(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, odd = tmp_path / "tower.json", tmp_path / "odd.obj"
    io.write(tower(2), model)
    if kind == "pipe":
        os.mkfifo(odd)
    else:
        odd.symlink_to("/dev/null" if kind == "device" else odd)
    for given in (["convert", str(model), str(odd)], ["inspect", str(odd)]):
        assert main(given) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1
    assert odd.is_fifo() or odd.is_symlink()
    with pytest.raises(FormatError, match="not a plain file"):
        save_page(drystone.check(tower(2)), odd)


@posix
def test_a_link_is_written_through(tmp_path: Path) -> None:
    kept, link = tmp_path / "kept.obj", tmp_path / "link.obj"
    io.write(tower(2), kept)
    link.symlink_to(kept)
    io.write(tower(3), link)
    assert link.is_symlink()
    assert len(io.read_file(kept).assembly) == 3


@posix
def test_a_pipe_is_no_checkpoint(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, pipe = tmp_path / "tower.json", tmp_path / "pipe"
    io.write(tower(3), model)
    os.mkfifo(pipe)
    assert main(["plan", str(model), "--checkpoint", str(pipe)]) == 2
    assert "not a plain file" in capsys.readouterr().err


def test_names_reach_the_terminal_without_control_characters(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.json"
    name = "\x1b[31mred\u202e\x85"
    blocks = [block(name + "0", 0.0), block(name + "1", 1.0), block(name + "2", 2.0)]
    path.write_text(json.dumps({"blocks": blocks}), encoding="utf-8")
    for given in (["check"], ["inspect"], ["plan"], ["limit", "tilt", "--equilibrium-only"]):
        words = [*given[:2], str(path), *given[2:]] if given[0] == "limit" else [*given, str(path)]
        assert main([*words, *(["--gravity", "9,0,-1"] if given == ["check"] else [])]) in (0, 1)
        out, err = capsys.readouterr()
        assert not {"\x1b", "\u202e", "\x85"} & set(out + err)


@pytest.mark.parametrize("suffix", [".json", ".obj", ".stl", ".ply", ".glb", ".xml"])
def test_half_of_a_surrogate_pair_in_a_name_is_written(tmp_path: Path, suffix: str) -> None:
    names = ("low", "half \ud800 a letter")
    blocks = tuple(b.renamed(name) for b, name in zip(tower(2).blocks, names, strict=True))
    path = tmp_path / f"model{suffix}"
    io.write(Model.of(drystone.Assembly(blocks, tower(2).fixed)), path)
    assert len(io.read_file(path).assembly) == 2
    if suffix in (".json", ".ply", ".glb"):
        assert io.read_file(path).assembly.names == names
    elif suffix in (".obj", ".stl"):
        assert io.read_file(path).assembly.names[1] == "half \\ud800 a letter"


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("a." * 5000 + "b = 1", "nested too deeply"),
        ("a = " + "[" * 50_000, "nested too deeply"),
        ("#" * 2**21, "larger than 1 MiB"),
        ("a = " + "1" * 5000, "a number has no end"),
        ("a = [", "is not TOML"),
    ],
)
def test_toml_that_takes_very_much_is_refused_before_it_does(
    content: str, told: str, tmp_path: Path
) -> None:
    path = tmp_path / "side.toml"
    path.write_text(content, encoding="utf-8")
    for read in (
        lambda: read_combinations(path, Model.of(tower(2))),
        lambda: TitleBlock.read(path),
        lambda: Train.named(str(path)),
        lambda: SeismicDemand.named(path),
    ):
        with pytest.raises(FormatError, match=told) as caught:
            read()
        assert str(path) in str(caught.value)
