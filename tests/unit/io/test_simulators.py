"""Models for simulators: well-formed files that hold the blocks as they are."""

import xml.etree.ElementTree as ET
from itertools import combinations

import manifold3d
import numpy as np
import pytest

from benchmarks.leaning import reciprocal_frame
from drystone import Assembly, Block, InputError, LoadCase, Model, io
from drystone.io.mjcf import mjcf_text, write_mjcf
from drystone.io.simulator_bodies import bodies
from drystone.io.urdf import write_urdf
from drystone.models import box, bridge, dome, stool, tower

MODEL = Model.of(bridge(), friction=0.6)


def test_mass_and_inertia_of_a_box_are_those_of_the_formula():
    model = Model.of(tower(2, edge=2.0).with_density(100.0))
    one = bodies(model)[0][1]
    assert one.mass == pytest.approx(800.0)
    np.testing.assert_allclose(one.inertia, 800.0 * 8.0 / 12.0 * np.eye(3), rtol=1e-9)


def test_the_inertia_of_a_concave_block_is_that_of_the_boxes_it_is_made_of():
    block = stool(side=0.4, leg=0.08, seat=0.06, height=0.45).blocks[1]
    parts = [box((0.4, 0.4, 0.06), (0.0, 0.0, 0.39))]
    parts += [box((0.08, 0.08, 0.39), (x, y, 0.0)) for x in (0.0, 0.32) for y in (0.0, 0.32)]
    expected = np.zeros((3, 3))
    for part in parts:
        sides = (part.bounds[1] - part.bounds[0]) ** 2
        away = part.centroid - block.centroid
        expected += part.mass * np.diag((sides.sum() - sides) / 12.0)
        expected += part.mass * (away @ away * np.eye(3) - np.outer(away, away))
    found = bodies(Model.of(stool()))[0][1]
    np.testing.assert_allclose(found.inertia, expected, atol=1e-4 * expected.max())


@pytest.mark.parametrize("contact_s", [0.0, -1.0, float("nan")])
def test_a_time_constant_that_is_not_above_zero_is_refused(contact_s):
    with pytest.raises(InputError, match="contact_s is"):
        mjcf_text(MODEL, contact_s=contact_s)


def test_mjcf_has_a_body_per_block_and_frees_only_free_ones():
    root = ET.fromstring(mjcf_text(MODEL))
    found = root.findall("./worldbody/body")
    assert [body.get("name") for body in found] == list(MODEL.assembly.names)
    free = [body.find("freejoint") is not None for body in found]
    assert free == (~MODEL.assembly.fixed).tolist()
    meshes = {mesh.get("name") for mesh in root.findall("./asset/mesh")}
    used = {geom.get("mesh") for geom in root.iter("geom")} - {None}
    assert used == meshes


def test_mjcf_has_the_gravity_and_the_smallest_friction_of_the_model():
    tilted = MODEL.with_load(LoadCase.gravity(MODEL.assembly, 5.0, direction=(1.0, 0.0, 0.0)))
    root = ET.fromstring(mjcf_text(tilted))
    np.testing.assert_allclose(
        np.fromstring(root.find("option").get("gravity"), sep=" "), [5, 0, 0]
    )
    assert root.find("default/geom").get("friction").split()[0] == "0.6"


def test_a_load_that_is_no_gravity_is_refused():
    wrench = np.array(MODEL.load.wrench)
    wrench[4, 0] += 100.0
    with pytest.raises(InputError, match="is not a uniform acceleration"):
        mjcf_text(MODEL.with_load(LoadCase(wrench, "push")))


def test_mjcf_is_written_whole(tmp_path):
    write_mjcf(MODEL, tmp_path / "bridge.xml")
    assert ET.parse(tmp_path / "bridge.xml").getroot().tag == "mujoco"
    assert [p.name for p in tmp_path.iterdir()] == ["bridge.xml"]


def test_urdf_has_a_link_per_block_and_its_meshes_beside_it(tmp_path):
    files = write_urdf(MODEL, tmp_path / "bridge.urdf")
    root = ET.parse(tmp_path / "bridge.urdf").getroot()
    links = [link.get("name") for link in root.findall("link")]
    assert links == ["world", *MODEL.assembly.names]
    kinds = [joint.get("type") for joint in root.findall("joint")]
    assert kinds == ["fixed" if fixed else "floating" for fixed in MODEL.assembly.fixed]
    meshes = {mesh.get("filename") for mesh in root.iter("mesh")}
    assert all((tmp_path / mesh).exists() for mesh in meshes)
    assert len(files) == len(meshes) + 1


def test_a_block_may_have_the_name_of_the_ground(tmp_path):
    below, above = box((1.0, 1.0, 1.0), name="world"), box((1.0, 1.0, 1.0), (0, 0, 1.0), "top")
    model = Model.of(Assembly((below, above), [True, False]), friction=0.6)
    names = [body.name for body in bodies(model)[0]]
    assert len({"world", *names}) == 3


