"""IFC of building models: each bearing element is a block; of a wall of stones each stone.

Walls, columns, beams, members, plates, proxies and the like are read, with their names; what does
not bear (doors, windows, furniture) is left out and counted. Footings and piles are fixed. Of a
wall each solid is a stone, and so is each layer of a material of stone where there are several.
Needs ifcopenshell. Curved faces become facets whose normals differ by at most 5 degrees.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from drystone.base.arrays import FARTHEST, ROUNDING, Floats
from drystone.base.errors import FormatError, counted, require
from drystone.geometry.convex_pieces import mesh_of, solid_of
from drystone.geometry.polyhedron import Loop
from drystone.geometry.surface import edge_defects
from drystone.io.draft import Draft, FaceSoup, named_apart, shapes_of
from drystone.io.jsontext import Field, parse
from drystone.io.outside import content_of

PROGRAM = Path(__file__).with_name("ifc_extract.py")
_FIXED = ("IfcFooting", "IfcPile")


def read(data: bytes, path: Path) -> Draft:
    """Blocks of an IFC file."""
    require("ifcopenshell", "ifc", "reading IFC")
    top = parse(content_of(data, path, PROGRAM, {}), path)
    if top.has("error"):
        raise FormatError(
            "is no IFC file that can be read", where=str(path), remedy="export it again"
        )
    soups: list[FaceSoup] = []
    notes: list[str] = []
    for one in top["objects"].elements():
        stones, said = _stones(one)
        soups += stones
        notes += said
    if not soups:
        raise FormatError(
            "holds no element that bears",
            where=str(path),
            remedy="walls, columns, beams, members, plates, proxies and their parts are read",
        )
    shapes, said = shapes_of(soups, ROUNDING, path)
    shapes = [
        replace(one, fixed=one.where in _FIXED, metadata={"class": one.where}) for one in shapes
    ]
    notes += [note for note in said if "coincident" not in note]
    notes += [f"{n.integer()} x {kind} left out" for kind, n in top["skipped"].items()]
    shapes, renamed = named_apart(shapes)
    return Draft(tuple(shapes), "m", notes=(*notes, *renamed))


def _stones(one: Field) -> tuple[list[FaceSoup], list[str]]:
    """The stones of an element, else the element, and a note on its layers."""
    kind = one["kind"].text()
    name = one["name"].text() or kind
    points = one["vertices"].floats(None, 3)
    faces = [tuple(face) for face in one["faces"].integers(None, 3).tolist()]
    solids: dict[int, list[Loop]] = {}
    for face, of in zip(faces, one.get("solids", [0] * len(faces)).elements(), strict=True):
        solids.setdefault(of.integer(), []).append(face)
    made = [(points, own) for own in solids.values()]
    notes: list[str] = []
    if len(made) == 1 and len(one.get("layers", []).value) > 1:
        made, notes = _layers(one, points, faces, name)
    numbers = [""] if len(made) == 1 else [f"-{i}" for i in range(len(made))]
    return [
        FaceSoup(*body, f"{name}{number}", kind, split=False)
        for body, number in zip(made, numbers, strict=True)
    ], notes


def _layers(
    one: Field, points: Floats, faces: list[Loop], name: str
) -> tuple[list[tuple[Floats, list[Loop]]], list[str]]:
    """Vertices (v, 3) [m] and faces of each layer of a wall, and a note."""
    if edge_defects(faces) != ([], [], True) or not (np.abs(points) <= FARTHEST).all():
        return [(points, faces)], [f"'{name}' is no closed body: its layers are not parted"]
    body, along = solid_of(points, faces), one["along"].floats(3)
    layers, made = [*one["layers"].elements()], []
    for layer in layers:
        low, high = layer["ends"].floats(2)
        part = body.trim_by_plane(along, low).trim_by_plane(-along, -high)
        if part.volume() > 0.0:
            corner, triangle = mesh_of(part)
            made.append((corner, [tuple(each) for each in triangle.tolist()]))
    names = ", ".join(layer["name"].text() for layer in layers)
    others = one["others"].integer()
    left = f"; {counted(others, 'layer')} of other materials left out" if others else ""
    note = f"'{name}' is parted into its layers of stone: {names}{left}"
    return made or [(points, faces)], [note]
