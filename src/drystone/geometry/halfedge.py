"""Neighbours across the edges of closed polyhedra, and outlines of joined faces."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, cross, dot, unit
from drystone.base.ragged import linked, sum_by_owner
from drystone.geometry.polyhedron import Faces, Loop, rings, stack_faces


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
    chosen = np.flatnonzero(join)
    return linked(edges.face[chosen], edges.face[edges.twin[chosen]], count)


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
    walks = list(rings(successor))
    chain = [place for walk in walks for place in walk]
    start = np.cumsum([0, *map(len, walks)])
    picked = np.array(chain, dtype=np.intp)
    begin = start.astype(np.intp)
    return faces.loop[picked], begin, of_edge[picked[begin[:-1]]]


SMOOTH = np.deg2rad(35.0)
"""[rad] Neighbouring faces with a smaller angle approximate a curved surface. Chosen: a circle of
eleven strips or more."""
NOISE = np.deg2rad(0.1)
"""[rad] Neighbouring faces with a smaller angle are meant to be plane. Chosen: above the noise of
coordinates stored in single precision."""
CREASE = np.deg2rad(15.0)
"""[rad] Faces of one block with a smaller angle are drawn as one surface, without the edge between
them. Chosen: the facets of a curve of 24 or more around, and cuts of a flat face."""


def sharp_edges(faces: Faces, front: Bools | None = None) -> tuple[Ints, Ints, Bools]:
    """Edges between faces, without those on smooth surfaces.

    Parameters
    ----------
    faces
    front : (f,)
        Faces that look towards the eye: edges between these and others are outlines, and kept.

    Returns
    -------
    edge : (e, 2) positions in ``faces.point``
    owner : (e,) block
    drawn : (l,)
        Whether the edge from each loop corner to the next one is among them.
    """
    edges, normal = half_edges(faces), faces.normals
    beside = edges.face[edges.twin]
    drawn = dot(normal[edges.face], normal[beside]) <= np.cos(CREASE)
    drawn |= edges.twin < 0
    if front is not None:
        drawn |= front[edges.face] != front[beside]
    tail, head = faces.loop, faces.loop[edges.after]
    once = np.flatnonzero(drawn & (tail < head))
    once = once[np.lexsort((head[once], tail[once]))]
    edge = np.stack([tail[once], head[once]], axis=1)
    return edge, faces.owner[edges.face[once]], drawn


BENT = 1e-3
"""[rad] Neighbouring faces with a smaller angle between them meet at no edge. Chosen. They are
merged if their distance from one plane is small enough."""


def merge_coplanar(
    vertices: Sequence[Floats], faces: Sequence[Sequence[Loop]], tolerance: float
) -> list[list[Loop]]:
    """The faces of closed bodies, coplanar neighbours merged into one polygon.

    Parameters
    ----------
    vertices
        Per body (v, 3) [m].
    faces
        Per body its loops: a closed 2-manifold, consistently oriented.
    tolerance
        Largest distance of a corner from the plane of its merged face, relative to the body's size.

    Returns
    -------
    Per body its loops. A face is a simple loop: faces whose union has a hole or touches itself at a
    vertex are not merged. No vertex is moved or dropped.

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]])
    >>> loops = [(0, 2, 1), (0, 3, 2), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    >>> merge_coplanar([points], [loops], 1e-9)[0][0]
    (3, 2, 1, 0)
    """
    if len(vertices) == 0:
        return []
    stacked = stack_faces(vertices, faces)
    vectors, normal = stacked.area_vectors, stacked.normals
    edges = half_edges(stacked)
    flat = (edges.twin >= 0) & (np.abs(turn_angles(stacked, edges, normal)) < BENT)
    has_area: Bools = np.asarray(normal.any(axis=1))
    flat &= has_area[edges.face] & has_area[edges.face[edges.twin]]
    group = joined_faces(edges, flat, stacked.count)
    count = np.array([len(v) for v in vertices])
    first = np.cumsum(count) - count
    size = np.array([np.linalg.norm(v.max(axis=0) - v.min(axis=0)) for v in vertices])
    far = _deviation(stacked.point[stacked.loop], group[edges.face], group, vectors)
    kept = (np.bincount(group)[group] > 1) & (far[group] <= tolerance * size[stacked.owner])
    loop, start, owner = outlines(stacked, edges, np.where(kept, group, -1))
    rings: dict[int, list[Ints]] = defaultdict(list)
    for ring, of in zip(np.split(loop, start[1:-1]), owner.tolist(), strict=False):
        rings[of].append(ring)
    merged: list[list[Loop]] = [[] for _ in vertices]
    done: set[int] = set()
    first_face = np.searchsorted(stacked.owner, np.arange(len(vertices))).tolist()
    for face, (body, of) in enumerate(zip(stacked.owner.tolist(), group.tolist(), strict=True)):
        whole = rings.get(of, []) if kept[face] else []
        if len(whole) == 1 and len(set(whole[0].tolist())) == len(whole[0]):
            if of not in done:
                merged[body].append(tuple((whole[0] - first[body]).tolist()))
                done.add(of)
        else:
            merged[body].append(tuple(faces[body][face - first_face[body]]))
    return merged


def _deviation(corner: Floats, corner_group: Ints, group: Ints, vectors: Floats) -> Floats:
    """Largest distance of a corner from the plane of each group of faces."""
    total = int(group.max(initial=-1)) + 1
    share = np.maximum(np.bincount(corner_group, minlength=total), 1)
    middle = sum_by_owner(corner, corner_group, total) / share[:, None]
    normal = unit(sum_by_owner(vectors, group, total))[0]
    height = np.abs(((corner - middle[corner_group]) * normal[corner_group]).sum(axis=1))
    worst: Floats = np.zeros(total)
    np.maximum.at(worst, corner_group, height)
    return worst
