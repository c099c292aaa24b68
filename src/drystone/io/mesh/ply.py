"""PLY: polygons over vertices, in text or binary.

Source: Turk 1994, The PLY polygon file format.

What we write has a face property ``block``, and a comment per block with its name, whether it is
fixed and its density, so that nothing is lost. Of other files the solids are told apart by their
faces.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.errors import FormatError
from drystone.files import write_bytes
from drystone.io.draft import Contents, Draft, Shape
from drystone.io.jsontext import Field, parse
from drystone.io.mesh import ply_body
from drystone.io.mesh.heap import Heap, in_double, shape_of, shapes_of
from drystone.io.mesh.ply_body import Element, Header, Property

MARK = "drystone block "
END = re.compile(rb"[\r\n][ \t]*end_header")
"""On a line of its own: a block may be called so."""
LONGEST_HEADER = 2**20
"""[bytes], chosen: far more than there are tables to tell of."""
TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
EXACT, SINGLE = 1e-9, 1e-6
"""What counts as the same place, relative to the extent, in double and in single precision."""


def read(data: bytes, path: Path) -> Draft:
    """Blocks of a PLY file."""
    header = _header(data, path)
    tables = ply_body.read(data[header.size :], header, path)
    vertex, face = tables.get("vertex", {}), tables.get("face", {})
    if not all(axis in vertex for axis in "xyz"):
        raise FormatError("has no vertices with x, y and z", where=str(path))
    vertices = np.stack([in_double(vertex[axis]) for axis in "xyz"], axis=1)
    loops = face.get("vertex_indices", face.get("vertex_index"))
    if loops is None:
        raise FormatError("has no faces", where=str(path), remedy="export the blocks as meshes")
    for i, loop in enumerate(loops):
        if len(loop) < 3 or min(loop) < 0 or max(loop) >= len(vertices):
            raise FormatError(
                f"face {i} {list(loop)[:8]} is not made of three or more vertices",
                where=str(path),
                remedy=f"vertices go from 0 to {len(vertices) - 1}",
            )
    marked = [comment for comment in header.comments if comment.startswith(MARK)]
    if marked and "block" in face:
        return _ours(vertices, loops, face["block"], marked, path)
    exact = vertex["x"].dtype.itemsize == 8 or not header.order
    heap = Heap(vertices, loops, path.stem, "")
    shapes, notes = shapes_of([heap], EXACT if exact else SINGLE, path)
    return Draft(tuple(shapes), notes=tuple(notes))


def _header(data: bytes, path: Path) -> Header:
    ending = END.search(data, 0, LONGEST_HEADER)
    end = -1 if ending is None else ending.end() - len(b"end_header")
    stop = data.find(b"\n", end)
    if not data.startswith(b"ply") or end < 0:
        raise FormatError("is not a PLY file", where=str(path), remedy="export it again")
    size = stop + 1 if stop >= 0 else len(data)
    try:
        lines = data[:end].decode("utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise FormatError("has a header that is no text", where=str(path)) from error
    order: str | None = None
    elements: list[tuple[str, int, list[Property]]] = []
    comments: list[str] = []
    for number, line in enumerate(lines[1:], start=2):
        words = line.split()
        try:
            match words:
                case [] | ["obj_info", *_]:
                    pass
                case ["comment", *_]:
                    comments.append(line.split(None, 1)[1] if len(words) > 1 else "")
                case ["format", kind, _]:
                    order = ORDERS[kind]
                case ["element", name, count]:
                    elements.append((name, _count(count), []))
                case ["property", "list", length, kind, name]:
                    elements[-1][2].append(Property(name, TYPES[kind], TYPES[length]))
                case ["property", kind, name]:
                    elements[-1][2].append(Property(name, TYPES[kind]))
                case _:
                    raise KeyError(line)
        except (KeyError, IndexError, ValueError) as error:
            raise FormatError(
                f"'{line.strip()[:40]}' is no PLY header", where=f"{path}, line {number}"
            ) from error
    if order is None:
        raise FormatError("does not say its format", where=str(path), remedy="export it again")
    tables = tuple(Element(name, count, tuple(columns)) for name, count, columns in elements)
    return Header(order, tables, tuple(comments), size)


def _count(text: str) -> int:
    if not text.isdecimal() or len(text) > 12:
        raise ValueError(text)
    return int(text)


def _ours(
    vertices: NDArray[np.float64],
    loops: Any,
    block: NDArray[Any],
    marked: list[str],
    path: Path,
) -> Draft:
    """Blocks as we wrote them, to the last bit."""
    told = [
        Field(parse(mark.removeprefix(MARK).encode(), path).value, f"comment[{i}]", path)
        for i, mark in enumerate(marked)
    ]
    faces: list[list[list[int]]] = [[] for _ in told]
    for loop, owner in zip(loops, block.tolist(), strict=True):
        if not 0 <= owner < len(told):
            raise FormatError(
                f"a face belongs to block {owner}, which is not told", where=str(path)
            )
        faces[int(owner)].append(list(loop))
    shapes: list[Shape] = []
    for field, mine in zip(told, faces, strict=True):
        field.only(("name", "fixed", "density", "metadata"))
        bare = shape_of(vertices, [tuple(loop) for loop in mine], field["name"].text(), field.path)
        shapes.append(
            Shape(
                bare.name,
                bare.vertices,
                bare.faces,
                where=field.path,
                density=field["density"].number(),
                fixed=field["fixed"].boolean(),
                metadata=field.get("metadata", {}).object().value,
            )
        )
    return Draft(tuple(shapes))


def write(model: Contents, path: Path) -> None:
    """Binary, double precision, polygons kept."""
    assembly = model.assembly
    faces = assembly.faces
    comments = []
    for block, fixed in zip(assembly.blocks, assembly.fixed.tolist(), strict=True):
        told = {"name": block.name, "fixed": fixed, "density": block.density}
        if block.metadata:
            told["metadata"] = dict(block.metadata)
        try:
            comments.append(f"comment {MARK}{json.dumps(told, allow_nan=False)}")
        except (TypeError, ValueError) as error:
            raise FormatError(
                f"metadata of block '{block.name}' is no JSON value", where=str(path)
            ) from error
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *comments,
        f"element vertex {len(faces.point)}",
        *[f"property double {axis}" for axis in "xyz"],
        f"element face {faces.count}",
        "property list int int vertex_indices",
        "property int block",
        "end_header",
    ]
    lengths = np.diff(faces.start)
    body = np.zeros(len(faces.loop) + 2 * faces.count, dtype="<i4")
    at = faces.start[:-1] + 2 * np.arange(faces.count)
    body[at] = lengths
    body[at + lengths + 1] = faces.owner
    inside = np.arange(len(faces.loop)) + 1 + 2 * np.repeat(np.arange(faces.count), lengths)
    body[inside] = faces.loop
    data = ("\n".join(header) + "\n").encode()
    write_bytes(path, data + faces.point.astype("<f8").tobytes() + body.tobytes())
