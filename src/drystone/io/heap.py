"""Formats without blocks: one heap of faces becomes one shape per solid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.errors import FormatError
from drystone.geometry import coincidence, soup
from drystone.geometry.arrays import Floats
from drystone.geometry.polyhedron import Loop
from drystone.io.draft import Shape


def shapes_of(
    vertices: Floats, faces: Sequence[Sequence[int]], where: str, tolerance: float, stem: str
) -> tuple[list[Shape], list[str]]:
    """A shape for each solid in a heap of faces, and what was done to find them.

    Parameters
    ----------
    vertices : (v, 3)
    faces
    where
        The file, for errors.
    tolerance
        Vertices nearer than this share of the extent of all are one, and triangles of no greater
        height are slivers.
    stem
        The solids are called ``stem-0``, ``stem-1``; a single one ``stem``.
    """
    if not np.isfinite(vertices).all():
        bad = int(np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0])
        raise FormatError(f"vertex {bad} is not finite", where=where, remedy="give finite numbers")
    if len(faces) == 0:
        raise FormatError("holds no faces", where=where, remedy="export the blocks as meshes")
    welded, merged = coincidence.weld(vertices, faces, tolerance)
    loops = [loop for loop in welded if len(set(loop)) == len(loop)]
    kept, slivers = soup.without_slivers(vertices, loops, tolerance)
    notes = []
    if merged:
        notes.append(f"{merged} coincident vertices merged")
    gone = len(faces) - len(loops) + slivers
    if gone:
        notes.append(f"{gone} faces without area left out")
    solids = soup.split_solids(vertices, kept)
    if len(solids) > 1:
        notes.append(f"one heap of faces split into {len(solids)} solids")
    shapes = []
    for number, solid in enumerate(solids):
        name = stem if len(solids) == 1 else f"{stem}-{number}"
        shapes.append(shape_of(vertices, [kept[i] for i in solid], name, f"face {solid[0]}"))
    return shapes, notes


def shape_of(vertices: Floats, loops: Sequence[Loop], name: str, where: str) -> Shape:
    """A shape with only the vertices that its faces use, in their order."""
    used = sorted({corner for loop in loops for corner in loop})
    position = {corner: i for i, corner in enumerate(used)}
    faces = [[position[corner] for corner in loop] for loop in loops]
    return Shape(name, vertices[used], faces, where=where)
