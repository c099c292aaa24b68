"""Intrados of arches: arcs of circles, half an ellipse, or points that were measured or drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Self, TypeAlias

import numpy as np

from drystone.base.arrays import Floats, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.files import read_bytes
from drystone.io.dxf import read_polyline
from drystone.models.solids import require

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
        require(bool((np.diff(given[:, 0]) > 0.0).all()), "its x does not grow", "left to right")
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
        lines = text.split()
        if path.suffix.lower() in (".csv", ".txt"):
            lines = read_bytes(path).decode("utf-8", "replace").replace(";", ",").split()
        try:
            return cls(np.array([[float(one) for one in line.split(",")] for line in lines]))
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            raise InputError(
                f"'{text[:40]}' is no profile",
                remedy="write segmental, pointed, elliptic, three-centred, a .dxf or .csv, "
                "or points '0,0 3,1.5 6,0'",
            ) from error

    def _summary(self) -> str:
        return counted(len(self.point), "point")


def joints_of(profile: Shape | Measured, span: float, rise: float, count: int) -> Floats:
    """Feet of the joints on the intrados, and their directions (count + 1, 2, 2).

    They are equally far apart along the intrados, from the left springing at the origin.

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
        for one in here.tolist():  # two where arcs meet: the joint halves the angle between them
            centre, radius, first, _ = arcs[one]
            angle = first - (at - (end - length)[one]) / radius
            rays.append((np.cos(angle), np.sin(angle)))
            found[i, 0] = np.array(centre) + radius * np.array(rays[-1])
        ray = np.mean(rays, axis=0)
        found[i, 1] = ray / np.linalg.norm(ray)
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