def test_no_folder_is_made_beside_a_file_that_cannot_be_written(tmp_path):
    with pytest.raises(InputError, match="there is no folder"):
        write_urdf(MODEL, tmp_path / "none" / "bridge.urdf")
    assert not list(tmp_path.iterdir())


def test_a_model_without_contacts_is_written_by_its_suffix(tmp_path):
    io.write(bridge(), tmp_path / "bridge.xml")
    assert len(ET.parse(tmp_path / "bridge.xml").findall("./worldbody/body")) == len(bridge())


def warped_wall():
    """Three blocks on a floor, whose beds and head joints are warped by some centimetres."""
    lift = np.array([0.0, 0.06, -0.02, 0.05])
    corner = np.array([[0.0, 0.0], [1.0, 0.1], [1.0, 0.9], [0.0, 1.0]])
    blocks = []
    for level in range(4):
        low = np.c_[corner, level + (lift if level else 0.0 * lift)]
        high = np.c_[corner, 1.0 + level + lift]
        faces = [(3, 2, 1, 0), (4, 5, 6, 7), *((i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4)
                 for i in range(4))]  # fmt: skip
        blocks.append(Block(np.concatenate([low, high]), faces, f"block-{level}"))
    return Assembly(tuple(blocks), [True, False, False, False])


def common_depth(model):
    """Largest volume by surface that pieces of two bodies share [m]."""
    found = bodies(model)[0]
    solids = [
        (i, manifold3d.Manifold.hull_points(point + body.place))
        for i, body in enumerate(found)
        for point, _ in body.pieces
    ]
    shared = [a ^ b for (i, a), (j, b) in combinations(solids, 2) if i != j]
    return max((one.volume() / one.surface_area() for one in shared if one.volume()), default=0.0)


@pytest.mark.parametrize("model", [Model.of(warped_wall()), MODEL], ids=["warped", "concave"])
def test_pieces_for_simulators_touch_and_do_not_overlap(model):
    assert common_depth(model) < 1e-6
    assert "<!--" not in mjcf_text(model)
    for body, block in zip(bodies(model)[0], model.assembly.blocks, strict=True):
        volume = sum(manifold3d.Manifold.hull_points(point).volume() for point, _ in body.pieces)
        assert volume == pytest.approx(block.volume, rel=0.01)


def test_legs_that_sink_into_the_floor_begin_on_it_in_a_simulator_and_it_is_said(tmp_path):
    floor, table = stool().blocks
    model = Model.of(Assembly((floor, table.transformed(None, (0, 0, -0.003))), [True, False]))
    assert common_depth(model) < 1e-6
    write_mjcf(model, tmp_path / "sunk.xml")
    write_urdf(model, tmp_path / "sunk.urdf")
    for name in ("sunk.xml", "sunk.urdf"):
        assert "up to 3 mm inside each other are cut back" in (tmp_path / name).read_text("utf-8")


def test_beams_that_cross_with_two_edges_are_not_cut_back():
    frame = reciprocal_frame(3, 0.1)
    found, said = bodies(Model.of(frame, friction=0.6))
    assert said == ""
    for body, block in zip(found, frame.blocks, strict=True):
        ((corner, _),) = body.pieces
        away = np.linalg.norm(corner[:, None] + body.place - block.vertices, axis=2)
        assert away.min(axis=1).max() < 1e-9


def test_blocks_that_begin_apart_in_a_simulator_are_told():
    low, high = tower(2).blocks
    model = Model.of(Assembly((low, high.transformed(None, (0, 0, 0.004))), [True, False]))
    assert "blocks with a joint begin up to 4 mm apart" in mjcf_text(model)
    assert "apart" not in mjcf_text(Model.of(tower(2)))


def test_no_contact_in_mujoco_begins_deeper_than_a_tenth_of_a_millimetre():
    mujoco = pytest.importorskip("mujoco")
    for family in (warped_wall, bridge, stool, dome):
        simulator = mujoco.MjModel.from_xml_string(mjcf_text(Model.of(family(), friction=0.6)))
        data = mujoco.MjData(simulator)
        mujoco.mj_forward(simulator, data)
        assert data.ncon > 0
        assert data.contact.dist.min() > -1e-4


def test_a_tower_stays_and_a_leaning_block_falls_in_mujoco():
    mujoco = pytest.importorskip("mujoco")

    def moved(model):
        simulator = mujoco.MjModel.from_xml_string(mjcf_text(model))
        data = mujoco.MjData(simulator)
        mujoco.mj_forward(simulator, data)
        start = np.array(data.xpos)
        for _ in range(500):
            mujoco.mj_step(simulator, data)
        return float(np.linalg.norm(data.xpos - start, axis=1).max())

    model = Model.of(tower(3), friction=0.6)
    assert moved(model) < 1e-3
    leaning = LoadCase.gravity(model.assembly, 9.81, direction=(0.9, 0.0, -1.0))
    assert moved(model.with_load(leaning)) > 0.1
