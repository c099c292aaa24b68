"""COMPAS JSON without COMPAS: assemblies of compas_assembly, models and problems of compas_dem.

The structure was taken from files written with compas_assembly (COMPAS 2.0), compas_model
0.9.3 and compas_dem 0.4 to 0.6. Objects are ``{"dtype": "package.module/Class", "data": {...}}``;
COMPAS 1 wrote ``value`` for ``data``. Before that objects had no type: an assembly was
``{"assembly": {"vertex": {...}}, "blocks": {...}}`` or a network whose nodes have blocks, a list of
blocks a list of meshes, and a face the corner that follows each of its corners.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from drystone.assembly import DEFAULT_DENSITY
from drystone.base.arrays import Floats
from drystone.detection import DetectionOptions
from drystone.io import compas_contacts
from drystone.io.compas_contacts import SEARCH, data_of
from drystone.io.compas_problem import with_problems
from drystone.io.draft import Draft, DraftBlock
from drystone.io.drystone_json import detection_of
from drystone.io.face_soup import moved
from drystone.io.jsontext import Field

_TELLING = frozenset(("dtype", "assembly", "graph", "node", "face"))
"""Every object of COMPAS in a file has one of these keys."""


def is_compas(top: Field) -> bool:
    """Whether JSON is of COMPAS: typed objects, a list, or an assembly from before types."""
    if isinstance(top.value, list) or not _TELLING.isdisjoint(top.value):
        return True
    blocks = top.value.get("blocks")  # of results: a list of typed meshes
    return isinstance(blocks, list) and bool(blocks) and "dtype" in _keys(blocks[0])


def _keys(value: object) -> Collection[str]:
    return value if isinstance(value, dict) else ()


def read(top: Field) -> Draft:
    """The draft of a COMPAS file."""
    if isinstance(top.value, list):
        return _meshes(top)
    if "dtype" not in top.value:
        return _untyped(top)
    kind, data = _class(top), data_of(top)
    if kind in ("Problem", "Analysis"):
        return _problems(data, [data] if kind == "Problem" else [*data["problems"].elements()])
    if kind.endswith("Assembly"):
        return _graph(data_of(data["graph"]))
    if kind.endswith("Model"):
        return _model(data)[0]
    if "node" in data.object().value:
        return _graph(data)
    if not {"vertex", "vertices"}.isdisjoint(data.value):
        return Draft((_mesh(top, top.get("name", "block").text()),))
    raise top.error(
        f"is a COMPAS '{kind[:40]}'",
        "save an Assembly of compas_assembly, or a BlockModel or an Analysis of compas_dem",
    )


def _untyped(top: Field) -> Draft:
    """A network, a mesh, an assembly, or the blocks of results, from before types."""
    if "node" in top.value:
        return _graph(top)
    if "graph" in top.value:  # Assembly.to_json of COMPAS 1 leaves its own type out
        return _graph(data_of(top["graph"]))
    if "face" in top.value:
        return Draft((_mesh(top, "block"),))
    return _untyped_assembly(top) if "assembly" in top.value else _meshes(top["blocks"])


def _problems(data: Field, problems: list[Field]) -> Draft:
    if not data.has("model"):
        raise data.error(
            "holds no model", "save the Analysis, which has the model and its problems"
        )
    model, nodes = _model(data_of(data["model"]))
    return with_problems(model, nodes, [data_of(problem) for problem in problems])


def _meshes(top: Field) -> Draft:
    """A list of meshes or of such lists: blocks with their names, or their places in the list."""
    shapes = []
    waiting = [(mesh, f"block-{place}") for place, mesh in enumerate(top.elements())][::-1]
    while waiting:
        mesh, name = waiting.pop()
        if isinstance(mesh.value, list):
            inner = [(one, f"{name}-{i}") for i, one in enumerate(mesh.elements())]
            waiting += inner[::-1] if len(inner) != 1 else [(inner[0][0], name)]
        elif {"vertex", "vertices"}.isdisjoint(data_of(mesh).object().value):
            raise mesh.error("is no mesh", "a list may hold meshes only")
        else:
            shapes.append(_mesh(mesh, name))
    labels = [shape.metadata.get("label") for shape in shapes]
    for i, label in enumerate(labels):
        if label and labels.count(label) == 1:
            shapes[i] = replace(shapes[i], name=str(label), metadata={})
    return Draft(tuple(shapes))


def _untyped_assembly(top: Field) -> Draft:
    """An assembly from before COMPAS 1: a network whose vertices are blocks, and their meshes."""
    network = top["assembly"]
    default = network.get("dva", {}).get("is_support", False).boolean()
    shapes = []
    for key, node in network["vertex" if "vertex" in network.value else "node"].items():
        fixed = node.get("is_support", default).boolean()
        shapes.append(replace(_mesh(top["blocks"][key], _name(key)), fixed=fixed))
    return Draft(tuple(shapes))


def _class(field: Field) -> str:
    """Class name of an object."""
    return field["dtype"].text().rpartition("/")[2]


def _name(key: str) -> str:
    """Name of a graph's node: its key, which COMPAS writes with Python's ``repr``."""
    if len(key) > 2 and key[0] == key[-1] and key[0] in "'\"":
        try:
            return key[1:-1].encode("latin-1", "backslashreplace").decode("unicode_escape")
        except UnicodeDecodeError:
            return key
    return key


def _graph(graph: Field) -> Draft:
    """An assembly: a graph whose nodes have blocks. A node's key is its block's name."""
    default = graph.get("default_node_attributes", {}).get("is_support", False).boolean()
    shapes = []
    for key, node in graph["node"].items():
        if not node.has("block"):
            raise node.error("has no block", "remove the node")
        shape = _mesh(node["block"], _name(key))
        fixed = shape.fixed or node.get("is_support", default).boolean()
        shapes.append(replace(shape, fixed=fixed))
    finish = compas_contacts.reader(graph, ("interfaces", "interface"), list(graph["node"].value))
    return Draft(tuple(shapes), finish=finish, detection=_searched(graph))


def _model(data: Field) -> tuple[Draft, list[str]]:
    """A block model, and the node of each block.

    Its elements are placed by a tree of transformations, and in the order of the graph.
    """
    graph = data_of(data["graph"])
    elements = _by_guid(data["elements"])
    densities = _densities(data)
    place = _placements(data, elements)
    shapes: list[DraftBlock] = []
    nodes: list[str] = []
    given = Counter(data_of(element).get("name", "").text() for _, element in elements.items())
    for key, node in sorted(graph["node"].items(), key=lambda item: (len(item[0]), item[0])):
        guid = node["element"].text()
        inside = data_of(elements[guid])
        if not inside.has("geometry"):
            if _class(elements[guid]) != "Group":
                raise elements[guid].error("has no mesh", "only elements with a mesh can be read")
            continue
        name = inside.get("name", "").text()
        if not name or given[name] > 1:
            name = f"{name or 'block'}-{key}"
        shape = _mesh(inside["geometry"], name)
        vertices, mirrored = moved(np.asarray(shape.vertices), place.get(guid, np.eye(4)))
        shapes.append(
            replace(
                shape,
                vertices=vertices,
                faces=[loop[::-1] for loop in shape.faces] if mirrored else shape.faces,
                fixed=inside.get("is_support", False).boolean(),
                density=densities.get(inside.get("material", "").text(), DEFAULT_DENSITY),
            )
        )
        nodes.append(key)
    finish = compas_contacts.reader(graph, ("contacts",), nodes)
    return Draft(tuple(shapes), finish=finish, detection=_searched(graph)), nodes


def _searched(graph: Field) -> DetectionOptions | None:
    """The tolerances with which contacts were searched, where this package wrote them."""
    attributes = graph.get("attributes", {})
    known = isinstance(attributes.value, dict) and attributes.has(SEARCH)
    return detection_of(attributes[SEARCH]) if known else None


def _by_guid(elements: Field) -> Field:
    """Elements by their identifier; older files hold them as a list."""
    if not isinstance(elements.value, list):
        return elements.object()
    named = {element["guid"].text(): element.value for element in elements.elements()}
    return Field(named, elements.path, elements.file)


def _densities(data: Field) -> dict[str, float]:
    found = {}
    for guid, material in _by_guid(data.get("materials", {})).items():
        inside = data_of(material)
        if inside.has("density"):
            found[guid] = inside["density"].number()
    return found


def _placements(data: Field, elements: Field) -> dict[str, Floats]:
    """Matrix (4, 4) of each element: the model's, then its ancestors', then its own."""
    own = {guid: _matrix(data_of(element)) for guid, element in elements.items()}
    placed: dict[str, Floats] = {}
    stack = [(data_of(data["tree"])["root"], _matrix(data))]
    while stack:
        node, above = stack.pop()
        for child in node.get("children", []).elements():
            guid = child["element"].text()
            if guid not in own:
                raise child["element"].error("is no known element")
            with np.errstate(all="ignore"):  # overflow is found with the vertices
                placed[guid] = above @ own[guid]
            stack.append((child, placed[guid]))
    return placed


def _matrix(field: Field) -> Floats:
    if not field.has("transformation"):
        return np.eye(4)
    return data_of(field["transformation"])["matrix"].floats(4, 4)


def _mesh(field: Field, name: str) -> DraftBlock:
    """A mesh with vertices by key, as COMPAS 1 and 2 write them, or by position (polyhedron)."""
    data = data_of(field)
    attributes: Mapping[str, object] = data.get("attributes", {}).object().value
    if "vertices" in data.value:
        points = data["vertices"].floats(None, 3)
        loops = [[corner.integer() for corner in f.elements()] for f in data["faces"].elements()]
        for loop in loops:
            if loop and not (min(loop) >= 0 and max(loop) < len(points)):
                raise data["faces"].error("has a vertex that does not exist")
        return DraftBlock(name, points, loops, where=field.path)
    position = {key: i for i, key in enumerate(data["vertex"].object().value)}
    points = np.array(
        [[vertex.get(axis, 0.0).number() for axis in "xyz"] for _, vertex in data["vertex"].items()]
    ).reshape(-1, 3)
    loops = []
    for _, face in data["face"].items():
        corners = _corners(face)
        if not all(corner in position for corner in corners):
            raise face.error("has a vertex that does not exist")
        loops.append([position[corner] for corner in corners])
    label = attributes.get("name")
    density = data.get("attributes", {}).get("density", DEFAULT_DENSITY)
    return DraftBlock(
        name,
        points,
        loops,
        where=field.path,
        density=density.number(),
        fixed=attributes.get("is_support") is True,
        metadata={"label": label} if isinstance(label, str) else {},
    )


def _corners(face: Field) -> list[str]:
    """Keys of the corners of a face, in order: a list, or the corner that follows each of them."""
    if not isinstance(face.value, dict):
        return [str(corner.value) for corner in face.elements()]
    after = {key: str(corner.value) for key, corner in face.items()}
    loop = list(after)[:1]
    while loop and after.get(loop[-1]) in after and after[loop[-1]] not in loop:
        loop.append(after[loop[-1]])
    if len(loop) < len(after) or (loop and after[loop[-1]] != loop[0]):
        raise face.error("is not one closed loop of corners")
    return loop
