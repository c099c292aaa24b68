"""Answers as files for CAD programs: Rhino 3dm and GLB."""

from __future__ import annotations

import importlib
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from drystone.answer.scene import Layer, LayerKind, Scene, SceneStage, State
from drystone.base.arrays import Floats, Ints
from drystone.base.errors import FormatError, InputError, clean
from drystone.base.files import write_bytes
from drystone.contacts import Contacts
from drystone.geometry.triangulate import triangulate
from drystone.io.glb import TRIANGLES, Z_UP, GlbParts, block_meshes
from drystone.io.rhino import add_layer, attributes_of, empty_file, mesh_of, mesh_of_faces, save
from drystone.io.rhino_extract import PICTURE
from drystone.results.stage import VIRTUAL
from drystone.view.drawn_parts import (
    Triangles,
    arrow_ends,
    arrows,
    block_groups,
    fall_moments,
    marks,
    matrix_of,
    quaternions,
    stage_of_scene,
    tubes,
)
from drystone.view.palette import (
    PRESETS,
    ROLE_COLOUR,
    STATE_COLOUR,
    first_preset,
    is_shown,
    ramp_colours,
    rgb,
)
from drystone.view.subjects import Subject, scene_of

NETWORK, ARROW, MARK = 0.05, 0.02, 0.05
"""Radii of the line of the largest force, of an arrow and of a mark, relative to the size of a
block. Chosen by eye."""
_PLACED_S = 1.6
"""Time [s] from one block of an assembly to the next, as on the page."""


def write_glb(scene: Scene, path: Path, stage: int | None, preset: str) -> None:
    """Write one stage of a scene; a plan plays all of them."""
    made = _Glb(scene, stage_of_scene(scene, stage), preset)
    made.blocks()
    for layer in made.stage.layers:
        if layer.count and is_shown(layer, preset):
            made.layer(layer)
    made.animations(whole=stage is None)
    write_bytes(path, made.whole())


