"""Semicircular arches with radial joints."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.simple import box
from drystone.models.solids import prism, require


def radial_joints(inner: float, outer: float, voussoirs: int) -> Floats:
    """Ends (voussoirs + 1, 2, 2) [m] of the joints of a semicircular arch about the origin.

    From the left foot to the right one; of each joint (x, z) on the intrados, then the extrados.
    """
    angle = np.pi * (1.0 - np.arange(voussoirs + 1) / voussoirs)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    ray[[0, -1], 1] = 0.0
    return np.stack([inner * ray, outer * ray], axis=1)


def voussoirs_between(joints: Floats, depth: tuple[float, float]) -> list[Block]:
    """A voussoir between each two successive joints (j, 2, 2), as prisms along y."""
    return [
        prism([a[0], a[1], b[1], b[0]], depth, f"voussoir-{i:02d}")
        for i, (a, b) in enumerate(pairwise(joints))
    ]


def arch(
    thickness_ratio: float = 0.15,
    voussoirs: int = 36,
    radius: float = 1.0,
    depth: float = 0.3,
) -> Assembly:
    """A semicircular arch with radial joints and a fixed block under each foot.

    Parameters
    ----------
    thickness_ratio
        Thickness over centre-line radius. Under self-weight the least that stands is 0.1075
        (Milankovitch 1907); published tilt limits at 0.15 are 8.2 degrees for a friction angle of
        43 degrees and 3.0 for 21.8 (Kao et al. 2022).
    voussoirs
        Free blocks, plane-faced: corners lie on the two circles.
    radius : [m]
        Of the centre line.
    depth : [m]
        Along y.

    Returns
    -------
    Assembly
        ``springer-left``, ``voussoir-00`` from left to right, ``springer-right``.
    """
    require(0.0 < thickness_ratio < 2.0, "the arch has no opening", "thickness / radius below 2")
    require(voussoirs > 1, f"an arch of {voussoirs} voussoirs", "give two or more")
    half = 0.5 * thickness_ratio * radius
    joints = radial_joints(radius - half, radius + half, voussoirs)
    size = (2.0 * half, depth, 2.0 * half)
    y = (0.0, depth)
    blocks = voussoirs_between(joints, y)
    feet = [
        prism([*joint, (joint[1, 0], -size[2]), (joint[0, 0], -size[2])], y, f"springer-{side}")
        for joint, side in ((joints[0], "left"), (joints[-1], "right"))
    ]
    ordered = (feet[0], *blocks, feet[1])
    fixed = np.zeros(len(ordered), dtype=bool)
    fixed[[0, -1]] = True
    return Assembly(ordered, fixed)


def buttressed_arch(
    inner_radius: float = 1.0,
    thickness: float = 0.3,
    depth: float = 0.5,
    voussoirs: int = 15,
    buttress_width: float = 0.7,
    buttress_height: float = 2.5,
    buttress_depth: float = 1.0,
    courses: int = 6,
    density: float = 1800.0,
) -> Assembly:
    """A semicircular arch on two free-standing buttresses, the lowest block of each fixed.

    Lengths in m, density in kg/m3. The buttresses are centred under the feet. With the defaults the
    least friction is 0.31 and the tilt limit about y 12 degrees (Whiting et al. 2009; Kao 2022).

    Returns
    -------
    Assembly
        ``left-0`` upwards, ``right-0`` upwards, then ``voussoir-00`` from left to right.
    """
    require(
        0.0 < thickness <= buttress_width and 0.0 < depth <= buttress_depth,
        "the arch is wider than its buttresses",
        "make the buttresses wider",
    )
    require(courses > 1 and voussoirs > 1, "too few blocks", "give two courses and voussoirs")
    outer = inner_radius + thickness
    joints = radial_joints(inner_radius, outer, voussoirs)
    joints = joints + np.array([0.0, buttress_height])
    middle = 0.5 * (inner_radius + outer)
    level = buttress_height * np.arange(courses + 1) / courses
    blocks: list[Block] = []
    for side, x in (("left", -middle), ("right", middle)):
        blocks += [
            box(
                (buttress_width, buttress_depth, level[i + 1] - level[i]),
                (x - 0.5 * buttress_width, -0.5 * buttress_depth, level[i]),
                f"{side}-{i}",
            )
            for i in range(courses)
        ]
    blocks += voussoirs_between(joints, (-0.5 * depth, 0.5 * depth))
    fixed = np.zeros(len(blocks), dtype=bool)
    fixed[[0, courses]] = True
    return Assembly(tuple(blocks), fixed).with_density(density)
