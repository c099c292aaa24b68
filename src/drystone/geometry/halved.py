"""A body cut by a plane into two, on its faces as loops: the usual case, without loose faces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Floats
from drystone.geometry.polyhedron import Loop, Piece, loop_edges


def halved(
    vertices: Floats, faces: Sequence[Loop], height: Floats, near: float
) -> tuple[Piece, Piece] | None:
    """The parts of a closed body below and above a plane.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops of them, outwards.
    height : (v,) [m]
        Of the vertices above the plane; exactly zero on it, and of both signs.
    near : [m]
        Shortest edge that a cut may make.

    Returns
    -------
    Two bodies; ``None`` where the section is not one simple loop, where a face lies in the plane or
    is cut more than once, or where an edge of the section would be shorter than ``near``.
    """
    points = list(vertices)
    at: dict[tuple[int, int], int] = {}
    sides: tuple[list[Loop], list[Loop]] = ([], [])
    high = height.tolist()
    for face in faces:
        parts = _parts(face, high, vertices, points, at)
        if parts is None:
            return None
        for side, part in zip(sides, parts, strict=True):
            if len(part) > 2:
                side.append(part)
    corner = np.array(points)
    for side in sides:
        lid = _lid(side)
        if lid is None:
            return None
        edge = corner[list(lid)] - corner[[*lid[1:], lid[0]]]
        if np.linalg.norm(edge, axis=1).min() < near:
            return None
        side.append(lid)
    return _used(corner, sides[0]), _used(corner, sides[1])


def _parts(
    face: Loop,
    height: Sequence[float],
    vertices: Floats,
    points: list[Floats],
    at: dict[tuple[int, int], int],
) -> tuple[Loop, Loop] | None:
    """The parts of a face below and above the plane; new points are added to ``points``."""
    below: list[int] = []
    above: list[int] = []
    changes, last = 0, 0.0
    for i, j in loop_edges(face):
        here, then = height[i], height[j]
        if here <= 0.0:
            below.append(i)
        if here >= 0.0:
            above.append(i)
        if here * then < 0.0:
            key = (i, j) if i < j else (j, i)
            if key not in at:
                one, other = key
                share = height[one] / (height[one] - height[other])
                at[key] = len(points)
                points.append(vertices[one] + share * (vertices[other] - vertices[one]))
            below.append(at[key])
            above.append(at[key])
        if here * last < 0.0:
            changes += 1
        last = here or last
    first = next((height[i] for i in face if height[i]), 0.0)
    if first == 0.0 or changes + (first * last < 0.0) > 2:
        return None
    lowest, highest = min(height[i] for i in face), max(height[i] for i in face)
    return tuple(below) if lowest < 0.0 else (), tuple(above) if highest > 0.0 else ()


def _lid(faces: Sequence[Loop]) -> Loop | None:
    """The face that closes a body with one opening; ``None`` where it has another number."""
    edges = {edge for face in faces for edge in loop_edges(face)}
    after: dict[int, int] = {}
    for i, j in edges:
        if (j, i) not in edges:
            if j in after:
                return None
            after[j] = i
    if len(after) < 3:
        return None
    start = next(iter(after))
    loop = [start]
    while (following := after.get(loop[-1])) != start:
        if following is None or len(loop) == len(after):
            return None
        loop.append(following)
    return tuple(loop) if len(loop) == len(after) else None


def _used(corner: Floats, faces: Sequence[Loop]) -> Piece:
    """The body without vertices that no face has."""
    used = sorted({i for face in faces for i in face})
    new = dict(zip(used, range(len(used)), strict=True))
    return corner[used], [tuple(new[i] for i in face) for face in faces]
