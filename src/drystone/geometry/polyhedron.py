"""Closed polyhedra with polygon faces: topology, orientation, mass properties.

A face is a loop of vertex indices, counter-clockwise seen from outside; it may be concave and
slightly warped. A warped face stands for the fan about the mean of its corners. That fan does not
depend on where the loop starts.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import TypeVar

import numpy as np

from drystone.base.arrays import Floats, Ints, frozen, unit
from drystone.base.display import OneLine
from drystone.base.ragged import Ragged
from drystone.geometry.frames import area_vector, area_vectors

T = TypeVar("T")

Loop = tuple[int, ...]
Edge = tuple[int, int]
Piece = tuple[Floats, list[Loop]]
"""Vertices (v, 3) [m], and faces as loops of them."""


@dataclass(frozen=True)
class Faces(OneLine):
    """Polygon faces of many polyhedra as flat arrays.

    Attributes
    ----------
    point : (v, 3) [m]
    loop : (l,) index into ``point``, face after face
    start : (f + 1,) face i has the corners ``loop[start[i]:start[i + 1]]``
    owner : (f,) index of the polyhedron that the face belongs to
    """

    point: Floats
    loop: Ints
    start: Ints
    owner: Ints

    @property
    def count(self) -> int:
        """Number of faces."""
        return len(self.owner)

    @cached_property
    def corners(self) -> Ragged:
        """Which corners belong to which face."""
        return Ragged(self.start)

    @cached_property
    def area_vectors(self) -> Floats:
        """Area vectors (f, 3) [m2] of the faces."""
        return frozen(area_vectors(self.point[self.loop], self.start))

    @cached_property
    def normals(self) -> Floats:
        """Unit normals (f, 3) of the faces; zero for a face without area."""
        return frozen(unit(self.area_vectors)[0])

    @cached_property
    def middles(self) -> Floats:
        """Mean corner (f, 3) [m] of each face."""
        return frozen(self.corners.mean(self.point[self.loop]))


def stack_faces(vertices: Sequence[Floats], faces: Sequence[Sequence[Loop]]) -> Faces:
    """Flat arrays of the faces of several polyhedra.

    Parameters
    ----------
    vertices
        Per polyhedron (v, 3) [m].
    faces
        Per polyhedron its loops.
    """
    sizes = np.array([len(v) for v in vertices], dtype=np.intp)
    offset = Ragged.from_counts(sizes).start
    flat: dict[int, tuple[Ints, Ints]] = {}  # copies of one body share their face list
    for loops in faces:
        if id(loops) not in flat:
            corners = np.fromiter(chain.from_iterable(loops), dtype=np.intp)
            flat[id(loops)] = corners, np.fromiter(map(len, loops), dtype=np.intp)
    none = np.zeros(0, dtype=np.intp)
    loop = np.concatenate([none, *(flat[id(loops)][0] for loops in faces)])
    lengths = np.concatenate([none, *(flat[id(loops)][1] for loops in faces)])
    owner = np.repeat(
        np.arange(len(faces), dtype=np.intp),
        np.array([len(loops) for loops in faces], dtype=np.intp),
    )
    start = Ragged.from_counts(lengths).start
    loop = loop + np.repeat(offset[owner], lengths)
    point = np.concatenate(list(vertices)) if len(vertices) else np.zeros((0, 3))
    return Faces(point, loop, start, owner)


def fan_triangles(faces: Faces) -> tuple[Floats, Ints]:
    """Triangles (t, 3, 3) of every face's fan about its mean corner, and their face (t,)."""
    here, corners = faces.point[faces.loop], faces.corners
    middle = corners.spread(faces.middles)
    return np.stack([middle, here, here[corners.following]], axis=1), corners.owner


def mass_properties(faces: Faces, count: int) -> tuple[Floats, Floats]:
    """Volume and centroid of each polyhedron, by the divergence theorem.

    Parameters
    ----------
    faces
        Faces of ``count`` polyhedra, oriented outwards.
    count
        Number of polyhedra.

    Returns
    -------
    volume : (count,) [m3], negative when the faces point inwards
    centroid : (count, 3) [m], NaN where the volume is exactly zero

    Notes
    -----
    All sums are relative to a point of each polyhedron. A model far from the origin loses no
    digits. Source: Mirtich 1996; Eberly 2002.
    """
    triangles, face = fan_triangles(faces)
    owner = faces.owner[face]
    first_face = np.searchsorted(faces.owner, np.arange(count))
    origin = faces.point[faces.loop[faces.start[first_face]]]
    a, b, c = (triangles - origin[owner][:, None, :]).transpose(1, 2, 0)
    six_volume = _six_volumes(a, b, c)
    volume = np.bincount(owner, six_volume, minlength=count) / 6.0
    moment = np.stack(
        [np.bincount(owner, row, minlength=count) for row in six_volume * (a + b + c)], axis=1
    )
    safe = np.where(volume == 0.0, np.nan, volume)
    return volume, origin + moment / (24.0 * safe[:, None])


