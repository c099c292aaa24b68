"""A scene as Rhino 3dm: blocks, joints, forces and the motion, each on a layer of its own.

Needs rhino3dm (extra ``cad``).
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from drystone.answer.scene import Layer, LayerKind, Scene, SceneStage, State
from drystone.base.arrays import Floats, Ints
from drystone.geometry.triangulate import triangulate
from drystone.io.rhino import add_layer, attributes_of, empty_file, mesh_of, save
from drystone.io.rhino_extract import PICTURE
from drystone.results.stage import VIRTUAL
from drystone.view.drawn_parts import arrow_ends, block_groups, marks, matrix_of, stage_of_scene
from drystone.view.glb_picture import MARK
from drystone.view.palette import ROLE_COLOUR, STATE_COLOUR, is_shown, ramp_colours, rgb

_WIDEST = 2.0
"""Width [mm] on paper of the line of the largest force. Chosen by eye."""
_MOTION = "motion"


def write_3dm(scene: Scene, path: Path, stage: int | None, preset: str) -> None:
    """Write one stage of a scene; layers that the picture does not show are switched off."""
    file = empty_file("writing 3dm")
    drawn = stage_of_scene(scene, stage)
    _blocks(file, scene, drawn, path)
    above = _layer(file, "drystone", "#000000")
    for layer in _wanted(drawn):
        if layer.count:
            colour = ROLE_COLOUR["light"][layer.colour]
            number = _layer(file, layer.label, colour, above, shown=is_shown(layer, preset))
            _draw(file, layer, scene, drawn, number)
    if drawn.motion is not None and drawn.motion_name != VIRTUAL:
        number = _layer(file, drawn.motion_name, STATE_COLOUR["light"][State.FALLING], above)
        _motion(file, scene, drawn.motion, number)
    for name, text in {**scene.facts, **drawn.facts, "Answer": drawn.headline}.items():
        file.Strings[f"drystone {name}"] = text
    save(file, path)


def _wanted(stage: SceneStage) -> list[Layer]:
    """Layers without those that repeat others with more objects."""
    keys = {layer.key for layer in stage.layers}
    doubled = {"interfaces", "pressure"} if "joint-force" in keys else set()
    return [layer for layer in stage.layers if layer.key not in doubled]


def _layer(file: Any, name: str, colour: str, above: int | None = None, shown: bool = True) -> int:
    number = add_layer(file, name)
    made = file.Layers[number]
    made.Color = _bytes(rgb(colour))
    made.Visible = shown
    if above is not None:
        made.ParentLayerId = file.Layers[above].Id
    return number


def _bytes(colour: Floats) -> tuple[int, int, int, int]:
    red, green, blue = np.rint(255.0 * colour).astype(int).tolist()
    return red, green, blue, 255


def _blocks(file: Any, scene: Scene, stage: SceneStage, path: Path) -> None:
    assembly = scene.assembly
    for name, colour, blocks in block_groups(stage):
        layer = _layer(file, name, colour)
        for i in blocks:
            block = assembly.blocks[i]
            attributes = attributes_of(block, bool(assembly.fixed[i]), layer, path)
            if scene.number is not None and scene.number[i] > 0:
                attributes.SetUserString("number", str(scene.number[i]))
            if stage.prop is not None and stage.prop[i].any():
                force = ", ".join(f"{x:.6g}" for x in stage.prop[i, :3])
                attributes.SetUserString("help needed [N]", force)
            file.Objects.AddMesh(mesh_of(block), attributes)


def _drawn(layer: int, key: str, name: str = "") -> Any:
    """Attributes of an object that is not a block."""
    rhino3dm: Any = importlib.import_module("rhino3dm")
    attributes = rhino3dm.ObjectAttributes()
    attributes.LayerIndex = layer
    attributes.Name = "".join(character for character in name if character >= " ")
    attributes.SetUserString(PICTURE, key)
    return attributes


def _draw(file: Any, layer: Layer, scene: Scene, stage: SceneStage, number: int) -> None:
    if layer.kind is LayerKind.POLYGONS:
        _polygons(file, layer, scene, stage, number)
    elif layer.kind is LayerKind.MARKERS:
        size = MARK * scene.block_size
        points, corners = marks(np.zeros((1, 3)), size, layer.shape)
        for at in layer.position:
            file.Objects.AddMesh(
                _mesh(points + at, corners), _drawn(number, layer.key, layer.label)
            )
    else:
        _lines(file, layer, scene, number)


def _polygons(file: Any, layer: Layer, scene: Scene, stage: SceneStage, number: int) -> None:
    """A mesh for each joint, coloured at its corners, with its forces as user text."""
    if layer.start is None:
        return
    triangle, polygon = triangulate(layer.position, layer.start)
    begin = np.searchsorted(polygon, np.arange(layer.count + 1))
    top = scene.top(layer.key)
    value = layer.value
    colour = None if value is None else ramp_colours(value / top if top > 0.0 else value)
    for i in range(layer.count):
        first, last = int(layer.start[i]), int(layer.start[i + 1])
        mesh = _mesh(layer.position[first:last], triangle[begin[i] : begin[i + 1]] - first)
        if colour is not None:
            for corner in colour[first:last]:
                mesh.VertexColors.Add(*_bytes(corner)[:3])
        attributes = _drawn(number, layer.key)
        if layer.interface is not None:
            _tell(attributes, scene, stage, int(layer.interface[i]))
        file.Objects.AddMesh(mesh, attributes)


def _tell(attributes: Any, scene: Scene, stage: SceneStage, interface: int) -> None:
    """The name and the forces of a joint."""
    contacts, names = scene.contacts, scene.assembly.names
    a, b = names[contacts.block_a[interface]], names[contacts.block_b[interface]]
    attributes.Name = "".join(character for character in f"{a} - {b}" if character >= " ")
    for what, values in (
        ("normal force [N]", stage.normal),
        ("shear force [N]", stage.tangential),
        ("friction used", stage.utilisation),
    ):
        if values is not None:
            attributes.SetUserString(what, f"{values[interface]:.6g}")


def _mesh(points: Floats, corners: Ints) -> Any:
    rhino3dm: Any = importlib.import_module("rhino3dm")
    mesh = rhino3dm.Mesh()
    mesh.Vertices.UseDoublePrecisionVertices = True
    for point in points.tolist():
        mesh.Vertices.AddPoint3d(*point)
    for corner in corners.tolist():
        mesh.Faces.AddFace(*corner)
    return mesh


def _lines(file: Any, layer: Layer, scene: Scene, number: int) -> None:
    """Lines with their force as user text; arrows have a head."""
    rhino3dm: Any = importlib.import_module("rhino3dm")
    if layer.vector is None:
        return
    arrows = layer.kind is LayerKind.ARROWS
    if arrows:
        start, end = arrow_ends(layer, scene.arrow_scale(layer.group))
        size = np.linalg.norm(layer.vector, axis=1)
    else:
        start, end = layer.position, layer.position + layer.vector
        size = np.zeros(layer.count) if layer.value is None else layer.value
    most = float(size.max(initial=0.0))
    for k, (a, b) in enumerate(zip(start.tolist(), end.tolist(), strict=True)):
        force = float(size[k % layer.count])
        attributes = _drawn(number, layer.key, layer.label)
        if most > 0.0:
            attributes.SetUserString(f"{layer.label} [{layer.unit}]", f"{force:.6g}")
            attributes.PlotWeightSource = rhino3dm.ObjectPlotWeightSource.PlotWeightFromObject
            attributes.PlotWeight = _WIDEST * force / most
        if arrows:
            attributes.ObjectDecoration = rhino3dm.ObjectDecoration.EndArrowhead
        file.Objects.AddLine(rhino3dm.Point3d(*a), rhino3dm.Point3d(*b), attributes)


def _motion(file: Any, scene: Scene, motion: Floats, number: int) -> None:
    """Each block that moves, at the end of the motion, and the path of its centroid."""
    rhino3dm: Any = importlib.import_module("rhino3dm")
    assembly = scene.assembly
    for i in np.flatnonzero(motion.any(axis=1)).tolist():
        block, at = assembly.blocks[i], assembly.centroid[i]
        matrix = matrix_of(motion[i], at)
        moved = block.transformed(matrix[:3, :3], matrix[:3, 3])
        file.Objects.AddMesh(mesh_of(moved), _drawn(number, _MOTION, block.name))
        attributes = _drawn(number, _MOTION, block.name)
        attributes.ObjectDecoration = rhino3dm.ObjectDecoration.EndArrowhead
        end = at + motion[i, :3]
        file.Objects.AddLine(rhino3dm.Point3d(*at), rhino3dm.Point3d(*end), attributes)
