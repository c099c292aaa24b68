"""Blocks that stand in each other: which pairs, and how deep."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drystone.arrays import Floats, Ints
from drystone.assembly import Assembly, Block
from drystone.detection.search.candidates import Pairs, block_boxes
from drystone.detection.search.patches import Patches
from drystone.geometry import boxes
from drystone.geometry.body.depth import depths
from drystone.geometry.body.polyhedron import edges_of

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
    row = np.flatnonzero(~both)
    least, direction = _least_overlaps(assembly, patches, a[deep[row]], b[deep[row]])
    close = least > tolerance[deep[row]]
    row, pair = row[close], deep[row[close]]
    faces = replace(assembly.faces, point=assembly.faces.point - patches.origin)
    depth[row] = depths(faces, a[pair], b[pair], tolerance[pair], direction[close])
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


def _least_overlaps(
    assembly: Assembly, patches: Patches, a: Ints, b: Ints
) -> tuple[Floats, Floats]:
    """Least overlap (p,) [m] along any face normal of the two, and that normal (p, 3).

    A plane parts them where it is 0.
    """
    first = patches.first_patch
    least, direction = np.zeros(len(a)), np.zeros((len(a), 3))
    for k, pair in enumerate(zip(a.tolist(), b.tolist(), strict=True)):
        normals = np.concatenate([patches.normal[first[i] : first[i + 1]] for i in pair])
        one, two = (assembly.blocks[i].vertices - patches.origin for i in pair)
        x, y = one @ normals.T, two @ normals.T
        overlap = np.minimum(x.max(axis=0) - y.min(axis=0), y.max(axis=0) - x.min(axis=0))
        thinnest = int(np.argmin(overlap))
        least[k], direction[k] = overlap[thinnest], normals[thinnest]
    return least, direction


def _directions(block: Block) -> Floats:
    """Unit directions of the edges of one block, parallel ones once, up to rounding."""
    ends = block.vertices[edges_of(block.faces)]
    edge = ends[:, 1] - ends[:, 0]
    edge /= np.sqrt((edge * edge).sum(axis=1))[:, None]
    main = edge[np.arange(len(edge)), np.argmax(np.abs(edge) > 0.5, axis=1)]
    edge *= np.where(main < 0.0, -1.0, 1.0)[:, None]
    return edge[np.unique(np.round(edge, 7), axis=0, return_index=True)[1]]


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


__all__ = ["Penetration", "penetrations"]
