"""The order in which the faces of a drawing are painted, from back to front.

Two blocks that touch are separated by the plane of their interface, so the one on the eye's side is
drawn later. A comparison of centroids is not enough. Blocks that do not touch but overlap on the
paper are ordered by a plane between them. Where no single order exists (a box in the notch of an L,
three sticks that overlap in a ring), the blocks concerned are drawn triangle by triangle, each pair
ordered by its depth at a point that both cover.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, dot, plane_cross
from drystone.base.ragged import BATCH, Ragged
from drystone.contacts import Contacts
from drystone.geometry.halfedge import sharp_edges
from drystone.geometry.triangulate import triangulate
from drystone.view.section import NEAR

_INTERFACE_OVERLAP = 0.1
"""Share of a block's size by which two blocks may reach through their common plane (warped faces,
gaps, interpenetration) and still be ordered by it; chosen, for drawing only."""


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


def ordered_patches(
    assembly: Assembly, contacts: Contacts, toward: Floats, paper: Floats
) -> SortedPolygons:
    """The visible sides of all blocks, far ones first.

    Parameters
    ----------
    assembly
    contacts
    toward : (3,) unit, from the model to the eye
    paper : (2, 3) unit, to the right and up on the paper
    """
    faces = assembly.faces
    normal = faces.normals
    front = normal @ toward > ROUNDING
    _, _, drawn = sharp_edges(faces, front)
    bodies = SeparationData.of(assembly, normal)
    before, after = _block_constraints(bodies, contacts, toward, paper)
    n = len(assembly)
    graph = coo_array((np.ones(len(before)), (before, after)), shape=(n, n))
    group_count, group = connected_components(graph, directed=True, connection="strong")
    depth = assembly.centroid @ toward
    group_depth = np.bincount(group, depth) / np.bincount(group)
    between = group[before] != group[after]
    order = topological(group_count, group[before][between], group[after][between], group_depth)
    rank = np.empty(group_count, dtype=np.intp)
    rank[order] = np.arange(group_count)
    mixed = (np.bincount(group) > 1)[group] | ~bodies.convex
    return _patches(assembly, toward, paper, front, drawn, rank[group], mixed)


def _block_constraints(
    bodies: SeparationData, contacts: Contacts, toward: Floats, paper: Floats
) -> tuple[Ints, Ints]:
    """Pairs of blocks (before, after), to be drawn in this order; both ways where neither works.

    Parameters
    ----------
    bodies
    contacts
    toward, paper
        As in :func:`ordered_patches`.
    """
    first, second = _overlapping(bodies, paper)
    sign = np.zeros(len(first))  # +1: second is in front, -1: first is, 0: neither hides the other
    touching, open_ = _by_interfaces(bodies, contacts, toward, first, second, sign)
    rest = np.flatnonzero(~touching)
    boxed, box_sign = separated_by_boxes(bodies, first[rest], second[rest], toward)
    sign[rest] = box_sign
    open_[rest] = ~boxed
    rest = np.flatnonzero(open_)
    apart, face_sign = separated_by_faces(bodies, first[rest], second[rest], toward)
    sign[rest] = face_sign
    open_[rest] = ~apart
    forward, backward = (sign > 0.0) | open_, (sign < 0.0) | open_
    before = np.concatenate([first[forward], second[backward]])
    after = np.concatenate([second[forward], first[backward]])
    return before, after


def _overlapping(bodies: SeparationData, paper: Floats) -> tuple[Ints, Ints]:
    """Pairs (first < second) whose outlines overlap on the paper."""
    flat = bodies.point @ paper.T
    owner = np.repeat(np.arange(bodies.count), np.diff(bodies.start))
    outline = shapely.convex_hull(shapely.multipoints(flat, indices=owner))
    first, second = shapely.STRtree(outline).query(outline, predicate="intersects")
    keep = first < second
    return first[keep].astype(np.intp), second[keep].astype(np.intp)


def _by_interfaces(
    bodies: SeparationData,
    contacts: Contacts,
    toward: Floats,
    first: Ints,
    second: Ints,
    sign: Floats,
) -> tuple[Bools, Bools]:
    """Fill in the sign of touching pairs; which pairs touch, and which of them stay open."""
    n = bodies.count
    low = np.minimum(contacts.block_a, contacts.block_b)
    high = np.maximum(contacts.block_a, contacts.block_b)
    key, place = np.unique(low * n + high, return_inverse=True)
    facing = contacts.frame[:, 0] @ toward
    facing = np.where(contacts.block_a == low, facing, -facing)
    _, highest = spans(bodies, contacts.block_a, contacts.frame[:, 0])
    lowest, _ = spans(bodies, contacts.block_b, contacts.frame[:, 0])
    size = np.minimum(bodies.size[contacts.block_a], bodies.size[contacts.block_b])
    apart = lowest - highest >= -_INTERFACE_OVERLAP * size
    least, most = np.full(len(key), np.inf), np.full(len(key), -np.inf)
    np.minimum.at(least, place, facing)
    np.maximum.at(most, place, facing)
    clean = np.ones(len(key), dtype=bool)
    np.logical_and.at(clean, place, apart)
    clean &= (least > -ROUNDING) | (most < ROUNDING)
    direction = np.where(most > ROUNDING, 1.0, np.where(least < -ROUNDING, -1.0, 0.0))
    at = np.searchsorted(key, first * n + second)
    touching = at < len(key)
    touching[touching] = key[at[touching]] == (first * n + second)[touching]
    open_ = np.zeros(len(first), dtype=bool)
    pair = at[touching]
    sign[touching] = np.where(clean[pair], direction[pair], 0.0)
    open_[touching] = ~clean[pair]
    return touching, open_


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


def _patches(
    assembly: Assembly,
    toward: Floats,
    paper: Floats,
    front: Bools,
    drawn: Bools,
    rank: Ints,
    mixed: Bools,
) -> SortedPolygons:
    """Whole faces of blocks that can be drawn at once, ordered triangles of the others."""
    faces = assembly.faces
    corners = faces.point[faces.loop]
    whole = np.flatnonzero(front & ~mixed[faces.owner])
    cut = np.flatnonzero(front & mixed[faces.owner])
    face_depth = faces.corners.mean(corners @ toward)
    triangle, triangle_face = _triangles(corners, faces.start, cut)
    before, after = _hidden_pairs(
        corners[triangle], rank[faces.owner[triangle_face]], toward, paper
    )
    # Faces stay whole unless they hide each other in a ring; then they go triangle by triangle.
    item = np.searchsorted(cut, triangle_face)
    ring = _rings(len(cut), item[before], item[after])
    whole = np.concatenate([whole, cut[~ring]])
    single = ring[item]
    item = np.where(single, len(cut) + np.arange(len(item)), item)
    depth = np.concatenate([face_depth[cut], (corners[triangle] @ toward).mean(axis=1)])
    order = topological(len(depth), item[before], item[after], depth)
    place = np.empty(len(depth))
    place[order] = np.arange(len(depth))
    loops = [np.arange(faces.start[f], faces.start[f + 1]) for f in whole] + list(triangle[single])
    face = np.concatenate([whole, triangle_face[single]]).astype(np.intp)
    within = face_depth.copy()
    within[cut] = place[: len(cut)]
    within = np.concatenate([within[whole], place[len(cut) :][single]])
    order = np.lexsort((within, rank[faces.owner[face]]))
    loops = [loops[i] for i in order]
    corner = np.concatenate(loops) if loops else np.zeros(0, dtype=np.intp)
    start = Ragged.of(loops).start
    next_corner = corner[Ragged(start).following] if len(corner) else corner
    outlined = drawn[corner] & (next_corner == faces.corners.following[corner])
    return SortedPolygons(corner, start, face[order], outlined)


def _triangles(corners: Floats, start: Ints, chosen: Ints) -> tuple[Ints, Ints]:
    """Triangles (t, 3), positions in ``corners``, of the chosen faces, and their face (t,)."""
    length = np.diff(start)[chosen]
    local_start = Ragged.from_counts(length).start
    taken = np.repeat(start[chosen] - local_start[:-1], length) + np.arange(local_start[-1])
    triangle, polygon = triangulate(corners[taken], local_start)
    return taken[triangle].reshape(-1, 3), chosen[polygon]


def _rings(count: int, before: Ints, after: Ints) -> Bools:
    """Which items (count,) no order of the pairs can place."""
    graph = coo_array((np.ones(len(before)), (before, after)), shape=(count, count))
    _, group = connected_components(graph, directed=True, connection="strong")
    return (np.bincount(group) > 1)[group] if count else np.zeros(0, dtype=bool)


def _hidden_pairs(
    triangle: Floats, group: Ints, toward: Floats, paper: Floats
) -> tuple[Ints, Ints]:
    """Pairs (behind, in front) of triangles (t, 3, 3) of one group that overlap on the paper."""
    if len(triangle) == 0:
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    flat = triangle @ paper.T
    depth = triangle @ toward
    shape = shapely.polygons(flat)
    area = shapely.area(shape)
    wide = area > 1e-12 * np.ptp(flat) ** 2  # a sliver seen edge-on hides nothing
    i, j = shapely.STRtree(shape).query(shape)
    keep = (i < j) & (group[i] == group[j]) & wide[i] & wide[j]
    i, j = i[keep], j[keep]
    common = shapely.intersection(shape[i], shape[j])
    keep = shapely.area(common) > 1e-9 * np.minimum(area[i], area[j])
    i, j = i[keep], j[keep]
    at = shapely.get_coordinates(shapely.centroid(common[keep]))
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
    value: Floats = depth[:, 0] + s * (depth[:, 1] - depth[:, 0]) + t * (depth[:, 2] - depth[:, 0])
    return value


_NEARLY_CONVEX = 0.05
"""Share of its size by which a block may stick out of the planes of its own faces and be drawn as
if convex (warped faces); chosen."""


@dataclass(frozen=True, eq=False)
class SeparationData:
    """Corners and face directions of all blocks, flat.

    Attributes
    ----------
    point : (v, 3) [m], block after block, start : (n + 1,)
    normal : (f, 3), block after block, face_start : (n + 1,)
    support : (f,) [m], largest extent of the block along each of its normals
    bounds : (n, 2, 3) [m]
    size : (n,) [m]
    convex : (n,), or nearly so
    """

    point: Floats
    start: Ints
    normal: Floats
    face_start: Ints
    support: Floats
    bounds: Floats
    size: Floats
    convex: Bools

    @property
    def count(self) -> int:
        """Number of blocks."""
        return len(self.size)

    @classmethod
    def of(cls, assembly: Assembly, normal: Floats) -> SeparationData:
        """The bodies of an assembly whose faces have the outward normals (f, 3)."""
        faces = assembly.faces
        count = np.array([len(block.vertices) for block in assembly.blocks])
        start = Ragged.from_counts(count).start
        face_start = np.searchsorted(faces.owner, np.arange(len(assembly) + 1)).astype(np.intp)
        point = faces.point - assembly.centroid[0]  # small coordinates even far from the origin
        bounds = assembly.bounds - assembly.centroid[0]
        _, support = _spans(point, start, faces.owner, normal)
        middle = faces.corners.mean(point[faces.loop])
        sticks_out = support - dot(middle, normal)
        worst = Ragged(face_start).max(sticks_out)
        convex = worst <= _NEARLY_CONVEX * assembly.size
        return cls(
            point, start, normal, face_start, support, bounds, np.array(assembly.size), convex
        )


def spans(bodies: SeparationData, block: Ints, direction: Floats) -> tuple[Floats, Floats]:
    """Lowest and highest reach (r,) [m] of blocks (r,) along directions (r, 3)."""
    return _spans(bodies.point, bodies.start, block, direction)


def _spans(point: Floats, start: Ints, block: Ints, direction: Floats) -> tuple[Floats, Floats]:
    lowest, highest = np.empty(len(block)), np.empty(len(block))
    points = Ragged(start)
    for some in Ragged.from_counts(points.counts[block]).batches(BATCH):
        part, row = points.take(block[some])
        reach = dot(point[row], part.spread(direction[some]))
        lowest[some], highest[some] = part.min(reach), part.max(reach)
    return lowest, highest


def separated_by_boxes(
    bodies: SeparationData, first: Ints, second: Ints, toward: Floats
) -> tuple[Bools, Floats]:
    """Whether the bounding boxes of pairs are apart, and which is in front.

    Returns
    -------
    apart : (p,)
    sign : (p,) +1 the second, -1 the first; 0 where two planes contradict: neither hides the other
    """
    size = np.minimum(bodies.size[first], bodies.size[second])[:, None]
    room = -1e-6 * size
    low, high = bodies.bounds[:, 0], bodies.bounds[:, 1]
    beyond = low[second] - high[first] >= room
    below = low[first] - high[second] >= room
    facing = np.where(np.abs(toward) > 1e-9, np.sign(toward), 0.0)
    vote = (beyond.astype(float) - below.astype(float)) * facing
    agree = (vote >= 0.0).all(axis=1) | (vote <= 0.0).all(axis=1)
    sign = np.where(agree, np.sign(vote.sum(axis=1)), 0.0)
    # A pair of boxes apart along a direction in the paper does not overlap on it.
    edge_on = ((beyond | below) & (facing == 0.0)).any(axis=1)
    apart: Bools = np.any(beyond | below, axis=1)
    return apart, np.where(edge_on, 0.0, sign)


def separated_by_faces(
    bodies: SeparationData, first: Ints, second: Ints, toward: Floats
) -> tuple[Bools, Floats]:
    """As :func:`separated_by_boxes`, by the face of either block that separates them best."""
    gap = np.full(len(first), -np.inf)
    sign = np.zeros(len(first))
    for own, other, side in ((first, second, 1.0), (second, first, -1.0)):
        count = np.diff(bodies.face_start)[own]
        begin = np.cumsum(count) - count
        if len(own) == 0:
            continue
        row = np.repeat(np.arange(len(own)), count)
        face = np.repeat(bodies.face_start[own] - begin, count) + np.arange(count.sum())
        lowest, _ = spans(bodies, other[row], bodies.normal[face])
        distance = lowest - bodies.support[face]
        order = np.lexsort((distance, row))
        best = order[begin + count - 1]
        facing = bodies.normal[face[best]] @ toward
        better = distance[best] > gap
        gap = np.where(better, distance[best], gap)
        facing = np.where(np.abs(facing) > 1e-9, np.sign(facing), 0.0)
        sign = np.where(better, side * facing, sign)
    apart = gap >= -NEAR * np.minimum(bodies.size[first], bodies.size[second])
    return apart, np.where(apart, sign, 0.0)
