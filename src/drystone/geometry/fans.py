"""Warped faces replaced by triangles: a fan about the mean of the corners."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, cross, unit
from drystone.base.ragged import Ragged
from drystone.geometry.polygon import area_vectors
from drystone.geometry.polyhedron import Faces


def fan_warped(faces: Faces, tolerance: float) -> Faces:
    """The same bodies, every warped face replaced by its fan about the mean of its corners.

    The volume and the centroid of a body are those of this fan
    (:func:`drystone.geometry.polyhedron.mass_properties`), so the triangles in a file enclose
    the solid of the calculation. Two bodies that share a warped face get the same triangles there.

    Parameters
    ----------
    faces
        Oriented outwards, the points of each body together.
    tolerance
        A face is warped when a corner is farther from its plane, relative to the size of its body.

    Returns
    -------
    Faces
        The points of each body are followed by the middles of its warped faces. Planar faces and
        triangles are unchanged. So are warped faces whose fan would fold over because their mean
        does not see all of their edges.

    Examples
    --------
    >>> saddle = np.array([[0.0, 0, 0.1], [1, 0, 0], [1, 1, 0.1], [0, 1, 0]])
    >>> one = Faces(saddle, np.arange(4), np.array([0, 4]), np.array([0]))
    >>> fan = fan_warped(one, 1e-9)
    >>> fan.point[4].tolist(), fan.loop.reshape(-1, 3).tolist()
    ([0.5, 0.5, 0.05], [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    """
    if faces.count == 0:
        return faces
    body = point_owners(faces)
    corner = faces.point[faces.loop]
    chosen = _warped(faces, body, corner, tolerance) & (faces.corners.counts > 3)
    if not chosen.any():
        return faces
    added = np.flatnonzero(chosen)
    middle = faces.corners.mean(corner)
    order = np.argsort(np.concatenate([body, faces.owner[added]]), kind="stable")
    place = np.empty(len(order), dtype=np.intp)
    place[order] = np.arange(len(order))
    middle_at = np.full(faces.count, -1, dtype=np.intp)
    middle_at[added] = place[len(body) :]
    face = faces.corners.owner
    fanned = chosen[face]
    row = np.empty((len(face), 3), dtype=np.intp)
    row[:, 0] = place[faces.loop]
    row[:, 1] = row[faces.corners.following, 0]
    row[:, 2] = middle_at[face]
    kept = np.ones((len(face), 3), dtype=bool)
    kept[:, 1:] = fanned[:, None]
    first = np.zeros(len(face), dtype=bool)
    first[faces.start[:-1]] = True
    begins = np.flatnonzero(first | fanned)
    pieces = Ragged(np.append(begins, len(face)))
    corners = Ragged.from_counts(pieces.sum(kept.sum(axis=1)))
    return Faces(
        np.concatenate([faces.point, middle[added]])[order],
        row[kept],
        corners.start,
        faces.owner[face[begins]],
    )


def point_owners(faces: Faces) -> Ints:
    """(v,) the body that each point belongs to; every point is a corner of a face."""
    owner = np.zeros(len(faces.point), dtype=np.intp)
    owner[faces.loop] = faces.corners.spread(faces.owner)
    return owner


def _warped(faces: Faces, body: Ints, corner: Floats, tolerance: float) -> Bools:
    """(f,) whether a face is warped beyond the tolerance, and its mean sees all of its edges."""
    height, seen = warp_and_view(corner, faces.start)
    count = int(body.max()) + 1
    of_body = Ragged.from_owners(body, count)
    extent = of_body.max(faces.point) - of_body.min(faces.point)
    size = np.linalg.norm(extent, axis=1)[faces.owner]
    return (height > tolerance * size) & seen


def warp_and_view(corners: Floats, start: Ints) -> tuple[Floats, Bools]:
    """How far polygons are from planar, and whether the mean of their corners sees all their edges.

    Parameters
    ----------
    corners : (l, 3) [m]
    start : (f + 1,)

    Returns
    -------
    height : (f,) [m]
        Largest distance of a corner from the plane through the mean, square to the area vector.
    seen : (f,)
        Every triangle of the fan about the mean has the orientation of the polygon.
    """
    loops = Ragged(start)
    normal = loops.spread(unit(area_vectors(corners, start))[0])
    local = corners - loops.spread(loops.mean(corners))
    turn = (cross(local, local[loops.following]) * normal).sum(axis=1)
    height: Floats = loops.max(np.abs((local * normal).sum(axis=1)))
    seen: Bools = loops.min(turn) > 0.0
    return height, seen
