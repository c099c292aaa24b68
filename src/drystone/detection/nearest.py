"""Hidden interfaces: of several blocks in front of one face, only the nearest touches it."""

from __future__ import annotations

import numpy as np
import shapely

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.ragged import Ragged, expand
from drystone.detection.patches import Patches
from drystone.detection.planes import Pieces, Planes, merged, tidy
from drystone.geometry import planar

EXACT = 1e-4
"""Gaps below this share of the block size have no block between them. Chosen: thinner than any
block."""
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
    whole = np.ones(pieces.count, dtype=bool)
    whole[cut] = False
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
