"""How the corners of interfaces follow the vertices of the two blocks that touch there.

A corner of an interface is a vertex of one block on a face of the other, or of both, or the
crossing of two edges in the plane of the joint.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats, Ints, cross, dot
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.design.vertex_places import BlockVertices
from drystone.detection.edgecontacts import PARALLEL
from drystone.geometry.polyhedron import edges_of
from drystone.model import Model

NEAR = 6e-3
"""A corner is at a vertex, or on an edge, that is nearer than this share of the size of the smaller
block, and a face in the plane of a joint. Chosen above the gap of 5e-3 within which contacts are
found."""


@dataclass(frozen=True, eq=False)
class Corners:
    """The corners of all interfaces as functions of vertices.

    Attributes
    ----------
    at : (k, 2)
        A vertex of block a and one of block b that the corner is at; -1 where it is at none.
    edge_a, edge_b : (k, 2)
        Ends of the two edges that cross there; -1 where a vertex is there.
    offset : (k, 3) [m]
        From what the vertices give to the corner as it was found: the gap of the joint.
    joint
        The corners of each interface.
    frame : (m, 3, 3)
        Of the interfaces as they were found.
    turn : (m,)
        1 where the corners run counter-clockwise about the normal, else -1.
    """

    at: Ints
    edge_a: Ints
    edge_b: Ints
    offset: Floats
    joint: Ragged
    frame: Floats
    turn: Floats

    @classmethod
    def of(cls, model: Model, bodies: BlockVertices) -> Corners:
        """The corners of the interfaces of a model.

        Raises
        ------
        InputError
            A corner is neither at a vertex nor at a crossing of edges: the joint is curved, or was
            given and not found.
        """
        contacts = model.contacts
        count = contacts.corner_count
        at = np.full((count, 2), -1, dtype=np.intp)
        edges = np.full((2, count, 2), -1, dtype=np.intp)
        offset = np.zeros((count, 3))
        for i, own in enumerate(contacts.corners):
            pair = int(contacts.block_a[i]), int(contacts.block_b[i])
            near = NEAR * float(model.assembly.size[list(pair)].min())
            for k in range(own.start, own.stop):
                point = contacts.point[k]
                for side, block in enumerate(pair):
                    some = bodies.of_block[block]
                    away = np.linalg.norm(bodies.vertex[some] - point, axis=1)
                    if away.min() <= near:
                        at[k, side] = some.start + int(np.argmin(away))
                if (at[k] < 0).all():
                    found = _crossing(bodies, pair, point, contacts.frame[i, 0], near)
                    if found is None:
                        names = [model.assembly.names[block] for block in pair]
                        raise InputError(
                            "is neither a vertex nor a crossing of edges",
                            where=f"a corner of the joint of '{names[0]}' and '{names[1]}'",
                            remedy="shape a model with plane joints that were found, not given",
                        )
                    edges[0, k], edges[1, k] = found
        made = cls(
            at, edges[0], edges[1], offset, contacts.corners, contacts.frame,
            np.ones(contacts.count),
        )  # fmt: skip
        normal, _ = made._normals(contacts.point)
        made.turn[dot(normal, contacts.frame[:, 0]) < 0.0] = -1.0
        offset += contacts.point - made.points(bodies.vertex)
        return made

    def points(self, vertex: Floats) -> Floats:
        """The corners (k, 3) [m] for vertices (v, 3)."""
        out = self.offset.copy()
        weight = self._weights
        for side in (0, 1):
            out += weight[:, side, None] * vertex[self.at[:, side]]
        for k in self._crossings:
            p, e, q, f, t, _ = self._edges(vertex, int(k))
            out[k] += 0.5 * (p + t[0] * e + q + t[1] * f)
        return out

    def frames(self, point: Floats) -> Floats:
        """The frames (m, 3, 3) for corners (k, 3); lines and points keep theirs."""
        normal, size = self._normals(point)
        plane = size > 0.0
        n = np.where(plane[:, None], normal / np.where(plane, size, 1.0)[:, None], self.frame[:, 0])
        u = self.frame[:, 1] - dot(self.frame[:, 1], n)[:, None] * n
        u = u / np.linalg.norm(u, axis=1, keepdims=True)
        return np.stack([n, u, cross(n, u)], axis=1)

    def frames_pulled_back(self, point: Floats, by_frame: Floats) -> Floats:
        """Derivative (k, 3) by the corners, from that by the axes (m, 3, 3) of the frames."""
        size = self._normals(point)[1]
        plane = size > 0.0
        frame = self.frames(point)
        n = frame[:, 0]
        # axes u and v follow the normal; a turn about it changes nothing that is asked here
        by_normal = by_frame[:, 0].copy()
        for axis in (1, 2):
            along = dot(by_frame[:, axis], n)
            by_normal -= along[:, None] * frame[:, axis]
        by_normal -= dot(by_normal, n)[:, None] * n
        by_area = np.where(plane[:, None], by_normal / np.where(plane, size, 1.0)[:, None], 0.0)
        by_area *= self.turn[:, None]
        following = self.joint.following
        across = point[following] - point[np.argsort(following)]
        return 0.5 * cross(across, self.joint.spread(by_area))

    def points_pulled_back(self, vertex: Floats, by_point: Floats) -> Floats:
        """Derivative (v, 3) by the vertices, from that by the corners (k, 3)."""
        out = np.zeros_like(vertex)
        weight = self._weights
        for side in (0, 1):
            np.add.at(out, self.at[:, side], weight[:, side, None] * by_point)
        for k in self._crossings:
            _, e, _, f, t, (gap_a, gap_b) = self._edges(vertex, int(k))
            # least distance: e.(r) = 0 and f.(r) = 0 for r = (p + t0 e) - (q + t1 f)
            r = gap_a - gap_b
            system = np.array([[e @ e, -(e @ f)], [e @ f, -(f @ f)]])
            g = 0.5 * by_point[k]
            y = np.linalg.solve(system.T, np.array([g @ e, g @ f]))
            both = y[0] * e + y[1] * f
            on_a, on_b = g - both, g + both
            turn_a, turn_b = t[0] * on_a - y[0] * r, t[1] * on_b - y[1] * r
            (a0, a1), (b0, b1) = self.edge_a[k], self.edge_b[k]
            out[a0] += on_a - turn_a
            out[a1] += turn_a
            out[b0] += on_b - turn_b
            out[b1] += turn_b
        return out

    @property
    def _weights(self) -> Floats:
        """(k, 2) shares of the vertices of block a and of block b in a corner."""
        there = (self.at >= 0).astype(np.float64)
        total = there.sum(axis=1, keepdims=True)
        return there / np.where(total > 0.0, total, 1.0)

    @property
    def _crossings(self) -> Ints:
        return np.flatnonzero((self.at < 0).all(axis=1))

    def _edges(
        self, vertex: Floats, k: int
    ) -> tuple[Floats, Floats, Floats, Floats, Floats, tuple[Floats, Floats]]:
        """Starts and vectors of two edges that cross, places and points of least distance."""
        p, q = vertex[self.edge_a[k, 0]], vertex[self.edge_b[k, 0]]
        e, f = vertex[self.edge_a[k, 1]] - p, vertex[self.edge_b[k, 1]] - q
        system = np.array([[e @ e, -(e @ f)], [e @ f, -(f @ f)]])
        t = np.linalg.solve(system, np.array([e @ (q - p), f @ (q - p)]))
        return p, e, q, f, t, (p + t[0] * e, q + t[1] * f)

    def _normals(self, point: Floats) -> tuple[Floats, Floats]:
        """Area vectors (m, 3) of the interfaces, along the normals as found, and sizes (m,)."""
        normal = self.joint.sum(0.5 * cross(point, point[self.joint.following]))
        normal[self.joint.counts < 3] = 0.0
        return normal * self.turn[:, None], np.linalg.norm(normal, axis=1)


def _crossing(
    bodies: BlockVertices, pair: tuple[int, int], point: Floats, normal: Floats, near: float
) -> tuple[Ints, Ints] | None:
    """The two edges that cross at a point."""
    found = [list(_edges_at(bodies, block, point, normal, near)) for block in pair]
    for one, along in found[0]:
        for other, across in found[1]:
            if float(np.linalg.norm(np.cross(along, across))) > PARALLEL:
                return one, other
    return None


def _edges_at(
    bodies: BlockVertices, block: int, point: Floats, normal: Floats, near: float
) -> Iterator[tuple[Ints, Floats]]:
    """Edges of a block through a point and in the plane of a joint, and their directions."""
    start = bodies.of_block[block].start
    for i, j in edges_of(bodies.assembly.blocks[block].faces):
        p, q = bodies.vertex[start + i], bodies.vertex[start + j]
        length = float(np.linalg.norm(q - p))
        along = (q - p) / length
        t = float((point - p) @ along)
        off = float(np.linalg.norm(point - p - t * along))
        if off <= near and -near <= t <= length + near and abs(float(along @ normal)) < PARALLEL:
            yield np.array([start + i, start + j]), along
