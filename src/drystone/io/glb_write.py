"""Writing GLB; see :mod:`drystone.io.glb`."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from drystone.base.errors import FormatError
from drystone.base.files import write_bytes
from drystone.base.ragged import Ragged
from drystone.geometry.triangulate import fan_warped, point_owners, triangulate
from drystone.io.draft import Contents
from drystone.io.face_soup import SINGLE
from drystone.io.glb import BIN, FLOAT, JSON, MAGIC, VERSION, Z_UP


def write(model: Contents, path: Path) -> None:
    """A node per block, with its name; supports, densities and metadata as extras.

    Coordinates have single precision. Polygons are cut into triangles. Polygons warped by more than
    this precision become a fan about the mean of their corners, as in the volume calculation.
    """
    content, binary = glb_content(model)
    try:
        text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    except (TypeError, ValueError) as error:
        raise FormatError("metadata of a block is no JSON value", where=str(path)) from error
    write_bytes(path, container(text, binary))


def glb_content(model: Contents) -> tuple[dict[str, Any], bytes]:
    """The JSON part of a file as plain values, and its binary part."""
    assembly = model.assembly
    faces = fan_warped(assembly.faces, SINGLE)
    triangle, polygon = triangulate(faces.point[faces.loop], faces.start)
    corners = faces.loop[triangle]
    owner = faces.owner[polygon]
    sizes = np.bincount(point_owners(faces), minlength=len(assembly))
    first = Ragged.from_counts(sizes).start
    begin = np.searchsorted(owner, np.arange(len(assembly) + 1))
    points = (faces.point @ Z_UP).astype("<f4")
    index = (corners - first[owner][:, None]).astype("<u4")
    views: list[dict[str, int]] = []
    accessors: list[dict[str, Any]] = []
    for i in range(len(assembly)):
        mine, loops = points[first[i] : first[i + 1]], index[begin[i] : begin[i + 1]]
        views.append({"buffer": 0, "byteOffset": 12 * int(first[i]), "byteLength": mine.nbytes})
        views.append(
            {
                "buffer": 0,
                "byteOffset": points.nbytes + 12 * int(begin[i]),
                "byteLength": loops.nbytes,
            }
        )
        accessors.append(
            {
                "bufferView": 2 * i,
                "componentType": FLOAT,
                "count": len(mine),
                "type": "VEC3",
                "min": mine.min(axis=0).tolist(),
                "max": mine.max(axis=0).tolist(),
            }
        )
        accessors.append(
            {
                "bufferView": 2 * i + 1,
                "componentType": 5125,
                "count": loops.size,
                "type": "SCALAR",
            }
        )
    content = {
        "asset": {"version": "2.0", "generator": "drystone"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(assembly)))}],
        "nodes": [
            {"name": name, "mesh": i, "extras": {"drystone": _told(model, i)}}
            for i, name in enumerate(assembly.names)
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 2 * i}, "indices": 2 * i + 1}]}
            for i in range(len(assembly))
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": points.nbytes + index.nbytes}],
    }
    return content, points.tobytes() + index.tobytes()


def _told(model: Contents, i: int) -> dict[str, Any]:
    block = model.assembly.blocks[i]
    told = {"fixed": bool(model.assembly.fixed[i]), "density": block.density}
    return told | ({"metadata": dict(block.metadata)} if block.metadata else {})


def container(text: bytes, binary: bytes) -> bytes:
    """A GLB file of its two parts."""
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    return b"".join(
        [
            struct.pack("<3I", MAGIC, VERSION, total),
            struct.pack("<2I", len(text), JSON),
            text,
            struct.pack("<2I", len(binary), BIN),
            binary,
        ]
    )
