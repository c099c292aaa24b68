import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drystone import (
    Assembly,
    Block,
    Contacts,
    FormatError,
    LoadCase,
    Model,
    Result,
    Verdict,
    check,
    io,
)
from drystone.assembly import replace_block
from drystone.models import arch, box, tower, vault

CUBE = box((1.0, 1.0, 1.0))


def mesh(block: Block = CUBE, dtype: str = "compas.datastructures/Mesh") -> dict[str, Any]:
    """As COMPAS 2 writes a mesh."""
    data = {
        "attributes": {"name": "B-1"},
        "default_vertex_attributes": {"x": 0.0, "y": 0.0, "z": 0.0},
        "vertex": {
            str(10 + i): dict(zip("xyz", point, strict=True))
            for i, point in enumerate(block.vertices.tolist())
        },
        "face": {str(i): [10 + c for c in face] for i, face in enumerate(block.faces)},
    }
    return {"dtype": dtype, "data": data, "guid": "-"}


def interface(z: float = 1.0) -> dict[str, Any]:
    """The unit square at a height, its frame upwards, its corners clockwise."""
    frame = {"point": [0, 0, z], "xaxis": [2, 0, 0], "yaxis": [0.5, 1, 0]}
    points = [[0, 0, z], [0, 1, z], [1, 1, z], [1, 0, z]]
    data = {"points": points, "size": 7.0, "frame": {"dtype": "a/Frame", "data": frame}}
    return {"dtype": "compas_assembly.datastructures/Interface", "data": data}


def assembly_file(**edge: Any) -> dict[str, Any]:
    """As compas_assembly writes two cubes, the lower one a support."""
    upper = CUBE.transformed(translation=(0.0, 0.0, 1.0))
    blocks = [mesh(b, "compas_assembly.datastructures/Block") for b in (CUBE, upper)]
    graph = {
        "default_node_attributes": {"block": None, "is_support": False},
        "node": {"7": {"block": blocks[0], "is_support": True}, "'top'": {"block": blocks[1]}},
        "edge": {"7": {"'top'": edge}, "'top'": {}},
    }
    data = {"attributes": {}, "graph": {"dtype": "compas.datastructures/Graph", "data": graph}}
    return {"dtype": "compas_assembly.datastructures/Assembly", "data": data}


def matrix(*rows: list[float]) -> dict[str, Any]:
    full = [*rows, [0.0, 0.0, 0.0, 1.0]]
    return {"dtype": "compas.geometry/Transformation", "data": {"matrix": full}}


def element(name: str, transformation: Any = None, **more: Any) -> dict[str, Any]:
    data = {"name": name, "transformation": transformation, "geometry": mesh()} | more
    return {"dtype": "compas_dem.elements/Block", "data": data}


LIFT = matrix([1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 1.0])
DOUBLE_AND_MIRROR = matrix([-2.0, 0, 0, 0], [0, 2.0, 0, 0], [0, 0, 2.0, 0])


def block_model_file() -> dict[str, Any]:
    """As compas_dem writes a base and, in a group, two blocks without a name of their own."""
    elements = {
        "g": {"dtype": "compas_model.elements/Group", "data": {"transformation": LIFT}},
        "b": element("Block", LIFT, material="m"),
        "a": element("base", is_support=True),
        "c": element("Block", DOUBLE_AND_MIRROR),
    }
    children = [{"element": "b"}, {"element": "c"}]
    root = {"children": [{"element": "a"}, {"element": "g", "children": children}]}
    stone = {"dtype": "compas_dem.material/Stone", "data": {"density": 2000}}
    data = {
        "transformation": matrix([1.0, 0, 0, 5.0], [0, 1.0, 0, 0], [0, 0, 1.0, 0]),
        "elements": elements,
        "materials": {"m": stone},
        "tree": {"root": root},
        "graph": {
            "node": {
                "10": {"element": "c"},
                "0": {"element": "a"},
                "2": {"element": "b"},
                "1": {"element": "g"},
            },
            "edge": {},
        },
    }
    return {"dtype": "compas_dem.models/BlockModel", "data": data}


