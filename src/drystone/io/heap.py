"""Formats without blocks: one heap of faces becomes one shape per solid."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drystone.errors import FormatError
from drystone.geometry import coincidence, soup
from drystone.geometry.arrays import Floats
from drystone.geometry.merge import merge_coplanar
from drystone.geometry.polyhedron import Loop, edge_defects
from drystone.io.draft import Shape

FARTHEST = 1e100
"""In any unit, chosen: products of coordinates stay finite."""
MANY = 5
"""Names told of in notes."""


def shapes_of(
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    where: str,
    tolerance: float,
    stem: str,
    *,
    split: bool = True,
) -> tuple[list[Shape], list[str]]:
    """A shape for each solid in a heap of faces, and what was done to find them.

    Vertices that coincide become one, faces without area go, solids are told apart, and coplanar
    neighbours are merged into polygons.

    Parameters
    ----------
    vertices : (v, 3)
    faces
    where
        The file, for errors.
    tolerance
        Distance that counts as none, relative to the extent of all vertices.
    stem
        The solids are called ``stem-0``, ``stem-1``; a single one ``stem``.
    split
        Otherwise everything is one shape.
    """
    usable = (np.abs(vertices) <= FARTHEST).all(axis=1)
    if not usable.all():
        bad = int(np.flatnonzero(~usable)[0])
        what = "far too large" if np.isfinite(vertices[bad]).all() else "not finite"
        raise FormatError(f"vertex {bad} is {what}", where=where, remedy="give finite numbers")
    if len(faces) == 0 or len(vertices) == 0:
        raise FormatError("holds no faces", where=where, remedy="export the blocks as meshes")
    welded, merged = coincidence.weld(vertices, faces, tolerance)
    loops = [loop for loop in welded if len(set(loop)) == len(loop)]
    kept, slivers = soup.without_slivers(vertices, loops, tolerance)
    if not kept:
        raise FormatError("has no face with an area", where=where, remedy="export it again")
    notes = []
    if merged:
        notes.append(f"{merged} coincident vertices merged")
    if len(faces) > len(loops) or slivers:
        notes.append(f"{len(faces) - len(loops) + slivers} faces without area left out")
    solids = soup.split_solids(vertices, kept) if split else [list(range(len(kept)))]
    if len(solids) > 1:
        notes.append(f"one heap of faces split into {len(solids)} solids")
    bodies = [_own_vertices(vertices, [kept[i] for i in solid]) for solid in solids]
    closed = [edge_defects(loops) == ([], [], True) for _, loops in bodies]
    polygons = iter(
        merge_coplanar(
            [points for (points, _), good in zip(bodies, closed, strict=True) if good],
            [loops for (_, loops), good in zip(bodies, closed, strict=True) if good],
            tolerance,
        )
    )
    shapes = []
    for number, (solid, (points, own), good) in enumerate(zip(solids, bodies, closed, strict=True)):
        name = stem if len(solids) == 1 else f"{stem}-{number}"
        shapes.append(Shape(name, points, next(polygons) if good else own, f"face {solid[0]}"))
    return shapes, notes


def moved(vertices: Floats, matrix: Floats) -> tuple[Floats, bool]:
    """Vertices (v, 3) moved by a matrix (4, 4), and whether that mirrors them.

    What overflows becomes infinite or NaN, which the caller refuses with the name of the block.
    """
    with np.errstate(all="ignore"):
        placed = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        return placed, bool(np.linalg.det(matrix[:3, :3]) < 0.0)


def _own_vertices(vertices: Floats, loops: Sequence[Loop]) -> tuple[Floats, list[Loop]]:
    """Only the vertices that the loops use, in their order."""
    used = sorted({corner for loop in loops for corner in loop})
    position = {corner: i for i, corner in enumerate(used)}
    return vertices[used], [tuple(position[corner] for corner in loop) for loop in loops]


def shape_of(vertices: Floats, loops: Sequence[Loop], name: str, where: str) -> Shape:
    """A shape with only the vertices that its faces use, in their order."""
    return Shape(name, *_own_vertices(vertices, loops), where)


def named_apart(shapes: Sequence[Shape]) -> tuple[list[Shape], list[str]]:
    """Shapes with a number behind names that several have, for formats in which that is usual."""
    count = Counter(shape.name for shape in shapes)
    taken = set(count)
    number: Counter[str] = Counter()
    named = []
    for shape in shapes:
        name = shape.name
        if count[name] > 1:
            while f"{name}-{number[name]}" in taken:
                number[name] += 1
            taken.add(f"{name}-{number[name]}")
            named.append(replace(shape, name=f"{name}-{number[name]}"))
        else:
            named.append(shape)
    often = [name for name, times in count.items() if times > 1]
    notes = [f"{count[name]} blocks are called '{name}': numbered" for name in often[:MANY]]
    if len(often) > MANY:
        notes.append(f"and {len(often) - MANY} more names that several blocks have")
    return named, notes
