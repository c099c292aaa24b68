"""Curved joints as the few plane pieces that their curvature needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import marked
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.detection.interfaces import Interfaces, joined
from drystone.detection.tolerances import millimetres
from drystone.geometry import facets
from drystone.geometry.frames import area_vectors, frames_from_normals

FEW = 1000
"""Corners of facets up to which all facets stay. Chosen: the answer takes no time then, and
published models of two and three curved blocks are as published."""


@dataclass(frozen=True)
class Resampled(OneLine):
    """The curved joints of two blocks, which fewer plane pieces stand for.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    facets, pieces, points
        Number of plane interfaces before and after, and of their corners.
    turn : [deg]
        Largest angle between a facet and its piece, slivers aside.
    moved : [m]
        Largest distance of the corners of a facet from the plane of its piece.
    """

    block_a: int
    block_b: int
    facets: int
    pieces: int
    points: int
    turn: float
    moved: float


def resample(found: Interfaces, angle: float) -> tuple[Interfaces, tuple[Resampled, ...]]:
    """The interfaces with pieces of curved joints in place of facets, and what was changed.

    Gap, warp and angle of a piece are the mean and the worst of its facets.

    Parameters
    ----------
    angle : [deg]
        Largest angle between facets and the mean of their piece. With zero all facets stay, and so
        they do where they have few corners. Slivers are joined to their neighbours always.
    """
    if found.count < 2:
        return found, ()
    pair = found.block_a * (int(found.block_b.max()) + 1) + found.block_b
    plane = np.diff(found.start) > 2
    _, place, count = np.unique(pair[plane], return_inverse=True, return_counts=True)
    some = np.flatnonzero(plane)[count[place.ravel()] > 1]
    if len(some) == 0:
        return found, ()
    given = found.take(some)
    within = np.deg2rad(angle) if len(given.point) > FEW else 0.0
    made = facets.joined(given.point, given.start, pair[some], within)
    if made is None:
        return found, ()
    new = _pieces(given, made)
    left = ~marked(some, found.count)
    told = _told(given, new, made)
    return joined([found.take(np.flatnonzero(left)), new]).ordered(), told


def _pieces(given: Interfaces, made: facets.JoinedFacets) -> Interfaces:
    rows, facet = made.facets, made.facet
    weight = given.area[facet]
    largest = np.lexsort((facet, -weight, rows.owner))[rows.first]
    first = facet[largest]
    alone = rows.counts == 1
    frame = frames_from_normals(made.normal)
    frame[alone] = given.frame[first[alone]]
    area = np.linalg.norm(area_vectors(made.point, made.start), axis=1)
    area[alone] = given.area[first[alone]]
    mean = rows.sum(weight * given.gap[facet]) / rows.sum(weight)
    return replace(
        given.take(first),
        frame=frame,
        point=made.point,
        start=made.start,
        area=area,
        gap=np.where(alone, given.gap[first], mean),
        warp=rows.max(given.warp[facet]),
        angle=rows.max(given.angle[facet]),
        clipped=rows.any(given.clipped[facet]),
        merged=rows.counts,
    )


def _told(given: Interfaces, new: Interfaces, made: facets.JoinedFacets) -> tuple[Resampled, ...]:
    """A line for each pair of blocks with fewer interfaces than before."""
    count = int(given.block_b.max()) + 1
    before, of_facet = np.unique(given.block_a * count + given.block_b, return_inverse=True)
    of_piece = np.searchsorted(before, new.block_a * count + new.block_b)
    many, few = np.bincount(of_facet.ravel()), np.bincount(of_piece)
    points = np.bincount(of_piece, np.diff(new.start)).astype(np.intp)
    turn, moved = np.zeros(len(before)), np.zeros(len(before))
    np.maximum.at(turn, of_piece, np.rad2deg(made.turn))
    np.maximum.at(moved, of_piece, made.moved)
    columns = (*np.divmod(before, count), many, few, points, turn, moved)
    rows = zip(*(column[few < many].tolist() for column in columns), strict=True)
    return tuple(Resampled(*row) for row in rows)


def resampled_lines(resampled: Sequence[Resampled]) -> list[str]:
    """A sentence that says how many pieces stand for facets, and how well."""
    if not resampled:
        return []
    pairs = counted(len(resampled), "pair")
    facets, pieces, points = (
        f"{sum(getattr(each, name) for each in resampled):,}"
        for name in ("facets", "pieces", "points")
    )
    turn = max(each.turn for each in resampled)
    moved = millimetres(max(each.moved for each in resampled))
    return [
        f"{facets} facets of the curved joints of {pairs} are taken as {pieces} plane pieces with"
        f" {points} corners: turned by up to {turn:.2g} degrees, and up to {moved} mm off"
    ]
