"""Contacts along a line or at a point, where blocks touch with an edge or a corner."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.ragged import Ragged
from drystone.detection.detection_options import DetectionOptions
from drystone.detection.search.candidates import Pairs, warp_slack
from drystone.detection.search.interfaces import Interfaces
from drystone.detection.search.patches import Patches
from drystone.geometry import boxes
from drystone.geometry.body.polyhedron import edges_of
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.plane import planar

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

    def lowest_neighbour(self, height: Floats) -> Floats:
        """For heights (v, ...) of the vertices: the least height among the neighbours of each."""
        least = np.full(height.shape, np.inf)
        np.minimum.at(least, self.edge[:, 0], height[self.edge[:, 1]])
        np.minimum.at(least, self.edge[:, 1], height[self.edge[:, 0]])
        return least


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
        self._gap = options.gap
        self._slack = warp_slack(patches, options)
        self._frame = frames_from_normals(patches.normal)
        self._wires: dict[int, _Wire] = {}
        self._regions: dict[int, Any] = {}

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

    def _near_patches(self, other: int, wire: _Wire, margin: float) -> Ints:
        first, last = self._patches.first_patch[other : other + 2]
        patch = np.arange(first, last)
        low, high = wire.point.min(axis=0) - margin, wire.point.max(axis=0) + margin
        reach = self._slack[patch, None]
        near = boxes.touching(
            self._patches.low[patch] - reach,
            self._patches.high[patch] + reach,
            np.broadcast_to(low, (len(patch), 3)),
            np.broadcast_to(high, (len(patch), 3)),
        )
        return patch[near].astype(np.intp)

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
        margin = self._gap * size
        patch = self._near_patches(other, wire, margin)
        offset = wire.point[:, None] - self._patches.centre[None, patch]
        height = (offset * self._patches.normal[None, patch]).sum(axis=2)
        tolerance = margin + self._slack[patch]
        rests = (np.abs(height) <= tolerance) & (wire.lowest_neighbour(height) >= -tolerance)
        touches: list[_Touch] = []
        meets = False
        for column in np.flatnonzero(rests.any(axis=0)).tolist():
            g = int(patch[column])
            found, at_outline = self._on_face(wire, g, height[:, column], rests[:, column], size)
            meets |= at_outline
            for points, gap in found:
                mine, theirs = -1, int(self._patches.face[g])
                faces = (mine, theirs) if sign < 0 else (theirs, mine)
                touches.append(_Touch(points, sign * self._patches.normal[g], *faces, gap))
        return touches, meets

    def _on_face(
        self, wire: _Wire, patch: int, height: Floats, rests: Bools, size: float
    ) -> tuple[list[tuple[Floats, float]], bool]:
        """Points (2, 3) or (1, 3) and gap of the contacts with one face."""
        region = self._region(patch)
        outline = shapely.boundary(region)
        inside = _INSIDE * size
        found: list[tuple[Floats, float]] = []
        meets = False
        covered = np.zeros(len(height), dtype=bool)
        for i, j in wire.edge[rests[wire.edge].all(axis=1)].tolist():
            ends = self._flat(wire.point[[i, j]], patch)
            shared = shapely.intersection(shapely.linestrings(ends), region)
            for part in shapely.get_parts(shared):
                if shapely.length(part) <= _SHORT * size:
                    continue
                middle = shapely.line_interpolate_point(part, 0.5, normalized=True)
                covered[[i, j]] = True
                if shapely.distance(middle, outline) <= inside:
                    meets = True
                    continue
                flat = shapely.get_coordinates(part)[[0, -1]]
                found.append(self._lifted(flat, patch, height[[i, j]]))
        for i in np.flatnonzero(rests & ~covered).tolist():
            flat = self._flat(wire.point[[i]], patch)
            point = shapely.points(flat[0])
            if shapely.distance(point, outline) <= max(inside, self._gap * size):
                meets = True
            if shapely.contains(region, point) and shapely.distance(point, outline) > inside:
                found.append(self._lifted(flat, patch, height[[i]]))
        return found, meets

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
        for i, j, p, q in _crossings(one, two, self._gap * size):
            along = (
                np.diff(one.point[one.edge[i]], axis=0)[0],
                np.diff(two.point[two.edge[j]], axis=0)[0],
            )
            normal = np.cross(*along)
            normal /= np.sqrt(normal @ normal)
            for direction in (normal, -normal):
                below = (one.point[_around(one, i)] - p) @ direction
                above = (two.point[_around(two, j)] - q) @ direction
                if below.max() <= _INSIDE * size and above.min() >= -_INSIDE * size:
                    gap = float((q - p) @ direction)
                    touches.append(_Touch(0.5 * (p + q)[None], direction, -1, -1, gap))
                    break
        return touches


def _around(wire: _Wire, edge: int) -> Ints:
    """Vertices joined to either end of an edge."""
    ends = wire.edge[edge]
    return np.unique(wire.edge[np.isin(wire.edge, ends).any(axis=1)])


def _crossings(
    one: _Wire, two: _Wire, distance: float
) -> Iterator[tuple[int, int, Floats, Floats]]:
    """Pairs of edges that pass each other within a distance, and the nearest points.

    Source: Ericson 2005, Real-time collision detection, section 5.1.9.
    """
    start, along = one.point[one.edge[:, 0]], np.diff(one.point[one.edge], axis=1)[:, 0]
    begin, run = two.point[two.edge[:, 0]], np.diff(two.point[two.edge], axis=1)[:, 0]
    a = (along * along).sum(axis=1)[:, None]
    c = (run * run).sum(axis=1)[None]
    b = along @ run.T
    between = start[:, None] - begin[None]
    d = (along[:, None] * between).sum(axis=2)
    e = (run[None] * between).sum(axis=2)
    square = a * c - b * b
    crosses = square > _PARALLEL**2 * a * c
    safe = np.where(crosses, square, 1.0)
    s, t = (b * e - c * d) / safe, (a * e - b * d) / safe
    crosses &= (s > _INSIDE) & (s < 1.0 - _INSIDE) & (t > _INSIDE) & (t < 1.0 - _INSIDE)
    for i, j in np.argwhere(crosses).tolist():
        p, q = start[i] + s[i, j] * along[i], begin[j] + t[i, j] * run[j]
        if (p - q) @ (p - q) <= distance**2:
            yield i, j, p, q
