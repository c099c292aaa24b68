"""Hemispherical domes of plane-faced voussoirs, and slices of them between two meridian planes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.models.simple import box
from drystone.models.solids import prism, require, shell_faces, welded


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
            blocks.append(welded(shell_faces(shell), f"r{ring:02d}-b{i:02d}"))
    return Assembly(tuple(blocks), np.arange(len(blocks)) < slices)


def _two(thickness: float | Sequence[float]) -> tuple[float, float]:
    pair = np.broadcast_to(np.asarray(thickness, dtype=np.float64), (2,))
    return float(pair[0]), float(pair[1])


def lune(
    thickness_ratio: float = 0.05,
    rings: int = 40,
    angle: float = 5.0,
    radius: float = 1.0,
) -> Assembly:
    """A slice of a closed hemispherical dome between two fixed walls in its meridian planes.

    With walls without friction it behaves like a dome whose slices all move alike: the walls press
    in place of the neighbours. Without hoop tension the least thickness by radius is 0.0428 (Heyman
    1967: 0.042, for a simpler mechanism).

    Parameters
    ----------
    thickness_ratio
        Thickness over the radius of the middle surface.
    rings
        Voussoirs from the ground to the pole, of equal latitude.
    angle : [degrees]
        Between the walls.
    radius : [m]
        Of the middle surface.

    Returns
    -------
    Assembly
        ``ground``, ``wall-left``, ``wall-right``, all fixed, and ``ring-00`` upwards.
    """
    require(0.0 < thickness_ratio < 2.0, "no such thickness", "thickness / radius below 2")
    require(rings > 1 and 0.0 < angle < 90.0, f"a lune of {rings} rings, {angle} deg", "2, 0 to 90")
    half = np.deg2rad(0.5 * angle)
    sphere = radius * (1.0 + 0.5 * thickness_ratio * np.array([-1.0, 1.0]))
    latitude = 0.5 * np.pi * np.arange(rings + 1) / rings
    across = sphere[:, None] * np.cos(latitude)
    across[:, -1] = 0.0
    point = np.empty((2, rings + 1, 2, 3))  # intrados and extrados, joint, side
    for side, turn in enumerate((-half, half)):
        point[:, :, side, 0] = across * np.cos(turn)
        point[:, :, side, 1] = across * np.sin(turn)
        point[:, :, side, 2] = sphere[:, None] * np.sin(latitude)
    blocks: list[Block] = []
    for ring in range(rings):
        blocks.append(welded(shell_faces(point[:, ring : ring + 2]), f"ring-{ring:02d}"))
    reach = 1.1 * float(sphere[1])
    depth = 0.1 * radius
    ground = box((2.0 * reach, 2.0 * reach, depth), (-0.5 * reach, -reach, -depth), "ground")
    plane = [(0.0, 0.0), (reach, 0.0), (reach, reach), (0.0, reach)]
    walls = []
    for name, y, turn in (("left", (-depth, 0.0), -half), ("right", (0.0, depth), half)):
        cos, sin = np.cos(turn), np.sin(turn)
        rotation = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]
        walls.append(prism(plane, y, f"wall-{name}").transformed(rotation))
    return Assembly((ground, *walls, *blocks), np.arange(3 + rings) < 3)
