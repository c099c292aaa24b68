"""Directions in which a block can move straight away from its joints.

A block is free to move along d when no joint closes: ``n . d >= 0`` for every joint with a block in
place, n pointing from that block into this one. All such d form a cone.

Source: Wilson and Latombe 1994 (directional blocking).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.sequence.twists import TOLERANCE


@dataclass(frozen=True, eq=False)
class Freedom(OneLine):
    """Directions in which a block can be removed.

    Attributes
    ----------
    generators : (g, 3) unit
        Every free direction is a sum of these with non-negative factors; empty when blocked.
    preferred : (3,) unit, or None when blocked
        The free direction nearest to up.
    """

    generators: Floats
    preferred: Floats | None

    @property
    def blocked(self) -> bool:
        """Whether no translation is free."""
        return self.preferred is None


def freedom(normals: Floats, up: Floats, tolerance: float = TOLERANCE) -> Freedom:
    """The cone of directions d with ``normals @ d >= 0``.

    Parameters
    ----------
    normals : (j, 3) unit
    up : (3,) unit
    tolerance

    Examples
    --------
    A block on the floor can move up and sideways; a block between two walls only along them:

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
    rounded = np.round(normals / (0.1 * tolerance))
    distinct = np.array(sorted({tuple(one) for one in rounded.tolist()})) * (0.1 * tolerance)
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
    if not len(free):
        return Freedom(free, None)
    alike: dict[tuple[float, ...], int] = {}
    for number, one in enumerate(np.round(free, 6).tolist()):
        alike.setdefault(tuple(one), number)
    free = free[list(alike.values())]
    if (distinct @ up >= -tolerance).all():
        return Freedom(free, up)
    share, _ = nnls(free.T, up)
    steepest = free.T @ share
    length = float(np.linalg.norm(steepest))
    if length < tolerance:
        steepest, length = free[int(np.argmax(free @ up))], 1.0
    return Freedom(free, steepest / length)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    out: Floats = vectors[length[:, 0] > 0.0] / length[length[:, 0] > 0.0]
    return out
