"""Bodies and polygons cut by a plane, for drawings: what lies beyond the plane is left out.

A point is beyond the plane where its height above it is more than zero.
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.geometry.polyhedron import Faces


def clip_loop(corner: Floats, height: Floats, marked: Bools) -> tuple[Floats, Bools]:
    """The part of a polygon that is not beyond a plane.

    Parameters
    ----------
    corner : (c, d)
        Coordinates, and other values that are interpolated along the sides.
    height : (c,)
        Of the corners above the plane.
    marked : (c,)
        Whether the side from each corner to the next is marked.

    Returns
    -------
    corner : (e, d)
    marked : (e,)
        Sides that lie in the plane are not.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> part, marked = clip_loop(square, square[:, 0] - 0.5, np.ones(4, dtype=bool))
    >>> part.tolist(), marked.tolist()
    ([[0.0, 0.0], [0.5, 0.0], [0.5, 2.0], [0.0, 2.0]], [True, False, True, True])
    """
    beyond = height > 0.0
    if not beyond.any():
        return corner, marked
    after = np.roll(np.arange(len(corner)), -1)
    points: list[Floats] = []
    sides: list[bool] = []
    for i, j in enumerate(after.tolist()):
        if not beyond[i]:
            points.append(corner[i])
            sides.append(bool(marked[i]))
        if beyond[i] != beyond[j]:
            share = height[i] / (height[i] - height[j])
            points.append(corner[i] + share * (corner[j] - corner[i]))
            sides.append(bool(marked[i] and beyond[i]))
    return np.array(points).reshape(-1, corner.shape[1]), np.array(sides, dtype=bool)


def cut_faces(faces: Faces, normal: Floats, offset: float) -> list[tuple[int, Floats]]:
    """The sections of closed bodies by the plane ``normal @ x = offset``.

    Parameters
    ----------
    faces
        Of closed bodies, oriented outwards.
    normal : (3,) unit
    offset : [m]

    Returns
    -------
    Body and corners (c, 3) [m] of each ring, counter-clockwise seen from the side of the normal;
    holes run the other way round.

    Examples
    --------
    >>> from drystone.geometry.polyhedron import stack_faces
    >>> from drystone.models import box
    >>> cube = box((1.0, 1.0, 1.0))
    >>> faces = stack_faces([cube.vertices], [cube.faces])
    >>> (body, ring), = cut_faces(faces, np.array([0.0, 0.0, 1.0]), 0.25)
    >>> body, ring.shape, ring[:, 2].tolist()
    (0, (4, 3), [0.25, 0.25, 0.25, 0.25])
    """
    height = faces.point @ normal - offset
    beyond = height > 0.0
    corner_beyond = beyond[faces.loop]
    mixed = faces.corners.any(corner_beyond) & ~faces.corners.all(corner_beyond)
    follows: dict[tuple[int, int], tuple[int, int]] = {}
    place: dict[tuple[int, int], Floats] = {}
    body: dict[tuple[int, int], int] = {}
    area = faces.area_vectors
    for face in np.flatnonzero(mixed).tolist():
        loop = faces.loop[faces.start[face] : faces.start[face + 1]]
        crossed = [
            (min(i, j), max(i, j))
            for i, j in zip(loop.tolist(), np.roll(loop, -1).tolist(), strict=True)
            if beyond[i] != beyond[j]
        ]
        for i, j in crossed:
            share = height[i] / (height[i] - height[j])
            place[i, j] = faces.point[i] + share * (faces.point[j] - faces.point[i])
            body[i, j] = int(faces.owner[face])
        along = np.cross(normal, area[face])  # the body lies to the left
        crossed.sort(key=lambda edge: float(place[edge] @ along))
        follows.update(zip(crossed[::2], crossed[1::2], strict=True))
    rings = []
    while follows:
        first, at = follows.popitem()
        ring = [first]
        while at != first and at in follows:
            ring.append(at)
            at = follows.pop(at)
        rings.append((body[first], np.array([place[one] for one in ring])))
    return rings
