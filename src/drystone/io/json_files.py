"""JSON files of drystone, of COMPAS and of bricks: told apart when they are read, and written."""

from __future__ import annotations

import json
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from drystone.answer import plain
from drystone.assembly import Block
from drystone.base.errors import FormatError
from drystone.base.files import utf8, write_bytes
from drystone.contacts import Contacts
from drystone.detection import DetectionOptions
from drystone.io import bricks, compas_json, drystone_json, jsontext
from drystone.io.compas_contacts import SEARCH
from drystone.io.draft import Contents, Draft
from drystone.io.drystone_json import ARRAYS, CONTACTS, NUMBERS, PLAIN, SCHEMA, TEXTS, VERSION
from drystone.joint_capacity import DRY
from drystone.loads import LoadCase
from drystone.results import Result


def write(model: Contents, path: Path) -> None:
    """Write a model with all its data to one file.

    Raises
    ------
    FormatError
        A result belongs to other contacts, or metadata is not made of JSON values.
    """
    write_bytes(path, _text(_content(model, path), path))


def _text(content: dict[str, Any], path: Path) -> bytes:
    """JSON with a line for each block."""
    parts = []
    for key, value in content.items():
        if key == "blocks":
            blocks = ",\n  ".join(_dumps(block, path) for block in value)
            parts.append(f'"blocks": [\n  {blocks}\n ]')
        elif value is not None:
            parts.append(f'"{key}": {_dumps(value, path)}')
    return utf8("{\n " + ",\n ".join(parts) + "\n}\n")


def _content(model: Contents, path: Path) -> dict[str, Any]:
    """A model as plain values."""
    assembly, contacts = model.assembly, model.contacts
    loads = list(model.loads)
    results = []
    for result in model.results:
        if result.assembly is not assembly or result.contacts is not contacts:
            raise FormatError(
                "a result belongs to another assembly or to other contacts",
                where=str(path),
                remedy="write it to a file of its own",
            )
        if not any(load is result.load for load in loads):
            loads.append(result.load)
        position = next(i for i, load in enumerate(loads) if load is result.load)
        results.append(_result_content(result, position))
    return {
        "schema": SCHEMA,
        "version": VERSION,
        "units": "m",
        "blocks": [
            _block_content(block, bool(fixed))
            for block, fixed in zip(assembly.blocks, assembly.fixed, strict=True)
        ],
        "contacts": None if contacts is None else contacts_content(contacts),
        "detection": detection_content(model),
        "ends": model.ends,
        "loads": [_load_content(load) for load in loads] or None,
        "results": results or None,
    }


def detection_content(model: Contents) -> dict[str, Any] | None:
    """The tolerances with which the contacts were searched, where they differ from the defaults."""
    if model.contacts is None or model.detection is None:
        return None
    usual = vars(DetectionOptions())
    return {name: plain(one) for name, one in vars(model.detection).items() if one != usual[name]}


def contacts_content(contacts: Contacts, decimals: int | None = None) -> dict[str, Any]:
    """Contacts as plain values, rounded where so many ``decimals`` are enough."""
    content = {name: getattr(contacts, name) for name in CONTACTS}
    content |= {"rod": contacts.rod} if contacts.rod.any() else {}
    if contacts.capacity is not None:
        content |= {name: getattr(contacts.capacity, name) for name in DRY}
    if decimals is not None:
        content = {name: values.round(decimals) for name, values in content.items()}
    law = {} if contacts.capacity is None else {"brittle": contacts.capacity.brittle}
    return {name: values.tolist() for name, values in content.items()} | law


def _load_content(load: LoadCase) -> dict[str, Any]:
    content: dict[str, Any] = {"name": load.name, "wrench": load.wrench.tolist()}
    there = {
        "motion": load.motion is not None,
        "acceleration": load.acceleration.any(),
        "shake": load.shake.any(),
        "given": load.given is not None,
    }
    content |= {name: getattr(load, name).tolist() for name, some in there.items() if some}
    if load.notes:
        content["notes"] = list(load.notes)
    if load.masses:
        content["masses"] = [
            {name: plain.tolist() if name != "kind" else plain for name, plain in vars(one).items()}
            for one in load.masses
        ]
    if load.surface is not None:
        content["surface"] = {key: values.tolist() for key, values in vars(load.surface).items()}
    return content


def _block_content(block: Block, fixed: bool) -> dict[str, Any]:
    content: dict[str, Any] = {
        "name": block.name,
        "fixed": fixed,
        "density": block.density,
        "vertices": block.vertices.tolist(),
        "faces": block.faces,
    }
    if block.metadata:
        content["metadata"] = dict(block.metadata)
    if block.repairs:
        content["repairs"] = block.repairs
    return content


