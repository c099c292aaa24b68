"""Least help of a block, from its equilibrium with all neighbours held.

A block without equilibrium between fixed neighbours has none between movable neighbours either.
This decides many stages with a calculation of one block. It also gives a lower bound of the help in
any order: where two blocks need each other, the first one is propped, or both are placed together.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from drystone.base.arrays import Floats
from drystone.results import Verdict
from drystone.sequence.solving import PartSolver
from drystone.sequence.stages import Stage, balance, members
from drystone.sequence.structure import Structure

RAYS = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
"""Number of directions about a friction cone in the first test."""

ENCLOSING = 1.0 / np.cos(np.pi / len(RAYS))
"""Factor on friction with which sums of these directions contain the whole cone."""

BALANCED = 1e-9
"""Unbalanced share of a load that counts as rounding."""

FALLING = 1e-5
"""Unbalanced share that counts as no equilibrium: ten times the tolerance of the interior-point
solver."""


class LocalBalance:
    """Equilibrium of single blocks between held neighbours, with a cache."""

    def __init__(self, model: Structure) -> None:
        self.model = model
        self._solver = PartSolver(Structure(model.model, balance))
        self._known: dict[tuple[int, int], bool] = {}

    def holds(self, block: int, placed: int) -> bool:
        """Whether contact forces from the blocks in place, all held, can balance a block."""
        around = self.model.neighbours[block] & placed
        key = (block, around)
        if key not in self._known:
            carried = self._rests(block, around) or self._carried(block, around)
            self._known[key] = self._balanced(block, around) if carried is None else carried
        return self._known[key]

    def _carried(self, block: int, around: int) -> bool | None:
        """Whether forces along some rays about the friction cones balance it.

        True if rays on the cones balance it. False if rays that enclose the cones do not. Else
        None.
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
        except RuntimeError:  # no convergence
            return None

    def _joints(self, block: int, around: int) -> Floats:
        """Sign (m,) per interface: 1 if it presses the block along its normal, -1 against it."""
        contacts = self.model.contacts
        here = np.array(self.model.assembly.fixed)
        here[list(members(around))] = True
        as_b = (contacts.block_b == block) & here[contacts.block_a]
        as_a = (contacts.block_a == block) & here[contacts.block_b]
        return as_b.astype(np.float64) - as_a

    def _balanced(self, block: int, around: int) -> bool:
        answer = self._solver.solve(Stage(around | 1 << block, around))
        return answer.verdict is not Verdict.UNSTABLE

    def _rests(self, block: int, around: int) -> bool:
        """Whether one joint alone carries it: the load passes through it, within its friction."""
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
        """Whether a line intersects the convex hull of an interface."""
        contacts = self.model.contacts
        frame = contacts.frame[interface]
        corner = contacts.polygon(interface)
        reach = ((corner[0] - point) @ frame[0]) / (direction @ frame[0])
        flat = (corner - (point + reach * direction)) @ frame[1:].T
        angle = np.sort(np.arctan2(flat[:, 1], flat[:, 0]))
        gaps = np.diff(np.append(angle, angle[0] + 2.0 * np.pi))
        return bool(gaps.max() <= np.pi)

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
