"""The missing area of curved joints whose two sides are meshed too differently."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.detection.candidates import fits
from drystone.detection.interfaces import Interfaces
from drystone.detection.misses import ToleranceCheck
from drystone.detection.patches import Patches
from drystone.detection.planes import Pieces, Planes, gaps
from drystone.detection.tolerances import DetectionOptions

_WORTH = 0.02
"""Share of the area of a joint that may be missing without a report."""


@dataclass(frozen=True)
class Shortfall:
    """A curved joint whose area was not completely found.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    area : [m2], estimate of the missing area
    share
        Of the area of the joint.
    gap, angle : [-], [deg]
        Options that would find the whole area; they may exceed the largest permitted values.
    """

    block_a: int
    block_b: int
    area: float
    share: float
    gap: float
    angle: float


@dataclass(frozen=True)
class Compared:
    """The planes between facing patches, their overlaps, and how these are within tolerance."""

    planes: Planes
    shared: Pieces
    checked: ToleranceCheck


def shortfalls(
    patches: Patches, compared: Compared, found: Interfaces, options: DetectionOptions
) -> tuple[Shortfall, ...]:
    """Joints of curved faces with overlaps that were not joined, on faces without other contact.

    Parameters
    ----------
    found
        All interfaces, with those that the search joined beyond its tolerances.
    """
    planes, shared, checked = compared.planes, compared.shared, compared.checked
    curved = fits(patches, planes.f, planes.g)
    if shared.count == 0 or not curved.any():
        return ()
    count = len(planes.f)
    away = np.abs(gaps(planes, shared)) - checked.slack[shared.row]
    near = away <= options.search * planes.size[shared.row]
    f = patches.of_faces(found.block_a, found.face_a)
    g = patches.of_faces(found.block_b, found.face_b)
    key = planes.f * patches.count + planes.g
    order = np.argsort(key)
    place = order[np.minimum(np.searchsorted(key[order], f * patches.count + g), count - 1)]
    known = key[place] == f * patches.count + g
    kept = _summed(place[known], found.area[known], count)
    covered = _summed(np.concatenate([f, g]), np.tile(found.area, 2), patches.count)
    lost = _summed(shared.row, np.where(near, shared.area, 0.0), count) - kept
    lost = np.where(curved, np.maximum(lost, 0.0), 0.0)
    first, second = patches.owner[planes.f], patches.owner[planes.g]
    keys, pair = np.unique(first * len(patches.size) + second, return_inverse=True)
    pair = pair.ravel()
    joint = np.bincount(pair, np.where(curved, kept, 0.0))
    missing = np.maximum(
        *(np.bincount(pair, _bare(patches, side, lost, covered)) for side in (planes.f, planes.g))
    )
    gap, angle = _needed(planes, shared, checked, options)
    result = []
    for i in np.flatnonzero((joint > 0.0) & (missing > _WORTH * (joint + missing))).tolist():
        mine = (pair == i) & (lost > 1e-3 * lost[pair == i].max())
        a, b = divmod(int(keys[i]), len(patches.size))
        share = float(missing[i] / (joint[i] + missing[i]))
        result.append(
            Shortfall(
                a, b, float(missing[i]), share, float(gap[mine].max()), float(angle[mine].max())
            )
        )
    return tuple(result)


def _bare(patches: Patches, side: Ints, lost: Floats, covered: Floats) -> Floats:
    """Lost area (q,) as far as the patch on one side has that much area left."""
    wanted = _summed(side, lost, patches.count)
    left = np.clip(patches.area - covered, 0.0, wanted)
    part: Floats = lost * (left / np.where(wanted > 0.0, wanted, 1.0))[side]
    return part


def _summed(row: Ints, area: Floats, count: int) -> Floats:
    total: Floats = np.bincount(row, area, minlength=count).astype(np.float64)
    return total


def _needed(
    planes: Planes, shared: Pieces, checked: ToleranceCheck, options: DetectionOptions
) -> tuple[Floats, Floats]:
    """The gap (q,) and the angle (q,) [deg] with which pairs of patches would be joined."""
    row = shared.corner_row
    most = np.zeros(len(planes.f))
    np.maximum.at(most, row, np.abs(planes.gap_at(shared.corner, row)))
    gap = np.maximum((most - checked.slack) / planes.size, options.reach(planes.size) / planes.size)
    angle = np.rad2deg(np.maximum(checked.angle - checked.limit, 0.0)) + options.angle
    return gap, angle
