"""Formats without blocks: one heap of faces becomes one shape per solid."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drystone.base.arrays import FARTHEST, Floats, Ints
from drystone.base.errors import FormatError, counted
from drystone.geometry.body.polyhedron import Loop, edge_defects
from drystone.geometry.mend import coincidence, soup
from drystone.geometry.mend.merge import merge_coplanar
from drystone.io.draft import Shape

MANY = 5
"""Names told of in notes."""


@dataclass(frozen=True)
class Heap:
    """Faces that belong to one or more solids.

    Attributes
    ----------
    vertices : (v, 3)
    faces
    name
        Of its solid; with a number behind it where there are several.
    where
        Its place in the file, for errors; empty where it is all there is.
    split
        Otherwise all its faces are one shape.
    """

    vertices: Floats
    faces: Sequence[Sequence[int]]
    name: str
    where: str
    split: bool = True


def shapes_of(
    heaps: Sequence[Heap], tolerance: float, path: Path, *, shared: bool = True
) -> tuple[list[Shape], list[str]]:
    """A shape for each solid in heaps of faces, and what was done to find them.

    Vertices that coincide become one, faces without area go, solids are told apart, and coplanar
    neighbours are merged into polygons.

    Parameters
    ----------
    heaps
    tolerance
        Distance that counts as none, relative to the extent of a heap.
    path
        The file, for errors.
    shared
        Whether faces of the format share their vertices; where not, merging them is no news.

    Raises
    ------
    FormatError
        A heap has no face with an area, or a vertex that is not finite.
    """
    if not heaps:
        return [], []
    reach = np.array([tolerance * _extent(heap, path) for heap in heaps])
    count = np.array([len(heap.vertices) for heap in heaps])
    owner = np.repeat(np.arange(len(heaps)), count)
    vertices = np.concatenate([heap.vertices for heap in heaps])
    first = coincidence.first_coincident(vertices, reach[owner], owner).tolist()
    offset = (np.cumsum(count) - count).tolist()
    loops: list[Loop] = []
    of_loop: list[int] = []
    for number, heap in enumerate(heaps):
        for face in heap.faces:
            loop = tuple(dict.fromkeys(first[i + offset[number]] for i in face))
            if len(loop) >= 3:
                loops.append(loop)
                of_loop.append(number)
    loops, kept = soup.without_slivers(vertices, loops, reach[owner])
    home = np.array(of_loop, dtype=np.intp)[kept]
    missing = np.flatnonzero(np.bincount(home, minlength=len(heaps)) == 0)
    if len(missing):
        where = _place(heaps[missing[0]], path)
        raise FormatError("has no face with an area", where=where, remedy="export it again")
    solids = _per_heap(soup.split_solids(vertices, loops, home), home, heaps)
    gone = sum(len(heap.faces) for heap in heaps) - len(loops)
    merged = len(vertices) - len(set(first)) if shared else 0
    return _shapes(vertices, loops, solids, heaps, tolerance), _notes(merged, gone, solids)


def _place(heap: Heap, path: Path) -> str:
    return f"{path}, {heap.where}" if heap.where else str(path)


def _extent(heap: Heap, path: Path) -> float:
    """Diagonal of a heap whose numbers can be used."""
    usable = (np.abs(heap.vertices) <= FARTHEST).all(axis=1)
    if not usable.all():
        bad = int(np.flatnonzero(~usable)[0])
        what = "far too large" if np.isfinite(heap.vertices[bad]).all() else "not finite"
        raise FormatError(
            f"vertex {bad} is {what}", where=_place(heap, path), remedy="give finite numbers"
        )
    if len(heap.faces) == 0 or len(heap.vertices) == 0:
        raise FormatError(
            "holds no faces", where=_place(heap, path), remedy="export the blocks as meshes"
        )
    return float(np.linalg.norm(heap.vertices.max(axis=0) - heap.vertices.min(axis=0)))


def _per_heap(solids: list[list[int]], home: Ints, heaps: Sequence[Heap]) -> list[list[list[int]]]:
    """Solids (lists of faces) of each heap."""
    grouped: list[list[list[int]]] = [[] for _ in heaps]
    for solid in solids:
        grouped[int(home[solid[0]])].append(solid)
    return [
        found if heap.split else [sorted(face for solid in found for face in solid)]
        for found, heap in zip(grouped, heaps, strict=True)
    ]


def _shapes(
    vertices: Floats,
    loops: Sequence[Loop],
    solids: Sequence[Sequence[Sequence[int]]],
    heaps: Sequence[Heap],
    tolerance: float,
) -> list[Shape]:
    made: list[Shape] = []
    own: list[list[Loop]] = []
    for found, heap in zip(solids, heaps, strict=True):
        for number, solid in enumerate(found):
            name = heap.name if len(found) == 1 else f"{heap.name}-{number}"
            points, faces = _own_vertices(vertices, [loops[i] for i in solid])
            made.append(Shape(name, points, faces, heap.where))
            own.append(faces)
    closed = [i for i, faces in enumerate(own) if edge_defects(faces) == ([], [], True)]
    polygons = merge_coplanar(
        [made[i].vertices for i in closed], [own[i] for i in closed], tolerance
    )
    for i, merged in zip(closed, polygons, strict=True):
        made[i] = replace(made[i], faces=merged)
    return made


def _notes(merged: int, gone: int, solids: Sequence[Sequence[Any]]) -> list[str]:
    notes = []
    if merged:
        notes.append(f"{counted(merged, 'coincident vertex', 'coincident vertices')} merged")
    if gone:
        notes.append(f"{counted(gone, 'face')} without area left out")
    several = [i for i, found in enumerate(solids) if len(found) > 1]
    if several:
        parts = sum(len(solids[i]) for i in several)
        what = "one heap of faces" if len(several) == 1 else f"{len(several)} heaps of faces"
        notes.append(f"{what} split into {parts} solids")
    return notes


def in_double(values: np.ndarray[Any, Any]) -> Floats:
    """Numbers of a file as float64; what is not a number there is found where it is used."""
    with np.errstate(invalid="ignore"):  # a signalling NaN
        return values.astype(np.float64)


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
