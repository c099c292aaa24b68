"""Small motions that the joints of a block leave free: a velocity and a turn at once.

A block moves with the velocity v of its centroid and the angular velocity w. At a corner r of a
joint with a block in place, n pointing into the moving block, the joint does not close when

    n . (v + w x (r - centroid)) >= 0.

All such twists (v, w) form a cone in six dimensions. It holds more than the zero motion if and only
if one of the twelve unit twists has a projection on it that is not zero.

Source: Wilson and Latombe 1994 (blocking graphs for infinitesimal motions); the projection by
nonnegative least squares is Moreau's decomposition.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from drystone.base.arrays import Floats, Ints

TOLERANCE = 1e-3
"""By how much a joint may seem to close, by the size of the motion: 0.06 degrees for a straight
one. Above the rounding of CAD files and well below any taper that a mason would call one."""

OPEN = 0.1
"""Least length of a projection that is not rounding. Some unit twist has at least 0.4 where the
cone holds any motion, since one of its six components is at least that large."""


@dataclass(frozen=True, eq=False)
class FreeTwists:
    """Twists that close no joint.

    Attributes
    ----------
    twist : (t, 6)
        Velocity [size / s] and angular velocity [rad / s], unit; one for each unit twist that has
        a part in the cone. None where the block cannot move at all.
    blocking : (b,)
        Rows that together leave no motion free; empty where there is one.
    """

    twist: Floats
    blocking: Ints

    @property
    def blocked(self) -> bool:
        """Whether no small motion at all is free."""
        return not len(self.twist)


def twist_rows(corner: Floats, normal: Floats, centre: Floats, size: float) -> Floats:
    """Rows (c, 6) of which each, times a twist, is the speed at which a corner opens.

    Parameters
    ----------
    corner : (c, 3) [m]
    normal : (c, 3) unit
        Into the moving block.
    centre : (3,) [m]
        Of the moving block.
    size : [m]
        Of the moving block: velocities are measured by it, so that both halves are alike.
    """
    return np.column_stack([normal, np.cross((corner - centre) / size, normal)])


def free_twists(rows: Floats, tolerance: float = TOLERANCE) -> FreeTwists:
    """Twists x with ``rows @ x >= 0``, within the tolerance.

    Parameters
    ----------
    rows : (c, 6)
        Or (c, 3), normals alone, for straight motions.
    tolerance

    Examples
    --------
    A block in a corner of three walls can leave; in a box it cannot:

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


__all__ = ["TOLERANCE", "FreeTwists", "free_twists", "opens", "twist_rows"]
