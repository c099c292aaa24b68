from pathlib import Path

import numpy as np
import pytest

from drystone import Assembly, FormatError, io
from drystone.assembly import replace_block
from drystone.models import arch, concave, tower, vault

CUBE = """v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
"""
FACES = "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
RELATIVE = (
    "f -8 -5 -6 -7\nf -4 -3 -2 -1\nf -8 -7 -3 -4\nf -7 -6 -2 -3\nf -6 -5 -1 -2\nf -5 -8 -4 -1\n"
)


def cube_at(x: float) -> str:
    rows = [line.split() for line in CUBE.splitlines()]
    return "".join(f"v {float(r[1]) + x} {r[2]} {r[3]}\n" for r in rows)


def load(tmp_path: Path, text: str, **options: str) -> io.Contents:
    path = tmp_path / "model.obj"
    path.write_text(text, encoding="utf-8")
    return io.read_file(path, **options)


def test_each_object_is_a_block_with_its_name(tmp_path: Path) -> None:
    text = f"o left pier\n{CUBE}{FACES}o right # 2\n{cube_at(3.0)}{RELATIVE}"
    model = load(tmp_path, text)
    assert model.assembly.names == ("left pier", "right # 2")
    assert [b.volume for b in model.assembly.blocks] == pytest.approx([1.0, 1.0])
    assert not model.assembly.fixed.any()


def test_each_group_is_a_block_when_there_are_no_objects(tmp_path: Path) -> None:
    model = load(tmp_path, f"{CUBE}{cube_at(3.0)}g a b\n{FACES}g c\n{RELATIVE}")
    assert model.assembly.names == ("a b", "c")


def test_groups_inside_objects_do_not_split_a_block(tmp_path: Path) -> None:
    first, second = FACES.split("\n", 2)[:2], FACES.split("\n", 2)[2]
    text = (
        f"{CUBE}o one\ng top\n" + "\n".join(first) + f"\ng side\n{second}"
        f"o two\ng top\n{cube_at(2.0)}{RELATIVE}"
    )
    assert load(tmp_path, text).assembly.names == ("one", "two")


def test_a_group_taken_up_again_goes_on_with_its_block(tmp_path: Path) -> None:
    lines = FACES.splitlines(keepends=True)
    text = (
        f"{CUBE}{cube_at(2.0)}g a\n"
        + "".join(lines[:3])
        + f"g b\n{RELATIVE}g a\n"
        + "".join(lines[3:])
    )
    assert load(tmp_path, text).assembly.names == ("a", "b")


def test_blocks_that_share_places_are_not_welded(tmp_path: Path) -> None:
    model = load(tmp_path, f"o a\n{CUBE}{FACES}o b\n{cube_at(1.0)}{RELATIVE}")
    assert [len(b.vertices) for b in model.assembly.blocks] == [8, 8]


@pytest.mark.parametrize(
    "faces",
    [
        FACES.replace(" ", " ").replace("f 1 4 3 2", "f 1/1 4/2 3/3 2/4"),
        FACES.replace("f 1 4 3 2", "f 1//1 4//1 3//1 2//1"),
        FACES.replace("f 1 4 3 2", "f 1/9/9 4/9/9 3/9/9 2/9/9"),
        FACES.replace("f 1 4 3 2", "f 1 4 \\\n 3 2"),
        FACES.replace("f 1 4 3 2", "f  1\t4 3 2   # bottom"),
        RELATIVE,
        FACES.replace("\n", "\r\n"),
        "s off\nusemtl stone\nvn 0 0 1\nvt 0 0\n" + FACES,
    ],
)
def test_every_way_to_write_a_face_is_read(tmp_path: Path, faces: str) -> None:
    block = load(tmp_path, f"mtllib x.mtl\no cube\n{CUBE}{faces}").assembly.blocks[0]
    assert [len(f) for f in block.faces] == [4] * 6
    assert block.volume == pytest.approx(1.0)


def test_nameless_blocks_are_named_and_that_is_told(tmp_path: Path) -> None:
    model = load(tmp_path, f"{CUBE}{FACES}o b\n{cube_at(2.0)}{RELATIVE}")
    assert model.assembly.names == ("block-0", "b")
    assert any("has no name" in note for note in model.notes)
    assert load(tmp_path, CUBE + FACES).assembly.names == ("model",)


def test_an_object_without_the_faces_of_its_vertices_is_told(tmp_path: Path) -> None:
    whole = f"o pier\n{CUBE}{FACES}"
    found = load(tmp_path, whole + f"o cap\n{cube_at(2.0)}")
    assert found.assembly.names == ("pier",)
    assert "'cap' at line 16 has vertices and no faces: was the file cut off there?" in found.notes
    assert not load(tmp_path, whole + "o empty\n").notes


