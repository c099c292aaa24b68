"""Topology of a face list without coordinates: closed, manifold, oriented."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import named
from drystone.base.errors import DefectKind, InputError, counted
from drystone.base.ragged import first_linked, linked
from drystone.geometry.polyhedron import Edge, Fan, Loop, loop_edges, used_vertices

SHARED_FACES = 128
"""Longest face list in the cache, and number of lists in it. Chosen: 30 MB at most. Copies of one
body share their face list, and voussoirs of 3 x 3 facets: 140 of these, 108 faces each, move in 13
ms, and in 22 ms with 64. A longer list belongs to a scan or a freeform body and does not occur
twice."""
_SHARED_LISTS = 1024
TURNED = "all faces pointed inwards, and are turned"
"""What is said of a block that is drawn inside out."""


def worth_drawing(lines: Iterable[str]) -> list[str]:
    """Lines for the heading of a picture: without the blocks that are turned."""
    return [line for line in lines if not line.endswith(TURNED)]


@dataclass(frozen=True, eq=False)
class _SurfaceTopology:
    """A closed, oriented 2-manifold without coordinates.

    Attributes
    ----------
    loops
        Faces, consistently oriented: all outwards or all inwards.
    fan
        Their triangles.
    used
        The used vertices, in order; None when all are used. ``loops`` number these only.
    notes
        What was repaired.
    """

    loops: tuple[Loop, ...]
    fan: Fan
    used: tuple[int, ...] | None
    notes: tuple[str, ...]

    def select(self, vertices: Floats) -> Floats:
        """The used ones of the vertices (v, 3)."""
        return vertices if self.used is None else vertices[list(self.used)]

    def turned(self) -> _SurfaceTopology:
        """The same surface, inside out, with a note."""
        return _inside_out(self) if len(self.loops) <= SHARED_FACES else _turned(self)


def closed_surface(faces: Iterable[Sequence[int]], count: int) -> _SurfaceTopology:
    """The surface of faces over ``count`` vertices.

    Raises
    ------
    InputError
        Open, non-manifold, one-sided, or touching itself in a vertex; the edges are named.
    """
    loops = _integers(faces)
    return _shared(loops, count) if len(loops) <= SHARED_FACES else _surface(loops, count)


def fan_of(faces: tuple[Loop, ...], count: int) -> Fan:
    """The fan of a surface over ``count`` vertices that is known to be closed."""
    return _shared(faces, count).fan if len(faces) <= SHARED_FACES else Fan.of(faces)


def _integers(faces: Iterable[Sequence[int]]) -> tuple[Loop, ...]:
    loops: list[Loop] = []
    for face in faces:
        try:
            loops.append(tuple(map(int, face)))
        except (TypeError, ValueError) as error:
            raise InputError(f"face {len(loops)} is not a list of integers") from error
    return tuple(loops)


def _surface(faces: tuple[Loop, ...], count: int) -> _SurfaceTopology:
    _check_loops(faces, count)
    used, loops = used_vertices(faces)
    notes: list[str] = []
    if len(used) < count:
        faces = tuple(loops)
        unused = counted(count - len(used), "unused vertex", "unused vertices")
        notes.append(f"{unused} dropped")
    open_edges, crowded, consistent = edge_defects(faces)
    if crowded:
        raise InputError(
            f"non-manifold: more than two faces meet at edges {_edges_text(crowded, used)}",
            remedy="split the block there or remove inner faces",
            kind=DefectKind.CROWDED,
        )
    if open_edges:
        shown = _edges_text(open_edges, used)
        at = open_faces(faces)
        raise InputError(
            f"open mesh: {len(open_edges)} edges have one face only ({shown}), of"
            f" {'face' if len(at) == 1 else 'faces'} {named([*map(str, at)], 4)}, counted from 0 in"
            " the block",
            remedy="close the holes or merge coincident vertices; only a support may be open; a "
            "surface is cut into blocks by 'drystone shell'",
            kind=DefectKind.OPEN,
        )
    if not consistent:
        oriented, turned = orient(faces)
        if not edge_defects(oriented)[2]:
            raise InputError("its surface has no inside", remedy="it is one-sided: model it again")
        faces = tuple(oriented)
        notes.append(f"faces {', '.join(map(str, turned[:8]))} turned to agree with the others")
    pinched = pinched_vertices(faces)
    if pinched:
        raise InputError(
            f"its surface touches itself at vertex {used[pinched[0]]}",
            remedy="separate the parts there, or split it into two blocks",
            kind=DefectKind.CROWDED,
        )
    kept = tuple(used) if len(used) < count else None
    return _SurfaceTopology(faces, Fan.of(faces), kept, tuple(notes))


_shared = lru_cache(_SHARED_LISTS)(_surface)


def _turned(surface: _SurfaceTopology) -> _SurfaceTopology:
    loops = tuple(loop[::-1] for loop in surface.loops)
    notes = (*surface.notes, TURNED)
    return _SurfaceTopology(loops, Fan.of(loops), surface.used, notes)


_inside_out = lru_cache(_SHARED_LISTS)(_turned)


def _check_loops(loops: Sequence[Loop], count: int) -> None:
    for number, loop in enumerate(loops):
        if len(loop) < 3 or len(set(loop)) != len(loop):
            raise InputError(
                f"face {number} {list(loop)} needs three or more corners, none twice",
                remedy="remove repeated corners, split a face with a hole into several",
            )
        if min(loop) < 0 or max(loop) >= count:
            raise InputError(
                f"face {number} uses vertex {max(loop) if max(loop) >= count else min(loop)}",
                remedy=f"vertices are numbered 0 to {count - 1}",
            )
    if len(loops) < 4:
        raise InputError(
            f"has {counted(len(loops), 'face')}",
            remedy="a closed block has four or more; only a support may be open",
            kind=DefectKind.OPEN,
        )


def _edges_text(edges: list[Edge], number: Sequence[int]) -> str:
    """The first edges, with the caller's vertex numbers."""
    return named([f"{number[a]}-{number[b]}" for a, b in edges], 4)


