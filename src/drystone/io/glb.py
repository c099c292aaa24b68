"""GLB, the binary form of glTF 2.0: a scene of named nodes with triangle meshes.

Source: Khronos Group, glTF 2.0 Specification, 2021 (ISO/IEC 12113:2022). Its unit is the metre and
its y axis points up; in drystone z does, so models are rotated when written, and when built from
what is read. A node with a mesh is a block. Extensions that a file requires, sparse accessors and
files outside the GLB are refused.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.assembly import DEFAULT_DENSITY, Assembly
from drystone.base.arrays import SAME, Floats, Ints
from drystone.base.errors import FormatError
from drystone.base.files import write_bytes
from drystone.base.ragged import Ragged
from drystone.geometry.triangulate import fan_warped, triangulate
from drystone.io.draft import (
    UP,
    Contents,
    Draft,
    DraftBlock,
    FaceSoup,
    in_double,
    moved,
    named_apart,
    shapes_of,
)
from drystone.io.jsontext import Field, parse
from drystone.io.outside import Unfolded

MAGIC, VERSION, JSON, BIN = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
TRIANGLES, STRIP, FAN = 4, 5, 6
_INDEX_TYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4"}
UNSIGNED, FLOAT = 5125, 5126
Z_UP = UP["y"]
"""Rotation from y up to z up."""
_LARGEST_STRIDE = 252
"""[bytes] Distance from one element to the next. Source: glTF 2.0, section 5.11."""


def read(data: bytes, path: Path) -> Draft:
    """Blocks of a GLB file, in its axes: the nodes of its scene with a mesh."""
    top, binary = _chunks(data, path)
    if required := [one.text() for one in top.get("extensionsRequired", []).elements()]:
        what = f"needs the extension {', '.join(required)[:80]}"
        raise FormatError(what, where=str(path), remedy="export without compression and extensions")
    soups: list[FaceSoup] = []
    told: dict[str, Field | None] = {}
    unfolded = Unfolded(path)
    known: dict[int, tuple[Floats, Ints]] = {}
    for number, (node, matrix) in enumerate(_placed_nodes(top)):
        ours = _ours(node)
        if not node.has("mesh") or (ours is not None and ours.has("picture")):
            continue  # what drystone drew of a result is no block
        mesh = _item(top, "meshes", node["mesh"])
        name = node.get("name", mesh.get("name", f"node-{number}").text()).text()
        index = node["mesh"].integer()
        if index in known:
            unfolded.take(*map(len, known[index]))
        else:
            known[index] = _geometry(top, binary, mesh, unfolded)
        vertices, triangles = known[index]
        vertices, faces = moved(vertices, triangles.tolist(), matrix)
        where = f"node {number}"
        told[where] = ours
        soups.append(FaceSoup(vertices, faces, name, where, split=ours is None))
    shapes, notes = shapes_of(soups, SAME, path)
    shapes = [_with_material(shape, told[shape.where]) for shape in shapes]
    shapes, renamed = named_apart(shapes)
    notes = notes if None in told.values() else []
    return Draft(tuple(shapes), units="m", notes=(*notes, *renamed))


def _ours(node: Field) -> Field | None:
    """Data that drystone wrote with a mesh."""
    extras = node.get("extras", {})
    if isinstance(extras.value, dict) and extras.has("drystone"):
        return extras["drystone"]
    return None


def _with_material(shape: DraftBlock, told: Field | None) -> DraftBlock:
    if told is None:
        return shape
    told.only(("fixed", "density", "metadata"))
    return DraftBlock(
        shape.name,
        shape.vertices,
        shape.faces,
        where=shape.where,
        density=told.get("density", DEFAULT_DENSITY).number(),
        fixed=told.get("fixed", False).boolean(),
        metadata=told.get("metadata", {}).object().value,
    )


def _chunks(data: bytes, path: Path) -> tuple[Field, bytes]:
    """The JSON and the binary part."""
    bad = FormatError("is not a GLB file", where=str(path), remedy="export it as binary glTF 2.0")
    if len(data) < 20 or struct.unpack_from("<2I", data) != (MAGIC, VERSION):
        raise bad
    length, kind = struct.unpack_from("<2I", data, 12)
    if kind != JSON or 20 + length > len(data):
        raise bad
    top = parse(data[20 : 20 + length], path)
    at = 20 + length
    if at + 8 > len(data):
        return top, b""
    size, kind = struct.unpack_from("<2I", data, at)
    if kind != BIN or at + 8 + size > len(data):
        raise FormatError("ends before its data do", where=str(path), remedy="export it again")
    return top, data[at + 8 : at + 8 + size]


def _item(top: Field, table: str, index: Field) -> Field:
    """Entry of one of the top-level lists."""
    number = index.integer()
    entries = top[table]
    if not isinstance(entries.value, list) or not 0 <= number < len(entries.value):
        raise index.error(f"is not among the {table}")
    return Field(entries.value[number], f"{table}[{number}]", top.file)


def _placed_nodes(top: Field) -> Iterator[tuple[Field, Floats]]:
    """Nodes of the scene with their matrix (4, 4), parents first, each once."""
    if top.has("scenes"):
        roots = _item(top, "scenes", top.get("scene", 0)).get("nodes", [])
    else:
        count = len(top.get("nodes", []).value or [])
        roots = Field(list(range(count)), "nodes", top.file)
    waiting = [(root, np.eye(4)) for root in roots.elements()][::-1]
    visited: set[int] = set()
    while waiting:
        index, above = waiting.pop()
        node = _item(top, "nodes", index)
        if index.integer() in visited:
            raise index.error("is used twice, or is its own parent")
        visited.add(index.integer())
        with np.errstate(all="ignore"):  # overflow is found with the vertices
            matrix = above @ _matrix(node)
        yield node, matrix
        waiting += [(child, matrix) for child in node.get("children", []).elements()][::-1]


def _matrix(node: Field) -> Floats:
    if node.has("matrix"):
        return node["matrix"].floats(16).reshape(4, 4).T
    if not any(node.has(key) for key in ("rotation", "scale", "translation")):
        return np.eye(4)
    x, y, z, w = node.get("rotation", [0.0, 0.0, 0.0, 1.0]).floats(4)
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= node.get("scale", [1.0, 1.0, 1.0]).floats(3)
    matrix[:3, 3] = node.get("translation", [0.0, 0.0, 0.0]).floats(3)
    return matrix


def _geometry(top: Field, binary: bytes, mesh: Field, unfolded: Unfolded) -> tuple[Floats, Ints]:
    """Vertices (v, 3) and triangles (t, 3) of all parts of a mesh."""
    vertices: list[Floats] = []
    triangles: list[Ints] = []
    offset = 0
    for part in mesh["primitives"].elements():
        mode = part.get("mode", TRIANGLES).integer()
        if mode not in (TRIANGLES, STRIP, FAN):
            continue  # points and lines bound no solid
        accessor = _item(top, "accessors", part["attributes"]["POSITION"])
        points = in_double(_accessor(top, binary, accessor, 3, {FLOAT: "<f4"}))
        if part.has("indices"):
            accessor = _item(top, "accessors", part["indices"])
            index = _accessor(top, binary, accessor, 1, _INDEX_TYPES).ravel().astype(np.intp)
            if len(index) and index.max() >= len(points):
                raise accessor.error(f"has vertex {index.max()} of {len(points)}")
        else:
            index = np.arange(len(points))
        triangles.append(_corners(index, mode, part) + offset)
        unfolded.take(len(points), len(triangles[-1]))
        vertices.append(points)
        offset += len(points)
    if not triangles:
        raise mesh.error("has no triangles", "export the blocks as meshes")
    return np.concatenate(vertices), np.concatenate(triangles)


def _corners(index: Ints, mode: int, part: Field) -> Ints:
    if mode == TRIANGLES:
        if len(index) % 3:
            raise part.error(f"has {len(index)} corners, no multiple of three")
        return index.reshape(-1, 3)
    if len(index) < 3:
        return np.zeros((0, 3), dtype=np.intp)
    if mode == FAN:
        first = np.full(len(index) - 2, index[0])
        return np.stack([first, index[1:-1], index[2:]], axis=1)
    strip = np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip


def _accessor(
    top: Field, binary: bytes, accessor: Field, columns: int, types: dict[int, str]
) -> np.ndarray[Any, Any]:
    """Numbers (count, columns); the header is checked against the size of the data."""
    kind = accessor["componentType"].integer()
    count = accessor["count"].integer()
    if accessor["type"].text() != {1: "SCALAR", 3: "VEC3"}[columns] or kind not in types:
        raise accessor.error("does not have the required type")
    if accessor.has("sparse") or not accessor.has("bufferView"):
        raise accessor.error("is sparse", "export without sparse accessors")
    view = _item(top, "bufferViews", accessor["bufferView"])
    buffer = _item(top, "buffers", view["buffer"])
    if buffer.has("uri") or view["buffer"].integer() != 0:
        raise buffer.error("lies outside the file", "export everything into one GLB")
    dtype = np.dtype(types[kind])
    row = dtype.itemsize * columns
    stride = view.get("byteStride", row).integer()
    start = view.get("byteOffset", 0).integer() + accessor.get("byteOffset", 0).integer()
    end = view.get("byteOffset", 0).integer() + view["byteLength"].integer()
    last = start + stride * (count - 1) + row
    if (
        count < 0
        or not row <= stride <= _LARGEST_STRIDE
        or start < 0
        or (count and last > min(end, len(binary)))
    ):
        raise accessor.error("reaches beyond the data", "export it again")
    if count == 0:
        return np.zeros((0, columns), dtype)
    return np.ndarray((count, columns), dtype, binary, start, (stride, dtype.itemsize))


def write(model: Contents, path: Path) -> None:
    """A node per block, with its name; supports, densities and metadata as extras.

    Coordinates have single precision. Polygons are cut into triangles. Polygons warped by more than
    this precision become a fan about the mean of their corners, as in the volume calculation.
    """
    try:
        data = blocks_of(model).file({"nodes": [*range(len(model.assembly))]})
    except (TypeError, ValueError) as error:
        raise FormatError("metadata of a block is no JSON value", where=str(path)) from error
    write_bytes(path, data)


class GlbParts:
    """The parts of a file while it is made.

    Attributes
    ----------
    top
        Tables of the JSON part.
    binary
        Arrays of the binary part, ``size`` bytes in all.
    """

    def __init__(self) -> None:
        keys = ("nodes", "meshes", "materials", "accessors", "bufferViews", "animations")
        self.top: dict[str, list[dict[str, Any]]] = {key: [] for key in keys}
        self.binary: list[bytes] = []
        self.size = 0

    def add(self, table: str, entry: dict[str, Any]) -> int:
        """The number of a new entry of a table."""
        self.top[table].append(entry)
        return len(self.top[table]) - 1

    def numbers(self, values: NDArray[Any], *, bounds: bool = False) -> int:
        """The accessor of an array: whole numbers, or rows of single precision."""
        whole = values.dtype.kind in "iu"
        array = values.astype("<u4" if whole else "<f4")
        raw = array.tobytes()
        place = {"buffer": 0, "byteOffset": self.size, "byteLength": len(raw)}
        self.binary.append(raw)
        self.size += len(raw)
        columns = 1 if array.ndim == 1 else array.shape[1]
        entry: dict[str, Any] = {
            "bufferView": self.add("bufferViews", place),
            "componentType": UNSIGNED if whole else FLOAT,
            "count": len(array),
            "type": "SCALAR" if columns == 1 else f"VEC{columns}",
        }
        if bounds:
            flat = array.reshape(len(array), -1)
            entry |= {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        return self.add("accessors", entry)

    def play(self, name: str, channels: Iterable[tuple[int, str, int, Floats, str]]) -> None:
        """An animation: of each channel the node, what moves, moments, values, interpolation."""
        entry: dict[str, list[dict[str, Any]]] = {"channels": [], "samplers": []}
        for node, path, moments, values, interpolation in channels:
            target = {"node": node, "path": path}
            entry["channels"].append({"sampler": len(entry["samplers"]), "target": target})
            entry["samplers"].append({
                "input": moments, "output": self.numbers(values), "interpolation": interpolation
            })  # fmt: skip
        if entry["channels"]:
            self.add("animations", {"name": name, **entry})

    def file(self, scene: dict[str, Any], told: Any = None, **more: Any) -> bytes:
        """The whole file with its one scene; what is ``told`` of it, and more of the JSON part."""
        extras = {} if told is None else {"extras": {"drystone": told}}
        content = {
            "asset": {"version": "2.0", "generator": "drystone", **extras},
            **more,
            "scene": 0,
            "scenes": [scene],
            **{key: table for key, table in self.top.items() if table},
            "buffers": [{"byteLength": self.size}],
        }
        text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        head = struct.pack("<3I", MAGIC, VERSION, 12 + 8 + len(text) + 8 + self.size)
        parts = struct.pack("<2I", len(text), JSON), struct.pack("<2I", self.size, BIN)
        return b"".join([head, parts[0], text, parts[1], *self.binary])


def block_meshes(assembly: Assembly) -> list[tuple[Floats, Ints]]:
    """Points (p, 3) [m] and triangles (t, 3) of each block; warped faces have a middle."""
    faces = fan_warped(assembly.faces, SAME)
    triangle, polygon = triangulate(faces.point[faces.loop], faces.start)
    made = []
    for rows in Ragged.from_owners(faces.owner[polygon], len(assembly)):
        used, index = np.unique(faces.loop[triangle[rows]], return_inverse=True)
        made.append((faces.point[used], index.reshape(-1, 3)))
    return made


def blocks_of(model: Contents) -> GlbParts:
    """A node and a mesh for each block of a model, by its number."""
    assembly, parts = model.assembly, GlbParts()
    for i, (block, mesh) in enumerate(zip(assembly.blocks, block_meshes(assembly), strict=True)):
        mine = parts.numbers(mesh[0] @ Z_UP, bounds=True)
        loops = parts.numbers(mesh[1].ravel())
        parts.add("meshes", {"primitives": [{"attributes": {"POSITION": mine}, "indices": loops}]})
        told: dict[str, Any] = {"fixed": bool(assembly.fixed[i]), "density": block.density}
        told |= {"metadata": dict(block.metadata)} if block.metadata else {}
        parts.add("nodes", {"name": block.name, "mesh": i, "extras": {"drystone": told}})
    return parts
