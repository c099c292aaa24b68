"""Writing Rhino 3dm; see :mod:`drystone.io.rhino`. Needs rhino3dm (extra ``cad``)."""

from __future__ import annotations

import base64
import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from drystone.assembly import Block
from drystone.base.errors import FormatError, require
from drystone.base.files import write_bytes
from drystone.base.ragged import Ragged
from drystone.geometry.triangulate import triangulate
from drystone.io.draft import Contents
from drystone.io.rhino import TEXT, UNITS
from drystone.io.rhino_extract import TIE


def write(model: Contents, path: Path) -> None:
    """Meshes in double precision, with names, layers, supports and densities; ties as lines.

    Polygons with more than four corners are cut into triangles for Rhino; they are kept in the user
    text, so that reading the file gives the same block.
    """
    file = empty_file("writing 3dm", model.units)
    layers: dict[str, int] = {}
    for block, fixed in zip(model.assembly.blocks, model.assembly.fixed.tolist(), strict=True):
        layer = str(block.metadata.get("layer", "supports" if fixed else "blocks"))
        if layer not in layers:
            layers[layer] = add_layer(file, layer.rpartition("::")[2])
        file.Objects.AddMesh(mesh_of(block), attributes_of(block, fixed, layers[layer], path))
    _add_ties(file, model)
    save(file, path)


def _add_ties(file: Any, model: Contents) -> None:
    """A line on a layer of their own for each tie."""
    rhino3dm: Any = importlib.import_module("rhino3dm")
    layer = add_layer(file, "ties") if model.ties else 0
    for pair in model.ties:
        ends = [rhino3dm.Point3d(*model.assembly[name].centroid.tolist()) for name in pair]
        attributes = rhino3dm.ObjectAttributes()
        attributes.Name, attributes.LayerIndex = "tie", layer
        attributes.SetUserString(TIE, json.dumps(pair))
        file.Objects.AddLine(*ends, attributes)


def empty_file(purpose: str, units: str = "m") -> Any:
    """A file without objects.

    Raises
    ------
    MissingDependency
        rhino3dm is not installed.
    """
    require("rhino3dm", "cad", purpose)
    rhino3dm: Any = importlib.import_module("rhino3dm")
    file = rhino3dm.File3dm()
    named = {unit: name for name, unit in UNITS.items()}
    file.Settings.ModelUnitSystem = getattr(rhino3dm.UnitSystem, named[units])
    return file


def save(file: Any, path: Path) -> None:
    """Write the whole file, or nothing; ``file.Write`` would not say why it fails."""
    write_bytes(path, base64.b64decode(file.Encode()))


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
