"""Masonry bridges: rings of voussoirs of any profile over one span or several, on piers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.profiles import Measured, Shape, joints_of
from drystone.models.simple import box
from drystone.models.solids import prism, require


def segmental_bridge(
    span: float = 6.0,
    rise: float = 1.5,
    ring: float = 0.45,
    voussoirs: int = 30,
    width: float = 1.0,
    *,
    profile: Shape | Measured = "segmental",
    rings: int = 1,
    spans: int = 1,
    pier: float = 1.2,
    abutment: float = 2.0,
    height: float = 0.0,
    courses: int = 4,
    backing: float = 0.0,
) -> Assembly:
    """The arches of a masonry bridge along x, with their piers and abutments.

    Fill and traffic are loads: see ``--load fill:...`` and ``drystone limit train``.

    Parameters
    ----------
    span, rise : [m]
        Of the intrados; those of ``profile`` where it has points.
    ring : [m]
        Thickness of a ring, square to the intrados.
    voussoirs
        Of each ring; plane-faced, with joints at equal distances along the intrados.
    width : [m]
        Along y.
    profile
        Of the intrados: ``segmental``, ``pointed`` (an even number of voussoirs has a joint at the
        apex), ``elliptic``, ``three-centred`` (arcs of 60 degrees each), the polyline of a .dxf, a
        .csv of x and z, or points such as ``0,0 3,1.5 6,0`` [m].
    rings
        Rings, or rolls, one on top of the other, with joints between them.
    spans
        Equal ones.
    pier, abutment : [m]
        Widths at the springing.
    height : [m]
        Of piers and abutments below the springing, which then stand free on a fixed course. At zero
        the springers and the heads of the piers are fixed.
    courses
        Of each pier and abutment.
    backing : [m]
        Height of solid masonry above the foot of the extrados, from each haunch to the back of its
        abutment, of one span; none at zero.

    Returns
    -------
    Assembly
        From left to right: ``springer-left``, ``voussoir-00`` ..., ``pier-1`` ...,
        ``springer-right``; then ``backing-left`` and ``backing-right``. Supports of several courses
        upwards from ``springer-left-ground``. With several spans or rings the voussoirs begin with
        ``span-1-`` or ``ring-1-``.

    Examples
    --------
    >>> bridge = segmental_bridge(voussoirs=3)
    >>> bridge.names
    ('springer-left', 'voussoir-00', 'voussoir-01', 'voussoir-02', 'springer-right')
    """
    require(voussoirs > 1, f"a ring of {voussoirs} voussoirs", "give two or more")
    require(rings > 0 and spans > 0, f"{rings} rings, {spans} spans", "give one or more")
    require(ring > 0.0 and width > 0.0, f"a ring of {ring} m, {width} m wide", "above zero")
    require(height >= 0.0, f"a height of {height} m", "give zero or more")
    require(courses > 1, f"{courses} courses", "give two or more")
    foot = joints_of(profile, span, rise, voussoirs)
    joints = foot[:, :1] + ring * np.arange(rings + 1)[:, None] * foot[:, 1:]  # (j, rings + 1, 2)
    _require_simple(joints)
    depth = (0.0, width)
    beyond = abs(joints[0, -1, 0] - joints[0, 0, 0])
    clear = spans == 1 or pier > 2.0 * beyond
    require(clear, "the rings meet over a pier", f"make it wider than {2.0 * beyond:.3g} m")
    held = not (height or backing) or abutment > beyond
    require(held, "an abutment is too narrow", f"make it wider than {beyond:.3g} m")
    level = joints[[0, -1], 0, 1]
    level_feet = spans == 1 or bool(np.ptp(level) < 1e-9 * beyond)
    require(level_feet, "the feet of the profile are not level", "give one span")
    apart = joints[-1, 0, 0] - joints[0, 0, 0] + pier
    low = -max(float(joints[0, -1, 1]), rings * ring)
    wide = abutment if height or backing else beyond
    ends = [np.array([joints[0, 0], joints[0, -1]]), np.array([joints[-1, -1], joints[-1, 0]])]
    blocks, fixed = _support(
        "springer-left", _abutment(ends[0], -wide), height, courses, depth, low
    )
    for i in range(spans):
        moved = joints + np.array([i * apart, 0.0])
        start = f"span-{i + 1}-" if spans > 1 else ""
        for k in range(rings):
            name = f"{start}ring-{k + 1}-" if rings > 1 else start
            blocks += [
                prism([a[k], a[k + 1], b[k + 1], b[k]], depth, f"{name}voussoir-{j:02d}")
                for j, (a, b) in enumerate(pairwise(moved))
            ]
        fixed += [False] * (rings * voussoirs)
        if i < spans - 1:
            left, right = moved[-1], moved[0] + np.array([apart, 0.0])
            top = np.array([left[0], left[-1], right[-1], right[0]])
            made = _support(f"pier-{i + 1}", top, height, courses, depth, low)
        else:
            top = _abutment(ends[1] + np.array([i * apart, 0.0]), wide)
            made = _support("springer-right", top, height, courses, depth, low)
        blocks += made[0]
        fixed += made[1]
    if backing:
        require(spans == 1, f"backing of {spans} spans", "give one span")
        outer = joints[:, -1]
        for side, line, back in (
            ("left", outer, joints[0, 0, 0] - wide),
            ("right", outer[::-1], joints[-1, 0, 0] + wide),
        ):
            blocks.append(prism(_backing(line, back, backing), depth, f"backing-{side}"))
            fixed.append(False)
    return Assembly(tuple(blocks), np.array(fixed))


def _backing(line: Floats, back: float, height: float) -> list[tuple[float, float]]:
    """Outline of backing on an extrados (p, 2) from its foot up, to a back at a place along x."""
    crown = int(line[:, 1].argmax())
    level = line[0, 1] + height
    require(0.0 < height < line[crown, 1] - line[0, 1], f"backing of {height} m", "below the crown")
    below = line[: int((line[: crown + 1, 1] < level).sum())]
    beyond = line[len(below)]
    share = (level - below[-1, 1]) / (beyond[1] - below[-1, 1])
    top = below[-1] + share * (beyond - below[-1])
    outline = [*below.tolist(), top.tolist(), [back, level], [back, float(line[0, 1])]]
    turned = outline if back < line[0, 0] else outline[::-1]
    return [(x, z) for x, z in turned]


def _require_simple(joints: Floats) -> None:
    """Refuse joints (j, r, 2) that cross."""
    side = np.diff(joints, axis=0)
    across = joints[:-1, -1] - joints[:-1, 0]
    area = side[..., 0] * across[:, None, 1] - side[..., 1] * across[:, None, 0]
    require(bool((area > 0.0).all()), "joints cross in the ring", "a thinner ring, fewer voussoirs")


def _abutment(joint: Floats, way: float) -> Floats:
    """Upper outline (4 or 3, 2) of an abutment behind a joint (2, 2); ``way`` [m] along x."""
    outer = joint[1] if way < 0.0 else joint[0]
    inner = joint[0] if way < 0.0 else joint[1]
    back = np.array([inner[0] + way, outer[1]])
    far = [] if abs(back[0] - outer[0]) < 1e-9 * abs(way) else [back]
    outline = [inner, outer, *far]
    return np.array(outline[::-1] if way < 0.0 else [*far[::-1], outer, inner][::-1])


def _support(
    name: str, top: Floats, height: float, courses: int, depth: tuple[float, float], low: float
) -> tuple[list[Block], list[bool]]:
    """A support below an upper outline (p, 2) from left to right, upwards, and which are fixed."""
    left, right = float(top[:, 0].min()), float(top[:, 0].max())
    step = height / courses
    under = float(min(top[0, 1], top[-1, 1])) - step if height else low
    head = prism(
        [*top, (right, under), (left, under)], depth, name if not height else f"{name}-top"
    )
    if not height:
        return [head], [True]
    size = (right - left, depth[1] - depth[0], step)
    below = [
        box(size, (left, depth[0], under - (courses - k) * step), f"{name}-{k or 'ground'}")
        for k in range(courses)
    ]
    return [*below, head], [True] + [False] * courses
