"""The faces of blocks that touch, nearly touch, or touch on a part of a curved joint."""

from __future__ import annotations

from drystone.detection.candidates import Pairs, facing_patches
from drystone.detection.face_overlaps import negligible, within
from drystone.detection.interfaces import Interfaces, from_pieces
from drystone.detection.misses import Compared, compared, dropped, misses
from drystone.detection.patches import Patches
from drystone.detection.planes import uncovered
from drystone.detection.tolerances import DetectionOptions, Missed, Reason


def face_contacts(
    patches: Patches, pairs: Pairs, options: DetectionOptions
) -> tuple[Interfaces, list[Missed], Compared]:
    """Interfaces with an area, near misses, and all that was compared."""
    f, g = facing_patches(patches, pairs, options)
    everything = compared(patches, f, g, options)
    planes, shared, checked = everything
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
    return (
        from_pieces(patches, planes, found, checked.partial),
        missed,
        Compared(planes, shared, checked),
    )
