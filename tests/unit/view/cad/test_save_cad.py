"""Answers written for CAD programs: blocks that read back, layers, colours, the fall."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone.base.errors import FormatError, InputError
from drystone.io import rhino
from drystone.models import arch, shelf
from drystone.results import Result
from drystone.view import MarkerShape, drawn_parts
from drystone.view.cad_pictures import save_cad
from drystone.view.drawn_parts import matrix_of, quaternions
from drystone.view.palette import ramp_colours


@pytest.fixture(scope="module")
def standing() -> Result:
    return drystone.check(arch(0.2, 8), friction=0.7)


@pytest.fixture(scope="module")
def falling() -> Result:
    return drystone.check(shelf(), friction=0.9)


def glb(path: Path) -> tuple[dict[str, Any], bytes]:
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def numbers(top: dict[str, Any], binary: bytes, accessor: int) -> np.ndarray[Any, Any]:
    entry = top["accessors"][accessor]
    view = top["bufferViews"][entry["bufferView"]]
    columns = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[entry["type"]]
    kind = "<f4" if entry["componentType"] == 5126 else "<u4"
    raw = np.frombuffer(binary, kind, entry["count"] * columns, view["byteOffset"])
    return raw.reshape(-1, columns)


def same_blocks(found: drystone.Assembly, given: drystone.Assembly) -> None:
    order = [found.names.index(name) for name in given.names]
    assert len(found) == len(given)
    assert np.array_equal(found.fixed[order], given.fixed)
    assert np.allclose(found.volume[order], given.volume, rtol=1e-5)
    assert np.allclose(found.centroid[order], given.centroid, atol=1e-5)


@pytest.mark.parametrize("suffix", [".glb", ".3dm"])
def test_what_is_drawn_is_no_block_when_the_file_is_read_again(
    suffix, standing, falling, tmp_path, monkeypatch
):
    if suffix == ".3dm":
        pytest.importorskip("rhino3dm")
        monkeypatch.setattr(rhino, "WALL_S", 60.0)  # a machine that does much else
    for result in (standing, falling):
        path = tmp_path / f"answer{suffix}"
        save_cad(result, path)
        same_blocks(drystone.read(path).assembly, result.assembly)


def test_a_glb_has_a_material_for_what_falls_and_plays_its_first_motion(falling, tmp_path):
    save_cad(falling, tmp_path / "fall.glb")
    top, binary = glb(tmp_path / "fall.glb")
    names = [top["materials"][i]["name"] for i in range(len(top["materials"]))]
    assert {"supports", "blocks", "falling blocks"} <= set(names)
    (animation,) = top["animations"]
    assert animation["name"] == "First motion"
    moved = {top["nodes"][c["target"]["node"]]["name"] for c in animation["channels"]}
    assert moved == {falling.assembly.names[i] for i in falling.falling}
    channel = next(c for c in animation["channels"] if c["target"]["path"] == "translation")
    block = falling.assembly.names.index(top["nodes"][channel["target"]["node"]]["name"])
    sampler = animation["samplers"][channel["sampler"]]
    time, place = (numbers(top, binary, sampler[key]) for key in ("input", "output"))
    turned = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # y up in the file
    way = place @ turned.T - falling.assembly.centroid[block]
    assert np.allclose(way[0], 0.0, atol=1e-6)
    assert falling.mechanism is not None
    assert np.allclose(way[-1], falling.mechanism[block, :3], atol=1e-6)
    half = np.searchsorted(time[:, 0], 0.5 * time[-1, 0])
    assert np.allclose(way[half], 0.25 * way[-1], atol=1e-6)  # a free fall: time squared


def test_a_model_that_stands_does_not_move(standing, tmp_path):
    save_cad(standing, tmp_path / "arch.glb")
    assert "animations" not in glb(tmp_path / "arch.glb")[0]


def test_joints_of_a_glb_have_the_colours_of_their_forces(standing, tmp_path):
    save_cad(standing, tmp_path / "arch.glb")
    top, binary = glb(tmp_path / "arch.glb")
    node = next(n for n in top["nodes"] if n["name"] == "normal force at a corner")
    part = top["meshes"][node["mesh"]]["primitives"][0]
    colour = numbers(top, binary, part["attributes"]["COLOR_0"])
    assert standing.force is not None
    force = np.maximum(standing.force[:, 0], 0.0)
    expected = ramp_colours(force / force.max())
    linear = np.where(expected <= 0.04045, expected / 12.92, ((expected + 0.055) / 1.055) ** 2.4)
    assert np.allclose(colour, linear, atol=1e-6)


def test_a_plan_brings_in_each_block_in_its_order(tmp_path):
    plan = drystone.plan(drystone.Model.of(arch(0.2, 4), friction=0.7))
    save_cad(plan, tmp_path / "plan.glb")
    top, binary = glb(tmp_path / "plan.glb")
    (animation,) = top["animations"]
    begin = {}
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        if channel["target"]["path"] == "scale":
            name = top["nodes"][channel["target"]["node"]]["name"]
            begin[name] = numbers(top, binary, sampler["input"])[1, 0]
            assert numbers(top, binary, sampler["output"])[0].tolist() == [0.0, 0.0, 0.0]
    order = [plan.model.assembly.names[b] for step in plan.steps for b in step.blocks]
    assert sorted(begin, key=lambda name: begin[name]) == order


def test_a_3dm_has_layers_for_blocks_forces_and_the_motion(falling, standing, tmp_path):
    rhino3dm = pytest.importorskip("rhino3dm")
    save_cad(falling, tmp_path / "fall.3dm")
    file = rhino3dm.File3dm.Read(str(tmp_path / "fall.3dm"))
    on = {layer.Index: layer.FullPath for layer in file.Layers}
    counts: dict[str, int] = {}
    for item in file.Objects:
        name = on[item.Attributes.LayerIndex]
        counts[name] = counts.get(name, 0) + 1
    assert (counts["supports"], counts["blocks"], counts["falling blocks"]) == (1, 8, 2)
    assert counts["drystone::First motion"] == 4  # two blocks moved, two ways
    save_cad(standing, tmp_path / "arch.3dm")
    file = rhino3dm.File3dm.Read(str(tmp_path / "arch.3dm"))
    shown = {layer.FullPath: layer.Visible for layer in file.Layers}
    assert shown["drystone::force network (normal forces)"]
    assert not shown["drystone::pressure at a corner"]
    told = [
        float(item.Attributes.GetUserString("normal force [N]"))
        for item in file.Objects
        if item.Attributes.GetUserString("drystone-picture") == "joint-force"
    ]
    assert np.allclose(told, standing.resultants.normal, rtol=1e-5)


@pytest.mark.parametrize("shape", list(MarkerShape))
def test_marks_tubes_and_arrows_are_closed_and_have_the_volume_of_their_shape(shape):
    start = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    end = np.array([[0.0, 0.0, 2.0], [2.0, 2.0, 3.0]])
    base = 0.5 * drawn_parts.SIDES * np.sin(2.0 * np.pi / drawn_parts.SIDES)  # by radius squared
    radius = np.array([0.1, 0.2])
    length = np.linalg.norm(end - start, axis=1)
    assert volume(drawn_parts.tubes(start, end, radius)) == pytest.approx(
        (base * radius**2 * length).sum()
    )
    assert volume(drawn_parts.cones(start, end, radius)) == pytest.approx(
        (base * radius**2 * length).sum() / 3.0
    )
    found = volume(drawn_parts.marks(start, 0.5, shape))
    octahedron, ball = 2 * 4 / 3 * 0.125, 2 * 4 / 3 * np.pi * 0.125
    assert (
        found == pytest.approx(octahedron)
        if shape is MarkerShape.DIAMOND
        else 0.9 * ball < found < ball
    )


def volume(solid: drawn_parts.Triangles) -> float:
    points, corners = solid
    sides = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]))
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    a, b, c = (points[corners[:, i]] for i in range(3))
    return float((np.cross(a, b) * c).sum() / 6.0)


def test_a_quaternion_and_a_matrix_are_the_same_rotation():
    motion = np.array([0.3, -0.2, 0.1, 0.4, 1.1, -0.7])
    centroid = np.array([1.0, 2.0, 3.0])
    x, y, z, w = quaternions(motion[None, 3:])[0]
    v = np.array([0.2, 0.5, -0.1])
    around = np.array([x, y, z])
    turned = v + 2.0 * np.cross(around, np.cross(around, v) + w * v)
    matrix = matrix_of(motion, centroid)
    assert np.allclose(matrix[:3, :3] @ v, turned)
    assert np.allclose(matrix[:3, :3] @ centroid + matrix[:3, 3], centroid + motion[:3])
    assert np.allclose(quaternions(np.zeros((1, 3))), [[0.0, 0.0, 0.0, 1.0]])


def test_bad_input_is_told(standing, tmp_path):
    with pytest.raises(FormatError, match=r"\.obj"):
        save_cad(standing, tmp_path / "arch.obj")
    with pytest.raises(InputError, match="no stage 3"):
        save_cad(standing, tmp_path / "arch.glb", stage=3)
    with pytest.raises(InputError, match="no picture 'dream'"):
        save_cad(standing, tmp_path / "arch.glb", preset="dream")
    assert list(tmp_path.iterdir()) == []