def load(tmp_path: Path, content: Any, **options: str) -> io.Contents:
    path = tmp_path / "model.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return io.read_file(path, **options)


def test_an_assembly_is_read_with_its_supports_and_the_keys_of_its_nodes(tmp_path: Path) -> None:
    model = load(tmp_path, assembly_file())
    assert model.assembly.names == ("7", "top")
    assert model.assembly.fixed.tolist() == [True, False]
    assert [len(b.faces) for b in model.assembly.blocks] == [6, 6]
    assert dict(model.assembly.blocks[0].metadata) == {"label": "B-1"}
    assert model.contacts is None


def test_an_assembly_of_a_derived_class_is_read(tmp_path: Path) -> None:
    content = assembly_file() | {"dtype": "compas_cra.datastructures/CRA_Assembly"}
    assert len(load(tmp_path, content).assembly) == 2


def test_files_of_compas_1_say_value_for_data(tmp_path: Path) -> None:
    text = json.dumps(assembly_file()).replace('"data"', '"value"')
    assert len(load(tmp_path, json.loads(text)).assembly) == 2


def test_an_assembly_that_wrote_itself_with_compas_1_is_read(tmp_path: Path) -> None:
    """``Assembly.to_json`` leaves out its own type and says "value" for data."""
    typed = json.loads(json.dumps(assembly_file()).replace('"data"', '"value"'))
    itself = {"attributes": {"name": "Assembly"}, "graph": typed["value"]["graph"]}
    for graph in (itself, itself | {"graph": typed["value"]["graph"]["value"]}):
        contents = load(tmp_path, graph)
        assert contents.assembly.names == load(tmp_path, typed).assembly.names


def untyped_mesh(block: Block, name: str | None = None) -> dict[str, Any]:
    """As COMPAS wrote a mesh before it wrote types: each corner of a face names the next one."""
    data: dict[str, Any] = mesh(block)["data"]
    loops = data["face"].values()
    following = [
        dict(zip(map(str, loop), map(str, [*loop[1:], loop[0]]), strict=True)) for loop in loops
    ]
    return data | {"face": dict(enumerate(following)), "attributes": {"name": name}}


UPPER = CUBE.transformed(translation=(0.0, 0.0, 1.0))


def test_an_assembly_from_before_types_is_read(tmp_path: Path) -> None:
    network = {"dva": {"is_support": False}, "vertex": {"0": {"is_support": True}, "1": {}}}
    blocks = {"1": untyped_mesh(UPPER), "0": untyped_mesh(CUBE)}
    read = load(tmp_path, {"assembly": network, "blocks": blocks}).assembly
    assert read.names == ("0", "1")
    assert read.fixed.tolist() == [True, False]
    assert [block.centroid[2] for block in read.blocks] == pytest.approx([0.5, 1.5])
    assert [block.volume for block in read.blocks] == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize("make", [untyped_mesh, mesh])
def test_a_list_of_meshes_is_read(tmp_path: Path, make: Any) -> None:
    read = load(tmp_path, [make(CUBE), make(UPPER)]).assembly
    assert [block.volume for block in read.blocks] == pytest.approx([1.0, 1.0])
    assert read.names == ("block-0", "block-1")


def test_meshes_of_a_list_keep_names_that_differ(tmp_path: Path) -> None:
    read = load(tmp_path, [untyped_mesh(CUBE, "base"), untyped_mesh(UPPER, "top")]).assembly
    assert read.names == ("base", "top")


def test_elements_of_a_model_may_be_a_list(tmp_path: Path) -> None:
    content = block_model_file()
    elements = content["data"]["elements"]
    content["data"]["elements"] = [one | {"guid": guid} for guid, one in elements.items()]
    assert load(tmp_path, content).assembly.names == ("base", "Block-2", "Block-10")


