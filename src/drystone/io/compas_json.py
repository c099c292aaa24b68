"""COMPAS JSON without COMPAS: assemblies of compas_assembly, models and problems of compas_dem.

The structure was taken from files written with compas_assembly (COMPAS 2.0), compas_model
0.9.3 and compas_dem 0.4 to 0.6. Objects are ``{"dtype": "package.module/Class", "data": {...}}``;
COMPAS 1 wrote ``value`` for ``data``. Before that objects had no type: an assembly was
``{"assembly": {"vertex": {...}}, "blocks": {...}}`` or a network whose nodes have blocks, a list of
blocks a list of meshes, and a face the corner that follows each of its corners.

A ``Problem`` of compas_dem 0.5 holds its model and one set of conditions, an ``Analysis`` of 0.6 a
model and problems, each with groups of conditions. The loads of a problem act together and become
one load case with the weight, in newtons and metres, since its solvers add the weight. Its
displacements become another one: only a settlement answers for them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly
from drystone.base.arrays import FARTHEST, Floats
from drystone.detection import DetectionOptions
from drystone.geometry.frames import area_vector
from drystone.io import compas_contacts
from drystone.io.compas_contacts import SEARCH, data_of
from drystone.io.draft import Draft, DraftBlock, Extras, moved
from drystone.io.drystone_json import detection_of
from drystone.io.jsontext import Field
from drystone.loads import STANDARD_GRAVITY, LoadCase


def with_problems(model: Draft, nodes: Sequence[str], problems: Sequence[Field]) -> Draft:
    """The draft of a block model with the friction, supports and loads of its problems.

    Parameters
    ----------
    model
    nodes
        Node of each of its blocks.
    problems
        Data of the problems. The first one gives friction and supports.
    """
    position = {node: i for i, node in enumerate(nodes)}
    conditions = [[*_groups(problem)] for problem in problems]
    motions = [_motions(groups, position) for groups in conditions]
    friction, notes = _friction(problems[0]) if problems else (None, [])
    if len(problems) > 1:
        notes.append(f"friction and supports are those of the first of {len(problems)} problems")
    held = motions[0] if motions else {}
    law = {} if friction is None else {"friction": friction}
    shapes = tuple(
        replace(shape, fixed=shape.fixed or i in held, metadata={**shape.metadata, **law})
        for i, shape in enumerate(model.shapes)
    )
    every = [*zip(problems, conditions, motions, strict=True)]
    if model.finish is None and not any(_is_loaded(g) or _moves(m) for _, g, m in every):
        return replace(model, shapes=shapes, notes=(*model.notes, *notes))

    def finish(assembly: Assembly, scale: float) -> Extras:
        contacts, _, results = model.finish(assembly, scale) if model.finish else (None, (), ())
        if contacts is not None and friction is not None:
            contacts = contacts.with_friction(friction)
            results = tuple(
                replace(one, model=one.model.with_friction(friction)) for one in results
            )
        cases = [
            case
            for number, one in enumerate(every)
            for case in _cases(*one, number, assembly, position)
        ]
        if cases and cases[0].motion is not None:
            cases.insert(0, LoadCase.gravity(assembly))
        return contacts, tuple(cases), results

    return Draft(shapes, "m", finish, notes=(*model.notes, *notes))


def _moves(motion: Mapping[int, Floats]) -> bool:
    return bool(np.any([*motion.values()]))


def _cases(
    problem: Field,
    groups: Sequence[Field],
    motion: Mapping[int, Floats],
    number: int,
    assembly: Assembly,
    position: dict[str, int],
) -> Iterator[LoadCase]:
    """The load case of a problem, and one of its displacements, where it has them."""
    name = problem.get("name", "").text() or f"problem-{number}"
    if _is_loaded(groups):
        weight = LoadCase.gravity(assembly, _gravity(groups))
        loads = [one for group in groups for one in _loads(group, assembly, position)]
        yield LoadCase.combine([(1.0, one) for one in (weight, *loads)], name)
    if _moves(motion):
        moves = [(1.0, LoadCase.settlement(assembly, i, by)) for i, by in motion.items()]
        yield LoadCase.combine(moves, f"{name}-displacements")


def _groups(problem: Field) -> Iterator[Field]:
    """Data of the groups of conditions of a problem: several, or one in compas_dem 0.5."""
    conditions = problem.get("boundary_conditions", [])
    listed = isinstance(conditions.value, list)
    yield from map(data_of, conditions.elements() if listed else [conditions])


def _entries(group: Field, key: str) -> Iterator[Field]:
    yield from map(data_of, group.get(key, []).elements())


def _friction(problem: Field) -> tuple[float | None, list[str]]:
    """Friction coefficient of a problem, and remarks on what of its contact law is not read."""
    if not problem.has("contact_properties"):
        return None, []
    properties = data_of(problem["contact_properties"])
    if not properties.has("contact_model"):
        return None, []
    law = data_of(properties["contact_model"])
    glue = [key for key in ("c", "t_c") if law.has(key) and law[key].number()]
    notes = ["cohesion and tensile strength of the contacts are left out"] if glue else []
    if law.has("mu"):
        friction = law["mu"].number()
    elif law.has("phi"):
        friction = float(np.tan(np.deg2rad(law["phi"].number())))
    else:
        return None, notes
    if not 0.0 <= friction < np.inf:
        raise law.error(f"has a friction coefficient of {friction:g}", "give zero or more")
    return friction, notes


def _block(entry: Field, position: dict[str, int]) -> int:
    node = entry["block_index"].integer()
    if str(node) not in position:
        raise entry["block_index"].error(f"{node} is no block", "give a node of the model's graph")
    return position[str(node)]


def _motions(groups: Sequence[Field], position: dict[str, int]) -> dict[int, Floats]:
    """Motion (6,) [m, rad] of each block that is held or moved; what is not given is zero."""
    motions: dict[int, Floats] = {}
    for group in groups:
        for entry in _entries(group, "displacements"):
            motion = motions.setdefault(_block(entry, position), np.zeros(6))
            for key, start in (("translation", 0), ("rotation", 3)):
                if entry.has(key):
                    given = [one.value or 0.0 for one in entry[key].elements()]
                    told = Field(given, entry[key].path, entry.file)
                    motion[start : start + 3] += told.floats(3)
    return motions


def _is_loaded(groups: Sequence[Field]) -> bool:
    keys = ("body_forces", "point_loads", "surface_loads")
    return any(group.get(key, []).value for group in groups for key in keys) or (
        _gravity(groups) != STANDARD_GRAVITY
    )


def _gravity(groups: Sequence[Field]) -> float:
    given = [group["g"].number() for group in groups if group.has("g")]
    return given[0] if given else STANDARD_GRAVITY


def _loads(group: Field, assembly: Assembly, position: dict[str, int]) -> Iterator[LoadCase]:
    """The loads of a group. Loads on supports have no effect and are left out."""
    for entry in group.get("body_forces", []).elements():
        given = entry if isinstance(entry.value, list) else data_of(entry)["acceleration"]
        wrench = np.zeros((len(assembly), 6))
        wrench[:, :3] = assembly.mass[:, None] * given.floats(3)
        yield LoadCase(wrench, "body force")
    for key, load in _LOADS.items():
        for entry in _entries(group, key):
            block = _block(entry, position)
            if not assembly.fixed[block]:
                yield from load(entry, assembly, block)


def _point(entry: Field, assembly: Assembly, block: int) -> Iterator[LoadCase]:
    at = entry["point"].floats(3) if entry.has("point") else None
    yield LoadCase.point_load(assembly, block, entry["force"].floats(3), at)
    if entry.has("moment"):
        yield LoadCase.moment(assembly, block, entry["moment"].floats(3))


def _surface(entry: Field, assembly: Assembly, block: int) -> Iterator[LoadCase]:
    """A traction [Pa] on a face, or in compas_dem 0.5 on a polygon of its own."""
    if entry.has("face_index"):
        face = entry["face_index"].integer()
        yield LoadCase.surface_load(assembly, block, entry["load"].floats(3), [face])
        return
    points = data_of(entry["polygon"])["points"].elements()
    corners = np.array([data_of(point).floats(3) for point in points]).reshape(-1, 3)
    if not np.abs(corners).max(initial=0.0) <= FARTHEST:
        raise entry["polygon"].error("has a coordinate that is far too large")
    area = area_vector(corners) if len(corners) > 2 else np.zeros(3)
    size = float(np.linalg.norm(area))
    if size == 0.0:
        raise entry["polygon"].error("has no area")
    along = entry["direction"].floats(3) if entry.has("direction") else area / size
    force = entry["magnitude"].number() * size * along
    yield LoadCase.point_load(assembly, block, force, corners.mean(axis=0))


_LOADS: dict[str, Callable[[Field, Assembly, int], Iterator[LoadCase]]] = {
    "point_loads": _point,
    "surface_loads": _surface,
}


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
        at = place.get(guid, np.eye(4))
        vertices, faces = moved(np.asarray(shape.vertices), shape.faces, at)
        shapes.append(
            replace(
                shape,
                vertices=vertices,
                faces=faces,
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
