"""Small free motions of a block at its joints: a velocity and an angular velocity together.

A block moves with the velocity v of its centroid and the angular velocity w. At a corner r of a
joint with a block in place, n pointing into the moving block, the joint does not close when

    n . (v + w x (r - centroid)) >= 0.

All such twists (v, w) form a cone in six dimensions. It contains more than the zero motion if and
only if one of the twelve unit twists has a non-zero projection on it.

Source: Wilson and Latombe 1994 (blocking graphs for infinitesimal motions); the projection by
nonnegative least squares is Moreau's decomposition.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from drystone.base.arrays import Floats, Ints

TOLERANCE = 1e-3
"""Largest closing speed of a joint, relative to the size of the motion: 0.06 degrees for a
translation. Above the rounding of CAD files and well below any intended taper."""

OPEN = 0.1
"""Least length of a projection that is not rounding. If the cone contains a motion, one of its six
components is at least 0.4, so some unit twist has a projection of at least 0.4."""


@dataclass(frozen=True, eq=False)
class FreeTwists:
    """Twists that close no joint.

    Attributes
    ----------
    twist : (t, 6)
        Velocity [size / s] and angular velocity [rad / s], unit; one for each unit twist with a
        projection on the cone. Empty if the block cannot move.
    blocking : (b,)
        Rows that together block every motion; empty if a motion is free.
    """

    twist: Floats
    blocking: Ints

    @property
    def blocked(self) -> bool:
        """Whether no small motion is free."""
        return not len(self.twist)


def twist_rows(corner: Floats, normal: Floats, centre: Floats, size: float) -> Floats:
    """Rows (c, 6); each row times a twist is the opening speed of a corner.

    Parameters
    ----------
    corner : (c, 3) [m]
    normal : (c, 3) unit
        Into the moving block.
    centre : (3,) [m]
        Of the moving block.
    size : [m]
        Size of the moving block; velocities are divided by it, so both parts of a twist have one
        unit.
    """
    return np.column_stack([normal, np.cross((corner - centre) / size, normal)])


def free_twists(rows: Floats, tolerance: float = TOLERANCE) -> FreeTwists:
    """Twists x with ``rows @ x >= 0``, within the tolerance.

    Parameters
    ----------
    rows : (c, 6)
        Or (c, 3), normals only, for translations.
    tolerance

    Examples
    --------
    A block in a corner of three walls can be removed; in a closed box it cannot:

    >>> corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> up = twist_rows(corner, np.tile([0.0, 0.0, 1.0], (4, 1)), np.full(3, 0.5), 1.0)
    >>> free_twists(up).blocked
    False
    >>> both = np.concatenate([up, -up])
    >>> free_twists(np.concatenate([both, -both, np.eye(6), -np.eye(6)])).blocked
    True
    """
    size = rows.shape[1]
    units = np.concatenate([np.eye(size), -np.eye(size)])
    if not len(rows):
        return FreeTwists(units, np.zeros(0, dtype=np.intp))
    grid = 0.1 * tolerance
    whole, first = np.unique(np.round(rows / grid), axis=0, return_index=True)
    distinct = whole * grid
    found, used = [], np.zeros(len(distinct), dtype=bool)
    for seed in units:
        factor, _ = nnls(distinct.T, -seed)
        rest = seed + distinct.T @ factor
        length = float(np.linalg.norm(rest))
        used |= factor > 0.0
        if length > OPEN and (distinct @ rest >= -tolerance * length).all():
            found.append(rest / length)
    if not found:
        return FreeTwists(np.zeros((0, size)), first[used])
    twist = np.array(found)
    kept = np.sort(np.unique(np.round(twist, 4), axis=0, return_index=True)[1])
    return FreeTwists(twist[kept], np.zeros(0, dtype=np.intp))


def opens(rows: Floats, twist: Floats, tolerance: float = TOLERANCE) -> bool:
    """Whether a twist (6,) closes no joint by more than the tolerance."""
    return bool((rows @ twist >= -tolerance * np.linalg.norm(twist)).all())
