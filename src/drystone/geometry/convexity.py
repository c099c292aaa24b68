"""Which bodies are convex."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Bools, Floats, unit
from drystone.base.ragged import expand
from drystone.geometry.polyhedron import Faces, Loop, stack_faces

_CONVEX = 1e-9
"""A body is convex when no vertex lies farther than this share of its size over a face plane."""
_MANY_PAIRS = 2_000_000
"""Pairs of a vertex and a face in one batch. Chosen: at most some hundred MB."""


def convex_bodies(vertices: Sequence[Floats], faces: Sequence[Sequence[Loop]]) -> Bools:
    """Whether each body is convex.

    No vertex may lie above the plane of a face by more than :data:`_CONVEX`. A body with very many
    faces counts as concave: the test would cost more time than it saves.

    Parameters
    ----------
    vertices
        Per body (v, 3) [m].
    faces
        Per body its loops, oriented outwards.
    """
    convex = np.zeros(len(vertices), dtype=bool)
    pairs = np.array([len(v) * len(f) for v, f in zip(vertices, faces, strict=True)])
    small = np.flatnonzero(pairs <= _MANY_PAIRS)
    batch = np.cumsum(pairs[small]) // _MANY_PAIRS
    for bodies in np.split(small, np.flatnonzero(np.diff(batch)) + 1):
        if len(bodies):
            part = bodies.tolist()
            convex[bodies] = _convex_batch([vertices[i] for i in part], [faces[i] for i in part])
    return convex


def _convex_batch(vertices: Sequence[Floats], faces: Sequence[Sequence[Loop]]) -> Bools:
    placed = [(v - v[0]) / np.linalg.norm(v.max(axis=0) - v.min(axis=0)) for v in vertices]
    stacked = stack_faces(placed, faces)
    normal, middle = planes(stacked)
    count = np.array([len(v) for v in vertices])
    first = np.cumsum(count) - count
    face, vertex = expand(first[stacked.owner], count[stacked.owner])
    height = ((stacked.point[vertex] - middle[face]) * normal[face]).sum(axis=1)
    highest = np.zeros(len(vertices))
    np.maximum.at(highest, stacked.owner[face], height)
    return highest <= _CONVEX


def planes(faces: Faces) -> tuple[Floats, Floats]:
    """Unit normal (zero for a face without area) and mean corner of each face."""
    return unit(faces.area_vectors)[0], faces.corners.mean(faces.point[faces.loop])
