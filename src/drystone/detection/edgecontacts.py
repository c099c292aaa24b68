"""Contacts along a line or at a point, where blocks touch with an edge or a corner."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, dot
from drystone.base.ragged import Ragged
from drystone.detection.candidates import Pairs, warp_slack
from drystone.detection.detection_options import DetectionOptions
from drystone.detection.interfaces import Interfaces
from drystone.detection.patches import Patches
from drystone.geometry import boxes, planar
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.polyhedron import edges_of

_INSIDE = 1e-6
"""A contact lies inside a face when it is farther than this share of the block size from the
outline. Nearer to it, edge meets edge, and the contact has no defined normal."""
_SHORT = 1e-3
"""Contact lines shorter than this share of the block size are points; chosen."""
_PARALLEL = 0.05
"""Edges cross when the sine of their angle is larger, about 3 degrees; chosen."""


@dataclass(frozen=True)
class _Touch:
    """One line (two points) or point contact; the normal points from block a to block b."""

    points: Floats
    normal: Floats
    face_a: int
    face_b: int
    gap: float


@dataclass(frozen=True)
class _Wire:
    """Vertices and edges of one block, relative to the patches' origin."""

    point: Floats  # (v, 3)
    edge: Ints  # (e, 2)

    @cached_property
    def beside(self) -> tuple[Ragged, Ints]:
        """The neighbours of each vertex: rows by vertex, and the neighbour of each row."""
        mine, theirs = np.concatenate([self.edge, self.edge[:, ::-1]]).T
        order = np.lexsort((theirs, mine))
        return Ragged.from_owners(mine[order], len(self.point)), theirs[order]

    @cached_property
    def boxes(self) -> tuple[Floats, Floats]:
        """Lowest and highest corner (e, 3) [m] of every edge."""
        one, other = self.point[self.edge[:, 0]], self.point[self.edge[:, 1]]
        return np.minimum(one, other), np.maximum(one, other)

    def around(self, vertex: Ints) -> tuple[Ragged, Ints]:
        """Some vertices, each with its neighbours: rows by given vertex, and their vertices."""
        rows, neighbour = self.beside
        part, row = rows.take(vertex)
        return part, neighbour[row]


def edge_contacts(
    assembly: Assembly, patches: Patches, pairs: Pairs, options: DetectionOptions
) -> tuple[Interfaces, Ints]:
    """Contacts of edges and vertices with faces, and of edges that cross.

    Parameters
    ----------
    pairs
        Near blocks (a < b) without a face contact.

    Returns
    -------
    interfaces
        Lines with two corners and points with one; area zero.
    undirected : (u, 2)
        Pairs that meet only along parallel edges or at corners, where the contact has no defined
        normal.
    """
    search = _EdgeSearch(assembly, patches, options)
    rows: list[tuple[int, int, _Touch]] = []
    undirected = []
    for a, b in zip(pairs[0].tolist(), pairs[1].tolist(), strict=True):
        touches, meets = search.between(a, b)
        rows += [(a, b, touch) for touch in touches]
        if meets and not touches:
            undirected.append((a, b))
    return _interfaces(patches, rows), np.array(undirected, dtype=np.intp).reshape(-1, 2)


def _interfaces(patches: Patches, rows: list[tuple[int, int, _Touch]]) -> Interfaces:
    count = np.array([len(touch.points) for _, _, touch in rows], dtype=np.intp)
    block_a = np.array([a for a, _, _ in rows], dtype=np.intp)
    block_b = np.array([b for _, b, _ in rows], dtype=np.intp)
    normals = np.array([touch.normal for _, _, touch in rows]).reshape(-1, 3)
    none = np.zeros(len(rows))
    return Interfaces(
        block_a=block_a,
        block_b=block_b,
        face_a=np.array([touch.face_a for _, _, touch in rows], dtype=np.intp),
        face_b=np.array([touch.face_b for _, _, touch in rows], dtype=np.intp),
        frame=frames_from_normals(normals),
        point=np.concatenate([np.zeros((0, 3)), *(touch.points for _, _, touch in rows)]),
        start=Ragged.from_counts(count).start,
        area=none,
        gap=np.array([touch.gap for _, _, touch in rows], dtype=np.float64),
        warp=none,
        angle=none,
        clipped=np.zeros(len(rows), dtype=bool),
        merged=np.ones(len(rows), dtype=np.intp),
        size=np.minimum(patches.size[block_a], patches.size[block_b]),
    )


