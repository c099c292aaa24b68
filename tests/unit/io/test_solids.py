"""STEP and IFC: solids with names, parts of a wall, units; read by libraries that are extras."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Block, FormatError, MissingDependency, Verdict, check, io
from drystone.io import ifc, step
from drystone.models import box, tower

LOW, HIGH = tower(2).blocks[:2]


class Entities:
    """Entities of ISO 10303-21, numbered as they are added."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, text: str) -> str:
        self.lines.append(f"#{len(self.lines) + 1}={text};")
        return f"#{len(self.lines)}"

    def file(self, schema: str) -> str:
        head = ["ISO-10303-21;", "HEADER;", "FILE_DESCRIPTION((''),'2;1');"]
        head += ["FILE_NAME('','',(''),(''),'','','');", f"FILE_SCHEMA(('{schema}'));", "ENDSEC;"]
        return "\n".join([*head, "DATA;", *self.lines, "ENDSEC;", "END-ISO-10303-21;", ""])


def step_file(blocks: Sequence[Block], unit: str = "$") -> str:
    """Faceted solids, each a product of its own."""
    out = Entities()
    app = out.add("APPLICATION_CONTEXT('design')")
    out.add(f"APPLICATION_PROTOCOL_DEFINITION('','automotive_design',2000,{app})")
    length = out.add(f"(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({unit},.METRE.))")
    angle = out.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid = out.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    near = out.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-7),{length},'d','')")
    context = out.add(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)"
        f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({near}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))REPRESENTATION_CONTEXT('',''))"
    )
    for block in blocks:
        at = [out.add("CARTESIAN_POINT('',({:f},{:f},{:f}))".format(*p)) for p in block.vertices]
        faces = []
        for loop in block.faces:
            ring = out.add(f"POLY_LOOP('',({','.join(at[i] for i in loop)}))")
            bound = out.add(f"FACE_OUTER_BOUND('',{ring},.T.)")
            corner = block.vertices[list(loop)]
            ways = [corner[1] - corner[0], np.cross(corner[1] - corner[0], corner[2] - corner[1])]
            along, up = (out.add("DIRECTION('',({:f},{:f},{:f}))".format(*way)) for way in ways)
            axes = out.add(f"AXIS2_PLACEMENT_3D('',{at[loop[0]]},{up},{along})")
            plane = out.add(f"PLANE('',{axes})")
            faces.append(out.add(f"FACE_SURFACE('',({bound}),{plane},.T.)"))
        shell = out.add(f"CLOSED_SHELL('',({','.join(faces)}))")
        brep = out.add(f"FACETED_BREP('{block.name}',{shell})")
        shape = out.add(f"FACETED_BREP_SHAPE_REPRESENTATION('',({brep}),{context})")
        area = out.add(f"PRODUCT_CONTEXT('',{app},'mechanical')")
        product = out.add(f"PRODUCT('{block.name}','{block.name}','',({area}))")
        formation = out.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        view = out.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{app},'design')")
        definition = out.add(f"PRODUCT_DEFINITION('design','',{formation},{view})")
        of = out.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        out.add(f"SHAPE_DEFINITION_REPRESENTATION({of},{shape})")
    return out.file("AUTOMOTIVE_DESIGN")


def ifc_file(elements: Sequence[tuple[str, str, Block, str]], unit: str = "$") -> str:
    """Elements of a class, a name and a body; the last text is the name of the wall they are in."""
    out = Entities()
    point = out.add("IFCCARTESIANPOINT((0.,0.,0.))")
    axes = out.add(f"IFCAXIS2PLACEMENT3D({point},$,$)")
    place = out.add(f"IFCLOCALPLACEMENT($,{axes})")
    length = out.add(f"IFCSIUNIT(*,.LENGTHUNIT.,{unit},.METRE.)")
    units = out.add(f"IFCUNITASSIGNMENT(({length}))")
    context = out.add(f"IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-6,{axes},$)")
    out.add(f"IFCPROJECT('p',$,'p',$,$,$,$,({context}),{units})")
    walls: dict[str, tuple[str, list[str]]] = {}
    for number, (kind, name, block, wall) in enumerate(elements):
        corners = ",".join("({:f},{:f},{:f})".format(*at) for at in block.vertices)
        points = out.add(f"IFCCARTESIANPOINTLIST3D(({corners}))")
        loops = [
            out.add(f"IFCINDEXEDPOLYGONALFACE(({','.join(str(i + 1) for i in loop)}))")
            for loop in block.faces
        ]
        body = out.add(f"IFCPOLYGONALFACESET({points},.T.,({','.join(loops)}),$)")
        shape = out.add(f"IFCSHAPEREPRESENTATION({context},'Body','Tessellation',({body}))")
        of = out.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
        more = ",$" * {"IfcBuildingElementPart": 2, "IfcDoor": 6}.get(kind, 2)
        part = out.add(f"{kind.upper()}('e{number}',$,'{name}',$,$,{place},{of}{more})")
        if wall:
            known = walls.get(wall) or (
                out.add(f"IFCWALL('{wall}',$,'{wall}',$,$,{place},$,$,$)"),
                [],
            )
            walls[wall] = known
            known[1].append(part)
    for whole, parts in walls.values():
        out.add(f"IFCRELAGGREGATES('r{whole[1:]}',$,$,$,{whole},({','.join(parts)}))")
    return out.file("IFC4")


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


@pytest.mark.parametrize("content", ["solid cube", ifc_file([])[:300], ifc_file([])])
def test_what_is_no_ifc_file_is_refused_in_one_line(tmp_path: Path, content: str) -> None:
    pytest.importorskip("ifcopenshell")
    with pytest.raises(FormatError, match=r"is no IFC|is damaged|no element that bears") as caught:
        read(tmp_path, content, ".ifc")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("suffix", "package"), [(".step", "cascadio"), (".ifc", "ifcopenshell")])
def test_without_its_package_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, package: str
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(
        MissingDependency, match=rf"{package}; pip install 'drystone\[{suffix[1:]}\]'"
    ):
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
