"""Directions, local frames, and polygons in space: area vectors, tributary areas."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base import arrays
from drystone.base.arrays import Floats, Ints, cross, frozen_floats, lengths, number, plane_cross
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged

AXES = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
}
"""Axes by name."""

LEVEL_AXES = {name: AXES[name] for name in ("x", "-x", "y", "-y")}
"""The horizontal axes about which a structure is tilted, to each of four sides."""


def unit(vector: Floats | Sequence[float], what: str = "direction") -> Floats:
    """The unit vector along ``vector`` (3,).

    Raises
    ------
    InputError
        Zero or not finite.
    """
    array = frozen_floats(vector, (3,), what)
    largest = float(np.abs(array).max())
    if largest == 0.0:
        raise InputError(f"{what} is zero", remedy="give a vector with a length")
    array = array / largest  # squares of 1e-170 or 1e170 do not fit a float
    return array / np.linalg.norm(array)


def axis_vector(axis: Floats | Sequence[float] | str, called: str = "axis") -> Floats:
    """An axis (3,) from a name or a vector.

    Raises
    ------
    InputError
        No such name, or a vector without a length.
    """
    if isinstance(axis, str):
        if axis not in AXES:
            raise InputError(f"no axis is called '{axis}'", remedy=f"{', '.join(AXES)} or X,Y,Z")
        return np.array(AXES[axis])
    return unit(axis, called)


def axis_words(axis: Floats) -> str:
    """An axis (3,) in words; what turns about a horizontal one leans at right angles to it."""
    along = unit(axis, "axis")
    for name, known in AXES.items():
        if np.allclose(along, known, atol=1e-6):
            return f"about {name}"
    if abs(along[2]) > 1e-6:
        return f"about ({', '.join(f'{one:.4g}' for one in along)})"
    towards = np.rad2deg(np.arctan2(along[1], along[0])) - 90.0
    return f"towards {towards % 360.0:.4g} degrees from x"


def frames_from_normals(normal: Floats) -> Floats:
    """Right-handed frames (m, 3, 3), rows n, u, v, for unit normals (m, 3).

    u is horizontal unless the normal is vertical. The mechanics do not depend on the choice.
    """
    n = np.asarray(normal, dtype=np.float64).reshape(-1, 3)
    steep = np.abs(n[:, 2]) > 0.9
    helper = np.where(steep[:, None], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    u = cross(helper, n)
    length = lengths(u)[:, None]
    u /= np.where(length > 0.0, length, 1.0)
    return np.stack([n, u, cross(n, u)], axis=1)


def rotation_about(axis: Floats, angle_deg: float) -> Floats:
    """Rotation matrix (3, 3), counter-clockwise about ``axis`` by ``angle_deg`` degrees.

    Source: Rodrigues 1840.
    """
    x, y, z = unit(axis, "axis")
    angle = np.deg2rad(number(angle_deg, "the angle"))
    turn = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * turn + (1.0 - np.cos(angle)) * (turn @ turn)


UNTURNED = arrays.frozen(np.eye(3))
"""The matrix of no rotation: to make one takes longer than a product of two."""
_SKEW = np.array([[0, 2, 1], [2, 0, 0], [1, 0, 0]])
_SIGN = np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])


def rotations(vectors: Floats) -> Floats:
    """Matrices (n, 3, 3) of rotation vectors (n, 3) [rad]. Source: Rodrigues 1840."""
    axis, angle = arrays.unit(vectors)
    turn = skew(axis)
    made = np.sin(angle)[:, None, None] * turn
    made += UNTURNED
    made += (1.0 - np.cos(angle))[:, None, None] * (turn @ turn)
    return made


def skew(vectors: Floats) -> Floats:
    """Matrices (k, 3, 3) with ``skew(a) @ b == cross(a, b)`` for vectors (k, 3)."""
    return vectors.take(_SKEW, axis=-1) * _SIGN


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
