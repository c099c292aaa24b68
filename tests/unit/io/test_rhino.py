"""3dm files, made here with rhino3dm as Rhino would; skipped where that is not installed."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drystone import Assembly, FormatError, InputError, MissingDependency, check, io
from drystone.assembly import replace_block
from drystone.cli.told import left_out
from drystone.io import rhino
from drystone.io.registry import contents_of
from drystone.models import arch, box, concave, vault
from drystone.ties import tied, with_tie_words

try:
    import rhino3dm

    rhino3dm: Any
except ImportError:
    rhino3dm = None
needs_rhino = pytest.mark.skipif(rhino3dm is None, reason="rhino3dm is not installed")


def outline(*points: tuple[float, float]) -> Any:
    line = rhino3dm.Polyline(len(points) + 1)
    for x, y in (*points, points[0]):
        line.Add(x, y, 0.0)
    return line.ToPolylineCurve()


def cube(x: float = 0.0) -> Any:
    low, high = rhino3dm.Point3d(x, 0, 0), rhino3dm.Point3d(x + 1, 1, 1)
    return rhino3dm.Brep.CreateFromBox(rhino3dm.Box(rhino3dm.BoundingBox(low, high)))


def attributes(file: Any, name: str = "", layer: str = "", **text: str) -> Any:
    made = rhino3dm.ObjectAttributes()
    made.Name = name
    if layer:
        entry = rhino3dm.Layer()
        entry.Name = layer
        made.LayerIndex = file.Layers.Add(entry)
    for key, value in text.items():
        made.SetUserString(key, value)
    return made


def saved(tmp_path: Path, file: Any) -> Path:
    path = tmp_path / "model.3dm"
    assert file.Write(str(path), 7)
    return path


def new_file(units: str = "Meters") -> Any:
    file = rhino3dm.File3dm()
    file.Settings.ModelUnitSystem = getattr(rhino3dm.UnitSystem, units)
    return file


@needs_rhino
def test_planar_breps_and_extrusions_are_read_exactly(tmp_path: Path) -> None:
    file = new_file()
    file.Objects.AddBrep(cube(), attributes(file, "cube"))
    ell = rhino3dm.Extrusion.Create(
        outline((2, 0), (4, 0), (4, 1 / 3), (3, 1 / 3), (3, 2), (2, 2)), 3.0, True
    )
    file.Objects.AddExtrusion(ell, attributes(file, "ell"))
    model = io.read_file(saved(tmp_path, file))
    one, other = model.assembly.blocks
    assert model.assembly.names == ("cube", "ell")
    assert (len(one.faces), float(one.volume)) == (6, 1.0)
    assert sorted(map(len, other.faces)) == [4] * 6 + [6, 6]
    assert other.volume == pytest.approx(7.0, rel=1e-14)
    assert not one.repairs
    assert not other.repairs


@needs_rhino
def test_a_hole_through_a_brep_is_kept(tmp_path: Path) -> None:
    file = new_file()
    frame = rhino3dm.Extrusion.Create(outline((0, 0), (4, 0), (4, 4), (0, 4)), 3.0, True)
    assert frame.AddInnerProfile(outline((1, 1), (1, 2), (2, 2), (2, 1)))
    file.Objects.AddExtrusion(frame, attributes(file, "frame"))
    (block,) = io.read_file(saved(tmp_path, file)).assembly.blocks
    assert block.volume == pytest.approx(3.0 * 15.0)
    assert len(block.vertices) == 16


@needs_rhino
def test_meshes_layers_names_user_text_and_units_are_honoured(tmp_path: Path) -> None:
    file = new_file("Millimeters")
    text = {"support": "yes", "density": "2000", "friction": "0.7", "quarry": "north"}
    file.Objects.AddBrep(cube(), attributes(file, "left pier", "site::stones", **text))
    file.Objects.AddBrep(cube(5.0), attributes(file, "", "Supports"))
    file.Objects.AddBrep(cube(9.0), attributes(file, "", "", support="false"))
    model = io.read_file(saved(tmp_path, file))
    pier = model.assembly.blocks[0]
    assert pier.volume == pytest.approx(1e-9)
    assert pier.density == 2000.0
    assert dict(pier.metadata)["quarry"] == "north"
    assert dict(pier.metadata)["friction"] == 0.7
    assert model.assembly.names[:2] == ("left pier", "Supports-1")
    assert model.assembly.fixed.tolist() == [True, True, False]


@needs_rhino
def test_equal_names_are_numbered_and_that_is_told(tmp_path: Path) -> None:
    file = new_file()
    for i in range(3):
        file.Objects.AddBrep(cube(2.0 * i), attributes(file, "stone"))
    model = io.read_file(saved(tmp_path, file))
    assert model.assembly.names == ("stone-0", "stone-1", "stone-2")
    assert "3 blocks are called 'stone': numbered" in model.notes


@needs_rhino
def test_hidden_objects_and_other_things_are_left_out_and_that_is_told(tmp_path: Path) -> None:
    file = new_file()
    file.Objects.AddBrep(cube())
    hidden = attributes(file)
    hidden.Visible = False
    file.Objects.AddBrep(cube(2.0), hidden)
    file.Objects.AddPoint(1.0, 2.0, 3.0)
    model = io.read_file(saved(tmp_path, file))
    assert len(model.assembly) == 1
    assert any("1 hidden object left out" in note for note in model.notes)
    assert len(io.read_file(tmp_path / "model.3dm", hidden=True).assembly) == 2
    assert any("1 x Point left out" in note for note in model.notes)


@needs_rhino
def test_hidden_layers_are_told_and_read_on_request(tmp_path: Path) -> None:
    file = new_file()
    for i, name in enumerate(("voussoirs", "centring")):
        entry = attributes(file, name, name)
        file.Layers[entry.LayerIndex].Visible = False
        file.Objects.AddBrep(cube(2.0 * i), entry)
    path = saved(tmp_path, file)
    with pytest.raises(
        FormatError, match=r"no visible block; 2 objects hidden .*'voussoirs'.*--layer"
    ):
        io.read_file(path)
    assert io.read_file(path, layers=["voussoirs"]).assembly.names == ("voussoirs",)
    assert io.read_file(path, hidden=True).assembly.names == ("voussoirs", "centring")
    with pytest.raises(FormatError, match=r"no block on layer 'stone'; its layers are 'voussoirs'"):
        io.read_file(path, layers=["stone"])
    with pytest.raises(FormatError, match="Wavefront OBJ has no layers"):
        io.read_file(tmp_path / "model.obj", layers=["stone"])


DRUM = """
import math, os, rhino3dm, sys
circle = rhino3dm.Circle(rhino3dm.Point3d(0, 0, 0), 1.0)
drum = rhino3dm.Extrusion.CreateCylinderExtrusion(rhino3dm.Cylinder(circle, 2.0), True, True)
mesh, n = rhino3dm.Mesh(), 24
for z in (0.0, 2.0):
    for i in range(n):
        mesh.Vertices.Add(math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n), z)
    mesh.Vertices.Add(0.0, 0.0, z)
