"""Rhino 3dm: meshes, extrusions and planar Breps; names, layers, user text and units.

User text of an object: ``support`` (true or false), ``density`` [kg/m3], ``friction``. Objects on a
layer called ``supports``, ``fixed`` or ``ground`` are fixed. For a curved Brep the render mesh in
the file is read, if there is one, with a note. Needs rhino3dm (extra ``cad``).
"""

from __future__ import annotations

import base64
import importlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Block
from drystone.base.arrays import ROUNDING, SAME, Floats
from drystone.base.errors import FormatError, InputError, require
from drystone.base.files import write_bytes
from drystone.base.ragged import Ragged
from drystone.geometry.planar import faces_with_holes
from drystone.geometry.polyhedron import Loop
from drystone.geometry.triangulate import triangulate
from drystone.io import outside
from drystone.io.draft import (
    Contents,
    Draft,
    DraftBlock,
    FaceSoup,
    hidden_notes,
    holds,
    moved,
    named_apart,
    require_blocks,
    shapes_of,
)
from drystone.io.jsontext import Field, parse
from drystone.io.rhino_extract import TIE

UNITS = {"Millimeters": "mm", "Centimeters": "cm", "Meters": "m", "Inches": "in", "Feet": "ft"}
YES, NO = ("true", "yes", "1"), ("false", "no", "0")
TEXT = "drystone"
"""User text for data that a mesh of Rhino cannot hold."""
PROGRAM = Path(__file__).with_name("rhino_extract.py")
WALL_S = 4.0
"""[s] Any small file is answered within 5 s; one of some hundred KiB takes 0.2 s."""


def read(data: bytes, path: Path, *, layers: Sequence[str] = (), hidden: bool = False) -> Draft:
    """Blocks of a 3dm file: visible objects, objects on ``layers``, or hidden objects too."""
    require("rhino3dm", "cad", "reading 3dm")
    wanted = {"layers": list(layers), "hidden": hidden}
    top = parse(outside.content_of(data, path, PROGRAM, wanted, WALL_S), path)
    if top.has("error"):
        raise FormatError(top["error"].text(), where=str(path), remedy="save it again in Rhino")
    units = UNITS.get(top["units"].text())
    notes = [f"{count.integer()} x {kind} left out" for kind, count in top["skipped"].items()]
    unread = {layer: count.integer() for layer, count in top["hidden"].items()}
    notes += hidden_notes(unread)
    if units is None:
        notes.append(f"its unit, {top['units'].text()}, is not known; metres assumed")
    shapes: list[DraftBlock] = []
    for number, item in enumerate(top["objects"].elements()):
        made, remarks = _shapes(item, number, path)
        shapes += made
        notes += remarks
    known = [one.text() for one in top["layers"].elements()]
    require_blocks(shapes, layers, known, unread, path)
    shapes, renamed = named_apart(shapes)
    ties = [_tie(one.text(), path) for one in top["ties"].elements()]
    names = {shape.name for shape in shapes}
    lost = [(a, b) for a, b in ties if not {a, b} <= names]
    notes += [f"the tie of '{a}' and '{b}' left out: one of them is not there" for a, b in lost]
    return Draft(
        tuple(shapes), units=units, notes=(*dict.fromkeys(notes), *renamed), ties=tuple(ties)
    )


def _tie(text: str, path: Path) -> tuple[str, str]:
    """The names of the two blocks of a tie."""
    kept = parse(text.encode(), path)
    names = [one.text() for one in kept.elements()]
    if len(names) != 2 or names[0] == names[1]:
        raise kept.error("does not name two blocks")
    return names[0], names[1]


def _shapes(item: Field, number: int, path: Path) -> tuple[list[DraftBlock], list[str]]:
    """The blocks of one object, one for each solid of its mesh."""
    layer = item["layer"].text().rpartition("::")[2]
    name = item["name"].text() or f"{layer or 'object'}-{number}"
    where = f"object {number}"
    place = f"{path}, {where} '{name}'"
    kind = item["kind"].text()
    if kind == "curved":
        what = f"its {item['problem'].text()}, it cannot be read exactly"
        remedy = "mesh it in Rhino, or save it while it is shaded"
        return [_unusable(name, where, what, remedy)], []
    told = _told(item["text"], place)
    made, notes = _meshes(item, told, name, where, path)
    if not made:
        return [_unusable(name, where, "a face has no outline", "repair it in Rhino")], []
    fixed = holds(layer) if told.fixed is None else told.fixed
    placed = item["placed"].floats(4, 4) if item.has("placed") else np.eye(4)
    metadata = told.metadata | ({"layer": item["layer"].text()} if layer else {})
    shapes = []
    for one in made:
        points, turned = moved(np.asarray(one.vertices), one.faces, placed)
        shapes.append(DraftBlock(one.name, points, turned, where, told.density, fixed, metadata))
    return shapes, notes


