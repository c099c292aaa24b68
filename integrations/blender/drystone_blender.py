"""drystone in Blender: pick blocks and supports, check, colour, play the fall.

An add-on of one file for Blender 4.2 and later. Its panel is in the sidebar of the 3D view (key N),
tab drystone. drystone must be installed in the Python of Blender, once:

    blender --background --python-expr "import subprocess, sys;
    subprocess.check_call([sys.executable, '-m', 'pip', 'install', '--user', 'drystone'])"

(one line; from a checkout, write its folder instead of 'drystone'). Then: Edit, Preferences,
Add-ons, Install from Disk, this file.

Select the mesh objects that are blocks, mark some as supports, press Check. Blocks take the colour
of what they are. Joints are drawn in a collection of their own, with the normal force at each
corner. What falls gets keyframes: press Space. Clear takes all of this away again. Meshes and
materials of the objects are never changed.
"""

# No postponed annotations: Blender reads the properties of a class from its annotations.
from collections.abc import Sequence
from typing import Any

import bpy
import mathutils
import numpy as np

bl_info = {
    "name": "drystone",
    "author": "The drystone developers",
    "version": (0, 2, 0),
    "blender": (4, 2, 0),
    "location": "3D View > Sidebar > drystone",
    "description": "Does a structure of loose blocks stand by contact and friction alone?",
    "category": "Physics",
}

SUPPORT = "drystone_support"
KEPT = "drystone_colour"
"""Custom properties of an object: whether it is a support; the colour that it had before."""
DRAWN = "drystone"
"""Name of the collection of what is drawn."""
FRAMES = 60
"""A fall takes so many frames from the current one."""
STEP = 3
"""Frames between two keyframes."""


def blocks_among(objects: Sequence[Any]) -> list[Any]:
    """The mesh objects, without what was drawn here."""
    drawn = bpy.data.collections.get(DRAWN)
    ours = set() if drawn is None else {one.name for one in drawn.objects}
    return [one for one in objects if one.type == "MESH" and one.name not in ours]


def model_of(objects: Sequence[Any], scene: Any, friction: float, density: float) -> Any:
    """The model of mesh objects with their modifiers, in metres, loaded by the scene's gravity.

    Raises
    ------
    drystone.InputError
        An object is no closed solid, or all or none of them are supports.
    """
    import drystone

    scale = scene.unit_settings.scale_length
    graph = bpy.context.evaluated_depsgraph_get()
    blocks = []
    for one in objects:
        seen = one.evaluated_get(graph)
        mesh = seen.to_mesh()
        place = np.array(one.matrix_world)
        local = np.empty(3 * len(mesh.vertices))
        mesh.vertices.foreach_get("co", local)
        points = scale * (local.reshape(-1, 3) @ place[:3, :3].T + place[:3, 3])
        faces = tuple(tuple(face.vertices) for face in mesh.polygons)
        seen.to_mesh_clear()
        blocks.append(drystone.Block(points, faces, one.name, density))
    fixed = np.array([bool(one.get(SUPPORT)) for one in objects])
    if fixed.all() or not fixed.any():
        told = "every block is a support" if fixed.all() else "no block is a support"
        raise drystone.InputError(told, remedy="select some blocks and press Support")
    assembly = drystone.Assembly(tuple(blocks), fixed)
    pull = np.array(scene.gravity) * scale if scene.use_gravity else np.array([0.0, 0.0, -9.81])
    return drystone.Model.of(assembly, friction=friction, load=tuple(pull.tolist()))


def show(result: Any, objects: Sequence[Any], scene: Any) -> None:
    """Colour the objects, draw the joints, and give keyframes to what falls."""
    from drystone.view.drawn_parts import block_groups
    from drystone.view.palette import rgb
    from drystone.view.subjects import scene_of

    clear(objects)
    (stage,) = scene_of(result).stages
    for _, colour, blocks in block_groups(stage):
        for i in blocks:
            objects[i][KEPT] = list(objects[i].color)
            objects[i].color = (*rgb(colour).tolist(), 1.0)
    draw_joints(stage, scene)
    if result.falls and result.mechanism is not None:
        play(result, objects, scene)


def draw_joints(stage: Any, scene: Any) -> None:
    """A mesh of the joints with the normal force as the colour of each corner."""
    from drystone.view.palette import ramp_colours

    layers = [layer for layer in stage.layers if layer.key in ("joint-force", "interfaces")]
    if not layers:
        return
    layer = layers[-1]
    scale = scene.unit_settings.scale_length
    loops = [range(a, b) for a, b in zip(layer.start[:-1], layer.start[1:], strict=True)]
    mesh = bpy.data.meshes.new("joints")
    mesh.from_pydata((layer.position / scale).tolist(), [], [list(loop) for loop in loops])
    share = np.zeros(len(layer.position))
    if layer.value is not None and layer.largest > 0.0:
        share = layer.value / layer.largest
    colour = mesh.color_attributes.new("Force", "FLOAT_COLOR", "POINT")
    colour.data.foreach_set("color", np.insert(ramp_colours(share), 3, 1.0, axis=1).ravel())
    mesh.materials.append(_force_material())
    made = bpy.data.objects.new("drystone joints", mesh)
    made.show_in_front = True  # seen through the blocks
    drawn = bpy.data.collections.new(DRAWN)
    scene.collection.children.link(drawn)
    drawn.objects.link(made)


