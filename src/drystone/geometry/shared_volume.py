"""Pairs of bodies that overlap: shared volume and depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import manifold3d
import numpy as np

from drystone.base.arrays import SAME, Bools, Floats, Ints, cross, dot, unit
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.ragged import BATCH, Ragged
from drystone.geometry import boxes
from drystone.geometry.frames import area_vectors
from drystone.geometry.polyhedron import Faces
from drystone.geometry.solid import farthest, squared_distance
from drystone.geometry.triangulate import fan_warped, point_owners, triangulate

_MANY_CORNERS = 100_000
"""Pairs of a corner of each of two convex bodies above which their depth is measured as that of
concave ones. Chosen: below, every direction in which they may part is tried within a second."""
_FINE = 10_000
"""Corners of a shared surface from which on its depth is measured at them alone. Measured: a peg of
111,000 triangles, deep all round, takes six times as long with the middles, and is as deep."""
_COPY = 0.5
"""Bodies whose surfaces agree within the tolerance are copies when they share more than this part
of the larger volume. Chosen: any value between 0 and 1 gives the same answer."""


@dataclass(frozen=True, eq=False)
class _SharedVolume(OneLine):
    """Pairs of bodies that share volume.

    Attributes
    ----------
    row : (s,)
        Positions of these pairs among the given ones.
    depth : (s,) [m]
        For two convex bodies: the shortest translation that separates them. Otherwise, and where
        both have very many corners: the largest distance from a surface point of one body, inside
        the other, to the surface of the other. For copies: 6 V / A with the volume V and the
        surface A, the edge of a cube.
    volume : (s,) [m3]
    """

    row: Ints
    depth: Floats
    volume: Floats


def shared_volumes(
    faces: Faces, a: Ints, b: Ints, tolerance: Floats, convex: Bools
) -> _SharedVolume:
    """The pairs of bodies that overlap deeper than the tolerance.

    Pairs that a plane separates, up to the tolerance, are removed first. The planes tried are
    perpendicular to the line between the two centres, and those of the faces that face along this
    line; for convex pairs the planes of all faces. manifold3d intersects the remaining pairs.

    Parameters
    ----------
    faces
        Of all bodies, oriented outwards; a warped face counts as its fan.
    a, b : (p,)
        Pairs of bodies, by the owners in ``faces``.
    tolerance : (p,) [m]
    convex : (n,)
        Which bodies are known to be convex.

    Raises
    ------
    InputError
        manifold3d does not accept a body as a solid.

    Examples
    --------
    >>> from drystone.models import box
    >>> from drystone.assembly import Assembly
    >>> pair = Assembly((box((1, 1, 1), name="a"), box((1, 1, 1), (0.5, 0.25, 0.9), name="b")))
    >>> found = shared_volumes(
    ...     pair.faces, np.array([0]), np.array([1]), np.array([1e-6]), np.array([True, True]))
    >>> found.depth.round(6).tolist(), found.volume.round(6).tolist()
    ([0.1], [0.0375])
    """
    row = np.arange(len(a), dtype=np.intp)
    if len(row) == 0:
        return _SharedVolume(row, np.zeros(0), np.zeros(0))
    bodies = _Bodies.of(faces, a, b)
    convex = convex[bodies.number]
    a, b = (np.searchsorted(bodies.number, body) for body in (a, b))
    for sieve in (_near_along_a_line, _near_along_faces):
        near = sieve(bodies, a, b, tolerance[row], convex)
        row, a, b = row[near], a[near], b[near]
        if len(row) == 0:
            return _SharedVolume(row, np.zeros(0), np.zeros(0))
    commons = [
        bodies.solid(i) ^ bodies.solid(j) for i, j in zip(a.tolist(), b.tolist(), strict=True)
    ]
    some = np.flatnonzero([common.num_tri() > 0 for common in commons])
    row, a, b, commons = row[some], a[some], b[some], [commons[i] for i in some]
    volume = np.array([common.volume() for common in commons])
    depth = np.zeros(len(a))
    both = _few_convex(bodies, a, b, convex)
    for i in np.flatnonzero(both):
        depth[i] = _way_out(bodies, a[i], b[i])
    some = np.flatnonzero(~both)
    if len(some):
        solids = [commons[i] for i in some]
        depth[some] = _deepest(bodies, a[some], b[some], solids, tolerance[row[some]])
    whole = np.array(
        [[bodies.solid(i).volume() for i in pair] for pair in np.stack([a, b], axis=1)]
    ).reshape(-1, 2)
    for i in np.flatnonzero((depth <= tolerance[row]) & (volume > _COPY * whole.max(axis=1))):
        depth[i] = 6.0 * volume[i] / commons[i].surface_area()
    deep = depth > tolerance[row]
    return _SharedVolume(row[deep], depth[deep], volume[deep])


@dataclass(frozen=True, eq=False)
class _Bodies:
    """Some bodies; ``corners`` and ``faces`` say which points and faces belong to which body."""

    number: Ints  # (n,) among all bodies
    point: Floats  # (c, 3)
    corners: Ragged
    faces: Ragged
    loop: Ints  # (l,) points, face after face
    loops: Ragged
    solids: dict[int, manifold3d.Manifold]

    @classmethod
    def of(cls, every: Faces, a: Ints, b: Ints) -> _Bodies:
        """The bodies that occur in the pairs."""
        number = np.unique(np.concatenate([a, b]))
        chosen = np.isin(every.owner, number)
        loops, place = every.corners.take(chosen)
        used, loop = np.unique(every.loop[place], return_inverse=True)
        owner = np.searchsorted(number, every.owner[chosen])
        faces = fan_warped(Faces(every.point[used], loop.astype(np.intp), loops.start, owner))
        return cls(
            number,
            faces.point,
            Ragged.from_owners(point_owners(faces), len(number)),
            Ragged.from_owners(faces.owner, len(number)),
            faces.loop,
            faces.corners,
            {},
        )

    @cached_property
    def normal(self) -> Floats:
        """(f, 3) unit normals of the faces."""
        return unit(area_vectors(self.point[self.loop], self.loops.start))[0]

    @cached_property
    def middle(self) -> Floats:
        """(f, 3) [m] mean corners of the faces."""
        return self.loops.mean(self.point[self.loop])

    @cached_property
    def triangles(self) -> tuple[Ints, Ragged]:
        """(t, 3) points of the triangles of all faces, and which triangles belong to which body."""
        triangle, face = triangulate(self.point[self.loop], self.loops.start)
        owner = self.faces.owner[face]
        return self.loop[triangle], Ragged.from_owners(owner, len(self.number))

    @cached_property
    def planes(self) -> tuple[Floats, Floats]:
        """Unit normals (t, 3) of the triangles, and their distances (t,) [m] from the origin."""
        corner = self.point[self.triangles[0]]
        normal = unit(cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))[0]
        return normal, dot(normal, corner[:, 0])

    @cached_property
    def first_id(self) -> int:
        """By which manifold3d knows the first body; the others follow."""
        return int(manifold3d.Manifold.reserve_ids(len(self.number)))

    def solid(self, body: int) -> manifold3d.Manifold:
        """One body as a manifold3d solid."""
        if body not in self.solids:
            triangle, of = self.triangles
            mine = self.corners[body]
            loops = (triangle[of[body]] - mine.start).astype(np.uint64)
            mesh = manifold3d.Mesh64(
                np.array(self.point[mine]),
                loops,
                run_index=np.array([0, loops.size], dtype=np.uint64),
                run_original_id=np.array([self.first_id + body], dtype=np.uint32),
            )
            solid = manifold3d.Manifold(mesh)
            if solid.status() != manifold3d.Error.NoError:
                raise InputError(
                    f"body {self.number[body]} is no solid: {solid.status().name}",
                    remedy="write it with planar faces, or with triangles",
                )
            self.solids[body] = solid
        return self.solids[body]

    def extent(self, body: Ints, direction: Floats) -> tuple[Floats, Floats]:
        """Least and largest coordinate (p,) of bodies along directions (p, 3)."""
        part, corner = self.corners.take(body)
        along = dot(self.point[corner], part.spread(direction))
        return part.min(along), part.max(along)

    def facing(self, body: Ints, direction: Floats) -> Floats:
        """Normal (p, 3) of the face of each body that is nearest to a direction."""
        part, face = self.faces.take(body)
        square = np.abs(dot(self.normal[face], part.spread(direction)))
        order = np.lexsort((square, part.owner))
        return self.normal[face[order[part.start[1:] - 1]]]

    def edges(self, body: int) -> Floats:
        """Unit directions (e, 3) of the edges of one body, each direction once, up to rounding."""
        loops = self.loops.take(np.arange(len(self.loops))[self.faces[body]])[1]
        edge = unit(
            self.point[self.loop[self.loops.following[loops]]] - self.point[self.loop[loops]]
        )[0]
        main = edge[np.arange(len(edge)), np.argmax(np.abs(edge) > 0.5, axis=1)]
        edge = edge * np.where(main < 0.0, -1.0, 1.0)[:, None]
        return edge[np.unique(np.round(edge, 7), axis=0, return_index=True)[1]]


def _near_along_a_line(bodies: _Bodies, a: Ints, b: Ints, tolerance: Floats, _: Bools) -> Ints:
    """Pairs that overlap along the line between their centres and near normals."""
    row = np.arange(len(a))
    middle = bodies.corners.mean(bodies.point)
    for which in (None, a, b):
        line = middle[b[row]] - middle[a[row]]
        if which is not None:
            line = bodies.facing(which[row], line)
        direction = unit(line)[0]
        one, other = (bodies.extent(body[row], direction) for body in (a, b))
        overlap = np.minimum(one[1] - other[0], other[1] - one[0])
        row = row[(overlap > tolerance[row]) | ~direction.any(axis=1)]
        if len(row) == 0:
            break
    return row


def _near_along_faces(bodies: _Bodies, a: Ints, b: Ints, tolerance: Floats, convex: Bools) -> Ints:
    """Pairs that overlap along every face normal, if both are convex; all other pairs."""
    both = np.flatnonzero(_few_convex(bodies, a, b, convex))
    near = np.ones(len(a), dtype=bool)
    for one, other in ((a, b), (b, a)):
        left = both[near[both]]
        near[left] = _least_depth(bodies, one[left], other[left]) > tolerance[left]
    return np.flatnonzero(near)


def _few_convex(bodies: _Bodies, a: Ints, b: Ints, convex: Bools) -> Bools:
    """Pairs (p,) of convex bodies for which every direction to part them can be tried."""
    count = bodies.corners.counts
    return convex[a] & convex[b] & (count[a] * count[b] <= _MANY_CORNERS)


def _least_depth(bodies: _Bodies, a: Ints, b: Ints) -> Floats:
    """Least depth (p,) [m] of convex bodies b below any face plane of the bodies a."""
    of_pair, face = bodies.faces.take(a)
    other = of_pair.spread(b)
    depth = np.zeros(len(face))
    for part in Ragged.from_counts(bodies.corners.counts[other]).batches(BATCH):
        each, corner = bodies.corners.take(other[part])
        mine = each.spread(face[part])
        along = dot(bodies.point[corner] - bodies.middle[mine], bodies.normal[mine])
        depth[part] = -each.min(along)
    return of_pair.min(depth)


def _way_out(bodies: _Bodies, a: int, b: int) -> float:
    """Shortest translation [m] that separates one convex body from another.

    It is normal to a face of one body, or to an edge of each. Source: Gottschalk, Lin, Manocha
    1996.
    """
    across = np.cross(bodies.edges(a)[:, None], bodies.edges(b)[None]).reshape(-1, 3)
    across, length = unit(across)
    faces = [bodies.normal[bodies.faces[body]] for body in (a, b)]
    direction = np.concatenate([*faces, across[length > SAME]])
    x, y = (bodies.point[bodies.corners[body]] for body in (a, b))
    least = np.inf
    for part in np.array_split(direction, len(direction) * (len(x) + len(y)) // BATCH + 1):
        one, other = x @ part.T, y @ part.T
        ahead = one.max(axis=0) - other.min(axis=0)
        behind = other.max(axis=0) - one.min(axis=0)
        least = min(least, float(np.minimum(ahead, behind).min()))
    return least


def _deepest(
    bodies: _Bodies,
    a: Ints,
    b: Ints,
    commons: Sequence[manifold3d.Manifold],
    tolerance: Floats,
) -> Floats:
    """Depth (p,) [m] of the common solids of bodies; see :class:`_SharedVolume`.

    The depth is measured at the corners of their triangles and, unless these are very many, at the
    middles of edges and triangles. Each triangle lies on the surface of one body, and is measured
    from the other.
    """
    meshes = [common.to_mesh64() for common in commons]
    points = [np.asarray(mesh.vert_properties)[:, :3] for mesh in meshes]
    corners = [np.asarray(mesh.tri_verts) for mesh in meshes]
    vertices, triangles = Ragged.of(points), Ragged.of(corners)
    point = np.concatenate(points)
    corner = np.concatenate(corners).astype(np.intp) + triangles.spread(vertices.first)[:, None]
    of_a = zip(meshes, (bodies.first_id + a).tolist(), strict=True)
    on_a = np.concatenate([_lie_on(mesh, number) for mesh, number in of_a])
    depth = np.zeros(len(a))
    for body, lie in ((a, ~on_a), (b, on_a)):
        tried, pair = _middles(point, corner[lie], triangles.owner[lie])
        order = np.argsort(pair, kind="stable")
        places = Ragged.from_owners(pair[order], len(a))
        depth = np.maximum(depth, _away(bodies, body, places, tried[order], tolerance))
    return depth


def _lie_on(common: manifold3d.Mesh64, number: int) -> Bools:
    """Which triangles (t,) of a common solid lie on the surface of the body with that number."""
    start: Ints = np.asarray(common.run_index).astype(np.intp)
    runs = (start[1:] - start[:-1]) // 3
    return np.repeat(np.asarray(common.run_original_id) == number, runs)


def _middles(point: Floats, corner: Ints, owner: Ints) -> tuple[Floats, Ints]:
    """The corners of triangles (t, 3), the middles of them and of their edges; and their owners.

    Owners with very many corners have no middles.
    """
    used, first = np.unique(corner, return_index=True)
    at = owner[first // 3]
    coarse = np.bincount(at, minlength=1)[owner] < _FINE
    corner, owner = corner[coarse], owner[coarse]
    begin, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    once = np.flatnonzero(begin < end)
    middle = 0.5 * (point[begin[once]] + point[end[once]])
    tried = np.concatenate([point[used], middle, point[corner].mean(axis=1)])
    return tried, np.concatenate([at, owner[once // 3], owner])


def _away(bodies: _Bodies, body: Ints, points: Ragged, point: Floats, tolerance: Floats) -> Floats:
    """Largest distance (p,) [m] of points from the surface of each body; 0 up to the tolerance.

    Most points lie on the surface, so the triangles near all points of a body are tried first.
    """
    triangle, of = bodies.triangles
    part, row = of.take(body)
    corner = bodies.point[triangle[row]]
    reach = tolerance[:, None]
    low, high = points.min(point) - reach, points.max(point) + reach
    touch = boxes.touching(
        part.spread(low), part.spread(high), corner.min(axis=1), corner.max(axis=1)
    )
    near, row = part.keep(touch), row[touch]
    away = np.zeros(len(body))
    many = points.counts * of.counts[body] > BATCH
    for i in np.flatnonzero(many).tolist():
        surface = bodies.point[triangle[of[body[i]]]]
        away[i] = farthest(point[points[i]], surface, float(tolerance[i]))
    left = np.flatnonzero(~many[points.owner])
    # the cache of the processor holds so many, which halves the time
    for some in Ragged.from_counts(near.counts[points.owner[left]]).batches(BATCH // 16):
        mine = left[some]
        pair = points.owner[mine]
        each, place = near.take(pair)
        square = _squared(bodies, each, row[place], point[mine], tolerance[pair])
        mine, pair = (one[square > tolerance[pair] ** 2] for one in (mine, pair))
        each, place = of.take(body[pair])
        every = squared_distance(point[each.spread(mine)], bodies.point[triangle[place]])
        np.maximum.at(away, pair, np.sqrt(each.min(every)))
    return away


def _squared(bodies: _Bodies, each: Ragged, row: Ints, point: Floats, tolerance: Floats) -> Floats:
    """Squared distance (c,) [m2] of points from triangles whose planes are within a tolerance."""
    normal, offset = (values[row] for values in bodies.planes)
    place = each.spread(point)
    square = np.full(each.rows, np.inf)
    flat = np.abs(dot(place, normal) - offset) <= each.spread(tolerance)
    corner = bodies.point[bodies.triangles[0][row[flat]]]
    square[flat] = squared_distance(place[flat], corner)
    return each.min(square)
