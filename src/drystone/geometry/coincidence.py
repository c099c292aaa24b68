"""Points that coincide, and bodies that occur twice."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from drystone.base.arrays import SAME, Floats, Ints
from drystone.base.ragged import Ragged, first_linked
from drystone.geometry.polyhedron import Loop

_PAIRED = 48
"""Up to so many points all pairs are compared first: faster than the grids, measured."""
_FEW = 200
"""Below so many rows a dictionary finds equal ones faster than sorting does, measured."""


def first_coincident(points: Floats, distance: float | Floats, body: Ints | None = None) -> Ints:
    """For each point the first of the group of points that it coincides with.

    Parameters
    ----------
    points : (p, 3) [m]
    distance : [m], or (p,) one for each point, the same within a body
        Points within this distance coincide, and so do chains of them. Points more than four times
        as far apart do not, unless a chain joins them.
    body : (p,), optional
        Points of different bodies do not coincide.

    Notes
    -----
    Eight grids with cells of twice the distance, shifted by half a cell: near points share a cell
    of at least one grid. The time is linear, even when all points coincide.
    """
    count = len(points)
    if count == 0:
        return np.zeros(0, dtype=np.intp)
    owner = np.zeros(count, dtype=np.intp) if body is None else body
    same = _first_alike([owner, *points.T])
    kept = np.flatnonzero(same == np.arange(count))
    cell = 2.0 * np.broadcast_to(np.asarray(distance, dtype=np.float64), (count,))[kept]
    if not (cell > 0.0).any() or (len(kept) <= _PAIRED and not _any_near(points[kept], cell)):
        return same
    first = kept[_joined(points[kept], cell, owner[kept])]
    whole = np.arange(count, dtype=np.intp)
    whole[kept] = first
    return whole[same]


def _any_near(points: Floats, cell: Floats) -> bool:
    """Whether two of few points are so near in every coordinate that they could share a cell."""
    near = (np.abs(points[:, None] - points) <= (1.0 + SAME) * cell.max()).all(axis=2)
    return int(near.sum()) > len(points)


def distinct(points: Floats, distance: float) -> tuple[Ints, Ints]:
    """The points that remain when those that coincide are made one.

    Parameters
    ----------
    points : (p, 3) [m]
    distance : [m]
        See :func:`first_coincident`.

    Returns
    -------
    kept : (k,)
        Ascending positions of the points that remain: the first of each group.
    number : (p,)
        Which of those each point coincides with.
    """
    kept, number = np.unique(first_coincident(points, distance), return_inverse=True)
    return kept, number.astype(np.intp)


def _joined(points: Floats, cell: Floats, owner: Ints) -> Ints:
    """For each distinct point the first point that it coincides with."""
    count = len(points)
    low = np.full((int(owner.max()) + 1, 3), np.inf)
    np.minimum.at(low, owner, points)
    size = np.where(cell > 0.0, cell, 1.0)[:, None]
    scaled = (points - low[owner]) / size
    links = [
        _first_alike([owner, *np.floor(scaled + np.array(shift)).T])
        for shift in product((0.0, 0.5), repeat=3)
    ]
    here = np.arange(count, dtype=np.intp)
    moved = [link != here for link in links]
    if not any(move.any() for move in moved):
        return here
    source = np.concatenate([here[move] for move in moved])
    target = np.concatenate([link[move] for link, move in zip(links, moved, strict=True)])
    return first_linked(source, target, count)


def _first_alike(columns: Sequence[Floats | Ints]) -> Ints:
    """For each row the first row that equals it in every column."""
    if len(columns[0]) < _FEW:
        first: dict[tuple[float, ...], int] = {}
        rows = zip(*(column.tolist() for column in columns), strict=True)
        alike = [first.setdefault(row, i) for i, row in enumerate(rows)]
        return np.array(alike, dtype=np.intp)
    key = np.zeros(len(columns[0]), dtype=np.int64)
    for column in columns:
        _, rank = np.unique(column, return_inverse=True)
        _, key = np.unique(key * (int(rank.max()) + 1) + rank, return_inverse=True)
    of_key = np.full(int(key.max()) + 1, len(key), dtype=np.intp)
    np.minimum.at(of_key, key, np.arange(len(key), dtype=np.intp))
    return of_key[key]


def weld(
    vertices: Floats, faces: Sequence[Sequence[int]], tolerance: float
) -> tuple[tuple[Loop, ...], int]:
    """Faces with coincident vertices replaced by one.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops of vertex indices.
    tolerance
        Distance that counts as coincident, relative to the bounding box diagonal.

    Returns
    -------
    faces
        The same loops over the first of each group of coincident vertices. A corner that coincides
        with the one before it is removed. A face with fewer than three corners is removed.
    merged
        Number of vertices that are no longer used.

    Examples
    --------
    >>> twin = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0]])
    >>> weld(twin, [(0, 1, 2), (3, 2, 1)], 1e-9)
    (((0, 1, 2), (0, 2, 1)), 1)
    """
    return weld_each([vertices], [faces], tolerance)[0]


def weld_each(
    vertices: Sequence[Floats], faces: Sequence[Sequence[Sequence[int]]], tolerance: float
) -> list[tuple[tuple[Loop, ...], int]]:
    """:func:`weld` for many bodies at once, which is faster than one after the other.

    Parameters
    ----------
    vertices
        Per body (v, 3) [m].
    faces
        Per body its loops.
    tolerance
        Relative to the bounding box diagonal of each body.
    """
    of_body = Ragged.of(vertices)
    every = np.concatenate([np.zeros((0, 3)), *vertices])
    reach = tolerance * np.linalg.norm(of_body.max(every, 0.0) - of_body.min(every, 0.0), axis=1)
    first = first_coincident(every, of_body.spread(reach), of_body.owner).tolist()
    starts = zip(faces, of_body.first.tolist(), strict=True)
    return [_on_first(loops, first, begin) for loops, begin in starts]


def _on_first(
    faces: Sequence[Sequence[int]], first: Sequence[int], begin: int
) -> tuple[tuple[Loop, ...], int]:
    """Loops of one body over the first of each group of vertices, and how many go unused."""
    used = {i for face in faces for i in face}
    loops = []
    for face in faces:
        corners = [first[begin + i] - begin for i in face]
        loop = [v for i, v in enumerate(corners) if v != corners[i - 1]]
        if len(loop) >= 3:
            loops.append(tuple(loop))
    kept = {i for loop in loops for i in loop}
    return tuple(loops), len(used) - len(kept)


def once(faces: Sequence[Loop], *, sided: bool = False) -> tuple[list[Loop], int]:
    """The faces without repeated ones, and the number of repeated ones.

    Faces of opposite orientation are repeated ones too, unless ``sided``.

    Examples
    --------
    >>> once([(0, 1, 2), (3, 2, 1, 0), (1, 2, 0), (2, 1, 0), (0, 2, 1, 3)])
    ([(0, 1, 2), (3, 2, 1, 0), (0, 2, 1, 3)], 2)
    """
    first: dict[Loop, Loop] = {}
    for face in faces:
        turns = []
        for loop in (tuple(face),) if sided else (tuple(face), tuple(face)[::-1]):
            least = loop.index(min(loop)) if loop else 0
            turns.append(loop[least:] + loop[:least])
        first.setdefault(min(turns), face)
    return list(first.values()), len(faces) - len(first)


def duplicates(vertices: Sequence[Floats], tolerance: float) -> list[tuple[int, int]]:
    """Pairs of bodies with the same vertices, in any order: the first such body and each later one.

    Parameters
    ----------
    vertices
        Per body (v, 3) [m].
    tolerance
        Distance between equal vertices, relative to the median size of the bodies.
    """
    if len(vertices) < 2:
        return []
    low = np.array([v.min(axis=0) for v in vertices])
    high = np.array([v.max(axis=0) for v in vertices])
    distance = tolerance * float(np.median(np.linalg.norm(high - low, axis=1)))
    middle = first_coincident(0.5 * (low + high), distance)
    extent = first_coincident(high - low, distance)
    kinds: dict[tuple[int, int, int], list[int]] = {}
    found = []
    for body, points in enumerate(vertices):
        kind = (int(middle[body]), int(extent[body]), len(points))
        like = kinds.setdefault(kind, [])
        for other in like:
            if _same_points(vertices[other], points, distance):
                found.append((other, body))
                break
        else:
            like.append(body)
    return found


def _same_points(one: Floats, other: Floats, distance: float) -> bool:
    """Whether the points of the two sets match one to one."""
    count = len(one)
    first = first_coincident(np.concatenate([one, other]), distance)
    return np.array_equal(np.sort(first[:count]), np.sort(first[count:]))
