"""Near misses, with the reason why the faces were not joined; lengths and names as text."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine, named

SHOWN = 8
"""Names listed in one line."""


class Reason(StrEnum):
    """Why two faces that nearly touch were not joined."""

    GAP = "too far apart"
    OVERLAP = "too deep in each other"
    ANGLE = "not parallel enough"
    WARP = "too warped"
    SLIVER = "overlap too narrow"
    HIDDEN = "another block lies between"
    PARTLY = "within tolerance on a part only"


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
