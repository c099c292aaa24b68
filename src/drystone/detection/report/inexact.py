"""Joints that small errors of a drawing kept apart, and by how much it is off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.detection.report.reasons import Reason, millimetres


@dataclass(frozen=True)
class Inexact(OneLine):
    """Two blocks that are joined although they are drawn beyond a tolerance.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    reason
        ``OVERLAP``, ``GAP`` or ``WARP``.
    off : [m]
        How deep they are in each other, how far apart, or how far their faces are from a plane.
    """

    block_a: int
    block_b: int
    reason: Reason
    off: float


_WORDS = {
    Reason.OVERLAP: (
        "is drawn {off} mm deep into each other and joined on the plane halfway",
        "are drawn up to {off} mm deep into each other and joined on the planes halfway",
    ),
    Reason.GAP: (
        "is drawn {off} mm apart and joined on the plane halfway",
        "are drawn up to {off} mm apart and joined on the planes halfway",
    ),
    Reason.WARP: (
        "has a joint {off} mm from plane, taken as a fan of triangles",
        "have joints up to {off} mm from plane, taken as fans of triangles",
    ),
}
HOLDS = "the answer holds for these joints, not for the blocks as they are drawn"


def inexact_lines(names: Sequence[str], inexact: Sequence[Inexact]) -> list[str]:
    """A sentence for each kind of error, with the largest one, and what the answer holds for."""
    lines = []
    for reason, (one, several) in _WORDS.items():
        here = [pair for pair in inexact if pair.reason is reason]
        if here:
            worst = max(here, key=lambda pair: pair.off)
            words = counted(len(here), f"pair of blocks {one}", f"pairs of blocks {several}")
            said = words.format(off=millimetres(worst.off))
            which = "" if len(here) == 1 else "largest: "
            pair = f"{which}'{names[worst.block_a]}' and '{names[worst.block_b]}'"
            lines.append(f"{said} ({pair})")
    return [*lines, HOLDS] if lines else []
