"""Small files that unfold to very much are refused before they do."""

import io as streams
import json
import struct
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from drystone import FormatError, io

WIDE, OFTEN = 20_000, 2_000
"""Vertices of a part, and times that it is placed: 40 million vertices."""
MOST = 400 * 2**20
"""[bytes] that reading may take: what a million faces need, and a tenth of what the files make."""


def most_memory() -> int:
    """[bytes] The most that this process has held; zero where the system does not say."""
    if sys.platform != "linux":
        return 0
    import resource

    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def archive(members: dict[str, bytes]) -> bytes:
    buffer = streams.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in members.items():
            made.writestr(name, content)
    return buffer.getvalue()


def usdz(folder: Path) -> Path:
    pytest.importorskip("pxr")
    return written(folder, "model.usdz", archive({"stage.usda": b"#usda 1.0\n" + bytes(2**28)}))


def glb_file(folder: Path, primitives: int, nodes: int, *, inside: bool = True) -> Path:
    accessor = {"bufferView": 0, "componentType": 5126, "count": WIDE, "type": "VEC3"}
    index = {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}
    if not inside:
        accessor = {"componentType": 5126, "count": 2**31 - 1, "type": "VEC3"}
    points = np.random.default_rng(0).random((WIDE, 3), dtype=np.float32).tobytes()
    binary = points + struct.pack("<3I", 0, 1, 2)
    text = json.dumps(
        {
            "asset": {"version": "2.0"},
            "meshes": [
                {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}] * primitives}
            ],
            "accessors": [accessor, index],
            "bufferViews": [
                {"buffer": 0, "byteLength": len(points)},
                {"buffer": 0, "byteOffset": len(points), "byteLength": 12},
            ],
            "buffers": [{"byteLength": len(binary)}],
            "nodes": [{"mesh": 0}] * nodes,
        }
    ).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<5I", 0x46546C67, 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A)
    body = text + struct.pack("<2I", len(binary), 0x004E4942) + binary
    return written(folder, "model.glb", head + body)


def dae(folder: Path, parts: int, nodes: int) -> Path:
    numbers = " ".join(["0 0 0", "1 0 0", *["0 1 0"] * (WIDE - 2)])
    source = f'<source id="s"><float_array>{numbers}</float_array><technique_common>'
    source += '<accessor stride="3"/></technique_common></source>'
    shared = '<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>'
    part = '<triangles><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>'
    node = '<node><instance_geometry url="#g"/></node>'
    text = (
        f'<COLLADA><library_geometries><geometry id="g"><mesh>{source}{shared}{part * parts}</mesh>'
        f"</geometry></library_geometries><library_visual_scenes><visual_scene>{node * nodes}"
        "</visual_scene></library_visual_scenes></COLLADA>"
    )
    return written(folder, "model.dae", text.encode())


