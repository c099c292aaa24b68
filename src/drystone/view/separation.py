"""Planes that separate blocks: by their boxes, by their faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, dot
from drystone.base.ragged import BATCH, Ragged

_TOUCHING = 1e-3
"""Share of a block's size by which blocks may reach through a plane between them; chosen, for
drawing only."""
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
    apart = gap >= -_TOUCHING * np.minimum(bodies.size[first], bodies.size[second])
    return apart, np.where(apart, sign, 0.0)
