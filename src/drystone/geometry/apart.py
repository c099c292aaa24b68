"""Convex pieces of several bodies that touch and do not overlap, for simulators.

A simulator pushes bodies apart that begin inside each other. Blocks do so by little where they were
drawn so, and where their joints are warped: each block divides a warped face in its own way. A body
that is convex but for its warp gets the mean planes of its faces, so that two blocks with the same
corners touch in one plane. What overlaps even so is cut back, one half each.
"""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np
from scipy.spatial import HalfspaceIntersection, QhullError

from drystone.base.arrays import Bools, Floats, Ints
from drystone.geometry import boxes
from drystone.geometry.convex_pieces import ConvexPiece, mesh_of
from drystone.geometry.polygon import area_vector
from drystone.geometry.polyhedron import Loop

PLANE = 1e-7
"""A face is plane where its corners lie nearer than this share of the body's size to its mean
plane: the single precision of simulators."""


def levelled(vertices: Floats, faces: Sequence[Loop]) -> ConvexPiece | None:
    """The body between the mean planes of the faces of a body with warped faces.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops, oriented outwards.

    Returns
    -------
    ConvexPiece or None
        ``None`` where all faces are plane. And where a vertex lies above the plane of a face, of
        which it is no corner, by more than that face is warped: the body is not convex.
    """
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    planes, most = [], 0.0
    for face in faces:
        corner = vertices[list(face)]
        area = area_vector(corner)
        normal = area / max(float(np.linalg.norm(area)), np.finfo(float).tiny)
        offset = float(normal @ corner.mean(axis=0))
        height = vertices @ normal - offset
        own = float(np.abs(height[list(face)]).max())
        height[list(face)] = 0.0
        if height.max() > own + PLANE * size:
            return None
        planes.append([*normal, -offset])
        most = max(most, own)
    if most <= PLANE * size:
        return None
    try:
        found = HalfspaceIntersection(np.array(planes), vertices.mean(axis=0)).intersections
    except QhullError:  # it is thinner than its warp
        return None
    return ConvexPiece.around(np.asarray(found))


def set_apart(
    pieces: Sequence[ConvexPiece], owner: Ints, still: Bools
) -> tuple[list[ConvexPiece | None], float]:
    """The pieces, cut back where those of two bodies overlap, and the largest depth of that [m].

    Each pair is cut by the plane in the middle of its overlap, in the direction in which they
    overlap least: across a face of one of them, or across an edge of each. A piece of which nothing
    is left is ``None``, unless it is the last of its body.

    Parameters
    ----------
    pieces
    owner : (p,)
        Body of each, from 0 on.
    still : (p,)
        Pieces that cannot move: two of them are left as they are.

    Examples
    --------
    >>> cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    >>> low, high = ConvexPiece.around(cube), ConvexPiece.around(cube + [0.2, 0.0, 0.9])
    >>> (low, high), deep = set_apart([low, high], np.array([0, 1]), np.zeros(2, dtype=bool))
    >>> [round(float(z), 9) for z in (deep, low.point[:, 2].max(), high.point[:, 2].min())]
    [0.1, 0.95, 0.95]
    """
    made: list[ConvexPiece | None] = list(pieces)
    left = np.bincount(owner).tolist()
    low = np.array([one.point.min(axis=0) for one in pieces]).reshape(-1, 3)
    high = np.array([one.point.max(axis=0) for one in pieces]).reshape(-1, 3)
    size = np.linalg.norm(high - low, axis=1)
    first, second = boxes.overlapping(low, high)
    asked = (owner[first] != owner[second]) & ~(still[first] & still[second])
    deepest = 0.0
    for i, j in zip(first[asked].tolist(), second[asked].tolist(), strict=True):
        one, other = made[i], made[j]
        if one is None or other is None:
            continue
        touching = PLANE * min(size[i], size[j])
        normal, middle, depth = _least_overlap(
            one, other, np.concatenate([one.normal, -other.normal])
        )
        if depth > touching:  # they may cross with two edges
            edges = _least_overlap(one, other, _across_edges(one, other))
            normal, middle, depth = min((normal, middle, depth), edges, key=lambda cut: cut[2])
        if depth <= touching:
            continue
        deepest = max(deepest, depth)
        cut = _below(one, normal, middle), _below(other, -normal, -middle)
        gone = [k for k, part in zip((i, j), cut, strict=True) if part is None]
        if not gone:
            made[i], made[j] = cut
        for k in gone[:1]:
            if left[owner[k]] > 1:
                made[k] = None
                left[owner[k]] -= 1
    return made, deepest


def _least_overlap(
    one: ConvexPiece, other: ConvexPiece, normal: Floats
) -> tuple[Floats, float, float]:
    """Of some directions (d, 3) that in which a piece reaches least into another.

    With the middle of that overlap [m] along it, and its depth [m].
    """
    top = (one.point @ normal.T).max(axis=0)
    bottom = (other.point @ normal.T).min(axis=0)
    least = int(np.argmin(top - bottom))
    middle = 0.5 * float(top[least] + bottom[least])
    return normal[least], middle, float(top[least] - bottom[least])


def _across_edges(one: ConvexPiece, other: ConvexPiece) -> Floats:
    """Directions (d, 3) across an edge of each piece, either way.

    With those of their faces they are all that can part two convex bodies.
    """
    across = np.cross(_edges(one)[:, None], _edges(other)[None]).reshape(-1, 3)
    size = np.linalg.norm(across, axis=1)
    across = across[size > PLANE] / size[size > PLANE, None]
    return np.concatenate([across, -across])


def _edges(piece: ConvexPiece) -> Floats:
    """Unit directions (e, 3) of the edges of a piece: of two corners that share two faces."""
    height = np.abs(piece.point @ piece.normal.T - piece.offset)
    at = (height <= PLANE * np.ptp(piece.point, axis=0).max()).astype(np.intp)
    first, second = np.nonzero(np.triu(at @ at.T >= 2, 1))
    along = piece.point[second] - piece.point[first]
    return along / np.linalg.norm(along, axis=1, keepdims=True)


def _below(piece: ConvexPiece, normal: Floats, offset: float) -> ConvexPiece | None:
    """The part of a piece where ``normal @ x <= offset``; ``None`` where nothing is left."""
    solid = manifold3d.Manifold.hull_points(piece.point).trim_by_plane(-normal, -offset)
    return None if solid.volume() <= 0.0 else ConvexPiece.around(mesh_of(solid)[0])
