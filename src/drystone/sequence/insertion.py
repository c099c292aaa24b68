"""Can a block be put where it belongs? Directions in which translation is not blocked.

A block moves away freely along d when no joint closes: ``n . d >= 0`` for every joint with a block
in place, n pointing from that block into this one. All such d form a cone; it is put in along the
opposite of one of them.

Source: Wilson and Latombe 1994 (directional blocking). Only contacts are looked at: what stands
further along the way is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from drystone.geometry.arrays import Floats
from drystone.sequence.model import Model
from drystone.sequence.stages import members

TOLERANCE = 1e-3
"""Sine of the angle by which a joint may seem to close. Chosen: 0.06 degrees, above the rounding of
CAD files and well below any taper that a mason would call one."""


@dataclass(frozen=True, eq=False)
class Freedom:
    """Directions in which a block can leave.

    Attributes
    ----------
    generators : (g, 3) unit
        Every free direction is a sum of these with factors of zero or more; none when blocked.
    preferred : (3,) unit, or None when blocked
        The free direction nearest to up.
    """

    generators: Floats
    preferred: Floats | None

    @property
    def blocked(self) -> bool:
        """Whether no translation is free."""
        return self.preferred is None


def joint_normals(model: Model, block: int, placed: int) -> Floats:
    """Normals (j, 3) of the joints of a block with supports and blocks in place, into the block."""
    here = np.array(model.assembly.fixed)
    here[list(members(placed))] = True
    contacts = model.contacts
    as_b = (contacts.block_b == block) & here[contacts.block_a]
    as_a = (contacts.block_a == block) & here[contacts.block_b]
    normals: Floats = np.concatenate([contacts.frame[as_b, 0], -contacts.frame[as_a, 0]])
    return normals


def freedom(normals: Floats, up: Floats, tolerance: float = TOLERANCE) -> Freedom:
    """The cone of directions d with ``normals @ d >= 0``.

    Parameters
    ----------
    normals : (j, 3) unit
    up : (3,) unit
    tolerance

    Examples
    --------
    A block on the floor can go up and sideways, one between two walls only along them:

    >>> up = np.array([0.0, 0.0, 1.0])
    >>> freedom(np.array([[0.0, 0.0, 1.0]]), up).preferred.tolist()
    [0.0, 0.0, 1.0]
    >>> walls = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    >>> (freedom(walls, up).generators.round(6) + 0.0).tolist()
    [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]
    >>> freedom(np.concatenate([np.eye(3), -np.eye(3)]), up).blocked
    True
    """
    if not len(normals):
        axes = np.eye(3)
        return Freedom(np.concatenate([axes, -axes]), up)
    distinct = np.unique(np.round(normals / (0.1 * tolerance)), axis=0) * (0.1 * tolerance)
    squared, axes = np.linalg.eigh(distinct.T @ distinct)
    rank = int((squared > tolerance**2 * len(distinct)).sum())
    lineality = axes[:, : 3 - rank].T
    if rank == 1:
        candidates = np.concatenate([axes[:, 2:].T, -axes[:, 2:].T])
    elif rank == 2:
        across = np.cross(lineality[0], distinct)
        candidates = np.concatenate([across, -across])
    else:
        i, j = np.triu_indices(len(distinct), 1)
        across = np.cross(distinct[i], distinct[j])
        across = across[np.linalg.norm(across, axis=1) > tolerance]
        candidates = np.concatenate([across, -across])
    rays = np.concatenate([lineality, -lineality, _unit(candidates)])
    free = rays[(rays @ distinct.T >= -tolerance).all(axis=1)]
    free = free[np.sort(np.unique(np.round(free, 6), axis=0, return_index=True)[1])]
    if not len(free):
        return Freedom(free, None)
    if (distinct @ up >= -tolerance).all():
        return Freedom(free, up)
    share, _ = nnls(free.T, up)
    steepest = free.T @ share
    length = float(np.linalg.norm(steepest))
    if length < tolerance:
        steepest, length = free[int(np.argmax(free @ up))], 1.0
    return Freedom(free, steepest / length)


class RemovalTest:
    """Which blocks can leave while others are in place."""

    def __init__(self, model: Model, tolerance: float = TOLERANCE) -> None:
        self.model = model
        self.tolerance = tolerance
        self._known: dict[tuple[int, int], Freedom] = {}
        self._free: dict[tuple[int, int], bool] = {}

    def freedom(self, block: int, placed: int) -> Freedom:
        """How a block can leave the blocks in place (it may be one of them)."""
        around = self.model.neighbours[block] & placed & ~(1 << block)
        key = (block, around)
        if key not in self._known:
            normals = joint_normals(self.model, block, around)
            self._known[key] = freedom(normals, self.model.up, self.tolerance)
        return self._known[key]

    def way(self, block: int, placed: int) -> Floats | None:
        """The free direction (3,) nearest to up in which a block can leave; None when blocked."""
        normals = joint_normals(
            self.model, block, self.model.neighbours[block] & placed & ~(1 << block)
        )
        if (normals @ self.model.up >= 0.0).all():
            return self.model.up
        return self.freedom(block, placed).preferred

    def free(self, block: int, placed: int) -> bool:
        """Whether it can leave at all."""
        key = (block, self.model.neighbours[block] & placed & ~(1 << block))
        if key not in self._free:
            normals = joint_normals(self.model, *key)
            # most blocks can go straight up, or away from all of their joints; where these face
            # each other their sum is no direction
            away = normals.sum(axis=0)
            length = float(np.linalg.norm(away))
            quick = np.stack([self.model.up, away] if length > self.tolerance else [self.model.up])
            leaves = bool((normals @ quick.T >= 0.0).all(axis=0).any())
            self._free[key] = leaves or not self.freedom(*key).blocked
        return self._free[key]


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    out: Floats = vectors[length[:, 0] > 0.0] / length[length[:, 0] > 0.0]
    return out


__all__ = ["Freedom", "RemovalTest", "freedom", "joint_normals"]