for i in range(n):
    j = (i + 1) % n
    mesh.Faces.AddFace(j, i, n)
    mesh.Faces.AddFace(i + n + 1, j + n + 1, 2 * n + 1)
    mesh.Faces.AddFace(i, j, j + n + 1, i + n + 1)
assert drum.SetMesh(mesh, rhino3dm.MeshType.Render)
file = rhino3dm.File3dm()
file.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Meters
file.Objects.AddExtrusion(drum, rhino3dm.ObjectAttributes())
assert file.Write(sys.argv[1], 7)
os._exit(0)
"""
"""In a process of its own: a mesh that was given to an extrusion is freed twice at the end."""


@needs_rhino
def test_a_curved_extrusion_is_read_through_the_mesh_that_it_carries(tmp_path: Path) -> None:
    path = tmp_path / "drum.3dm"
    subprocess.run([sys.executable, "-c", DRUM, str(path)], check=True)
    model = io.read_file(path)
    exact = 2.0 * 12.0 * np.sin(2.0 * np.pi / 24)
    assert model.assembly.blocks[0].volume == pytest.approx(exact, rel=1e-6)
    assert any("is curved: its render mesh" in note for note in model.notes)


@needs_rhino
def test_a_curved_brep_says_that_it_cannot_be_read(tmp_path: Path) -> None:
    file = new_file()
    circle = rhino3dm.Circle(rhino3dm.Point3d(0, 0, 0), 1.0)
    drum = rhino3dm.Brep.CreateFromCylinder(rhino3dm.Cylinder(circle, 2.0), True, True)
    file.Objects.AddBrep(drum, attributes(file, "drum"))
    path = saved(tmp_path, file)
    with pytest.raises(FormatError, match=r"object 0 block 'drum'.*face 0 is curved.*mesh it in"):
        io.read_file(path)


@needs_rhino
def test_good_objects_beside_one_that_cannot_be_read_are_read_on_request(tmp_path: Path) -> None:
    file = new_file()
    circle = rhino3dm.Circle(rhino3dm.Point3d(0, 0, 0), 1.0)
    drum = rhino3dm.Brep.CreateFromCylinder(rhino3dm.Cylinder(circle, 2.0), True, True)
    file.Objects.AddBrep(drum, attributes(file, "drum"))
    cube = rhino3dm.Brep.CreateFromBox(rhino3dm.Box(rhino3dm.BoundingBox(3, 0, 0, 4, 1, 1)))
    file.Objects.AddBrep(cube, attributes(file, "cube"))
    left = io.read_file(saved(tmp_path, file), skip_defects=True)
    assert left.assembly.names == ("cube",)
    assert "1 block with defects left out ('drystone inspect' lists them)" in left.notes


@needs_rhino
@needs_rhino
@pytest.mark.parametrize("pair", ['["a", "a"]', '["a"]', '["a", "b", "c"]'])
def test_a_tie_that_does_not_join_two_blocks_is_refused(tmp_path: Path, pair: str) -> None:
    file = new_file()
    file.Objects.AddBrep(cube(), attributes(file, "a"))
    rope = attributes(file, "tie", **{"drystone-tie": pair})
    file.Objects.AddLine(rhino3dm.Point3d(0, 0, 0), rhino3dm.Point3d(1, 0, 0), rope)
    with pytest.raises(FormatError, match="does not name two blocks"):
        io.read(saved(tmp_path, file))


@pytest.mark.parametrize(
    ("key", "value"), [("support", "maybe"), ("density", "heavy"), ("friction", "-1")]
)
def test_user_text_that_is_no_value_is_refused(tmp_path: Path, key: str, value: str) -> None:
    file = new_file()
    file.Objects.AddBrep(cube(), attributes(file, "cube", **{key: value}))
    with pytest.raises(FormatError, match=rf"'cube': user text '{key}' is '{value}'"):
        io.read_file(saved(tmp_path, file))


@needs_rhino
@pytest.mark.parametrize("assembly", [arch(), concave("short"), vault()])
def test_writing_and_reading_keeps_everything_to_the_last_bit(
    tmp_path: Path, assembly: Assembly
) -> None:
    blocks = tuple(
        replace_block(
            block.transformed(translation=(1 / 3, 1e4, 0.1)),
            density=2000.0 + i / 3,
            metadata={"layer": "Stein", "course": i, "note": "a\n壁"},
        )
        for i, block in enumerate(assembly.blocks)
    )
    assembly = Assembly(blocks, assembly.fixed)
    io.write(assembly, tmp_path / "model.3dm")
    again = io.read_file(tmp_path / "model.3dm")
    assert again.notes == ()
    assert again.assembly.names == assembly.names
    assert np.array_equal(again.assembly.fixed, assembly.fixed)
    for one, other in zip(assembly.blocks, again.assembly.blocks, strict=True):
        assert np.array_equal(one.vertices, other.vertices)
        assert (one.faces, one.density) == (other.faces, other.density)
        assert dict(one.metadata) == dict(other.metadata)


@needs_rhino
@pytest.mark.parametrize("data", [b"3D Geometry File Format ", b"garbage" * 100])
def test_what_is_no_3dm_file_is_refused(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "model.3dm"
    path.write_bytes(data)
    with pytest.raises(FormatError, match=r"model\.3dm: is no 3dm file"):
        io.read_file(path)


@needs_rhino
def test_a_reader_that_dies_is_no_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "rhino_extract.py"
    program.write_text("import os; os.abort()", encoding="utf-8")
    monkeypatch.setattr(rhino, "PROGRAM", program)
    path = saved(tmp_path, new_file())
    with pytest.raises(FormatError, match="is damaged"):
        io.read_file(path)


@needs_rhino
def test_a_reader_that_does_not_end_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "rhino_extract.py"
    program.write_text("import time; time.sleep(60)", encoding="utf-8")
    monkeypatch.setattr(rhino, "PROGRAM", program)
    monkeypatch.setattr(rhino, "WALL_S", 0.2)
    path = saved(tmp_path, new_file())
    with pytest.raises(FormatError, match=r"was not read within 0\.2 s"):
        io.read_file(path)


@needs_rhino
def test_small_files_are_answered_within_five_seconds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[float] = []

    def run(arguments: list[str], timeout: float, **_: object) -> None:
        told.append(timeout)
        raise subprocess.TimeoutExpired(arguments, timeout)

    monkeypatch.setattr(subprocess, "run", run)
    with pytest.raises(FormatError, match="the machine is very busy"):
        io.read_file(saved(tmp_path, new_file()))
    assert told == [4.0]


def test_without_rhino3dm_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    path = tmp_path / "model.3dm"
    path.write_bytes(b"x")
    with pytest.raises(MissingDependency, match=r"\.\[cad\]"):
        io.read_file(path)
    with pytest.raises(MissingDependency, match=r"\.\[cad\]"):
        io.write(Assembly((box((1, 1, 1)),)), path)


@needs_rhino
@pytest.mark.parametrize("name", ["a\tb", "a\nb", "a\0b"])
def test_names_that_would_be_lost_are_refused(tmp_path: Path, name: str) -> None:
    model = Assembly((replace_block(box((1.0, 1.0, 1.0)), name=name),))
    with pytest.raises(FormatError, match="control character"):
        io.write(model, tmp_path / "model.3dm")


@needs_rhino
def test_ties_and_units_are_kept_in_a_file(tmp_path: Path) -> None:
    floor, out = box((1.0, 1.0, 1.0), name="floor"), box((0.5, 0.5, 0.5), (0.0, 0.0, 1.0), "out")
    wall = box((0.5, 0.5, 0.5), (-2.0, 0.0, 1.0), "wall")
    pushed = {"friction": 0.2, "gravity": (5.0, 0.0, -9.81)}
    model = io.as_model(Assembly((floor, out, wall)).with_fixed([0, 2]), **pushed)
    held = tied(model, 1, 2)
    assert check(held).stable
    assert check(model).falls
    io.write(held, tmp_path / "held.3dm", units="mm")
    again = io.read(tmp_path / "held.3dm", **pushed)
    assert again.origin.units == "mm"
    assert again.assembly.volume == pytest.approx(model.assembly.volume)
    assert again.contacts.centroid[-1] == pytest.approx(held.contacts.centroid[-1])
    assert check(again).stable
    for other in ("out:wall:5kN", "out@0.25,0.25,1.4:wall"):  # the file could not tell this one
        rod = with_tie_words(model, [other])
        io.write(rod, tmp_path / "rod.3dm")
        assert not io.read(tmp_path / "rod.3dm", **pushed).contacts.ties.any()
        assert "write .json" in " ".join(left_out(io.format_of("a.3dm"), "m", contents_of(rod)))
    assert "write .json" not in " ".join(left_out(io.format_of("a.3dm"), "m", contents_of(held)))
    lone = io.read(tmp_path / "held.3dm", without="wall", **pushed)
    assert len(lone.assembly) == 2
    assert check(lone).falls
    with pytest.raises(InputError, match="unit 'league' is not known"):
        io.write(held, tmp_path / "held.obj", units="league")
