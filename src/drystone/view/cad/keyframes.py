"""A motion as poses at times, for animations."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats
from drystone.geometry.frames import rotation_about

SECONDS = 2.4
"""Duration [s] of a motion, as on the page."""
FRAMES = 25
"""Number of poses of a motion. Chosen: programs interpolate linearly between them."""


def fall_moments() -> tuple[Floats, Floats]:
    """Times (t,) [s], and the share (t,) of the motion at each, as in a free fall."""
    share = np.linspace(0.0, 1.0, FRAMES)
    return SECONDS * share, share**2


def quaternions(rotation: Floats) -> Floats:
    """(t, 4) x, y, z, w of rotation vectors (t, 3) [rad]."""
    angle = np.linalg.norm(rotation, axis=1, keepdims=True)
    half = np.sinc(angle / (2.0 * np.pi)) / 2.0  # sin(angle / 2) / angle, also at zero
    return np.concatenate([rotation * half, np.cos(0.5 * angle)], axis=1)


def matrix_of(motion: Floats, centroid: Floats) -> Floats:
    """(4, 4) of a motion (6,) [m, rad]: translation of the centroid (3,) and rotation about it."""
    angle = float(np.linalg.norm(motion[3:]))
    matrix = np.eye(4)
    if angle > 0.0:
        matrix[:3, :3] = rotation_about(motion[3:], float(np.rad2deg(angle)))
    matrix[:3, 3] = centroid + motion[:3] - matrix[:3, :3] @ centroid
    return matrix


__all__ = ["fall_moments", "matrix_of", "quaternions"]
