"""What a block needs at the least, from its own equilibrium with everything around it held.

A block that has no equilibrium when all its neighbours hold still has none when they may move as
well. That settles many stages at the price of one block, and gives a lower bound on the help that
any order needs: where two blocks need each other, whichever comes first is propped, or both come
together.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from drystone.base.arrays import Floats
from drystone.results import Verdict
from drystone.sequence.stage.stage_checks import balance
from drystone.sequence.stage.stages import Stage, members
from drystone.sequence.stage.structure import Structure

RAYS = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
"""Directions about a friction cone that stand for it first."""

ENCLOSING = 1.0 / np.cos(np.pi / len(RAYS))
"""Friction by which sums of these directions hold all of the cone."""

BALANCED = 1e-9
"""Unbalanced share of a load that is rounding."""

FALLING = 1e-5
"""One that is none: ten times what an interior point calls balanced."""


class LocalBalance:
    """Single blocks among held neighbours; remembers."""

    def __init__(self, model: Structure) -> None:
        self.model = Structure(model.model, balance)
        self._known: dict[tuple[int, int], bool] = {}

    def holds(self, block: int, placed: int) -> bool:
        """Whether contact forces from what is in place, all of it held, can balance a block."""
        around = self.model.neighbours[block] & placed
        key = (block, around)
        if key not in self._known:
            carried = self._rests(block, around) or self._carried(block, around)
            self._known[key] = self._balanced(block, around) if carried is None else carried
        return self._known[key]

    def _carried(self, block: int, around: int) -> bool | None:
        """Whether forces along some rays about the friction cones balance it.

        Rays on the cones that do are a proof; so are rays that enclose the cones and do not. None
        where neither is the case.
        """
        contacts, assembly = self.model.contacts, self.model.assembly
        joint = self._joints(block, around)
        if not contacts.dry[joint != 0.0].all():
            return None
        sign = joint[contacts.interface]
        corner = np.flatnonzero(sign)
        size, wrench = assembly.size[block], self.model.load.wrench[block]
        load = np.append(wrench[:3], wrench[3:] / size)
        length = float(np.linalg.norm(load))
        if not len(corner) or length == 0.0:
            return length == 0.0
        frame = contacts.frame[contacts.interface[corner]] * sign[corner, None, None]
        slide = contacts.friction[contacts.interface[corner], None, None]
        turn = np.stack([np.cos(RAYS), np.sin(RAYS)], axis=1) @ frame[:, 1:]
        arm = np.repeat((contacts.point[corner] - assembly.centroid[block]) / size, len(RAYS), 0)

        def unbalanced(wider: float) -> float:
            ray = (frame[:, None, 0] + wider * slide * turn).reshape(-1, 3)
            forces = np.concatenate([ray, np.cross(arm, ray)], axis=1).T
            return float(nnls(forces, -load / length)[1])

        try:
            if unbalanced(1.0) <= BALANCED:
                return True
            return None if unbalanced(ENCLOSING) <= FALLING else False
        except RuntimeError:  # it came to no end
            return None

    def _joints(self, block: int, around: int) -> Floats:
        """(m,) per interface: 1 where it presses the block along its normal, -1 against it."""
        contacts = self.model.contacts
        here = np.array(self.model.assembly.fixed)
        here[list(members(around))] = True
        as_b = (contacts.block_b == block) & here[contacts.block_a]
        as_a = (contacts.block_a == block) & here[contacts.block_b]
        return as_b.astype(np.float64) - as_a

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
        sign = self._joints(block, around)
        dip = -sign * (contacts.frame[:, 0] @ down)  # 1: level, below the block
        within = dip >= 1.0 / np.sqrt(1.0 + contacts.friction**2)
        return any(
            self._through(int(i), self.model.assembly.centroid[block], down)
            for i in np.flatnonzero((sign != 0.0) & within)
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