def _result_content(result: Result, load: int) -> dict[str, Any]:
    plainly = {name: plain(getattr(result, name)) for name in (*PLAIN, *TEXTS, *NUMBERS)}
    arrays = {name: getattr(result, name) for name in ARRAYS}
    return {
        **plainly,
        "load": load,
        **{name: values.tolist() for name, values in arrays.items() if values is not None},
        "sensitive_to": [one.name.lower() for one in result.sensitive_to],
    }


def _dumps(value: Any, path: Path, *, ascii: bool = False) -> str:
    try:
        return json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=ascii)
    except (TypeError, ValueError, RecursionError) as error:
        raise FormatError(
            f"something in the model is no JSON value: {error}",
            where=str(path),
            remedy="keep metadata to text, finite numbers, lists and objects",
        ) from error


_NAMESPACE = uuid.UUID("5f0d1c80-9f0c-5d7e-8a51-3c1b6a1b7c55")
"""Namespace of the identifiers that COMPAS needs. They are made from names, so the same model gives
the same file."""


def write_assembly(model: Contents, path: Path) -> None:
    """A compas_assembly ``Assembly``; a block's name becomes the key of its node."""
    write_bytes(path, _dumps(assembly_content(model), path, ascii=True).encode())


def write_block_model(model: Contents, path: Path) -> None:
    """A compas_dem ``BlockModel``; a block's name becomes the name of its element."""
    write_bytes(path, _dumps(block_model_content(model), path, ascii=True).encode())


def assembly_content(model: Contents) -> dict[str, Any]:
    """A model in the data structure of compas_assembly."""
    assembly = model.assembly
    keys = [_key(name) for name in assembly.names]
    nodes = {}
    for key, block, fixed in zip(keys, assembly.blocks, assembly.fixed.tolist(), strict=True):
        mesh = _mesh(block)
        mesh["attributes"] |= {"density": block.density, "node": None}
        nodes[repr(key)] = {
            "block": _object("compas_assembly.datastructures/Block", mesh, block.name),
            "is_support": fixed,
        }
    graph = {
        "attributes": {"name": "Graph", **_search(model)},
        "default_node_attributes": {"block": None, "is_support": False},
        "default_edge_attributes": {"interfaces": None},
        "node": nodes,
        "edge": _edges(model, [repr(key) for key in keys], "interfaces", _interface),
        "max_node": max([key for key in keys if isinstance(key, int)], default=-1),
    }
    data = {
        "attributes": {"name": "Assembly"},
        "graph": {"dtype": "compas.datastructures/Graph", "data": graph},
    }
    return _object("compas_assembly.datastructures/Assembly", data, "assembly")


def block_model_content(model: Contents) -> dict[str, Any]:
    """A model in the data structure of compas_dem; each density is a material."""
    assembly = model.assembly
    guids = [_guid("element", str(i), name) for i, name in enumerate(assembly.names)]
    materials = {
        density: _object(
            "compas_dem.material/Stone",
            {
                "name": f"{density:g} kg/m3",
                "density": density,
                "poisson": 0.2,
                "fck": None,
                "ft": None,
                "Ecm": None,
            },
            repr(density),
        )
        for density in sorted({block.density for block in assembly.blocks})
    }
    elements = {}
    for guid, block, fixed in zip(guids, assembly.blocks, assembly.fixed.tolist(), strict=True):
        data = {
            "name": block.name,
            "transformation": None,
            "features": [],
            "material": materials[block.density]["guid"],
            "geometry": _object("compas.datastructures/Mesh", _mesh(block), block.name),
            "is_support": fixed,
        }
        elements[guid] = {
            "dtype": "compas_dem.elements/Block",
            "guid": guid,
            "name": block.name,
            "data": data,
        }
    nodes = [str(i) for i in range(len(assembly))]
    graph = {
        "attributes": _search(model),
        "default_node_attributes": {"element": None},
        "default_edge_attributes": {"modifiers": None, "contacts": None},
        "node": {node: {"element": guid} for node, guid in zip(nodes, guids, strict=True)},
        "edge": _edges(model, nodes, "contacts", _friction_contact),
        "max_node": len(nodes) - 1,
    }
    children = [{"name": "ElementNode", "element": guid} for guid in guids]
    data = {
        "transformation": None,
        "elements": elements,
        "materials": {material["guid"]: material for material in materials.values()},
        "tree": {"attributes": {}, "root": {"name": "root", "children": children}},
        "graph": graph,
    }
    return _object("compas_dem.models/BlockModel", data, "model")


