"""A slice of a dome between two meridian planes."""

from __future__ import annotations

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.models.simple import box
from drystone.models.solids import prism, require, welded


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
        corner = point[:, ring : ring + 2]
        faces = [corner[:, :, side].reshape(4, 3)[[0, 1, 3, 2]] for side in (0, 1)]
        faces += [corner[face].reshape(4, 3)[[0, 1, 3, 2]] for face in (0, 1)]
        faces += [corner[:, joint].reshape(4, 3)[[0, 1, 3, 2]] for joint in (0, 1)]
        blocks.append(welded(faces, f"ring-{ring:02d}"))
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