def dxf(folder: Path, columns: int, inner: list[tuple[int, object]]) -> Path:
    tags = [(0, "SECTION"), (2, "BLOCKS"), (0, "BLOCK"), (2, "b"), *inner, (0, "ENDBLK")]
    tags += [(0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"), (0, "INSERT"), (2, "b")]
    tags += [(70, columns), (71, columns), (44, 1), (45, 1), (0, "ENDSEC"), (0, "EOF")]
    text = "".join(f"{code}\n{value}\n" for code, value in tags)
    return written(folder, "model.dxf", text.encode())


def polyline() -> list[tuple[int, object]]:
    angle = np.linspace(0.0, 6.0, WIDE)
    corners = zip(np.cos(angle).tolist(), np.sin(angle).tolist(), strict=True)
    return [(0, "LWPOLYLINE"), (70, 1), *[one for x, y in corners for one in ((10, x), (20, y))]]


def parts_of_bricks(folder: Path) -> Path:
    names = "abcdefghijklmnopqrst"
    lines = []
    for name, inner in zip(names, [*names[1:], "3001.dat"], strict=True):
        lines += [f"0 FILE {name}", *[f"1 0 0 0 0 1 0 0 0 1 0 0 0 1 {inner}"] * 9]
    return written(folder, "model.mpd", "\n".join(lines).encode())


def mesh(folder: Path) -> str:
    """An OBJ file of a strip of many faces."""
    points = [f"v {i // 2} {i % 2} {i % 3}" for i in range(WIDE + 2)]
    faces = [f"f {i + 1} {i + 2} {i + 3}" for i in range(WIDE)]
    written(folder, "strip.obj", "\n".join(points + faces).encode())
    return "strip.obj"


def mjcf(folder: Path) -> Path:
    geom = '<body><freejoint/><geom type="mesh" mesh="m"/></body>' * OFTEN
    asset = f'<asset><mesh name="m" file="{mesh(folder)}"/></asset>'
    text = f"<mujoco>{asset}<worldbody>{geom}</worldbody></mujoco>"
    return written(folder, "model.xml", text.encode())


def urdf(folder: Path) -> Path:
    shape = f'<collision><geometry><mesh filename="{mesh(folder)}"/></geometry></collision>'
    text = f'<robot name="r"><link name="a">{shape * OFTEN}</link></robot>'
    return written(folder, "model.urdf", text.encode())


def entities(folder: Path, name: str, root: str, encoding: str) -> Path:
    """Ten entities, each ten times the one before."""
    told = '<!ENTITY a0 "stones">'
    told += "".join(f'<!ENTITY a{i + 1} "{f"&a{i};" * 10}">' for i in range(10))
    text = f'<?xml version="1.0" encoding="{encoding}"?><!DOCTYPE {root} [{told}]>'
    return written(folder, name, f"{text}<{root}>&a10;</{root}>".encode(encoding))


def written(folder: Path, name: str, data: bytes) -> Path:
    (folder / name).write_bytes(data)
    return folder / name


@pytest.mark.parametrize(
    ("made", "words"),
    [
        pytest.param(usdz, "its files are packed", id="usdz"),
        pytest.param(lambda at: glb_file(at, 1, OFTEN), "places more than", id="glb-nodes"),
        pytest.param(lambda at: glb_file(at, OFTEN, 1), "places more than", id="glb-parts"),
        pytest.param(lambda at: glb_file(at, 1, 1, inside=False), "is sparse", id="glb-zeros"),
        pytest.param(lambda at: dae(at, 1, OFTEN), "places more than", id="dae-nodes"),
        pytest.param(lambda at: dae(at, OFTEN, 1), "places more than", id="dae-parts"),
        pytest.param(lambda at: dxf(at, 50, polyline()), "places more than", id="dxf-outlines"),
        pytest.param(lambda at: dxf(at, 10**9, []), "no block", id="dxf-nothing"),
        pytest.param(parts_of_bricks, "more than 100,000 parts", id="mpd"),
        pytest.param(mjcf, "places more than", id="mjcf"),
        pytest.param(urdf, "places more than", id="urdf"),
        *(
            pytest.param(
                lambda at, name=name, root=root, code=code: entities(at, name, root, code),
                "defines entities",
                id=f"{name}-{code}",
            )
            for name, root in (
                ("a.dae", "COLLADA"),
                ("a.xml", "mujoco"),
                ("a.mjcf", "mujoco"),
                ("a.urdf", "robot"),
            )
            for code in ("utf-8", "utf-16", "utf-16-be")
        ),
    ],
)
def test_what_unfolds_to_very_much_is_refused_before_it_does(
    tmp_path: Path, made: Callable[[Path], Path], words: str
) -> None:
    path = made(tmp_path)
    assert path.stat().st_size < 2**21
    before = most_memory()
    with pytest.raises(FormatError, match=words):
        io.read_file(path)
    assert most_memory() - before < MOST


@pytest.mark.parametrize(
    "name", ["a.zip", "a.json.gz", "a.obj.gz", "a.3mf", "a.ifczip", "a.zae", "a.stpz", "a.gltf"]
)
def test_no_other_packed_file_is_opened(tmp_path: Path, name: str) -> None:
    written(tmp_path, name, archive({"a.obj": b"v 0 0 0\n"}))
    with pytest.raises(FormatError, match="is not known"):
        io.read_file(tmp_path / name)
