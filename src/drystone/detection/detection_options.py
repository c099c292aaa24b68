"""The tolerances of the contact search."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.base.units import UNITS, measured

LARGEST = {"gap": 0.5, "angle": 45.0, "warp": 0.5, "sliver": 0.5, "curve": 45.0, "search": 0.5}
"""The largest value of each tolerance. Chosen: with larger values, contacts reach through
blocks."""


class EdgeContacts(StrEnum):
    """Which blocks are searched for contacts along an edge or at a corner.

    Attributes
    ----------
    ISOLATED
        Blocks without a face contact, such as a block that stands on an edge or a corner.
    ALWAYS
        Every pair of blocks without a face contact.
    NEVER
        Face contacts only.
    """

    ISOLATED = "isolated"
    ALWAYS = "always"
    NEVER = "never"


@dataclass(frozen=True, kw_only=True)
class DetectionOptions(Options):
    """Tolerances, dimensionless; lengths are relative to the local block size.

    The size of a block is 6 V / A with its volume V and its surface A: for a cube, the edge. Of two
    blocks the smaller size counts. So thin slabs and small stones have small tolerances.

    Parameters
    ----------
    gap
        Faces touch up to this distance or this overlap. For faces that are warped or approximate a
        curve, their deviation from the plane is added. The default lies on a plateau: in the models
        on which it was chosen, the number of interfaces is the same from 1e-5 to 0.02 (see
        :func:`drystone.detection.gap_sweep`).
    angle : [deg]
        Largest angle between two faces that touch. The angles due to warp and curvature are added.
    warp
        Faces that deviate from a plane by more than this share of the block size have no contacts.
    sliver
        Overlaps narrower than this (twice the area over the perimeter) are dropped.
    curve : [deg]
        Facets of curved joints are one plane interface where their normals are within this angle
        of their mean; with zero every facet is an interface. Curved joints with up to 1,000 corners
        in all keep their facets. Slivers always go into their neighbours: they occur where the two
        sides of a joint are meshed differently.
    search
        Pairs up to this distance are reported as near misses, with the gap that would join them.
    edges
        When to search for contacts along edges and at corners.
    gap_length : [m]
        Replaces ``gap``; up to half the size of the smaller block.
    inexact
        Whether to join what small errors of the drawing keep apart: overlaps up to 8 % of the
        thinnest dimension of the smaller block, gaps up to three times the deepest overlap of one
        of their blocks, or of all where hardly any joint is exact.

    Raises
    ------
    InputError
        A tolerance is negative, not finite or too large.
    """

    gap: float = 0.005
    angle: float = 2.0
    warp: float = 0.1
    sliver: float = 1e-4
    curve: float = 3.0
    search: float = 0.05
    edges: EdgeContacts = EdgeContacts.ISOLATED
    inexact: bool = True
    gap_length: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, largest in LARGEST.items():
            value = getattr(self, name)
            if not 0.0 <= value <= largest:
                raise InputError(f"{name} is {value}", remedy=f"give 0 to {largest:g}")
        if self.gap_length is not None and not 0.0 <= self.gap_length < float("inf"):
            raise InputError(f"gap is {self.gap_length} m", remedy="give a length above zero")

    def with_gap(self, gap: float | str) -> DetectionOptions:
        """The same with another gap: a share such as 0.005 or ``0.5%``, or a length as ``2mm``.

        Raises
        ------
        InputError
            It is neither.

        Examples
        --------
        >>> DetectionOptions().with_gap("2mm").gap_length
        0.002
        """
        text = str(gap).strip()
        value = measured(text.removesuffix("%"), UNITS, 1.0, "gap")
        if text.endswith("%"):
            return replace(self, gap=value / 100.0)
        return replace(self, gap_length=value) if text[-1].isalpha() else replace(self, gap=value)

    def reach(self, size: Floats) -> Floats:
        """Largest gap [m] of blocks of a size [m], of any shape."""
        if self.gap_length is None:
            return self.gap * size
        reach: Floats = np.minimum(self.gap_length, LARGEST["gap"] * size)
        return reach
