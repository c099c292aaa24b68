"""IFC of building models: each bearing element is a block; of a wall of stones each stone.

Walls, columns, beams, members, plates, proxies and the like are read, with their names; what does
not bear (doors, windows, furniture) is left out and counted. Footings and piles are fixed. Needs
ifcopenshell. Curved faces become facets whose normals differ by at most 5 degrees.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from drystone.base.errors import FormatError
from drystone.io.draft import Draft
from drystone.io.face_soup import FaceSoup, named_apart, shapes_of
from drystone.io.jsontext import parse
from drystone.io.outside import content_of, require

PROGRAM = Path(__file__).with_name("ifc_extract.py")
WALL_S = 20.0
_SAME = 1e-9
"""Distance of coincident points, relative to the extent."""
_FIXED = ("IfcFooting", "IfcPile")


def read(data: bytes, path: Path) -> Draft:
    """Blocks of an IFC file."""
    require("ifcopenshell", "ifc", "reading IFC")
    top = parse(content_of(data, path, PROGRAM, {}, WALL_S), path)
    if top.has("error"):
        raise FormatError(
            "is no IFC file that can be read", where=str(path), remedy="export it again"
        )
    soups = []
    for one in top["objects"].elements():
        kind = one["kind"].text()
        faces = [tuple(face) for face in one["faces"].integers(None, 3).tolist()]
        name = one["name"].text() or kind
        soups.append(FaceSoup(one["vertices"].floats(None, 3), faces, name, kind, split=False))
    if not soups:
        raise FormatError(
            "holds no element that bears",
            where=str(path),
            remedy="walls, columns, beams, members, plates, proxies and their parts are read",
        )
    shapes, notes = shapes_of(soups, _SAME, path)
    shapes = [
        replace(one, fixed=one.where in _FIXED, metadata={"class": one.where}) for one in shapes
    ]
    notes = [note for note in notes if "coincident" not in note]
    notes += [f"{n.integer()} x {kind} left out" for kind, n in top["skipped"].items()]
    shapes, renamed = named_apart(shapes)
    return Draft(tuple(shapes), "m", notes=(*notes, *renamed))
