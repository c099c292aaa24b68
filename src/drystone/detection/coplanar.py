"""Coplanar neighbours among the faces of blocks, and the outlines of their unions."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import ROUNDING, Floats, Ints, cross, dot
from drystone.base.ragged import Ragged, sum_by_owner
from drystone.geometry.halfedge import NOISE, HalfEdges, joined_faces, outlines
from drystone.geometry.polygon import area_vectors
from drystone.geometry.polyhedron import Faces

EXACT = 1e-4
"""Distances below this share of the block size count as none: gaps have no block between them, and
faces are one polygon. Chosen: thinner than any block, and fine meshes of a curve are not flattened.
"""


def coplanar_groups(faces: Faces, edges: HalfEdges, turn: Floats, size: Floats) -> Ints:
    """Group (f,) of each face, numbered by first face: coplanar neighbours share one."""
    flat = (edges.twin >= 0) & (np.abs(turn) < NOISE)
    if not flat.any():
        return np.arange(faces.count, dtype=np.intp)
    group = joined_faces(edges, flat, faces.count)
    many = np.bincount(group)[group] > 1
    corner_face = edges.face
    point = faces.point[faces.loop]
    total = sum_by_owner(faces.area_vectors, group, int(group.max()) + 1)
    normal = unit_rows(total, np.linalg.norm(total, axis=1))
    corner_group = group[corner_face]
    share = np.bincount(corner_group)
    middle = sum_by_owner(point, corner_group, len(share)) / share[:, None]
    height = np.abs(dot(point - middle[corner_group], normal[corner_group]))
    worst = np.zeros(len(share))
    np.maximum.at(worst, corner_group, height)
    keep = many & (worst[group] <= EXACT * size[faces.owner])
    apart = np.where(keep, group, len(share) + np.arange(faces.count))
    _, first, label = np.unique(apart, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.intp)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[label.ravel()]


def rings_of(faces: Faces, edges: HalfEdges, group: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Vertex loops, their starts, the patch of each ring, the first face of each patch."""
    number, face = np.unique(group, return_index=True)
    if len(number) == faces.count:
        return faces.loop, faces.start, group, face.astype(np.intp)
    loop, start, owner = outlines(faces, edges, group)
    vectors = area_vectors(faces.point[loop], start)
    total = sum_by_owner(faces.area_vectors, group, len(number))
    hole = -dot(vectors, total[owner])  # holes have the opposite orientation
    order = np.lexsort((hole, owner))
    length = np.diff(start)
    begin = Ragged.from_counts(length[order]).start
    source = np.repeat(start[order] - begin[:-1], length[order]) + np.arange(len(loop))
    return loop[source], begin, owner[order], face.astype(np.intp)


def without_straight(corner: Floats, start: Ints, size: Floats) -> tuple[Floats, Ints]:
    """Rings without the corners on straight lines that merging faces leaves."""
    while True:
        after = Ragged(start).following
        before = np.argsort(after)
        ring = np.repeat(np.arange(len(start) - 1), np.diff(start))
        chord = corner[after] - corner[before]
        length = np.linalg.norm(chord, axis=1)
        off = np.linalg.norm(cross(chord, corner - corner[before]), axis=1)
        straight = off <= ROUNDING * size[ring] * length
        straight &= ~straight[before]  # of two neighbours only one
        straight &= (np.diff(start) > 3)[ring]
        if not straight.any():
            return corner, start
        lost = np.bincount(ring, straight, minlength=len(start) - 1).astype(np.intp)
        start = Ragged.from_counts(np.diff(start) - lost).start
        corner = corner[~straight]


def unit_rows(vectors: Floats, length: Floats) -> Floats:
    """Vectors (r, 3) divided by their length (r,); zero where the length is zero."""
    safe = np.where(length > 0.0, length, 1.0)[:, None]
    return np.where(length[:, None] > 0.0, vectors / safe, 0.0)
