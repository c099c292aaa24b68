"""The elements of an IFC file: run by ``extract.py``, never imported. Needs ifcopenshell."""

import importlib
import re
from itertools import accumulate, pairwise
from typing import Any

_PARTS = (
    "IfcWall", "IfcColumn", "IfcBeam", "IfcSlab", "IfcMember", "IfcPlate", "IfcFooting", "IfcPile",
    "IfcStair", "IfcStairFlight", "IfcRoof", "IfcChimney", "IfcCovering", "IfcElementAssembly",
    "IfcBuildingElementProxy", "IfcBuildingElementPart", "IfcDiscreteAccessory", "IfcCivilElement",
    "IfcGeographicElement",
)  # fmt: skip
"""Classes of what bears. An IfcWall whose stones are parts of it is these parts."""
_STONES = ("stone", "brick", "block", "concrete", "masonry", "earth")
"""Categories of materials, or words in their names, of layers that are stones. Source of the first
ones: IFC 4, IfcMaterial."""
_AXES = ("AXIS1", "AXIS2", "AXIS3")
_ANGLE = 0.0873
"""[rad] Largest angle between the normals of neighbouring facets of a curved face: 5 degrees."""


def content(data: bytes, options: dict[str, Any]) -> dict[str, Any]:  # noqa: ARG001
    """Objects with name, class, vertices (v, 3) [m] and triangles; and the number of others.

    A wall has the layers of stone it is made of, and the solid of each triangle, too.
    """
    ifcopenshell: Any = importlib.import_module("ifcopenshell")
    geometry: Any = importlib.import_module("ifcopenshell.geom")
    numbers = re.findall(rb"^#(\d+)\s*=", data, re.MULTILINE)
    if len(set(numbers)) < len(numbers):  # each refers to all of the others: 21 become 9,261
        return {"error": "several entities have one number"}
    try:
        file = ifcopenshell.file.from_string(data.decode("utf-8", "replace"))
        settings = geometry.settings()
        settings.set("use-world-coords", True)
        settings.set("mesher-angular-deflection", _ANGLE)
        metres = importlib.import_module("ifcopenshell.util.unit").calculate_unit_scale(file)
        found = geometry.iterator(settings, file, 1, exclude=["IfcOpeningElement", "IfcSpace"])
        more = found.initialize()
    except (RuntimeError, ifcopenshell.Error) as error:
        return {"error": str(error)}
    objects: list[dict[str, Any]] = []
    skipped: dict[str, int] = {}
    whole: set[int] = set()
    while more:
        shape = found.get()
        element = file.by_id(shape.id)
        if any(element.is_a(kind) for kind in _PARTS):
            try:
                stones = _stones(shape, element, metres)
            except (AttributeError, TypeError, ValueError):  # values of other types
                stones, what = {}, "layers that cannot be read"
                skipped[what] = skipped.get(what, 0) + 1
            objects.append(_object(shape, element) | stones)
            whole |= {one.RelatingObject.id() for one in getattr(element, "Decomposes", ())}
        else:
            skipped[shape.type] = skipped.get(shape.type, 0) + 1
        more = found.next()
    return {"objects": [one for one in objects if one["id"] not in whole], "skipped": skipped}


def _object(shape: Any, element: Any) -> dict[str, Any]:
    points, corners = shape.geometry.verts, shape.geometry.faces
    return {
        "id": element.id(),
        "name": element.Name or "",
        "kind": shape.type,
        "vertices": [points[i : i + 3] for i in range(0, len(points), 3)],
        "faces": [corners[i : i + 3] for i in range(0, len(corners), 3)],
    }


def _stones(shape: Any, element: Any, metres: float) -> dict[str, Any]:
    """The stones of a wall: the solids of its body, or its layers.

    A layer has a name, and lies between two heights [m] along a direction.
    """
    if not element.is_a("IfcWall"):
        return {}
    solids = {"solids": list(shape.geometry.item_ids)}
    usage = importlib.import_module("ifcopenshell.util.element").get_material(element)
    if usage is None or not usage.is_a("IfcMaterialLayerSetUsage"):
        return solids
    place = importlib.import_module("ifcopenshell.util.placement").get_local_placement(
        element.ObjectPlacement
    )
    along = place[:3, _AXES.index(usage.LayerSetDirection)]
    turn = 1.0 if usage.DirectionSense == "POSITIVE" else -1.0
    first = float(along @ place[:3, 3]) + usage.OffsetFromReferenceLine
    each = usage.ForLayerSet.MaterialLayers
    ends = accumulate((turn * one.LayerThickness for one in each), initial=first)
    layers = [
        {"name": one.Material.Name or "", "ends": sorted((metres * a, metres * b))}
        for one, (a, b) in zip(each, pairwise(ends), strict=True)
        if one.Material is not None and one.LayerThickness > 0.0 and _is_stone(one.Material)
    ]
    return solids | {"along": along.tolist(), "layers": layers, "others": len(each) - len(layers)}


def _is_stone(material: Any) -> bool:
    said = f"{getattr(material, 'Category', '') or ''} {material.Name or ''}".lower()
    return any(word in said for word in _STONES)