def edge_uses(faces: Sequence[Loop]) -> dict[Edge, list[tuple[int, Edge]]]:
    """The faces at each edge, and how each runs along it."""
    uses: dict[Edge, list[tuple[int, Edge]]] = defaultdict(list)
    for f, loop in enumerate(faces):
        for a, b in loop_edges(loop):
            uses[min(a, b), max(a, b)].append((f, (a, b)))
    return uses


def edge_defects(faces: Sequence[Loop]) -> tuple[list[Edge], list[Edge], bool]:
    """Edges that keep a face list from being a closed 2-manifold.

    Returns
    -------
    open_edges
        Used by one face only.
    crowded_edges
        Used by more than two faces.
    consistent
        Whether every edge is run once in each direction.
    """
    count: dict[Edge, int] = defaultdict(int)
    balance: dict[Edge, int] = defaultdict(int)
    for loop in faces:
        previous = loop[-1]
        for vertex in loop:
            edge = (previous, vertex) if previous < vertex else (vertex, previous)
            count[edge] += 1
            balance[edge] += 1 if previous < vertex else -1
            previous = vertex
    open_edges = [e for e, used in count.items() if used == 1]
    crowded = [e for e, used in count.items() if used > 2]
    return open_edges, crowded, not any(balance.values())


def orient(faces: Sequence[Loop]) -> tuple[list[Loop], list[int]]:
    """Orient the faces of each connected part like its first face.

    Returns
    -------
    faces
        Loops, some reversed.
    turned
        Indices of the reversed ones.

    Notes
    -----
    At an edge of one face, or of more than two, nothing is compared. A surface that cannot be
    oriented keeps inconsistent edges: :func:`edge_defects` of the result finds them.
    """
    shared = [
        (f, g, one == other)
        for (f, one), (g, other) in (two for two in edge_uses(faces).values() if len(two) == 2)
    ]
    f, g, against = np.array(shared, dtype=np.intp).reshape(-1, 3).T
    # each face is there twice: as it is, and turned
    one, other = (2 * f, 2 * f + 1), (2 * g + against, 2 * g + 1 - against)
    first = first_linked(np.concatenate(one), np.concatenate(other), 2 * len(faces))
    turned = np.flatnonzero(first[::2] % 2).tolist()
    oriented = list(faces)
    for i in turned:
        oriented[i] = faces[i][::-1]
    return oriented, turned


def open_faces(faces: Sequence[Loop]) -> list[int]:
    """Faces with an edge that no other face uses."""
    return sorted({runs[0][0] for runs in edge_uses(faces).values() if len(runs) == 1})


def face_components(faces: Sequence[Loop]) -> list[list[int]]:
    """Faces grouped into parts connected through shared vertices."""
    ends = np.array([(loop[0], v) for loop in faces for v in loop], dtype=np.intp).reshape(-1, 2)
    part = linked(ends[:, 0], ends[:, 1], int(ends.max(initial=-1)) + 1)
    groups: dict[int, list[int]] = defaultdict(list)
    for f, loop in enumerate(faces):
        groups[int(part[loop[0]])].append(f)
    return list(groups.values())


def pinched_vertices(faces: Sequence[Loop]) -> list[int]:
    """Vertices at which a closed surface touches itself: their faces form more than one fan."""
    links: dict[int, dict[int, int]] = defaultdict(dict)
    for loop in faces:
        n = len(loop)
        for i, v in enumerate(loop):
            links[v][loop[i - 1]] = loop[(i + 1) % n]
    pinched = []
    for vertex, link in links.items():
        start = next(iter(link))
        current, steps = link[start], 1
        while current != start and current in link and steps <= len(link):
            current = link[current]
            steps += 1
        if current != start or steps != len(link):
            pinched.append(vertex)
    return pinched
