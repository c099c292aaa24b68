"""What a block needs at the least, from its own equilibrium with everything around it held.

A block that has no equilibrium when all its neighbours hold still has none when they may move as
well. That settles many stages at the price of one block, and gives a lower bound on the help that
any order needs: where two blocks need each other, whichever comes first is propped, or both come
together.
"""

from __future__ import annotations

import numpy as np

from drystone.geometry.arrays import Floats
from drystone.results import Verdict
from drystone.sequence.judges import balance
from drystone.sequence.stages import Model, Stage, members


class LocalBalance:
    """Single blocks among held neighbours; remembers."""

    def __init__(self, model: Model) -> None:
        self.model = Model(model.assembly, model.contacts, model.load, balance)
        self._known: dict[tuple[int, int], bool] = {}

    def holds(self, block: int, placed: int) -> bool:
        """Whether contact forces from what is in place, all of it held, can balance a block."""
        around = self.model.neighbours[block] & placed
        key = (block, around)
        if key not in self._known:
            self._known[key] = self._rests(block, around) or self._balanced(block, around)
        return self._known[key]

    def _balanced(self, block: int, around: int) -> bool:
        answer = self.model.solve(Stage(around | 1 << block, around))
        return answer.verdict is not Verdict.UNSTABLE

    def _rests(self, block: int, around: int) -> bool:
        """Whether one joint alone carries it: the load goes through it, within its friction."""
        wrench = self.model.load.wrench[block]
        if wrench[3:].any() or not wrench[:3].any():
            return False
        contacts = self.model.contacts
        down = wrench[:3] / np.linalg.norm(wrench[:3])
        here = np.array(self.model.assembly.fixed)
        here[list(members(around))] = True
        as_b = (contacts.block_b == block) & here[contacts.block_a]
        as_a = (contacts.block_a == block) & here[contacts.block_b]
        dip = contacts.frame[:, 0] @ down * np.where(as_b, -1.0, 1.0)  # 1: level, below the block
        within = dip >= 1.0 / np.sqrt(1.0 + contacts.friction**2)
        return any(
            self._through(int(i), self.model.assembly.centroid[block], down)
            for i in np.flatnonzero((as_a | as_b) & within)
        )

    def _through(self, interface: int, point: Floats, direction: Floats) -> bool:
        """Whether a line meets the convex hull of an interface: no corner direction is missed."""
        contacts = self.model.contacts
        frame = contacts.frame[interface]
        corner = contacts.polygon(interface)
        reach = ((corner[0] - point) @ frame[0]) / (direction @ frame[0])
        flat = (corner - (point + reach * direction)) @ frame[1:].T
        angle = np.sort(np.arctan2(flat[:, 1], flat[:, 0]))
        gaps = np.diff(np.append(angle, angle[0] + 2.0 * np.pi))
        return bool(gaps.max() <= np.pi)

    def unbalanced(self, blocks: int, placed: int) -> tuple[int, ...]:
        """Those of some blocks that have no equilibrium among what is in place."""
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
        """Whether a block has no equilibrium without a neighbour, all others being there."""
        return not self.holds(block, self.model.everything & ~(1 << other))


__all__ = ["LocalBalance"]
