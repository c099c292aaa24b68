"""How far points are from closed polyhedra."""

from __future__ import annotations

import numpy as np

from drystone.geometry.arrays import Floats
from drystone.geometry.polyhedron import Faces, fan_triangles


def outside_distance(faces: Faces, point: Floats) -> float:
    """Distance [m] of a point (3,) from one closed polyhedron; zero inside it and on its surface.

    Parameters
    ----------
    faces
        Of one polyhedron, oriented outwards.
    point : (3,) [m]

    Notes
    -----
    Inside is where the faces, seen from the point, fill the whole sphere.
    Source: van Oosterom and Strackee 1983 (solid angle); Ericson 2005, section 5.1.5 (distance).
    """
    triangles, _ = fan_triangles(faces)
    distance = float(triangle_distances(triangles, point).min())
    a, b, c = (triangles[:, i] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    top = np.einsum("ti,ti->t", a, np.cross(b, c))
    bottom = (
        la * lb * lc
        + np.einsum("ti,ti->t", a, b) * lc
        + np.einsum("ti,ti->t", b, c) * la
        + np.einsum("ti,ti->t", c, a) * lb
    )
    turns = float(np.arctan2(top, bottom).sum()) / (2.0 * np.pi)
    return 0.0 if turns > 0.5 else distance


def triangle_distances(triangles: Floats, point: Floats) -> Floats:
    """Distance (t,) [m] of a point (3,) from each triangle (t, 3, 3)."""
    ends = np.roll(triangles, -1, axis=1)
    edge = ends - triangles
    away = point - triangles
    length = np.einsum("tei,tei->te", edge, edge)
    share = np.einsum("tei,tei->te", away, edge) / np.where(length > 0.0, length, 1.0)
    nearest = triangles + np.clip(share, 0.0, 1.0)[..., None] * edge
    to_edges = np.linalg.norm(point - nearest, axis=2).min(axis=1)
    normal = np.cross(edge[:, 0], -edge[:, 2])
    size = np.linalg.norm(normal, axis=1)
    unit = normal / np.where(size > 0.0, size, 1.0)[:, None]
    over = np.einsum(
        "tei,tei->te", np.cross(np.broadcast_to(unit[:, None], edge.shape), edge), away
    )
    height = np.abs(np.einsum("ti,ti->t", unit, away[:, 0]))
    result: Floats = np.where((over >= 0.0).all(axis=1) & (size > 0.0), height, to_edges)
    return result
