"""Near misses of line and point contacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, Ints
from drystone.detection.detection_options import DetectionOptions
from drystone.detection.report.reasons import Missed, Reason
from drystone.detection.search.candidates import Pairs
from drystone.detection.search.edgecontacts import edge_contacts
from drystone.detection.search.interfaces import Interfaces
from drystone.detection.search.patches import Patches


def edge_misses(
    assembly: Assembly, patches: Patches, pairs: Pairs, options: DetectionOptions
) -> tuple[list[Missed], Ints]:
    """Line and point contacts that a larger gap would create.

    Parameters
    ----------
    pairs
        Near blocks (a < b) without any contact.

    Returns
    -------
    missed
    undirected : (u, 2)
        Pairs whose edges or corners are near each other, where the contact has no defined normal.
    """
    if len(pairs[0]) == 0 or options.search <= options.gap:
        return [], np.zeros((0, 2), dtype=np.intp)
    found, undirected = edge_contacts(
        assembly, patches, pairs, replace(options, gap=options.search)
    )
    return [_missed(found, i, patches.origin) for i in range(found.count)], undirected


def _missed(found: Interfaces, i: int, origin: Floats) -> Missed:
    gap = float(found.gap[i])
    return Missed(
        block_a=int(found.block_a[i]),
        block_b=int(found.block_b[i]),
        face_a=int(found.face_a[i]),
        face_b=int(found.face_b[i]),
        reason=Reason.GAP if gap >= 0.0 else Reason.OVERLAP,
        gap=gap,
        angle=0.0,
        area=0.0,
        needed=abs(gap) / float(found.size[i]),
        polygon=_across(found.point[found.start[i] : found.start[i + 1]], found.frame[i, 0], gap)
        + origin,
        joined=False,
    )


def _across(point: Floats, normal: Floats, gap: float) -> Floats:
    """A band (4, 3) across the gap at a line, a line (2, 3) across it at a point."""
    half = 0.5 * gap * normal
    band: Floats = np.concatenate([point - half, point[::-1] + half])
    return band


__all__ = ["edge_misses"]
