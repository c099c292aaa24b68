"""The order in which the faces of a drawing are painted, from back to front.

Two faces that overlap on the paper are ordered by their depth at a point that both cover; a
comparison of centroids is not enough. Faces that hide each other in a ring are drawn triangle by
triangle.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, plane_cross
from drystone.base.ragged import Ragged
from drystone.geometry import clip
from drystone.geometry.halfedge import sharp_edges
from drystone.geometry.triangulate import triangulate


@dataclass(frozen=True, eq=False)
class SortedPolygons:
    """Polygons in the order in which they are drawn, far ones first.

    Attributes
    ----------
    corner : (l,) positions in ``assembly.faces.loop``, patch after patch
    start : (p + 1,)
    face : (p,) the face that a patch is, or is part of
    outlined : (l,) whether the side from a corner to the next is an edge of the block
    """

    corner: Ints
    start: Ints
    face: Ints
    outlined: Bools


def ordered_patches(assembly: Assembly, toward: Floats, paper: Floats) -> SortedPolygons:
    """The visible sides of all blocks, far ones first.

    Parameters
    ----------
    assembly
    toward, paper
        Unit vector (3,) to the eye, and the axes (2, 3) of the paper.
    """
    faces = assembly.faces
    front = faces.normals @ toward > ROUNDING
    _, _, drawn = sharp_edges(faces, front)
    corners = faces.point[faces.loop]
    every = np.flatnonzero(front)
    loops_of, row = faces.corners.take(every)
    triangle, face = triangulate(corners[row], loops_of.start)
    triangle, face = row[triangle], every[face]
    behind, before = _hidden_pairs(corners[triangle], toward, paper)
    # Faces stay whole unless they hide each other in a ring; then they go triangle by triangle.
    ring = _rings(faces.count, face[behind], face[before])
    single = ring[face]
    item = np.where(single, faces.count + np.arange(len(face)), face)
    depth = np.concatenate(
        [faces.corners.mean(corners @ toward), (corners[triangle] @ toward).mean(axis=1)]
    )
    place = np.argsort(topological(len(depth), item[behind], item[before], depth))
    whole = every[~ring[every]]
    loops = [np.arange(faces.start[f], faces.start[f + 1]) for f in whole]
    loops += list(triangle[single])
    owner = np.concatenate([whole, face[single]]).astype(np.intp)
    order = np.argsort(place[np.concatenate([whole, item[single]])])
    loops = [loops[i] for i in order]
    corner = np.concatenate(loops) if loops else np.zeros(0, dtype=np.intp)
    start = Ragged.of(loops).start
    next_corner = corner[Ragged(start).following] if len(corner) else corner
    outlined = drawn[corner] & (next_corner == faces.corners.following[corner])
    return SortedPolygons(corner, start, owner[order], outlined)


def topological(count: int, before: Ints, after: Ints, depth: Floats) -> Ints:
    """An order (count,) that respects all pairs, the farthest first where there is a choice.

    Parameters
    ----------
    count
    before, after : (e,)
    depth : (count,)
        Larger is nearer to the eye. In a ring of pairs the farthest is drawn first.
    """
    pairs = np.unique(np.stack([before, after], axis=1), axis=0).reshape(-1, 2)
    first = np.searchsorted(pairs[:, 0], np.arange(count + 1)).tolist()
    target = pairs[:, 1].tolist()
    waiting = np.bincount(pairs[:, 1], minlength=count).tolist()
    keys = depth.tolist()
    ready = [(keys[i], i) for i in range(count) if waiting[i] == 0]
    heapq.heapify(ready)
    by_depth = iter(np.argsort(depth, kind="stable").tolist())
    done = [False] * count
    order: list[int] = []
    while len(order) < count:
        item = heapq.heappop(ready)[1] if ready else next(i for i in by_depth if not done[i])
        if done[item]:
            continue
        done[item] = True
        order.append(item)
        for other in target[first[item] : first[item + 1]]:
            waiting[other] -= 1
            if waiting[other] == 0 and not done[other]:
                heapq.heappush(ready, (keys[other], other))
    return np.array(order, dtype=np.intp)


def _rings(count: int, before: Ints, after: Ints) -> Bools:
    """Which items (count,) no order of the pairs can place."""
    graph = coo_array((np.ones(len(before)), (before, after)), shape=(count, count))
    _, group = connected_components(graph, directed=True, connection="strong")
    return (np.bincount(group) > 1)[group] if count else np.zeros(0, dtype=bool)


def _hidden_pairs(triangle: Floats, toward: Floats, paper: Floats) -> tuple[Ints, Ints]:
    """Pairs (behind, in front) of triangles (t, 3, 3) that overlap on the paper."""
    if len(triangle) == 0:
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    flat = triangle @ paper.T  # counter-clockwise: the sides are seen from outside
    depth = triangle @ toward
    shape = shapely.polygons(flat)
    area = shapely.area(shape)
    wide = area > 1e-12 * np.ptp(flat) ** 2  # a sliver seen edge-on hides nothing
    i, j = shapely.STRtree(shape).query(shape)
    keep = (i < j) & wide[i] & wide[j]
    i, j = i[keep], j[keep]
    three = np.full(len(i), 3)
    common, start = clip.flatten(clip.intersect_convex((flat[i], three), (flat[j], three)))
    keep = clip.areas(common, start) > 1e-9 * np.minimum(area[i], area[j])
    i, j = i[keep], j[keep]
    at = Ragged(start).mean(common)[keep]
    nearer = _depth_at(flat[j], depth[j], at) - _depth_at(flat[i], depth[i], at)
    apart = np.abs(nearer) > 1e-9 * (np.ptp(depth) + np.ptp(flat))
    front_j = nearer > 0.0
    behind, before = np.where(front_j, i, j)[apart], np.where(front_j, j, i)[apart]
    return behind.astype(np.intp), before.astype(np.intp)


def _depth_at(flat: Floats, depth: Floats, at: Floats) -> Floats:
    """Depth of the planes of triangles (p, 3, 2) with corner depths (p, 3) at points (p, 2)."""
    a, b = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    p = at - flat[:, 0]
    whole = plane_cross(a, b)
    whole = np.where(whole == 0.0, 1.0, whole)
    s = plane_cross(p, b) / whole
    t = plane_cross(a, p) / whole
    return depth[:, 0] + s * (depth[:, 1] - depth[:, 0]) + t * (depth[:, 2] - depth[:, 0])
