"""Which blocks can leave while others are in place.

Straight directions that no joint blocks are tried first: most blocks have one. If there is none, a
path with rotation is searched, without collision with the blocks in place.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.display import OneLine
from drystone.sequence.freedom import (
    TOLERANCE,
    Freedom,
    Joints,
    free_twists,
    freedom,
)
from drystone.sequence.path_search import NoPath, PathFinder, PathOptions, RemovalPath
from drystone.sequence.stages import StagedModel, members

EFFORT = 1500
"""Number of swept volumes that are tested before a block counts as blocked during planning.
Chosen."""


class RemovalTest(OneLine):
    """Tests which blocks can be removed while others are in place.

    Parameters
    ----------
    model
    """

    def __init__(self, model: StagedModel) -> None:
        self.model = model
        self._all: dict[int, Joints] = {}
        self._known: dict[tuple[int, int], Freedom] = {}
        self._free: dict[tuple[int, int], bool] = {}
        self._paths: dict[tuple[int, int], RemovalPath | NoPath] = {}

    def _summary(self) -> str:
        return repr(self.model)

    def freedom(self, block: int, placed: int) -> Freedom:
        """Straight directions in which a block can be removed from the blocks in place."""
        key = self._key(block, placed)
        if key not in self._known:
            normals = self._normals(*key)
            self._known[key] = freedom(normals, self.model.up)
        return self._known[key]

    def direction(self, block: int, placed: int) -> Floats | None:
        """The free direction (3,) nearest to up; None when blocked."""
        return self.freedom(block, placed).preferred

    def free(self, block: int, placed: int) -> bool:
        """Whether it can be removed, straight or with rotation."""
        key = self._key(block, placed)
        if key not in self._free:
            normals = self._normals(*key)
            # most blocks can move straight up or away from all joints; opposite joints have no sum
            away = normals.sum(axis=0)
            length = float(np.linalg.norm(away))
            quick = np.stack([self.model.up, away] if length > TOLERANCE else [self.model.up])
            leaves = bool((normals @ quick.T >= 0.0).all(axis=0).any())
            self._free[key] = leaves or not self.freedom(*key).blocked
        return self._free[key] or self._turns(block, placed)

    def leaves(self, block: int, placed: int, directions: Floats) -> Bools:
        """Whether it can be removed straight, for each direction (d, 3), unit."""
        normals = self._normals(*self._key(block, placed))
        return np.asarray((directions @ normals.T >= -TOLERANCE).all(axis=1))

    def path(self, block: int, placed: int) -> RemovalPath | NoPath:
        """The path on which a block is removed from those in place, or why there is none."""
        key = (block, placed & ~(1 << block))
        if key not in self._paths:
            self._paths[key] = self._finder.path(block, self._here(placed))
        return self._paths[key]

    def reason(self, block: int, placed: int) -> str:
        """Why a block cannot be removed, with the blocking faces."""
        found = self.path(block, placed)
        return found.reason if isinstance(found, NoPath) else ""

    def _turns(self, block: int, placed: int) -> bool:
        """Whether a block without a straight path has one with rotation."""
        around = self._here(self._key(block, placed)[1])
        joints = Joints.of(self.model.contacts, block, around)
        if free_twists(joints.rows(self.model.assembly.blocks[block])).blocked:
            return False
        return isinstance(self.path(block, placed), RemovalPath)

    @cached_property
    def _finder(self) -> PathFinder:
        up = self.model.up.tolist()
        return PathFinder(self.model.model, PathOptions(effort=EFFORT, up=tuple(up)))

    def _key(self, block: int, placed: int) -> tuple[int, int]:
        """The block and its neighbours in place; the joints depend on these only."""
        return block, self.model.neighbours[block] & placed & ~(1 << block)

    def _here(self, placed: int) -> Bools:
        here = np.array(self.model.assembly.fixed)
        here[list(members(placed))] = True
        return here

    def _normals(self, block: int, placed: int) -> Floats:
        """Normals (j, 3) into a block of its joints with those in place."""
        if block not in self._all:
            everything = self._here(self.model.everything)
            self._all[block] = Joints.of(self.model.contacts, block, everything)
        joints = self._all[block]
        return joints.normal[self._here(placed)[joints.other]]
