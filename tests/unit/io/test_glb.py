import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drystone import Assembly, FormatError, io
from drystone.assembly import replace_block
from drystone.models import arch, box, concave, dome, tower, vault

CUBE = box((1.0, 2.0, 3.0))
CORNERS = np.array(
    [t for f in CUBE.faces for t in ((f[0], f[1], f[2]), (f[0], f[2], f[3]))], dtype=np.int64
)


def glb(content: dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    total = 28 + len(text) + len(binary)
    parts = [struct.pack("<3I", 0x46546C67, 2, total), struct.pack("<2I", len(text), 0x4E4F534A)]
    return b"".join([*parts, text, struct.pack("<2I", len(binary), 0x004E4942), binary])


def scene(index_type: int = 5123, **node: Any) -> tuple[dict[str, Any], bytes]:
    """A box of 1 by 2 by 3, as other programs write it: y up, in a group that lifts it by 1."""
    points = CUBE.vertices[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
    index = CORNERS.astype({5121: "<u1", 5123: "<u2", 5125: "<u4"}[index_type]).tobytes()
    binary = points.astype("<f4").tobytes() + index
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [1]}],
        "nodes": [
            {"name": "stone", "mesh": 0} | node,
            {"name": "group", "children": [0], "translation": [0.0, 1.0, 0.0]},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
            {"bufferView": 1, "componentType": index_type, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 96},
            {"buffer": 0, "byteOffset": 96, "byteLength": len(index)},
        ],
        "buffers": [{"byteLength": len(binary)}],
    }
    return content, binary


def load(tmp_path: Path, data: bytes) -> io.Contents:
    path = tmp_path / "model.glb"
    path.write_bytes(data)
    return io.read_file(path)


@pytest.mark.parametrize("index_type", [5121, 5123, 5125])
def test_nodes_with_a_mesh_are_blocks_and_y_up_becomes_z_up(
    tmp_path: Path, index_type: int
) -> None:
    (block,) = load(tmp_path, glb(*scene(index_type))).assembly.blocks
    assert block.name == "stone"
    assert block.bounds.tolist() == [[0, 0, 1], [1, 2, 4]]
    assert len(block.faces) == 6


def test_z_is_up_as_written_where_it_is_said(tmp_path: Path) -> None:
    (tmp_path / "model.glb").write_bytes(glb(*scene()))
    for up, bounds in (("z", [[0, 1, -2], [1, 4, 0]]), ("y", [[0, 0, 1], [1, 2, 4]])):
        (block,) = io.read_file(tmp_path / "model.glb", up=up).assembly.blocks
        assert block.bounds.tolist() == bounds
    io.write(tower(2), tmp_path / "tower.obj")
    files = [tmp_path / "model.glb", tmp_path / "tower.obj"]
    assert io.read_file(files).assembly.blocks[0].bounds.tolist() == [[0, 0, 1], [1, 2, 4]]


@pytest.mark.parametrize(
    ("node", "bounds"),
    [
        ({"scale": [2.0, 2.0, 2.0]}, [[0, 0, 1], [2, 4, 7]]),
        ({"scale": [-1.0, 1.0, 1.0]}, [[-1, 0, 1], [0, 2, 4]]),
        ({"rotation": [0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)]}, [[-2, 0, 1], [0, 1, 4]]),
        (
            {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]},
            [[5, -7, 7], [6, -5, 10]],
        ),
    ],
)
def test_nodes_are_placed(tmp_path: Path, node: dict[str, Any], bounds: list[Any]) -> None:
    (block,) = load(tmp_path, glb(*scene(**node))).assembly.blocks
    assert block.bounds == pytest.approx(np.array(bounds), abs=1e-6)
    assert not block.repairs


def test_a_node_that_places_its_vertices_beyond_every_number_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="vertex 1 is far too large"):
        load(tmp_path, glb(*scene(scale=[1e308, 1e308, 1e308])))


