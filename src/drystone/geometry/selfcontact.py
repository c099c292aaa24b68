"""Closed surfaces that touch or cross themselves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, dot, unit
from drystone.base.ragged import BATCH, Ragged, expand
from drystone.geometry import boxes
from drystone.geometry.polyhedron import Faces, Loop, stack_faces

_SIDE = 2.0
"""An edge pierces a face when its ends lie farther from the plane than this multiple of the warp of
the face, on opposite sides. Chosen: the true surface of a warped face lies within its warp."""
_MOST_PAIRS = 20_000_000
"""The search stops after this many pairs of overlapping boxes. Chosen: some seconds. A body whose
parts all overlap is not searched to the end."""

_Finding = tuple[int, str]


@dataclass(frozen=True)
class _Surface:
    """Bodies scaled to size 1 and moved apart, so that only parts of one body are near each other.

    Letters: v vertices, e edges, f faces.

    Attributes
    ----------
    faces
    number : (f,) of each face in its body
    vertices : of each body
    """

    faces: Faces
    number: Ints
    vertices: Ragged

    def of_faces(self, keep: Bools) -> _Surface:
        """Some of the faces (f,)."""
        corners, row = self.faces.corners.take(keep)
        faces = Faces(self.faces.point, self.faces.loop[row], corners.start, self.faces.owner[keep])
        return replace(self, faces=faces, number=self.number[keep])

    @cached_property
    def _local(self) -> Floats:
        """Corners (l, 3) about the middle of their face."""
        faces = self.faces
        return faces.point[faces.loop] - faces.corners.spread(faces.middles)

    @cached_property
    def warp(self) -> Floats:
        """(f,) largest distance of a corner from the plane."""
        corners = self.faces.corners
        return corners.max(np.abs(dot(self._local, corners.spread(self.faces.normals))))

    @cached_property
    def axes(self) -> Floats:
        """(f, 2, 3) in the plane."""
        normal = self.faces.normals
        u = np.cross(normal, np.eye(3)[np.abs(normal).argmin(axis=1)])
        u /= np.maximum(np.linalg.norm(u, axis=1), 1e-300)[:, None]
        return np.stack([u, np.cross(normal, u)], axis=1)

    @cached_property
    def outline(self) -> NDArray[Any]:
        """(f,) shapely polygons, in the plane."""
        face = self.faces.corners.owner
        plane = np.einsum("lj,lij->li", self._local, self.axes[face])
        return np.asarray(shapely.polygons(shapely.linearrings(plane, indices=face)))

    @cached_property
    def edge(self) -> Ints:
        """(e, 2) vertices, each edge once."""
        ends = self.faces.loop, self.faces.loop[self.faces.corners.following]
        count = len(self.faces.point)
        return np.stack(
            np.divmod(np.unique(np.minimum(*ends) * count + np.maximum(*ends)), count), axis=1
        )

    def ends(self) -> tuple[Floats, Floats]:
        """First and second end (e, 3) of every edge."""
        return self.faces.point[self.edge[:, 0]], self.faces.point[self.edge[:, 1]]

    def height(self, points: Floats, face: Ints) -> Floats:
        """Signed distance of each point from the plane of its face."""
        return dot(points - self.faces.middles[face], self.faces.normals[face])

    def in_plane(self, points: Floats, face: Ints) -> NDArray[Any]:
        """Each point in the plane of its face, as shapely points."""
        flat = np.einsum("pj,pij->pi", points - self.faces.middles[face], self.axes[face])
        return np.asarray(shapely.points(flat))


def self_contacts(vertices: Sequence[Floats], faces: Sequence[Sequence[Loop]]) -> list[_Finding]:
    """The first self-contact of each closed polyhedron that has one.

    Parameters
    ----------
    vertices
        Per body (v, 3) [m].
    faces
        Per body its loops: a closed 2-manifold, oriented outwards.

    Returns
    -------
    Position of the body, and what is wrong: a verb and its object, such as "touches itself: vertex
    3 lies on face 7".

    Notes
    -----
    A convex body cannot touch itself and is skipped. In other bodies the search looks for four
    faults: a face whose outline crosses itself; an edge that pierces a face; a vertex that lies on
    a face of which it is no corner; two edges that cross away from their ends. Faces that planes
    keep apart from all others near them are not looked at again.
    """
    concave = np.flatnonzero(~convex_bodies(vertices, faces)).tolist()
    if not concave:
        return []
    surface = _surface([vertices[i] for i in concave], [faces[i] for i in concave])
    near = surface.of_faces(_may_touch(surface))
    found: dict[int, str] = {}
    for body, what in chain(
        _crossed_outlines(surface),
        _pierced_faces(near),
        _touching_vertices(near),
        _touching_edges(near),
    ):
        found.setdefault(body, what)
    return [(concave[body], what) for body, what in sorted(found.items())]


def _surface(vertices: Sequence[Floats], faces: Sequence[Sequence[Loop]]) -> _Surface:
    placed = []
    for i, points in enumerate(vertices):
        low, high = points.min(axis=0), points.max(axis=0)
        placed.append((points - low) / np.linalg.norm(high - low) + np.array([2.0 * i, 0.0, 0.0]))
    stacked = stack_faces(placed, faces)
    number = np.arange(stacked.count) - Ragged.of(faces).spread(Ragged.of(faces).first)
    return _Surface(stacked, number, Ragged.of(vertices))


def _may_touch(surface: _Surface) -> Bools:
    """The faces (f,) that no plane keeps apart from each other face near them.

    Nearly all facets of a fine mesh are kept apart from their neighbours, and from those on the
    other side of a thin part. Only triangles and quadrangles are tried.
    """
    faces = surface.faces
    count = faces.corners.counts
    ring = faces.loop[faces.start[:-1, None] + np.minimum(np.arange(4), count[:, None] - 1)]
    found = np.zeros(faces.count, dtype=bool)
    around = _face_boxes(surface)
    for one, other in _near(*around, around):
        later = one < other
        one, other = one[later], other[later]
        left = np.ones(len(one), dtype=bool)
        few = np.flatnonzero((count[one] <= 4) & (count[other] <= 4))
        left[few] = ~_kept_apart(surface, ring, one[few], other[few])
        found[one[left]] = found[other[left]] = True
    return found


def _kept_apart(surface: _Surface, ring: Ints, one: Ints, other: Ints) -> Bools:
    """Whether a plane between two faces (q,) meets both at most in a common corner or edge.

    Tried are the plane across the way between their middles, through what they share, and those of
    the faces themselves.

    Parameters
    ----------
    ring : (f, c)
        Corners of each face; the last one again where there are fewer.
    """
    point, middle = surface.faces.point, surface.faces.middles
    mine, theirs = ring[one], ring[other]
    same = mine[:, :, None] == theirs[:, None, :]
    common, theirs_common = same.any(axis=2), same.any(axis=1)
    shares = common.any(axis=1)
    rows = np.arange(len(one))
    first = mine[rows, common.argmax(axis=1)]
    last = mine[rows, common.shape[1] - 1 - common[:, ::-1].argmax(axis=1)]
    at = np.where(shares[:, None], point[first], 0.5 * (middle[one] + middle[other]))
    edge = unit(np.where(shares[:, None], point[last] - point[first], 0.0))[0]
    ways = []
    for face in (one, other):
        way = middle[face] - at
        ways.append(unit(way - dot(way, edge)[:, None] * edge)[0])
    apart, rounding = np.zeros(len(one), dtype=bool), 1e-3 * ROUNDING
    for normal in (ways[1] - ways[0], surface.faces.normals[one], surface.faces.normals[other]):
        left = np.flatnonzero(~apart)
        axis = normal[left]
        away = dot(middle[other[left]] - middle[one[left]], axis)
        axis = np.where((away < 0.0)[:, None], -axis, axis)
        low, high = (
            np.einsum("qcj,qj->qc", point[corners[left]] - at[left, None], axis)
            for corners in (mine, theirs)
        )
        level = np.where(shares[left], 0.0, low.max(axis=1))[:, None]
        below = np.where(common[left], -np.inf, low - level).max(axis=1)
        above = np.where(theirs_common[left], np.inf, high - level).min(axis=1)
        onto = (low - level).max(axis=1) <= rounding
        beneath = (high - level).min(axis=1) >= -rounding
        apart[left] = (onto & (above > ROUNDING)) | (beneath & (below < -ROUNDING))
    return apart


def _crossed_outlines(surface: _Surface) -> Iterator[_Finding]:
    """Faces whose outline crosses or touches itself."""
    faces = surface.faces
    square = dot(faces.area_vectors, faces.area_vectors)
    span = faces.corners.max(dot(surface._local, surface._local))
    thin = square <= (1e-12 * span) ** 2
    some = surface.of_faces((faces.corners.counts > 3) | thin)
    for face in np.flatnonzero(~shapely.is_valid(some.outline)).tolist():
        what = f"crosses itself in the outline of face {some.number[face]}"
        yield int(some.faces.owner[face]), what


def _near(low: Floats, high: Floats, others: tuple[Floats, Floats]) -> Iterator[tuple[Ints, Ints]]:
    """Pairs of axis-aligned boxes that overlap, in batches: position, position among others."""
    looked_at = 0
    grown = others[0] - ROUNDING, others[1] + ROUNDING
    for one, other in boxes.batches(low - ROUNDING, high + ROUNDING, *grown):
        looked_at += len(one)
        if looked_at > _MOST_PAIRS:
            return
        yield one, other


def _face_boxes(surface: _Surface) -> tuple[Floats, Floats]:
    corner = surface.faces.point[surface.faces.loop]
    return surface.faces.corners.min(corner), surface.faces.corners.max(corner)


def _edge_boxes(surface: _Surface) -> tuple[Floats, Floats]:
    one, other = surface.ends()
    return np.minimum(one, other), np.maximum(one, other)


def _pierced_faces(surface: _Surface) -> Iterator[_Finding]:
    """Edges that go through a face."""
    one, other = surface.ends()
    for edge, face in _near(*_edge_boxes(surface), _face_boxes(surface)):
        margin = _SIDE * surface.warp[face] + ROUNDING
        from_one = surface.height(one[edge], face)
        from_other = surface.height(other[edge], face)
        through = (np.minimum(np.abs(from_one), np.abs(from_other)) > margin) & (
            from_one * from_other < 0.0
        )
        edge, face, margin = edge[through], face[through], margin[through]
        share = from_one[through] / (from_one[through] - from_other[through])
        point = one[edge] + share[:, None] * (other[edge] - one[edge])
        inside = _inside(surface, point, face, margin)
        for e, f in zip(edge[inside].tolist(), face[inside].tolist(), strict=True):
            body = int(surface.faces.owner[f])
            a, b = (surface.edge[e] - surface.vertices.first[body]).tolist()
            yield body, f"crosses itself: edge {a}-{b} goes through face {surface.number[f]}"


def _inside(surface: _Surface, point: Floats, face: Ints, margin: Floats) -> Bools:
    """Whether points in the plane of a face lie inside its outline by more than a margin."""
    outline = surface.outline[face]
    flat = surface.in_plane(point, face)
    return shapely.contains(outline, flat) & (
        shapely.distance(shapely.boundary(outline), flat) > margin
    )


def _touching_vertices(surface: _Surface) -> Iterator[_Finding]:
    """Vertices that lie on a plane face without being one of its corners."""
    point = surface.faces.point
    count = surface.faces.count
    lengths = np.diff(surface.faces.start)
    corner = np.unique(surface.faces.loop * count + np.repeat(np.arange(count), lengths))
    joined = {tuple(pair) for pair in surface.edge.tolist()}
    used = np.unique(surface.faces.loop)
    for place, face in _near(point[used], point[used], _face_boxes(surface)):
        vertex = used[place]
        on = (np.abs(surface.height(point[vertex], face)) <= ROUNDING) & (
            surface.warp[face] <= ROUNDING
        )
        key = vertex * count + face
        on &= corner[np.minimum(np.searchsorted(corner, key), len(corner) - 1)] != key
        vertex, face = vertex[on], face[on]
        flat = surface.in_plane(point[vertex], face)
        on = shapely.distance(surface.outline[face], flat) <= ROUNDING
        for v, f in zip(vertex[on].tolist(), face[on].tolist(), strict=True):
            if not _short_edge(surface, v, f, joined):
                body = int(surface.faces.owner[f])
                own = v - surface.vertices.first[body]
                yield body, f"touches itself: vertex {own} lies on face {surface.number[f]}"


def _short_edge(surface: _Surface, vertex: int, face: int, joined: set[tuple[int, ...]]) -> bool:
    """Whether a vertex is near a face only because a very short edge connects them."""
    loop = surface.faces.loop[surface.faces.start[face] : surface.faces.start[face + 1]]
    gap = np.linalg.norm(surface.faces.point[loop] - surface.faces.point[vertex], axis=1)
    close = loop[gap <= 2.0 * ROUNDING].tolist()
    return any((min(vertex, c), max(vertex, c)) in joined for c in close)


def _touching_edges(surface: _Surface) -> Iterator[_Finding]:
    """Edges that cross each other away from their ends.

    Nearest points of two lines a + s d, b + t e; Source: Ericson 2005, section 5.1.9.
    """
    one, other = surface.ends()
    around = _edge_boxes(surface)
    for first, second in _near(*around, around):
        later = first < second
        first, second = first[later], second[later]
        d, e = other[first] - one[first], other[second] - one[second]
        between = one[second] - one[first]
        cross = np.cross(d, e)
        square = (cross * cross).sum(axis=1)
        oblique = square > 1e-12 * (d * d).sum(axis=1) * (e * e).sum(axis=1)
        safe = np.where(oblique, square, 1.0)
        s = (np.cross(between, e) * cross).sum(axis=1) / safe
        t = (np.cross(between, d) * cross).sum(axis=1) / safe
        gap = np.abs((between * cross).sum(axis=1)) / np.sqrt(safe)
        margin_s = ROUNDING / np.maximum(np.linalg.norm(d, axis=1), ROUNDING)
        margin_t = ROUNDING / np.maximum(np.linalg.norm(e, axis=1), ROUNDING)
        hit = (
            oblique
            & (gap <= ROUNDING)
            & (s > margin_s)
            & (s < 1.0 - margin_s)
            & (t > margin_t)
            & (t < 1.0 - margin_t)
        )
        for i, j in zip(first[hit].tolist(), second[hit].tolist(), strict=True):
            body = int(surface.vertices.owner[surface.edge[i, 0]])
            a, b = (surface.edge[i] - surface.vertices.first[body]).tolist()
            c, d_ = (surface.edge[j] - surface.vertices.first[body]).tolist()
            yield body, f"touches itself: edges {a}-{b} and {c}-{d_} cross"


def convex_bodies(vertices: Sequence[Floats], faces: Sequence[Sequence[Loop]]) -> Bools:
    """Whether each body is convex.

    It is one body, and no vertex lies above the plane of a face by more than rounding. One
    with very many faces counts as concave: the test would cost more time than it saves.

    Parameters
    ----------
    vertices
        Per body (v, 3) [m].
    faces
        Per body its loops, oriented outwards.
    """
    convex = np.zeros(len(vertices), dtype=bool)
    pairs = np.array([len(v) * len(f) for v, f in zip(vertices, faces, strict=True)])
    small = np.flatnonzero(pairs <= BATCH)
    batch = np.cumsum(pairs[small]) // BATCH
    for bodies in np.split(small, np.flatnonzero(np.diff(batch)) + 1):
        if len(bodies):
            part = bodies.tolist()
            convex[bodies] = _convex_batch([vertices[i] for i in part], [faces[i] for i in part])
    return convex


def _convex_batch(vertices: Sequence[Floats], faces: Sequence[Sequence[Loop]]) -> Bools:
    placed = [(v - v[0]) / np.linalg.norm(v.max(axis=0) - v.min(axis=0)) for v in vertices]
    stacked = stack_faces(placed, faces)
    normal, middle = stacked.normals, stacked.middles
    count = np.array([len(v) for v in vertices])
    first = np.cumsum(count) - count
    face, vertex = expand(first[stacked.owner], count[stacked.owner])
    height = ((stacked.point[vertex] - middle[face]) * normal[face]).sum(axis=1)
    highest = np.zeros(len(vertices))
    np.maximum.at(highest, stacked.owner[face], height)
    # each face by its own and its half edges: the same body twice has twice as many (Euler)
    faces_less_edges = np.bincount(stacked.owner, 1.0 - 0.5 * stacked.corners.counts)
    return (highest <= ROUNDING) & (count + faces_less_edges == 2.0)
