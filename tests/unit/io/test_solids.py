"""STEP and IFC: solids with names, parts of a wall, units; read by libraries that are extras."""

from pathlib import Path

import numpy as np
import pytest

import drystone
from benchmarks.solid_files import ifc_file, step_file, wall_of_layers
from drystone import FormatError, MissingDependency, Verdict, check, io
from drystone.io import ifc, step
from drystone.models import box, tower

LOW, HIGH = tower(2).blocks[:2]


def read(folder: Path, content: str, suffix: str) -> io.Contents:
    path = folder / f"model{suffix}"
    path.write_text(content, encoding="ascii")
    return io.read_file(path)


@pytest.mark.parametrize(("unit", "scale"), [("$", 1.0), (".MILLI.", 1e-3)])
def test_each_solid_of_a_step_file_is_a_block(tmp_path: Path, unit: str, scale: float) -> None:
    pytest.importorskip("cascadio")
    found = read(tmp_path, step_file([LOW, HIGH], unit), ".step").assembly
    assert found.names == (LOW.name, HIGH.name)
    for made, given in zip(found.blocks, (LOW, HIGH), strict=True):
        assert len(made.faces) == 6
        assert made.centroid == pytest.approx(scale * given.centroid, abs=1e-6)
        assert made.volume == pytest.approx(scale**3 * given.volume, rel=1e-5)
    model = drystone.read(tmp_path / "model.step", supports="lowest")
    assert check(model).verdict is Verdict.STABLE


@pytest.mark.parametrize("content", ["solid cube", step_file([LOW])[:2000], step_file([])])
def test_what_is_no_step_file_is_refused_in_one_line(tmp_path: Path, content: str) -> None:
    pytest.importorskip("cascadio")
    with pytest.raises(FormatError, match=r"is no STEP|is damaged|holds no solid") as caught:
        read(tmp_path, content, ".stp")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("unit", "scale"), [("$", 1.0), (".MILLI.", 1e-3)])
def test_elements_that_bear_are_blocks_and_a_wall_of_stones_its_stones(
    tmp_path: Path, unit: str, scale: float
) -> None:
    pytest.importorskip("ifcopenshell")
    cap = box((1.0, 1.0, 1.0), (0.0, 0.0, 2.0), "cap")
    elements = [
        ("IfcFooting", "foot", box((1.0, 1.0, 1.0), (0.0, 0.0, -1.0)), ""),
        ("IfcBuildingElementPart", "stone", box((1.0, 1.0, 1.0)), "wall"),
        ("IfcBuildingElementPart", "stone", box((1.0, 1.0, 1.0), (0.0, 0.0, 1.0)), "wall"),
        ("IfcBuildingElementProxy", "cap", cap, ""),
        ("IfcDoor", "door", box((1.0, 1.0, 1.0), (5.0, 0.0, 0.0)), ""),
    ]
    found = read(tmp_path, ifc_file(elements, unit), ".ifc")
    assert sorted(found.assembly.names) == ["cap", "foot", "stone-0", "stone-1"]
    fixed = dict(zip(found.assembly.names, found.assembly.fixed.tolist(), strict=True))
    assert fixed == {"cap": False, "foot": True, "stone-0": False, "stone-1": False}
    assert "1 x IfcDoor left out" in found.notes
    at = found.assembly.names.index("cap")
    assert found.assembly.blocks[at].centroid == pytest.approx(scale * cap.centroid)
    assert check(drystone.read(tmp_path / "model.ifc")).verdict is Verdict.STABLE


