"""Stages of USD: rigid bodies are blocks, what has none is fixed."""

import io as streams
import zipfile

import numpy as np
import pytest

import drystone
from drystone import FormatError, io

HEAD = '#usda 1.0\n(\n    metersPerUnit = {unit}\n    upAxis = "{up}"\n)\n'
MOVED = """    double3 xformOp:translate = {place}
    uniform token[] xformOpOrder = ["xformOp:translate"]
"""
TWO = """
def Cube "base"
{
    double size = 1
}
def Xform "top" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{
    float physics:mass = 12
    MOVED
    def Mesh "shape"
    {
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
        int[] faceVertexIndices = [0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    }
}
"""  # noqa: E501


def written(folder, text, place="(-0.5, -0.5, 0.5)", unit=1, up="Z", name="stage.usda"):
    text = HEAD.format(unit=unit, up=up) + text.replace("MOVED", MOVED.format(place=place))
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(autouse=True)
def _usd():
    pytest.importorskip("pxr")


@pytest.mark.parametrize(("x", "stands"), [(-0.5, True), (-0.05, True), (0.05, False)])
def test_a_stage_of_two_cubes_stands_up_to_its_edge(tmp_path, x, stands):
    model = drystone.read(written(tmp_path, TWO, f"({x}, -0.5, 0.5)"), friction=0.6)
    assert model.assembly.names == ("base", "top")
    assert model.assembly.fixed.tolist() == [True, False]
    assert model.assembly.mass[1] == pytest.approx(12.0)
    assert drystone.check(model).stable == stands


def test_unit_and_axis_of_the_stage_are_followed(tmp_path):
    path = written(tmp_path, TWO, "(-0.5, 0.5, -0.5)", unit=0.01, up="Y")
    model = drystone.read(path, friction=0.6)
    np.testing.assert_allclose(model.assembly.centroid[1], [0.0, 0.0, 0.01], atol=1e-9)
    assert model.contacts.count == 1


def test_only_shapes_that_collide_are_read_where_some_do(tmp_path):
    text = TWO.replace(
        'def Mesh "shape"', 'def Mesh "shape" (apiSchemas = ["PhysicsCollisionAPI"])'
    )
    assert drystone.read(written(tmp_path, text), supports="ground").assembly.names[0] == "top"


def test_a_stage_without_bodies_fixes_nothing(tmp_path):
    text = TWO.replace('"PhysicsRigidBodyAPI", ', "")
    found = io.read_file(written(tmp_path, text))
    assert not found.assembly.fixed.any()
    assert "it has no rigid bodies: nothing is fixed but planes" in found.notes


def test_a_plane_is_the_ground(tmp_path):
    text = TWO.replace('def Cube "base"', 'def Plane "floor"')
    model = drystone.read(written(tmp_path, text, "(0, 0, 0)"), friction=0.6)
    assert model.assembly.names == ("top", "floor")
    assert drystone.check(model).stable


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("def Cube", "def Sphere", "is a Sphere, which rolls"),
        ("3, 2, 1, 4", "3, 2, 99, 4", "a vertex that does not exist"),
        ('def Cube "base"', 'def PhysicsRevoluteJoint "j" {}\ndef Cube "base"', "a joint of type"),
        ("def Xform", "not USD", r"line \d+: .*is no USD text; mend this line"),
        (
            "int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]",
            'string faceVertexCounts = "x"',
            "is no USD",
        ),
        ('def Cube "base"', 'def Cube "base" (references = @other.usda@)', "refers to other"),
    ],
)
def test_what_a_stage_cannot_say_is_refused_in_one_line(tmp_path, old, new, said):
    assert old in TWO
    with pytest.raises(FormatError, match=said) as caught:
        io.read_file(written(tmp_path, TWO.replace(old, new)))
    assert "\n" not in str(caught.value)


def test_a_plane_beyond_every_number_is_refused_in_words(tmp_path):
    floor = 'def Plane "floor"\n{\n    uniform token axis = "Z"\n    MOVED\n}\n'
    stretched = floor.replace(
        "MOVED",
        """double3 xformOp:scale = (1e200, 1, 1)
    uniform token[] xformOpOrder = ["xformOp:scale"]""",
    )
    with pytest.raises(FormatError, match="a plane has no size, or is too far away"):
        io.read_file(written(tmp_path, TWO + stretched))


def test_a_plane_in_a_tiny_unit_is_still_the_ground(tmp_path):
    floor = 'def Plane "floor"\n{\n    uniform token axis = "Z"\n}\n'
    found = io.read_file(written(tmp_path, floor, unit=1e-200))
    assert found.assembly.names == ("floor",)
    assert found.assembly.fixed.all()


def test_archives_are_read_and_packed_ones_refused(tmp_path):
    stage = written(tmp_path, TWO).read_bytes()
    usdz = tmp_path / "stage.usdz"
    from pxr import UsdUtils

    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "stage.usda"), str(usdz))
    assert len(io.read_file(usdz).assembly) == 2
    buffer = streams.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("stage.usda", stage + b"\n" * 10_000_000)
    usdz.write_bytes(buffer.getvalue())
    with pytest.raises(FormatError, match="its files are packed"):
        io.read_file(usdz)
    usdz.write_bytes(b"PK nothing")
    with pytest.raises(FormatError, match="is no USDZ archive"):
        io.read_file(usdz)
