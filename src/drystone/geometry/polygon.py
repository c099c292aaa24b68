"""Polygons in space: area vectors, tributary areas."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats, Ints, cross, lengths, plane_cross
from drystone.base.ragged import Ragged


def area_vectors(corners: Floats, start: Ints) -> Floats:
    """Newell's area vector (f, 3) [m2] of each loop of corners (l, 3).

    Its length is the area of the projection along it. Its direction is the best-fit normal. It is
    computed about the mean of each loop, so no digits are lost far from the origin. Source:
    Sutherland, Sproull, Schumacker 1974.
    """
    loops = Ragged(start)
    local = corners - loops.spread(loops.mean(corners))
    return 0.5 * loops.sum(cross(local, local[loops.following]))


def area_vector(corners: Floats) -> Floats:
    """Newell's area vector (3,) [m2] of one polygon (c, 3)."""
    return area_vectors(corners, np.array([0, len(corners)]))[0]


def tributary_areas(corners: Floats, start: Ints | Ragged) -> Floats:
    """Share (l,) [m2] of its polygon's area that belongs to each corner (l, 3), or (l, 2).

    The share is half of the two fan triangles (about the mean of the corners) that meet at the
    corner. The shares of a polygon sum to the area of its fan.
    """
    loops = Ragged.over(start)
    local = corners - loops.mean(corners)[loops.owner]
    after = loops.following
    there = local[after]
    if corners.shape[1] == 2:
        half = 0.25 * np.abs(plane_cross(local, there))
    else:
        half = 0.25 * lengths(cross(local, there))
    share: Floats = half.copy()
    share[after] += half
    return share
