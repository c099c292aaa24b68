"""Parallel edges of two blocks that meet: a contact whose normal may have a range of directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, Ints, cross, dot, lengths
from drystone.contacts import Contacts
from drystone.detection.candidates import Pairs
from drystone.detection.edgecontacts import PARALLEL, SHORT, Wires, near_items
from drystone.detection.patches import Patches
from drystone.detection.tolerances import DetectionOptions
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.halfedge import BENT
from drystone.geometry.polyhedron import loop_edges


@dataclass(frozen=True)
class ParallelEdges:
    """Lines along which two convex edges meet.

    A plane through the line that has the one block on this side and the other on that may be turned
    about the line: its normal is anywhere within ``half`` of the middle one.

    Attributes
    ----------
    block_a, block_b : (m,)
    point : (m, 2, 3) [m]
    axis : (m, 3)
        Along the line.
    normal : (m, 3)
        The middle one, from block a to block b.
    half : (m,) [rad]
    """

    block_a: Ints
    block_b: Ints
    point: Floats
    axis: Floats
    normal: Floats
    half: Floats

    def __len__(self) -> int:
        return len(self.half)

    def take(self, some: Bools) -> ParallelEdges:
        """Some of the lines."""
        return ParallelEdges(
            self.block_a[some], self.block_b[some], self.point[some],
            self.axis[some], self.normal[some], self.half[some],
        )  # fmt: skip

    def approached(self, motion: Floats) -> tuple[Floats, Floats]:
        """How blocks b move at the ends of the lines, seen from blocks a, by (m, 2, 3).

        Returns
        -------
        opening : (m,)
            The least of both ends along the normal that is best for it.
        turned : (m,)
            The end of the range that is nearer to the motion: -1 or 1.
        """
        across = cross(self.axis, self.normal)
        along = np.einsum("mci,mi->mc", motion, self.normal)
        beside = np.einsum("mci,mi->mc", motion, across)
        angle, half = np.arctan2(beside, along), self.half[:, None]
        nearest = np.clip(angle, -half, half)
        opening = np.hypot(along, beside) * np.cos(angle - nearest)
        return opening.min(axis=1), np.where(beside.sum(axis=1) < 0.0, -1.0, 1.0)

    def contacts(self, turned: Floats, friction: Floats) -> Contacts:
        """The lines as interfaces.

        Parameters
        ----------
        turned : (m,)
            Of the normal, by ``half``: from -1 to 1.
        friction : (m,)
        """
        angle = (turned * self.half)[:, None]
        normal = np.cos(angle) * self.normal + np.sin(angle) * cross(self.axis, self.normal)
        count = len(self)
        return Contacts(
            self.block_a,
            self.block_b,
            frames_from_normals(normal),
            np.zeros(count),
            friction,
            self.point.reshape(-1, 3),
            np.repeat(np.arange(count, dtype=np.intp), 2),
        )


def parallel_edges(
    assembly: Assembly, patches: Patches, pairs: Pairs, options: DetectionOptions
) -> ParallelEdges:
    """The lines along which edges of some pairs of blocks (a < b) meet."""
    wires = Wires.of(assembly, patches.origin, np.unique(np.concatenate(pairs)))
    size = np.minimum(patches.size[pairs[0]], patches.size[pairs[1]])
    reach = options.reach(size)
    sides = [(wires.of_block, one, wires.low, wires.high) for one in pairs]
    rows = [np.stack(found) for found in near_items(sides[0], sides[1], reach)]
    row, first, second = np.concatenate([np.zeros((3, 0), dtype=np.intp), *rows], axis=1)
    one, other = wires.point[wires.edge[first]], wires.point[wires.edge[second]]
    run, along = one[:, 1] - one[:, 0], other[:, 1] - other[:, 0]
    length = lengths(run)
    axis = run / length[:, None]
    off = other - one[:, :1]
    at = np.einsum("rci,ri->rc", off, axis)
    beside = off - at[:, :, None] * axis[:, None]
    ends = np.stack([np.maximum(at.min(axis=1), 0.0), np.minimum(at.max(axis=1), length)], axis=1)
    keep = lengths(cross(run, along)) <= PARALLEL * length * lengths(along)
    keep &= ends[:, 1] - ends[:, 0] > SHORT * size[row]
    keep &= np.linalg.norm(beside, axis=2).max(axis=1) <= reach[row]
    point = (one[:, 0] + 0.5 * beside.mean(axis=1))[:, None] + ends[:, :, None] * axis[:, None]
    row, first, second, axis = row[keep], first[keep], second[keep], axis[keep]
    fold = _folds(assembly, wires, np.unique(np.concatenate(pairs)))
    normal, half, apart = _between(fold[first], -fold[second], axis)
    a, b = (block[row] for block in pairs)
    return ParallelEdges(a, b, point[keep] + patches.origin, axis, normal, half).take(apart)


def _folds(assembly: Assembly, wires: Wires, blocks: Ints) -> Floats:
    """The outward normals (e, 2, 3) of the two faces of every edge; zero where it is not convex."""
    fold = np.zeros((len(wires.edge), 2, 3))
    faces = assembly.faces
    first = np.searchsorted(faces.owner, blocks).tolist()
    for block, begin in zip(blocks.tolist(), first, strict=True):
        body = assembly.blocks[block]
        sides: dict[tuple[int, int], list[tuple[int, int, int]]] = {}
        for number, face in enumerate(body.faces, start=begin):
            for i, j in loop_edges(face):
                sides.setdefault((min(i, j), max(i, j)), []).append((number, i, j))
        for edge, key in enumerate(sorted(sides), start=int(wires.of_block.first[block])):
            if len(sides[key]) == 2:
                (one, i, j), (other, _, _) = sides[key]
                inward = np.cross(faces.normals[one], body.vertices[j] - body.vertices[i])
                if inward @ faces.normals[other] < -BENT * np.sqrt(inward @ inward):
                    fold[edge] = faces.normals[[one, other]]
    return fold


def _between(one: Floats, other: Floats, axis: Floats) -> tuple[Floats, Floats, Bools]:
    """The middle (r, 3) of the directions between both normals of ``one`` and both of ``other``.

    Half the angle (r,) of their range, and whether there are any (r,).
    """
    middle = [normals.sum(axis=1) for normals in (one, other)]
    size = [lengths(each) for each in middle]
    convex = (size[0] > 0.0) & (size[1] > 0.0)
    middle = [m / np.where(s > 0.0, s, 1.0)[:, None] for m, s in zip(middle, size, strict=True)]
    wide = [
        np.arctan2(0.5 * lengths(normals[:, 0] - normals[:, 1]), 0.5 * s)
        for normals, s in zip((one, other), size, strict=True)
    ]
    turned = np.arctan2(dot(cross(middle[0], middle[1]), axis), dot(middle[0], middle[1]))
    low = np.maximum(-wide[0], turned - wide[1])
    high = np.minimum(wide[0], turned + wide[1])
    angle = (0.5 * (low + high))[:, None]
    normal = np.cos(angle) * middle[0] + np.sin(angle) * cross(axis, middle[0])
    return normal, 0.5 * (high - low), convex & (high >= low - SAME)
