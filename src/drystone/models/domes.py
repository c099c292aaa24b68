"""Hemispherical domes of plane-faced voussoirs, and slices of them between two meridian planes.

Models with curved joints, given as strips; both blocks of a joint have the same strips.

Dimensions: Kao 2023, doctoral dissertation, ETH Zurich.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.geometry.frames import rotation_about
from drystone.models.simple import box, prism, require, sections, shell_faces, welded


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
    oculus : [m] >= 0
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
    require(oculus < radius, f"an oculus of {oculus} m", "less than the radius")
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
    thickness_ratio : > 0, < 2
        Thickness over the radius of the middle surface.
    rings : >= 2
        Voussoirs from the ground to the pole, of equal latitude.
    angle : [degrees] > 0, < 90
        Between the walls.
    radius : [m]
        Of the middle surface.

    Returns
    -------
    Assembly
        ``ground``, ``wall-left``, ``wall-right``, all fixed, and ``ring-00`` upwards.
    """
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
    blocks = [
        welded(shell_faces(point[:, ring : ring + 2]), f"ring-{ring:02d}") for ring in range(rings)
    ]
    reach = 1.1 * float(sphere[1])
    depth = 0.1 * radius
    ground = box((2.0 * reach, 2.0 * reach, depth), (-0.5 * reach, -reach, -depth), "ground")
    plane = [(0.0, 0.0), (reach, 0.0), (reach, reach), (0.0, reach)]
    walls = []
    for name, y, turn in (("left", (-depth, 0.0), -angle), ("right", (0.0, depth), angle)):
        rotation = rotation_about(np.array([0.0, 0.0, 1.0]), 0.5 * turn)
        walls.append(prism(plane, y, f"wall-{name}").transformed(rotation))
    return Assembly((ground, *walls, *blocks), np.arange(3 + rings) < 3)


def resampled(curve: ArrayLike, strips: int) -> Floats:
    """A curve (c, 2) cut into equal steps of its parameter: the given points for c - 1 strips.

    A cubic spline through the points, whose parameter is their number. Source: de Boor 1978.
    """
    points = np.asarray(curve, dtype=np.float64)
    if strips == len(points) - 1:
        return points
    from scipy.interpolate import CubicSpline  # slow to import

    parameter = np.arange(len(points))
    finer: Floats = CubicSpline(parameter, points)(np.linspace(0.0, len(points) - 1.0, strips + 1))
    finer[[0, -1]] = points[[0, -1]]
    return finer


def curve_three_blocks(strips: int = 20) -> Assembly:
    """A roller in the hollow of a block that rests with an S-shaped bed on a fixed one.

    Published tilt limits for a friction of 0.84: 8 degrees about y, 53 about -y, 24 about x,
    12 about x+y, 47 about x-y.

    Parameters
    ----------
    strips : >= 2
        Plane pieces of each of the two joints.

    Returns
    -------
    Assembly
        ``base``, fixed, ``cradle`` and ``roller``.
    """
    curves = sections("curve-three-blocks")
    bed, hollow = resampled(curves["bed"], strips), resampled(curves["hollow"], strips)
    corners = {
        "base": [(0.0, 0.0), (1.0, 0.0), *bed[::-1]],
        "cradle": [(-0.5, bed[0, 1]), *bed, (1.5, 0.7), *hollow[::-1], (-0.5, 2.0)],
        "roller": [*hollow, *_rest_of_roller(hollow, *curves["roller"])],
    }
    blocks = tuple(prism(np.array(c), (0.0, 1.0), name) for name, c in corners.items())
    return Assembly(blocks, np.array([True, False, False]))


def _rest_of_roller(hollow: Floats, x: float, z: float, radius: float) -> Floats:
    """The arc of a circle from the end of the hollow to its start, in equal steps."""
    centre = np.array([x, z])
    end, start = (np.arctan2(*(p - centre)[::-1]) for p in (hollow[-1], hollow[0]))
    inside = (end - start) % (2.0 * np.pi)
    outside = 2.0 * np.pi - inside
    pieces = max(round((len(hollow) - 1) * outside / inside), 3)
    angle = end + outside * np.arange(1, pieces) / pieces
    return centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def cube_curve(height: Literal["short", "tall"] = "short", strips: int = 18) -> Assembly:
    """Two hollow blocks, open towards each other, that touch along an S-shaped rim 0.1 m wide.

    The rim is high at two opposite corners, (0, 0) and (1, 1), and low at the two others; across
    the wall its height is constant, with mitred corners.
    Published tilt limits for a friction of 0.84: 70 to 80 degrees (short), 40 to 59 (tall).

    Parameters
    ----------
    height
        ``short``: 1.1 m, corners of the rim at 0.9 and 0.2 m. ``tall``: 2.6 m, at 1.7 and 1.0 m.
    strips : >= 4
        Plane pieces of the rim along each wall, the two mitred corners included.

    Returns
    -------
    Assembly
        ``lower``, fixed, and ``upper``.
    """
    first, *curve, last = sections("cube-curve")["rim"]
    rim = np.vstack([first, resampled(curve, strips - 2), last])
    lift, top = (0.0, 1.1) if height == "short" else (0.8, 2.6)
    rim[:, 1] += lift
    lower = _hollow_block(rim, outside=0.0, floor=0.1, name="lower")
    upper = _hollow_block(rim, outside=top, floor=top - 0.1, name="upper")
    return Assembly((lower, upper), np.array([True, False]))


def _hollow_block(rim: Floats, outside: float, floor: float, name: str) -> Block:
    """The block between the rim and a slab with faces z = ``outside`` and z = ``floor``."""
    wall = 0.1
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    inside = wall + (1.0 - 2.0 * wall) * square
    loops = [np.insert(square, 2, outside, axis=1), np.insert(inside, 2, floor, axis=1)]
    for along in (0, 1):
        for far in (False, True):
            strips = rim if not far else np.column_stack([1.0 - rim[::-1, 0], rim[::-1, 1]])
            outer, hollow = (1.0, 1.0 - wall) if far else (0.0, wall)
            within = np.clip(strips[:, 0], wall, 1.0 - wall)
            at_outer = _along(along, strips[:, 0], outer, strips[:, 1])
            at_inner = _along(along, within, hollow, strips[[1, *range(1, len(rim) - 1), -2], 1])
            loops += [
                np.array([at_outer[i], at_outer[i + 1], at_inner[i + 1], at_inner[i]])
                for i in range(len(rim) - 1)
            ]
            ends = np.array([1.0, 0.0])
            loops.append(np.vstack([at_outer, _along(along, ends, outer, outside)]))
            corners = np.array([1.0 - wall, wall])
            loops.append(np.vstack([at_inner[1:-1], _along(along, corners, hollow, floor)]))
    return welded(loops, name)


def _along(axis: int, place: Floats, side: float, z: ArrayLike) -> Floats:
    """Points (p, 3) at ``place`` along x (axis 0) or y (1), at ``side`` along the other."""
    other = np.full(len(place), side)
    level = np.broadcast_to(np.asarray(z, dtype=np.float64), (len(place),))
    return np.column_stack([place, other, level] if axis == 0 else [other, place, level])