@dataclass(frozen=True, eq=False)
class Fan:
    """The triangles of :func:`fan_triangles` of one polyhedron, as indices: no coordinates.

    Attributes
    ----------
    corner, following : (t,) vertex at which each triangle's outer edge starts, and ends
    face : (t,)
    start : (f,) first triangle of each face
    sides : (f,) number of corners of each face
    """

    corner: Ints
    following: Ints
    face: Ints
    start: Ints
    sides: Ints

    @classmethod
    def of(cls, loops: Sequence[Loop]) -> Fan:
        """The fan of a polyhedron's faces."""
        sides = np.array([len(loop) for loop in loops], dtype=np.intp)
        return cls(
            corner=np.array([v for loop in loops for v in loop], dtype=np.intp),
            following=np.array([v for f in loops for v in (*f[1:], f[0])], dtype=np.intp),
            face=np.repeat(np.arange(len(loops), dtype=np.intp), sides),
            start=np.cumsum(sides) - sides,
            sides=sides,
        )


def body_mass_properties(vertices: Floats, fan: Fan) -> tuple[float, Floats]:
    """:func:`mass_properties` of one polyhedron whose fan is known.

    Parameters
    ----------
    vertices : (v, 3) [m]
    fan

    Returns
    -------
    volume : [m3]
    centroid : (3,) [m], NaN where the volume is exactly zero
    """
    origin = vertices[fan.corner[0]]
    local = (vertices - origin).T
    b, c = local.take(fan.corner, axis=1), local.take(fan.following, axis=1)
    a = (np.add.reduceat(b, fan.start, axis=1) / fan.sides).take(fan.face, axis=1)
    six_volume = _six_volumes(a, b, c)
    total = float(six_volume.sum())
    moment: Floats = (a + b + c) @ six_volume
    return total / 6.0, origin + moment / (4.0 * total if total != 0.0 else np.nan)


def _six_volumes(a: Floats, b: Floats, c: Floats) -> Floats:
    """Six times the signed volume (t,) of tetrahedra over the origin; each corner (3, t)."""
    (a0, a1, a2), (b0, b1, b2), (c0, c1, c2) = a, b, c
    return a0 * (b1 * c2 - b2 * c1) + a1 * (b2 * c0 - b0 * c2) + a2 * (b0 * c1 - b1 * c0)


BOX = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
"""Faces of a hexahedron whose vertices are the bottom loop 0 to 3, counter-clockwise from above,
and the top loop 4 to 7 over it."""


def box_corners(low: Floats, high: Floats) -> Floats:
    """Vertices (8, 3) of an axis-aligned box with faces :data:`BOX`."""
    upper = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=bool)
    return np.where(np.concatenate([upper, upper | (False, False, True)]), high, low)


def prism_faces(count: int) -> list[Loop]:
    """Faces of a prism: its bottom, vertices 0 on counter-clockwise from above, its top, its sides.

    Examples
    --------
    >>> prism_faces(3)
    [(2, 1, 0), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
    """
    here = range(count)
    bottom, top = tuple(reversed(here)), tuple(i + count for i in here)
    return [bottom, top, *((i, j, j + count, i + count) for i, j in loop_edges(here))]


def used_vertices(faces: Iterable[Sequence[int]]) -> tuple[list[int], list[Loop]]:
    """The vertices that faces have, ascending, and the faces with the numbers of these.

    Examples
    --------
    >>> used_vertices([(7, 2, 5), (5, 2, 9)])
    ([2, 5, 7, 9], [(2, 0, 1), (1, 0, 3)])
    """
    faces = list(faces)
    used = sorted({i for face in faces for i in face})
    new = {old: i for i, old in enumerate(used)}
    return used, [tuple(new[i] for i in face) for face in faces]


def loop_edges(loop: Sequence[int]) -> list[Edge]:
    """The edges of a loop, each from a vertex to the next.

    Examples
    --------
    >>> loop_edges([4, 7, 5])
    [(4, 7), (7, 5), (5, 4)]
    """
    return list(zip(loop, (*loop[1:], *loop[:1]), strict=True))


def rings(after: Mapping[T, T]) -> Iterator[list[T]]:
    """Walks from each key to its value, until they return or find no way on.

    Examples
    --------
    >>> list(rings({1: 2, 2: 3, 3: 1, 7: 8}))
    [[7], [3, 1, 2]]
    """
    left = dict(after)
    while left:
        first, at = left.popitem()
        ring = [first]
        while at != first and at in left:
            ring.append(at)
            at = left.pop(at)
        yield ring


def enclosed_volume(vertices: Floats, faces: Sequence[Loop]) -> float:
    """Volume [m3] that faces go around, seen from the middle of the vertices; some may be open."""
    local = vertices - vertices.mean(axis=0)
    corners = [local[list(face)] for face in faces if len(face) > 2]
    return sum(float(area_vector(at) @ at.mean(axis=0)) for at in corners) / 3.0


def edges_of(faces: Sequence[Loop]) -> Ints:
    """Edges (e, 2) of some faces: each once, lower vertex first, in ascending order."""
    pairs = {(min(i, j), max(i, j)) for face in faces for i, j in loop_edges(face)}
    return np.array(sorted(pairs), dtype=np.intp)