@pytest.mark.parametrize("assembly", [tower(3), arch(), dome(), concave("short"), vault()])
def test_writing_and_reading_keeps_names_supports_material_and_polygons(
    tmp_path: Path, assembly: Assembly
) -> None:
    told = tuple(
        replace_block(block, density=1000.0 + i / 3, metadata={"i": i})
        for i, block in enumerate(assembly.blocks)
    )
    assembly = Assembly(told, assembly.fixed)
    io.write(assembly, tmp_path / "model.glb")
    again = io.read_file(tmp_path / "model.glb")
    assert again.notes == ()
    assert again.assembly.names == assembly.names
    assert np.array_equal(again.assembly.fixed, assembly.fixed)
    for one, other in zip(assembly.blocks, again.assembly.blocks, strict=True):
        assert other.vertices == pytest.approx(one.vertices, rel=1e-6, abs=1e-6)
        assert (one.density, dict(one.metadata)) == (other.density, dict(other.metadata))
        assert other.volume == pytest.approx(one.volume, rel=1e-4)
        assert len(other.faces) <= len(one.faces)


def test_strips_and_fans_are_triangles_too(tmp_path: Path) -> None:
    """A tetrahedron as a strip of two triangles and a fan of two."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4").tobytes()
    strip, fan = np.array([1, 0, 2, 3], dtype="<u1"), np.array([1, 0, 3, 2], dtype="<u1")
    binary = points + strip.tobytes() + fan.tobytes()
    content, _ = scene()
    content["meshes"] = [
        {
            "primitives": [
                {"attributes": {"POSITION": 0}, "indices": 1, "mode": 5},
                {"attributes": {"POSITION": 0}, "indices": 2, "mode": 6},
                {"attributes": {"POSITION": 0}, "indices": 2, "mode": 1},
            ]
        }
    ]
    content["accessors"] = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5121, "count": 4, "type": "SCALAR"},
        {"bufferView": 1, "byteOffset": 4, "componentType": 5121, "count": 4, "type": "SCALAR"},
    ]
    content["bufferViews"][0] = {"buffer": 0, "byteLength": 48}
    content["bufferViews"][1] = {"buffer": 0, "byteOffset": 48, "byteLength": 8}
    (block,) = load(tmp_path, glb(content, binary)).assembly.blocks
    assert block.volume == pytest.approx(1 / 6)


def changed(path: str, value: Any) -> bytes:
    content, binary = scene()
    at: Any = content
    *steps, last = [int(s) if s.isdecimal() else s for s in path.split("/")]
    for step in steps:
        at = at[step]
    at[last] = value
    return glb(content, binary)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"glTF", ["not a GLB file"]),
        (b"{}" * 20, ["not a GLB file"]),
        (glb(*scene())[:-40], ["ends before its data"]),
        (changed("extensionsRequired", ["KHR_draco_mesh_compression"]), ["KHR_draco", "without"]),
        (changed("scenes/0/nodes", [7]), ["scenes[0].nodes[0]", "not among the nodes"]),
        (changed("nodes/0/children", [1]), ["used twice, or is its own parent"]),
        (changed("nodes/0/mesh", 3), ["nodes[0].mesh", "not among the meshes"]),
        (changed("nodes/1/translation", [0, "x", 0]), ["nodes[1].translation[1]"]),
        (changed("meshes/0/primitives/0/mode", 1), ["meshes[0]", "no triangles"]),
        (changed("accessors/0/count", 10**9), ["accessors[0]", "beyond the data"]),
        (changed("accessors/0/count", -1), ["accessors[0]", "beyond the data"]),
        (changed("accessors/0/byteOffset", -4), ["accessors[0]", "beyond the data"]),
        (changed("accessors/0/sparse", {}), ["accessors[0]", "sparse"]),
        (changed("accessors/0/type", "VEC2"), ["accessors[0]", "required type"]),
        (changed("accessors/1/count", 35), ["no multiple of three"]),
        (changed("accessors/0/count", 4), ["accessors[1]", "has vertex"]),
        (changed("bufferViews/0/byteStride", 2), ["accessors[0]", "beyond the data"]),
        (changed("buffers/0/uri", "http://example.org/x.bin"), ["buffers[0]", "outside the file"]),
        (changed("buffers", {}), ["bufferViews[0].buffer", "not among the buffers"]),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(
    tmp_path: Path, data: bytes, words: list[str]
) -> None:
    with pytest.raises(FormatError) as caught:
        load(tmp_path, data)
    assert "\n" not in str(caught.value)
    for word in ("model.glb", *words):
        assert word in str(caught.value)
