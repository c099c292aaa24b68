"""The contacts of an assembly, with a report of the search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from drystone.assembly import Assembly
from drystone.assembly.block import require_sound
from drystone.base.arrays import Ints
from drystone.base.display import Card
from drystone.base.settings import checked_call
from drystone.contacts import DEFAULT_FRICTION, Contacts, check_friction
from drystone.detection.candidates import Pairs, most_slack, near_blocks
from drystone.detection.contact_report import ContactReport
from drystone.detection.edgecontacts import edge_contacts
from drystone.detection.face_overlaps import Overlap, block_overlaps
from drystone.detection.inexact_joints import join_inexact, strips
from drystone.detection.interfaces import Interfaces, joined
from drystone.detection.misses import Inexact, edge_misses, face_contacts, shortfalls
from drystone.detection.patches import Patches, patches_of
from drystone.detection.resample import resample
from drystone.detection.tolerances import DetectionOptions, EdgeContacts, Missed
from drystone.geometry.soup import separate_parts


@dataclass(frozen=True)
class Detection(Card):
    """Contacts, with a report of the search.

    Attributes
    ----------
    contacts
    report
    """

    contacts: Contacts
    report: ContactReport

    def _facts(self) -> tuple[str, Mapping[str, object]]:
        return self.report._facts()

    def _summary(self) -> str:
        return self.report._summary()


@checked_call
def find_contacts(
    assembly: Assembly,
    *,
    friction: float = DEFAULT_FRICTION,
    options: DetectionOptions | None = None,
) -> Detection:
    """The planar interfaces at which the blocks of an assembly touch.

    Two faces touch when they face each other, are near each other, and share an area in projection;
    see :class:`DetectionOptions` for the tolerances. Every connected piece of shared area is one
    interface, in the plane halfway between the faces. An area with a hole is cut into several
    interfaces. Interfaces are ordered by their blocks (``block_a < block_b``) and faces.

    Blocks that overlap a little more are joined as well, and so are those as little apart: the
    drawing is off, and the report says by how much.

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
        The friction is negative or not a number, or a block touches or crosses itself.

    Notes
    -----
    The result does not depend on units, position or rotation. Numbering changes its order only.
    Time and memory are proportional to the number of faces.

    Examples
    --------
    >>> from drystone.models import tower
    >>> found = find_contacts(tower(3), friction=0.7)
    >>> found.contacts.block_a.tolist(), found.contacts.block_b.tolist()
    ([0, 1], [1, 2])
    >>> found.report.isolated
    ()
    """
    options = DetectionOptions.of(options)
    check_friction(friction, 1)
    patches = patches_of(assembly)
    require_sound(assembly.blocks, patches.block_convex & patches.one_surface)
    pairs = near_blocks(patches, options)
    found, missed, compared = face_contacts(patches, pairs, options)
    near = _pairs_for_edges(patches, pairs, found, options)
    touching = options.reach(np.minimum(patches.size[near[0]], patches.size[near[1]]))
    lines, undirected = edge_contacts(assembly, patches, near, touching, options)
    by_edge = set(zip(lines.block_a.tolist(), lines.block_b.tolist(), strict=True))
    told = [m for m in missed if not (np.isnan(m.needed) or m.farther(options.search))]
    named = by_edge | {(miss.block_a, miss.block_b) for miss in told}
    named |= set(map(tuple, undirected.tolist()))
    missed = [
        replace(miss, joined=miss.joined or (miss.block_a, miss.block_b) in by_edge)
        for miss in missed
    ]
    found = joined([found, lines]).ordered()
    plane = found.area > 0.0
    together = found.block_a[plane] * len(assembly) + found.block_b[plane]
    deep = _overlaps(assembly, patches, pairs, together, options)
    facing = [m.block_a * len(assembly) + m.block_b for m in missed]
    inexact: list[Inexact] = []
    if options.inexact:
        found, inexact, missed = join_inexact(assembly, patches, found, missed, deep, options)
    named |= {(pair.block_a, pair.block_b) for pair in inexact}
    beyond, open_ones = edge_misses(assembly, patches, _less(near, named), facing, options)
    short = shortfalls(patches, compared, found, options)
    found, fewer = resample(found, options.curve)
    parted: dict[bool, list[Missed]] = {False: [], True: []}
    for miss in (*missed, *beyond):
        parted[miss.farther(options.search)].append(miss)
    touched = np.zeros(len(assembly), dtype=bool)
    touched[found.block_a] = touched[found.block_b] = True
    report = ContactReport(
        names=assembly.names,
        options=options,
        interfaces=found,
        resampled=fewer,
        missed=tuple(parted[False]),
        farther=(*parted[True], *strips(found, len(assembly))),
        inexact=tuple(inexact),
        shortfalls=short,
        undirected=tuple(zip(*np.concatenate([undirected, open_ones]).T.tolist(), strict=True)),
        isolated=tuple(np.flatnonzero(~touched).tolist()),
        overlaps=deep,
        parts=_parts(assembly, patches),
        repairs=_repairs(assembly),
    )
    return Detection(found.contacts(patches.origin, friction), report)


def _pairs_for_edges(
    patches: Patches, pairs: Pairs, found: Interfaces, options: DetectionOptions
) -> Pairs:
    """Near pairs that are searched for contacts along edges and at corners."""
    a, b = pairs
    count = len(patches.size)
    apart = ~np.isin(a * count + b, found.block_a * count + found.block_b)
    if options.edges is EdgeContacts.NEVER:
        apart[:] = False
    elif options.edges is EdgeContacts.ISOLATED:
        alone = np.ones(count, dtype=bool)
        alone[found.block_a] = alone[found.block_b] = False
        apart &= alone[a] | alone[b]
    return a[apart], b[apart]


def _less(pairs: Pairs, known: set[tuple[int, int]]) -> Pairs:
    """The pairs that are not in ``known``."""
    a, b = pairs
    couples = zip(a.tolist(), b.tolist(), strict=True)
    keep = np.array([couple not in known for couple in couples], dtype=bool)
    return a[keep], b[keep]


def _repairs(assembly: Assembly) -> tuple[tuple[int, str], ...]:
    """Per repaired block its position and the repair."""
    return tuple((i, what) for i, block in enumerate(assembly.blocks) for what in block.repairs)


def find_overlaps(
    assembly: Assembly, options: DetectionOptions | None = None
) -> tuple[Overlap, ...]:
    """Pairs of blocks that overlap deeper than the tolerances allow.

    :func:`find_contacts` reports them too. Use this function for contacts from another source.

    Parameters
    ----------
    assembly
    options
        Tolerances; the defaults when left out.

    Examples
    --------
    >>> from drystone.models import box
    >>> from drystone.assembly import Assembly
    >>> sunk = box((1, 1, 1), (0, 0, 0.75), name="sunk")
    >>> found = find_overlaps(Assembly((box((1, 1, 1), name="base"), sunk)))
    >>> found[0].volume, found[0].share, found[0].depth
    (0.25, 0.25, 0.25)
    """
    options = DetectionOptions.of(options)
    patches = patches_of(assembly)
    pairs = near_blocks(patches, options)
    return _overlaps(assembly, patches, pairs, np.zeros(0, dtype=np.intp), options)


def _overlaps(
    assembly: Assembly, patches: Patches, pairs: Pairs, joined: Ints, options: DetectionOptions
) -> tuple[Overlap, ...]:
    """See :func:`block_overlaps`; ``joined`` are pairs as ``a * number + b``."""
    apart = ~(assembly.fixed[pairs[0]] & assembly.fixed[pairs[1]])  # supports may overlap
    a, b = pairs[0][apart], pairs[1][apart]
    most = patches.of_block.max(most_slack(patches, options))
    tolerance = options.reach(np.minimum(patches.size[a], patches.size[b])) + most[a] + most[b]
    together = np.flatnonzero(np.isin(a * len(assembly) + b, joined))
    return block_overlaps(assembly, patches, (a, b), together, tolerance)


def _parts(assembly: Assembly, patches: Patches) -> tuple[tuple[int, int], ...]:
    """Blocks that consist of separate parts, and the number of parts."""
    counts = []
    for i in np.flatnonzero(~patches.one_surface).tolist():
        block = assembly.blocks[i]
        counts.append((i, len(separate_parts(block.vertices, block.faces)[0])))
    return tuple((i, count) for i, count in counts if count > 1)
