"""Stages: which blocks are in place, which of them are held, and whether that stands.

A stage is two sets of free blocks, kept as the bits of integers; the supports are always there. A
held block is one that a prop, a hand or a robot keeps where it is: it counts as fixed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.results import Verdict
from drystone.stability import Screening


class Stage(NamedTuple):
    """Blocks in place and, among them, those that are held; one bit per block.

    With a ``screening`` level the stage is screened instead of checked: that it stands is then
    proved, that it falls is not. The screening may start from the rest state of a similar stage
    ``near``, given by its blocks in place and held.
    """

    placed: int
    held: int = 0
    screening: Screening | None = None
    near: tuple[int, int] | None = None

    def __repr__(self) -> str:
        return f"Stage({self.placed.bit_count()} blocks in place, {self.held.bit_count()} held)"


def mask_of(blocks: Iterable[int]) -> int:
    """The set of some blocks as the bits of an integer.

    Examples
    --------
    >>> mask_of([0, 2])
    5
    """
    mask = 0
    for block in blocks:
        mask |= 1 << int(block)
    return mask


def members(mask: int) -> Iterator[int]:
    """The blocks of a set, ascending.

    Examples
    --------
    >>> list(members(5))
    [0, 2]
    """
    while mask:
        lowest = mask & -mask
        yield lowest.bit_length() - 1
        mask ^= lowest


@dataclass(frozen=True, eq=False)
class Answer(OneLine):
    """Whether a stage, or one part of it, stands.

    Attributes
    ----------
    verdict
    message
    falling
        Positions of the blocks that fall.
    reaction : block to (6,) [N, N m]
        What holds each held block: force, and moment about its centroid. In a part, what it takes
        against the contact forces alone; in a stage, its own load included. Joints between two
        held or fixed blocks carry nothing, so a held block may need less than this.
    used
        Largest share of the friction coefficient that a loaded corner uses: the very same forces
        still hold when all coefficients are multiplied by it.
    corner : (c,)
        Corners of the whole model that carry ``force`` (c, 3) [N]; empty when it was not kept.
    settled
        What following the blocks told, where contact stiffness decides; else empty.
    motion : (b, 6) [m, rad]
        Of the moving blocks of a part, ascending, for neighbours to start from; empty as well.
    """

    verdict: Verdict
    message: str = ""
    falling: tuple[int, ...] = ()
    reaction: Mapping[int, Floats] = field(default_factory=dict)
    used: float = 0.0
    corner: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    force: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    motion: Floats = field(default_factory=lambda: np.zeros((0, 6)))
    settled: str = ""

    @property
    def stands(self) -> bool:
        """Whether it was shown to stand."""
        return self.verdict is Verdict.STABLE


__all__ = ["Answer", "Stage", "mask_of", "members"]
