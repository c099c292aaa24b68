"""What keeps a surface from being closed, mended: missing joints and lids, faces inside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Floats, Ints, lengths, unit
from drystone.geometry import boxes
from drystone.geometry.planar import faces_with_holes
from drystone.geometry.polygon import area_vector
from drystone.geometry.polyhedron import (
    Loop,
    fan_triangles,
    loop_edges,
    mass_properties,
    rings,
    stack_faces,
)
from drystone.geometry.solid import winding_number
from drystone.geometry.surface import edge_uses, face_components

_INSIDE = 0.75
"""A face lies inside when the rest of the surface goes around both of its sides by more: around a
side of any other face it goes half."""
_BESIDE = 1e-4
"""Distance of the points on both sides, relative to the size of the face."""


def with_joints(vertices: Floats, faces: Sequence[Loop], near: float) -> tuple[list[Loop], int]:
    """Faces with the ends of open edges that lie on other open edges, and the number of these.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
    near : [m]

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [1, 0, 0], [1, 0, 1]])
    >>> with_joints(points, [(0, 1, 2, 3), (4, 0, 5)], 1e-6)
    ([(0, 4, 1, 2, 3), (4, 0, 5)], 1)
    """
    edges = [runs[0] for runs in edge_uses(faces).values() if len(runs) == 1]
    if not edges:
        return list(faces), 0
    ends = np.array([run for _, run in edges], dtype=np.intp)
    inside = points_between(vertices, ends, np.unique(ends), near)
    between = {edge: own for edge, own in zip(edges, inside, strict=True) if own}
    made: list[Loop] = []
    for f, loop in enumerate(faces):
        corners: list[int] = []
        for run in loop_edges(loop):
            own = between.get((f, run), [])
            corners += [run[0], *(vertex for vertex in own if vertex not in loop)]
        made.append(tuple(corners) if len(set(corners)) == len(corners) else loop)
    return made, sum(len(new) - len(old) for new, old in zip(made, faces, strict=True))


def points_between(vertices: Floats, ends: Ints, point: Ints, near: float) -> list[list[int]]:
    """The points that lie on each of some edges, between its ends, in their order along it.

    Parameters
    ----------
    vertices : (v, 3) [m]
    ends : (e, 2)
    point : (p,) vertices that are looked at
    near : [m]
    """
    start, along = vertices[ends[:, 0]], vertices[ends[:, 1]] - vertices[ends[:, 0]]
    square = (along**2).sum(axis=1)
    square = np.where(square > 0.0, square, 1.0)
    margin = near / np.sqrt(square)
    low, high = np.minimum(start, start + along) - near, np.maximum(start, start + along) + near
    found: list[list[tuple[float, int]]] = [[] for _ in ends]
    for i, j in boxes.batches(low, high, vertices[point], vertices[point]):
        away = vertices[point[j]] - start[i]
        share = (away * along[i]).sum(axis=1) / square[i]
        off = np.linalg.norm(away - share[:, None] * along[i], axis=1)
        on = (off <= near) & (share > margin[i]) & (share < 1.0 - margin[i])
        for edge, own, vertex in zip(i[on], share[on], point[j[on]], strict=True):
            found[int(edge)].append((float(own), int(vertex)))
    return [[vertex for _, vertex in sorted(own)] for own in found]


def without_membranes(vertices: Floats, faces: Sequence[Loop]) -> tuple[list[Loop], int]:
    """Faces without those that lie inside the body, at edges of three faces, and their number."""
    odd = {
        f for runs in edge_uses(faces).values() if len(runs) > 2 and len(runs) % 2 for f, _ in runs
    }
    inside: set[int] = set()
    for f in sorted(odd):
        rest = [faces[i] for i in range(len(faces)) if i != f and i not in inside]
        corner = vertices[list(faces[f])]
        normal, area = unit(area_vector(corner)[None])
        step = _BESIDE * float(np.sqrt(area[0])) * normal[0]
        sides = np.array([corner.mean(axis=0) + step, corner.mean(axis=0) - step])
        if (
            np.abs(winding_number(sides, fan_triangles(stack_faces([vertices], [rest]))[0])).min()
            > _INSIDE
        ):
            inside.add(f)
    return [face for f, face in enumerate(faces) if f not in inside], len(inside)


def plane_lids(vertices: Floats, faces: Sequence[Loop], near: float) -> tuple[list[Loop], int]:
    """Faces that close the plane holes of a surface, and the number of the holes.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Consistently oriented.
    near : [m]
        Largest distance of the corners of a hole from its plane. Other holes stay open.

    Examples
    --------
    >>> from drystone.models import box
    >>> cube = box((1.0, 1.0, 1.0))
    >>> lids, holes = plane_lids(cube.vertices, cube.faces[1:], 1e-6)
    >>> sorted(lids[0]) == sorted(cube.faces[0]), holes
    (True, 1)
    """
    rims = [rim for rim in _rims(faces) if _off_plane(vertices[list(rim)]) <= near]
    stacked = stack_faces([vertices], [rims])
    normal = stacked.normals
    order = np.argsort(-lengths(stacked.area_vectors), kind="stable").tolist()
    outlines: list[tuple[int, list[Loop]]] = []
    for i in order:
        here = vertices[rims[i][0]]
        for outer, holes in outlines:
            level = abs(float((here - vertices[rims[outer][0]]) @ normal[outer]))
            if normal[i] @ normal[outer] < -0.999 and level <= near:
                holes.append(rims[i])
                break
        else:
            outlines.append((i, []))
    lids: list[Loop] = []
    for outer, holes in outlines:
        lids += faces_with_holes(vertices, [[rims[outer], *holes]])
    return lids, len(outlines)


def _rims(faces: Sequence[Loop]) -> list[Loop]:
    """Loops along the open edges, as a face that closes them runs; none that touches itself."""
    after: dict[int, int] = {}
    forked: set[int] = set()
    for runs in edge_uses(faces).values():
        if len(runs) == 1:
            a, b = runs[0][1]
            if b in after:
                forked.add(b)
            after[b] = a
    return [
        tuple(rim)
        for rim in rings(after)
        if after.get(rim[-1]) == rim[0] and len(rim) > 2 and not forked & set(rim)
    ]


def _off_plane(corner: Floats) -> float:
    """Largest distance [m] of corners from the plane of their loop."""
    normal, area = unit(area_vector(corner)[None])
    if area[0] == 0.0:
        return np.inf
    return float(np.abs((corner - corner.mean(axis=0)) @ normal[0]).max())


def separate_parts(vertices: Floats, faces: Sequence[Loop]) -> tuple[list[list[Loop]], int]:
    """Parts of a body, each with its cavities, with all shells correctly oriented.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Closed, and consistently oriented within each shell.

    Returns
    -------
    parts
        Per part its loops. One part for a body that is in one piece.
    turned
        Number of shells that were inside out. A shell inside an even number of others is the
        outside of a part. A shell inside an odd number of others bounds a cavity.
    """
    components = face_components(faces)
    if len(components) == 1:
        return [list(faces)], 0
    loops = [[faces[i] for i in component] for component in components]
    stacked = stack_faces([vertices] * len(loops), loops)
    volume = mass_properties(stacked, len(loops))[0]
    corners = [vertices[sorted({v for loop in one for v in loop})] for one in loops]
    around = _shells_around(vertices, loops, corners)
    turned = 0
    for i, shell in enumerate(loops):
        cavity = len(around[i]) % 2 == 1
        if (volume[i] < 0.0) != cavity:
            loops[i] = [loop[::-1] for loop in shell]
            turned += 1
    parts: dict[int, list[Loop]] = {}
    for i, shell in enumerate(loops):
        home = i
        if len(around[i]) % 2 == 1:
            home = min(around[i], key=lambda j: abs(volume[j]))
        parts.setdefault(home, []).extend(shell)
    return list(parts.values()), turned


def _shells_around(
    vertices: Floats, loops: Sequence[Sequence[Loop]], corners: Sequence[Floats]
) -> list[list[int]]:
    """For each shell those that contain most of its vertices."""
    low = np.array([points.min(axis=0) for points in corners])
    high = np.array([points.max(axis=0) for points in corners])
    found: list[list[int]] = []
    for shell, points in enumerate(corners):
        inside = (low <= low[shell]).all(axis=1) & (high >= high[shell]).all(axis=1)
        inside[shell] = False
        found.append([])
        for other in np.flatnonzero(inside).tolist():
            surface = fan_triangles(stack_faces([vertices], [loops[other]]))[0]
            if float(np.median(np.abs(winding_number(points, surface)))) > 0.75:
                found[-1].append(other)
    return found
