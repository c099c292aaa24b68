"""Plane faces with holes, converted to faces without holes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.polygon import area_vector
from drystone.geometry.polyhedron import Loop


def faces_with_holes(vertices: Floats, faces: Sequence[Sequence[Loop]]) -> list[Loop]:
    """Faces as simple loops: a face with holes becomes triangles between the same vertices.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Per face its outline (counter-clockwise from outside), then its holes (clockwise).

    Raises
    ------
    InputError
        The holes of a face do not lie inside it.

    Examples
    --------
    >>> ring = [[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0], [1, 1, 0], [1, 2, 0], [2, 2, 0]]
    >>> len(faces_with_holes(np.array(ring, dtype=float), [[(0, 1, 2, 3), (4, 5, 6)]]))
    7
    """
    simple: list[Loop] = []
    for number, (outline, *holes) in enumerate(faces):
        if holes:
            simple += _triangles(vertices, outline, holes, number)
        else:
            simple.append(tuple(outline))
    return simple


def _triangles(vertices: Floats, outline: Loop, holes: Sequence[Loop], number: int) -> list[Loop]:
    corners = np.array([*outline, *(corner for hole in holes for corner in hole)], dtype=np.intp)
    area = area_vector(vertices[list(outline)])
    length = float(np.linalg.norm(area))
    if length == 0.0:
        raise InputError(f"face {number} has no area")
    _, u, v = frames_from_normals((area / length)[None])[0]
    flat = np.stack([vertices @ u, vertices @ v], axis=1)
    region = shapely.Polygon(flat[list(outline)], [flat[list(hole)] for hole in holes])
    if not region.is_valid:
        raise InputError(
            f"face {number} has holes that do not lie inside it", remedy="model the face again"
        )
    known = {tuple(flat[i].tolist()): int(i) for i in corners}
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(region))
    loops: list[Loop] = []
    for triangle in shapely.orient_polygons(triangles):
        ring = shapely.get_coordinates(triangle)[:3].tolist()
        loops.append(tuple(known[tuple(point)] for point in ring))
    return loops
