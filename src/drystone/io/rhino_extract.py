"""The content of a 3dm file: run by ``extract.py``. Needs rhino3dm and nothing of drystone."""

import importlib
from typing import Any

_DEPTH = 16
"""Nesting of block definitions, chosen."""
TIE = "drystone-tie"
"""User text of a tie: the names of its blocks, as JSON."""
PICTURE = "drystone-picture"
"""User text of what drystone drew of a result: forces, joints, a motion. It is no block."""


def content(data: bytes, wanted: dict[str, Any]) -> dict[str, Any]:
    """All data of blocks on the requested layers."""
    rhino3dm: Any = importlib.import_module("rhino3dm")
    file = rhino3dm.File3dm.FromByteArray(data)
    if file is None:
        return {"error": "is no 3dm file that can be read"}
    found = _Found(file, wanted)
    for item in file.Objects:
        if not item.Attributes.IsInstanceDefinitionObject:
            found.take(item, None, 0)
    return {
        "units": file.Settings.ModelUnitSystem.name,
        "objects": found.objects,
        "skipped": found.skipped,
        "hidden": found.hidden,
        "ties": found.ties,
        "layers": [layer.FullPath for layer in file.Layers],
    }


class _Found:
    """Objects that were read, and the number of skipped ones by kind."""

    def __init__(self, file: Any, wanted: dict[str, Any]) -> None:
        self.file = file
        self.wanted = wanted
        self.hidden: dict[str, int] = {}
        self.layers = {layer.Index: layer for layer in file.Layers}
        self.tolerance = file.Settings.ModelAbsoluteTolerance
        self.objects: list[dict[str, Any]] = []
        self.skipped: dict[str, int] = {}
        self.ties: list[str] = []

    def take(self, item: Any, placed: Any, depth: int) -> None:
        """Add an object, moved by ``placed``; for an instance, the objects of its definition."""
        geometry, attributes = item.Geometry, item.Attributes
        kind = type(geometry).__name__
        tie = attributes.GetUserString(TIE)
        if tie:
            self.ties.append(tie)
            return
        layer = self.layers.get(attributes.LayerIndex)
        if attributes.GetUserString(PICTURE) or not self._wants(attributes, layer, depth):
            return
        if kind == "InstanceReference":
            self._instance(geometry, placed, depth)
            return
        shape = self._shape(geometry, kind)
        if shape is None:
            self._skip(kind)
            return
        if placed is not None:
            shape["placed"] = [[getattr(placed, f"M{i}{j}") for j in range(4)] for i in range(4)]
        text = dict(geometry.GetUserStrings())
        text.update(dict(attributes.GetUserStrings()))
        self.objects.append(
            {
                "name": attributes.Name,
                "layer": layer.FullPath if layer is not None else "",
                "id": str(attributes.Id),
                "text": {key: value for key, value in text.items() if isinstance(value, str)},
                **shape,
            }
        )

    def _wants(self, attributes: Any, layer: Any, depth: int) -> bool:
        """Whether an object is on a requested layer, or visible if no layer is requested."""
        path = layer.FullPath if layer is not None else ""
        named = self.wanted["layers"]
        if named:  # parts of an instance follow its layer
            return depth > 0 or any(one in (path, path.rpartition("::")[2]) for one in named)
        seen = attributes.Visible and (layer is None or layer.Visible)
        if seen or self.wanted["hidden"]:
            return True
        self.hidden[path] = self.hidden.get(path, 0) + 1
        return False

    def _skip(self, kind: str) -> None:
        self.skipped[kind] = self.skipped.get(kind, 0) + 1

    def _instance(self, reference: Any, placed: Any, depth: int) -> None:
        definition = self.file.InstanceDefinitions.FindId(reference.ParentIdefId)
        if definition is None or depth >= _DEPTH:
            self._skip("InstanceReference")
            return
        here = reference.Xform if placed is None else placed * reference.Xform
        for identity in definition.GetObjectIds():
            item = self.file.Objects.FindId(str(identity))
            if item is not None:
                self.take(item, here, depth + 1)

    def _shape(self, geometry: Any, kind: str) -> dict[str, Any] | None:
        if kind == "Mesh":
            return {"kind": "mesh", **_mesh([geometry])}
        drawn = None
        if kind == "Extrusion":
            rhino3dm: Any = importlib.import_module("rhino3dm")
            drawn = geometry.GetMesh(rhino3dm.MeshType.Any)  # a Brep made of it has no mesh
            geometry = geometry.ToBrep(True)
            kind = "Brep" if geometry is not None else kind
        if kind != "Brep":
            return None if drawn is None else {"kind": "drawn", **_mesh([drawn])}
        return self._brep(geometry, drawn)

    def _brep(self, brep: Any, carried: Any) -> dict[str, Any]:
        """Loops of a planar Brep; else its render meshes; else the problem."""
        curved = [i for i in range(len(brep.Faces)) if not brep.Faces[i].IsPlanar(self.tolerance)]
        bent = [i for i in range(len(brep.Edges)) if not brep.Edges[i].IsLinear(self.tolerance)]
        if not curved and not bent:
            return {"kind": "brep", **_loops(brep)}
        if carried is not None:
            return {"kind": "drawn", **_mesh([carried])}
        rhino3dm: Any = importlib.import_module("rhino3dm")
        drawn = [brep.Faces[i].GetMesh(rhino3dm.MeshType.Any) for i in range(len(brep.Faces))]
        if drawn and all(mesh is not None for mesh in drawn):
            return {"kind": "drawn", **_mesh(drawn)}
        what = f"face {curved[0]} is curved" if curved else f"edge {bent[0]} is curved"
        return {"kind": "curved", "problem": what}


def _mesh(parts: list[Any]) -> dict[str, Any]:
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    for mesh in parts:
        first = len(vertices)
        for i in range(len(mesh.Vertices)):
            point = mesh.Vertices.Point3dAt(i)
            vertices.append([point.X, point.Y, point.Z])
        for i in range(len(mesh.Faces)):
            a, b, c, d = mesh.Faces[i]
            faces.append([first + corner for corner in ((a, b, c) if c == d else (a, b, c, d))])
    exact = all(mesh.Vertices.UseDoublePrecisionVertices for mesh in parts)
    return {"vertices": vertices, "faces": faces, "exact": exact}


def _loops(brep: Any) -> dict[str, Any]:
    """Per face its loops of vertices, the outer one first, counter-clockwise from outside."""
    vertices = []
    for i in range(len(brep.Vertices)):
        point = brep.Vertices[i].Location
        vertices.append([point.X, point.Y, point.Z])
    faces = []
    for i in range(len(brep.Faces)):
        face = brep.Faces[i]
        outer: list[list[int]] = []
        inner: list[list[int]] = []
        for loop in face.Loops:
            corners = [trim.StartVertexIndex for trim in loop.Trims if trim.EdgeIndex >= 0]
            if face.OrientationIsReversed:
                corners.reverse()
            (outer if loop.LoopType.name == "Outer" else inner).append(corners)
        faces.append(outer + inner)
    return {"vertices": vertices, "loops": faces, "exact": True}
