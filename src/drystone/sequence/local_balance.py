"""Least help of a block, from its equilibrium with all neighbours held.

A block without equilibrium between fixed neighbours has none between movable neighbours either.
This decides many stages with a calculation of one block. It also gives a lower bound of the help in
any order: where two blocks need each other, the first one is propped, or both are placed together.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from drystone.base.arrays import Floats
from drystone.sequence.staged_model import StagedModel
from drystone.sequence.stages import members

RAYS = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
"""Directions about a friction cone. Sums of them contain the cone, and reach 2 % farther. Without
this test plans of shells of 40 to 85 blocks take a fifth longer, and need more props."""

FALLING = 1e-5
"""Unbalanced share of the load that counts as no equilibrium."""


class LocalBalance:
    """Equilibrium of single blocks between held neighbours, with a cache."""

    def __init__(self, model: StagedModel) -> None:
        self.model = model
        self._known: dict[tuple[int, int], bool] = {}

    def holds(self, block: int, placed: int) -> bool:
        """Whether contact forces from the blocks in place, all held, may balance a block."""
        around = self.model.neighbours[block] & placed
        key = (block, around)
        if key not in self._known:
            self._known[key] = self._balanced(block, around)
        return self._known[key]

    def _balanced(self, block: int, around: int) -> bool:
        """Whether forces along rays that enclose the friction cones balance it."""
        contacts, assembly = self.model.contacts, self.model.assembly
        here = np.array(assembly.fixed)
        here[list(members(around))] = True
        as_b = (contacts.block_b == block) & here[contacts.block_a]
        as_a = (contacts.block_a == block) & here[contacts.block_b]
        size, wrench = assembly.size[block], self.model.load.wrench[block]
        load = np.append(wrench[:3], wrench[3:] / size)
        length = float(np.linalg.norm(load))
        if length == 0.0 or not contacts.dry[as_a | as_b].all():  # glue may hold it
            return True
        sign = (as_b.astype(np.float64) - as_a)[contacts.interface]
        corner = np.flatnonzero(sign)
        frame = contacts.frame[contacts.interface[corner]] * sign[corner, None, None]
        slide = contacts.friction[contacts.interface[corner], None, None]
        turn = np.stack([np.cos(RAYS), np.sin(RAYS)], axis=1) @ frame[:, 1:]
        ray = frame[:, None, 0] + slide / np.cos(np.pi / len(RAYS)) * turn
        arm = (contacts.point[corner] - assembly.centroid[block]) / size
        forces = np.concatenate([ray, np.cross(arm[:, None], ray)], axis=2).reshape(-1, 6).T
        return len(corner) > 0 and _distance(forces, -load / length) <= FALLING

    def unbalanced(self, blocks: int, placed: int) -> tuple[int, ...]:
        """The given blocks that have no equilibrium among the blocks in place."""
        return tuple(b for b in members(blocks) if not self.holds(b, placed))

    def helpless_pairs(self) -> tuple[int, ...]:
        """Disjoint pairs of blocks, as bits, of which at least one needs help in any order."""
        free = self.model.everything
        pairs = []
        for block in members(free):
            if not free >> block & 1:
                continue
            for other in members(self.model.neighbours[block] & free):
                if self._needs(block, other) and self._needs(other, block):
                    pairs.append(1 << block | 1 << other)
                    free &= ~pairs[-1]
                    break
        return tuple(pairs)

    def _needs(self, block: int, other: int) -> bool:
        """Whether a block has no equilibrium without one neighbour, with all others in place."""
        return not self.holds(block, self.model.everything & ~(1 << other))


def _distance(forces: Floats, load: Floats) -> float:
    """Of a load from the cone of some forces (6, r); zero where it is not found."""
    try:
        return float(nnls(forces, load)[1])
    except RuntimeError:  # no convergence
        return 0.0
