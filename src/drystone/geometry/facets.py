"""Smooth runs of plane facets, and facets joined into fewer plane pieces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from drystone.base.arrays import Bools, Floats, Ints, dot, marked
from drystone.base.ragged import BATCH, Ragged, expand, first_linked, sum_by_owner
from drystone.geometry import boxes, clip, planar
from drystone.geometry.frames import area_vectors, frames_from_normals
from drystone.geometry.halfedge import NOISE, SMOOTH

KEPT = 0.02
"""Facets are joined when the area of their projection differs from the sum of their areas by less
than this share."""
_CLOSE = 0.02
"""Distance between the edges of neighbouring facets, relative to the root of the larger area.
Chosen: the search drops overlaps narrower than this share of another."""
_LONG = 2.0
"""Neighbours share an edge that is longer than this many such distances. Chosen: facets that only
meet at a corner are not neighbours."""
_OUTLINE = 0.5
"""Corners of the outline of a piece are left out where they are off by less than this share of the
distance of the facets from its plane, or of that between neighbours. Chosen: the outline is as
exact as the surface."""
_SLIVER = 0.2
"""Facets narrower than this share of a neighbour belong to it, however they are turned. They occur
where the two sides of a joint are meshed differently. Chosen."""


@dataclass(frozen=True)
class JoinedFacets:
    """Plane polygons that stand for facets.

    Attributes
    ----------
    point : (k, 3) [m] counter-clockwise about the normals
    start : (p + 1,) corners of each
    normal : (p, 3) unit
    facets
        Which facets each stands for, as rows of ``facet``.
    facet : (m,)
    turn : (p,) [rad]
        Largest angle between a piece and a facet that it stands for, slivers aside.
    moved : (p,) [m]
        Largest distance of the corners of these facets from its plane.
    """

    point: Floats
    start: Ints
    normal: Floats
    facets: Ragged
    facet: Ints
    turn: Floats
    moved: Floats


def smooth_runs(point: Floats, start: Ints, pair: Ints) -> Ints:
    """Number (m,) of the smooth run of each facet: those connected along edges without a crease.

    Parameters
    ----------
    point, start
        Corners (k, 3) [m] of each facet.
    pair : (m,)
        Facets of different pairs of blocks are not connected.
    """
    run = np.arange(len(pair), dtype=np.intp)
    _, place, count = np.unique(pair, return_inverse=True, return_counts=True)
    several = np.flatnonzero(count[place.ravel()] > 1)
    if len(several):
        loops, row = Ragged(start).take(several)
        one, other = _neighbours(point[row], loops, pair[several])
        run[several] = several[first_linked(one, other, len(several))]
    return np.unique(run, return_inverse=True)[1].ravel().astype(np.intp)


def outline(point: Floats, frame: Floats) -> Floats:
    """The convex outline (c, 3) [m] of points (k, 3), in the plane of a frame at their mean."""
    middle = point.mean(axis=0)
    hull = shapely.convex_hull(shapely.multipoints((point - middle) @ frame[1:].T))
    around = shapely.get_coordinates(shapely.normalize(hull))[:-1][::-1]
    return middle + around @ frame[1:]


def joined(point: Floats, start: Ints, pair: Ints, angle: float) -> JoinedFacets | None:
    """Facets of curved runs joined where they turn little; ``None`` where there is nothing to join.

    Parameters
    ----------
    point, start, pair
        As in :func:`smooth_runs`.
    angle : [rad]
        A piece stands for neighbours whose normals are within this angle of their mean. With zero
        only slivers are joined to their neighbours.

    Notes
    -----
    The directions of a run are cut into bands, across the direction in which they vary most, until
    each is narrow enough. Connected facets of a band are one piece.
    """
    loops = Ragged(start)
    vector = area_vectors(point, start)
    area = np.sqrt(dot(vector, vector))
    normal = vector / area[:, None]
    one, other = _neighbours(point, loops, pair)
    run = first_linked(one, other, len(area))
    turn = _turns(normal, vector, run)[0]
    curved = turn > NOISE
    if not curved.any():
        return None
    band = np.where(curved, run, len(run) + np.arange(len(run)))
    band = _bands(normal, vector, band, angle) if angle > 0.0 else np.arange(len(run))
    into = _slivers_into(area, _perimeters(point, loops), one, other)
    into[~curved] = -1
    sliver = np.flatnonzero(into >= 0)
    inside = (band[one] == band[other]) & (into[one] < 0) & (into[other] < 0)
    joins = np.concatenate([one[inside], sliver]), np.concatenate([other[inside], into[sliver]])
    cell = first_linked(*joins, len(area))
    return _united(point, loops, vector, cell, into < 0)


def _neighbours(point: Floats, loops: Ragged, pair: Ints) -> tuple[Ints, Ints]:
    """Facets of one pair of blocks with a common edge and without a crease there."""
    vector = area_vectors(point, loops.start)
    area = np.sqrt(dot(vector, vector))
    normal = vector / area[:, None]
    reach = _CLOSE * np.sqrt(area)
    low = loops.min(point) - reach[:, None]
    high = loops.max(point) + reach[:, None]
    one, other = boxes.overlapping(low, high)
    near = (pair[one] == pair[other]) & (dot(normal[one], normal[other]) >= np.cos(SMOOTH))
    one, other = one[near], other[near]
    meets = np.zeros(len(one), dtype=bool)
    work = Ragged.from_counts(2 * loops.counts[one] * loops.counts[other])
    for batch in work.batches(BATCH // 4):
        meets[batch] = _share_an_edge(point, loops, one[batch], other[batch], reach)
    return one[meets], other[meets]


def _share_an_edge(point: Floats, loops: Ragged, one: Ints, other: Ints, reach: Floats) -> Bools:
    """Whether corners of either facet that lie on the outline of the other span an edge."""
    far = np.maximum(reach[one], reach[other])
    low = np.full((len(one), 3), np.inf)
    high = -low
    following = loops.following
    for mine, theirs in ((one, other), (other, one)):
        row, corner = expand(loops.first[mine], loops.counts[mine])
        line, edge = expand(loops.first[theirs[row]], loops.counts[theirs[row]])
        begin = point[edge]
        along = point[following[edge]] - begin
        local = point[corner[line]] - begin
        length = dot(along, along)
        at = np.clip(dot(local, along) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        away = local - at[:, None] * along
        close = line[dot(away, away) <= far[row[line]] ** 2]
        np.minimum.at(low, row[close], point[corner[close]])
        np.maximum.at(high, row[close], point[corner[close]])
    span = np.where(np.isfinite(low), high - low, 0.0)
    return dot(span, span) > (_LONG * np.minimum(reach[one], reach[other])) ** 2


def _turns(normal: Floats, vector: Floats, group: Ints) -> tuple[Floats, Floats, Floats]:
    """Largest angle (m,) [rad] in the group of each facet, its own, and the mean normal (m, 3)."""
    total = sum_by_owner(vector, group, int(group.max()) + 1)
    mean = total / np.maximum(np.sqrt(dot(total, total)), np.finfo(np.float64).tiny)[:, None]
    off = normal - mean[group]
    own = 2.0 * np.arcsin(np.minimum(0.5 * np.sqrt(dot(off, off)), 1.0))
    worst = np.zeros(len(mean))
    np.maximum.at(worst, group, own)
    return worst[group], own, mean[group]


def _bands(normal: Floats, vector: Floats, group: Ints, angle: float) -> Ints:
    """Groups of facets (m,) cut into groups within an angle [rad] of their mean normal."""
    while True:
        group = np.unique(group, return_inverse=True)[1].ravel()
        worst, own, mean = _turns(normal, vector, group)
        wide = np.flatnonzero(worst > angle)
        if len(wide) == 0:
            return group.astype(np.intp)
        order = wide[np.lexsort((wide, -own[wide], group[wide]))]
        begin = np.flatnonzero(np.diff(group[order], prepend=-1))
        most = order[begin]  # the facet of each group that is turned most
        axis = np.zeros_like(normal)
        axis[group[most]] = normal[most] - mean[most]
        place = dot(normal[order] - mean[order], axis[group[order]])
        rows = Ragged.from_owners(np.cumsum(np.diff(group[order], prepend=-1) > 0) - 1, len(begin))
        scale = rows.spread(np.sqrt(dot(axis[group[most]], axis[group[most]])))
        place /= scale
        low, high = rows.spread(rows.min(place)), rows.spread(rows.max(place))
        several = np.maximum(np.ceil((high - low) / (2.0 * angle)), 2.0)
        share = np.where(high > low, (place - low) / np.where(high > low, high - low, 1.0), 0.0)
        band = np.minimum(np.floor(several * share), several - 1.0).astype(np.intp)
        cut = np.zeros(len(group), dtype=np.intp)
        cut[order] = band
        group = group * (int(band.max()) + 1) + cut


def _perimeters(point: Floats, loops: Ragged) -> Floats:
    edge = point[loops.following] - point
    return loops.sum(np.sqrt(dot(edge, edge)))


def _slivers_into(area: Floats, around: Floats, one: Ints, other: Ints) -> Ints:
    """The widest neighbour (m,) of each facet that is a sliver beside it; -1 for other facets."""
    width = 2.0 * area / around
    mine, theirs = np.concatenate([one, other]), np.concatenate([other, one])
    narrow = width[mine] < _SLIVER * width[theirs]
    mine, theirs = mine[narrow], theirs[narrow]
    order = np.lexsort((-theirs, width[theirs], mine))
    into = np.full(len(area), -1, dtype=np.intp)
    into[mine[order]] = theirs[order]  # the last one of each counts
    return into


def _united(point: Floats, loops: Ragged, vector: Floats, cell: Ints, wide: Bools) -> JoinedFacets:
    """A plane polygon for the facets of each cell; those that have none stay as they are.

    Parameters
    ----------
    wide : (m,)
        Facets that are no slivers.
    """
    area = np.sqrt(dot(vector, vector))
    order = np.argsort(cell, kind="stable")
    _, begin = np.unique(cell[order], return_index=True)
    members = Ragged(np.append(begin, len(order)).astype(np.intp))
    many = np.flatnonzero(members.counts > 1)
    part, row = members.take(many)
    facet = order[row]
    total = part.sum(vector[facet])
    normal = total / np.sqrt(dot(total, total))[:, None]
    weight = area[facet]
    middle = part.sum(weight[:, None] * loops.mean(point)[facet]) / part.sum(weight)[:, None]
    frame = frames_from_normals(normal)
    corners, corner = loops.take(facet)
    of_cell = part.owner[corners.owner]
    flat = np.einsum("lij,lj->li", frame[of_cell, 1:], point[corner] - middle[of_cell])
    off = Ragged(corners.start[part.start]).max(
        np.abs(dot(point[corner] - middle[of_cell], normal[of_cell]))
    )
    reach = _CLOSE * np.sqrt(part.max(weight))
    shape = _closed(flat, corners, part, reach)
    spare = _OUTLINE * np.maximum(off, reach)
    shape = shapely.simplify(shape, spare, preserve_topology=False)
    made, start, source = planar.pieces_of(planar.valid(shape))
    made, start = clip.cleaned(made, start, 1e-3 * reach[source])
    whole = np.bincount(source, minlength=len(many)) == 1
    whole[source[np.diff(start) < 3]] = False
    covered = np.bincount(source, clip.areas(made, start), len(many))
    whole &= np.abs(covered - part.sum(weight)) <= KEPT * part.sum(weight)
    good = whole[source]
    length = np.diff(start)[good]
    kept = made[np.repeat(good, np.diff(start))]
    which = np.repeat(source[good], length)
    joined_point = middle[which] + np.einsum("li,lij->lj", kept, frame[which, 1:])

    alone = ~marked(facet[part.spread(whole)], len(area))
    rest = np.flatnonzero(alone)
    own, own_corner = loops.take(rest)
    together, together_row = part.take(whole)
    angle = part.max(np.where(wide[facet], _between(vector[facet], total[part.owner]), 0.0))
    nothing = np.zeros(len(rest))
    return JoinedFacets(
        np.concatenate([point[own_corner], joined_point]),
        Ragged.from_counts(np.concatenate([own.counts, length])).start,
        np.concatenate([vector[rest] / area[rest, None], normal[whole]]),
        Ragged.from_counts(np.concatenate([np.ones(len(rest), dtype=np.intp), together.counts])),
        np.concatenate([rest, facet[together_row]]),
        np.concatenate([nothing, angle[whole]]),
        np.concatenate([nothing, np.maximum(off, spare)[whole]]),
    )


def _between(one: Floats, other: Floats) -> Floats:
    """Angle (r,) [rad] between vectors (r, 3)."""
    sine = np.linalg.norm(np.cross(one, other), axis=1)
    return np.arctan2(sine, dot(one, other))


def _closed(flat: Floats, corners: Ragged, part: Ragged, reach: Floats) -> planar.Regions:
    """The union (c,) of the polygons of each cell, with gaps up to twice the reach closed."""
    polygon = planar.valid(shapely.polygons(shapely.linearrings(flat, indices=corners.owner)))
    with np.errstate(divide="ignore", invalid="ignore"):  # the tip of a spike has no mitre
        grown = shapely.buffer(polygon, part.spread(reach), join_style="mitre")
    whole = np.empty(len(part), dtype=object)
    for several in np.unique(part.counts):
        mine = np.flatnonzero(part.counts == several)
        rows: Any = grown[part.first[mine, None] + np.arange(several)]
        whole[mine] = shapely.union_all(rows, axis=1)
    return shapely.buffer(whole, -reach, join_style="mitre")
