"""Surfaces for drawing: edges between faces that are not coplanar, triangles, outward normals."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, unit
from drystone.geometry.polyhedron import Faces

SMOOTH = 1e-6
"""Faces of one block whose unit normals differ by less are drawn as one plane, without the edge
between them (1 - cos 0.08 degrees, chosen: cuts of a flat face, not facets of a curve)."""


def face_normals(faces: Faces) -> Floats:
    """Outward unit normals (f, 3); zero for a face without area."""
    return unit(faces.area_vectors)[0]


def sharp_edges(faces: Faces, normal: Floats) -> tuple[Ints, Ints, Bools]:
    """Edges between faces, without those between coplanar faces.

    Parameters
    ----------
    faces
    normal : (f, 3)

    Returns
    -------
    edge : (e, 2) positions in ``faces.point``
    owner : (e,) block
    drawn : (l,)
        Whether the edge from each loop corner to the next one is among them.
    """
    a = faces.loop
    b = faces.loop[faces.corners.following]
    face = np.repeat(np.arange(faces.count), np.diff(faces.start))
    low, high = np.minimum(a, b), np.maximum(a, b)
    order = np.lexsort((high, low))
    first, second = order[0::2], order[1::2]
    flat = (normal[face[first]] * normal[face[second]]).sum(axis=1) > 1.0 - SMOOTH
    drawn = np.ones(len(a), dtype=bool)
    drawn[first[flat]] = False
    drawn[second[flat]] = False
    kept = first[~flat]
    return np.stack([low[kept], high[kept]], axis=1), faces.owner[face[kept]], drawn