def _force_material() -> Any:
    """A material of the colours at the corners, without shading."""
    material = bpy.data.materials.new("drystone force")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    colour, light = nodes.new("ShaderNodeVertexColor"), nodes.new("ShaderNodeEmission")
    colour.layer_name = "Force"
    end = nodes.new("ShaderNodeOutputMaterial")
    links.new(colour.outputs["Color"], light.inputs["Color"])
    links.new(light.outputs["Emission"], end.inputs["Surface"])
    return material


def play(result: Any, objects: Sequence[Any], scene: Any) -> None:
    """Keyframes of the first motion; a free fall starts slowly."""
    from drystone.view.drawn_parts import matrix_of

    scale = scene.unit_settings.scale_length
    first = scene.frame_current
    for i in result.falling:
        one = objects[i]
        start, mode = one.matrix_world.copy(), one.rotation_mode
        one["drystone_place"] = [x for row in start for x in row]
        one["drystone_mode"] = mode
        one.rotation_mode = "QUATERNION"
        for frame in range(0, FRAMES + 1, STEP):
            share = (frame / FRAMES) ** 2
            matrix = matrix_of(share * result.mechanism[i], result.assembly.centroid[i])
            matrix[:3, 3] /= scale
            one.matrix_world = mathutils.Matrix(matrix.tolist()) @ start
            for path in ("location", "rotation_quaternion"):
                one.keyframe_insert(path, frame=first + frame)
        one.matrix_world = start
    scene.frame_end = max(scene.frame_end, first + FRAMES)
    scene.frame_set(first)


def clear(objects: Sequence[Any]) -> None:
    """Take away colours, keyframes and what was drawn."""
    for one in objects:
        if KEPT in one:
            one.color = one[KEPT]
            del one[KEPT]
        if "drystone_place" in one:
            one.animation_data_clear()
            place = np.array(one["drystone_place"]).reshape(4, 4)
            one.matrix_world = mathutils.Matrix(place.tolist())
            one.rotation_mode = one["drystone_mode"]
            del one["drystone_place"], one["drystone_mode"]
    drawn = bpy.data.collections.get(DRAWN)
    if drawn is not None:
        for one in list(drawn.objects):
            bpy.data.objects.remove(one)
        bpy.data.collections.remove(drawn)


class DrystoneSettings(bpy.types.PropertyGroup):
    """What a check needs beside the blocks; the gravity is that of the scene."""

    friction: bpy.props.FloatProperty(
        name="Friction", description="Coefficient of every joint", default=0.6, min=0.0
    )
    density: bpy.props.FloatProperty(
        name="Density", description="Of every block [kg/m3]", default=2400.0, min=1e-3
    )
    answer: bpy.props.StringProperty(name="Answer")


class DRYSTONE_OT_support(bpy.types.Operator):  # noqa: N801  # Blender wants such names
    """Make the selected blocks supports, or free again."""

    bl_idname = "drystone.support"
    bl_label = "Support"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  # Blender reads a set

    def execute(self, context: Any) -> set[str]:
        """Turn the mark of every selected block."""
        for one in blocks_among(context.selected_objects):
            one[SUPPORT] = not bool(one.get(SUPPORT))
        return {"FINISHED"}


class DRYSTONE_OT_check(bpy.types.Operator):  # noqa: N801
    """Check the selected blocks; all mesh objects that are seen where nothing is selected."""

    bl_idname = "drystone.check"
    bl_label = "Check"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context: Any) -> set[str]:
        """Check, and show the answer."""
        settings = context.scene.drystone
        try:
            import drystone
        except ImportError:
            self.report({"ERROR"}, "drystone is not installed in the Python of Blender")
            return {"CANCELLED"}
        objects = blocks_among(context.selected_objects) or blocks_among(context.visible_objects)
        clear(objects)
        context.view_layer.update()
        try:
            model = model_of(objects, context.scene, settings.friction, settings.density)
            result = drystone.check(model)
        except drystone.DrystoneError as error:
            settings.answer = str(error)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        show(result, objects, context.scene)
        settings.answer = f"{result.verdict.name}: {result.message}"
        self.report({"INFO"}, settings.answer)
        _colour_views()
        return {"FINISHED"}


class DRYSTONE_OT_clear(bpy.types.Operator):  # noqa: N801
    """Take away colours, keyframes and joints."""

    bl_idname = "drystone.clear"
    bl_label = "Clear"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context: Any) -> set[str]:
        """Take them away."""
        clear(blocks_among(context.scene.objects))
        context.scene.drystone.answer = ""
        return {"FINISHED"}


class DRYSTONE_PT_panel(bpy.types.Panel):  # noqa: N801
    """Supports, friction, density, check."""

    bl_label = "drystone"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "drystone"

    def draw(self, context: Any) -> None:
        """Draw the panel."""
        settings, layout = context.scene.drystone, self.layout
        layout.operator("drystone.support")
        layout.prop(settings, "friction")
        layout.prop(settings, "density")
        layout.operator("drystone.check")
        for line in settings.answer.split("; "):
            layout.label(text=line)
        layout.operator("drystone.clear")


def _colour_views() -> None:
    """Let the views show the colours of objects, where there are windows."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.spaces.active.shading.color_type = "OBJECT"


CLASSES = (
    DrystoneSettings, DRYSTONE_OT_support, DRYSTONE_OT_check, DRYSTONE_OT_clear, DRYSTONE_PT_panel,
)  # fmt: skip


def switch_on() -> None:
    """Called by Blender when the add-on is switched on."""
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.drystone = bpy.props.PointerProperty(type=DrystoneSettings)


def switch_off() -> None:
    """Called by Blender when the add-on is switched off."""
    del bpy.types.Scene.drystone
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)


register, unregister = switch_on, switch_off  # the names by which Blender calls them
