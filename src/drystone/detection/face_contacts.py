"""The faces of blocks that touch, nearly touch, or touch on a part of a curved joint."""

from __future__ import annotations

import numpy as np

from drystone.detection.candidates import Pairs, facing_patches
from drystone.detection.face_overlaps import negligible, overlaps, within
from drystone.detection.interfaces import Interfaces, from_pieces
from drystone.detection.misses import Compared, compare_with_tolerances, dropped, misses
from drystone.detection.patches import Patches
from drystone.detection.planes import planes_between, uncovered
from drystone.detection.tolerances import DetectionOptions, Missed, Reason


def face_contacts(
    patches: Patches, pairs: Pairs, options: DetectionOptions
) -> tuple[Interfaces, list[Missed], Compared]:
    """Interfaces with an area, near misses, and all that was compared."""
    f, g = facing_patches(patches, pairs, options)
    order = np.lexsort((g, f, patches.owner[g], patches.owner[f]))
    planes = planes_between(patches, f[order], g[order])
    shared = overlaps(patches, planes)
    checked = compare_with_tolerances(patches, planes, shared, options)
    near = within(shared.select(checked.accepted), planes, checked.tolerance)
    wide = near.width > options.sliver * planes.size[near.row]
    wide &= ~negligible(patches, planes, near)
    touching = near.select(wide)
    found, hidden = uncovered(patches, planes, touching)
    missed = [
        *misses(patches, planes, shared, found, checked, options),
        *dropped(patches, planes, near.select(~wide), found, Reason.SLIVER),
        *dropped(patches, planes, touching.select(hidden[touching.row]), found, Reason.HIDDEN),
    ]
    compared = Compared(planes, shared, checked)
    return from_pieces(patches, planes, found, checked.partial), missed, compared
