"""Problems and analyses of compas_dem, networks, and nested lists of meshes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import Assembly, FormatError, Model, Verdict, check, io, settle
from drystone.loads import STANDARD_GRAVITY
from drystone.models import box

CUBES = [box((1.0, 1.0, 1.0)).transformed(translation=(0.0, 0.0, float(i))) for i in range(3)]


def typed(kind: str, data: dict[str, Any]) -> dict[str, Any]:
    return {"dtype": f"compas.any/{kind}", "data": data, "guid": "-"}


def mesh(i: int) -> dict[str, Any]:
    points = CUBES[i].vertices.tolist()
    vertices = {str(k): dict(zip("xyz", at, strict=True)) for k, at in enumerate(points)}
    faces = {str(k): list(face) for k, face in enumerate(CUBES[i].faces)}
    return typed("Mesh", {"attributes": {}, "vertex": vertices, "face": faces})


def model(**more: Any) -> dict[str, Any]:
    """As compas_dem writes a pile of three cubes; no cube is a support."""
    elements = {str(i): typed("Block", {"name": f"b{i}", "geometry": mesh(i)}) for i in range(3)}
    data = {
        "elements": elements,
        "materials": [],
        "tree": {"root": {"children": [{"element": str(i)} for i in range(3)]}},
        "graph": {"node": {str(i): {"element": str(i)} for i in range(3)}, "edge": {}},
    }
    return typed("BlockModel", data | more)


def law(**values: Any) -> dict[str, Any]:
    given = {"phi": None, "mu": None, "c": None, "t_c": None} | values
    return typed("ContactProperties", {"contact_model": typed("MohrCoulomb", given)})


def held(block: int) -> dict[str, Any]:
    return {"block_index": block, "translation": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0]}


def problem(**conditions: Any) -> dict[str, Any]:
    """As compas_dem 0.5 writes a problem."""
    given = {"gravity": True, "g": 9.81, "displacements": [held(0)]} | conditions
    data = {
        "name": "Problem",
        "model": model(),
        "boundary_conditions": typed("BoundaryConditions", given),
        "contact_properties": law(mu=0.3),
    }
    return typed("Problem", data)


def analysis(*groups: dict[str, Any], **more: Any) -> dict[str, Any]:
    """As compas_dem 0.6 writes an analysis of one problem."""
    supported = model()
    supported["data"]["elements"]["0"]["data"]["is_support"] = True
    data = {
        "name": "Live",
        "model_id": "-",
        "boundary_conditions": [typed("BoundaryConditionGroup", group) for group in groups],
        "contact_properties": law(phi=45.0),
        "solver": None,
    }
    problems = [typed("Problem", data | more)]
    return typed("Analysis", {"name": "Analysis", "model": supported, "problems": problems})


def read(folder: Path, content: Any, **options: Any) -> Model:
    path = folder / "model.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return drystone.read(path, **options)


def test_a_block_model_with_an_empty_list_of_materials_is_read(tmp_path: Path) -> None:
    found = read(tmp_path, model(), supports="b0")
    assert found.assembly.mass == pytest.approx([2400.0] * 3)
    assert check(found).verdict is Verdict.STABLE


def test_a_problem_gives_supports_friction_and_loads(tmp_path: Path) -> None:
    push = {"block_index": 2, "force": [500.0, 0.0, 0.0], "moment": None, "point": [0.5, 0.5, 3.0]}
    found = read(tmp_path, problem(point_loads=[push]))
    assert found.assembly.fixed.tolist() == [True, False, False]
    assert found.contacts.friction == pytest.approx([0.3, 0.3])
    weight = 2400.0 * STANDARD_GRAVITY
    assert found.load.wrench[1] == pytest.approx([0, 0, -weight, 0, 0, 0])
    assert found.load.wrench[2] == pytest.approx([500.0, 0, -weight, 0, 250.0, 0])
    assert found.load.name == "Problem"
    assert check(found).verdict is Verdict.STABLE


def test_a_problem_without_loads_has_its_weight_and_may_be_split(tmp_path: Path) -> None:
    found = read(tmp_path, problem(), split=True)
    assert len(found.assembly) == 3
    assert found.load.wrench[1, 2] == pytest.approx(-2400.0 * STANDARD_GRAVITY)


def test_an_analysis_gives_the_sum_of_its_groups(tmp_path: Path) -> None:
    body = typed("BodyForce", {"acceleration": [1.0, 0.0, 0.0], "loading_type": "ramp"})
    face = next(i for i, f in enumerate(CUBES[2].faces) if CUBES[2].vertices[list(f), 2].min() > 2)
    press = {"block_index": 2, "face_index": face, "load": [0.0, 0.0, -100.0]}
    turn = {"block_index": 1, "force": [0.0, 0.0, 0.0], "moment": [0.0, 7.0, 0.0], "point": None}
    one = {"g": 9.81, "body_forces": [body], "point_loads": [typed("PointLoad", turn)]}
    found = read(tmp_path, analysis(one, {"surface_loads": [typed("SurfaceLoad", press)]}))
    weight = 2400.0 * STANDARD_GRAVITY
    assert found.load.wrench[1] == pytest.approx([2400.0, 0, -weight, 0, 7.0, 0])
    assert found.load.wrench[2] == pytest.approx([2400.0, 0, -weight - 100.0, 0, 0, 0])
    assert found.contacts.friction == pytest.approx([1.0, 1.0])


def test_a_load_on_a_polygon_acts_along_its_normal_or_its_direction(tmp_path: Path) -> None:
    corners = [[0, 0, 3], [1, 0, 3], [1, 0.5, 3], [0, 0.5, 3]]
    polygon = typed("Polygon", {"points": corners})
    press = {"block_index": 2, "polygon": polygon, "magnitude": -100.0, "direction": None}
    found = read(tmp_path, problem(surface_loads=[press]))
    weight = 2400.0 * STANDARD_GRAVITY
    assert found.load.wrench[2] == pytest.approx([0, 0, -weight - 50.0, 12.5, 0, 0])


def test_a_polygon_far_too_large_is_refused_where_it_stands(tmp_path: Path) -> None:
    polygon = typed("Polygon", {"points": [[0, 0, 3], [1e200, 0, 3], [0, 1e200, 3]]})
    press = {"block_index": 2, "polygon": polygon, "magnitude": -1.0, "direction": None}
    with pytest.raises(FormatError, match="far too large"):
        read(tmp_path, problem(surface_loads=[press]))


def test_imposed_displacements_are_a_case_for_settlement(tmp_path: Path) -> None:
    sink = {"block_index": 0, "translation": [None, None, -0.01], "rotation": None}
    found = read(tmp_path, problem(displacements=[sink]))
    assert found.assembly.fixed.tolist() == [True, False, False]
    assert [case.name for case in found.cases] == ["gravity", "Problem-displacements"]
    assert check(found).verdict is Verdict.STABLE
    moved = settle(found.with_load(found.cases[0] + found.cases[1]))
    assert moved.displacement[2, 2] == pytest.approx(-0.01, rel=1e-3)


def test_what_is_left_out_is_told(tmp_path: Path) -> None:
    found = read(tmp_path, analysis(contact_properties=law(mu=0.5, c=1e5)))
    assert "cohesion and tensile strength of the contacts are left out" in found.notes
    two = analysis()
    two["data"]["problems"] *= 2
    assert any("the first of 2 problems" in note for note in read(tmp_path, two).notes)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (
            problem(point_loads=[{"block_index": 9}]),
            r"point_loads\[0\]\.block_index: 9 is no block",
        ),
        (problem(point_loads=[{"block_index": 1}]), r"point_loads\[0\]: 'force' is missing"),
        (problem(displacements=[held(0) | {"translation": [0, "x", 0]}]), "must be a number"),
        (analysis(contact_properties=law(mu=-1.0)), "has a friction coefficient of -1"),
        (typed("Problem", {"model_id": "-"}), "holds no model; save the Analysis"),
        (typed("Results", {"node_data": {}}), "is a COMPAS 'Results'; save an Assembly"),
        ([[mesh(0), 3]], r"\[0\]\[1\]: must be an object"),
        ([[mesh(0), {"dtype": "a/Line", "data": {}}]], r"\[0\]\[1\]: is no mesh"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(tmp_path: Path, content: Any, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        read(tmp_path, content)


def names(folder: Path, content: Any) -> Assembly:
    path = folder / "model.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return io.read_file(path).assembly


def test_lists_of_lists_of_meshes_are_read(tmp_path: Path) -> None:
    assert names(tmp_path, [[mesh(0)], [mesh(1)]]).names == ("block-0", "block-1")
    assert names(tmp_path, [mesh(0), [mesh(1), mesh(2)]]).names == (
        "block-0",
        "block-1-0",
        "block-1-1",
    )
    deep: Any = mesh(0)
    for _ in range(500):
        deep = [deep]
    assert names(tmp_path, deep).names == ("block-0",)


def test_the_meshes_of_results_are_read(tmp_path: Path) -> None:
    content = {"blocks": [mesh(0), mesh(1)], "nodal_normal_compression_by_interface": []}
    assert names(tmp_path, content).names == ("block-0", "block-1")


@pytest.mark.parametrize("wrapped", [False, True])
def test_a_network_with_blocks_is_read_with_its_interfaces(tmp_path: Path, wrapped: bool) -> None:
    frame = typed("Frame", {"point": [0, 0, 1], "xaxis": [1, 0, 0], "yaxis": [0, 1, 0]})
    points = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    face = typed("Interface", {"points": points, "frame": frame})
    network = {
        "attributes": {"name": "Network"},
        "dna": {"x": 0.0, "block": None},
        "node": {"0": {"block": mesh(0), "is_support": True}, "5": {"block": mesh(1)}},
        "edge": {"0": {"5": {"interface": face}}, "5": {}},
    }
    found = read(tmp_path, typed("Network", network) if wrapped else network)
    assert found.assembly.names == ("0", "5")
    assert found.assembly.fixed.tolist() == [True, False]
    assert "the 1 interface of the file is used" in found.notes
    assert check(found).verdict is Verdict.STABLE


def test_a_mesh_and_a_thrust_diagram_are_surfaces_of_a_shell(tmp_path: Path) -> None:
    from drystone.shells import read_surface

    x, y = np.meshgrid(np.linspace(0, 4, 5), np.linspace(0, 3, 4), indexing="ij")
    points = np.stack([x, y, x * (4 - x) / 4], axis=2).reshape(-1, 3)
    vertices = {str(k): dict(zip("xyz", at, strict=True)) for k, at in enumerate(points.tolist())}
    faces = {
        str(4 * i + j): [4 * i + j, 4 * i + j + 4, 4 * i + j + 5, 4 * i + j + 1]
        for i in range(4)
        for j in range(3)
    }
    data = {"attributes": {}, "vertex": vertices, "face": faces}
    for kind in ("Mesh", "ThrustDiagram"):
        path = tmp_path / "surface.json"
        path.write_text(json.dumps(typed(kind, data)), encoding="utf-8")
        corner, loops = read_surface(path)
        assert (len(corner), len(loops)) == (20, 12)
    path.write_text(json.dumps(data), encoding="utf-8")  # as COMPAS wrote it before types
    assert len(read_surface(path)[1]) == 12
