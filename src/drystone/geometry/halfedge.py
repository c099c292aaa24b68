"""Neighbours across the edges of closed polyhedra, and outlines of joined faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, cross, dot
from drystone.geometry.polyhedron import Faces


@dataclass(frozen=True)
class HalfEdges:
    """The directed edges of faces; number i runs from ``loop[i]`` to its successor in the face.

    Attributes
    ----------
    face : (h,) face on its left
    after : (h,) the next one in the face
    twin : (h,) the same edge run backwards by the neighbour, -1 where there is none
    """

    face: Ints
    after: Ints
    twin: Ints


def half_edges(faces: Faces) -> HalfEdges:
    """Half-edges of closed, consistently oriented polyhedra."""
    after = faces.corners.following
    face = np.repeat(np.arange(faces.count, dtype=np.intp), np.diff(faces.start))
    tail, head = faces.loop, faces.loop[after]
    count = np.int64(len(faces.point))
    key = np.minimum(tail, head) * count + np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    twin = np.full(len(key), -1, dtype=np.intp)
    twin[order[same]] = order[same + 1]
    twin[order[same + 1]] = order[same]
    return HalfEdges(face, after, twin)


def turn_angles(faces: Faces, edges: HalfEdges, normal: Floats) -> Floats:
    """Angle (h,) [rad] by which the surface turns at each half-edge.

    Positive at a convex edge, negative at a re-entrant one. Zero where the two faces lie in one
    plane, and where there is no neighbour.

    Parameters
    ----------
    normal : (f, 3) unit, outwards
    """
    along = faces.point[faces.loop[edges.after]] - faces.point[faces.loop]
    length = np.sqrt(dot(along, along))
    here = normal[edges.face]
    there = normal[edges.face[edges.twin]]
    sine = dot(cross(here, there), along) / np.where(length > 0.0, length, 1.0)
    turn: Floats = np.arctan2(sine, dot(here, there))
    turn[edges.twin < 0] = 0.0
    return turn


def joined_faces(edges: HalfEdges, join: Bools, count: int) -> Ints:
    """Group (f,) of each of ``count`` faces when they are joined across the chosen half-edges."""
    from scipy.sparse import coo_array  # slow to import, and few models need it
    from scipy.sparse.csgraph import connected_components

    chosen = np.flatnonzero(join)
    one, other = edges.face[chosen], edges.face[edges.twin[chosen]]
    graph = coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.intp)


def outlines(faces: Faces, edges: HalfEdges, group: Ints) -> tuple[Ints, Ints, Ints]:
    """Boundary loops of groups of faces joined across edges.

    Parameters
    ----------
    group : (f,) non-negative; faces with -1 are left out

    Returns
    -------
    loop : (l,) vertex indices, counter-clockwise with the group on the left; a hole runs clockwise
    start : (r + 1,)
    owner : (r,) group of each loop
    """
    of_edge = group[edges.face]
    inner = (edges.twin >= 0) & (of_edge[edges.twin] == of_edge)
    border = np.flatnonzero((of_edge >= 0) & ~inner)
    step = edges.after[border]
    turning = np.flatnonzero(inner[step])
    while len(turning):  # rotate about the vertex until the border is met again
        step[turning] = edges.after[edges.twin[step[turning]]]
        turning = turning[inner[step[turning]]]
    successor = dict(zip(border.tolist(), step.tolist(), strict=True))
    chain: list[int] = []
    start = [0]
    while successor:
        first, place = successor.popitem()
        chain.append(first)
        while place != first:
            chain.append(place)
            place = successor.pop(place)
        start.append(len(chain))
    picked = np.array(chain, dtype=np.intp)
    begin = np.array(start, dtype=np.intp)
    return faces.loop[picked], begin, of_edge[picked[begin[:-1]]]
