"""Vertices of all blocks in one array: volumes, centroids, and how they follow the vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from drystone.assembly import Assembly, replace_block
from drystone.base.arrays import Floats, Ints, cross, dot
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.geometry.selfcontact import self_contacts


def vertices_of(assembly: Assembly) -> Floats:
    """The vertices (v, 3) of all blocks, one after the other."""
    return np.concatenate([block.vertices for block in assembly.blocks])


def owners_of(assembly: Assembly) -> Ints:
    """The block (v,) of each vertex."""
    counts = [len(block.vertices) for block in assembly.blocks]
    return np.repeat(np.arange(len(counts)), counts)


@dataclass(frozen=True, eq=False)
class BlockVertices:
    """The blocks of an assembly as one array of vertices.

    Attributes
    ----------
    assembly
    vertex : (v, 3) [m] of all blocks, one after the other
    start : (n + 1,) where those of each block begin
    owner : (v,) the block of each vertex
    triangle : (t, 3) points of the triangles of all faces: fans about the means of their corners
    triangle_owner : (t,)
    mean : (v + f, v) the points of the triangles: the vertices, and the means of faces with more
        than three corners
    """

    assembly: Assembly
    vertex: Floats
    start: Ints
    owner: Ints
    triangle: Ints
    triangle_owner: Ints
    mean: sparse.csr_matrix

    @classmethod
    def of(cls, assembly: Assembly) -> BlockVertices:
        """The vertices and triangles of an assembly."""
        counts = [len(block.vertices) for block in assembly.blocks]
        start = Ragged.from_counts(counts).start
        total = int(start[-1])
        fan: list[tuple[int, int, int]] = []
        owner: list[int] = []
        corners: list[Ints] = []
        for i, block in enumerate(assembly.blocks):
            for loop in block.faces:
                ring = int(start[i]) + np.array(loop, dtype=np.intp)
                if len(ring) == 3:
                    fan.append((int(ring[0]), int(ring[1]), int(ring[2])))
                    owner.append(i)
                    continue
                middle = total + len(corners)
                corners.append(ring)
                ends = zip(ring.tolist(), np.roll(ring, -1).tolist(), strict=True)
                fan += [(middle, one, other) for one, other in ends]
                owner += [i] * len(ring)
        count = np.array([len(ring) for ring in corners], dtype=np.intp)
        row = np.repeat(np.arange(len(corners)), count)
        column = np.concatenate([*corners, np.zeros(0, dtype=np.intp)])
        means = sparse.csr_matrix((1.0 / count[row], (row, column)), (len(corners), total))
        return cls(
            assembly,
            vertices_of(assembly),
            start,
            owners_of(assembly),
            np.array(fan, dtype=np.intp),
            np.array(owner, dtype=np.intp),
            sparse.csr_matrix(sparse.vstack([sparse.identity(total), means])),
        )

    def assembly_at(self, vertex: Floats) -> Assembly:
        """The assembly with its vertices (v, 3) elsewhere; blocks that do not move stay.

        Raises
        ------
        InputError
            A block would be turned inside out, or its surface would cross itself.
        """
        blocks = list(self.assembly.blocks)
        moved = []
        for i, block in enumerate(blocks):
            own = vertex[self.start[i] : self.start[i + 1]]
            if not np.array_equal(own, block.vertices):
                blocks[i] = replace_block(block, vertices=own, repairs=())
                if blocks[i].faces != block.faces:
                    raise InputError(
                        "would be turned inside out",
                        where=f"block '{block.name}'",
                        remedy="allow smaller moves",
                    )
                moved.append(blocks[i])
        for body, what in self_contacts(
            [one.vertices for one in moved], [one.faces for one in moved]
        ):
            raise InputError(
                f"its surface {what}",
                where=f"block '{moved[body].name}'",
                remedy="allow smaller moves",
            )
        return Assembly(tuple(blocks), self.assembly.fixed)

    def measures(self, vertex: Floats) -> tuple[Floats, Floats]:
        """Volumes (n,) [m3] and centroids (n, 3) [m] for vertices (v, 3)."""
        six, total, middle = self._tetrahedra(vertex)[3:]
        count = len(self.start) - 1
        volume = np.bincount(self.triangle_owner, six, minlength=count) / 6.0
        moment = np.stack(
            [np.bincount(self.triangle_owner, row, minlength=count) for row in (six * total.T)],
            axis=1,
        )
        return volume, middle + moment / (24.0 * volume[:, None])

    def measures_pulled_back(
        self, vertex: Floats, by_volume: Floats, by_centroid: Floats
    ) -> Floats:
        """Derivative (v, 3) by the vertices, from those by volumes (n,) and centroids (n, 3)."""
        a, b, c, six, total, middle = self._tetrahedra(vertex)
        volume, centroid = self.measures(vertex)
        by_moment = by_centroid / volume[:, None]
        rest = by_volume - dot(by_moment, centroid - middle)
        moment = by_moment[self.triangle_owner]
        along = rest[self.triangle_owner] / 6.0 + dot(moment, total) / 24.0
        shared = moment * (six / 24.0)[:, None]
        out = np.zeros((self.mean.shape[0], 3))
        for k, (one, other) in enumerate(((b, c), (c, a), (a, b))):
            np.add.at(out, self.triangle[:, k], along[:, None] * cross(one, other) + shared)
        # the origin of each block moves with its vertices, and has no effect
        by_vertex: Floats = self.mean.T @ out
        return by_vertex

    def _tetrahedra(self, vertex: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
        """Corners of the triangles about the middle of their block, six volumes, sums, middles."""
        middle = np.add.reduceat(vertex, self.start[:-1], axis=0) / np.diff(self.start)[:, None]
        local = self.mean @ (vertex - middle[self.owner])
        a, b, c = (local[self.triangle[:, k]] for k in range(3))
        return a, b, c, dot(a, cross(b, c)), a + b + c, middle
