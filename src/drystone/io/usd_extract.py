"""The bodies of a USD stage: run by ``extract.py``, never imported. Needs usd-core."""

import importlib
import json
import re
import tempfile
from pathlib import Path
from typing import Any

_MISTAKE = re.compile(r"\.usda?:(\d+):\d+: .*? at '(.*?)'(?: in <|$)", re.MULTILINE)
"""Line and text of a mistake, in what the parser of USD says."""


def content(data: bytes, options: dict[str, Any]) -> dict[str, Any] | bytes:
    """Bodies with their parts and matrices, the unit and the upward axis of a stage.

    The file is opened alone in an empty folder, so that it finds no other file.
    """
    usd, geometry, tf = (
        importlib.import_module(f"pxr.{name}") for name in ("Usd", "UsdGeom", "Tf")
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"stage{options['suffix']}"
        file.write_bytes(data)
        try:
            stage = usd.Stage.Open(str(file))
            if stage is None:
                return {"error": ""}
            if stage.GetCompositionErrors():
                return {"error": "refers to other files"}
            found = _Found(stage).content() | {
                "scale": float(geometry.GetStageMetersPerUnit(stage)),
                "up": str(geometry.GetStageUpAxis(stage)),
            }
            return json.dumps(found).encode()
        except (tf.ErrorException, TypeError, ValueError) as error:  # also values of other types
            place = _MISTAKE.search(_words(error))
            return {"error": "", **({"line": place[1], "text": place[2]} if place else {})}


def _words(error: Exception) -> str:
    """What an error says, nothing where it quotes bytes that are no text."""
    try:
        return str(error)
    except UnicodeDecodeError:
        return ""


def _plain(name: str, value: Any) -> Any:
    """The value of an attribute as JSON has it."""
    if name == "points":
        return [[float(x) for x in point] for point in value or ()]
    return [int(x) for x in value or ()] if name.startswith("face") else value


class _Found:
    """What is in a stage."""

    def __init__(self, stage: Any) -> None:
        self.stage = stage
        self.usd, self.geometry, self.physics, self.shade = (
            importlib.import_module(f"pxr.{name}")
            for name in ("Usd", "UsdGeom", "UsdPhysics", "UsdShade")
        )
        self.places = self.geometry.XformCache()
        every = self.usd.PrimRange.Stage(stage, self.usd.TraverseInstanceProxies())
        self.prims = list(every)
        self.collides = any(prim.HasAPI(self.physics.CollisionAPI) for prim in self.prims)

    def content(self) -> dict[str, Any]:
        """Bodies by the path of the prim that moves."""
        rigid = {str(prim.GetPath()) for prim in self.prims if self._is_rigid(prim)}
        joints, held = self._joints()
        bodies: dict[str, dict[str, Any]] = {}
        for prim in self.prims:
            if not prim.IsA(self.geometry.Gprim) or self._above(prim, self._is_hidden):
                continue
            if self.collides and not self._above(prim, self._is_collider):
                continue
            home = self._above(prim, self._is_rigid) or prim
            path = str(home.GetPath())
            body = bodies.setdefault(path, self._body(home, path in rigid and path not in held))
            body["parts"].append(self._part(prim))
            friction = self._friction(prim)
            body["friction"] += [] if friction is None else [friction]
        return {"bodies": list(bodies.values()), "joints": joints, "moves": bool(rigid)}

    def _body(self, prim: Any, free: bool) -> dict[str, Any]:
        told = self.physics.MassAPI(prim)
        mass, density = told.GetMassAttr().Get() or 0.0, told.GetDensityAttr().Get() or 0.0
        return {
            "name": prim.GetName(), "path": str(prim.GetPath()), "free": free, "mass": float(mass),
            "density": float(density), "parts": [], "friction": [],
        }  # fmt: skip

    def _part(self, prim: Any) -> dict[str, Any]:
        matrix = self.places.GetLocalToWorldTransform(prim)
        part: dict[str, Any] = {
            "kind": str(prim.GetTypeName()),
            "matrix": [[float(x) for x in row] for row in matrix],
        }
        names = {
            "Cube": ("size",), "Cylinder": ("radius", "height", "axis"), "Plane": ("axis",),
            "Mesh": ("points", "faceVertexCounts", "faceVertexIndices", "orientation"),
        }  # fmt: skip
        for name in names.get(part["kind"], ()):
            part[name] = _plain(name, prim.GetAttribute(name).Get())
        return part

    def _friction(self, prim: Any) -> float | None:
        material, _ = self.shade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
        value = None
        if material and material.GetPrim().HasAPI(self.physics.MaterialAPI):
            value = self.physics.MaterialAPI(material.GetPrim()).GetStaticFrictionAttr().Get()
        return None if value is None else float(value)

    def _joints(self) -> tuple[list[str], set[str]]:
        """Kinds of the joints that move or hold two bodies; paths of what is held to the world."""
        kinds, held = [], set()
        for prim in self.prims:
            if prim.IsA(self.physics.Joint):
                joint = self.physics.Joint(prim)
                ends = [*joint.GetBody0Rel().GetTargets(), *joint.GetBody1Rel().GetTargets()]
                if prim.IsA(self.physics.FixedJoint) and len(ends) == 1:
                    held.add(str(ends[0]))
                else:
                    kinds.append(str(prim.GetTypeName()))
        return kinds, held

    def _is_rigid(self, prim: Any) -> bool:
        if not prim.HasAPI(self.physics.RigidBodyAPI):
            return False
        told = self.physics.RigidBodyAPI(prim)
        on = told.GetRigidBodyEnabledAttr().Get() is not False
        return on and not told.GetKinematicEnabledAttr().Get()

    def _is_collider(self, prim: Any) -> bool:
        return bool(prim.HasAPI(self.physics.CollisionAPI))

    def _is_hidden(self, prim: Any) -> bool:
        told = self.geometry.Imageable(prim)
        return bool(told) and str(told.GetPurposeAttr().Get()) in ("guide", "proxy")

    def _above(self, prim: Any, fits: Any) -> Any:
        """The prim or the nearest above it that fits; ``None`` where there is none."""
        while prim and not prim.IsPseudoRoot():
            if fits(prim):
                return prim
            prim = prim.GetParent()
        return None
