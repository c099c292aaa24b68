"""A body behind an open surface: what stands still needs no volume of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Floats, unit
from drystone.base.errors import InputError
from drystone.geometry.coincidence import first_coincident
from drystone.geometry.polygon import area_vector
from drystone.geometry.polyhedron import (
    Loop,
    enclosed_volume,
    fan_triangles,
    loop_edges,
    rings,
    stack_faces,
)
from drystone.geometry.selfcontact import self_contacts
from drystone.geometry.solid import winding_number
from drystone.geometry.surface import edge_uses, face_components, orient

_SLOPE = 0.1
"""A surface is a field of heights when the sine of the slope of each face is above this. Chosen."""
_SAME = 1e-9
"""Corners nearer than this share of the size of the surface are one."""
_TRIES = 6
"""So often the thickness is halved before a surface is refused."""

Body = tuple[Floats, list[Loop]]


def backed(
    vertices: Floats, faces: Sequence[Loop], beside: Floats, thickness: float
) -> tuple[Body, list[str]]:
    """A closed body with a given open surface, and what was done.

    Each connected part of the surface is treated alone. A mesh with holes around a body that has
    nothing inside gets its holes closed. Any other surface, such as a face, a terrain or a frame,
    gets a body of a given thickness behind it, on the side away from what is beside it.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops in any orientation.
    beside : (n, 3) [m]
        Centroids of the blocks that rest on the surface; may be empty.
    thickness : [m]
        Halved where the body would touch itself.

    Raises
    ------
    InputError
        More than two faces meet at an edge, a face has no area, or no body fits behind the surface.

    Examples
    --------
    >>> floor = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> (points, loops), done = backed(floor, [(0, 1, 2, 3)], np.array([[0.5, 0.5, 2.0]]), 0.25)
    >>> float(points[:, 2].min()), len(loops), done
    (-0.25, 6, ['an open surface backed by 0.25 m'])
    """
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0))) if len(vertices) else 0.0
    first = first_coincident(vertices, _SAME * extent).tolist()
    loops = [tuple(dict.fromkeys(first[i] for i in face)) for face in faces]
    loops = orient([loop for loop in loops if len(loop) >= 3])[0]
    points: list[Floats] = []
    every: list[Loop] = []
    done: list[str] = []
    for part in face_components(loops):
        body, how = _closed([loops[i] for i in part], vertices, beside, thickness)
        offset, step = sum(map(len, points)), -1 if enclosed_volume(*body) < 0.0 else 1
        points.append(body[0])
        every += [tuple(i + offset for i in loop)[::step] for loop in body[1]]
        done.append(how)
    if not every:
        raise InputError("it has no face with an area")
    return (np.concatenate(points), every), list(dict.fromkeys(done))


def _closed(
    loops: list[Loop], vertices: Floats, beside: Floats, thickness: float
) -> tuple[Body, str]:
    """One connected surface as a closed body, and how."""
    used = sorted({i for loop in loops for i in loop})
    place = {old: new for new, old in enumerate(used)}
    points, loops = vertices[used], [tuple(place[i] for i in loop) for loop in loops]
    border = _border(loops)
    if not border:
        return (points, loops), "a closed part kept"
    vector = np.array([area_vector(points[list(loop)]) for loop in loops])
    normal, area = unit(vector)
    if not (area > 0.0).all():
        raise InputError(f"face {int(np.argmin(area))} of its open surface has no area")
    front = _front(points, loops, beside)
    across = unit(vector.sum(axis=0)[None])[0][0]
    if (normal @ across).min() > _SLOPE:
        back = points - front * thickness * across
        return _sheet(points, back, loops, border), f"an open surface backed by {thickness:.3g} m"
    filled = _filled(points, loops, border)
    inside_out = enclosed_volume(*filled) < 0.0
    if (front < 0.0) == inside_out and _sound(filled):
        return filled, "the holes of a surface closed"
    at_vertex = np.zeros(points.shape)
    for loop, one in zip(loops, vector, strict=True):
        at_vertex[list(loop)] += one
    outward = unit(at_vertex)[0]
    for _ in range(_TRIES):
        sheet = _sheet(points, points - front * thickness * outward, loops, border)
        if _sound(sheet):
            return sheet, f"an open surface backed by {thickness:.3g} m"
        thickness *= 0.5
    raise InputError("no body fits behind its open surface", remedy="give it a thickness")


def _border(loops: Sequence[Loop]) -> list[tuple[int, int]]:
    """Edges of one face only, as that face runs them."""
    uses = edge_uses(loops).values()
    if any(len(runs) > 2 for runs in uses):
        raise InputError("more than two faces meet at an edge of its open surface")
    return [runs[0][1] for runs in uses if len(runs) == 1]


def _front(points: Floats, loops: Sequence[Loop], beside: Floats) -> float:
    """1 where what is beside a surface sees its front, the side of its normals, else -1."""
    fans = fan_triangles(stack_faces([points], [loops]))[0]
    behind = winding_number(beside, fans).sum()
    return -1.0 if behind > 0.0 else 1.0


def _sheet(
    points: Floats, back: Floats, loops: Sequence[Loop], border: Sequence[tuple[int, int]]
) -> Body:
    """The body between a surface and a copy of it."""
    count = len(points)
    behind = [tuple(i + count for i in loop[::-1]) for loop in loops]
    sides: list[Loop] = [(b, a, a + count, b + count) for a, b in border]
    return np.concatenate([points, back]), [*loops, *behind, *sides]


def _filled(points: Floats, loops: Sequence[Loop], border: Sequence[tuple[int, int]]) -> Body:
    """The surface with a fan of triangles over each hole."""
    fans, middles = list[Loop](), list[Floats]()
    for ring in rings({b: a for a, b in border}):
        apex = len(points) + len(middles)
        middles.append(points[ring].mean(axis=0))
        fans += [(a, b, apex) for a, b in loop_edges(tuple(ring))]
    return np.concatenate([points, np.array(middles)]), [*loops, *fans]


def _sound(body: Body) -> bool:
    """Whether a closed body has a volume and does not touch itself."""
    points, loops = body
    if abs(enclosed_volume(*body)) < 3e-4 * float(np.linalg.norm(np.ptp(points, axis=0))) ** 3:
        return False
    return not self_contacts([points], [loops])
