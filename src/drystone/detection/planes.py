"""Planes between facing patches, polygons in them, and which of several in front is nearest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from drystone.base.arrays import SAME, Bools, Floats, Ints, dot, marked
from drystone.base.ragged import Ragged, expand
from drystone.detection.patches import EXACT, Patches
from drystone.geometry import clip, planar
from drystone.geometry.frames import frames_from_normals


@dataclass(frozen=True)
class Planes:
    """The planes halfway between pairs of patches, and the distances of the patches.

    Letters: q pairs. The plane bisects the angle between the patches, so both are equally far from
    it.

    Attributes
    ----------
    f, g : (q,) patches
    frame : (q, 3, 3) rows n, u, v; n from f to g
    origin : (q, 3) [m] a point of the plane, where (u, v) is (0, 0)
    gap : (q,) [m] distance of the patches at the origin along n, negative where they overlap
    slope : (q, 2) its change per metre along u and v
    size : (q,) [m], of the smaller block
    """

    f: Ints
    g: Ints
    frame: Floats
    origin: Floats
    gap: Floats
    slope: Floats
    size: Floats

    def flat(self, points: Floats, row: Ints) -> Floats:
        """Points (l, 3) in the (u, v) of their row's plane."""
        local = points - self.origin[row]
        return np.stack([dot(local, self.frame[row, i]) for i in (1, 2)], axis=1)

    def gap_at(self, flat: Floats, row: Ints) -> Floats:
        """Distance [m] of the patches at points (l, 2) of their plane."""
        return self.gap[row] + dot(self.slope[row], flat)


@dataclass(frozen=True)
class Pieces:
    """Simple polygons in planes, flat corners.

    Attributes
    ----------
    corner : (l, 2) [m] counter-clockwise about n
    start : (s + 1,)
    row : (s,) plane of each, ascending
    """

    corner: Floats
    start: Ints
    row: Ints

    @property
    def count(self) -> int:
        """Number of polygons."""
        return len(self.row)

    @property
    def corner_row(self) -> Ints:
        """(l,) plane of each corner."""
        return np.repeat(self.row, np.diff(self.start))

    @cached_property
    def area(self) -> Floats:
        """(s,) [m2], positive counter-clockwise."""
        return clip.areas(self.corner, self.start)

    @cached_property
    def width(self) -> Floats:
        """(s,) [m], twice the area over the perimeter: the width of a long rectangle."""
        around = clip.perimeters(self.corner, self.start)
        return 2.0 * self.area / np.where(around > 0, around, 1)

    def select(self, keep: Bools) -> Pieces:
        """Some of the polygons."""
        if keep.all():
            return self
        length = np.diff(self.start)
        start = Ragged.from_counts(length[keep]).start
        return Pieces(self.corner[np.repeat(keep, length)], start, self.row[keep])


def planes_between(patches: Patches, f: Ints, g: Ints) -> Planes:
    """Planes of pairs of patches that face each other."""
    normal_f, normal_g = patches.normal[f], patches.normal[g]
    normal = normal_f - normal_g
    normal /= np.sqrt(dot(normal, normal))[:, None]
    frame = frames_from_normals(normal)
    size = np.minimum(patches.size[patches.owner[f]], patches.size[patches.owner[g]])
    smaller = np.where(patches.area[f] <= patches.area[g], f, g)
    origin = patches.centre[smaller]
    height, slope = [], []
    for patch, own in ((f, normal_f), (g, normal_g)):
        rise = dot(own, normal)
        height.append(dot(patches.centre[patch] - origin, own) / rise)
        slope.append(-np.einsum("qj,qij->qi", own, frame[:, 1:]) / rise[:, None])
    origin = origin + (0.5 * (height[0] + height[1]))[:, None] * normal
    return Planes(f, g, frame, origin, height[1] - height[0], slope[1] - slope[0], size)


def merged(parts: list[Pieces]) -> Pieces:
    """Pieces of several lists, by row."""
    parts = [part for part in parts if part.count]
    if not parts:
        return Pieces(np.zeros((0, 2)), np.zeros(1, dtype=np.intp), np.zeros(0, dtype=np.intp))
    row = np.concatenate([part.row for part in parts])
    length = np.concatenate([np.diff(part.start) for part in parts])
    corner = np.concatenate([part.corner for part in parts])
    begin = np.cumsum(length) - length
    order = np.argsort(row, kind="stable")
    picked = expand(begin[order], length[order])[1]
    start = Ragged.from_counts(length[order]).start
    return Pieces(corner[picked], start, row[order])