class _EdgeSearch:
    """Search for contacts of the edges and vertices of two blocks."""

    def __init__(self, assembly: Assembly, patches: Patches, options: DetectionOptions) -> None:
        self._assembly = assembly
        self._patches = patches
        self._options = options
        self._slack = warp_slack(patches, options)
        self._frame = frames_from_normals(patches.normal)
        self._wires: dict[int, _Wire] = {}
        self._regions: dict[int, Any] = {}

    def _reach(self, size: float) -> float:
        """Largest distance [m] of blocks of a size [m]."""
        return float(self._options.reach(np.array(size)))

    def between(self, a: int, b: int) -> tuple[list[_Touch], bool]:
        """Contacts, and whether edges or corners meet without one."""
        size = float(min(self._patches.size[a], self._patches.size[b]))
        touches: list[_Touch] = []
        meets = False
        for body, other, sign in ((a, b, -1.0), (b, a, 1.0)):
            found, at_outline = self._on_faces(body, other, sign, size)
            touches += found
            meets |= at_outline
        return touches or self._crossing(a, b, size), meets

    def _wire(self, block: int) -> _Wire:
        if block not in self._wires:
            body = self._assembly.blocks[block]
            self._wires[block] = _Wire(body.vertices - self._patches.origin, edges_of(body.faces))
        return self._wires[block]

    def _region(self, patch: int) -> Any:
        """The patch as a shapely polygon in its own plane."""
        if patch not in self._regions:
            p = self._patches
            ring = p.ring_start[p.first_ring[patch] : p.first_ring[patch + 1] + 1]
            flat = self._flat(p.corner[ring[0] : ring[-1]], patch)
            owner = np.zeros(len(ring) - 1, dtype=np.intp)
            self._regions[patch] = planar.regions(flat, ring - ring[0], owner)[0]
        return self._regions[patch]

    def _flat(self, points: Floats, patch: int) -> Floats:
        flat: Floats = (points - self._patches.centre[patch]) @ self._frame[patch, 1:].T
        return flat

    def _on_faces(
        self, body: int, other: int, sign: float, size: float
    ) -> tuple[list[_Touch], bool]:
        """Edges and vertices of one block on faces of the other."""
        wire = self._wire(body)
        resting = _Resting(wire, self._patches, self._frame, self._slack, self._reach(size))
        edge, edge_patch, vertex, vertex_patch = resting.on(other)
        touches: list[_Touch] = []
        meets = False
        every = np.unique(np.concatenate([edge_patch, vertex_patch]))
        edges = np.searchsorted(edge_patch, [every, every + 1]).T.tolist()
        vertices = np.searchsorted(vertex_patch, [every, every + 1]).T.tolist()
        for g, (i, j), (k, m) in zip(every.tolist(), edges, vertices, strict=True):
            found, at_outline = self._on_face(wire, g, edge[i:j], vertex[k:m], size)
            meets |= at_outline
            for points, gap in found:
                mine, theirs = -1, int(self._patches.face[g])
                faces = (mine, theirs) if sign < 0 else (theirs, mine)
                touches.append(_Touch(points, sign * self._patches.normal[g], *faces, gap))
        return touches, meets

    def _on_face(
        self, wire: _Wire, patch: int, edge: Ints, vertex: Ints, size: float
    ) -> tuple[list[tuple[Floats, float]], bool]:
        """Points (2, 3) or (1, 3) and gap of the contacts with one face.

        ``edge`` and ``vertex`` rest on its plane.
        """
        region = self._region(patch)
        outline = shapely.boundary(region)
        inside = _INSIDE * size
        found: list[tuple[Floats, float]] = []
        meets = False
        covered: set[int] = set()
        for i, j in wire.edge[edge].tolist():
            ends = self._flat(wire.point[[i, j]], patch)
            shared = shapely.intersection(shapely.linestrings(ends), region)
            for part in shapely.get_parts(shared):
                if shapely.length(part) <= _SHORT * size:
                    continue
                middle = shapely.line_interpolate_point(part, 0.5, normalized=True)
                covered |= {i, j}
                if shapely.distance(middle, outline) <= inside:
                    meets = True
                    continue
                flat = shapely.get_coordinates(part)[[0, -1]]
                found.append(self._lifted(flat, patch, self._heights(wire, patch, [i, j])))
        for i in vertex.tolist():
            if i in covered:
                continue
            flat = self._flat(wire.point[[i]], patch)
            point = shapely.points(flat[0])
            if shapely.distance(point, outline) <= max(inside, self._reach(size)):
                meets = True
            if shapely.contains(region, point) and shapely.distance(point, outline) > inside:
                found.append(self._lifted(flat, patch, self._heights(wire, patch, [i])))
        return found, meets

    def _heights(self, wire: _Wire, patch: int, vertex: list[int]) -> Floats:
        return heights(self._patches, wire.point[vertex], np.full(len(vertex), patch))

    def _lifted(self, flat: Floats, patch: int, height: Floats) -> tuple[Floats, float]:
        """Points of a face plane in space, halfway up the gap, and the gap."""
        gap = float(height.mean())
        plane = self._frame[patch]
        centre = self._patches.centre[patch]
        return centre + flat @ plane[1:] + 0.5 * gap * plane[0], gap

    def _crossing(self, a: int, b: int, size: float) -> list[_Touch]:
        """Points where edges of the two blocks cross, outside of both."""
        one, two = self._wire(a), self._wire(b)
        touches = []
        for i, j, p, q in _crossings(one, two, self._reach(size)):
            along = (
                np.diff(one.point[one.edge[i]], axis=0)[0],
                np.diff(two.point[two.edge[j]], axis=0)[0],
            )
            normal = np.cross(*along)
            normal /= np.sqrt(normal @ normal)
            mine, theirs = (wire.around(wire.edge[k])[1] for wire, k in ((one, i), (two, j)))
            for direction in (normal, -normal):
                below = (one.point[mine] - p) @ direction
                above = (two.point[theirs] - q) @ direction
                if below.max() <= _INSIDE * size and above.min() >= -_INSIDE * size:
                    gap = float((q - p) @ direction)
                    touches.append(_Touch(0.5 * (p + q)[None], direction, -1, -1, gap))
                    break
        return touches


