"""Polygons in space: area vectors, tributary areas."""

from __future__ import annotations

import numpy as np

from drystone.arrays import Floats, Ints, cross


def following(start: Ints) -> Ints:
    """For loops stored one after another, the position of each corner's successor."""
    result = np.arange(start[-1], dtype=np.intp) + 1
    filled = np.diff(start) > 0
    result[start[1:][filled] - 1] = start[:-1][filled]
    return result


def loop_means(values: Floats, start: Ints) -> Floats:
    """Mean of ``values`` (l, d) over each loop; every loop has a corner."""
    mean: Floats = np.add.reduceat(values, start[:-1], axis=0) / np.diff(start)[:, None]
    return mean


def area_vectors(corners: Floats, start: Ints) -> Floats:
    """Newell's area vector (f, 3) [m2] of each loop of corners (l, 3).

    Its length is the area of the projection along it, its direction the best-fit normal;
    computed about each loop's mean, so that nothing is lost far from the origin.
    Source: Sutherland, Sproull, Schumacker 1974.
    """
    if len(start) < 2:
        return np.zeros((0, 3))
    loop = np.repeat(np.arange(len(start) - 1), np.diff(start))
    local = corners - loop_means(corners, start)[loop]
    area: Floats = 0.5 * np.add.reduceat(cross(local, local[following(start)]), start[:-1], axis=0)
    return area


def tributary_areas(corners: Floats, start: Ints) -> Floats:
    """Share (l,) [m2] of its polygon's area that belongs to each corner.

    Half of the two fan triangles (about the mean of the corners) that meet at the corner;
    the shares of a polygon add up to the area of its fan.
    """
    if len(start) < 2:
        return np.zeros(0)
    loop = np.repeat(np.arange(len(start) - 1), np.diff(start))
    local = corners - loop_means(corners, start)[loop]
    after = following(start)
    half = 0.25 * np.linalg.norm(cross(local, local[after]), axis=1)
    share: Floats = half.copy()
    np.add.at(share, after, half)
    return share
