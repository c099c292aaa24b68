"""Cells that share vertices, in space: the outlines of the blocks on the surface."""

from __future__ import annotations

from dataclasses import dataclass

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.display import OneLine


@dataclass(frozen=True, eq=False)
class Tessellation(OneLine):
    """Cells that share vertices, in space.

    Attributes
    ----------
    point : (p, 3) [m]
    normal : (p, 3) unit, outwards; at a seam the mean of both sides
    up : (p, 3) unit tangent across the courses
    inner : (p,) whether the vertex is on a bed line between two courses of one patch
    cells
        Loops of vertices, counter-clockwise seen from outside.
    names
    course, position : (c,)
    of_patch : (c,)
        -1 for a keystone, which closes several patches.
    crest : (c, 3) [m] point of the surface over the middle of each cell; NaN for a keystone
    heads
        Pairs of vertices, lower number first, at the ends of the head joints.
    supported
        Edges on which the shell is supported, directed as in their cell.
    """

    point: Floats
    normal: Floats
    up: Floats
    inner: Bools
    cells: tuple[tuple[int, ...], ...]
    names: tuple[str, ...]
    course: Ints
    position: Ints
    of_patch: Ints
    crest: Floats
    heads: frozenset[tuple[int, int]]
    supported: tuple[tuple[int, int], ...]

    def name_at(self, vertex: int) -> str:
        """Name of the first cell that has a vertex."""
        return next(n for n, c in zip(self.names, self.cells, strict=True) if vertex in c)