def test_corners_written_once_per_face_are_merged_and_that_is_told(tmp_path: Path) -> None:
    rows = [line[2:] for line in CUBE.splitlines()]
    faces = [[int(i) - 1 for i in line.split()[1:]] for line in FACES.splitlines()]
    text = "".join("".join(f"v {rows[i]}\n" for i in f) + "f -4 -3 -2 -1\n" for f in faces)
    model = load(tmp_path, text)
    assert len(model.assembly.blocks[0].vertices) == 8
    assert "16 coincident vertices merged" in model.notes[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (CUBE + FACES.replace("f 1 4", "f 9 4"), ["line 9", "'9'", "8 vertices"]),
        (CUBE + FACES.replace("f 1 4", "f 0 4"), ["line 9", "'0'"]),
        (CUBE + FACES.replace("f 1 4", "f -9 4"), ["line 9", "'-9'"]),
        (CUBE + FACES.replace("f 1 4", "f x 4"), ["line 9", "'x'"]),
        (CUBE + "f 1 2\n", ["line 9", "three corners"]),
        (CUBE.replace("v 1 0 0", "v 1 0"), ["line 2", "three numbers"]),
        (CUBE.replace("v 1 0 0", "v nan 0 0") + FACES, ["line 2", "finite"]),
        (CUBE.replace("v 1 0 0", "v inf 0 0") + FACES, ["line 2", "finite"]),
        (CUBE.replace("v 1 0 0", "v 1e999 0 0") + FACES, ["line 2", "finite"]),
        (CUBE.replace("v 1 0 0", "v 1_0 0 0") + FACES, ["line 2", "three numbers"]),
        (CUBE, ["holds no block"]),
        ("curv 0 1 2 3\n", ["line 1", "free-form"]),
        ("<html></html>\n", ["line 1", "is not OBJ"]),
        ("call other.obj\n", ["line 1", "is not OBJ"]),
        (f"o a\n{CUBE}{FACES}o a\n{cube_at(3.0)}{RELATIVE}", ["same name, 'a'", "rename"]),
        (f"g a\n{CUBE}{FACES}g b\ng a\n{cube_at(3.0)}{RELATIVE}", ["same name, 'a'"]),
        (f"o a\n{CUBE}{FACES[:-10]}", ["block 'a'", "open mesh", "close the holes"]),
    ],
)
def test_what_cannot_be_read_names_its_line(tmp_path: Path, text: str, words: list[str]) -> None:
    with pytest.raises(FormatError) as caught:
        load(tmp_path, text)
    assert "\n" not in str(caught.value)
    for word in ("model.obj", *words):
        assert word in str(caught.value)


@pytest.mark.parametrize("assembly", [tower(2), arch(), concave("short"), vault()])
def test_writing_and_reading_keeps_names_polygons_and_every_bit(tmp_path: Path, assembly) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "model.obj"
    io.write(assembly, path)
    again = io.read_file(path).assembly
    assert again.names == assembly.names
    for one, other in zip(assembly.blocks, again.blocks, strict=True):
        assert np.array_equal(one.vertices, other.vertices)
        assert one.faces == other.faces


@pytest.mark.parametrize(("units", "volume"), [("mm", 1e-9), ("ft", 0.3048**3)])
def test_lengths_are_in_the_unit_that_is_named(tmp_path: Path, units: str, volume: float) -> None:
    model = load(tmp_path, CUBE + FACES, units=units)
    assert model.assembly.blocks[0].volume == pytest.approx(volume)


def test_a_number_of_very_many_digits_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="not three numbers"):
        load(tmp_path, f"v 0 0 {'9' * 200_000}-\n")


@pytest.mark.parametrize(("line", "is_cut"), [("v 1 x 0", False), ("v 1 0", True), ("v 1 x", True)])
def test_a_vertex_that_is_whole_is_not_told_to_be_cut_off(
    line: str, is_cut: bool, tmp_path: Path
) -> None:
    with pytest.raises(FormatError, match="not three numbers") as refused:
        load(tmp_path, f"{line}\n")
    assert ("cut off" in refused.value.remedy) == is_cut


def test_spaces_between_the_words_of_a_name_are_kept(tmp_path: Path) -> None:
    model = tower(2)
    blocks = [
        replace_block(model.blocks[0], name="a b"),
        replace_block(model.blocks[1], name="a  b"),
    ]
    io.write(Assembly(tuple(blocks)), tmp_path / "model.obj")
    assert io.read_file(tmp_path / "model.obj").assembly.names == ("a b", "a  b")