@pytest.mark.parametrize(
    ("sense", "offset"), [("POSITIVE", 0.0), ("NEGATIVE", 0.0), ("POSITIVE", -0.25)]
)
def test_layers_of_stone_of_a_wall_are_its_stones(
    tmp_path: Path, sense: str, offset: float
) -> None:
    pytest.importorskip("ifcopenshell")
    layers = [("granite", "stone", 0.1), ("rubble", "stone", 0.3), ("brickwork", "", 0.1)]
    found = read(tmp_path, wall_of_layers(layers, sense, offset)[0].to_string(), ".ifc")
    assert found.assembly.names == ("wall-0", "wall-1", "wall-2")
    assert found.assembly.volume == pytest.approx([0.2, 0.6, 0.2], rel=1e-6)
    across = np.array([-np.sin(0.5), np.cos(0.5), 0.0])
    at = found.assembly.centroid @ across - np.array([1.0, 2.0, 0.0]) @ across
    middle = [0.05, 0.25, 0.45] if sense == "POSITIVE" else [0.45, 0.25, 0.05]
    assert at == pytest.approx(np.add(middle, offset))
    assert any("parted into its layers of stone" in note for note in found.notes)
    assert drystone.read(tmp_path / "model.ifc", supports="wall-1").contacts.count == 2


def test_layers_of_other_materials_are_left_out_and_one_of_stone_is_the_wall(
    tmp_path: Path,
) -> None:
    pytest.importorskip("ifcopenshell")
    cavity = [("brick", "brick", 0.1), ("wool", "insulation", 0.3), ("block", "block", 0.1)]
    found = read(tmp_path, wall_of_layers(cavity)[0].to_string(), ".ifc")
    assert found.assembly.volume == pytest.approx([0.2, 0.2], rel=1e-6)
    assert any("1 layer of other materials left out" in note for note in found.notes)
    plastered = [("plaster", "gypsum", 0.1), ("brick", "brick", 0.4)]
    found = read(tmp_path, wall_of_layers(plastered)[0].to_string(), ".ifc")
    assert found.assembly.names == ("wall",)
    assert found.assembly.volume == pytest.approx([1.0], rel=1e-6)


def test_solids_of_a_wall_are_its_stones(tmp_path: Path) -> None:
    pytest.importorskip("ifcopenshell")
    file, _, shape, body = wall_of_layers([])
    api = pytest.importorskip("ifcopenshell.api")
    more = {"length": 2.0, "height": 0.5, "thickness": 0.5, "offset": 0.5}
    other = api.run("geometry.add_wall_representation", file, context=body, **more)
    shape.Items = (*shape.Items, *other.Items)
    found = read(tmp_path, file.to_string(), ".ifc").assembly
    assert found.names == ("wall-0", "wall-1")
    assert found.volume == pytest.approx([1.0, 0.5], rel=1e-6)


@pytest.mark.parametrize("content", ["solid cube", ifc_file([])[:300], ifc_file([])])
def test_what_is_no_ifc_file_is_refused_in_one_line(tmp_path: Path, content: str) -> None:
    pytest.importorskip("ifcopenshell")
    with pytest.raises(FormatError, match=r"is no IFC|is damaged|no element that bears") as caught:
        read(tmp_path, content, ".ifc")
    assert "\n" not in str(caught.value)


def test_a_number_of_several_ifc_entities_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("ifcopenshell")
    text = wall_of_layers([("granite", "stone", 0.2), ("brick", "brick", 0.3)])[0].to_string()
    (wall,) = (line for line in text.splitlines() if "=IFCWALL(" in line)
    with pytest.raises(FormatError, match="is no IFC file that can be read"):
        read(tmp_path, text.replace(wall, "\n".join(3 * [wall])), ".ifc")


@pytest.mark.parametrize(("suffix", "package"), [(".step", "cascadio"), (".ifc", "ifcopenshell")])
def test_without_its_package_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, package: str
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(MissingDependency, match=rf"{package}; pip install '\.\[{suffix[1:]}\]'"):
        read(tmp_path, "ISO-10303-21;", suffix)


@pytest.mark.parametrize(("module", "suffix"), [(step, ".step"), (ifc, ".ifc")])
def test_a_library_that_dies_is_no_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: object, suffix: str
) -> None:
    program = tmp_path / "program.py"
    program.write_text("import os; os.abort()", encoding="utf-8")
    monkeypatch.setattr(module, "PROGRAM", program)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: name)
    with pytest.raises(FormatError, match="is damaged"):
        read(tmp_path, "ISO-10303-21;", suffix)
