"""Masonry bridges: rings of voussoirs of any intrados over one span or several, on piers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Self, TypeAlias

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.files import read_bytes
from drystone.base.units import scale_of
from drystone.io.dxf import read_polyline
from drystone.models.simple import blocks_between, box, prism, require

_WIDEST = 200.0
"""[m]: no arch of stone spans as much."""


def segmental_bridge(
    span: float | None = None,
    rise: float | None = None,
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
        Of the intrados, 6 and 1.5 when left out; not with a ``profile`` of points, which has both.
    ring : [m] > 0
        Thickness of a ring, square to the intrados.
    voussoirs : >= 2
        Of each ring; plane-faced, with joints at equal distances along the intrados.
    width : [m] > 0
        Along y.
    profile
        Of the intrados: ``segmental``, ``pointed`` (an even number of voussoirs has a joint at the
        apex), ``elliptic``, ``three-centred`` (arcs of 60 degrees each), the polyline of a .dxf, a
        .csv of x and z, or points such as ``0,0 3,1.5 6,0`` [m].
    rings : >= 1
        Rings, or rolls, one on top of the other, with joints between them.
    spans : >= 1
        Equal ones.
    pier, abutment : [m]
        Widths at the springing.
    height : [m] >= 0
        Of piers and abutments below the springing, which then stand free on a fixed course. At zero
        the springers and the heads of the piers are fixed.
    courses : >= 2
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
    own = (span is None and rise is None) or not isinstance(profile, Measured)
    require(own, "span and rise are those of the profile's points", "leave them out")
    foot = joints_of(
        profile, 6.0 if span is None else span, 1.5 if rise is None else rise, voussoirs
    )
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
            blocks += blocks_between(moved[:, k : k + 2], depth, name + "voussoir-{:02d}")
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


Shape: TypeAlias = Literal["segmental", "pointed", "elliptic", "three-centred"]
_Arc: TypeAlias = tuple[tuple[float, float], float, float, float]
"""Centre (x, z) [m], radius [m], first and last angle [rad] from x."""


@dataclass(frozen=True, eq=False)
class Measured(OneLine):
    """An intrados by its points, from the left foot to the right one.

    Attributes
    ----------
    point : (p, 2) [m]
        x and z.
    """

    point: Floats

    def __post_init__(self) -> None:
        given = frozen_floats(self.point, (None, 2), "points of the intrados")
        require(len(given) > 2, counted(len(given), "point"), "give three or more, x and z")
        back = np.flatnonzero(np.diff(given[:, 0]) <= 0.0)[:1]
        words = [f"{given[i, 0]:g} in row {i + 1}, {given[i + 1, 0]:g} in the next" for i in back]
        require(not words, f"its x does not grow: {' '.join(words)}", "give it from left to right")
        span = float(given[-1, 0] - given[0, 0])
        require(
            span <= _WIDEST, f"it spans {span:g} m",
            "give metres, or the unit: x [mm], z [mm] above the columns of a CSV, or that of a DXF",
        )  # fmt: skip
        object.__setattr__(self, "point", given)

    @classmethod
    def named(cls, text: str) -> Self:
        """From ``X,Z X,Z ...`` [m], or a file: the polyline of a DXF, or two columns of a CSV.

        Raises
        ------
        InputError
            It is none of these.
        """
        path = Path(text)
        if path.suffix.lower() == ".dxf":
            found = read_polyline(read_bytes(path), path)
            return cls(found if found[0, 0] < found[-1, 0] else found[::-1])
        lines, scale = text.split(), [1.0]
        if path.suffix.lower() in (".csv", ".txt"):
            lines = read_bytes(path).decode("utf-8-sig", "replace").replace(";", ",").split("\n")
            lines = [line for line in lines if line.strip()]
            header = lines[0] if lines and not any(map(str.isdigit, lines[0])) else ""
            lines = lines[bool(header) :]
            scale = [scale_of(one) for one in re.findall(r"\[\s*(\w+)\s*\]", header)][:2] or scale
        point = []
        for line in lines:
            try:
                x, z = map(float, line.split(","))
            except ValueError as error:
                raise InputError(
                    f"'{text[:40]}' is no profile: '{line.strip()[:40]}' is not X,Z",
                    remedy="write segmental, pointed, elliptic, three-centred, a .dxf or .csv, "
                    "or points '0,0 3,1.5 6,0'",
                ) from error
            point.append((x, z))
        return cls(np.array(point).reshape(-1, 2) * scale)

    def _summary(self) -> str:
        return counted(len(self.point), "point")


def joints_of(profile: Shape | Measured, span: float, rise: float, count: int) -> Floats:
    """Feet of the joints on the intrados, and their directions (count + 1, 2, 2).

    They are equally far apart along the intrados, from the left springing at the origin. Directions
    are as long as joints of a ring of 1 m: more than 1 at an apex, which is mitred.

    Parameters
    ----------
    profile
    span, rise : [m]
        Of measured points not used.
    count
        Voussoirs.

    Examples
    --------
    >>> joints_of("segmental", 2.0, 1.0, 2)[1].round(3).tolist()
    [[1.0, 1.0], [0.0, 1.0]]
    """
    if isinstance(profile, Measured):
        return _along_points(profile.point, count)
    require(span > 0.0 and rise > 0.0, f"a span of {span} m, a rise of {rise} m", "above zero")
    if profile == "elliptic":
        return _along_ellipse(0.5 * span, rise, count)
    return _along_arcs(_arcs_of(profile, span, rise), count)


def _arcs_of(profile: Shape, span: float, rise: float) -> Sequence[_Arc]:
    half = 0.5 * span
    if profile == "pointed":
        require(rise >= half, "its arcs would begin inclined", "a rise of half the span or more")
        radius = (rise**2 + half**2) / span
        left = (radius, 0.0), radius, np.pi, float(np.pi - np.arctan2(rise, radius - half))
        return left, ((span - radius, 0.0), radius, float(np.pi - left[3]), 0.0)
    if profile == "three-centred":
        least = (2.0 - np.sqrt(3.0)) * half
        require(least < rise < half, "no such arcs", f"a rise from {least:.3g} to {half:.3g} m")
        small = (rise - least) / (np.sqrt(3.0) - 1.0)
        large = span - small
        third = np.pi / 3.0
        return (
            ((small, 0.0), small, np.pi, 2.0 * third),
            ((half, rise - large), large, 2.0 * third, third),
            ((span - small, 0.0), small, third, 0.0),
        )
    require(rise <= half, "more than a semicircle", "a rise of half the span at most")
    radius = (half**2 + rise**2) / (2.0 * rise)
    first = float(np.arctan2(radius - rise, half))
    return (((half, rise - radius), radius, np.pi - first, first),)


def _along_arcs(arcs: Sequence[_Arc], count: int) -> Floats:
    length = np.array([radius * (first - last) for _, radius, first, last in arcs])
    end = np.cumsum(length)
    found = np.empty((count + 1, 2, 2))
    near = 1e-9 * float(end[-1])
    for i, at in enumerate(np.linspace(0.0, float(end[-1]), count + 1).tolist()):
        here = np.flatnonzero((at >= end - length - near) & (at <= end + near))
        rays = []
        for one in here.tolist():  # two where arcs meet: the joint is a mitre between them
            centre, radius, first, _ = arcs[one]
            angle = first - (at - (end - length)[one]) / radius
            rays.append((np.cos(angle), np.sin(angle)))
            found[i, 0] = np.array(centre) + radius * np.array(rays[-1])
        ray = np.mean(rays, axis=0)
        found[i, 1] = ray / (ray @ ray)
    found[[0, -1], 0, 1] = 0.0
    return found


def _along_ellipse(half: float, rise: float, count: int) -> Floats:
    fine = np.linspace(np.pi, 0.0, 200 * count + 1)
    step = np.hypot(half * np.diff(np.cos(fine)), rise * np.diff(np.sin(fine)))
    at = np.concatenate([[0.0], np.cumsum(step)])
    angle = np.interp(np.linspace(0.0, at[-1], count + 1), at, fine)
    foot = np.stack([half + half * np.cos(angle), rise * np.sin(angle)], axis=1)
    ray = np.stack([rise * np.cos(angle), half * np.sin(angle)], axis=1)
    foot[[0, -1], 1], ray[[0, -1], 1] = 0.0, 0.0
    return np.stack([foot, ray / np.linalg.norm(ray, axis=1)[:, None]], axis=1)


def _along_points(point: Floats, count: int) -> Floats:
    """Of points (p, 2); a joint is normal to the line between its neighbours."""
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(point, axis=0), axis=1))])
    where = np.linspace(0.0, at[-1], count + 1)
    foot = np.stack([np.interp(where, at, one) for one in (point - point[0]).T], axis=1)
    along = np.gradient(foot, axis=0)
    ray = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return np.stack([foot, ray / np.linalg.norm(ray, axis=1)[:, None]], axis=1)
