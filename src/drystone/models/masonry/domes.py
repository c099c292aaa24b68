"""Hemispherical domes of plane-faced voussoirs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.solids import require, welded


def dome(
    radius: float = 5.0,
    thickness: float | Sequence[float] = (0.5, 0.25),
    oculus: float = 1.0,
    slices: int = 14,
    rings: int = 10,
    *,
    bonded: bool = False,
) -> Assembly:
    """A hemispherical dome with conical bed joints and meridian head joints.

    With the defaults, friction 0.6 and the bottom ring fixed, it tilts to 32 degrees
    (Kao et al. 2022, RBE).

    Parameters
    ----------
    radius : [m]
        Of the middle surface.
    thickness : [m]
        Constant, or at the base and at the top, linear in latitude between.
    oculus : [m]
        Radius of the opening on the middle surface; at zero the top ring closes at the pole.
    slices, rings
        Blocks per ring, and number of rings of equal latitude. The lowest ring is fixed.
    bonded
        Every other ring is turned by half a slice. Its blocks then have two plane halves, so that
        the beds match.

    Returns
    -------
    Assembly
        ``r00-b00`` around the ring, ring by ring upwards.

    Notes
    -----
    The corners lie on the two spheres; all faces are exactly planar, since the chords at all
    latitudes are parallel.
    """
    low, high = _two(thickness)
    require(slices > 2 and rings > 1, f"a dome of {slices} x {rings}", "3 slices, 2 rings or more")
    require(min(low, high) > 0.0 and max(low, high) < 2.0 * radius, "no such thickness", "0 to 2 R")
    require(0.0 <= oculus < radius, f"an oculus of {oculus} m", "between zero and the radius")
    latitude = np.arccos(oculus / radius) * np.arange(rings + 1) / rings
    half = 0.5 * np.linspace(low, high, rings + 1)
    parts = 2 * slices if bonded else slices
    longitude = 2.0 * np.pi * np.arange(parts) / parts
    ray = np.column_stack([np.cos(longitude), np.sin(longitude)])
    sphere = radius + np.stack([-half, half])  # (2, rings + 1), intrados and extrados
    across = sphere * np.cos(latitude)
    if oculus == 0.0:
        across[:, -1] = 0.0
    point = np.empty((2, rings + 1, parts, 3))
    point[..., :2] = across[..., None, None] * ray
    point[..., 2] = (sphere * np.sin(latitude))[..., None]
    blocks: list[Block] = []
    for ring in range(rings):
        for i in range(slices):
            first = 2 * i + ring % 2 if bonded else i
            span = np.arange(first, first + (3 if bonded else 2)) % parts
            shell = point[:, ring : ring + 2][:, :, span]
            blocks.append(welded(_shell_faces(shell), f"r{ring:02d}-b{i:02d}"))
    return Assembly(tuple(blocks), np.arange(len(blocks)) < slices)


def _two(thickness: float | Sequence[float]) -> tuple[float, float]:
    pair = np.broadcast_to(np.asarray(thickness, dtype=np.float64), (2,))
    return float(pair[0]), float(pair[1])


def _shell_faces(shell: Floats) -> list[Floats]:
    """Faces of a piece of shell (2, 2, s, 3): inner and outer, lower and upper, stations."""
    faces = [shell[:, :, end].reshape(4, 3)[[0, 1, 3, 2]] for end in (0, -1)]
    for i in range(shell.shape[2] - 1):
        faces += [shell[side, :, i : i + 2].reshape(4, 3)[[0, 1, 3, 2]] for side in (0, 1)]
        faces += [shell[:, bed, i : i + 2].reshape(4, 3)[[0, 1, 3, 2]] for bed in (0, 1)]
    return faces
