"""Contacts along a line or at a point, where blocks touch with an edge or a corner."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, Ints, dot, marked
from drystone.base.ragged import BATCH, Ragged, expand
from drystone.detection.candidates import Pairs, warp_slack
from drystone.detection.interfaces import Interfaces
from drystone.detection.patches import Patches
from drystone.detection.tolerances import DetectionOptions
from drystone.geometry import boxes, planar
from drystone.geometry.frames import frames_from_normals

SHORT = 1e-3
"""Contact lines shorter than this share of the block size are points; chosen."""
PARALLEL = 0.05
"""Edges cross when the sine of their angle is larger, about 3 degrees; chosen."""


@dataclass(frozen=True)
class Wires:
    """All vertices, and the edges of some blocks, relative to the patches' origin.

    Attributes
    ----------
    point : (v, 3) [m]
    edge : (e, 2) vertices
    of_block
        The edges of each block of the assembly; none of a block that is not asked for.
    low, high : (e, 3) [m]
        Corners of the box of every edge.
    """

    point: Floats
    edge: Ints
    of_block: Ragged
    beside: tuple[Ragged, Ints]
    low: Floats
    high: Floats

    @classmethod
    def of(cls, assembly: Assembly, origin: Floats, blocks: Ints) -> Wires:
        """The wires of some blocks (b,), ascending."""
        faces, count = assembly.faces, len(assembly)
        asked = marked(blocks, count)
        corners, row = faces.corners.take(asked[faces.owner])
        loop, number = faces.loop[row], len(faces.point)
        after = loop[corners.following]
        ends = np.unique(np.minimum(loop, after) * number + np.maximum(loop, after))
        edge = np.stack(np.divmod(ends, number), axis=1)
        owner = Ragged.from_counts([len(b.vertices) for b in assembly.blocks]).owner
        point = faces.point - origin
        mine, theirs = np.concatenate([edge, edge[:, ::-1]]).T
        order = np.lexsort((theirs, mine))
        beside = Ragged.from_owners(mine[order], len(point)), theirs[order]
        one, other = point[edge[:, 0]], point[edge[:, 1]]
        low, high = np.minimum(one, other), np.maximum(one, other)
        of_block = Ragged.from_owners(owner[edge[:, 0]], count)
        return cls(point, edge, of_block, beside, low, high)

    def around(self, vertex: Ints) -> tuple[Ragged, Ints]:
        """Some vertices, each with its neighbours: rows by given vertex, and their vertices."""
        rows, neighbour = self.beside
        part, row = rows.take(vertex)
        return part, neighbour[row]


@dataclass(frozen=True)
class _Rows:
    """Arrays of one length."""

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(getattr(self, fields(self)[0].name))

    def take(self: R, rows: Ints | Bools) -> R:
        """Some of the rows."""
        return type(self)(*(getattr(self, one.name)[rows] for one in fields(self)))


R = TypeVar("R", bound=_Rows)


def _joined(some: Sequence[R]) -> R:
    """The rows of several, one after another."""
    names = [one.name for one in fields(some[0])]
    return type(some[0])(*(np.concatenate([getattr(one, x) for one in some]) for x in names))


@dataclass(frozen=True)
class _Rests(_Rows):
    """Edges (c = 2) or vertices (c = 1) that may rest on patches.

    Attributes
    ----------
    pair : (r,)
    of_a : (r,) bool
        Whether they are of block a, and the patch of block b.
    vertex : (r, c)
    patch : (r,)
    """

    pair: Ints
    of_a: Bools
    vertex: Ints
    patch: Ints

    @classmethod
    def none(cls, corners: int) -> _Rests:
        """No rows."""
        none = np.zeros(0, dtype=np.intp)
        return cls(none, none.astype(bool), np.zeros((0, corners), dtype=np.intp), none)


@dataclass(frozen=True)
class _Touches(_Rows):
    """Lines (two points) and points of contact.

    Attributes
    ----------
    pair : (t,)
    point : (t, 2, 3) [m]
        Both the same for a point.
    line : (t,) bool
    normal : (t, 3) from block a to block b
    face_a, face_b : (t,)
    gap : (t,) [m]
    """

    pair: Ints
    point: Floats
    line: Bools
    normal: Floats
    face_a: Ints
    face_b: Ints
    gap: Floats


def edge_contacts(
    assembly: Assembly, patches: Patches, pairs: Pairs, reach: Floats, options: DetectionOptions
) -> tuple[Interfaces, Ints]:
    """Contacts of edges and vertices with faces, and of edges that cross.

    Parameters
    ----------
    pairs
        Near blocks (a < b) without a face contact.
    reach : (p,) [m]
        Largest distance of the edges and vertices of each pair.

    Returns
    -------
    interfaces
        Lines with two corners and points with one; area zero.
    undirected : (u, 2)
        Pairs that meet only along parallel edges or at corners, where the contact has no defined
        normal.
    """
    search = _EdgeSearch(assembly, patches, pairs, reach, options)
    on_faces, meets = search.on_faces()
    touched = marked(on_faces.pair, len(pairs[0]))
    crossing = search.crossing(np.flatnonzero(~touched))
    touched[crossing.pair] = True
    meets &= ~touched
    found = _interfaces(patches, pairs, _joined([on_faces, crossing]))
    return found, np.stack([pairs[0][meets], pairs[1][meets]], axis=1)


def _interfaces(patches: Patches, pairs: Pairs, found: _Touches) -> Interfaces:
    corner = np.stack([np.ones(found.count, dtype=bool), found.line], axis=1)
    none = np.zeros(found.count)
    a, b = pairs[0][found.pair], pairs[1][found.pair]
    return Interfaces(
        block_a=a,
        block_b=b,
        face_a=found.face_a,
        face_b=found.face_b,
        frame=frames_from_normals(found.normal),
        point=found.point[corner],
        start=Ragged.from_counts(corner.sum(axis=1)).start,
        area=none,
        gap=found.gap,
        warp=none,
        angle=none,
        clipped=np.zeros(found.count, dtype=bool),
        merged=np.ones(found.count, dtype=np.intp),
        size=np.minimum(patches.size[a], patches.size[b]),
    )


class _EdgeSearch:
    """Search for contacts of the edges and vertices of pairs of blocks."""

    def __init__(
        self,
        assembly: Assembly,
        patches: Patches,
        pairs: Pairs,
        reach: Floats,
        options: DetectionOptions,
    ) -> None:
        self.patches, self.pairs = patches, pairs
        self.wires = Wires.of(assembly, patches.origin, np.unique(np.concatenate(pairs)))
        self.slack = warp_slack(patches, options)
        self.frame = frames_from_normals(patches.normal)
        self.size: Floats = np.minimum(patches.size[pairs[0]], patches.size[pairs[1]])
        self.reach = reach

    def on_faces(self) -> tuple[_Touches, Bools]:
        """Contacts of edges and vertices with faces, and which pairs meet at outlines (q,)."""
        edges, vertices = self._resting()
        used, place = np.unique(np.concatenate([edges.patch, vertices.patch]), return_inverse=True)
        region = self._regions(used)
        meets = np.zeros(len(self.size), dtype=bool)
        lines, covered = self._lines(edges, region[place[: edges.count]], meets)
        region, alone = region[place[edges.count :]], ~np.isin(self._keys(vertices), covered)
        points = self._points(vertices.take(alone), region[alone], meets)
        return _joined([lines, points]), meets

    def _lines(self, edges: _Rests, region: Any, meets: Bools) -> tuple[_Touches, Ints]:
        """Contacts of edges (r, 2), and the vertices on patches that need no other."""
        size = self.size[edges.pair]
        ends = self._flat(edges.vertex, edges.patch[:, None])
        shared = shapely.intersection(shapely.linestrings(ends), region)
        part, row = shapely.get_parts(shared, return_index=True)
        long = shapely.length(part) > SHORT * size[row]
        part, row = part[long], row[long]
        middle = shapely.line_interpolate_point(part, 0.5, normalized=True)
        off = shapely.distance(middle, shapely.boundary(region)[row])
        inside = off > SAME * size[row]
        meets[edges.pair[row[~inside]]] = True
        covered = self._keys(edges.take(row))
        part, edges = part[inside], edges.take(row[inside])
        flat = [shapely.get_coordinates(shapely.get_point(part, i)) for i in (0, -1)]
        return self._touches(edges, np.stack(flat, axis=1)), covered

    def _points(self, vertices: _Rests, region: Any, meets: Bools) -> _Touches:
        """Contacts of vertices (r, 1)."""
        flat = self._flat(vertices.vertex, vertices.patch[:, None])
        point = shapely.points(flat[:, 0])
        off = shapely.distance(point, shapely.boundary(region))
        inside = SAME * self.size[vertices.pair]
        near = off <= np.maximum(inside, self.reach[vertices.pair])
        meets[vertices.pair[near]] = True
        rests = shapely.contains(region, point) & (off > inside)
        return self._touches(vertices.take(rests), flat[rests])

    def _touches(self, rows: _Rests, flat: Floats) -> _Touches:
        """Points (t, c, 2) of face planes in space, halfway up the gap."""
        p, patch = self.patches, rows.patch
        gap = heights(p, self.wires.point[rows.vertex], patch[:, None]).mean(axis=1)
        plane = self.frame[patch]
        point = (p.centre[patch] + (0.5 * gap)[:, None] * plane[:, 0])[:, None] + flat @ plane[
            :, 1:
        ]
        theirs, none = p.face[patch], np.full(len(patch), -1)
        return _Touches(
            rows.pair,
            point[:, [0, -1]],
            np.full(len(patch), flat.shape[1] == 2),
            np.where(rows.of_a, -1.0, 1.0)[:, None] * p.normal[patch],
            np.where(rows.of_a, none, theirs),
            np.where(rows.of_a, theirs, none),
            gap,
        )

    def _regions(self, patch: Ints) -> Any:
        """Some patches as shapely polygons in their own planes."""
        p = self.patches
        part, ring = Ragged(p.first_ring).take(patch)
        corners, corner = Ragged(p.ring_start).take(ring)
        owner = corners.spread(part.spread(patch))
        local = p.corner[corner] - p.centre[owner]
        flat = np.einsum("lij,lj->li", self.frame[owner, 1:], local)
        return planar.regions(flat, corners.start, part.owner)

    def _flat(self, vertex: Ints, patch: Ints) -> Floats:
        """Vertices (r, c) in the planes (u, v) of patches (r, 1)."""
        local = self.wires.point[vertex] - self.patches.centre[patch]
        return np.einsum("rcij,rcj->rci", self.frame[patch, 1:], local)

    def _keys(self, rows: _Rests) -> Ints:
        """A number for each vertex on each patch."""
        keys: Ints = rows.patch[:, None] * len(self.wires.point) + rows.vertex
        return keys.ravel()

    def _resting(self) -> tuple[_Rests, _Rests]:
        """Edges (r, 2), and vertices (s, 1), of one block that may rest on faces of another.

        Both ends of such an edge, and such a vertex, are near the plane of the patch and have all
        their neighbours on its outer side. The edge or the vertex is in front of the box of the
        patch, or so near to it that it may meet its outline.
        """
        edges, vertices = [_Rests.none(2)], [_Rests.none(1)]
        for pair, of_a, edge, patch in self._near_edges():
            ends = self.wires.edge[edge]
            tolerance = self.reach[pair] + self.slack[patch]
            rests = self._rest(ends.ravel(), np.repeat(patch, 2), np.repeat(tolerance, 2))
            rests = rests.reshape(-1, 2)
            both = rests.all(axis=1)
            edges.append(_Rests(pair[both], of_a[both], ends[both], patch[both]))
            row, end = np.nonzero(rests)
            vertices.append(_Rests(pair[row], of_a[row], ends[row, end][:, None], patch[row]))
        found = _joined(vertices)
        _, once = np.unique(self._keys(found), return_index=True)
        return _joined(edges), found.take(once)

    def _near_edges(self) -> Iterator[tuple[Ints, Bools, Ints, Ints]]:
        """Pairs, whether the edge is of block a, edges, and patches whose boxes they are near."""
        p, wires = self.patches, self.wires
        (a, b), count = self.pairs, len(self.size)
        body, other = np.concatenate([a, b]), np.concatenate([b, a])
        margin = 2.0 * np.tile(self.reach, 2)
        wider = (self.slack + p.warp)[:, None]
        found = near_items(
            (wires.of_block, body, wires.low, wires.high),
            (p.of_block, other, p.low - wider, p.high + wider),
            margin,
        )
        for row, edge, patch in found:
            yield row % count, row < count, edge, patch

    def _rest(self, vertex: Ints, patch: Ints, tolerance: Floats) -> Bools:
        """Whether each vertex (q,) is near the plane of its patch and no neighbour is behind it."""
        away = np.abs(heights(self.patches, self.wires.point[vertex], patch))
        rests: Bools = away <= tolerance
        every = np.flatnonzero(rests)
        beside = Ragged.from_counts(self.wires.beside[0].counts[vertex[every]])
        for some in beside.batches(BATCH // 8):  # 10 MB
            near = every[some]
            part, neighbour = self.wires.around(vertex[near])
            height = heights(self.patches, self.wires.point[neighbour], part.spread(patch[near]))
            rests[near] = part.min(height) >= -tolerance[near]
        return rests

    def crossing(self, pairs: Ints) -> _Touches:
        """Points where edges of some pairs of blocks cross, outside of both.

        Source: Ericson 2005, Real-time collision detection, section 5.1.9.
        """
        wires, block = self.wires, [self.pairs[i][pairs] for i in (0, 1)]
        none, nowhere = np.zeros(0, dtype=np.intp), np.zeros((0, 3))
        found = [self._outside(none, none, none, nowhere, nowhere)]
        sides = [(wires.of_block, one, wires.low, wires.high) for one in block]
        for row, first, second in near_items(sides[0], sides[1], self.reach[pairs]):
            pair = pairs[row]
            start, begin = (wires.point[wires.edge[one, 0]] for one in (first, second))
            along = wires.point[wires.edge[first, 1]] - start
            run = wires.point[wires.edge[second, 1]] - begin
            between = start - begin
            a, b, c = dot(along, along), dot(along, run), dot(run, run)
            d, e = dot(along, between), dot(run, between)
            square = a * c - b * b
            crosses = square > PARALLEL**2 * a * c
            safe = np.where(crosses, square, 1.0)
            s, t = (b * e - c * d) / safe, (a * e - b * d) / safe
            crosses &= (s > SAME) & (s < 1.0 - SAME) & (t > SAME) & (t < 1.0 - SAME)
            p, q = start + s[:, None] * along, begin + t[:, None] * run
            crosses &= dot(p - q, p - q) <= self.reach[pair] ** 2
            k = np.flatnonzero(crosses)
            found.append(self._outside(pair[k], first[k], second[k], p[k], q[k]))
        return _joined(found)

    def _outside(self, pair: Ints, first: Ints, second: Ints, p: Floats, q: Floats) -> _Touches:
        """Those of crossing edges at which the blocks lie on two sides of a plane."""
        wires = self.wires
        ends = [wires.point[wires.edge[one]] for one in (first, second)]
        normal = np.cross(ends[0][:, 1] - ends[0][:, 0], ends[1][:, 1] - ends[1][:, 0])
        normal /= np.sqrt(dot(normal, normal))[:, None]
        inside = SAME * self.size[pair]
        across = []
        for edge, at in ((first, p), (second, q)):
            part, neighbour = wires.around(wires.edge[edge].ravel())
            row = part.owner // 2
            height = dot(wires.point[neighbour] - at[row], normal[row])
            least, most = part.min(height), part.max(height)
            across.append((least.reshape(-1, 2).min(axis=1), most.reshape(-1, 2).max(axis=1)))
        (low_a, high_a), (low_b, high_b) = across
        ahead = (high_a <= inside) & (low_b >= -inside)
        behind = (low_a >= -inside) & (high_b <= inside) & ~ahead
        normal[behind] *= -1.0
        keep = ahead | behind
        point = np.repeat(0.5 * (p + q)[:, None], 2, axis=1)
        none = np.full(len(pair), -1)
        return _Touches(
            pair, point, np.zeros(len(pair), dtype=bool), normal, none, none, dot(q - p, normal)
        ).take(keep)


_Side = tuple[Ragged, Ints, Floats, Floats]
"""Items of all blocks, one block per pair, and the boxes of the items."""


def near_items(one: _Side, other: _Side, margin: Floats) -> Iterator[tuple[Ints, Ints, Ints]]:
    """Pairs (q,) of blocks, items of the first and of the second whose boxes are within a margin.

    In batches of bounded size.
    """
    count, wide = len(margin), margin[:, None]
    spans = [
        (of.min(low)[block] - wide, of.max(high)[block] + wide)
        for of, block, low, high in (one, other)
    ]
    (first, mine), (second, theirs) = _items(one, spans[1]), _items(other, spans[0])
    begin = np.searchsorted(second, np.arange(count + 1))
    several = np.diff(begin)
    product = several[first]
    low, high, below, above = one[2], one[3], other[2], other[3]
    large = np.bincount(first, product, minlength=count) > boxes.FEW
    small = np.flatnonzero(~large[first])
    for batch in Ragged.from_counts(product[small]).batches(BATCH):
        chosen = small[batch]
        source, place = expand(begin[first[chosen]], product[chosen])
        row, i, j = first[chosen][source], mine[chosen][source], theirs[place]
        near = boxes.touching(low[i], high[i], below[j] - wide[row], above[j] + wide[row])
        yield row[near], i[near], j[near]
    for one_row in np.flatnonzero(large).tolist():
        i, j = mine[first == one_row], theirs[begin[one_row] : begin[one_row + 1]]
        least, most = below[j] - margin[one_row], above[j] + margin[one_row]
        for k, m in boxes.batches(low[i], high[i], least, most):
            yield np.full(len(k), one_row), i[k], j[m]


def _items(side: _Side, around: tuple[Floats, Floats]) -> tuple[Ints, Ints]:
    """Items whose boxes reach into boxes (q, 3) around the other block, with their pair."""
    of_block, block, low, high = side
    pair, item = expand(of_block.first[block], of_block.counts[block])
    near = boxes.touching(low[item], high[item], around[0][pair], around[1][pair])
    return pair[near], item[near]


def heights(patches: Patches, point: Floats, patch: Ints) -> Floats:
    """Distance (...) [m] of points (..., 3) from the planes of patches (...), outwards."""
    return ((point - patches.centre[patch]) * patches.normal[patch]).sum(axis=-1)
