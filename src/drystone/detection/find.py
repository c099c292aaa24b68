"""From an assembly to its contacts, and a report of how they came about."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.assembly import Assembly
from drystone.contacts import DEFAULT_FRICTION, Contacts, check_friction
from drystone.detection.candidates import Pairs, facing_patches, near_blocks, slack
from drystone.detection.interfaces import Interfaces, from_pieces
from drystone.detection.misses import dropped, judge, misses
from drystone.detection.nearest import uncovered
from drystone.detection.options import DetectionOptions
from drystone.detection.overlap import overlaps, planes_between, widths, within
from drystone.detection.patches import Patches, patches_of
from drystone.detection.penetration import penetrations
from drystone.detection.report import ContactReport, Missed, Reason
from drystone.geometry.coincidence import duplicates

SAME = 1e-6
"""Blocks whose vertices agree within this share of their size are one block twice."""


@dataclass(frozen=True)
class Detection:
    """Contacts, and how they came about.

    Attributes
    ----------
    contacts
    report
    """

    contacts: Contacts
    report: ContactReport


def find_contacts(
    assembly: Assembly,
    *,
    friction: float = DEFAULT_FRICTION,
    options: DetectionOptions | None = None,
) -> Detection:
    """The planar interfaces at which the blocks of an assembly touch.

    Faces touch when they look at each other, are near each other, and share an area in projection;
    see :class:`DetectionOptions` for the tolerances. Every connected piece of shared area is an
    interface of its own, in the plane halfway between the faces; an area with a hole is
    cut into several. Interfaces are ordered by their blocks (``block_a < block_b``) and faces.

    Parameters
    ----------
    assembly
    friction
        Coefficient of every interface.
    options
        Tolerances; the defaults when left out.

    Raises
    ------
    InputError
        The friction is negative or not a number.

    Notes
    -----
    The result does not depend on units, place or rotation, nor, up to order, on numbering.
    Time and memory grow as the number of faces.

    Examples
    --------
    >>> from drystone.models import tower
    >>> found = find_contacts(tower(3), friction=0.7)
    >>> found.contacts.block_a.tolist(), found.contacts.block_b.tolist()
    ([0, 1], [1, 2])
    >>> found.report.isolated
    ()
    """
    options = options if options is not None else DetectionOptions()
    check_friction(friction, 1)
    patches = patches_of(assembly)
    pairs = near_blocks(patches, options)
    found, missed = _face_contacts(patches, pairs, options)
    found = found.ordered()
    return Detection(
        found.contacts(patches.origin, friction),
        _report(assembly, patches, pairs, found, missed, options),
    )


def _face_contacts(
    patches: Patches, pairs: Pairs, options: DetectionOptions
) -> tuple[Interfaces, list[Missed]]:
    """Interfaces with an area, and near misses."""
    f, g = facing_patches(patches, pairs, options)
    order = np.lexsort((g, f, patches.owner[g], patches.owner[f]))
    planes = planes_between(patches, f[order], g[order])
    shared = overlaps(patches, planes)
    judgement = judge(patches, planes, shared, options)
    near = within(shared.select(judgement.accepted), planes, judgement.tolerance)
    wide = widths(near) > options.sliver * planes.size[near.row]
    touching = near.select(wide)
    found, hidden = uncovered(patches, planes, touching)
    missed = [
        *misses(patches, planes, shared, found, judgement, options),
        *dropped(patches, planes, near.select(~wide), found, Reason.SLIVER),
        *dropped(patches, planes, touching.select(hidden[touching.row]), found, Reason.HIDDEN),
    ]
    return from_pieces(patches, planes, found, judgement.partial), missed


def _report(
    assembly: Assembly,
    patches: Patches,
    pairs: Pairs,
    found: Interfaces,
    missed: list[Missed],
    options: DetectionOptions,
) -> ContactReport:
    touched = np.zeros(len(assembly), dtype=bool)
    touched[found.block_a] = touched[found.block_b] = True
    a, b = pairs
    joined = np.isin(a * len(assembly) + b, found.block_a * len(assembly) + found.block_b)
    most = np.maximum.reduceat(slack(patches, options), patches.first_patch[:-1])
    tolerance = options.gap * np.minimum(patches.size[a], patches.size[b]) + most[a] + most[b]
    return ContactReport(
        names=assembly.names,
        options=options,
        block_a=found.block_a,
        block_b=found.block_b,
        face_a=found.face_a,
        face_b=found.face_b,
        kind=np.minimum(np.diff(found.start), 3),
        area=found.area,
        gap=found.gap,
        warp=found.warp,
        angle=found.angle,
        clipped=found.clipped,
        merged=found.merged,
        missed=tuple(missed),
        isolated=tuple(np.flatnonzero(~touched).tolist()),
        penetrations=penetrations(assembly, patches, pairs, np.flatnonzero(joined), tolerance),
        duplicates=tuple(duplicates([block.vertices for block in assembly.blocks], SAME)),
        repairs=tuple(
            (i, what) for i, block in enumerate(assembly.blocks) for what in block.repairs
        ),
    )


__all__ = ["Detection", "find_contacts"]
