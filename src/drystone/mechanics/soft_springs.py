"""Whether the springs of a run are too soft: asked once, at a given displacement of the blocks."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats
from drystone.mechanics.bodies import Bodies

STIFFEST = 1e-9
"""Smallest overlap: below it gaps are lost in rounding."""
SOFT_AT, SOFT_AT_MANY = 0.05, 0.02
"""Displacement of a block relative to its size where it is decided whether springs are too soft; of
many blocks. It is the same however far they are followed, so that :func:`drystone.check` and
:func:`drystone.settle` give one answer."""
FADING = 0.44
"""Of many blocks: mean share of the load that the contacts do not carry over the last quarter of
the way there, by that over the second quarter, below which springs were too soft: it was about to
come to rest. Measured on the Armadillo vault: 0.37 at 21 degrees, 0.42 at 21.3 and 0.46 at 21.5,
where it rests on springs 100 times as stiff, 0.49 at 21.7, where it does not within 1,500
increments, 0.53 at 22 and 0.67 at 24, where it falls. Rounding changes these means by 0.01, and the
share of a single increment by 0.05."""
SQUEEZED, GROWN = 20.0, 1.5
"""Overlap of a corner by that under the mean load, and by its own at half of the travel, from which
on springs are too soft: a plug that tapers by 0.05 degrees presses with 570 times its weight in the
end, and the overlap grows with its travel. Forces on what slides or topples hardly change."""
DOUBLED = 1.8
"""Of many blocks: what presses on the block of such a corner, by the same at half of the travel. On
a plug it doubles. In a vault that moves thrust goes from one corner of a joint to another: 1.62
times at most on the Armadillo vault, tilted by 24 to 30 degrees. In a dome that falls: 3 times."""

SLIVER = 0.03
"""Force at a corner, by all that presses on a block of its, below which its overlap says nothing.
Measured: corners with hardly any area of boxes that slide off each other carry 0.003 at most, one
of a curved joint that rests on stiffer springs 0.24."""


class SoftSprings:
    """What a run remembers of its way, to tell springs that are too soft.

    Parameters
    ----------
    bodies
    many
        There are many blocks.
    most
        Displacement of a block relative to its size at which the run ends.
    """

    def __init__(self, bodies: Bodies, many: bool, most: float) -> None:
        self.bodies, self.many = bodies, many
        self.at = min(most, SOFT_AT_MANY if many else SOFT_AT)
        self.asked = bodies.overlap <= STIFFEST
        self.half_way: Floats | None = None
        self.reached = 0.0
        self.share = np.zeros(4)  # mean over each quarter of the way

    def pass_by(self, farthest: float, gap: Floats, share: float) -> None:
        """Remember the gaps (k,) at half of the way; of many blocks, what contacts do not carry."""
        if self.half_way is None and farthest >= 0.5 * self.at:
            self.half_way = gap
        if self.many and not self.asked and farthest > self.reached:
            way = 4.0 * np.array([self.reached, farthest]) / self.at
            before, after = np.clip(way[:, None] - np.arange(4.0), 0.0, 1.0)
            self.share += share * (after - before)
            self.reached = farthest

    def told(self, farthest: float, gap: Floats) -> bool:
        """Whether stiffer springs are to be tried."""
        if farthest <= self.at or self.asked:
            return False
        self.asked = True
        _, second, third, last = self.share  # of few blocks zero
        # forces that will hold the blocks carry more and more
        return bool(last < FADING * second or (last <= third and self._squeezed(gap)))

    def _squeezed(self, gap: Floats) -> bool:
        """Whether forces far above the loads have grown."""
        bodies = self.bodies
        before = gap if self.half_way is None else GROWN * self.half_way
        grown = (gap < -SQUEEZED * bodies.overlap) & (gap <= before)
        if grown.any():
            pressing, force = self._pressing(gap), -bodies.normal * gap
            grown &= force > SLIVER * np.maximum(pressing[bodies.block_a], pressing[bodies.block_b])
        if self.many and self.half_way is not None and grown.any():
            more = self._pressing(gap) >= DOUBLED * self._pressing(self.half_way)
            more[bodies.slot < 0] = False
            grown &= more[bodies.block_a] | more[bodies.block_b]
        return bool(grown.any())

    def _pressing(self, gap: Floats) -> Floats:
        """Sum (n,) of the normal forces on each block."""
        bodies = self.bodies
        force = bodies.normal * np.maximum(0.0, -gap)
        both = np.concatenate([bodies.block_a, bodies.block_b])
        return np.asarray(np.bincount(both, np.tile(force, 2), minlength=len(bodies.centroid)))
