"""Faces as chords of a curved surface: their distance from it, and the sign of its curvature."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, dot
from drystone.base.ragged import sum_by_owner
from drystone.geometry.halfedge import NOISE, SMOOTH, HalfEdges
from drystone.geometry.polyhedron import Faces

_FACETED = np.deg2rad(50.0)
"""[rad] The same for triangles, whose edges cross the curve in any direction. Chosen: above the 42
degrees between the faces of an icosahedron."""


def curvature(
    faces: Faces, edges: HalfEdges, turn: Floats, group: Ints, area: Floats, triangle: Bools
) -> tuple[Floats, Floats, Bools, Bools]:
    """The surface that each patch approximates, from the turning angles (h,) [rad] at half-edges.

    A strip of width w with the angle t to its neighbours is a chord of a curve. Its sag is w t / 8
    and its angle to the curve at its edges t / 2. The narrower of two neighbours gives w, so a
    chamfer does not make a large face curved. Two triangles may form a warped quadrilateral, and
    the other side of the joint may be cut along the other diagonal. Then the distance in the middle
    is w t, half of it for each side, with w the mean width of the triangle. The angle between the
    sides is that between the facets at a corner and their mean.

    Parameters
    ----------
    group : (f,) patch of each face
    area : (p,) [m2]
    triangle : (p,) bool

    Returns
    -------
    sag : (p,) [m], distance of the patch from the surface
    bend : (p,) [rad], angle between them
    bulges, hollow : (p,) bool
        Whether the surface is convex, or concave, at the patch or at a neighbour of it.
    """
    count = len(area)
    sag, bend = np.zeros(count), np.zeros(count)
    bulges, hollow = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    border = group[edges.face] != group[edges.face[edges.twin]]
    curved = _across_curves(edges, turn, group, triangle)
    smooth = np.flatnonzero(border & curved)
    if len(smooth) == 0:
        return sag, bend, bulges, hollow
    here, there = group[edges.face[smooth]], group[edges.face[edges.twin[smooth]]]
    along = faces.point[faces.loop[edges.after[smooth]]] - faces.point[faces.loop[smooth]]
    length = np.maximum(np.linalg.norm(along, axis=1), np.finfo(np.float64).tiny)
    own, other = (area[i] / np.maximum(length, np.sqrt(area[i])) for i in (here, there))
    narrow = np.minimum(own, other)
    share = narrow / np.where(own > 0.0, own, 1.0)
    angle = np.abs(turn[smooth])
    np.maximum.at(sag, here, narrow * angle * np.where(triangle[here], 0.5, 0.125))
    np.maximum.at(bend, here, 0.5 * angle * share)
    if triangle[here].any():
        _turn_to_corners(bend, faces, edges, curved, group, triangle)
    for turned, sign in ((bulges, 1.0), (hollow, -1.0)):
        turns = sign * turn[smooth] > NOISE
        turned[here[turns]] = True
        turned[here[turned[there]]] = True  # extended to the neighbours
    return sag, bend, bulges, hollow


def _across_curves(edges: HalfEdges, turn: Floats, group: Ints, triangle: Bools) -> Bools:
    """Whether each half-edge (h,) lies on a smooth surface and not at a crease."""
    three = triangle[group[edges.face]] & triangle[group[edges.face[edges.twin]]]
    smooth: Bools = (edges.twin >= 0) & (np.abs(turn) < np.where(three, _FACETED, SMOOTH))
    return smooth


def _turn_to_corners(
    bend: Floats, faces: Faces, edges: HalfEdges, smooth: Bools, group: Ints, triangle: Bools
) -> None:
    """Raise the bend (p,) of triangles to their angle to the mean normal at a corner.

    The mean of the facets at the corner is weighted by area.
    """
    from scipy.sparse import coo_array  # slow to import, and few models need it
    from scipy.sparse.csgraph import connected_components

    joins = np.flatnonzero(smooth)
    beside = edges.after[edges.twin[joins]]  # the same corner, in the face across the edge
    count = len(edges.face)
    graph = coo_array((np.ones(len(joins)), (joins, beside)), shape=(count, count))
    fan = connected_components(graph, directed=False)[1].astype(np.intp)
    vector = faces.area_vectors[edges.face]
    mean = sum_by_owner(vector, fan, int(fan.max()) + 1)[fan]
    sine = np.linalg.norm(np.cross(vector, mean), axis=1)
    angle = np.arctan2(sine, dot(vector, mean))
    patch = group[edges.face]
    chosen = triangle[patch]
    np.maximum.at(bend, patch[chosen], angle[chosen])