class _Glb(GlbParts):
    """The parts of a file while it is made."""

    def __init__(self, scene: Scene, stage: SceneStage, preset: str) -> None:
        super().__init__()
        self.scene, self.stage, self.opacity = scene, stage, PRESETS[preset].opacity
        self.roots: list[int] = []
        self.node_of = np.full(len(scene.assembly), -1, dtype=np.intp)

    def material(self, name: str, colour: str, opacity: float = 1.0) -> int:
        """A rough material of one colour."""
        entry: dict[str, Any] = {
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [*_linear(rgb(colour)).tolist(), opacity],
                "metallicFactor": 0.0,
                "roughnessFactor": 0.9,
            },
        }
        return self.add("materials", entry | ({"alphaMode": "BLEND"} if opacity < 1.0 else {}))

    def mesh(self, points: Floats, corners: Ints, material: int, colour: Floats | None) -> int:
        """A mesh of triangles (t, 3), perhaps with a colour (p, 3) at each point."""
        attributes = {"POSITION": self.numbers(points @ Z_UP, bounds=True)}
        if colour is not None:
            attributes["COLOR_0"] = self.numbers(_linear(colour))
        part = {
            "attributes": attributes,
            "indices": self.numbers(corners.ravel()),
            "material": material,
            "mode": TRIANGLES,
        }
        return self.add("meshes", {"primitives": [part]})

    def blocks(self) -> None:
        """A node for each block, about its centroid, below one for each group."""
        assembly = self.scene.assembly
        meshes = block_meshes(assembly)
        for name, colour, blocks in block_groups(self.stage):
            material = self.material(name, colour, self.opacity)
            children = []
            for i in blocks:
                points, corners = meshes[i]
                mesh = self.mesh(points - assembly.centroid[i], corners, material, None)
                told = {"fixed": bool(assembly.fixed[i]), "density": assembly.blocks[i].density}
                node = {
                    "name": assembly.names[i],
                    "mesh": mesh,
                    "translation": (assembly.centroid[i] @ Z_UP).tolist(),
                    "extras": {"drystone": told},
                }
                self.node_of[i] = self.add("nodes", node)
                children.append(int(self.node_of[i]))
            self.roots.append(self.add("nodes", {"name": name, "children": children}))

    def layer(self, layer: Layer) -> None:
        """A node with the content of a layer."""
        colour = None
        if layer.kind is LayerKind.POLYGONS and layer.start is not None:
            points = layer.position
            corners, _ = triangulate(points, layer.start)
            if layer.value is not None:
                top = self.scene.top(layer.key)
                colour = ramp_colours(layer.value / top if top > 0.0 else layer.value)
        else:
            points, corners = _solids(layer, self.scene)
        ink = "#ffffff" if colour is not None else ROLE_COLOUR["light"][layer.colour]
        material = self.material(layer.label, ink)
        if layer.kind is LayerKind.POLYGONS:
            flat = {"doubleSided": True, "extensions": {"KHR_materials_unlit": {}}}
            self.top["materials"][material] |= flat
        mesh = self.mesh(points, corners, material, colour)
        told = {"picture": layer.key}
        node = {"name": layer.label, "mesh": mesh, "extras": {"drystone": told}}
        self.roots.append(self.add("nodes", node))

    def animations(self, *, whole: bool) -> None:
        """The motion of the stage; of a plan, the insertion of each block."""
        arriving = [one for one in self.scene.stages if one.arrives and one.motion is not None]
        if whole and arriving:
            self._assembly(arriving)
        elif self.stage.motion is not None and self.stage.motion_name != VIRTUAL:
            self._fall(self.stage.motion)

    def _fall(self, motion: Floats) -> None:
        time, share = fall_moments()
        path = self.stage.path
        if path is None:
            path = share[:, None, None] * motion
        else:
            time = np.linspace(0.0, float(time[-1]), len(path))
        moments = self.numbers(time, bounds=True)
        channels = []
        for i in np.flatnonzero(motion.any(axis=1) & (self.node_of >= 0)).tolist():
            motion = path[:, i]
            place = (self.scene.assembly.centroid[i] + motion[:, :3]) @ Z_UP
            node, turn = int(self.node_of[i]), quaternions(motion[:, 3:] @ Z_UP)
            channels.append((node, "translation", moments, place, "LINEAR"))
            channels.append((node, "rotation", moments, turn, "LINEAR"))
        self.play(self.stage.motion_name, channels)

    def _assembly(self, stages: list[SceneStage]) -> None:
        channels = []
        for number, stage in enumerate(stages):
            motion = stage.motion
            if motion is None:
                continue
            begin = number * _PLACED_S
            times = np.array([0.0, max(begin, 1e-3), begin + 0.5 * _PLACED_S])
            moments = self.numbers(times, bounds=True)
            for i in np.flatnonzero(motion[:, :3].any(axis=1) & (self.node_of >= 0)).tolist():
                at = self.scene.assembly.centroid[i]
                out = at + motion[i, :3]
                place = np.stack([out, out, at]) @ Z_UP
                shown = np.repeat([[0.0], [1.0], [1.0]], 3, axis=1)
                channels.append((int(self.node_of[i]), "translation", moments, place, "LINEAR"))
                channels.append((int(self.node_of[i]), "scale", moments, shown, "STEP"))
        self.play("Assembly", channels)

    def whole(self) -> bytes:
        """The whole file."""
        told = {
            "answer": self.stage.headline,
            "message": self.stage.message,
            "made": self.scene.made,
        }
        facts = {**self.scene.facts, **self.stage.facts, **told}
        scene = {"name": self.scene.title, "nodes": self.roots}
        return self.file(scene, facts, extensionsUsed=["KHR_materials_unlit"])


