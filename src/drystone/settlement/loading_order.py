"""In which order a load is put on before blocks are followed to rest."""

from __future__ import annotations

import enum

import numpy as np

from drystone.base.arrays import Floats
from drystone.geometry.frames import rotation_about
from drystone.mechanics.bodies import Bodies

PARTS = 20
"""Of a load that is put on part by part. Chosen: ten models that were measured have the same limit
with the load at once."""


class Loading(enum.Enum):
    """How the load is put on; friction remembers it."""

    AT_ONCE = "at once"
    RAMP = "ramp"
    """All of it grows from nothing, in 20 parts with a rest after each."""
    TURNED = "turned"
    """All of it is turned from upright to its direction, in 20 parts with a rest after each."""


def earlier_loads(bodies: Bodies, loading: Loading) -> list[Floats]:
    """Loads (f, 6), scaled, under which the blocks rest before the whole load is on."""
    shares = np.arange(PARTS) / PARTS
    if loading is Loading.RAMP:
        return [share * bodies.load for share in shares[1:]]
    total = bodies.load[:, :3].sum(axis=0)
    size = float(np.linalg.norm(total))
    if loading is Loading.AT_ONCE or size == 0.0:
        return []
    down = np.array([0.0, 0.0, -1.0])
    angle = float(np.rad2deg(np.arccos(np.clip(total @ down / size, -1.0, 1.0))))
    if angle < 1e-9:
        return []
    axis = np.cross(down, total)
    if np.linalg.norm(axis) < 1e-9 * size:
        axis = np.array([1.0, 0.0, 0.0])
    made = []
    for share in shares:
        turn = rotation_about(axis, (share - 1.0) * angle)
        made.append((bodies.load.reshape(-1, 2, 3) @ turn.T).reshape(-1, 6))
    return made