@pytest.mark.parametrize(
    ("face", "words"),
    [
        ({"10": "11", "11": "10", "12": "13", "13": "12"}, "one closed loop"),
        ({"10": "11", "11": "12"}, "one closed loop"),
    ],
)
def test_an_untyped_face_that_is_no_loop_is_refused(
    tmp_path: Path, face: dict[str, str], words: str
) -> None:
    broken = untyped_mesh(CUBE)
    broken["face"] = {"x": face} | broken["face"]
    with pytest.raises(FormatError, match=words):
        load(tmp_path, [broken])


@pytest.mark.parametrize("content", [[], [3], [{"dtype": "compas.geometry/Box", "data": {}}]])
def test_a_list_of_other_things_is_refused(tmp_path: Path, content: Any) -> None:
    with pytest.raises(FormatError):
        load(tmp_path, content)


@pytest.mark.parametrize(("units", "scale"), [("m", 1.0), ("cm", 0.01)])
def test_stored_interfaces_become_contacts(tmp_path: Path, units: str, scale: float) -> None:
    model = load(tmp_path, assembly_file(interfaces=[interface()]), units=units)
    contacts = model.contacts
    assert contacts is not None
    assert (contacts.block_a.tolist(), contacts.block_b.tolist()) == ([0], [1])
    assert contacts.frame[0].tolist() == [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
    assert contacts.area == pytest.approx([scale**2])
    around = np.array([[1.0, 0, 1], [1, 1, 1], [0, 1, 1], [0, 0, 1]]) * scale
    assert contacts.point == pytest.approx(around)


def test_a_normal_that_points_the_wrong_way_is_turned(tmp_path: Path) -> None:
    stored = interface()
    stored["data"]["frame"]["data"]["yaxis"] = [0.5, -1, 0]
    contacts = load(tmp_path, assembly_file(interfaces=[stored])).contacts
    assert contacts is not None
    assert contacts.frame[0].tolist() == [[0, 0, 1], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    ("where", "value", "words"),
    [
        ("points", [[0, 0, 0], [1e200, 0, 0], [0, 1e200, 0]], "far too large"),
        ("points", [], "no points"),
        ("frame", {"xaxis": [1e200, 0, 0], "yaxis": [0, 1e200, 0]}, "span no plane"),
        ("frame", {"xaxis": [1, 0, 0], "yaxis": [2, 0, 0]}, "span no plane"),
    ],
)
def test_interfaces_that_cannot_be_used_are_refused(
    tmp_path: Path, where: str, value: Any, words: str
) -> None:
    stored = interface()
    stored["data"][where] = value
    with pytest.raises(FormatError, match=words):
        load(tmp_path, assembly_file(interfaces=[stored]))


def test_an_interface_without_a_frame_gets_one(tmp_path: Path) -> None:
    stored = interface()
    stored["data"]["frame"] = None
    contacts = load(tmp_path, assembly_file(interfaces=[stored])).contacts
    assert contacts is not None
    assert contacts.frame[0, 0].tolist() == [0, 0, 1]
    assert np.linalg.det(contacts.frame[0]) == pytest.approx(1.0)


def test_a_block_model_is_read_in_the_order_of_its_graph_and_placed_by_its_tree(
    tmp_path: Path,
) -> None:
    model = load(tmp_path, block_model_file())
    blocks = model.assembly.blocks
    assert model.assembly.names == ("base", "Block-2", "Block-10")
    assert model.assembly.fixed.tolist() == [True, False, False]
    assert [b.density for b in blocks] == [2400.0, 2000.0, 2400.0]
    assert [b.volume for b in blocks] == pytest.approx([1.0, 1.0, 8.0])
    low = [b.bounds[0].tolist() for b in blocks]
    assert low == [[5, 0, 0], [5, 0, 2], [3, 0, 1]]
    assert not any(b.repairs for b in blocks)


def test_a_single_mesh_is_one_block(tmp_path: Path) -> None:
    assert load(tmp_path, mesh()).assembly.blocks[0].volume == pytest.approx(1.0)
    data = {"vertices": CUBE.vertices.tolist(), "faces": [list(f) for f in CUBE.faces]}
    polyhedron = {"dtype": "compas.geometry/Polyhedron", "data": data, "name": "one"}
    assert load(tmp_path, polyhedron).assembly.names == ("one",)


def changed(content: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    at: Any = content
    *steps, last = path.split("/")
    for step in steps:
        at = at[step]
    if value is KeyError:
        del at[last]
    else:
        at[last] = value
    return content


NODE = "data/graph/data/node/7"


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("dtype", "compas.geometry/Box", ["'Box'", "BlockModel"]),
        ("dtype", 3, ["dtype", "a string"]),
        ("data", KeyError, ["'value' is missing"]),
        (f"{NODE}/block", None, ["node.7", "no block"]),
        (f"{NODE}/is_support", "yes", ["node.7.is_support", "true or false"]),
        (f"{NODE}/block/data/vertex/10/x", float("nan"), ["vertex.10.x", "nan"]),
        (f"{NODE}/block/data/face/0", [10, 11, 99], ["face.0", "has a vertex"]),
        (f"{NODE}/block/data/attributes", {"density": -3}, ["density is -3"]),
        ("data/graph/data/edge", {"7": {"8": {"interfaces": [{}]}}}, ["no blocks"]),
        ("data/graph/data/edge", {"7": {"'top'": {"interfaces": [{}]}}}, ["'points' is missing"]),
        ("data/graph/data/node", {}, ["no block"]),
    ],
)
def test_what_is_wrong_is_named_with_its_path(
    tmp_path: Path, path: str, value: Any, words: list[str]
) -> None:
    with pytest.raises(FormatError) as caught:
        load(tmp_path, changed(assembly_file(), path, value))
    assert "\n" not in str(caught.value)
    for word in ("model.json", *words):
        assert word in str(caught.value)


