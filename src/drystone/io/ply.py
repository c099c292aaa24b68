"""PLY: polygons over vertices, in text or binary.

Source: Turk 1994, The PLY polygon file format.

drystone writes a face property ``block``, and a comment per block with its name, support and
density. So nothing is lost. In other files the solids are separated by their faces.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.base.arrays import ROUNDING, SAME
from drystone.base.errors import FormatError
from drystone.base.files import utf8, write_bytes
from drystone.io import ply_tables
from drystone.io.draft import Contents, Draft, DraftBlock
from drystone.io.face_soup import FaceSoup, in_double, shape_of, shapes_of
from drystone.io.jsontext import Field, parse

_MARK = "drystone block "


def read(data: bytes, path: Path) -> Draft:
    """Blocks of a PLY file."""
    header = ply_tables.header_of(data, path)
    tables = ply_tables.read(data[header.size :], header, path)
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
