"""The elements of an IFC file: run by ``extract.py``, never imported. Needs ifcopenshell."""

import importlib
from typing import Any

_PARTS = (
    "IfcWall", "IfcColumn", "IfcBeam", "IfcSlab", "IfcMember", "IfcPlate", "IfcFooting", "IfcPile",
    "IfcStair", "IfcStairFlight", "IfcRoof", "IfcChimney", "IfcCovering", "IfcElementAssembly",
    "IfcBuildingElementProxy", "IfcBuildingElementPart", "IfcDiscreteAccessory", "IfcCivilElement",
    "IfcGeographicElement",
)  # fmt: skip
"""Classes of what bears. An IfcWall whose stones are parts of it is these parts."""
_ANGLE = 0.0873
"""[rad] Largest angle between the normals of neighbouring facets of a curved face: 5 degrees."""


def content(data: bytes, options: dict[str, Any]) -> dict[str, Any]:  # noqa: ARG001
    """Objects with name, class, vertices (v, 3) [m] and triangles; and the number of others."""
    ifcopenshell: Any = importlib.import_module("ifcopenshell")
    geometry: Any = importlib.import_module("ifcopenshell.geom")
    try:
        file = ifcopenshell.file.from_string(data.decode("utf-8", "replace"))
        settings = geometry.settings()
        settings.set("use-world-coords", True)
        settings.set("mesher-angular-deflection", _ANGLE)
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
            objects.append(_object(shape, element))
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
