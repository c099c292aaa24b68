"""Which block an edge of an interface belongs to, and how far the face of the other goes on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, Ints, cross, dot, lengths, plane_cross, unit
from drystone.base.ragged import BATCH, Ragged, expand

COPLANAR = 0.01
"""Largest distance between an interface and a face that it lies on, by the block's size, and
largest sine of the angle between them: contacts are found on faces that are not quite flat."""

ASKEW = 0.1
"""Sine of the angle between an edge of an imperfect interface and that edge of a block that it
stands for."""


class FaceSides:
    """The sides of the faces of all blocks.

    Attributes
    ----------
    begin, end : (e, 3) [m]
    face : (e,) the face of each
    normal : (f, 3) outward, of each face
    of_block
        The sides of each block.
    """

    def __init__(self, assembly: Assembly) -> None:
        faces = assembly.faces
        self.begin = faces.point[faces.loop]
        self.end = self.begin[faces.corners.following]
        self.axis, self.length = unit(self.end - self.begin)
        self.face, self.normal = faces.corners.owner, faces.normals
        self.of_block = Ragged.from_owners(faces.owner[self.face], len(assembly))
        self.size = np.cbrt(assembly.volume)
        self.largest = assembly.size

    def in_planes(self, block: Ints, frame: Floats, origin: Floats) -> tuple[Ragged, Floats]:
        """The outer sides of the faces of blocks (r,) in a plane each.

        Parameters
        ----------
        block, frame, origin
            Axes (r, 3, 3) of the planes, rows n, u, v, and a point (r, 3) [m] of each.

        Returns
        -------
        of_row
            Which sides belong to which plane.
        ends : (s, 2, 2) [m]
            Local u and v of both ends of each side.
        """
        rows, ends = [np.zeros(0, dtype=np.intp)], [np.zeros((0, 2, 2))]
        for row, side in _pairs(self.of_block, block):
            n, size = frame[row, 0], self.size[block[row]]
            arms = [self.begin[side] - origin[row], self.end[side] - origin[row]]
            near = np.maximum(*(np.abs(dot(arm, n)) for arm in arms)) < COPLANAR * size
            flat = np.flatnonzero(near)
            lean = lengths(cross(self.normal[self.face[side[flat]]], n[flat]))
            flat = flat[lean < COPLANAR]
            rows.append(row[flat])
            axes = frame[row[flat], 1:]
            ends.append(np.stack([(axes @ arm[flat, :, None])[..., 0] for arm in arms], axis=1))
        row, found = np.concatenate(rows), np.concatenate(ends)
        # sides between two faces in the plane are no ends
        outer = np.ones(len(row), dtype=bool)
        for one, other in _pairs(Ragged.from_owners(row, len(block)), row):
            back = np.abs(found[one, ::-1] - found[other]).max(axis=(1, 2), initial=0.0)
            outer[one[back < SAME * self.size[block[row[one]]]]] = False
        return Ragged.from_owners(row[outer], len(block)), found[outer]

    def owned(
        self, block: Ints, middle: Floats, along: Floats, outward: Floats
    ) -> tuple[Bools, Floats]:
        """Which edges (k,) of interfaces are edges of a block (k,) each, and their bend (k,).

        The bend is the sine of the angle by which the block's surface turns away from the interface
        at the edge: positive at a convex edge, negative at a re-entrant one.

        Parameters
        ----------
        block
        middle, along : (k, 3) [m]
            The middle of each edge, and its end less its beginning.
        outward : (k, 3)
            Normal of the edge in the plane of its interface.
        """
        owned, bend = np.zeros(len(block), dtype=bool), np.zeros(len(block))
        direction, margin = unit(along)[0], SAME * self.largest[block]
        for edge, side in _pairs(self.of_block, block):
            axis, most = self.axis[side], margin[edge]
            arm = middle[edge] - self.begin[side]
            at = dot(arm, axis)
            near = (at > -most) & (at < self.length[side] + most)
            near &= lengths(arm - at[:, None] * axis) < most
            edge, side, axis = edge[near], side[near], axis[near]
            # an edge without length, as of a point, runs along every side
            parallel = lengths(cross(direction[edge], axis)) < 1e-3
            edge, side = edge[parallel], side[parallel]
            owned[edge] = True
            turned = dot(outward[edge], self.normal[self.face[side]])
            order = np.argsort(-np.abs(turned), kind="stable")[::-1]
            bend[edge[order]] = turned[order]  # the last one counts, which turns most
        return owned, bend

    def nearest(self, block: Ints, middle: Floats, along: Floats) -> Floats:
        """Distance (k,) [m] of edges, as for :meth:`owned`, from the nearest edge of a block.

        Edges of the block that run in another direction do not count.
        """
        found, direction = np.full(len(block), np.inf), unit(along)[0]
        for edge, side in _pairs(self.of_block, block):
            axis = self.axis[side]
            alike = lengths(cross(direction[edge], axis)) < ASKEW
            edge, side, axis = edge[alike], side[alike], axis[alike]
            arm = middle[edge] - self.begin[side]
            at = np.clip(dot(arm, axis), 0.0, self.length[side])
            np.minimum.at(found, edge, lengths(arm - at[:, None] * axis))
        return found


def _pairs(of_row: Ragged, row: Ints) -> Iterator[tuple[Ints, Ints]]:
    """Things, each with all items of its row (t,), some things at a time."""
    first, count = of_row.first[row], of_row.counts[row]
    for some in Ragged.from_counts(count).batches(BATCH // 10):
        one, item = expand(first[some], count[some])
        yield some[one], item


def to_the_end(at: Floats, outward: Floats, row: Ints, of_row: Ragged, segments: Floats) -> Floats:
    """(c,) distance from points (c, 2) along directions (c, 2) to a segment of their row (c,).

    Parameters
    ----------
    at, outward, row
    of_row
        The segments of each row.
    segments : (s, 2, 2)
    """
    run, found = segments[:, 1] - segments[:, 0], np.full(len(at), np.inf)
    length = lengths(run)
    for one, item in _pairs(of_row, row):
        arm, out, side = segments[item, 0] - at[one], outward[one], run[item]
        turn = plane_cross(out, side)
        safe = np.where(np.abs(turn) > 0.0, turn, 1.0)
        far, part = plane_cross(arm, side) / safe, plane_cross(arm, out) / safe
        met = (np.abs(turn) > 1e-6 * length[item]) & (far > 0.0) & (part >= 0.0) & (part <= 1.0)
        np.minimum.at(found, one[met], far[met])
    return found
