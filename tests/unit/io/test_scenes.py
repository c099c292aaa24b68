"""Scenes of simulators: their bodies are blocks, what is joined to the world is fixed."""

from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import FormatError, Model, io
from drystone.models import arch, bridge, burr, hooked_bar, stool

STACK = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1"/>
    <body name="low" pos="0 0 .1"><freejoint/><geom type="box" size=".2 .1 .1"/></body>
    <body name="high" pos="{off} 0 .3"><freejoint/><geom type="box" size=".2 .1 .1"/></body>
  </worldbody>
</mujoco>
"""
ROBOT = """
<robot name="two">
  <link name="world"/>
  <link name="base"><collision><geometry><box size="1 1 0.2"/></geometry></collision></link>
  <link name="top">
    <inertial><mass value="50"/></inertial>
    <collision><geometry><cylinder radius="0.2" length="0.5"/></geometry></collision>
  </link>
  <link name="cap">
    <collision>
      <origin xyz="0 0 0.05"/><geometry><box size="0.6 0.6 0.1"/></geometry>
    </collision>
  </link>
  <joint name="a" type="fixed"><parent link="world"/><child link="base"/></joint>
  <joint name="b" type="floating">
    <parent link="world"/><child link="top"/><origin xyz="0 0 0.35"/>
  </joint>
  <joint name="c" type="fixed"><parent link="top"/><child link="cap"/>
    <origin xyz="0 0 0.25"/></joint>
