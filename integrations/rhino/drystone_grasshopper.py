"""drystone in Grasshopper: a script component that asks a server on this machine.

For the Python 3 script component of Rhino 8. It was NOT run in Rhino: there was none where it was
written. The part that needs no Rhino is tested.

1. Start the server beside any model: ``drystone live model.obj``. It prints a link.
2. Write its client beside this file: ``drystone live --client drystone_client.py``.
3. Give the component the inputs ``blocks`` and ``supports`` (lists of meshes or Breps),
   ``friction`` (number) and ``link`` (text), and the outputs ``verdict``, ``message``, ``falling``.
4. Paste this file into it.

Closed meshes and Breps with plane faces are blocks. ``falling`` has the first 20 blocks that fall.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any


def block_of(mesh: Any, name: str, fixed: bool, to_metres: float) -> dict[str, Any]:
    """A closed mesh of RhinoCommon as a block of the JSON interface, in metres."""
    points = [[to_metres * x for x in (p.X, p.Y, p.Z)] for p in mesh.Vertices]
    faces = [[f.A, f.B, f.C] if f.IsTriangle else [f.A, f.B, f.C, f.D] for f in mesh.Faces]
    return {"name": name, "vertices": points, "faces": faces, "fixed": fixed}


def model_of(
    blocks: Iterable[Any], supports: Iterable[Any], friction: float, to_metres: float
) -> dict[str, Any]:
    """The model of free and fixed meshes: ``block-0``, ``support-0`` and so on."""
    made = [block_of(mesh, f"block-{i}", False, to_metres) for i, mesh in enumerate(blocks)]
    made += [block_of(mesh, f"support-{i}", True, to_metres) for i, mesh in enumerate(supports)]
    return {"content": {"blocks": made}, "friction": friction}


def falling_of(answer: dict[str, Any], blocks: Sequence[Any]) -> list[Any]:
    """The geometry of the blocks that an answer names."""
    names = answer["falling"]["first"]
    return [blocks[int(name.rpartition("-")[2])] for name in names]


def welded(shape: Any) -> Any:
    """One closed mesh of a mesh or a Brep, whose faces share their corners."""
    import Rhino

    mesh = Rhino.Geometry.Mesh()
    if isinstance(shape, Rhino.Geometry.Mesh):
        mesh.Append(shape)
    else:
        fast = Rhino.Geometry.MeshingParameters.FastRenderMesh
        for part in Rhino.Geometry.Mesh.CreateFromBrep(shape, fast):
            mesh.Append(part)
    mesh.Vertices.CombineIdentical(True, True)
    return mesh


def asked(
    blocks: Sequence[Any], supports: Sequence[Any], friction: float, link: str
) -> tuple[str, str, list[Any]]:
    """Verdict, message and falling geometry of shapes of the open document."""
    import drystone_client
    import Rhino

    unit = Rhino.RhinoDoc.ActiveDoc.ModelUnitSystem
    to_metres = Rhino.RhinoMath.UnitScale(unit, Rhino.UnitSystem.Meters)
    free, fixed = [welded(one) for one in blocks], [welded(one) for one in supports]
    model = model_of(free, fixed, friction, to_metres)
    answer = drystone_client.Server(link).check(model)
    return answer["verdict"], answer["message"], falling_of(answer, blocks)


if "ghenv" in globals():  # inside a component, whose inputs are global names
    given = globals()
    verdict, message, falling = asked(
        given["blocks"], given["supports"], given["friction"], given["link"]
    )