@dataclass(frozen=True)
class _Resting:
    """Edges and vertices of one block that may rest on faces of another."""

    wire: _Wire
    patches: Patches
    frame: Floats  # (p, 3, 3) of all patches
    slack: Floats  # (p,) [m]
    margin: float  # [m]

    def on(self, block: int) -> tuple[Ints, Ints, Ints, Ints]:
        """Edges and their patches, vertices and their patches; by patch, then by number.

        Both ends of such an edge, and such a vertex, are near the plane of the patch and have all
        their neighbours on its outer side. The edge or the vertex is in front of the box of the
        patch, or so near to it that it may meet its outline.
        """
        first, last = self.patches.first_patch[block : block + 2]
        patch = np.arange(first, last)
        reach = (2.0 * self.margin + self.slack[patch] + self.patches.warp[patch])[:, None]
        low, high = self.patches.low[patch] - reach, self.patches.high[patch] + reach
        some = _within(self.wire, low, high)
        edges, vertices = [np.zeros(0, dtype=np.intp)], [np.zeros(0, dtype=np.intp)]
        count = max(self.wire.edge.shape[0], len(self.wire.point))
        for i, j in boxes.batches(self.wire.boxes[0][some], self.wire.boxes[1][some], low, high):
            ends, near = self.wire.edge[some[i]], patch[j]
            rests = self._rest(ends.ravel(), np.repeat(near, 2)).reshape(-1, 2)
            both = rests.all(axis=1)
            edges.append(near[both] * count + some[i[both]])
            vertices.append((near[:, None] * count + ends)[rests])
        on_patch, edge = np.divmod(np.unique(np.concatenate(edges)), count)
        at_patch, vertex = np.divmod(np.unique(np.concatenate(vertices)), count)
        return edge, on_patch, vertex, at_patch

    def _rest(self, vertex: Ints, patch: Ints) -> Bools:
        """Whether each vertex (q,) is near the plane of its patch and no neighbour is behind it."""
        tolerance = self.margin + self.slack[patch]
        away = np.abs(heights(self.patches, self.wire.point[vertex], patch))
        rests: Bools = away <= tolerance
        near = np.flatnonzero(rests)
        part, neighbour = self.wire.around(vertex[near])
        height = heights(self.patches, self.wire.point[neighbour], part.spread(patch[near]))
        rests[near] = part.min(height) >= -tolerance[near]
        return rests


def _within(wire: _Wire, low: Floats, high: Floats) -> Ints:
    """Edges whose boxes reach into the box around some boxes (b, 3)."""
    around = low.min(axis=0)[None], high.max(axis=0)[None]
    return np.flatnonzero(boxes.touching(*wire.boxes, *around))


def heights(patches: Patches, point: Floats, patch: Ints) -> Floats:
    """Distance (q,) [m] of points (q, 3) from the planes of patches (q,), outwards."""
    height: Floats = ((point - patches.centre[patch]) * patches.normal[patch]).sum(axis=1)
    return height


def _crossings(
    one: _Wire, two: _Wire, distance: float
) -> Iterator[tuple[int, int, Floats, Floats]]:
    """Pairs of edges that pass each other within a distance, and the nearest points.

    Source: Ericson 2005, Real-time collision detection, section 5.1.9.
    """
    low, high = two.boxes[0] - distance, two.boxes[1] + distance
    some = _within(one, low, high)
    for i, j in boxes.batches(one.boxes[0][some], one.boxes[1][some], low, high):
        order = np.lexsort((j, i))
        first, second = some[i[order]], j[order]
        start, begin = one.point[one.edge[first, 0]], two.point[two.edge[second, 0]]
        along = one.point[one.edge[first, 1]] - start
        run = two.point[two.edge[second, 1]] - begin
        between = start - begin
        a, b, c = dot(along, along), dot(along, run), dot(run, run)
        d, e = dot(along, between), dot(run, between)
        square = a * c - b * b
        crosses = square > _PARALLEL**2 * a * c
        safe = np.where(crosses, square, 1.0)
        s, t = (b * e - c * d) / safe, (a * e - b * d) / safe
        crosses &= (s > _INSIDE) & (s < 1.0 - _INSIDE) & (t > _INSIDE) & (t < 1.0 - _INSIDE)
        p, q = start + s[:, None] * along, begin + t[:, None] * run
        crosses &= dot(p - q, p - q) <= distance**2
        for k in np.flatnonzero(crosses).tolist():
            yield int(first[k]), int(second[k]), p[k], q[k]
