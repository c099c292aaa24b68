"""Conversion from and to assemblies of compas_assembly and models of compas_model.

The ``BlockModel`` of compas_dem is a model of compas_model. Objects are recognised by the
attributes that their packages document. Reading them does not import COMPAS. Making them needs the
packages (extra ``compas``).
"""

from __future__ import annotations

import enum
import importlib
import json
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block
from drystone.base.arrays import Bools, Floats
from drystone.base.errors import DefectKind, InputError, require
from drystone.base.settings import member_of
from drystone.contacts import DEFAULT_FRICTION, Contacts
from drystone.geometry.frames import area_vector, frames_from_normals
from drystone.io.compas_contacts import COMPONENTS, forces_of, frame_of, joined, solved
from drystone.io.draft import Contents
from drystone.io.json_files import assembly_content, block_model_content
from drystone.io.registry import contents_of
from drystone.model import Model
from drystone.repair import mended_block
from drystone.results import Result


class CompasKind(enum.Enum):
    """What :func:`to_compas` makes."""

    ASSEMBLY = "compas_assembly"
    """An ``Assembly`` of compas_assembly."""
    BLOCK_MODEL = "compas_dem"
    """A ``BlockModel`` of compas_dem, which is a ``Model`` of compas_model."""


def from_compas(obj: Any, *, friction: float = DEFAULT_FRICTION) -> Contents:
    """Blocks, supports, contacts and forces of a COMPAS object.

    Parameters
    ----------
    obj
        An ``Assembly`` of compas_assembly or of a class derived from it; a ``Model`` of
        compas_model, such as the ``BlockModel`` of compas_dem. It is not changed.
    friction
        Of all contacts: COMPAS objects do not store it.

    Returns
    -------
    Contents
        In an assembly a node's key is its block's name; in a model the element's name, with the
        node behind it where several have one. Contacts are ``None`` when there are none. Forces of
        a solved one are a result.

    Raises
    ------
    InputError
        Another type, or a block that cannot be used.
    """
    if hasattr(obj, "node_block"):
        return _from_assembly(obj, friction)
    if hasattr(obj, "elements") and hasattr(obj, "graph"):
        return _from_model(obj, friction)
    raise InputError(
        f"a {type(obj).__name__} is neither an assembly nor a model of COMPAS",
        remedy="give an Assembly of compas_assembly or a BlockModel of compas_dem",
    )


def _from_assembly(obj: Any, friction: float) -> Contents:
    nodes = list(obj.graph.nodes())
    return _contents(blocks_of(obj, nodes), obj.graph, nodes, "interfaces", friction)


def blocks_of(obj: Any, nodes: Sequence[Any], density: float = DEFAULT_DENSITY) -> Assembly:
    """The blocks of an assembly of COMPAS with their supports; a density where one has none."""
    blocks = []
    for node in nodes:
        mesh = obj.node_block(node)
        blocks.append(block_of(mesh, str(node), mesh.attributes.get("density", density)))
    fixed = [bool(obj.graph.node_attribute(node, "is_support")) for node in nodes]
    return Assembly(tuple(blocks), np.array(fixed, dtype=bool))


def _from_model(obj: Any, friction: float) -> Contents:
    nodes = list(obj.graph.nodes())
    elements = [obj.graph.node_element(node) for node in nodes]
    solid = [_is_mesh(element.modelgeometry) for element in elements]
    nodes = [node for node, has in zip(nodes, solid, strict=True) if has]
    elements = [element for element, has in zip(elements, solid, strict=True) if has]
    if not nodes:
        raise InputError("the model has no elements with a mesh")
    names = [str(element.name) for element in elements]
    blocks = [
        block_of(
            element.modelgeometry,
            name if names.count(name) == 1 else f"{name}-{node}",
            getattr(element.material, "density", None),
        )
        for element, name, node in zip(elements, names, nodes, strict=True)
    ]
    fixed = [bool(getattr(element, "is_support", False)) for element in elements]
    assembly = Assembly(tuple(blocks), np.array(fixed, dtype=bool))
    return _contents(assembly, obj.graph, nodes, "contacts", friction)


def _is_mesh(geometry: Any) -> bool:
    return hasattr(geometry, "to_vertices_and_faces") and hasattr(geometry, "face_vertices")


