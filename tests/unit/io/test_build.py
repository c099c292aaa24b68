"""What is wrong with the shapes of a file, whatever its format."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import FormatError, io
from drystone.models import box, vault

CUBE = box((1.0, 1.0, 1.0))


def block(name: str = "a", x: float = 0.0, **changes: Any) -> dict[str, Any]:
    vertices = (CUBE.vertices + np.array([x, 0.0, 0.0])).tolist()
    content = {"name": name, "vertices": vertices, "faces": [list(f) for f in CUBE.faces]}
    return content | changes


def extrusion(outline: list[tuple[float, float]]) -> dict[str, Any]:
    n = len(outline)
    vertices = [[x, y, z] for z in (0.0, 1.0) for x, y in outline]
    faces = [list(range(n))[::-1], list(range(n, 2 * n))]
    faces += [[i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n)]
    return {"name": "extrusion", "vertices": vertices, "faces": faces}


def file(tmp_path: Path, *blocks: dict[str, Any]) -> Path:
    path = tmp_path / "model.json"
    path.write_text(json.dumps({"blocks": blocks}), encoding="utf-8")
    return path


RING = [(0, 0), (4, 0), (4, 1.5), (1, 1.5), (1, 1.6), (4, 1.6), (4, 3), (0, 3)]
TOUCHING = [(0, 0), (4, 0), (4, 1.5), (3, 1), (1, 1), (1, 2), (3, 2), (4, 1.5), (4, 3), (0, 3)]
BOW_TIE = [(0, 0), (2, 1), (2, 0), (0, 2)]


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        (block(faces=[list(f) for f in CUBE.faces[1:]]), ["open mesh", "4 edges", "close"]),
        (
            block(faces=[list(f) for f in CUBE.faces] + [[0, 1, 6, 7]]),
            ["non-manifold", "more than two faces"],
        ),
        (block(vertices=(CUBE.vertices * [1, 1, 0]).tolist()), ["volume is zero", "thickness"]),
        (block(vertices=(CUBE.vertices * 0).tolist()), ["volume is zero"]),
        (block(faces=[[0, 1, 2]]), ["has 1 face;", "four or more"]),
        (block(faces=[[0, 0, 2, 1], *CUBE.faces[1:]]), ["face 0", "none twice"]),
        (extrusion(BOW_TIE), ["outline of face 0"]),
        (extrusion(TOUCHING), ["outline of face 0"]),
    ],
)
def test_shapes_without_a_proper_inside_are_refused(
    tmp_path: Path, shape: dict[str, Any], words: list[str]
) -> None:
    with pytest.raises(FormatError) as caught:
        io.read_file(file(tmp_path, shape))
    text = str(caught.value)
    assert "\n" not in text
    for word in ("model.json", f"block '{shape['name']}'", *words):
        assert word in text


def test_concave_shapes_with_a_narrow_gap_are_fine(tmp_path: Path) -> None:
    model = io.read_file(file(tmp_path, extrusion(RING)))
    assert model.assembly.blocks[0].volume == pytest.approx(12.0 - 0.3)


def test_inside_out_blocks_are_turned_and_that_is_told(tmp_path: Path) -> None:
    shape = block(faces=[list(f)[::-1] for f in CUBE.faces])
    model = io.read_file(file(tmp_path, shape, block("b", 2.0)))
    assert model.assembly.blocks[0].volume == pytest.approx(1.0)
    assert model.notes == ("block 'a': all faces pointed inwards, and are turned",)


def test_single_turned_faces_are_turned_back_and_that_is_told(tmp_path: Path) -> None:
    faces = [list(f) for f in CUBE.faces]
    faces[3].reverse()
    model = io.read_file(file(tmp_path, block(faces=faces)))
    assert model.assembly.blocks[0].volume == pytest.approx(1.0)
    assert model.notes == ("block 'a': faces 3 turned to agree with the others",)


def test_one_note_tells_of_many_blocks_that_were_mended_alike(tmp_path: Path) -> None:
    faces = [list(f)[::-1] for f in CUBE.faces]
    shapes = [block(f"block-{i}", 2.0 * i, faces=faces) for i in range(8)]
    (note,) = io.read_file(file(tmp_path, *shapes)).notes
    assert note.startswith(
        "blocks 'block-0', 'block-1', 'block-2' and 5 more: all faces pointed in"
    )


def test_a_block_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    twin = block("copy", vertices=(CUBE.vertices[::-1] + 1e-12).tolist())
    twin["faces"] = [[7 - i for i in face] for face in CUBE.faces]
    with pytest.raises(FormatError, match="'a' and 'copy' are the same block twice"):
        io.read_file(file(tmp_path, block("a"), block("b", 1.0), twin))


def test_blocks_of_one_shape_at_different_places_are_not_doubles(tmp_path: Path) -> None:
    model = io.read_file(file(tmp_path, block("a"), block("b", 1.0), block("c", 1.5)))
    assert len(model.assembly) == 3


def test_all_defects_of_a_file_are_found_and_counted(tmp_path: Path) -> None:
    path = file(
        tmp_path,
        block("good"),
        block("open", 2.0, faces=[list(f) for f in CUBE.faces[1:]]),
        block("flat", vertices=(CUBE.vertices * [1, 1, 0] + 5.0).tolist()),
        block("good", 4.0),
    )
    with pytest.raises(
        FormatError, match=r"block 'open'.*\(2 more; 'drystone inspect' lists all.*--skip-defects"
    ):
        io.read_file(path)
    built = io.inspect(path)
    assert [b is None for b in built.blocks] == [False, True, True, False]
    assert built.assembly is None
    assert ["same name" in str(defect) for defect in built.defects] == [False, False, True]


def test_unreadable_units_are_refused_before_the_file_is_touched(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match="units is 'yard'; give one of 'mm', 'cm', 'm', 'in', 'ft'"
    ):
        io.read_file(tmp_path / "missing.json", units="yard")


def two_cubes(name: str = "pair") -> dict[str, Any]:
    vertices = np.concatenate([CUBE.vertices, CUBE.vertices + np.array([2.0, 0, 0])])
    faces = [[8 * i + corner for corner in face] for i in range(2) for face in CUBE.faces]
    return {"name": name, "vertices": vertices.tolist(), "faces": faces, "fixed": True}


def test_a_block_of_two_parts_moves_as_one_and_that_is_told(tmp_path: Path) -> None:
    model = io.read_file(file(tmp_path, two_cubes()))
    assert model.assembly.names == ("pair",)
    assert model.assembly.volume == pytest.approx([2.0])
    assert model.notes == ("block 'pair' has 2 separate parts that move as one (see split)",)


def test_the_parts_of_a_block_become_blocks_when_asked_for(tmp_path: Path) -> None:
    model = io.read_file(file(tmp_path, two_cubes(), block("b", 9.0)), split=True)
    assert model.assembly.names == ("pair-0", "pair-1", "b")
    assert model.assembly.fixed.tolist() == [True, True, False]
    assert model.assembly.volume == pytest.approx([1.0, 1.0, 1.0])


def test_a_part_that_is_inside_out_does_not_eat_the_volume_of_the_other(tmp_path: Path) -> None:
    shape = two_cubes()
    shape["faces"][6:] = [face[::-1] for face in shape["faces"][6:]]
    for vertex in shape["vertices"][8:]:
        vertex[2] *= 1.25
    model = io.read_file(file(tmp_path, shape))
    assert model.assembly.volume == pytest.approx([2.25])
    assert "block 'pair': 1 of its shells turned" in model.notes


def test_each_open_shape_is_a_defect(tmp_path: Path) -> None:
    loose = [block(f"l{i}", 2.0 * i, faces=[[0, 1, 2, 3]] * 3 + [[4, 5, 6, 7]]) for i in range(20)]
    holed = [
        block(f"h{i}", 2.0 * i, faces=[list(f) for f in CUBE.faces[1:]]) for i in range(20, 40)
    ]
    assert len(io.inspect(file(tmp_path, *loose, *holed)).defects) == 40


def test_each_open_shape_is_closed_by_its_own_vertices(tmp_path: Path) -> None:
    corners = [
        [(CUBE.vertices + np.array([2.0 * i, 0.0, 0.0]))[k].tolist() for f in CUBE.faces for k in f]
        for i in range(3)
    ]
    faces = [list(range(4 * k, 4 * k + 4)) for k in range(6)]
    blocks = [block(f"b{i}", vertices=corner, faces=faces) for i, corner in enumerate(corners)]
    built = io.inspect(file(tmp_path, *blocks, block("open", 9.0, faces=faces[:1] * 4)))
    assert [one is None for one in built.blocks] == [False, False, False, True]
    assert all(len(one.vertices) == 8 for one in built.blocks if one is not None)


def test_faces_that_are_there_twice_are_left_out_and_that_is_told(tmp_path: Path) -> None:
    """Once with shared vertices, some turned; once with vertices of their own."""
    faces = [list(f) for f in CUBE.faces]
    shared = block(faces=[*faces, *(face[::-1] for face in faces[:4])])
    apart = block(
        "b",
        2.0,
        vertices=(CUBE.vertices + np.array([2.0, 0, 0])).tolist() * 2,
        faces=[*faces, *([i + 8 for i in face] for face in faces)],
    )
    model = io.read_file(file(tmp_path, shared))
    assert model.assembly.blocks[0].volume == pytest.approx(1.0)
    assert model.notes == ("block 'a': 4 faces that occur twice left out",)
    with pytest.raises(FormatError, match=r"a part of it is there twice.*--repair would mend it"):
        io.read_file(file(tmp_path, apart))
    once = io.read_file(file(tmp_path, block(faces=[*faces, faces[0]])))
    assert once.notes == ("block 'a': 1 face that occurs twice left out",)


def test_blocks_with_defects_are_left_out_on_request(tmp_path: Path) -> None:
    opened = block("open", 2.0, faces=[list(f) for f in CUBE.faces[1:]])
    path = file(tmp_path, block("a"), opened, block("a", 4.0), block("c"))
    model = io.read_file(path, skip_defects=True)
    assert model.assembly.names == ("a",)
    assert model.notes[-1] == "3 blocks with defects left out ('drystone inspect' lists them)"
    assert drystone.read(path, skip_defects=True, supports="a").assembly.fixed.all()
    with pytest.raises(FormatError, match="open mesh"):
        io.read_file(file(tmp_path, opened), skip_defects=True)


@pytest.mark.parametrize(("scale", "suggested"), [(100.0, "cm"), (1000.0, "mm")])
def test_a_unit_is_suggested_for_blocks_that_are_too_large(
    tmp_path: Path, scale: float, suggested: str
) -> None:
    path = tmp_path / "vault.obj"
    io.write(vault().transformed(scale * np.eye(3)), path)
    (note,) = io.read_file(path).notes
    assert f"is the unit right (--units {suggested})?" in note
    assert io.read_file(path, units=suggested).notes == ()
