#! python 3
"""drystone in Rhino 8: do the chosen blocks stand?

Run it from the command *ScriptEditor*. It asks for blocks, for the supports among them and for the
friction. Blocks that fall become purple, a dot tells the verdict, and the layer *forces* has a line
through each joint, the longer the larger its force. Undo takes this back. It was NOT run in Rhino:
there was none where it was written.

The Python of Rhino 8 is 3.9 and drystone needs 3.11: ``# r: drystone`` cannot install it. Install
drystone outside Rhino, and put the full path of its program below where Rhino does not find it.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

PROGRAM = "drystone"
FALLS, FORCES = (204, 121, 167), (0, 158, 115)  # the colours of its own pages


def block_of(mesh: Any, name: str, fixed: bool, to_metres: float) -> dict[str, Any]:
    """A closed mesh of RhinoCommon as a block of the JSON interface, in metres."""
    points = [[to_metres * x for x in (p.X, p.Y, p.Z)] for p in mesh.Vertices]
    faces = [[f.A, f.B, f.C] if f.IsTriangle else [f.A, f.B, f.C, f.D] for f in mesh.Faces]
    return {"name": name, "vertices": points, "faces": faces, "fixed": fixed}


def model_of(
    blocks: Iterable[Any], supports: Iterable[Any], friction: float, to_metres: float
) -> dict[str, Any]:
    """The model of free and fixed shapes: ``block-0``, ``support-0`` and so on."""
    made = [block_of(welded(one), f"block-{i}", False, to_metres) for i, one in enumerate(blocks)]
    for i, one in enumerate(supports):
        made.append(block_of(welded(one), f"support-{i}", True, to_metres))
    return {"content": {"blocks": made}, "friction": friction}


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


def unit_of_document() -> float:
    """Metres of a unit of the open document."""
    import Rhino

    unit = Rhino.RhinoDoc.ActiveDoc.ModelUnitSystem
    return float(Rhino.RhinoMath.UnitScale(unit, Rhino.UnitSystem.Meters))


def named(names: Iterable[str], blocks: Sequence[Any]) -> list[Any]:
    """The blocks of names such as ``block-3``."""
    return [blocks[int(name.rpartition("-")[2])] for name in names]


def checked(model: dict[str, Any]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """The answer of the program, and a row for each joint that has forces.

    Raises RuntimeError with what the program says where it cannot answer.
    """
    others = {"PYTHONHOME", "PYTHONPATH"}  # where Rhino's Python is, drystone's is not
    with tempfile.TemporaryDirectory() as folder:
        given, joints = Path(folder, "model.json"), Path(folder, "joints.json")
        given.write_text(json.dumps(model["content"]), "utf-8")
        line = [PROGRAM, "check", str(given), "--friction", str(model["friction"])]
        try:
            done = subprocess.run(
                [*line, "--json", "--joints", str(joints)],
                capture_output=True,
                check=False,
                encoding="utf-8",
                env={key: value for key, value in os.environ.items() if key not in others},
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            raise RuntimeError(f"{error}: give the full path of drystone as PROGRAM") from error
        if done.returncode not in (0, 1):
            raise RuntimeError(done.stderr.strip() or f"{PROGRAM} ended with {done.returncode}")
        rows = json.loads(joints.read_text("utf-8"))["rows"] if joints.exists() else []
        return json.loads(done.stdout), rows


def lines_of(rows: Sequence[dict[str, Any]], longest: float, to_metres: float) -> list[Any]:
    """Start and end of a line along the force of each joint; the largest force has the longest."""
    forces = [[row[f"force_{axis}"] for axis in "xyz"] for row in rows]
    largest = max((sum(x * x for x in force) ** 0.5 for force in forces), default=0.0) or 1.0
    half = 0.5 * longest / largest
    return [
        [[row[a] / to_metres + side * row[f"force_{a}"] for a in "xyz"] for side in (-half, half)]
        for row in rows
    ]


def main() -> None:
    """Ask, check and draw."""
    import rhinoscriptsyntax as rs

    solid = rs.filter.surface | rs.filter.polysurface | rs.filter.mesh | rs.filter.extrusion
    every: list[Any] = rs.GetObjects("Blocks and their supports", solid, preselect=True) or []
    held: list[Any] = (every and rs.GetObjects("Supports among them", objects=every)) or []
    friction = rs.GetReal("Friction coefficient", 0.6, 0.0) if held else None
    if friction is None:
        return
    if broken := [one for one in every if not rs.IsObjectSolid(one)]:
        rs.SelectObjects(broken)
        rs.MessageBox(f"{len(broken)} objects are not closed: selected now", 48, "drystone")
        return
    supports = {str(one) for one in held}
    free = [one for one in every if str(one) not in supports]
    blocks, fixed = [[rs.coercemesh(x) or rs.coercebrep(x) for x in some] for some in (free, held)]
    to_metres = unit_of_document()
    try:
        answer, joints = checked(model_of(blocks, fixed, friction, to_metres))
    except RuntimeError as error:
        rs.MessageBox(str(error), 48, "drystone")
        return
    draw(answer, joints, free, to_metres)


def draw(
    answer: dict[str, Any], joints: Sequence[dict[str, Any]], free: Sequence[Any], to_metres: float
) -> None:
    """Colour what falls, and draw verdict and forces in place of those of an earlier run."""
    import rhinoscriptsyntax as rs

    rs.EnableRedraw(False)
    for name, color in (("verdict", (0, 0, 0)), ("forces", FORCES)):
        rs.DeleteObjects(rs.ObjectsByLayer(rs.AddLayer(f"drystone::{name}", color)))
    for one in free:
        color = rs.ObjectColor(one)
        if (color.R, color.G, color.B) == FALLS:
            rs.ObjectColorSource(one, 0)
    for one in named(answer["falling"], free):
        rs.ObjectColor(one, FALLS)
    boxes = [rs.BoundingBox(one) for one in free]
    longest = max((rs.Distance(box[0], box[6]) for box in boxes), default=1.0)
    for start, end in lines_of(joints, longest, to_metres):
        rs.ObjectLayer(rs.AddLine(start, end), "drystone::forces")
    told = "{}: {}".format(answer["verdict"].upper(), answer["message"])
    top = max((box[4] for box in boxes), key=lambda corner: corner[2], default=(0.0, 0.0, 0.0))
    rs.ObjectLayer(rs.AddTextDot(told, top), "drystone::verdict")
    rs.EnableRedraw(True)
    print(answer["title"], *answer["sentences"], sep="\n")  # noqa: T201  # on Rhino's command line


if __name__ == "__main__":
    main()