def test_an_element_without_a_mesh_is_refused(tmp_path: Path) -> None:
    content = block_model_file()
    del content["data"]["elements"]["b"]["data"]["geometry"]
    with pytest.raises(FormatError, match=r"data\.elements\.b: has no mesh"):
        load(tmp_path, content)


def result_of_a_tower() -> Result:
    """Three cubes; the second joint is stored from above, against the order of the first."""
    assembly = Assembly(
        tuple(
            replace_block(block, name=name, density=density)
            for block, name, density in zip(
                tower(3).blocks, ("12", "left pier", "'q'"), (2400.0, 1 / 3, 2400.0), strict=True
            )
        ),
        np.array([True, False, False]),
    )
    up = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    down = np.array([[0.0, 0, -1], [1, 0, 0], [0, -1, 0]])
    square = np.array([[0.0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
    lift = np.array([0.0, 0, 1])
    contacts = Contacts(
        np.array([0, 2, 1]),
        np.array([1, 1, 2]),
        np.stack([up, down, up]),
        np.array([1.0, 1.0, 1.0]),
        np.full(3, 0.6),
        np.concatenate([square, square[::-1] + lift, square + lift]),
        np.repeat([0, 1, 2], 4),
    )
    force = np.arange(36.0).reshape(12, 3) - 5.0
    load = LoadCase.gravity(assembly)
    return Result("rbe", Verdict.UNDECIDED, Model(assembly, contacts, load), force=force)


@pytest.mark.parametrize("format", ["compas-assembly", "compas-dem"])
def test_writing_and_reading_keeps_everything_that_compas_has_a_place_for(
    tmp_path: Path, format: str
) -> None:
    result = result_of_a_tower()
    io.write(result, tmp_path / "model.json", format=format)
    again = io.read_file(tmp_path / "model.json")
    assert again.assembly.names == result.assembly.names
    assert again.assembly.fixed.tolist() == [True, False, False]
    for one, other in zip(result.assembly.blocks, again.assembly.blocks, strict=True):
        assert np.array_equal(one.vertices, other.vertices)
        assert (one.faces, one.density) == (other.faces, other.density)
    contacts = again.contacts
    assert contacts is not None
    assert contacts.block_a.tolist() == [0, 2, 2]
    assert contacts.block_b.tolist() == [1, 1, 1]
    assert contacts.area.tolist() == [1.0, 1.0, 1.0]
    assert contacts.frame[:, 0].tolist() == [[0, 0, 1], [0, 0, -1], [0, 0, -1]]
    assert np.linalg.det(contacts.frame) == pytest.approx(1.0)


@pytest.mark.parametrize("format", ["compas-assembly", "compas-dem"])
def test_forces_are_those_on_the_second_block_of_an_edge(tmp_path: Path, format: str) -> None:
    result = result_of_a_tower()
    io.write(result, tmp_path / "model.json", format=format)
    content = json.loads((tmp_path / "model.json").read_text(encoding="utf-8"))
    graph = content["data"]["graph"]
    edges = graph.get("data", graph)["edge"]
    world = np.zeros((3, 3))
    names = list(edges)
    for a, neighbours in edges.items():
        for b, edge in neighbours.items():
            for stored in edge.get("interfaces") or edge.get("contacts"):
                frame = stored["data"]["frame"]["data"]
                x, y = np.array(frame["xaxis"]), np.array(frame["yaxis"])
                for force in stored["data"]["forces"]:
                    total = (
                        (force["c_np"] - force["c_nn"]) * np.cross(x, y)
                        + force["c_u"] * x
                        + force["c_v"] * y
                    )
                    assert min(force["c_np"], force["c_nn"]) == 0.0
                    world[names.index(b)] += total
                    world[names.index(a)] -= total
    expected = np.zeros((3, 3))
    on_b = result.world_force()
    np.add.at(expected, result.contacts.block_b[result.contacts.interface], on_b)
    np.add.at(expected, result.contacts.block_a[result.contacts.interface], -on_b)
    assert world == pytest.approx(expected)


@pytest.mark.parametrize("format", ["compas-assembly", "compas-dem"])
def test_forces_are_read_back(tmp_path: Path, format: str) -> None:
    model = Model.of(tower(3), load=(1.0, 0.5, -9.81), friction=0.6)
    force = check(model).force
    assert force is not None
    io.write(
        Result("rbe", Verdict.UNDECIDED, model, force=force), tmp_path / "m.json", format=format
    )
    (again,) = io.read_file(tmp_path / "m.json").results
    assert again.verdict is Verdict.EQUILIBRIUM_EXISTS
    assert again.load.wrench == pytest.approx(model.load.wrench, rel=1e-9)
    assert again.force == pytest.approx(force)


def test_forces_of_an_interface_that_points_the_other_way_are_read_back(tmp_path: Path) -> None:
    result = result_of_a_tower()
    io.write(result, tmp_path / "model.json", format="compas-assembly")
    (again,) = io.read_file(tmp_path / "model.json").results
    assert again.verdict is Verdict.UNDECIDED
    assert "do not balance" in again.message
    total = np.zeros((2, 3, 3))
    for side, one in zip(total, (result, again), strict=True):
        contacts = one.contacts
        np.add.at(side, contacts.block_b[contacts.interface], one.world_force())
        np.add.at(side, contacts.block_a[contacts.interface], -one.world_force())
    assert total[1] == pytest.approx(total[0])


@pytest.mark.parametrize("format", ["compas-assembly", "compas-dem"])
@pytest.mark.parametrize("assembly", [arch(), vault()])
def test_model_families_survive_the_way_there_and_back(
    tmp_path: Path, format: str, assembly: Assembly
) -> None:
    io.write(assembly, tmp_path / "model.json", format=format)
    again = io.read_file(tmp_path / "model.json").assembly
    assert again.names == assembly.names
    assert np.array_equal(again.fixed, assembly.fixed)
    for one, other in zip(assembly.blocks, again.blocks, strict=True):
        assert np.array_equal(one.vertices, other.vertices)
        assert one.faces == other.faces


def test_the_same_model_gives_the_same_file(tmp_path: Path) -> None:
    model = io.Contents(tower(3))
    for name in ("a.json", "b.json"):
        io.write(dataclasses.replace(model), tmp_path / name, format="compas-dem")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