def block_of(mesh: Any, name: str, density: float | None = None) -> Block:
    """The block of a COMPAS mesh; its ``density`` attribute is used if none is given.

    Raises
    ------
    InputError
        Open, non-manifold or flat.
    """
    vertices, faces = mesh.to_vertices_and_faces()
    if density is None:
        density = mesh.attributes.get("density", DEFAULT_DENSITY)
    try:
        return Block(np.array(vertices), tuple(tuple(face) for face in faces), name, density)
    except InputError as error:
        if error.kind is not DefectKind.OPEN:
            raise
    return mended_block(np.array(vertices), faces, name, density)


def _contents(
    assembly: Assembly, graph: Any, nodes: Sequence[Any], key: str, friction: float
) -> Contents:
    """The blocks with the interfaces of a graph, and the forces and motions of a solved one."""
    found = interfaces_of(graph, nodes, key)
    if not found:
        return Contents(assembly)
    contacts, backwards = joined_interfaces(found, friction)
    given = [
        np.array([[one.get(name, 0.0) for name in COMPONENTS] for one in stored.forces or []])
        for _, _, stored in found
    ]
    forces = forces_of(given, contacts, np.zeros(contacts.count, dtype=bool), backwards)
    moved = [graph.node_attribute(node, "displacement") or [0.0] * 6 for node in nodes]
    motion = np.array(moved, dtype=np.float64) if np.any(moved) else None
    return Contents(assembly, contacts, results=solved(assembly, contacts, forces, motion))


def interfaces_of(graph: Any, nodes: Sequence[Any], key: str) -> list[tuple[int, int, Any]]:
    """Positions of both blocks of each stored interface that has points, and the interface."""
    position = {node: i for i, node in enumerate(nodes)}
    return [
        (position[start], position[end], stored)
        for start, end in graph.edges()
        if start in position and end in position
        for stored in graph.edge_attribute((start, end), key) or []
        if len(stored.points)
    ]


def joined_interfaces(
    found: Sequence[tuple[int, int, Any]], friction: float
) -> tuple[Contacts, Bools]:
    """Contacts from stored interfaces, and which of these (m,) were turned round."""
    pairs = np.array([(a, b) for a, b, _ in found], dtype=np.intp)
    corners = [
        np.array([list(point) for point in stored.points], dtype=np.float64)
        for _, _, stored in found
    ]
    frames = [interface_frame(one[2], at) for one, at in zip(found, corners, strict=True)]
    return joined(pairs[:, 0], pairs[:, 1], corners, np.stack(frames), friction)


def interface_frame(stored: Any, points: Floats) -> Floats:
    """Rows n, u, v of a stored interface; a frame from its points if its own is not valid."""
    frame = frame_of(np.array(list(stored.frame.xaxis)), np.array(list(stored.frame.yaxis)))
    if frame is not None:
        return frame
    area = area_vector(points)
    if not area.any():
        raise InputError("an interface has neither a frame nor an area")
    return frames_from_normals((area / np.linalg.norm(area))[None])[0]


def to_compas(
    model: Model | Contents | Assembly | Result, kind: CompasKind = CompasKind.BLOCK_MODEL
) -> Any:
    """A COMPAS object with the blocks, supports, densities, contacts and forces of a model.

    Parameters
    ----------
    model
        A result also gives its contacts and its corner forces [N].
    kind

    Raises
    ------
    MissingDependency
        compas_assembly or compas_dem is not installed.
    """
    content = {
        CompasKind.ASSEMBLY: assembly_content,
        CompasKind.BLOCK_MODEL: block_model_content,
    }[member_of(CompasKind, kind, "kind")](contents_of(model))
    compas = _compas(_packages(content))
    return compas.json_loads(json.dumps(content))


def _packages(content: Any) -> set[str]:
    """Names of the packages whose classes occur in the content."""
    if isinstance(content, dict):
        own = {content["dtype"].partition(".")[0]} if "dtype" in content else set()
        return own.union(*(_packages(value) for value in content.values()))
    if isinstance(content, Iterable) and not isinstance(content, str):
        return set().union(*(_packages(value) for value in content))
    return set()


def _compas(packages: set[str]) -> Any:
    for package in sorted({"compas", *packages}):
        require(package, "compas", "making COMPAS objects")
        importlib.import_module(package)
    return importlib.import_module("compas")
