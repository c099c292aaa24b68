"""Blocks that stand in each other: which pairs, and how deep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.detection.candidates import Pairs, block_boxes
from drystone.detection.patches import Patches
from drystone.geometry import boxes, solid
from drystone.geometry.arrays import Floats, Ints
from drystone.geometry.triangulate import triangulate

CROSS = 1e-6
"""Cross products of unit directions shorter than this name no direction of their own."""


@dataclass(frozen=True)
class Penetration:
    """Two blocks that stand in each other.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    depth : [m]
        For convex blocks the shortest way that frees them. Otherwise how far the deepest point on
        an edge of the one lies below the surface of the other.
    """

    block_a: int
    block_b: int
    depth: float


def penetrations(
    assembly: Assembly, patches: Patches, pairs: Pairs, joined: Ints, tolerance: Floats
) -> tuple[Penetration, ...]:
    """Pairs of blocks that are deeper in each other than is tolerated.

    Parameters
    ----------
    pairs
        Near blocks, a < b.
    joined : (j,)
        Positions in ``pairs`` of those with a face contact: convex ones are parted by its plane.
    tolerance : (p,) [m] per pair
    """
    a, b = pairs
    low, high = block_boxes(patches)
    shared = (np.minimum(high[a], high[b]) - np.maximum(low[a], low[b])).min(axis=1)
    convex = patches.block_convex[a] & patches.block_convex[b]
    parted = np.zeros(len(a), dtype=bool)
    parted[joined] = True
    deep = np.flatnonzero((shared > tolerance) & ~(parted & convex))
    depth = np.zeros(len(deep))
    both = convex[deep]
    depth[both] = _convex_depth(assembly, patches, a[deep[both]], b[deep[both]])
    bodies = _Bodies(assembly, patches.origin)
    for i in np.flatnonzero(~both):
        one, two = int(a[deep[i]]), int(b[deep[i]])
        if _least_overlap(assembly, patches, one, two) > tolerance[deep[i]]:
            depth[i] = bodies.depth(one, two, float(tolerance[deep[i]]))
    return tuple(
        Penetration(int(a[pair]), int(b[pair]), float(each))
        for pair, each in zip(deep, depth, strict=True)
        if each > tolerance[pair]
    )


def _convex_depth(assembly: Assembly, patches: Patches, a: Ints, b: Ints) -> Floats:
    """Depth of convex pairs: the least overlap along any separating direction.

    Directions are the face normals of both and, where those do not part them, the cross products of
    their edges. Source: Gottschalk, Lin, Manocha 1996.
    """
    if len(a) == 0:
        return np.zeros(0)
    depth = np.minimum(
        _face_overlap(assembly, patches, a, b), _face_overlap(assembly, patches, b, a)
    )
    for i in np.flatnonzero(depth > 0.0):
        one, two = assembly.blocks[a[i]], assembly.blocks[b[i]]
        directions = np.cross(_directions(one)[:, None], _directions(two)[None])
        directions = directions.reshape(-1, 3)
        length = np.sqrt((directions * directions).sum(axis=1))
        unit = directions[length > CROSS] / length[length > CROSS, None]
        if len(unit) == 0:
            continue
        middle = one.centroid
        x, y = (one.vertices - middle) @ unit.T, (two.vertices - middle) @ unit.T
        overlap = np.minimum(x.max(axis=0) - y.min(axis=0), y.max(axis=0) - x.min(axis=0))
        depth[i] = min(depth[i], float(overlap.min()))
    return np.maximum(depth, 0.0)


def _least_overlap(assembly: Assembly, patches: Patches, a: int, b: int) -> float:
    """Least overlap [m] of two blocks along any of their face normals; a plane parts them at 0."""
    first = patches.first_patch
    normals = np.concatenate([patches.normal[first[i] : first[i + 1]] for i in (a, b)])
    one, two = (assembly.blocks[i].vertices - patches.origin for i in (a, b))
    x, y = one @ normals.T, two @ normals.T
    overlap = np.minimum(x.max(axis=0) - y.min(axis=0), y.max(axis=0) - x.min(axis=0))
    return float(overlap.min())


def _directions(block: Block) -> Floats:
    """Unit directions of the edges of one block, parallel ones once, up to rounding."""
    start, end = _edges(block)
    edge = end - start
    edge /= np.sqrt((edge * edge).sum(axis=1))[:, None]
    main = edge[np.arange(len(edge)), np.argmax(np.abs(edge) > 0.5, axis=1)]
    edge *= np.where(main < 0.0, -1.0, 1.0)[:, None]
    return edge[np.unique(np.round(edge, 7), axis=0, return_index=True)[1]]


def _edges(block: Block) -> tuple[Floats, Floats]:
    """First and second end (e, 3) [m] of every edge of a block."""
    pairs = {
        (min(i, j), max(i, j))
        for face in block.faces
        for i, j in zip(face, (*face[1:], face[0]), strict=True)
    }
    ends = block.vertices[np.array(sorted(pairs))]
    return ends[:, 0], ends[:, 1]


def _face_overlap(assembly: Assembly, patches: Patches, a: Ints, b: Ints) -> Floats:
    """Least depth (p,) of the block b below any face plane of a."""
    count = np.array([len(block.vertices) for block in assembly.blocks], dtype=np.intp)
    first_vertex = np.concatenate([[0], np.cumsum(count)]).astype(np.intp)
    point = assembly.faces.point - patches.origin
    first = patches.first_patch
    pair, patch = boxes.expand(first[a], first[a + 1] - first[a])
    depth = np.empty(len(patch))
    vertices = count[b][pair]
    for part in np.split(
        np.arange(len(patch)), np.flatnonzero(np.diff(np.cumsum(vertices) // boxes.BATCH)) + 1
    ):
        source, vertex = boxes.expand(first_vertex[b[pair[part]]], vertices[part])
        height = point[vertex] - patches.centre[patch[part]][source]
        along = (height * patches.normal[patch[part]][source]).sum(axis=1)
        begin = np.cumsum(vertices[part]) - vertices[part]
        depth[part] = -np.minimum.reduceat(along, begin)
    begin = np.cumsum(first[a + 1] - first[a]) - (first[a + 1] - first[a])
    least: Floats = np.minimum.reduceat(depth, begin)
    return least


class _Bodies:
    """Blocks as triangles, made when first asked for."""

    def __init__(self, assembly: Assembly, origin: Floats) -> None:
        self._assembly = assembly
        self._origin = origin
        self._triangles: dict[int, Floats] = {}

    def triangles(self, block: int) -> Floats:
        if block not in self._triangles:
            body = self._assembly.blocks[block]
            corner = body.vertices[[i for face in body.faces for i in face]] - self._origin
            start = np.concatenate([[0], np.cumsum([len(face) for face in body.faces])])
            self._triangles[block] = corner[triangulate(corner, start.astype(np.intp))[0]]
        return self._triangles[block]

    def depth(self, a: int, b: int, least: float) -> float:
        """How deep points on the edges of one lie in the other [m], if deeper than ``least``."""
        return max(self._depth_of_edges(a, b, least), self._depth_of_edges(b, a, least))

    def _depth_of_edges(self, block: int, other: int, least: float) -> float:
        triangles = self.triangles(other)
        low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
        start, end = (x - self._origin for x in _edges(self._assembly.blocks[block]))
        near = (np.minimum(start, end) <= high).all(axis=1)
        near &= (np.maximum(start, end) >= low).all(axis=1)
        start, end = start[near], end[near]
        if len(start) == 0:
            return 0.0
        segment, share = solid.crossings(start, end, triangles)
        edge = np.concatenate([np.tile(np.arange(len(start)), 2), segment])
        place = np.concatenate([np.zeros(len(start)), np.ones(len(start)), share])
        order = np.lexsort((place, edge))
        edge, place = edge[order], place[order]
        along = end - start
        length = np.sqrt((along * along).sum(axis=1))
        stretch = np.diff(place) * length[edge[:-1]]  # half of it is the most its middle is deep
        between = np.flatnonzero((edge[1:] == edge[:-1]) & (stretch > 2.0 * least))
        middle = start[edge[between]]
        middle = (
            middle + (0.5 * (place[between] + place[between + 1]))[:, None] * along[edge[between]]
        )
        points = np.concatenate([np.unique(np.concatenate([start, end]), axis=0), middle])
        points = points[((points >= low) & (points <= high)).all(axis=1)]
        points = points[solid.inside(points, triangles)]
        return float(solid.distance(points, triangles).max(initial=0.0))


__all__ = ["Penetration", "penetrations"]
