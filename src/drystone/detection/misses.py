"""Which overlaps count as contacts, why others do not, and which joints a drawing just misses.

The missing area of curved joints whose two sides are meshed too differently.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, marked
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.ragged import Ragged
from drystone.detection.candidates import (
    NEAR,
    NEAR_BESIDE,
    Pairs,
    facing_patches,
    fits,
    granted_to,
    reach_of_pairs,
    reach_of_patches,
)
from drystone.detection.edgecontacts import edge_contacts
from drystone.detection.face_overlaps import negligible, overlaps, within
from drystone.detection.interfaces import Interfaces, angles, from_pieces, joined
from drystone.detection.patches import Patches
from drystone.detection.planes import NEGLIGIBLE, Pieces, Planes, gaps, planes_between, uncovered
from drystone.detection.tolerances import DetectionOptions, Missed, Reason, millimetres
from drystone.geometry.boxes import FEW

EXPLAINED = 0.9
"""A face with more than this share of its area in contact has no near misses. Chosen."""


@dataclass(frozen=True)
class Compared:
    """Facing patches, what they share, and how it compares with the tolerances.

    Attributes
    ----------
    planes : of q pairs of patches
    shared : their s overlaps
    tolerance : (q,) [m]
    slack : (q,) [m] the part of it that is due to warp and curvature
    angle : (q,) [rad]
    limit : (q,) [rad]
    accepted : (s,) overlaps that are contacts, at least in part
    partial : (q,) whether only a part is within tolerance
    away : (s,) 1 of those too far apart, -1 of those too deep in each other, else 0
    too_steep, too_warped : (s,)
    """

    planes: Planes
    shared: Pieces
    tolerance: Floats
    slack: Floats
    angle: Floats
    limit: Floats
    accepted: Bools
    partial: Bools
    away: Ints
    too_steep: Bools
    too_warped: Bools


def compared(patches: Patches, f: Ints, g: Ints, options: DetectionOptions) -> Compared:
    """Patches (p,) that face each other, in order of their blocks, compared."""
    order = np.lexsort((g, f, patches.owner[g], patches.owner[f]))
    f, g = f[order], g[order]
    planes = planes_between(patches, f, g)
    shared = overlaps(patches, planes)
    slack, turned = granted_to(patches, f, g, options)
    tolerance = options.reach(planes.size) + slack
    angle = angles(patches, f, g)
    limit = np.deg2rad(options.angle) + turned
    corner_row = shared.corner_row
    gap = planes.gap_at(shared.corner, corner_row)
    corners = Ragged(shared.start)
    least = corners.min(gap - tolerance[corner_row])
    most = corners.max(gap + tolerance[corner_row])
    over = corners.max(np.abs(gap) - tolerance[corner_row])
    row = shared.row
    away = (least > 0.0).astype(np.intp) - (most < 0.0)
    steep = (angle > limit)[row]
    warped = (np.maximum(patches.warp[f], patches.warp[g]) > options.warp * planes.size)[row]
    accepted = (away == 0) & ~(steep | warped)
    partial = marked(row[over > 0.0], len(f))
    return Compared(
        planes, shared, tolerance, slack, angle, limit, accepted, partial, away, steep, warped
    )


def dropped(
    patches: Patches, planes: Planes, pieces: Pieces, found: Pieces, reason: Reason
) -> list[Missed]:
    """Overlaps within all tolerances that were left out for another reason."""
    if pieces.count == 0:
        return []
    interfaces = from_pieces(patches, planes, pieces, np.zeros(len(planes.f), dtype=bool))
    touch = np.isin(_pair_keys(patches, planes, pieces), _pair_keys(patches, planes, found))
    return [
        missed_of(interfaces, i, reason, float("nan"), bool(touch[i]), patches.origin)
        for i in range(interfaces.count)
    ]


def misses(
    patches: Patches, checked: Compared, found: Pieces, options: DetectionOptions
) -> list[Missed]:
    """Near misses: overlaps just beyond a tolerance, of faces without other contact.

    Wider gaps that may be errors of the drawing are among them.
    """
    planes, shared = checked.planes, checked.shared
    row = shared.row
    refused = ~checked.accepted & (shared.width > NEGLIGIBLE * planes.size[row])
    covered = np.zeros(patches.count)
    np.add.at(covered, planes.f[found.row], found.area)
    np.add.at(covered, planes.g[found.row], found.area)
    explained = covered >= EXPLAINED * patches.area
    refused &= ~(explained[planes.f] | explained[planes.g])[row]
    if not refused.any():
        return []
    away = gaps(planes, shared)
    apart = np.abs(away) - checked.slack[row]
    size = planes.size[row]
    touch = np.isin(_pair_keys(patches, planes, shared), _pair_keys(patches, planes, found))
    apart_only, beside = (
        reach_of_patches(patches, planes.f, planes.g, options, near)[row]
        for near in (NEAR, NEAR_BESIDE)
    )
    told = options.search * size
    refused &= apart <= np.where(away > 0.0, np.where(touch, beside, apart_only), told)
    chosen, touch = shared.select(refused), touch[refused]
    interfaces = from_pieces(patches, planes, chosen, checked.partial)
    excess = np.rad2deg(checked.angle - checked.limit)[chosen.row] + options.angle
    far = _far(checked, apart) / size
    result = []
    for i, piece in enumerate(np.flatnonzero(refused).tolist()):
        if apart[piece] > told[piece]:
            reason, needed = Reason.GAP, float(far[piece])
        elif checked.too_warped[piece]:
            reason, needed = Reason.WARP, float("nan")
        elif checked.too_steep[piece]:
            no_touch = checked.away[piece] != 0
            reason, needed = Reason.ANGLE, float("nan") if no_touch else float(excess[i])
        else:
            reason = Reason.GAP if checked.away[piece] > 0 else Reason.OVERLAP
            needed = float(apart[piece] / size[piece])
        result.append(missed_of(interfaces, i, reason, needed, bool(touch[i]), patches.origin))
    return result


def _far(checked: Compared, apart: Floats) -> Floats:
    """How far (s,) [m] a gap has to reach; of steep faces over all that they share.

    On a part of steep faces little stands.
    """
    shared = checked.shared
    gap = checked.planes.gap_at(shared.corner, shared.corner_row)
    widest = Ragged(shared.start).max(np.abs(gap))
    return np.where(checked.too_steep, widest - checked.slack[shared.row], apart)


def _pair_keys(patches: Patches, planes: Planes, pieces: Pieces) -> Ints:
    count = len(patches.size)
    owner = patches.owner
    return owner[planes.f[pieces.row]] * count + owner[planes.g[pieces.row]]


def missed_of(
    interfaces: Interfaces, i: int, reason: Reason, needed: float, joined: bool, origin: Floats
) -> Missed:
    """One interface that was not made; its points are relative to ``origin``."""
    return Missed(
        block_a=int(interfaces.block_a[i]),
        block_b=int(interfaces.block_b[i]),
        face_a=int(interfaces.face_a[i]),
        face_b=int(interfaces.face_b[i]),
        reason=reason,
        gap=float(interfaces.gap[i]),
        angle=float(interfaces.angle[i]),
        area=float(interfaces.area[i]),
        needed=needed,
        polygon=interfaces.point[interfaces.start[i] : interfaces.start[i + 1]] + origin,
        joined=joined,
    )


def edge_misses(
    assembly: Assembly,
    patches: Patches,
    pairs: Pairs,
    facing: Sequence[int],
    options: DetectionOptions,
) -> tuple[list[Missed], Ints]:
    """Line and point contacts that a larger gap would create, and those that are farther.

    Parameters
    ----------
    pairs
        Near blocks (a < b) without any contact.
    facing
        Those of them whose faces are farther apart, as ``a * number + b``: their edges are not.

    Returns
    -------
    missed
    undirected : (u, 2)
        Pairs whose edges or corners are near each other, where the contact has no defined normal.
    """
    if len(pairs[0]) == 0 or (options.gap_length is None and options.search <= options.gap):
        return [], np.zeros((0, 2), dtype=np.intp)
    a, b = pairs
    reach = options.search * np.minimum(patches.size[a], patches.size[b])
    found, undirected = edge_contacts(assembly, patches, pairs, reach, options)
    count = len(patches.size)
    left = ~np.isin(a * count + b, [*(found.block_a * count + found.block_b), *facing])
    left &= patches.of_block.counts[a] * patches.of_block.counts[b] <= FEW  # not of fine meshes
    others = a[left], b[left]
    farthest = reach_of_pairs(patches, others, options)
    farther, _ = edge_contacts(assembly, patches, others, farthest, options)
    found = joined([found, farther])
    return [_missed_edges(found, i, patches.origin) for i in range(found.count)], undirected


def _missed_edges(found: Interfaces, i: int, origin: Floats) -> Missed:
    gap = float(found.gap[i])
    reason = Reason.GAP if gap >= 0.0 else Reason.OVERLAP
    made = missed_of(found, i, reason, abs(gap) / float(found.size[i]), False, origin)
    line = found.point[found.start[i] : found.start[i + 1]]
    across = _across(line, found.frame[i, 0], gap) + origin
    return replace(made, angle=0.0, area=0.0, polygon=across)


def _across(point: Floats, normal: Floats, gap: float) -> Floats:
    """A band (4, 3) across the gap at a line, a line (2, 3) across it at a point."""
    half = 0.5 * gap * normal
    return np.concatenate([point - half, point[::-1] + half])


class Error(StrEnum):
    """Kinds of errors of a drawing that do not keep blocks apart."""

    OVERLAP = "in each other"
    GAP = "apart"
    WARP = "warped"
    MORTAR = "apart by the thickness of the mortar"


@dataclass(frozen=True)
class Inexact(OneLine):
    """Two blocks that are joined although they are drawn beyond a tolerance.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    error
    off : [m]
        How deep they are in each other, how far apart, or how far their faces are from a plane.
    """

    block_a: int
    block_b: int
    error: Error
    off: float


def inexact_pairs(pair: Ints, which: Bools, off: Floats, error: Error, count: int) -> list[Inexact]:
    """The largest error of each pair, as ``a * count + b``, of some pieces (s,) that are joined."""
    worst: dict[int, float] = {}
    for key, value in zip(pair[which].tolist(), off[which].tolist(), strict=True):
        worst[key] = max(value, worst.get(key, 0.0))
    return [Inexact(*divmod(key, count), error, value) for key, value in worst.items()]


_WORDS = {
    Error.OVERLAP: (
        "is drawn {off} mm deep into each other and joined on the plane halfway",
        "are drawn up to {off} mm deep into each other and joined on the planes halfway",
    ),
    Error.GAP: (
        "is drawn {off} mm apart and joined on the plane halfway",
        "are drawn up to {off} mm apart and joined on the planes halfway",
    ),
    Error.WARP: (
        "has a joint {off} mm from plane, taken as a fan of triangles",
        "have joints up to {off} mm from plane, taken as fans of triangles",
    ),
    Error.MORTAR: (
        "is {off} mm apart, taken for mortar and joined on the plane halfway",
        "are up to {off} mm apart, all alike: taken for mortar and joined on the planes halfway",
    ),
}
HOLDS = "the answer holds for these joints, not for the blocks as they are drawn"


def inexact_lines(names: Sequence[str], inexact: Sequence[Inexact]) -> list[str]:
    """A sentence for each kind of error, with the largest one, and what the answer holds for."""
    lines = []
    for error, (one, several) in _WORDS.items():
        here = [pair for pair in inexact if pair.error is error]
        if here:
            worst = max(here, key=lambda pair: pair.off)
            words = counted(len(here), f"pair of blocks {one}", f"pairs of blocks {several}")
            said = words.format(off=millimetres(worst.off))
            which = "largest: " if len(here) > 1 else ""
            pair = f" ({which}'{names[worst.block_a]}' and '{names[worst.block_b]}')"
            lines.append(said if error is Error.MORTAR else said + pair)
    return [*lines, HOLDS] if lines else []


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


def shortfalls(
    patches: Patches, checked: Compared, found: Interfaces, options: DetectionOptions
) -> tuple[Shortfall, ...]:
    """Joints of curved faces with overlaps that were not joined, on faces without other contact.

    Parameters
    ----------
    found
        All interfaces, with those that the search joined beyond its tolerances.
    """
    planes, shared = checked.planes, checked.shared
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
    gap, angle = _needed(checked, options)
    result = []
    for i in np.flatnonzero((joint > 0.0) & (missing > NEGLIGIBLE * (joint + missing))).tolist():
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
    return lost * (left / np.where(wanted > 0.0, wanted, 1.0))[side]


def _summed(row: Ints, area: Floats, count: int) -> Floats:
    return np.bincount(row, area, minlength=count).astype(np.float64)


def _needed(checked: Compared, options: DetectionOptions) -> tuple[Floats, Floats]:
    """The gap (q,) and the angle (q,) [deg] with which pairs of patches would be joined."""
    planes, shared = checked.planes, checked.shared
    row = shared.corner_row
    most = np.zeros(len(planes.f))
    np.maximum.at(most, row, np.abs(planes.gap_at(shared.corner, row)))
    gap = np.maximum((most - checked.slack) / planes.size, options.reach(planes.size) / planes.size)
    angle = np.rad2deg(np.maximum(checked.angle - checked.limit, 0.0)) + options.angle
    return gap, angle


def face_contacts(
    patches: Patches, pairs: Pairs, options: DetectionOptions
) -> tuple[Interfaces, list[Missed], Compared]:
    """Interfaces with an area, near misses, and all that was compared."""
    f, g = facing_patches(patches, pairs, options)
    checked = compared(patches, f, g, options)
    planes, shared = checked.planes, checked.shared
    near = within(shared.select(checked.accepted), planes, checked.tolerance)
    wide = near.width > options.sliver * planes.size[near.row]
    wide &= ~negligible(patches, planes, near)
    touching = near.select(wide)
    found, hidden = uncovered(patches, planes, touching)
    missed = [
        *misses(patches, checked, found, options),
        *dropped(patches, planes, near.select(~wide), found, Reason.SLIVER),
        *dropped(patches, planes, touching.select(hidden[touching.row]), found, Reason.HIDDEN),
    ]
    return from_pieces(patches, planes, found, checked.partial), missed, checked
