import struct
from pathlib import Path

import numpy as np
import pytest

from drystone import Assembly, FormatError, io
from drystone.geometry.triangulate import triangulate
from drystone.models import arch, box, concave, dome, tower, wall

FAMILIES = [tower(4), arch(), dome(), concave("short"), wall()]
NAMES = ["tower", "arch", "dome", "concave", "wall"]


def triangles(assembly: Assembly) -> np.ndarray:
    faces = assembly.faces
    triangle, _ = triangulate(faces.point[faces.loop], faces.start)
    return faces.point[faces.loop[triangle]]


def binary(assembly: Assembly, header: bytes = b"solid") -> bytes:
    """As most programs write it: all triangles of all blocks in one soup, single precision."""
    corner = triangles(assembly)
    records = b"".join(
        struct.pack("<12fH", 0, 0, 0, *points.ravel().tolist(), 0) for points in corner
    )
    return header.ljust(80) + struct.pack("<I", len(corner)) + records


@pytest.mark.parametrize("assembly", FAMILIES, ids=NAMES)
def test_a_binary_soup_of_touching_solids_is_split_into_blocks(
    tmp_path: Path, assembly: Assembly
) -> None:
    path = tmp_path / "model.stl"
    path.write_bytes(binary(assembly))
    model = io.read_file(path)
    assert len(model.assembly) == len(assembly)
    assert sorted(model.assembly.volume) == pytest.approx(sorted(assembly.volume), rel=1e-5)
    assert any(f"split into {len(assembly)} solids" in note for note in model.notes)


@pytest.mark.parametrize("assembly", FAMILIES, ids=NAMES)
def test_text_keeps_names_and_every_bit_of_the_corners(tmp_path: Path, assembly: Assembly) -> None:
    path = tmp_path / "model.stl"
    io.write(assembly, path)
    model = io.read_file(path)
    assert model.assembly.names == assembly.names
    assert model.assembly.volume == pytest.approx(assembly.volume, rel=1e-12)
    for one, other in zip(assembly.blocks, model.assembly.blocks, strict=True):
        corners = {tuple(point) for point in one.vertices.tolist()}
        assert {tuple(point) for point in other.vertices.tolist()} == corners


def test_a_single_solid_is_called_like_the_file_or_like_itself(tmp_path: Path) -> None:
    block = Assembly((box((1.0, 1.0, 1.0), name="the stone"),))
    path = tmp_path / "rock.stl"
    path.write_bytes(binary(block))
    assert io.read_file(path).assembly.names == ("rock",)
    io.write(block, path)
    assert io.read_file(path).assembly.names == ("the stone",)


def test_numbers_of_blocks_follow_the_file_name(tmp_path: Path) -> None:
    path = tmp_path / "rock.stl"
    path.write_bytes(binary(tower(3)))
    assert io.read_file(path).assembly.names == ("rock-0", "rock-1", "rock-2")


SIGNALLING_NAN = b"\x01\x00\x80\x7f"
FACET = """facet normal 0 0 1
 outer loop
  vertex 0 0 0
  vertex 1 0 0
  vertex 0 1 0
 endloop
endfacet
"""


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"x", ["neither text STL nor binary"]),
        (b"x" * 80 + struct.pack("<I", 5) + b"y" * 50, ["says that it has 5 triangles"]),
        (b"x" * 80 + struct.pack("<I", 2**32 - 1), ["says that it has 4294967295 triangles"]),
        (b"x" * 80 + struct.pack("<I", 0), ["no faces"]),
        (b"solid a\nendsolid a\n", ["line 1", "no faces"]),
        (b"solid a\nfacet normal 0 0 1\n", ["ends where 'outer' is expected"]),
        (b"solid a\n" + FACET.replace("1 0 0", "1 0").encode(), ["line 5", "vertex x y z"]),
        (b"solid a\n" + FACET.replace("1 0 0", "1 nan 0").encode(), ["line 5", "finite"]),
        (b"solid a\n" + FACET.replace("1 0 0", "1 x 0").encode(), ["line 5", "vertex x y z"]),
        (b"solid a\n" + FACET.replace("endloop", "endlop").encode(), ["line 7", "'endloop'"]),
        (b"solid a\nhello\n", ["line 2", "'hello'"]),
        (b"solid a\n" + FACET.encode() + b"endsolid a\n", ["has 1 face;"]),
        (
            binary(tower(1)).replace(struct.pack("<f", 1.0), struct.pack("<f", float("nan")), 1),
            ["not finite"],
        ),
        (binary(tower(1)).replace(struct.pack("<f", 1.0), SIGNALLING_NAN, 1), ["not finite"]),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(
    tmp_path: Path, data: bytes, words: list[str]
) -> None:
    path = tmp_path / "model.stl"
    path.write_bytes(data)
    with pytest.raises(FormatError) as caught:
        io.read_file(path)
    assert "\n" not in str(caught.value)
    for word in ("model.stl", *words):
        assert word in str(caught.value)
