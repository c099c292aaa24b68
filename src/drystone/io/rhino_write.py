"""Writing Rhino 3dm; see :mod:`drystone.io.rhino`. Needs rhino3dm (extra ``cad``)."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from drystone.assembly import Block
from drystone.base.errors import FormatError, require
from drystone.base.files import write_through
from drystone.base.ragged import Ragged
from drystone.geometry.triangulate import triangulate
from drystone.io.draft import Contents
from drystone.io.rhino import TEXT


def write(model: Contents, path: Path) -> None:
    """Meshes in metres, in double precision, with names, layers, supports and densities.

    Polygons with more than four corners are cut into triangles for Rhino; they are kept in the user
    text, so that reading the file gives the same block.
    """
    file = empty_file("writing 3dm")
    layers: dict[str, int] = {}
    for block, fixed in zip(model.assembly.blocks, model.assembly.fixed.tolist(), strict=True):
        layer = str(block.metadata.get("layer", "supports" if fixed else "blocks"))
        if layer not in layers:
            layers[layer] = add_layer(file, layer.rpartition("::")[2])
        file.Objects.AddMesh(mesh_of(block), attributes_of(block, fixed, layers[layer], path))
    save(file, path)


def empty_file(purpose: str) -> Any:
    """A file in metres without objects.

    Raises
    ------
    MissingDependency
        rhino3dm is not installed.
    """
    require("rhino3dm", "cad", purpose)
    rhino3dm: Any = importlib.import_module("rhino3dm")
    file = rhino3dm.File3dm()
    file.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Meters
    return file


def save(file: Any, path: Path) -> None:
    """Write the whole file, or nothing."""
    write_through(path, lambda name: bool(file.Write(name, 0)))


def add_layer(file: Any, name: str) -> int:
    """The number of a new layer."""
    rhino3dm: Any = importlib.import_module("rhino3dm")
    made = rhino3dm.Layer()
    made.Name = name
    return int(file.Layers.Add(made))


def attributes_of(block: Block, fixed: bool, layer: int, path: Path) -> Any:
    """Name, layer and user text of a block.

    Raises
    ------
    FormatError
        The name or the metadata have no place in the file.
    """
    rhino3dm: Any = importlib.import_module("rhino3dm")
    attributes = rhino3dm.ObjectAttributes()
    if any(character < " " for character in block.name):
        raise FormatError(
            f"block '{block.name}' has a control character in its name, which 3dm does not store",
            where=str(path),
            remedy="rename it without tabs and line ends",
        )
    attributes.Name = block.name
    attributes.LayerIndex = layer
    attributes.SetUserString("support", "true" if fixed else "false")
    attributes.SetUserString("density", repr(block.density))
    metadata = {key: value for key, value in block.metadata.items() if key != "layer"}
    own = {"vertices": len(block.vertices), "faces": block.faces, "metadata": metadata}
    try:
        attributes.SetUserString(TEXT, json.dumps(own, allow_nan=False))
    except (TypeError, ValueError) as error:
        raise FormatError(
            f"metadata of block '{block.name}' is no JSON value", where=str(path)
        ) from error
    return attributes


def mesh_of(block: Block) -> Any:
    """The surface of a block as a mesh of Rhino, in double precision."""
    rhino3dm: Any = importlib.import_module("rhino3dm")
    mesh = rhino3dm.Mesh()
    mesh.Vertices.UseDoublePrecisionVertices = True
    for point in block.vertices.tolist():
        mesh.Vertices.AddPoint3d(*point)
    large = [face for face in block.faces if len(face) > 4]
    for face in block.faces:
        if len(face) <= 4:
            mesh.Faces.AddFace(*face)
    if large:
        corners = np.array([corner for face in large for corner in face], dtype=np.intp)
        start = Ragged.of(large).start
        for triangle in corners[triangulate(block.vertices[corners], start)[0]].tolist():
            mesh.Faces.AddFace(*triangle)
    return mesh
