"""Interfaces during the search, each with its faces, gap, warp and angle."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, dot
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.ragged import Ragged, expand
from drystone.contacts import Contacts, check_friction
from drystone.detection.patches import Patches
from drystone.detection.planes import Pieces, Planes, gaps


@dataclass(frozen=True, eq=False)
class Interfaces(OneLine):
    """Polygons, lines and points between blocks.

    Letters: m interfaces, k corners.

    Attributes
    ----------
    block_a, block_b, face_a, face_b : (m,)
        Blocks (a < b) and the numbers of their (first) faces; -1 where the block touches with an
        edge or a corner.
    frame : (m, 3, 3) rows n, u, v; n from a to b
    point : (k, 3) [m]
    start : (m + 1,) corners of each
    area : (m,) [m2]
    gap : (m,) [m]
        Distance of the faces at the middle of the interface, negative where they overlap.
    warp : (m,) [m]
        Largest distance of a corner from the plane of its face, for both faces.
    angle : (m,) [deg]
        Between the two faces.
    clipped : (m,) bool
        Whether the faces are within tolerance on only a part of their common area.
    merged : (m,)
        Number of facets that the interface stands for.
    size : (m,) [m], of the smaller block
    """

    block_a: Ints
    block_b: Ints
    face_a: Ints
    face_b: Ints
    frame: Floats
    point: Floats
    start: Ints
    area: Floats
    gap: Floats
    warp: Floats
    angle: Floats
    clipped: Bools
    merged: Ints
    size: Floats

    def _summary(self) -> str:
        return counted(self.count, "interface")

    @property
    def count(self) -> int:
        """Number of interfaces, m."""
        return len(self.area)

    @property
    def kind(self) -> Ints:
        """(m,) 3 for an area, 2 for a line, 1 for a point."""
        return np.minimum(np.diff(self.start), 3)

    def flat(self) -> Floats:
        """Corners (k, 2) in (u, v) about the first corner of their interface."""
        owner = np.repeat(np.arange(self.count), np.diff(self.start))
        local = self.point - self.point[self.start[owner]]
        return np.einsum("kij,kj->ki", self.frame[owner, 1:], local)

    def take(self, order: Ints) -> Interfaces:
        """Some of the interfaces in a given order."""
        length = np.diff(self.start)[order]
        corner = expand(self.start[order], length)[1]
        values = {f.name: getattr(self, f.name)[order] for f in fields(self) if f.name not in _OWN}
        start = Ragged.from_counts(length).start
        return Interfaces(point=self.point[corner], start=start, **values)

    def ordered(self) -> Interfaces:
        """By blocks, then faces; pieces of one pair of faces keep their order."""
        return self.take(np.lexsort((self.face_b, self.face_a, self.block_b, self.block_a)))

    def contacts(self, origin: Floats, friction: float) -> Contacts:
        """Contacts in world coordinates; the points are relative to ``origin``."""
        owner = np.repeat(np.arange(self.count, dtype=np.intp), np.diff(self.start))
        return Contacts(
            self.block_a,
            self.block_b,
            self.frame,
            self.area,
            check_friction(friction, self.count),
            self.point + origin,
            owner,
        )


_OWN = ("point", "start")
"""Fields of :class:`Interfaces` with a row per corner instead of a row per interface."""


def joined(parts: list[Interfaces]) -> Interfaces:
    """Several lists of interfaces as one."""
    values = {
        f.name: np.concatenate([getattr(part, f.name) for part in parts])
        for f in fields(Interfaces)
        if f.name != "start"
    }
    length = np.concatenate([np.diff(part.start) for part in parts])
    start = Ragged.from_counts(length).start
    return Interfaces(start=start, **values)


def from_pieces(patches: Patches, planes: Planes, pieces: Pieces, clipped: Bools) -> Interfaces:
    """Interfaces of overlapping patches.

    Parameters
    ----------
    clipped : (q,) per plane
    """
    row = pieces.row
    f, g = planes.f[row], planes.g[row]
    of_corner = pieces.corner_row
    point = planes.origin[of_corner]
    for axis in (0, 1):
        point = point + pieces.corner[:, axis : axis + 1] * planes.frame[of_corner, axis + 1]
    return Interfaces(
        block_a=patches.owner[f],
        block_b=patches.owner[g],
        face_a=patches.face[f],
        face_b=patches.face[g],
        frame=planes.frame[row],
        point=point,
        start=pieces.start,
        area=pieces.area,
        gap=gaps(planes, pieces),
        warp=np.maximum(patches.warp[f], patches.warp[g]),
        angle=np.rad2deg(angles(patches, f, g)),
        clipped=clipped[row],
        merged=np.ones(len(row), dtype=np.intp),
        size=planes.size[row],
    )


def angles(patches: Patches, f: Ints, g: Ints) -> Floats:
    """Angle (q,) [rad] between facing patches, exact for small ones."""
    apart = patches.normal[f] + patches.normal[g]
    half = np.minimum(0.5 * np.sqrt(dot(apart, apart)), 1.0)
    return 2.0 * np.arcsin(half)
