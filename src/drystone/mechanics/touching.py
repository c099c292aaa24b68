"""Edges and corners that touch and that the search of contacts left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, cross
from drystone.base.display import named
from drystone.checks import block_speed
from drystone.contacts import Contacts, joined_contacts
from drystone.detection import EdgeContacts
from drystone.detection.candidates import near_blocks
from drystone.detection.edgecontacts import edge_contacts
from drystone.detection.misses import edge_misses
from drystone.detection.parallel_edges import ParallelEdges, parallel_edges
from drystone.detection.patches import kept_patches_of
from drystone.detection.tolerances import DetectionOptions, Missed
from drystone.mechanics.meeting import least_friction
from drystone.model import Model

_ELSEWHERE = 0.05
"""Distance from the joints of two blocks, by the size of the smaller one, from which on an edge of
one that is not convex touches the other elsewhere. Chosen: nearer to it the joint stands for it."""

_AT_EDGE = 0.01
"""Distance from a joint, by the size of the block, within which an edge ends it. Chosen."""


@dataclass(frozen=True)
class Further:
    """Where blocks touch with edges and corners only.

    Attributes
    ----------
    contacts
        Edges and corners on faces, and edges that cross.
    parallel
        Parallel edges that meet, of pairs that touch nowhere else.
    corners : (u, 2)
        Pairs that meet at corners only, where a contact has no direction.
    """

    contacts: Contacts
    parallel: ParallelEdges
    corners: Ints


@lru_cache(maxsize=8)
def further_contacts(assembly: Assembly, contacts: Contacts, options: DetectionOptions) -> Further:
    """What blocks touch beside their contacts, with edges and corners.

    The friction of these contacts is that of none.
    """
    count = len(assembly)
    low = np.minimum(contacts.block_a, contacts.block_b)
    high = np.maximum(contacts.block_a, contacts.block_b)
    known = np.unique(low * count + high)
    found = _searched(assembly, known.astype(np.int64).tobytes(), options)
    keys = found.contacts.block_a * count + found.contacts.block_b
    again = np.flatnonzero(np.isin(keys, known))
    found = replace(found, parallel=found.parallel.take(~_in_joints(assembly, contacts, found)))
    if not len(again):
        return found
    keep = np.ones(len(found.contacts), dtype=bool)
    size = np.cbrt(assembly.volume)
    for i in again.tolist():
        a, b = int(found.contacts.block_a[i]), int(found.contacts.block_b[i])
        near = _ELSEWHERE * float(min(size[a], size[b]))
        joints = np.flatnonzero((low == a) & (high == b))
        keep[i] = all(_distance(contacts, int(j), found.contacts.polygon(i)) > near for j in joints)
    return replace(found, contacts=found.contacts.select(keep))


def _in_joints(assembly: Assembly, contacts: Contacts, found: Further) -> Bools:
    """Which parallel edges (p,) both end a joint of their block with another one.

    Four blocks whose edges meet in one line press with their faces. What two of them do across the
    line is then decided by the joints, and the line holds nothing.
    """
    edges, size = found.parallel, np.cbrt(assembly.volume)
    ends = np.zeros((len(edges), 2), dtype=bool)
    for side, block in enumerate((edges.block_a, edges.block_b)):
        for i, one in enumerate(block.tolist()):
            of_block = (contacts.block_a == one) | (contacts.block_b == one)
            joints = np.flatnonzero(of_block & (contacts.area > 0.0))
            middle, near = edges.point[i].mean(axis=0, keepdims=True), _AT_EDGE * float(size[one])
            ends[i, side] = any(_distance(contacts, int(j), middle) <= near for j in joints)
    return np.asarray(ends.all(axis=1))


@lru_cache(maxsize=8)
def _searched(assembly: Assembly, known: bytes, options: DetectionOptions) -> Further:
    """A limit asks for the same blocks again and again."""
    patches = kept_patches_of(assembly)
    a, b = near_blocks(patches, options)
    free = ~(assembly.fixed[a] & assembly.fixed[b])
    a, b = a[free], b[free]
    joined = np.isin(a * len(assembly) + b, np.frombuffer(known, dtype=np.int64))
    # two convex blocks that share a face touch nowhere else
    several = joined & ~(patches.block_convex[a] & patches.block_convex[b])
    some = ~joined | several
    reach = options.reach(np.minimum(patches.size[a], patches.size[b]))[some]
    lines, undirected = edge_contacts(assembly, patches, (a[some], b[some]), reach, options)
    keys = a[several] * len(assembly) + b[several]
    meets = undirected[~np.isin(undirected[:, 0] * len(assembly) + undirected[:, 1], keys)]
    parallel = parallel_edges(assembly, patches, (meets[:, 0], meets[:, 1]), options)
    directed = parallel.block_a * len(assembly) + parallel.block_b
    corners = meets[~np.isin(meets[:, 0] * len(assembly) + meets[:, 1], directed)]
    return Further(lines.contacts(patches.origin, 0.0), parallel, corners)


def _distance(contacts: Contacts, interface: int, points: Floats) -> float:
    """[m] from an interface to the nearest of some points (p, 3)."""
    polygon = contacts.polygon(interface)
    local = (points - polygon[0]) @ contacts.frame[interface].T
    flat = (polygon - polygon[0]) @ contacts.frame[interface, 1:].T
    shape = shapely.convex_hull(shapely.multipoints(flat))
    beside = shapely.distance(shapely.points(local[:, 1:]), shape)
    return float(np.hypot(local[:, 0], beside).min())


def further_of(model: Model) -> Further | None:
    """What touches with edges and corners that were not searched; None where they were."""
    report = model.report
    if report is None or report.options.edges is not EdgeContacts.ISOLATED:
        return None
    return further_contacts(model.assembly, model.contacts, report.options)


def with_edges(model: Model, more: Contacts) -> Model:
    """The model with more contacts, and a note of them."""
    names = model.assembly.names
    pairs = sorted(set(zip(more.block_a.tolist(), more.block_b.tolist(), strict=True)))
    told = named([f"{names[a]}-{names[b]}" for a, b in pairs])
    note = f"edges and corners touch as well, where it would fall without: {told}"
    joined = joined_contacts(model.contacts, more)
    return replace(model, contacts=joined, notes=(*model.notes, note))


def approach(assembly: Assembly, edges: ParallelEdges, motion: Floats) -> tuple[Floats, Floats]:
    """How parallel edges (m,) come nearer to each other in a motion (n, 6) of the blocks.

    Returns
    -------
    closing : (m,)
        By the speed of the fastest block; negative where they part, about zero where they pass.
    turned : (m,)
        The end of the range of each normal to which they move: -1 or 1.
    """
    at_a, at_b = (
        motion[block, None, :3]
        + cross(motion[block, None, 3:], edges.point - assembly.centroid[block, None])
        for block in (edges.block_a, edges.block_b)
    )
    opening, turned = edges.approached(at_b - at_a)
    return -opening / float(block_speed(assembly, motion).max(initial=0.0)), turned


def with_what_touches(model: Model, motion: Floats) -> Model | None:
    """The model with edges and corners that touch, where it falls without by some motion (n, 6).

    Parallel edges that come nearer press along the middle one of their directions; those that pass
    hold nothing. None where nothing more touches.
    """
    found = further_of(model)
    if found is None or not motion.any():
        return None
    edges = found.parallel.take(approach(model.assembly, found.parallel, motion)[0] > 0.0)
    straight = np.zeros(len(edges))
    more = joined_contacts(found.contacts, edges.contacts(straight, straight))
    if not len(more):
        return None
    return with_edges(model, more.with_friction(least_friction(model, more)))


def near_edges(model: Model, moving: Bools) -> tuple[Missed, ...]:
    """Where edges and corners of blocks that move (n,) are near others that they do not touch.

    They were not searched where both blocks have faces that touch others.
    """
    if further_of(model) is None or model.report is None:
        return ()
    pairs = _apart(model.assembly, model.contacts, model.report.options)
    some = moving[pairs[:, 0]] | moving[pairs[:, 1]]
    for one in model.unjoined:
        some[(pairs == [one.block_a, one.block_b]).all(axis=1)] = False
    chosen = pairs[some].T.tobytes()
    return _missed(model.assembly, chosen, model.report.options) if some.any() else ()


@lru_cache(maxsize=8)
def _apart(assembly: Assembly, contacts: Contacts, options: DetectionOptions) -> Ints:
    """Pairs (p, 2) of blocks that are near and touch nowhere."""
    touching, count = further_contacts(assembly, contacts, options), len(assembly)
    a, b = near_blocks(kept_patches_of(assembly), options)
    every = (contacts, touching.contacts, touching.parallel)
    known = [np.sort(np.stack([each.block_a, each.block_b], axis=1), axis=1) for each in every]
    low, high = np.concatenate([*known, touching.corners]).T
    apart = ~np.isin(a * count + b, low * count + high)
    return np.stack([a[apart], b[apart]], axis=1)


@lru_cache(maxsize=8)
def _missed(assembly: Assembly, pairs: bytes, options: DetectionOptions) -> tuple[Missed, ...]:
    """Near edges of pairs of blocks (2, p); a limit asks for the same ones again and again."""
    a, b = np.frombuffer(pairs, dtype=np.intp).reshape(2, -1)
    return tuple(edge_misses(assembly, kept_patches_of(assembly), (a, b), (), options)[0])