</robot>
"""


def written(folder: Path, text: str, name: str = "scene.xml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def pairs(model: Model) -> set[tuple[int, int]]:
    """Blocks that touch."""
    return {*zip(model.contacts.block_a.tolist(), model.contacts.block_b.tolist(), strict=True)}


def mjcf(folder: Path, world: str, before: str = "") -> Model:
    text = f"<mujoco>{before}<worldbody>{world}</worldbody></mujoco>"
    return drystone.read(written(folder, text), supports=None)


@pytest.mark.parametrize(("off", "stands"), [(0.0, True), (0.19, True), (0.21, False)])
def test_a_stack_of_mujoco_stands_up_to_its_edge(tmp_path, off, stands):
    model = drystone.read(written(tmp_path, STACK.format(off=off)))
    assert model.assembly.names == ("low", "high", "floor")
    assert model.assembly.fixed.tolist() == [False, False, True]
    assert model.contacts.friction.tolist() == [1.0, 1.0]
    assert drystone.check(model).stable == stands


@pytest.mark.parametrize("suffix", [".xml", ".mjcf", ".urdf"])
@pytest.mark.parametrize("family", [arch, bridge, burr, hooked_bar, stool])
def test_what_is_written_for_simulators_is_read_back(tmp_path, family, suffix):
    model = Model.of(family(), friction=0.55)
    io.write(model, tmp_path / f"model{suffix}")
    back = drystone.read(tmp_path / f"model{suffix}", friction=0.55)
    assert back.assembly.names == model.assembly.names
    assert back.assembly.fixed.tolist() == model.assembly.fixed.tolist()
    np.testing.assert_allclose(back.assembly.mass, model.assembly.mass, rtol=1e-9)
    np.testing.assert_allclose(back.assembly.centroid, model.assembly.centroid, atol=1e-4)
    assert pairs(back) == pairs(model)
    assert not any("separate parts" in note for note in back.notes)


@pytest.mark.parametrize(
    "turn",
    [
        'quat="0.9659258 0 0.258819 0"',
        'axisangle="0 2 0 30"',
        'euler="0 30 0"',
        'xyaxes="0.8660254 0 -0.5 0 1 0"',
        'zaxis="0.5 0 0.8660254"',
    ],
)
def test_every_way_to_write_a_turn_gives_the_same_block(tmp_path, turn):
    model = mjcf(tmp_path, f'<body pos="0 0 1" {turn}><geom type="box" size="1 .5 .25"/></body>')
    top = model.assembly.blocks[0].vertices.max(axis=0)
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    np.testing.assert_allclose(top, [c + 0.25 * s, 0.5, 1.0 + s + 0.25 * c], atol=1e-6)


def test_classes_and_frames_of_mjcf_are_followed(tmp_path):
    before = """<compiler angle="radian"/><default><geom type="box" density="500"/>
      <default class="brick"><geom size=".1 .1 .1" friction=".3"/></default></default>"""
    world = """<frame pos="0 0 1"><body name="a" pos="0 0 1" childclass="brick"><freejoint/>
      <geom/></body></frame><body name="b"><geom class="brick" euler="0 0 1.5707963"/></body>"""
    model = mjcf(tmp_path, world, before)
    a, b = model.assembly.blocks
    np.testing.assert_allclose(a.centroid, [0.0, 0.0, 2.0], atol=1e-9)
    assert a.mass == pytest.approx(500.0 * 0.008)
    assert a.metadata["friction"] == 0.3
    assert model.assembly.fixed.tolist() == [False, True]
    assert b.volume == pytest.approx(0.008)


def test_bodies_joined_to_a_free_one_are_parts_of_it(tmp_path):
    legs = "".join(
        f'<body pos="{x} {y} -.25"><geom type="box" size=".05 .05 .2" mass="1"/></body>'
        for x in (-0.4, 0.4)
        for y in (-0.4, 0.4)
    )
    plate = '<freejoint/><geom type="box" size=".5 .5 .05" mass="6"/>'
    top = f'<body name="table" pos="0 0 .45">{plate}{legs}</body>'
    model = mjcf(tmp_path, f'<geom type="plane" size="1 1 1"/>{top}')
    assert model.assembly.names == ("table", "ground")
    table = model.assembly.blocks[0]
    assert table.mass == pytest.approx(10.0)
    assert table.volume == pytest.approx(0.1 + 4 * 0.004, rel=1e-3)
    assert model.contacts.count == 4
    assert drystone.check(model).stable


def test_a_weld_to_the_world_fixes_a_body(tmp_path):
    text = STACK.format(off=0.0).replace(
        "</mujoco>", '<equality><weld body1="low"/></equality></mujoco>'
    )
    assert drystone.read(written(tmp_path, text)).assembly.fixed.tolist() == [True, False, True]


def test_gravity_of_mjcf_is_the_load(tmp_path):
    text = STACK.format(off=0.0).replace("<worldbody>", '<option gravity="3 0 -4"/><worldbody>')
    model = drystone.read(written(tmp_path, text))
    np.testing.assert_allclose(model.load.wrench[0, :3] / model.assembly.mass[0], [3.0, 0.0, -4.0])


def test_a_tilted_plane_is_a_slope(tmp_path):
    text = """<mujoco><worldbody><geom type="plane" size="1 1 1" euler="0 {turn} 0"/>
      <body euler="0 {turn} 0"><freejoint/><geom type="box" size=".1 .1 .1" pos="0 0 .1"
      friction=".5"/></body></worldbody></mujoco>"""
    for turn, stands in ((26, True), (27, False)):
        model = drystone.read(written(tmp_path, text.format(turn=turn)))
        assert drystone.check(model).stable == stands


def test_meshes_beside_a_scene_are_read_with_their_scale(tmp_path):
    (tmp_path / "parts").mkdir()
    io.write(stool(), tmp_path / "parts" / "stool.obj")
    before = """<compiler meshdir="parts"/>
      <asset><mesh name="s" file="stool.obj" scale=".001 .001 .001"/></asset>"""
    model = mjcf(tmp_path, '<body name="s"><geom type="mesh" mesh="s"/></body>', before)
    assert model.assembly.volume.sum() == pytest.approx(1e-9 * stool().volume.sum(), rel=1e-2)


def test_links_of_urdf_are_blocks(tmp_path):
    model = drystone.read(written(tmp_path, ROBOT, "two.urdf"))
    assert model.assembly.names == ("base", "top")
    assert model.assembly.fixed.tolist() == [True, False]
    assert model.assembly.mass[1] == pytest.approx(50.0)
    assert model.assembly.blocks[1].bounds[1].tolist() == pytest.approx([0.3, 0.3, 0.7], abs=1e-4)
    assert drystone.check(model).stable


def test_meshes_of_a_ros_package_are_found_from_above(tmp_path):
    for name in ("urdf", "meshes"):
        (tmp_path / "pkg" / name).mkdir(parents=True)
    io.write(stool(), tmp_path / "pkg" / "meshes" / "stool.stl")
    for name in ("package://pkg/meshes/stool.stl", "../meshes/stool.stl"):
        text = f"""<robot><link name="a"><visual><geometry><mesh filename="{name}"/></geometry>
          </visual></link></robot>"""
        path = written(tmp_path / "pkg" / "urdf", text, "a.urdf")
        assert len(io.read_file(path).assembly) == 1


BODY = '<body name="a">{}<geom type="box" size="1 1 1"/></body>'
WRONG = {
    "not XML": ("<mujoco><worldbody>", "is no XML"),
    "entities": ('<!DOCTYPE a [<!ENTITY b "c">]><mujoco/>', "defines entities"),
    "another root": ("<sdf/>", "no MJCF: its root is 'sdf'"),
    "no body": ("<mujoco/>", "holds no block"),
    "a hinge": (BODY.format("<joint/>"), "moves on a joint of type hinge"),
    "a ball": ('<body><geom size="1"/></body>', "type sphere, which rolls"),
    "a height field": ('<geom type="hfield"/>', "type hfield"),
    "no such class": ('<body><geom class="x"/></body>', "no class 'x'"),
    "no such mesh": ('<body><geom type="mesh" mesh="x"/></body>', "no mesh 'x'"),
    "included": ('<include file="x.xml"/>', "has 'include'; save the scene by mujoco"),
    "a word for a number": ('<body pos="0 0 x"/>', "'pos' is '0 0 x'; write 3 numbers"),
    "not finite": ('<body pos="0 0 nan"/>', "'pos' is '0 0 nan'"),
    "two numbers for three": ('<body pos="0 0"/>', "'pos' is '0 0'"),
    "no size": ('<body><geom type="box"/></body>', "has no 'size'"),
    "size zero": ('<body><geom type="box" size="1 1 0"/></body>', "its size is '1 1 0'"),
    "no turn": ('<body quat="0 0 0 0"/>', "its quaternion is zero"),
    "a plane that moves": (
        '<body><freejoint/><geom type="plane" size="1 1 1"/></body>',
        "a plane cannot move",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_mjcf_cannot_say_is_refused_in_one_line(tmp_path, case):
    text, said = WRONG[case]
    if not text.startswith(("<mujoco", "<!", "<sdf")):
        text = f"<mujoco><worldbody>{text}</worldbody></mujoco>"
    with pytest.raises(FormatError) as caught:
        io.read_file(written(tmp_path, text))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "scene.xml" in str(caught.value)


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("../../other.obj", "outside of the folder"),
        ("/etc/passwd", "outside of the folder"),
        ("none.obj", "mesh 'm': there is no file 'none.obj'"),
        ("scene.xml", "in no format that is read here"),
        ("", "has no 'vertex'"),
    ],
)
def test_meshes_that_are_not_there_or_elsewhere_are_refused(tmp_path, file, said):
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    asset = f'<asset><mesh name="m" file="{file}"/></asset>'
    text = f'<mujoco>{asset}<worldbody><geom type="mesh" mesh="m"/></worldbody></mujoco>'
    with pytest.raises(FormatError, match=said):
        io.read_file(written(folder, text))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('<link name="world"/>', '<xacro:include filename="a"/>', "is xacro.*expand it"),
        ('type="floating"', 'type="revolute"', "joint 'b': is of type 'revolute'"),
        ('<child link="top"/>', '<child link="base"/>', "joins 'base' to 'world'"),
        ('<parent link="world"/><child link="base"/>', "", "joins '' to ''"),
        ("<cylinder", "<sphere", "'sphere', which rolls"),
        ('radius="0.2"', 'radius="0"', "'radius' is not above zero"),
        ('<box size="1 1 0.2"/>', "", "a shape has no geometry"),
        ('<parent link="world"/><child link="top"/>', '<parent link="cap"/><child link="top"/>',
         "hangs on itself"),
    ],
)  # fmt: skip
def test_what_urdf_cannot_say_is_refused_in_one_line(tmp_path, old, new, said):
    assert old in ROBOT
    with pytest.raises(FormatError, match=said) as caught:
        io.read_file(written(tmp_path, ROBOT.replace(old, new), "two.urdf"))
    assert "\n" not in str(caught.value)


def test_a_link_whose_mesh_is_missing_is_named(tmp_path):
    shape = '<collision><geometry><mesh filename="none.stl"/></geometry></collision>'
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r"><link name="arm">{shape}</link></robot>', encoding="utf-8")
    with pytest.raises(FormatError, match=r"link 'arm': there is no file 'none\.stl'"):
        io.read_file(path)
    (tmp_path / "none.stl").write_text("nothing", encoding="utf-8")
    with pytest.raises(FormatError, match=r"link 'arm', .*none\.stl"):
        io.read_file(path)


def test_a_scene_is_read_as_mujoco_reads_it(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    text = """<mujoco><compiler eulerseq="zXy"/><worldbody>
      <frame pos="1 2 3" euler="10 20 30"><body name="a" pos=".1 .2 .3" zaxis="1 2 3"><freejoint/>
        <body pos="1 0 0" axisangle="1 1 0 40"><geom type="box" size=".1 .2 .3" quat="1 2 3 4"/>
      </body></body></frame>
      <body name="b" xyaxes="1 2 0 -1 1 1"><geom type="box" size=".1 .2" fromto="0 0 0 1 2 3"/>
      </body></worldbody></mujoco>"""
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    mujoco.mj_forward(theirs, data)
    ours = io.read_file(written(tmp_path, text)).assembly
    unit = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    for number, block in enumerate(ours.blocks):
        turn = data.geom_xmat[number].reshape(3, 3)
        corner = data.geom_xpos[number] + (unit * theirs.geom_size[number]) @ turn.T
        found = block.vertices[np.lexsort(np.round(block.vertices, 6).T)]
        np.testing.assert_allclose(found, corner[np.lexsort(np.round(corner, 6).T)], atol=1e-6)
