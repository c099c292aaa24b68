from pathlib import Path

import numpy as np
import pytest

from drystone import Assembly, FormatError, io
from drystone.assembly import replace_block
from drystone.models import arch, box, concave, dome, tower, wall

CUBE = box((1.0, 1.0, 1.0))


def text(block: str = "", faces: str | None = None) -> str:
    """A cube as text, with a comment, a normal that nobody needs and one property more."""
    vertices = "\n".join(f"{x:g} {y:g} {z:g} 0" for x, y, z in CUBE.vertices.tolist())
    loops = "\n".join(f"{len(f)} " + " ".join(map(str, f)) for f in CUBE.faces)
    return f"""ply
format ascii 1.0
comment made by hand
obj_info none
element vertex 8
property float x
property float y
property float z
property uchar red
element face 6
property list uchar int vertex_indices
{block}end_header
{vertices}
{faces or loops}
"""


def load(tmp_path: Path, data: bytes | str) -> io.Contents:
    path = tmp_path / "model.ply"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return io.read_file(path)


def binary(assembly: Assembly, order: str) -> bytes:
    """As other programs write it: one soup, single precision, byte-sized list lengths."""
    faces = assembly.faces
    name = {"<": "little", ">": "big"}[order]
    header = (
        f"ply\r\nformat binary_{name}_endian 1.0\r\nelement vertex {len(faces.point)}\r\n"
        "property float x\r\nproperty float y\r\nproperty float z\r\n"
        f"element face {faces.count}\r\nproperty uchar flags\r\n"
        "property list uchar uint vertex_index\r\nend_header\r\n"
    )
    body = faces.point.astype(order + "f4").tobytes()
    for i in range(faces.count):
        loop = faces.loop[faces.start[i] : faces.start[i + 1]]
        body += bytes([7, len(loop)]) + loop.astype(order + "u4").tobytes()
    return header.encode() + body


def test_text_is_read_and_polygons_are_kept(tmp_path: Path) -> None:
    model = load(tmp_path, text())
    (block,) = model.assembly.blocks
    assert block.name == "model"
    assert [len(f) for f in block.faces] == [4] * 6


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("assembly", [tower(4), arch(), dome(), concave("short"), wall()])
def test_a_soup_of_touching_solids_is_split_into_blocks(
    tmp_path: Path, assembly: Assembly, order: str
) -> None:
    model = load(tmp_path, binary(assembly, order))
    assert len(model.assembly) == len(assembly)
    assert sorted(model.assembly.volume) == pytest.approx(sorted(assembly.volume), rel=1e-5)


def test_writing_and_reading_keeps_everything_to_the_last_bit(tmp_path: Path) -> None:
    blocks = [
        replace_block(
            block.transformed(translation=(1 / 3, 1e4, 0.1)),
            name=f"Mauer\t{i} \u58c1",
            density=2000.0 + i / 3,
            metadata={"layer": "a\nb"} if i else {},
        )
        for i, block in enumerate((*tower(2).blocks, *concave("short").blocks))
    ]
    assembly = Assembly(tuple(blocks), np.array([True, False, False, True]))
    io.write(assembly, tmp_path / "model.ply")
    again = io.read_file(tmp_path / "model.ply")
    assert again.notes == ()
    assert again.assembly.names == assembly.names
    assert again.assembly.fixed.tolist() == assembly.fixed.tolist()
    for one, other in zip(assembly.blocks, again.assembly.blocks, strict=True):
        assert np.array_equal(one.vertices, other.vertices)
        assert (one.faces, one.density) == (other.faces, other.density)
        assert dict(one.metadata) == dict(other.metadata)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"ply", ["not a PLY file"]),
        (b"ply\nformat ascii 1.0\nend_header\n", ["has no vertices"]),
        (text().replace("format ascii 1.0\n", ""), ["does not say its format"]),
        (text().replace("ascii", "braille"), ["line 2", "braille"]),
        (text().replace("float x", "string x"), ["line 6", "string x"]),
        (text().replace("vertex 8", "vertex eight"), ["line 5", "eight"]),
        (text().replace("vertex 8", "vertex 999999999"), ["ends before its data"]),
        (text().replace("vertex 8", "vertex 99999999999999999999"), ["line 5"]),
        (text().replace("property float z", "property float w"), ["x, y and z"]),
        (text().replace("vertex_indices", "corners"), ["has no faces"]),
        (text(faces="4 0 1 2"), ["ends before its data"]),
        (text(faces="x 0 1 2 3 4"), ["values that are not numbers"]),
        (text().replace("\n4 0 3 2 1", "\n4 0 3 2 9"), ["face 0", "0 to 7"]),
        (text().replace("\n4 0 3 2 1", "\n2 0 3"), ["face 0"]),
        (text().replace("\n4 0 3 2 1", "\n4 0 3 2 nan"), ["values that are not numbers"]),
        (text().replace("\n1 0 0 0", "\nnan 0 0 0"), ["vertex 1 is not finite"]),
        (text().replace("\n1 0 0 0", "\n1 0 0 " + "9" * 30), ["values that are not numbers"]),
        (binary(tower(2), "<")[:-3], ["ends before its data"]),
        (b"ply\nformat ascii 1.0\ncomment \xff\nend_header\n", ["no text"]),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(
    tmp_path: Path, data: bytes | str, words: list[str]
) -> None:
    with pytest.raises(FormatError) as caught:
        load(tmp_path, data)
    assert "\n" not in str(caught.value)
    for word in ("model.ply", *words):
        assert word in str(caught.value)


def test_our_own_comments_are_checked(tmp_path: Path) -> None:
    io.write(tower(2), tmp_path / "tower.ply")
    data = (tmp_path / "tower.ply").read_bytes()
    line = data.split(b"\n")[3]
    with pytest.raises(FormatError, match="belongs to block 1, which has no comment"):
        load(tmp_path, data.replace(line + b"\n", b""))
    with pytest.raises(FormatError, match=r"comment\[1\].*'density' is missing"):
        load(tmp_path, data.replace(line, b'comment drystone block {"name": "a", "fixed": true}'))


def test_a_block_called_like_the_end_of_the_header_comes_back(tmp_path: Path) -> None:
    model = Assembly((replace_block(CUBE, name="end_header"),))
    io.write(model, tmp_path / "model.ply")
    assert io.read_file(tmp_path / "model.ply").assembly.names == ("end_header",)


AXES = "".join(f"property float {axis}\n" for axis in "xyz")
HEADER = f"ply\nformat ascii 1.0\nelement vertex 3\n{AXES}"
POINTS = "0 0 0\n1 0 0\n0 1 0\n"


@pytest.mark.parametrize(
    "text",
    [
        HEADER + "element face 1\nproperty int vertex_indices\nend_header\n" + POINTS + "1\n",
        HEADER.replace("float x", "list int int x")
        + "element face 1\nproperty list int int vertex_indices\nend_header\n"
        + "1 0 0 0\n1 1 0 0\n1 0 1 0\n3 0 1 2\n",
        HEADER.replace("1.0\n", '1.0\ncomment drystone block {"name":"a"}\n')
        + "element face 1\nproperty list int int vertex_indices\nproperty list int int block\n"
        + "end_header\n" + POINTS + "3 0 1 2 1 0\n",
    ],
)  # fmt: skip
def test_properties_of_another_kind_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "model.ply"
    path.write_text(text, encoding="ascii")
    with pytest.raises(FormatError):
        io.read_file(path)
