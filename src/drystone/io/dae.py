"""DAE (COLLADA): nodes of a scene that show geometries.

Source: Khronos Group, COLLADA 1.4.1 and 1.5 Specification. A node with a geometry is a block; faces
are triangles, polygons or lists of these. The file says its unit and which axis is up.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import ChainMap
from collections.abc import Iterator, MutableMapping, Sequence
from functools import cache
from itertools import accumulate, pairwise
from pathlib import Path
from typing import TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.base.arrays import SAME, Floats
from drystone.base.errors import FormatError
from drystone.base.units import UNITS
from drystone.geometry.polyhedron import Loop
from drystone.io.draft import Draft, FaceSoup, moved, named_apart, shapes_of
from drystone.io.glb import Z_UP
from drystone.io.outside import Unfolded, unfold
from drystone.io.xml_tree import numbers, root_of

_Mesh: TypeAlias = tuple[Floats, list[Loop]]

_UP = {
    "X_UP": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
    "Y_UP": Z_UP,
    "Z_UP": np.eye(3),
}
"""Rotations to z up."""
_MOVES = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3}
"""Numbers of each transformation."""
_FACES = ("triangles", "polylist", "polygons", "trifans", "tristrips")


def read(data: bytes, path: Path) -> Draft:
    """Blocks of a DAE file: the nodes of its scene with a geometry."""
    root = root_of(data, path, "COLLADA", "COLLADA")
    named = {one.get("id", ""): one for one in root.iter() if one.get("id")}
    turn, units = _axes_and_units(root, path)
    known: dict[str, _Mesh] = {}
    soups = []
    unfolded = Unfolded(path)
    for name, url, matrix in _shown(root, named, path):
        if url in known:
            unfolded.take(len(known[url][0]), len(known[url][1]))
        else:
            where = f"{path}, geometry '{url[:40]}'"
            known[url] = _mesh(named.get(url), named, where, unfolded)
        points, faces = known[url]
        if not faces:
            continue
        placed, loops = moved(points, faces, matrix)
        with np.errstate(all="ignore"):  # overflow is found with the vertices
            upright = placed @ turn.T
        soups.append(FaceSoup(upright, loops, name, f"node '{name[:40]}'"))
    if not soups:
        raise FormatError(
            "shows no mesh", where=str(path), remedy="export the blocks as meshes in a scene"
        )
    shapes, notes = shapes_of(soups, SAME, path)
    shapes, renamed = named_apart(shapes)
    return Draft(tuple(shapes), units, notes=(*notes, *renamed))


def _axes_and_units(root: ET.Element, path: Path) -> tuple[Floats, str]:
    """The rotation (3, 3) to z up, and the unit of length."""
    up = (root.findtext("asset/up_axis") or "Y_UP").strip()
    if up not in _UP:
        raise FormatError(f"its up axis is '{up[:40]}'", where=str(path), remedy="export z up")
    unit = root.find("asset/unit")
    told = {} if unit is None else unit.attrib
    meter = float(numbers(told, "meter", 1, np.ones(1), str(path))[0])
    for name, size in UNITS.items():
        if abs(size - meter) < 1e-9 * size:
            return _UP[up], name
    raise FormatError(
        f"its unit is {meter:g} m", where=str(path), remedy=f"export in {', '.join(UNITS)}"
    )


def _shown(
    root: ET.Element, named: dict[str, ET.Element], path: Path
) -> Iterator[tuple[str, str, Floats]]:
    """Name, geometry and matrix (4, 4) of the nodes of the scene that show one."""

    def inside(placed: tuple[ET.Element, Floats]) -> Iterator[tuple[ET.Element, Floats]]:
        node, matrix = placed
        inner = [named.get(_of(one)) for one in node.findall("instance_node")]
        for one in (*node.findall("node"), *inner):
            if one is not None:
                with np.errstate(all="ignore"):  # overflow is found with the vertices
                    yield one, matrix @ _matrix(one, path)

    roots = [(node, _matrix(node, path)) for node in _roots(root, named)]
    nodes = unfold(roots, inside, path, things="nodes", name=lambda one: _told(one[0]))
    for number, (node, matrix) in enumerate(nodes):
        for one in node.findall("instance_geometry"):
            yield node.get("name") or node.get("id") or f"block-{number}", _of(one), matrix


def _told(node: ET.Element) -> str:
    """What to call a node in errors."""
    return f"node '{(node.get('name') or node.get('id') or '')[:40]}'"


def _roots(root: ET.Element, named: dict[str, ET.Element]) -> list[ET.Element]:
    """The nodes of the scene that the file shows, else of its first one."""
    instance = root.find("scene/instance_visual_scene")
    first = root.find("library_visual_scenes/visual_scene")
    scene = first if instance is None else named.get(_of(instance))
    return [] if scene is None else scene.findall("node")


def _of(instance: ET.Element) -> str:
    return instance.get("url", "").removeprefix("#")


def _matrix(node: ET.Element, path: Path) -> Floats:
    """The product of the transformations of a node, in their order."""
    matrix, where = np.eye(4), f"{path}, {_told(node)}"
    for one in node:
        size = _MOVES.get(one.tag)
        if size is None:
            continue
        values = numbers({one.tag: one.text or ""}, one.tag, size, None, where)
        step = np.eye(4)
        if one.tag == "matrix":
            step = values.reshape(4, 4)
        elif one.tag == "translate":
            step[:3, 3] = values
        elif one.tag == "scale":
            step[:3, :3] = np.diag(values)
        elif values[:3].any():
            axis = values[:3] / np.linalg.norm(values[:3])
            step[:3, :3] = Rotation.from_rotvec(np.deg2rad(values[3]) * axis).as_matrix()
        matrix = matrix @ step
    return matrix


def _mesh(
    geometry: ET.Element | None,
    named: MutableMapping[str, ET.Element],
    where: str,
    unfolded: Unfolded,
) -> _Mesh:
    """Vertices (v, 3) and faces of a geometry."""
    mesh = None if geometry is None else geometry.find("mesh")
    if mesh is None:
        raise FormatError("is no mesh", where=where, remedy="export meshes in place of surfaces")
    # some programs use the same names in every geometry
    named = ChainMap({one.get("id", ""): one for one in mesh.iter() if one.get("id")}, named)
    points: list[Floats] = []
    loops: list[Loop] = []
    read = cache(lambda shared: _positions(shared, named, where))
    for part in mesh:
        if part.tag not in _FACES:
            continue  # lines bound no body
        inputs = {one.get("semantic", ""): one for one in part.findall("input")}
        shared = named.get(_source(inputs.get("VERTEX")))
        if shared is None:
            raise FormatError("has faces without vertices", where=where, remedy="export it again")
        first = sum(map(len, points))
        points.append(read(shared))
        offset = [_whole([one.get("offset", "0")], where)[0] for one in part.findall("input")]
        stride, own = max(offset) + 1, offset[[*part.findall("input")].index(inputs["VERTEX"])]
        unfolded.take(len(points[-1]), 0)
        for face in _faces(part, stride, own, where):
            if not all(0 <= corner < len(points[-1]) for corner in face):
                raise FormatError("has a vertex that does not exist", where=where)
            unfolded.take(0, 1)
            loops.append(tuple(first + corner for corner in face))
    return np.concatenate([np.zeros((0, 3)), *points]), loops


def _source(given: ET.Element | None) -> str:
    return "" if given is None else given.get("source", "").removeprefix("#")


def _whole(words: Sequence[str], where: str) -> list[int]:
    if not all(word.isascii() and word.isdecimal() and len(word) < 10 for word in words):
        raise FormatError("has a corner that is no number", where=where, remedy="export it again")
    return [int(word) for word in words]


def _positions(shared: ET.Element, named: MutableMapping[str, ET.Element], where: str) -> Floats:
    """Vertices (v, 3) of a list of them."""
    given = {one.get("semantic", ""): one for one in shared.findall("input")}
    source = named.get(_source(given.get("POSITION")))
    array = None if source is None else source.find("float_array")
    accessor = None if source is None else source.find("technique_common/accessor")
    if array is None or accessor is None:
        raise FormatError("has no positions", where=where, remedy="export it again")
    values = numbers({"positions": array.text or ""}, "positions", None, None, where)
    stride = _whole([accessor.get("stride", "1")], where)[0]
    if stride < 3 or len(values) % stride:
        raise FormatError("has positions that are no points", where=where)
    return values.reshape(-1, stride)[:, :3]


def _faces(part: ET.Element, stride: int, own: int, where: str) -> Iterator[list[int]]:
    """Corners of each face of triangles, polygons, fans or strips."""
    if part.find("ph") is not None:
        raise FormatError("has faces with holes", where=where, remedy="export triangles")
    for listed in part.findall("p"):
        corner = _whole((listed.text or "").split(), where)[own::stride]
        if part.tag == "triangles":
            yield from (corner[i : i + 3] for i in range(0, len(corner), 3))
        elif part.tag == "polylist":
            count = _whole((part.findtext("vcount") or "").split(), where)
            yield from (corner[a:b] for a, b in pairwise(accumulate([0, *count])))
        elif part.tag == "polygons":
            yield corner
        elif part.tag == "trifans":
            yield from ([corner[0], *corner[i : i + 2]] for i in range(1, len(corner) - 1))
        else:
            turns = (corner[i : i + 3] for i in range(len(corner) - 2))
            yield from (one[::-1] if i % 2 else one for i, one in enumerate(turns))
