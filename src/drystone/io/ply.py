"""PLY: polygons over vertices, in text or binary.

Source: Turk 1994, The PLY polygon file format.

drystone writes a face property ``block``, and a comment per block with its name, support and
density. So nothing is lost. In other files the solids are separated by their faces.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.base.arrays import ROUNDING, SAME
from drystone.base.errors import FormatError
from drystone.base.files import MIB, utf8, write_bytes
from drystone.io.draft import Contents, Draft, DraftBlock, FaceSoup, in_double, shape_of, shapes_of
from drystone.io.jsontext import Field, parse

_END = re.compile(rb"[\r\n][ \t]*end_header")
"""It must be a whole line, since a block may have this name."""
_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
"""Of the module struct."""
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

Table = dict[str, Any]
"""Columns by name: arrays of numbers, and for list properties a list of lists."""


@dataclass(frozen=True)
class _Property:
    """A column of an element; a list has a type for its length."""

    name: str
    type: str
    length: str | None = None


@dataclass(frozen=True)
class Element:
    """A table of the file."""

    name: str
    count: int
    properties: tuple[_Property, ...]


@dataclass(frozen=True)
class _Header:
    """Description of the tables of a file."""

    order: str
    elements: tuple[Element, ...]
    comments: tuple[str, ...]
    size: int


def header_of(data: bytes, path: Path) -> _Header:
    """The header of a file.

    Raises
    ------
    FormatError
        It has no header, or one that cannot be read.
    """
    ending = _END.search(data, 0, MIB)
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
    elements: list[tuple[str, int, list[_Property]]] = []
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
                    order = _ORDERS[kind]
                case ["element", name, count]:
                    elements.append((name, _count(count), []))
                case ["property", "list", length, kind, name]:
                    elements[-1][2].append(_Property(name, _TYPES[kind], _TYPES[length]))
                case ["property", kind, name]:
                    elements[-1][2].append(_Property(name, _TYPES[kind]))
                case _:
                    raise KeyError(line)
        except (KeyError, IndexError, ValueError) as error:
            raise FormatError(
                f"'{line.strip()[:40]}' is no PLY header", where=f"{path}, line {number}"
            ) from error
    if order is None:
        raise FormatError("does not say its format", where=str(path), remedy="export it again")
    tables = tuple(Element(name, count, tuple(columns)) for name, count, columns in elements)
    return _Header(order, tables, tuple(comments), size)


def _count(text: str) -> int:
    if not text.isdecimal() or len(text) > 12:
        raise ValueError(text)
    return int(text)


def _tables_of(body: bytes, header: _Header, path: Path) -> dict[str, Table]:
    """All tables, by name.

    Raises
    ------
    FormatError
        The file ends too early, or has values that are not numbers.
    """
    early = FormatError("ends before its data do", where=str(path), remedy="export it again")
    try:
        if not header.order:
            return _ascii(body, header)
        return _binary(body, header)
    except (IndexError, struct.error) as error:
        raise early from error
    except (ValueError, OverflowError) as error:
        raise FormatError(f"has values that are not numbers: {error}", where=str(path)) from error


def _ascii(body: bytes, header: _Header) -> dict[str, Table]:
    words = body.split()
    at = 0

    def taken(kind: str, count: int) -> list[Any]:
        """The next values."""
        nonlocal at
        if not 0 <= count <= len(words) - at:
            raise IndexError
        at += count
        return list(map(float if kind[0] == "f" else int, words[at - count : at]))

    tables: dict[str, Table] = {}
    for element in header.elements:
        if element.properties and element.count > len(words) - at:
            raise IndexError
        tables[element.name] = _rows(element, taken)
    return tables


def _rows(element: Element, taken: Callable[[str, int], Sequence[Any]]) -> Table:
    """The columns of rows that follow each other, from a function that takes the next values."""
    columns: Table = {column.name: [] for column in element.properties}
    for _ in range(element.count if element.properties else 0):
        for column in element.properties:
            if column.length is None:
                columns[column.name].append(taken(column.type, 1)[0])
            else:
                (length,) = taken(column.length, 1)
                columns[column.name].append(list(map(int, taken(column.type, int(length)))))
    for column in element.properties:
        if column.length is None:
            kind = np.float64 if column.type[0] == "f" else np.int64
            columns[column.name] = np.array(columns[column.name], dtype=kind)
    return columns


def _binary(body: bytes, header: _Header) -> dict[str, Table]:
    at = 0

    def taken(kind: str, count: int) -> Sequence[Any]:
        """The next values; lists in rows have different lengths."""
        nonlocal at
        size = int(kind[1]) * count
        if not 0 <= size <= len(body) - at:
            raise IndexError
        at += size
        return struct.unpack_from(f"{header.order}{count}{_CODES[kind]}", body, at - size)

    tables: dict[str, Table] = {}
    for element in header.elements:
        if element.properties and not any(column.length for column in element.properties):
            dtype = np.dtype([(c.name, header.order + c.type) for c in element.properties])
            size = dtype.itemsize * element.count
            if size > len(body) - at:
                raise IndexError
            rows = np.frombuffer(body, dtype, element.count, at)
            tables[element.name] = {column.name: rows[column.name] for column in element.properties}
            at += size
            continue
        tables[element.name] = _rows(element, taken)
    return tables


_MARK = "drystone block "


def read(data: bytes, path: Path) -> Draft:
    """Blocks of a PLY file."""
    header = header_of(data, path)
    tables = _tables_of(data[header.size :], header, path)
    vertex, face = tables.get("vertex", {}), tables.get("face", {})
    if not all(isinstance(vertex.get(axis), np.ndarray) for axis in "xyz"):
        raise FormatError("has no vertices with numbers x, y and z", where=str(path))
    vertices = np.stack([in_double(vertex[axis]) for axis in "xyz"], axis=1)
    loops = face.get("vertex_indices", face.get("vertex_index"))
    if not isinstance(loops, list):
        raise FormatError("has no faces", where=str(path), remedy="export the blocks as meshes")
    for i, loop in enumerate(loops):
        if len(loop) < 3 or min(loop) < 0 or max(loop) >= len(vertices):
            raise FormatError(
                f"face {i} {list(loop)[:8]} is not made of three or more vertices",
                where=str(path),
                remedy=f"vertices go from 0 to {len(vertices) - 1}",
            )
    marked = [comment for comment in header.comments if comment.startswith(_MARK)]
    if marked and isinstance(face.get("block"), np.ndarray):
        return _ours(vertices, loops, face["block"], marked, path)
    exact = vertex["x"].dtype.itemsize == 8 or not header.order
    soup = FaceSoup(vertices, loops, path.stem, "")
    shapes, notes = shapes_of([soup], ROUNDING if exact else SAME, path)
    return Draft(tuple(shapes), notes=tuple(notes))


def _ours(
    vertices: NDArray[np.float64],
    loops: Any,
    block: NDArray[Any],
    marked: list[str],
    path: Path,
) -> Draft:
    """Blocks of a file written by drystone, exact to the last bit."""
    told = [
        Field(parse(mark.removeprefix(_MARK).encode(), path).value, f"comment[{i}]", path)
        for i, mark in enumerate(marked)
    ]
    faces: list[list[list[int]]] = [[] for _ in told]
    for loop, owner in zip(loops, block.tolist(), strict=True):
        if not 0 <= owner < len(told):
            raise FormatError(
                f"a face belongs to block {owner}, which has no comment", where=str(path)
            )
        faces[int(owner)].append(list(loop))
    shapes: list[DraftBlock] = []
    for field, mine in zip(told, faces, strict=True):
        field.only(("name", "fixed", "density", "metadata"))
        bare = shape_of(vertices, [tuple(loop) for loop in mine], field["name"].text(), field.path)
        shapes.append(
            DraftBlock(
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
            comments.append(f"comment {_MARK}{json.dumps(told, allow_nan=False)}")
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
    data = utf8("\n".join(header) + "\n")
    write_bytes(path, data + faces.point.astype("<f8").tobytes() + body.tobytes())
