"""Semicircular arches with radial joints.

Barrel vaults in staggered courses.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, marked
from drystone.models.simple import blocks_between, box, prism, require, welded
from drystone.models.walls import course_ends


def radial_joints(inner: float, outer: float, voussoirs: int) -> Floats:
    """Ends (voussoirs + 1, 2, 2) [m] of the joints of a semicircular arch about the origin.

    From the left foot to the right one; of each joint (x, z) on the intrados, then the extrados.
    """
    angle = np.pi * (1.0 - np.arange(voussoirs + 1) / voussoirs)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    ray[[0, -1], 1] = 0.0
    return np.stack([inner * ray, outer * ray], axis=1)


def arch(
    thickness_ratio: float = 0.15,
    voussoirs: int = 36,
    radius: float = 1.0,
    depth: float = 0.3,
) -> Assembly:
    """A semicircular arch with radial joints and a fixed block under each foot.

    Parameters
    ----------
    thickness_ratio : > 0, < 2
        Thickness over centre-line radius. Under self-weight the least that stands is 0.1075
        (Milankovitch 1907); published tilt limits at 0.15 are 8.2 degrees for a friction angle of
        43 degrees and 3.0 for 21.8 (Kao et al. 2022).
    voussoirs : >= 2
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
    half = 0.5 * thickness_ratio * radius
    joints = radial_joints(radius - half, radius + half, voussoirs)
    size = (2.0 * half, depth, 2.0 * half)
    y = (0.0, depth)
    blocks = blocks_between(joints, y)
    feet = [
        prism([*joint, (joint[1, 0], -size[2]), (joint[0, 0], -size[2])], y, f"springer-{side}")
        for joint, side in ((joints[0], "left"), (joints[-1], "right"))
    ]
    ordered = (feet[0], *blocks, feet[1])
    fixed = marked([0, -1], len(ordered))
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

    The buttresses are centred under the feet. With the defaults the least friction is 0.31 and the
    tilt limit about y 12 degrees (Whiting et al. 2009; Kao 2022).

    Parameters
    ----------
    inner_radius : [m]
        Of the intrados.
    thickness : [m]
        Of the arch, at most ``buttress_width``.
    depth : [m]
        Of the arch along y, at most ``buttress_depth``.
    voussoirs
        Number of them, two or more.
    buttress_width : [m]
        Along x.
    buttress_height : [m]
        From the ground to the springing.
    buttress_depth : [m]
        Along y.
    courses
        Blocks of each buttress, two or more; the lowest is fixed.
    density : [kg/m3]
        Of all blocks.

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
    blocks += blocks_between(joints, (-0.5 * depth, 0.5 * depth))
    fixed = marked([0, courses], len(blocks))
    return Assembly(tuple(blocks), fixed).with_density(density)


def barrel_vault(
    radius: float = 2.0,
    thickness: float = 0.3,
    length: float = 4.0,
    courses: int = 15,
    blocks: int = 6,
    *,
    staggered: bool = True,
) -> Assembly:
    """A semicircular barrel vault along y with radial bed joints; both lowest courses are fixed.

    Parameters
    ----------
    radius : [m]
        Of the middle surface.
    thickness, length : [m]
    courses : >= 3
        From springing to springing, the two fixed ones included.
    blocks : >= 1
        Block lengths per course.
    staggered
        Every other course is shifted by half a block, with half blocks at its ends.

    Returns
    -------
    Assembly
        ``c00-b00`` along y, course by course from left to right.
    """
    require(0.0 < thickness < 2.0 * radius, f"a thickness of {thickness} m", "0 to twice radius")
    joints = radial_joints(radius - 0.5 * thickness, radius + 0.5 * thickness, courses)
    return _in_courses(joints, 0.5 * length, 0.0, blocks, staggered)


def vault(
    span: float = 5.0,
    rise: float = 2.6,
    thickness: float = 0.28,
    length: float = 4.4,
    courses: int = 15,
    blocks: int = 6,
    flare: float = 0.25,
) -> Assembly:
    """A catenary vault in running bond whose ends lean inwards; both lowest courses are fixed.

    Its middle line is a catenary, so that its own weight presses along it. It is the model of
    ``drystone demo`` and stands at a friction coefficient of 0.6.

    Parameters
    ----------
    span, rise : [m] > 0
        Of the middle line.
    thickness : [m] > 0
        Normal to the middle line.
    length : [m] > 0
        Along y at the springings.
    courses : >= 3
        Of equal length along the middle line, from springing to springing.
    blocks : >= 1
        Block lengths per course.
    flare
        By how much each half of the vault is shorter per metre of height. The head joints fan out.

    Returns
    -------
    Assembly
        ``c00-b00`` along y, course by course from left to right.
    """
    require(flare * (rise + thickness) < 0.5 * length, "the ends meet", "reduce the flare")
    joints = _catenary_joints(span, rise, thickness, courses)
    return _in_courses(joints, 0.5 * length, -flare, blocks, True)


def _catenary_joints(span: float, rise: float, thickness: float, courses: int) -> Floats:
    """Joints (courses + 1, 2, 2) normal to z = rise - a (cosh(x / a) - 1), at equal arc length.

    The parameter a follows from the rise at half the span by Newton's method on
    a (cosh(s / a) - 1) = rise, in w = s / a; arc length is a sinh(x / a).
    """
    half = 0.5 * span
    w = 2.0 * np.arcsinh(rise / half)  # cosh(w) - 1 = w rise / half has its root below
    for _ in range(60):
        w -= (np.cosh(w) - 1.0 - w * rise / half) / (np.sinh(w) - rise / half)
    a = half / w
    arc = np.linspace(-np.sinh(w), np.sinh(w), courses + 1)
    x = a * np.arcsinh(arc)
    z = rise - a * (np.cosh(x / a) - 1.0)
    outward = np.column_stack([arc, np.ones(courses + 1)])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    middle = np.column_stack([x, z])
    return np.stack([middle - 0.5 * thickness * outward, middle + 0.5 * thickness * outward], 1)


def _in_courses(joints: Floats, half: float, lean: float, blocks: int, staggered: bool) -> Assembly:
    """Courses between joints (c + 1, 2, 2), cut by head joints y = s (half + lean z), s in -1..1.

    Such cuts are planes, every bed is the plane of its joint, and both curved sides are spanned by
    lines along y: all faces are exactly planar.
    """
    count = len(joints) - 1
    made: list[Block] = []
    fixed: list[bool] = []
    for course, (a, b) in enumerate(pairwise(joints)):
        section = np.array([a[0], a[1], b[1], b[0]])
        shifted = staggered and course % 2 == 1
        cuts = [2.0 * s / blocks - 1.0 for s in course_ends(blocks, shifted, "running")]
        for i, (near, far) in enumerate(pairwise(cuts)):
            reach = half + lean * section[:, 1]
            ends = [np.insert(section, 1, s * reach, axis=1) for s in (near, far)]
            sides = [
                np.array([ends[0][j], ends[0][j - 1], ends[1][j - 1], ends[1][j]]) for j in range(4)
            ]
            made.append(welded([*ends, *sides], f"c{course:02d}-b{i:02d}"))
            fixed.append(course in (0, count - 1))
    return Assembly(tuple(made), np.array(fixed))
