"""Joints on curved surfaces: pieces merged and regrouped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.contacts import Contacts
from drystone.detection.interfaces import Interfaces, joined
from drystone.geometry import facets as geometry
from drystone.geometry.facets import Facet
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.polygon import area_vectors

_UNEVEN = 0.5
"""The pieces of a pair are examined when one is narrower than this share of another. Chosen above
any sensible share, to skip ordinary joints quickly."""


def merge_slivers(found: Interfaces, share: float) -> Interfaces:
    """Merge interfaces narrower than ``share`` of a neighbour of the same two blocks into it.

    Where
    the two sides of a curved joint are meshed differently, their strips overlap in wide and narrow
    pieces. The total area changes by at most 2 %.
    """
    if share <= 0.0 or found.count < 2:
        return found
    length = np.diff(found.start)
    pair = found.block_a * (found.block_b.max() + 1) + found.block_b
    _, group, size = np.unique(pair, return_inverse=True, return_counts=True)
    many = np.flatnonzero((size[group] > 1) & (length > 2))
    whole = np.ones(found.count, dtype=bool)
    parts: list[Interfaces] = []
    for each in np.unique(group[many]):
        mine = many[group[many] == each]
        piece = found.take(mine)
        facets = geometry.facets_of(piece.point, piece.start)
        width = np.array([facet.width for facet in facets])
        if width.min() >= min(share, _UNEVEN) * width.max():
            continue
        merged = geometry.merge_slivers(facets, share, float(piece.size[0]))
        whole[mine] = False
        parts.append(_from_facets(piece, merged))
    return joined([found.take(np.flatnonzero(whole)), *parts]) if parts else found


def _from_facets(given: Interfaces, facets: Sequence[Facet]) -> Interfaces:
    """Interfaces from facets; gap, warp and angle are the worst of the members."""
    first = np.array([f.members[int(np.argmax(given.area[list(f.members)]))] for f in facets])
    weight = [given.area[list(f.members)] for f in facets]
    members = [list(f.members) for f in facets]
    count = np.array([len(f.point) for f in facets], dtype=np.intp)
    return replace(
        given.take(first.astype(np.intp)),
        frame=_frames(given, facets),
        point=np.concatenate([f.point for f in facets]),
        start=Ragged.from_counts(count).start,
        area=_areas(facets),
        gap=np.array([given.gap[m] @ w / w.sum() for m, w in zip(members, weight, strict=True)]),
        warp=np.array([given.warp[m].max() for m in members]),
        angle=np.array([given.angle[m].max() for m in members]),
        clipped=np.array([given.clipped[m].any() for m in members]),
        merged=np.array([len(m) for m in members], dtype=np.intp),
    )


def _frames(given: Interfaces, facets: Sequence[Facet]) -> Floats:
    """Frames of facets; unchanged facets keep theirs."""
    frame = frames_from_normals(np.array([facet.normal for facet in facets]))
    single = np.array([len(facet.members) == 1 for facet in facets])
    members = np.array([facet.members[0] for facet in facets], dtype=np.intp)
    frame[single] = given.frame[members[single]]
    return frame


def _areas(facets: Sequence[Facet]) -> Floats:
    """Areas [m2] of the polygons themselves."""
    count = np.array([len(facet.point) for facet in facets], dtype=np.intp)
    start = Ragged.from_counts(count).start
    vectors = area_vectors(np.concatenate([facet.point for facet in facets]), start)
    area: Floats = np.sqrt((vectors * vectors).sum(axis=1))
    return area


def regroup(
    contacts: Contacts,
    *,
    count: int | None = None,
    angle: float | None = None,
    pairs: Sequence[tuple[int, int]] | None = None,
) -> Contacts:
    """The same joints divided into another number of plane interfaces.

    Neighbouring interfaces of two blocks are joined, and large ones divided, joint by joint. A
    joint here is a set of interfaces connected along edges without a crease. Areas are kept to 2 %;
    interfaces that cannot be joined so are not changed.

    Parameters
    ----------
    contacts
    count
        Interfaces per joint. A strongly curved joint may keep more.
    angle : [deg]
        Join neighbours whose normals are within this angle of their mean. Give ``count`` or
        ``angle``.
    pairs
        Only the joints between these blocks; all when left out.

    Returns
    -------
    Contacts
        Ordered by blocks. Lines and points are not changed. The friction of a joined interface is
        the area-weighted mean.

    Raises
    ------
    InputError
        Neither or both of count and angle, or out of range.

    Examples
    --------
    >>> from drystone.detection import find_contacts
    >>> from drystone.models import tower
    >>> regroup(find_contacts(tower(2)).contacts, count=4).count
    4
    """
    if (count is None) == (angle is None):
        raise InputError("give either a count or an angle")
    if count is not None and count < 1:
        raise InputError(f"count is {count}", remedy="give 1 or more")
    if angle is not None and not 0.0 < angle <= 45.0:
        raise InputError(f"angle is {angle}", remedy="give degrees above 0, up to 45")
    wanted = None if pairs is None else {(min(p), max(p)) for p in pairs}
    couples = list(zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True))
    groups: dict[tuple[int, int], list[int]] = {}
    for i, couple in enumerate(couples):
        groups.setdefault(couple, []).append(i)
    rows: list[tuple[Floats, Floats, int, int, float]] = []
    for couple in sorted(groups, key=lambda c: (min(c), max(c), c)):
        mine = groups[couple]
        plane = [i for i in mine if contacts.start[i + 1] - contacts.start[i] > 2]
        chosen = wanted is None or (min(couple), max(couple)) in wanted
        facets = _regrouped(contacts, plane, count, angle) if chosen and plane else []
        kept = [i for i in mine if i not in plane] if facets else mine
        for facet in facets:
            members = [plane[m] for m in facet.members]
            weight = contacts.area[members]
            friction = float(contacts.friction[members] @ weight / weight.sum())
            rows.append((facet.point, facet.frame, *couple, friction))
        rows += [
            (contacts.polygon(i), contacts.frame[i], *couple, float(contacts.friction[i]))
            for i in kept
        ]
    return contacts_of(rows)


def _regrouped(
    contacts: Contacts, plane: list[int], count: int | None, angle: float | None
) -> list[Facet]:
    """Facets of the joints of one pair of blocks; members count within ``plane``."""
    length = np.diff(contacts.start)[plane]
    corner = np.concatenate([contacts.polygon(i) for i in plane])
    given = geometry.facets_of(corner, Ragged.from_counts(length).start)
    size = float(np.sqrt(contacts.area[plane].sum()))
    if angle is not None:
        return geometry.join_by_angle(given, float(np.deg2rad(angle)), size)
    facets: list[Facet] = []
    for joint in _joints(given, size):
        part = [given[i] for i in joint]
        local = [replace(facet, members=(i,)) for i, facet in enumerate(part)]
        grouped = geometry.join_to_count(local, int(count or 1), size)
        for facet in geometry.divide_to_count(grouped, int(count or 1)):
            facets.append(replace(facet, members=tuple(joint[m] for m in facet.members)))
    return facets


def _joints(facets: Sequence[Facet], size: float) -> list[list[int]]:
    """Positions of facets that are connected."""
    label = list(range(len(facets)))
    for i, j in geometry.neighbours(facets, size):
        old, new = label[j], label[i]
        label = [new if each == old else each for each in label]
    joints: dict[int, list[int]] = {}
    for i, each in enumerate(label):
        joints.setdefault(each, []).append(i)
    return list(joints.values())


def contacts_of(rows: Sequence[tuple[Floats, Floats, int, int, float]]) -> Contacts:
    """Contacts from (corners, frame, block a, block b, friction) each."""
    if not rows:
        return Contacts.empty()
    count = np.array([len(row[0]) for row in rows], dtype=np.intp)
    start = Ragged.from_counts(count).start
    point = np.concatenate([row[0] for row in rows])
    vectors = area_vectors(point, start)
    return Contacts(
        np.array([row[2] for row in rows], dtype=np.intp),
        np.array([row[3] for row in rows], dtype=np.intp),
        np.array([row[1] for row in rows]),
        np.where(count > 2, np.sqrt((vectors * vectors).sum(axis=1)), 0.0),
        np.array([row[4] for row in rows]),
        point,
        np.repeat(np.arange(len(rows), dtype=np.intp), count),
    )
