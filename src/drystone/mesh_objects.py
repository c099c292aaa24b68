"""Blocks from and to the mesh objects of other packages: trimesh, pyvista and COMPAS.

Given ones are recognised by the attributes that their packages document; no package is imported
before its objects are made.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.assembly import Assembly, Block, replace_block
from drystone.base.arrays import SAME, Floats, Ints
from drystone.base.errors import InputError, quoted, require
from drystone.geometry.halfedge import merge_coplanar
from drystone.geometry.triangulate import triangulate
from drystone.repair import mended_block

if TYPE_CHECKING:
    import pyvista
    import trimesh


def assembly_of(given: Any) -> Assembly:
    """An assembly as it is, or one block for each mesh of a scene or a list.

    Parameters
    ----------
    given
        An assembly; a mesh: ``Trimesh``, ``PolyData``, ``Mesh`` of COMPAS; a ``Scene`` of trimesh,
        a ``MultiBlock`` of pyvista; or a list of meshes. No block is fixed; lengths are in metres.

    Raises
    ------
    InputError
        Another type, no mesh, or a mesh that is no block: its name is told.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> from drystone.models import box
    >>> cube = box((1.0, 1.0, 1.0))
    >>> mesh = SimpleNamespace(vertices=cube.vertices, faces=cube.faces)
    >>> assembly_of([mesh]).names
    ('block-0',)
    """
    if isinstance(given, Assembly):
        return given
    blocks: list[Block] = []
    taken: set[str] = set()
    for name, points, faces in _meshes(given, ""):
        own = name or f"block-{len(blocks)}"
        if own in taken:
            own = f"{own}-{len(blocks)}"
        taken.add(own)
        block = mended_block(points, faces, own)
        loops = merge_coplanar([block.vertices], [block.faces], SAME)[0]
        merged = replace_block(block, faces=tuple(loops))
        blocks.append(replace_block(merged, repairs=block.repairs))  # corners inside faces go
    if not blocks:
        raise InputError("holds no mesh", where=type(given).__name__, remedy="give closed meshes")
    return Assembly(tuple(blocks), np.zeros(len(blocks), dtype=bool))


def to_trimesh(assembly: Assembly) -> trimesh.Scene:
    """A scene of trimesh with a mesh of triangles [m] for each block, by its name.

    Raises
    ------
    MissingDependency
        trimesh is not installed.
    """
    require("trimesh", "meshes", "a scene of trimesh")
    import trimesh  # optional: only for those who ask for it

    scene = trimesh.Scene()
    for block, triangle in _triangles(assembly):
        mesh = trimesh.Trimesh(block.vertices, triangle, process=False)
        scene.add_geometry(mesh, node_name=block.name, geom_name=block.name)
    return scene


def to_pyvista(assembly: Assembly) -> pyvista.MultiBlock:
    """A ``MultiBlock`` of pyvista with a mesh of triangles [m] for each block, by its name.

    Raises
    ------
    MissingDependency
        pyvista is not installed.
    """
    require("pyvista", "meshes", "meshes of pyvista")
    import pyvista  # as above

    meshes = pyvista.MultiBlock()
    for block, triangle in _triangles(assembly):
        loops: Any = triangle  # one of the types of its own arrays
        meshes[block.name] = pyvista.PolyData.from_regular_faces(np.array(block.vertices), loops)
    return meshes


def _triangles(assembly: Assembly) -> Iterator[tuple[Block, Ints]]:
    """Each block with triangles (t, 3) of its vertices."""
    faces = assembly.faces
    triangle, face = triangulate(faces.point[faces.loop], faces.start)
    first = np.cumsum([0, *(len(block.vertices) for block in assembly.blocks)])
    owner = faces.owner[face]
    for i, block in enumerate(assembly.blocks):
        yield block, faces.loop[triangle[owner == i]] - first[i]


def _meshes(given: Any, name: str) -> Iterator[tuple[str, Floats, list[Sequence[int]]]]:
    """Name, vertices (v, 3) and faces of each mesh in an object."""
    if hasattr(given, "to_vertices_and_faces"):
        points, faces = given.to_vertices_and_faces()
        yield name or _own_name(given), np.array(points, dtype=np.float64), list(faces)
    elif hasattr(given, "graph") and hasattr(given, "geometry"):
        for node in given.graph.nodes_geometry:
            matrix, key = given.graph[node]
            mesh = given.geometry[key]
            if hasattr(mesh, "faces"):
                copy = mesh.copy()
                copy.apply_transform(matrix)  # turns its faces where the matrix mirrors
                yield from _meshes(copy, str(node))
    elif hasattr(given, "regular_faces") or hasattr(given, "irregular_faces"):
        yield name, np.array(given.points, dtype=np.float64), _padded(given.faces)
    elif hasattr(given, "vertices") and hasattr(given, "faces"):
        faces = [tuple(int(corner) for corner in face) for face in given.faces]
        yield name, np.array(given.vertices, dtype=np.float64), faces
    elif hasattr(given, "keys") and hasattr(given, "n_blocks"):
        for key in given.keys():  # noqa: SIM118  # iterating gives the blocks
            yield from _meshes(given[key], str(key or ""))
    elif np.iterable(given) and not isinstance(given, str | bytes | dict):
        for one in given:
            yield from _meshes(one, "")
    else:
        raise InputError(
            f"{quoted(given)} cannot be analysed",
            remedy="give a Model, an Assembly or the path of a file, or meshes of trimesh, pyvista "
            "or COMPAS",
        )


def _own_name(mesh: Any) -> str:
    """The name of a COMPAS mesh, where it is more than that of its class."""
    name = str(getattr(mesh, "name", "") or "")
    return "" if name == type(mesh).__name__ else name


def _padded(faces: Any) -> list[Sequence[int]]:
    """Loops of an array in which each is preceded by its number of corners."""
    values, at, loops = np.asarray(faces).tolist(), 0, []
    while at < len(values):
        loops.append(values[at + 1 : at + 1 + values[at]])
        at += 1 + values[at]
    return loops
