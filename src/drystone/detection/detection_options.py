"""What counts as touching: every tolerance of the contact search, in one place."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from drystone.base.errors import InputError
from drystone.base.settings import Options

LARGEST = {"gap": 0.5, "angle": 45.0, "warp": 0.5, "sliver": 0.5, "merge": 1.0, "search": 0.5}
"""The largest value of each tolerance, chosen: beyond, blocks join across each other."""


class EdgeContacts(StrEnum):
    """For which blocks contacts along an edge or in a corner are looked for.

    Attributes
    ----------
    ISOLATED
        For blocks that touch nothing with a face: a block that stands on an edge or a corner.
    ALWAYS
        For every pair of blocks that shares no face contact.
    NEVER
        Face contacts only.
    """

    ISOLATED = "isolated"
    ALWAYS = "always"
    NEVER = "never"


@dataclass(frozen=True, kw_only=True)
class DetectionOptions(Options):
    """Tolerances, dimensionless; lengths are relative to the local block size.

    The size of a block is six times its volume over its surface, the edge of a cube; of two blocks
    the smaller counts. So thin slabs and small stones have small tolerances.

    Parameters
    ----------
    gap
        Faces this far apart, or this deep in each other, still touch. Where faces are warped or
        approximate a curve, their own deviation from the plane is granted on top of it. The default
        lies on the plateau of the models that it was chosen on: their numbers of interfaces are the
        same from 1e-5 to 0.02 (see :func:`drystone.detection.gap_sweep`).
    angle : [deg]
        Largest angle between two faces that touch. Warp and curvature are granted on top of it.
    warp
        Faces farther from planar than this share of the block size join nothing.
    sliver
        Overlaps narrower than this (twice the area over the perimeter) are dropped.
    merge
        Interfaces narrower than this share of a neighbour of the same two blocks are merged into
        it, where a curved joint is meshed differently on its two sides.
    search
        Pairs up to this far apart are reported as near misses, with the gap that would join them.
    edges
        When to look for contacts along edges and in corners.

    Raises
    ------
    InputError
        A tolerance is negative, not finite or so large that blocks join across each other.
    """

    gap: float = 0.005
    angle: float = 2.0
    warp: float = 0.1
    sliver: float = 1e-4
    merge: float = 0.2
    search: float = 0.05
    edges: EdgeContacts = EdgeContacts.ISOLATED

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, largest in LARGEST.items():
            value = getattr(self, name)
            if not 0.0 <= value <= largest:
                raise InputError(f"{name} is {value}", remedy=f"give 0 to {largest:g}")


__all__ = ["LARGEST", "DetectionOptions", "EdgeContacts"]
