"""Solids in a soup of faces, also where they touch and share vertices and edges.

What keeps a surface from being closed is mended: missing joints and lids, faces inside.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drystone.base.arrays import SAME, Bools, Floats, Ints, lengths, unit
from drystone.base.ragged import Ragged, linked, sum_by_owner
from drystone.geometry import boxes
from drystone.geometry.frames import area_vector, frames_from_normals
from drystone.geometry.planar import faces_with_holes
from drystone.geometry.polyhedron import (
    Faces,
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


def split_solids(
    vertices: Floats, faces: Sequence[Loop], soup: Ints | None = None
) -> list[list[int]]:
    """Faces grouped into solids.

    Parameters
    ----------
    vertices : (v, 3) [m]
        Coincident ones merged, see :func:`drystone.geometry.coincidence.weld`.
    faces
        Loops, consistently oriented in each soup.
    soup : (f,), optional
        Ascending. Faces of different soups share no vertices and belong to different solids.

    Returns
    -------
    list of face indices per solid, by first face
        A cavity belongs to the solid around it.

    Notes
    -----
    Two faces belong to one solid when they meet at an edge that no other face uses. Where solids
    touch, more than two faces use an edge. In angular order about the edge these faces bound
    sectors of material; the two faces of a sector belong to one solid. A common vertex alone does
    not join two faces.
    """
    if not faces:
        return []
    stacked = _of_shells(vertices, faces, [range(len(faces))])
    if soup is not None:
        _, number = np.unique(soup, return_inverse=True)
        stacked = replace(stacked, owner=number.astype(np.intp))
    volume = mass_properties(stacked, int(stacked.owner[-1]) + 1)[0]
    outwards = np.where(volume < 0.0, -1.0, 1.0)[stacked.owner]
    part = _components(stacked, outwards)
    return _with_cavities(vertices, faces, part, stacked.owner, outwards)


def without_slivers(
    vertices: Floats, faces: Sequence[Loop], height: Floats
) -> tuple[list[Loop], Ints]:
    """Faces without triangles of zero height, and the numbers of the faces that remain.

    Meshing programs close a straight line between three vertices with such a triangle. It is
    removed, and its middle vertex is inserted into the long edge of every neighbouring face. So a
    closed surface stays closed and no point moves.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops of different vertices.
    height : (v,) [m]
        At each vertex the largest height of a triangle that counts as zero.

    Returns
    -------
    faces
    kept : (f,)
        Their numbers among the given faces.
    """
    every = np.arange(len(faces), dtype=np.intp)
    triangle = np.array([f for f in faces if len(f) == 3], dtype=np.intp).reshape(-1, 3)
    if len(triangle) == 0:
        return list(faces), every
    corner = vertices[triangle]
    side = np.linalg.norm(corner[:, [1, 2, 0]] - corner, axis=2)
    longest = side.argmax(axis=1)
    double = np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    thin = double <= height[triangle[:, 0]] * side.max(axis=1)
    between: dict[tuple[int, int], set[int]] = defaultdict(set)
    for loop, long in zip(triangle[thin].tolist(), longest[thin].tolist(), strict=True):
        a, c, b = loop[long], loop[(long + 1) % 3], loop[(long + 2) % 3]
        between[min(a, c), max(a, c)].add(b)
    slivers = {tuple(loop) for loop in triangle[thin].tolist()}
    if not slivers:
        return list(faces), every
    kept = every[[f not in slivers for f in faces]]
    return [_subdivided(faces[i], between, vertices) for i in kept.tolist()], kept


def _subdivided(loop: Loop, between: dict[tuple[int, int], set[int]], vertices: Floats) -> Loop:
    """The loop with the vertices that lie on its edges."""
    out: list[int] = []
    edges = loop_edges(loop)[::-1]
    while edges:
        a, b = edges.pop()
        middle = between.get((min(a, b), max(a, b)), set()) - {*loop, *out}
        if not middle:
            out.append(a)
            continue
        ordered = sorted(middle, key=lambda v: float(np.linalg.norm(vertices[v] - vertices[a])))
        chain = [a, *ordered, b]
        edges.extend(zip(chain[-2::-1], chain[:0:-1], strict=True))
    return tuple(out)


def pulled_apart(
    vertices: Floats, faces: Sequence[Loop], by: float
) -> tuple[Floats, list[Loop], int]:
    """The surface with a vertex of its own for each part of it that meets others there.

    Where a surface touches itself along an edge or at a corner, as voxels do, its parts get copies
    of the vertices there. Copies of one body are moved into its material; bodies that touch each
    other stay where they are.

    Parameters
    ----------
    vertices : (v, 3) [m]
        Coincident ones merged.
    faces
        Loops, consistently oriented.
    by : [m]

    Returns
    -------
    vertices : (w, 3) [m]
    faces
    parted
        Number of vertices at which a body touched itself.

    Examples
    --------
    >>> from drystone.models import box
    >>> one, other = box((1.0, 1.0, 1.0)), box((1.0, 1.0, 1.0), (1.0, 1.0, 0.0))
    >>> both = np.concatenate([one.vertices, other.vertices])
    >>> kept, number = np.unique(both, axis=0, return_inverse=True)
    >>> twice = [*one.faces, *(tuple(i + 8 for i in face) for face in other.faces)]
    >>> shared = [tuple(int(number[i]) for i in face) for face in twice]
    >>> points, loops, parted = pulled_apart(kept, shared, 1e-6)
    >>> len(kept), len(points), parted
    (14, 16, 0)
    """
    stacked = _of_shells(vertices, faces, [range(len(faces))])
    outwards = np.where(mass_properties(stacked, 1)[0] < 0.0, -1.0, 1.0)[stacked.owner]
    half, twin = _neighbours(stacked, outwards)
    loop, after = stacked.loop, stacked.corners.following
    turned = loop[half] == loop[after[twin]]
    one = np.concatenate([half, after[half]])
    first, last = np.where(turned, after[twin], twin), np.where(turned, twin, after[twin])
    corner = linked(one, np.concatenate([first, last]), len(loop))
    fan, at = np.unique(corner, return_index=True)
    of_vertex = loop[at]
    loops = [tuple(part.tolist()) for part in stacked.corners.split(corner)]
    body = np.zeros(len(fan), dtype=np.intp)
    for number, part in enumerate(face_components(loops)):
        body[[i for f in part for i in loops[f]]] = number
    _, place, uses = np.unique(
        of_vertex * np.int64(len(fan)) + body, return_inverse=True, return_counts=True
    )
    shared = uses[place] > 1
    normal = unit(stacked.area_vectors * outwards[:, None])[0][stacked.corners.owner]
    inwards = -unit(sum_by_owner(normal, corner, len(fan)))[0]
    moved = np.where(shared[:, None], by * inwards, 0.0)
    return vertices[of_vertex] + moved, loops, len(np.unique(of_vertex[shared]))


def _components(faces: Faces, outwards: Floats) -> Ints:
    """Component (f,) of each face, joined across edges; ``outwards`` is -1 in soups inside out."""
    half, twin = _neighbours(faces, outwards)
    face = faces.corners.owner
    return linked(face[half], face[twin], faces.count)


def _neighbours(faces: Faces, outwards: Floats) -> tuple[Ints, Ints]:
    """Pairs of half-edges at which two faces of one surface meet, by their first corners."""
    face = np.repeat(np.arange(faces.count, dtype=np.intp), np.diff(faces.start))
    tail, head = faces.loop, faces.loop[faces.corners.following]
    key = np.minimum(tail, head) * np.int64(len(faces.point)) + np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.concatenate([[True], np.diff(key[order]) > 0]))
    used = np.diff(np.concatenate([first, [len(key)]]))
    pair = first[used == 2]
    one, other = [order[pair]], [order[pair + 1]]
    crowded = np.flatnonzero(used > 2)
    if len(crowded):
        rows = np.concatenate([np.arange(first[i], first[i] + used[i]) for i in crowded])
        half = order[rows]
        edge = np.repeat(np.arange(len(crowded)), used[crowded])
        forward = (tail < head) == (outwards[face] > 0.0)
        a, b = _sector_pairs(faces, half, edge, tail, head, face, forward[half])
        one.append(a)
        other.append(b)
    return np.concatenate(one), np.concatenate(other)


def _sector_pairs(
    faces: Faces, half: Ints, edge: Ints, tail: Ints, head: Ints, face: Ints, ends: Bools
) -> tuple[Ints, Ints]:
    """Pairs of half-edges of faces that bound a sector of material about crowded edges.

    A face that runs its edge forwards (from the lower vertex) has its material behind it, at
    smaller angles: it ends a sector. One that runs it backwards begins one. (The other way round
    where the whole soup is inside out.)
    """
    forward = tail[half] < head[half]
    low, high = np.minimum(tail, head)[half], np.maximum(tail, head)[half]
    along = unit(faces.point[high] - faces.point[low])[0]
    frame = frames_from_normals(along)
    normal = faces.area_vectors[face[half]]
    inwards = np.cross(normal, np.where(forward[:, None], along, -along))
    angle = np.arctan2((inwards * frame[:, 2]).sum(axis=1), (inwards * frame[:, 1]).sum(axis=1))
    one: list[int] = []
    other: list[int] = []
    begin = np.flatnonzero(np.concatenate([[True], np.diff(edge) > 0]))
    for rows in np.split(np.arange(len(half)), begin[1:]):
        ordered = _in_turn(angle[rows], ends[rows])
        waiting: list[int] = []
        for i in (rows[ordered]).tolist() * 2:
            if not ends[i]:
                waiting.append(i)
            elif waiting:
                one.append(int(half[waiting.pop()]))
                other.append(int(half[i]))
    return np.array(one, dtype=np.intp), np.array(other, dtype=np.intp)


def _in_turn(angle: Floats, ends: Bools) -> Ints:
    """Order about an edge that starts after the widest gap; at one angle, ends come first."""
    order = np.argsort(angle, kind="stable")
    turned = angle[order]
    gap = np.diff(np.concatenate([turned, turned[:1] + 2.0 * np.pi]))
    widest = int(gap.argmax()) + 1
    order, gap = np.roll(order, -widest), np.roll(gap, -widest)
    cluster = np.concatenate([[0], np.cumsum(gap[:-1] > SAME)])
    rank: Ints = np.lexsort([~ends[order], cluster])
    return order[rank]


def _with_cavities(
    vertices: Floats, faces: Sequence[Loop], part: Ints, soup: Ints, outwards: Floats
) -> list[list[int]]:
    """Faces per solid; a component oriented inwards inside another is its cavity."""
    members: dict[int, list[int]] = defaultdict(list)
    for i, p in enumerate(part.tolist()):
        members[p].append(i)
    shells = list(members.values())
    if len(shells) == 1:
        return shells
    stacked = _of_shells(vertices, faces, shells)
    lead = np.array([shell[0] for shell in shells])
    volume = mass_properties(stacked, len(shells))[0] * outwards[lead]
    of_shell = Ragged.from_owners(stacked.corners.spread(stacked.owner), len(shells))
    corner = stacked.point[stacked.loop]
    low, high = of_shell.min(corner), of_shell.max(corner)
    home = list(range(len(shells)))
    closed = _closed(stacked, len(shells))
    for cavity in np.flatnonzero((volume < 0.0) & closed).tolist():
        around = ((low <= low[cavity]) & (high >= high[cavity])).all(axis=1)
        around &= closed & (volume > -volume[cavity]) & (soup[lead] == soup[lead[cavity]])
        for solid in np.flatnonzero(around)[np.argsort(volume[around])].tolist():
            around_it = fan_triangles(_of_shells(vertices, faces, [shells[solid]]))[0]
            middle = 0.5 * (low[cavity] + high[cavity])
            if abs(winding_number(middle[None], around_it)[0]) > 0.5:
                home[cavity] = solid
                break
    solids: dict[int, list[int]] = defaultdict(list)
    for shell_faces, solid in zip(shells, home, strict=True):
        solids[solid].extend(shell_faces)
    return sorted((sorted(s) for s in solids.values()), key=lambda s: s[0])


def _closed(stacked: Faces, count: int) -> Bools:
    """Whether each body (count,) has two faces at every edge."""
    length = np.diff(stacked.start)
    after = stacked.loop[stacked.corners.following]
    side = np.sort(np.stack([stacked.loop, after], axis=1), axis=1)
    key = np.column_stack([np.repeat(stacked.owner, length), side])
    edge, uses = np.unique(key, axis=0, return_counts=True)
    odd = np.bincount(edge[:, 0], uses % 2, minlength=count)
    return odd == 0


def _of_shells(vertices: Floats, faces: Sequence[Loop], shells: Sequence[Sequence[int]]) -> Faces:
    """The faces of each shell, one shell after the other, over common vertices."""
    loops = [faces[i] for shell in shells for i in shell]
    lengths = np.array([len(loop) for loop in loops], dtype=np.intp)
    return Faces(
        vertices,
        np.array([corner for loop in loops for corner in loop], dtype=np.intp),
        Ragged.from_counts(lengths).start,
        np.repeat(np.arange(len(shells)), [len(shell) for shell in shells]),
    )
