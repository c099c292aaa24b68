"""What chosen corners contribute to a program: the wrench of a force along a local direction."""

from __future__ import annotations

import numpy as np

from drystone.arrays import Bools, Floats, Ints
from drystone.statics import Statics

NORMAL = np.array([1.0, 0.0, 0.0])
"""Local direction of a normal force."""


class CornerBlocks:
    """Some corners of a model, and their non-zeros in the equilibrium matrix.

    Attributes
    ----------
    corner : (c,) index of each among all corners
    freedom : (m,) row of each non-zero in the equilibrium matrix
    local : (m,) position in ``corner`` that it belongs to, ascending
    coefficient : (m, 3) of the three local force components
    """

    def __init__(self, statics: Statics, corner: Ints) -> None:
        block = np.stack([statics.block_a[corner], statics.block_b[corner]], axis=1)
        transfer = np.stack([statics.transfer_a[corner], statics.transfer_b[corner]], axis=1)
        free = block >= 0
        self.corner = corner
        self.freedom = (6 * block[free][:, None] + np.arange(6)).ravel()
        self.local = np.repeat(np.nonzero(free)[0], 6)
        self.coefficient = transfer[free].reshape(-1, 3)

    def along(self, direction: Floats) -> Floats:
        """(m,) non-zeros of the wrenches of unit forces along (c, 3) or (3,) local directions."""
        if direction.ndim == 1:
            return self.coefficient @ direction
        values: Floats = np.einsum("mi,mi->m", self.coefficient, direction[self.local])
        return values

    def kept(self, chosen: Bools) -> tuple[Bools, Ints]:
        """Non-zeros (m,) of the chosen corners (c,), and the new position of each corner."""
        return chosen[self.local], np.cumsum(chosen) - 1

    def crossed(self, left: Floats, right: Floats) -> tuple[Ints, Ints, Floats]:
        """Places and values of ``sum over corners of left_i right_i^T``, both as :meth:`along`."""
        size = np.bincount(self.local, minlength=len(self.corner))
        start = np.cumsum(size) - size
        repeats = size[self.local]
        first = np.repeat(np.arange(len(self.local)), repeats)
        offset = np.arange(len(first)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
        second = start[self.local[first]] + offset
        return self.freedom[first], self.freedom[second], left[first] * right[second]
