"""Blocks that overlap: pairs, shared volume, depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.detection.candidates import Pairs
from drystone.detection.patches import Patches
from drystone.detection.tolerances import SHOWN, millimetres
from drystone.geometry.shared_volume import shared_volumes

_REFUSED = 0.1
"""Models with blocks that share more than this part of the smaller one are refused. Chosen: far
above the overlaps that rounded coordinates and warped faces cause."""


@dataclass(frozen=True)
class Overlap(OneLine):
    """Two blocks that share volume.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    depth : [m]
        For convex blocks: the shortest translation that separates them. Otherwise: the largest
        distance from a surface point of one block, inside the other, to the surface of the other.
    volume : [m3]
        The shared volume.
    share
        The shared volume divided by the volume of the smaller block.
    """

    block_a: int
    block_b: int
    depth: float
    volume: float
    share: float


def block_overlaps(
    assembly: Assembly, patches: Patches, pairs: Pairs, joined: Ints, tolerance: Floats
) -> tuple[Overlap, ...]:
    """Pairs of blocks that overlap deeper than the tolerance.

    Parameters
    ----------
    pairs
        Near blocks, a < b.
    joined : (j,)
        Positions in ``pairs`` of those with a face contact: its plane separates convex blocks.
    tolerance : (p,) [m] per pair
    """
    a, b = pairs
    low, high = patches.boxes
    near = (np.minimum(high[a], high[b]) - np.maximum(low[a], low[b])).min(axis=1) > tolerance
    parted = np.zeros(len(a), dtype=bool)
    parted[joined] = True
    near &= ~(parted & patches.block_convex[a] & patches.block_convex[b])
    if not near.any():
        return ()
    a, b = a[near], b[near]
    faces = replace(assembly.faces, point=assembly.faces.point - patches.origin)
    found = shared_volumes(faces, a, b, tolerance[near], patches.block_convex)
    a, b = a[found.row], b[found.row]
    share = found.volume / np.minimum(assembly.volume[a], assembly.volume[b])
    columns = (a.tolist(), b.tolist(), found.depth.tolist(), found.volume.tolist(), share.tolist())
    return tuple(Overlap(*each) for each in zip(*columns, strict=True))


def overlap_lines(names: Sequence[str], overlaps: Sequence[Overlap]) -> list[str]:
    """A sentence for each of the first pairs of overlapping blocks, the largest share first."""
    worst = sorted(overlaps, key=lambda pair: (-pair.share, -pair.depth))
    lines = [f"{_named(names, pair)} overlap: they share {_shared(pair)}" for pair in worst[:SHOWN]]
    if len(worst) > SHOWN:
        left = len(worst) - SHOWN
        lines.append(counted(left, "more pair of blocks overlaps", "more pairs of blocks overlap"))
    return lines


def require_apart(names: Sequence[str], overlaps: Sequence[Overlap]) -> None:
    """Refuse blocks that share more than a tenth of the smaller one.

    Raises
    ------
    InputError
        There are such blocks; the pair with the largest share is named.
    """
    refused = [pair for pair in overlaps if pair.share > _REFUSED]
    if not refused:
        return
    worst = max(refused, key=lambda pair: (pair.share, pair.depth))
    more = ""
    if len(refused) > 1:
        others = counted(len(refused) - 1, "more pair overlaps", "more pairs overlap")
        more = f"; {others} by more than a tenth"
    raise InputError(
        f"overlap: they share {_shared(worst)}{more}",
        where=_named(names, worst),
        remedy="move them apart in the model, or accept them with --anyway (anyway=True in Python)",
    )


def _named(names: Sequence[str], pair: Overlap) -> str:
    return f"blocks '{names[pair.block_a]}' and '{names[pair.block_b]}'"


def _shared(pair: Overlap) -> str:
    share = f"{float(f'{100.0 * pair.share:.2g}'):g} % of the smaller one"
    return f"{pair.volume:.3g} m3 ({share}), {millimetres(pair.depth)} mm deep"