def tidy(pieces: Pieces, planes: Planes) -> Pieces:
    """The polygons without corners on straight lines, and without polygons of zero width."""
    size = planes.size[pieces.row]
    corner, start = clip.cleaned(pieces.corner, pieces.start, SAME * size)
    filled = np.diff(start) > 0
    result = Pieces(corner, start[np.concatenate([[True], filled])], pieces.row[filled])
    return result.select(result.width > SAME * planes.size[result.row])


NEGLIGIBLE = 0.02
"""Overlaps narrower than this share of another of the same patch and blocks are noise, and missed
ones, and parts of a joint, below it are not reported. Chosen: areas are kept to 2 %."""
_BEHIND = 0.01
"""An interface is cut where another lies in front of it, if their common area is wider than this
share of the block size. Chosen: above the overlap of neighbouring strips on a curve."""


def uncovered(patches: Patches, planes: Planes, pieces: Pieces) -> tuple[Pieces, Bools]:
    """Pieces without the parts behind a nearer piece on the same patch.

    Returns
    -------
    pieces
    hidden : (q,) planes with a removed part
    """
    hidden = np.zeros(len(planes.f), dtype=bool)
    gap = np.abs(gaps(planes, pieces))
    loose = gap > EXACT * planes.size[pieces.row]
    if not loose.any():
        return pieces, hidden
    behind, front = _sharing(planes, pieces, loose, gap)
    blocks = np.sort(np.stack([patches.owner[planes.f], patches.owner[planes.g]], axis=1), axis=1)
    other = (blocks[pieces.row[behind]] != blocks[pieces.row[front]]).any(axis=1)
    behind, front = behind[other], front[other]
    if len(behind) == 0:
        return pieces, hidden
    regions = planar.regions(pieces.corner, pieces.start, np.arange(pieces.count, dtype=np.intp))
    shade = _in_plane_of(planes, pieces, front, behind)
    common = planar.overlay(shapely.intersection, regions[behind], shade)
    around = shapely.length(common)
    width = 2.0 * shapely.area(common) / np.where(around > 0.0, around, 1.0)
    wide = width > _BEHIND * planes.size[pieces.row[behind]]
    if not wide.any():
        return pieces, hidden
    cut = np.unique(behind[wide])
    for piece in cut:
        cover = shapely.union_all(shade[wide & (behind == piece)])
        regions[piece] = planar.overlay(shapely.difference, regions[piece], cover)
    hidden[pieces.row[cut]] = True
    corner, start, source = planar.pieces_of(regions[cut])
    whole = ~marked(cut, pieces.count)
    left = tidy(Pieces(corner, start, pieces.row[cut][source]), planes)
    left = left.select(left.width > _BEHIND * planes.size[left.row])
    return merged([pieces.select(whole), left]), hidden


def gaps(planes: Planes, pieces: Pieces) -> Floats:
    """Gap (s,) [m] at the mean of the corners of each piece."""
    return Ragged(pieces.start).mean(planes.gap_at(pieces.corner, pieces.corner_row))


def _sharing(planes: Planes, pieces: Pieces, loose: Bools, gap: Floats) -> tuple[Ints, Ints]:
    """Pairs of pieces on one patch: one with a gap above ``loose``, and one with a smaller gap."""
    patch = np.concatenate([planes.f[pieces.row], planes.g[pieces.row]])
    piece = np.tile(np.arange(pieces.count, dtype=np.intp), 2)
    order = np.argsort(patch, kind="stable")
    patch, piece = patch[order], piece[order]
    entry = np.flatnonzero(loose[piece])
    first = np.searchsorted(patch, patch[entry])
    last = np.searchsorted(patch, patch[entry], side="right")
    source, place = expand(first, last - first)
    behind, front = piece[entry[source]], piece[place]
    nearer = (gap[front] < gap[behind]) | ((gap[front] == gap[behind]) & (front < behind))
    keep = nearer & (front != behind)
    return behind[keep], front[keep]


def _in_plane_of(planes: Planes, pieces: Pieces, which: Ints, reference: Ints) -> planar.Regions:
    """Pieces as seen in the planes of other pieces."""
    length = np.diff(pieces.start)[which]
    source, corner = expand(pieces.start[which], length)
    row, target = pieces.row[which][source], pieces.row[reference][source]
    flat = pieces.corner[corner]
    space = planes.origin[row] + np.einsum("li,lij->lj", flat, planes.frame[row, 1:])
    start = Ragged.from_counts(length).start
    seen = planes.flat(space, target)
    return planar.regions(seen, start, np.arange(len(which), dtype=np.intp))
