"""The Blender add-on, in Blender without a window: ``pip install bpy`` where there is a wheel."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from drystone.models import arch

bpy: Any = pytest.importorskip("bpy", reason="no bpy (Blender as a module) in this environment")
FILE = Path(__file__).parents[2] / "integrations" / "blender" / "drystone_blender.py"


@pytest.fixture
def addon() -> Iterator[ModuleType]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    spec = importlib.util.spec_from_file_location("drystone_blender", FILE)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    sys.modules["drystone_blender"] = made
    spec.loader.exec_module(made)
    made.register()
    yield made
    made.unregister()


def placed(scale: float = 1.0) -> list[Any]:
    """An arch as mesh objects, each with an origin of its own that is not its centroid."""
    objects = []
    assembly = arch(0.2, 8)
    for block, fixed in zip(assembly.blocks, assembly.fixed.tolist(), strict=True):
        mesh = bpy.data.meshes.new(block.name)
        mesh.from_pydata(((block.vertices - 0.5) / scale).tolist(), [], [*map(list, block.faces)])
        one = bpy.data.objects.new(block.name, mesh)
        one.location = (0.5 / scale,) * 3
        bpy.context.scene.collection.objects.link(one)
        if fixed:
            one["drystone_support"] = True
        objects.append(one)
    bpy.context.scene.unit_settings.scale_length = scale
    bpy.context.view_layer.update()
    return objects


@pytest.mark.parametrize("scale", [1.0, 0.001])
def test_an_arch_stands_and_its_joints_are_drawn(addon, scale):
    objects = placed(scale)
    before = [np.array(one.matrix_world) for one in objects]
    assert bpy.ops.drystone.check() == {"FINISHED"}
    assert bpy.context.scene.drystone.answer.startswith("STABLE")
    joints = bpy.data.objects["drystone joints"]
    assert len(joints.data.polygons) == 9
    colour = np.empty(4 * len(joints.data.vertices))
    joints.data.color_attributes["Force"].data.foreach_get("color", colour)
    assert np.ptp(colour.reshape(-1, 4)[:, 0]) > 0.5  # white to dark blue
    assert all(one.animation_data is None for one in objects)
    assert bpy.ops.drystone.clear() == {"FINISHED"}
    assert bpy.data.objects.get("drystone joints") is None
    after = [np.array(one.matrix_world) for one in objects]
    assert np.array_equal(before, after)
    assert {tuple(one.color) for one in objects} == {(1.0, 1.0, 1.0, 1.0)}


def test_with_little_friction_it_falls_and_plays(addon):
    objects = placed()
    start = {one.name: np.array(one.matrix_world) for one in objects}
    bpy.context.scene.drystone.friction = 0.1
    assert bpy.ops.drystone.check() == {"FINISHED"}
    assert bpy.context.scene.drystone.answer.startswith("UNSTABLE")
    bpy.context.scene.frame_set(bpy.context.scene.frame_current + addon.FRAMES)
    moved = [one for one in objects if one.animation_data is not None]
    assert moved
    assert not any(one.get("drystone_support") for one in moved)
    ways = [np.array(one.matrix_world)[2, 3] - start[one.name][2, 3] for one in moved]
    assert min(ways) < -0.01  # something comes down
    assert bpy.ops.drystone.check() == {"FINISHED"}  # asked again: from where they were
    bpy.ops.drystone.clear()
    bpy.context.view_layer.update()
    for one in objects:
        assert np.allclose(np.array(one.matrix_world), start[one.name], atol=1e-6)


def test_supports_are_marked_by_hand_and_trouble_is_told(addon):
    objects = placed()
    for one in objects:
        one["drystone_support"] = False
    with pytest.raises(RuntimeError, match="no block is a support"):
        bpy.ops.drystone.check()
    for one in objects:
        one.select_set(one.name.startswith("springer"))
    bpy.ops.drystone.support()
    assert [one.name for one in objects if one["drystone_support"]] == [
        "springer-left", "springer-right"
    ]  # fmt: skip
    bpy.ops.object.select_all(action="DESELECT")
    assert bpy.ops.drystone.check() == {"FINISHED"}
    objects[3].data.clear_geometry()
    objects[3].data.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    with pytest.raises(RuntimeError, match=objects[3].name):
        bpy.ops.drystone.check()