def _solids(layer: Layer, scene: Scene) -> Triangles:
    """Lines, arrows and marks as solids, in the proportions of the page."""
    size = scene.block_size
    if layer.vector is None:
        return marks(layer.position, MARK * size, layer.shape)
    if layer.kind is LayerKind.LINES:
        top = scene.top(layer.key)
        share = np.ones(layer.count)
        if layer.value is not None and top > 0.0:
            share = np.clip(layer.value / top, 0.02, 1.0)  # thinner ones are invisible
        width = NETWORK if layer.value is not None else ARROW
        end = layer.position + layer.vector
        return tubes(layer.position, end, width * size * share * layer.width)
    start, end = arrow_ends(layer, scene.arrow_scale(layer.group))
    return arrows(start, end, ARROW * size * layer.width)


def _linear(colour: Floats) -> Floats:
    """Linear components from those of sRGB, as the format requires (IEC 61966-2-1)."""
    return np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)


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
    attributes.Name = clean(name)
    attributes.SetUserString(PICTURE, key)
    return attributes


def _draw(file: Any, layer: Layer, scene: Scene, stage: SceneStage, number: int) -> None:
    if layer.kind is LayerKind.POLYGONS:
        _polygons(file, layer, scene, stage, number)
    elif layer.kind is LayerKind.MARKERS:
        size = MARK * scene.block_size
        points, corners = marks(np.zeros((1, 3)), size, layer.shape)
        for at in layer.position:
            mesh = mesh_of_faces(points + at, corners.tolist())
            file.Objects.AddMesh(mesh, _drawn(number, layer.key, layer.label))
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
        own = triangle[begin[i] : begin[i + 1]] - first
        mesh = mesh_of_faces(layer.position[first:last], own.tolist())
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
    attributes.Name = clean(f"{a} - {b}")
    for what, values in (
        ("normal force [N]", stage.normal),
        ("shear force [N]", stage.tangential),
        ("friction used", stage.utilisation),
    ):
        if values is not None:
            attributes.SetUserString(what, f"{values[interface]:.6g}")


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


_WRITERS = {".3dm": write_3dm, ".glb": write_glb}


def save_cad(
    subject: Subject,
    path: str | PathLike[str],
    contacts: Contacts | None = None,
    *,
    stage: int | None = None,
    preset: str | None = None,
) -> None:
    """Write an answer for a CAD program, as Rhino 3dm or GLB; lengths are in metres.

    Blocks keep their names. Their layer or material says what they are: support, free, falling, in
    need of help. Joints are coloured by the force at each corner. What is drawn is marked, so that
    reading the file again finds the blocks alone.

    Parameters
    ----------
    subject
        A result, a model, an assembly, a limit, a plan, a settlement, or a scene put together by
        hand.
    path
        ``.3dm``: layers for blocks, joints, forces and the motion, with forces as user text; needs
        rhino3dm (extra ``cad``). ``.glb``: materials, and the motion of a fall or the order of a
        plan as an animation.
    contacts
        Of an assembly; a result has its own.
    stage
        Its number, where there are several; the one that a figure shows when left out.
    preset
        Which layers are shown; the one that suits the answer when left out.

    Raises
    ------
    FormatError
        Another suffix, a name that the format has no place for, or the file cannot be written.
    InputError
        There is no such picture or stage.
    MissingDependency
        rhino3dm is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from drystone.models import tower
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> save_cad(tower(3), folder / "tower.glb")
    >>> (folder / "tower.glb").read_bytes()[:4]
    b'glTF'
    """
    target = Path(path)
    writer = _WRITERS.get(target.suffix.lower())
    if writer is None:
        raise FormatError(
            f"an answer cannot be written as '{target.suffix}'",
            where=str(path),
            remedy="end the name in .3dm or .glb",
        )
    scene = scene_of(subject, contacts)
    if stage is not None and not -len(scene.stages) <= stage < len(scene.stages):
        raise InputError(f"there is no stage {stage}", remedy=f"there are {len(scene.stages)}")
    chosen = first_preset(scene) if preset is None else preset
    if chosen not in PRESETS:
        raise InputError(f"there is no picture '{chosen}'", remedy=f"choose {', '.join(PRESETS)}")
    writer(scene, target, stage, chosen)
