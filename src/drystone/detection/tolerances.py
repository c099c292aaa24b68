"""The tolerances of the contact search, and near misses with the reason why they were not joined.

Lengths and names are told as text.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine, named
from drystone.base.errors import located
from drystone.base.settings import Options
from drystone.base.units import UNITS, measured

LARGEST = {"gap": 0.5, "angle": 45.0, "warp": 0.5, "sliver": 0.5, "curve": 45.0, "search": 0.5}
"""The largest value of each tolerance. Chosen: with larger values, contacts reach through
blocks."""


class EdgeContacts(StrEnum):
    """Which blocks are searched for contacts along an edge or at a corner."""

    ISOLATED = "isolated"
    """Blocks without a face contact, such as a block that stands on an edge or a corner."""
    ALWAYS = "always"
    """Every pair of blocks without a face contact."""
    NEVER = "never"
    """Face contacts only."""


@dataclass(frozen=True, kw_only=True)
class DetectionOptions(Options):
    """Tolerances, dimensionless; lengths are relative to the local block size.

    The size of a block is 6 V / A with its volume V and its surface A: for a cube, the edge. Of two
    blocks the smaller size counts. So thin slabs and small stones have small tolerances.

    Parameters
    ----------
    gap : >= 0, <= 0.5
        Faces touch up to this distance or this overlap. For faces that are warped or approximate a
        curve, their deviation from the plane is added. The default lies on a plateau: in the models
        on which it was chosen, the number of interfaces is the same from 1e-5 to 0.02.
    angle : [deg] >= 0, <= 45
        Largest angle between two faces that touch. The angles due to warp and curvature are added.
    warp : >= 0, <= 0.5
        Faces that deviate from a plane by more than this share of the block size have no contacts.
    sliver : >= 0, <= 0.5
        Overlaps narrower than this (twice the area over the perimeter) are dropped.
    curve : [deg] >= 0, <= 45
        Facets of curved joints are one plane interface where their normals are within this angle
        of their mean; with zero every facet is an interface. Curved joints with up to 1,000 corners
        in all keep their facets. Slivers always go into their neighbours: they occur where the two
        sides of a joint are meshed differently.
    search : >= 0, <= 0.5
        Pairs up to this distance are reported as near misses, with the gap that would join them.
    edges
        When to search for contacts along edges and at corners.
    gap_length : [m] >= 0, < inf
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
        if text[-1].isalpha():
            return replace(self, gap_length=value)
        with located("", f"give a share up to {LARGEST['gap']:g}, or a length such as 5mm"):
            return replace(self, gap=value / 100.0 if text.endswith("%") else value)

    def reach(self, size: Floats) -> Floats:
        """Largest gap [m] of blocks of a size [m], of any shape."""
        if self.gap_length is None:
            return self.gap * size
        return np.minimum(self.gap_length, LARGEST["gap"] * size)


SHOWN = 8
"""Names listed in one line."""


class Reason(StrEnum):
    """Why two faces that nearly touch were not joined."""

    GAP = "too far apart"
    """The gap between them is above the tolerance."""
    OVERLAP = "too deep in each other"
    """They are in each other by more than the tolerance."""
    ANGLE = "not parallel enough"
    """The angle between them is above the tolerance."""
    WARP = "too warped"
    """A face is farther from its plane than the tolerance."""
    SLIVER = "overlap too narrow"
    """What they share is narrower than the option ``sliver``."""
    HIDDEN = "another block lies between"
    """Another block is in the gap between them."""
    PARTLY = "within tolerance on a part only"
    """They were joined on the part that is within the tolerance; the rest is told."""


@dataclass(frozen=True)
class Missed(OneLine):
    """Two faces that nearly touch and were not joined.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    face_a, face_b
        Numbers of the faces in their blocks; the first where coplanar faces were merged, -1 for an
        edge or a corner.
    reason
    gap : [m]
        Smallest distance over the shared area, negative where they overlap.
    angle : [deg]
    area : [m2]
        Shared area in projection; zero for an edge or a corner.
    needed
        The option ``gap`` (for ``Reason.GAP``, ``OVERLAP`` and ``PARTLY``) or ``angle`` [deg] (for
        ``ANGLE``) that would join them; NaN for other reasons.
    polygon : (c, 3) [m]
        The shared area, halfway between the faces. For an edge: a band across the gap. For a
        corner: two points across the gap.
    joined
        Whether the two blocks touch elsewhere.
    """

    block_a: int
    block_b: int
    face_a: int
    face_b: int
    reason: Reason
    gap: float
    angle: float
    area: float
    needed: float
    polygon: Floats
    joined: bool

    @classmethod
    def overlap(cls, block_a: int, block_b: int, depth: float, *, joined: bool) -> Missed:
        """Two blocks that are in each other by a depth [m], by faces that nobody can tell."""
        return cls(
            block_a=block_a,
            block_b=block_b,
            face_a=-1,
            face_b=-1,
            reason=Reason.OVERLAP,
            gap=-depth,
            angle=0.0,
            area=0.0,
            needed=float("nan"),
            polygon=np.zeros((0, 3)),
            joined=joined,
        )

    @property
    def narrow(self) -> bool:
        """Whether the faces overlap at most twice as wide as deep: others may be meant to press."""
        around = np.linalg.norm(self.polygon - np.roll(self.polygon, -1, axis=0), axis=1).sum()
        return self.gap < 0.0 and self.area <= -self.gap * float(around)

    def farther(self, search: float) -> bool:
        """Whether it is a gap wider than the option ``search``, which is not reported."""
        return self.reason is Reason.GAP and self.needed > search


def millimetres(length: float) -> str:
    """A length [m] in millimetres, to three digits or a nanometre, and never as a power of ten.

    Examples
    --------
    >>> millimetres(0.0), millimetres(0.0012345), millimetres(-12.345)
    ('0', '1.23', '-12,345')
    """
    value = round(1e3 * float(length), 6) + 0.0
    return f"{value:,.0f}" if abs(value) >= 1e3 else f"{value:.3g}"


def repair_lines(repairs: Iterable[tuple[str, str]]) -> list[str]:
    """One line per kind of repair, with the names of the first repaired blocks."""
    names: dict[str, list[str]] = {}
    for name, repair in repairs:
        names.setdefault(repair, []).append(f"'{name}'")
    return [
        f"{'block' if len(some) == 1 else 'blocks'} {named(some)}: {repair}"
        for repair, some in names.items()
    ]