def _search(model: Contents) -> dict[str, Any]:
    """How the contacts were searched, as an attribute of the graph that COMPAS keeps."""
    content = detection_content(model)
    return {} if content is None else {SEARCH: content}


def _guid(*parts: str) -> str:
    return str(uuid.uuid5(_NAMESPACE, utf8("/".join(parts)).decode()))


def _object(dtype: str, data: dict[str, Any], name: str) -> dict[str, Any]:
    return {"dtype": dtype, "data": data, "guid": _guid(dtype, name)}


def _key(name: str) -> int | str:
    """An integer where the name is one: compas_assembly numbers its nodes."""
    return int(name) if name.isascii() and name.isdigit() and str(int(name)) == name else name


def _mesh(block: Block) -> dict[str, Any]:
    return {
        "attributes": {"name": block.name},
        "default_vertex_attributes": {"x": 0.0, "y": 0.0, "z": 0.0},
        "default_edge_attributes": {},
        "default_face_attributes": {},
        "vertex": {
            str(i): {"x": x, "y": y, "z": z} for i, (x, y, z) in enumerate(block.vertices.tolist())
        },
        "face": {str(i): list(face) for i, face in enumerate(block.faces)},
        "facedata": {},
        "edgedata": {},
        "max_vertex": len(block.vertices) - 1,
        "max_face": len(block.faces) - 1,
    }


def _edges(model: Contents, nodes: Sequence[str], key: str, make: Any) -> dict[str, Any]:
    """Edges of the graph, each with the converted interfaces of its two blocks."""
    edges: dict[str, dict[str, Any]] = {node: {} for node in nodes}
    contacts = model.contacts
    if contacts is None:
        return edges
    result = model.results[0] if model.results else None
    seen: dict[tuple[int, int], list[Any]] = {}
    for i, (a, b) in enumerate(
        zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
    ):
        turned = (b, a) in seen  # COMPAS keeps one edge per pair, in one direction
        pair = (b, a) if turned else (a, b)
        seen.setdefault(pair, []).append(make(contacts, i, turned, _forces(result, i, turned)))
    for (a, b), made in seen.items():
        edges[nodes[a]][nodes[b]] = {key: made}
    return edges


def _forces(result: Result | None, interface: int, turned: bool) -> list[dict[str, float]]:
    """Corner forces [N] with the names of COMPAS: compression, tension, along the x and y axes."""
    if result is None or result.force is None:
        return []
    start = result.contacts.start
    force = result.force[start[interface] : start[interface + 1]]
    if turned:  # seen from the other block: n and v reverse with the frame, and so does the force
        force = (force * np.array([1.0, -1.0, 1.0]))[::-1]
    return [
        {"c_np": max(n, 0.0), "c_nn": max(-n, 0.0), "c_u": u, "c_v": v}
        for n, u, v in force.tolist()
    ]


def _placed(contacts: Contacts, interface: int, turned: bool) -> tuple[Any, dict[str, Any]]:
    """Corners and frame of an interface; seen from the other block when turned."""
    points = contacts.polygon(interface)
    _, u, v = contacts.frame[interface]
    if turned:
        points, v = points[::-1], -v
    frame = {
        "point": contacts.centroid[interface].tolist(),
        "xaxis": u.tolist(),
        "yaxis": v.tolist(),
    }
    return points.tolist(), {"dtype": "compas.geometry/Frame", "data": frame}


def _interface(contacts: Contacts, i: int, turned: bool, forces: list[Any]) -> dict[str, Any]:
    points, frame = _placed(contacts, i, turned)
    data = {
        "points": points,
        "frame": frame,
        "size": float(contacts.area[i]),
        "forces": forces or None,
        "mesh": None,
    }
    return _object("compas_assembly.datastructures/Interface", data, str(i))


def _friction_contact(
    contacts: Contacts, i: int, turned: bool, forces: list[Any]
) -> dict[str, Any]:
    points, frame = _placed(contacts, i, turned)
    data = {
        "points": [{"dtype": "compas.geometry/Point", "data": point} for point in points],
        "name": "FrictionContact",
        "frame": frame,
        "size": float(contacts.area[i]),
        "mesh": None,
        "holes": None,
        "forces": forces,
    }
    return _object("compas_dem.interactions/FrictionContact", data, str(i))


def read(data: bytes, path: Path) -> Draft:
    """The draft of any of the JSON formats."""
    top = jsontext.parse(data, path)
    if bricks.is_list(top):
        return bricks.from_json(top)
    return compas_json.read(top) if compas_json.is_compas(top) else drystone_json.read(top)
