"""Joints that small errors of a drawing kept apart, and by how much it is off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.detection.reasons import millimetres


class Error(StrEnum):
    """Kinds of errors of a drawing that do not keep blocks apart."""

    OVERLAP = "in each other"
    GAP = "apart"
    WARP = "warped"
    MORTAR = "apart by the thickness of the mortar"


@dataclass(frozen=True)
class Inexact(OneLine):
    """Two blocks that are joined although they are drawn beyond a tolerance.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    error
    off : [m]
        How deep they are in each other, how far apart, or how far their faces are from a plane.
    """

    block_a: int
    block_b: int
    error: Error
    off: float


_WORDS = {
    Error.OVERLAP: (
        "is drawn {off} mm deep into each other and joined on the plane halfway",
        "are drawn up to {off} mm deep into each other and joined on the planes halfway",
    ),
    Error.GAP: (
        "is drawn {off} mm apart and joined on the plane halfway",
        "are drawn up to {off} mm apart and joined on the planes halfway",
    ),
    Error.WARP: (
        "has a joint {off} mm from plane, taken as a fan of triangles",
        "have joints up to {off} mm from plane, taken as fans of triangles",
    ),
    Error.MORTAR: (
        "is {off} mm apart, taken for mortar and joined on the plane halfway",
        "are up to {off} mm apart, all alike: taken for mortar and joined on the planes halfway",
    ),
}
HOLDS = "the answer holds for these joints, not for the blocks as they are drawn"


def inexact_lines(names: Sequence[str], inexact: Sequence[Inexact]) -> list[str]:
    """A sentence for each kind of error, with the largest one, and what the answer holds for."""
    lines = []
    for error, (one, several) in _WORDS.items():
        here = [pair for pair in inexact if pair.error is error]
        if here:
            worst = max(here, key=lambda pair: pair.off)
            words = counted(len(here), f"pair of blocks {one}", f"pairs of blocks {several}")
            said = words.format(off=millimetres(worst.off))
            which = "largest: " if len(here) > 1 else ""
            pair = f" ({which}'{names[worst.block_a]}' and '{names[worst.block_b]}')"
            lines.append(said if error is Error.MORTAR else said + pair)
    return [*lines, HOLDS] if lines else []