def _meshes(
    item: Field, told: _Told, name: str, where: str, path: Path
) -> tuple[list[DraftBlock], list[str]]:
    """The shapes of one object in its own frame, and notes; none if a face has no outline."""
    vertices = item["vertices"].floats(None, 3)
    kind = item["kind"].text()
    if kind == "brep":
        loops = [[_loop(one, vertices) for one in f.elements()] for f in item["loops"].elements()]
        if not all(loops):
            return [], []
        return [DraftBlock(name, vertices, faces_with_holes(vertices, loops))], []
    if told.polygons is not None and told.vertices == len(vertices):
        return [DraftBlock(name, vertices, told.polygons)], []
    faces = [_loop(face, vertices) for face in item["faces"].elements()]
    tolerance = ROUNDING if item["exact"].boolean() else SAME
    soup = FaceSoup(vertices, faces, name, f"{where} '{name}'")
    made, notes = shapes_of([soup], tolerance, path)
    drawn = [f"'{name}' is curved: its render mesh was read"] if kind == "drawn" else []
    return made, [*notes, *drawn]


def _unusable(name: str, where: str, what: str, remedy: str) -> DraftBlock:
    """A shape that is refused, or left out where defects are to be skipped."""
    return DraftBlock(name, np.zeros((0, 3)), (), where, defect=InputError(what, remedy=remedy))


def _loop(loop: Field, vertices: Floats) -> Loop:
    corners = tuple(corner.integer() for corner in loop.elements())
    if corners and not (min(corners) >= 0 and max(corners) < len(vertices)):
        raise loop.error("has a vertex that does not exist")
    return corners


@dataclass
class _Told:
    """The user text of an object."""

    fixed: bool | None = None
    density: float = DEFAULT_DENSITY
    metadata: dict[str, Any] = field(default_factory=dict)
    polygons: list[Loop] | None = None
    vertices: int = 0


def _told(text: Field, place: str) -> _Told:
    told = _Told()
    for key, value in text.items():
        word = value.text().strip()
        if key == TEXT:
            _our_own(told, parse(word.encode(), Path(place)))
        elif key.lower() in ("support", "fixed"):
            if word.lower() not in YES + NO:
                raise FormatError(
                    f"user text '{key}' is '{word[:40]}'", where=place, remedy="write true or false"
                )
            told.fixed = word.lower() in YES
        elif key.lower() == "density":
            told.density = _number(word, key, place)
        elif key.lower() == "friction":
            told.metadata["friction"] = _number(word, key, place)
        else:
            told.metadata[key] = value.text()
    return told


def _number(word: str, key: str, place: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = float("nan")
    if not 0.0 <= value < float("inf"):
        raise FormatError(
            f"user text '{key}' is '{word[:40]}'", where=place, remedy="write a number"
        )
    return value


def _our_own(told: _Told, kept: Field) -> None:
    """Polygons and metadata of a block written by drystone."""
    told.vertices = kept["vertices"].integer()
    told.polygons = []
    for face in kept["faces"].elements():
        corners = tuple(corner.integer() for corner in face.elements())
        if not all(0 <= corner < told.vertices for corner in corners):
            raise face.error("has a vertex that does not exist")
        told.polygons.append(corners)
    told.metadata.update(kept.get("metadata", {}).object().value)


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
    """The surface of a block as a mesh of Rhino."""
    large = [face for face in block.faces if len(face) > 4]
    faces: list[Sequence[int]] = [face for face in block.faces if len(face) <= 4]
    if large:
        corners = np.array([corner for face in large for corner in face], dtype=np.intp)
        start = Ragged.of(large).start
        faces += corners[triangulate(block.vertices[corners], start)[0]].tolist()
    return mesh_of_faces(block.vertices, faces)


def mesh_of_faces(points: Floats, faces: Iterable[Sequence[int]]) -> Any:
    """Faces of three or four of some points (p, 3) as a mesh of Rhino, in double precision."""
    rhino3dm: Any = importlib.import_module("rhino3dm")
    mesh = rhino3dm.Mesh()
    mesh.Vertices.UseDoublePrecisionVertices = True
    for point in points.tolist():
        mesh.Vertices.AddPoint3d(*point)
    for face in faces:
        mesh.Faces.AddFace(*face)
    return mesh
