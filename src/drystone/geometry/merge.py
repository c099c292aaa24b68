"""Coplanar triangles merged into polygons."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Floats, Ints, unit
from drystone.base.ragged import sum_by_owner
from drystone.geometry.halfedge import half_edges, joined_faces, outlines, turn_angles
from drystone.geometry.polyhedron import Loop, stack_faces

_TURN = 1e-3
"""[rad] Neighbours with a smaller angle between them are candidates for merging. Chosen. They are
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
    vectors = stacked.area_vectors
    normal, length = unit(vectors)
    edges = half_edges(stacked)
    flat = (edges.twin >= 0) & (np.abs(turn_angles(stacked, edges, normal)) < _TURN)
    flat &= (length > 0.0)[edges.face] & (length > 0.0)[edges.face[edges.twin]]
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
