"""Faces that are apart at the beginning and that blocks may meet as they move.

Two faces that are nearly parallel, face each other and lie apart get an interface whose corners
have a gap. It carries nothing until the gap closes.

Beside these, edges and corners may touch that the search of contacts left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, Ints, cross, frozen
from drystone.base.display import named
from drystone.checks import block_speed
from drystone.contacts import DEFAULT_FRICTION, Contacts, joined_contacts
from drystone.detection import EdgeContacts
from drystone.detection.candidates import near_blocks
from drystone.detection.edgecontacts import edge_contacts
from drystone.detection.misses import edge_misses, face_contacts
from drystone.detection.parallel_edges import ParallelEdges, parallel_edges
from drystone.detection.patches import kept_patches_of
from drystone.detection.resample import resample
from drystone.detection.tolerances import LARGEST, DetectionOptions, Missed
from drystone.mechanics.corners import FaceSides
from drystone.model import Model

FARTHEST = LARGEST["gap"]
"""Largest distance of two faces that may meet, by the smaller block's size."""
BETWEEN = 1e-3
"""By the block's size, how far outside of the two faces a joint of the model may lie that is taken
as the joint of these faces: joints are found halfway between faces that are not quite flat."""
PARALLEL = 0.99
"""Cosine of the largest angle between the normals of a face and of its interface."""


class Apart(NamedTuple):
    """Interfaces that are open at the beginning.

    Attributes
    ----------
    contacts
        Between the faces.
    gap : (k, 2) [m]
        Distance of each corner from the faces of a and b, along n.
    """

    contacts: Contacts
    gap: Floats


@lru_cache(maxsize=2)
def faces_apart(model: Model, reach: float) -> Apart:
    """The faces that blocks may meet.

    Parameters
    ----------
    model
    reach
        Largest distance of two faces, by the smaller block's size.
    """
    assembly = model.assembly
    found = _facing(assembly, min(reach, FARTHEST))
    contacts, size = found.contacts, np.cbrt(assembly.volume)
    a, b = contacts.block_a, contacts.block_b
    margin = BETWEEN * np.minimum(size[a], size[b])
    keep = ~(assembly.fixed[a] & assembly.fixed[b])
    for i in np.flatnonzero(keep).tolist():
        keep[i] = not _is_joint(model.contacts, found, i, float(margin[i]))
    chosen = contacts.select(keep)
    gap = found.gap[keep[contacts.interface]]
    return Apart(chosen.with_friction(least_friction(model, chosen)), gap)


@lru_cache(maxsize=4)
def _facing(assembly: Assembly, reach: float) -> Apart:
    """The faces that are apart; a limit asks for those of the same blocks again and again."""
    options = DetectionOptions(gap=reach, search=reach, edges=EdgeContacts.NEVER, inexact=False)
    patches = kept_patches_of(assembly)
    faces, *_ = face_contacts(patches, near_blocks(patches, options), options)
    found, _ = resample(faces.ordered(), options.curve)
    sides = FaceSides(assembly)
    most = SAME * np.minimum(sides.size[found.block_a], sides.size[found.block_b])
    near = np.abs(found.gap) > most
    contacts = found.contacts(patches.origin, DEFAULT_FRICTION).select(near)
    a, b = contacts.block_a, contacts.block_b
    gap = np.stack(
        [_distance(sides, contacts, a, -1.0), _distance(sides, contacts, b, 1.0)], axis=1
    )
    least = np.full(len(contacts), np.inf)
    np.minimum.at(least, contacts.interface, gap.sum(axis=1))
    apart = least > most[near]
    return Apart(contacts.select(apart), frozen(gap[apart[contacts.interface]]))


def _distance(sides: FaceSides, contacts: Contacts, block: Ints, sign: float) -> Floats:
    """(k,) [m] along n from each corner to the face of its block; -inf where there is none."""
    found = np.full(contacts.corner_count, -np.inf)
    for i in range(len(contacts)):
        corners = slice(contacts.start[i], contacts.start[i + 1])
        n, point = sign * contacts.frame[i, 0], contacts.point[corners]
        here = sides.of_block[int(block[i])]
        faces, first = np.unique(sides.face[here], return_index=True)
        begin, normal = sides.begin[here][first], sides.normal[faces]
        # the face of a looks along n and lies on the side of a; that of b the other way round
        facing = normal @ n < -PARALLEL
        if not facing.any():
            continue
        begin, normal = begin[facing], normal[facing]
        far = ((begin[None] - point[:, None]) * normal).sum(axis=2) / (normal @ n)
        middle = far.mean(axis=0)
        nearest = np.where(middle > 0.0, middle, np.inf).argmin()
        found[corners] = far[:, nearest]
    return found


def _is_joint(joints: Contacts, apart: Apart, i: int, margin: float) -> bool:
    """Whether the model has a joint of the same two faces."""
    contacts = apart.contacts
    corners = slice(contacts.start[i], contacts.start[i + 1])
    n, middle = contacts.frame[i, 0], contacts.point[corners].mean(axis=0)
    reach = 0.5 * float(apart.gap[corners].sum(axis=1).max()) + margin
    pair = [contacts.block_a[i], contacts.block_b[i]]
    same: Bools = np.isin(joints.block_a, pair) & np.isin(joints.block_b, pair)
    same &= np.abs(joints.frame[:, 0] @ n) > PARALLEL
    off = np.abs((joints.point[joints.start[:-1][same]] - middle) @ n)
    return bool((off < reach).any())


def least_friction(model: Model, contacts: Contacts) -> Floats:
    """Coefficients (m,) of contacts that are no joints: the least of the joints of the blocks."""
    joints = model.contacts
    fallback = float(joints.friction.min()) if len(joints) else DEFAULT_FRICTION
    least = np.full(len(model.assembly), np.inf)
    for block in (joints.block_a, joints.block_b):
        np.minimum.at(least, block, joints.friction)
    found = np.minimum(least[contacts.block_a], least[contacts.block_b])
    return np.where(np.isfinite(found), found, fallback)


def followed_model(model: Model, apart: Apart) -> tuple[Model, Floats]:
    """The model with the interfaces that a free block takes part in or may meet, and their gaps."""
    part = _followed(model, apart.contacts)
    touch = part.contacts.corner_count - len(apart.gap)
    return part, np.concatenate([np.zeros((touch, 2)), apart.gap])


@lru_cache(maxsize=2)
def _followed(model: Model, apart: Contacts) -> Model:
    return model.with_contacts(joined_contacts(model.contacts.select(model.active), apart))


def model_with_met(model: Model, apart: Apart, met: Bools) -> tuple[Model, Bools, Bools]:
    """The model with the interfaces that were met on the way.

    Parameters
    ----------
    model, apart
    met : (k,)
        Whether a corner of what :func:`followed_model` gives has ever pressed.

    Returns
    -------
    model
    followed : (l,)
        Corners of that model that were followed.
    kept : (k,)
        Corners that were followed and are in that model.
    """
    own = model.active[model.contacts.interface]
    followed = np.ones(int(own.sum()), dtype=bool)
    later = apart.contacts.interface[met[len(followed) :]]
    joints = np.bincount(later, minlength=len(apart.contacts)) > 0
    mine = joints[apart.contacts.interface]
    whole = model.with_contacts(joined_contacts(model.contacts, apart.contacts.select(joints)))
    ones = np.ones(int(mine.sum()), dtype=bool)
    return whole, np.concatenate([own, ones]), np.concatenate([followed, mine])


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
def further_contacts(
    assembly: Assembly, contacts: Contacts, options: DetectionOptions, parts: bool = False
) -> Further:
    """What blocks touch beside their contacts, with edges and corners.

    The friction of these contacts is that of none. ``parts``: with what they touch where others
    are gone.
    """
    count = len(assembly)
    low = np.minimum(contacts.block_a, contacts.block_b)
    high = np.maximum(contacts.block_a, contacts.block_b)
    known = np.unique(low * count + high)
    found = _searched(assembly, known.astype(np.int64).tobytes(), options)
    keys = found.contacts.block_a * count + found.contacts.block_b
    again = np.flatnonzero(np.isin(keys, known))
    if not parts:
        held = _in_joints(assembly, contacts, found)
        found = replace(found, parallel=found.parallel.take(~held))
    if not len(again):
        return found
    keep = np.ones(len(found.contacts), dtype=bool)
    size = np.cbrt(assembly.volume)
    for i in again.tolist():
        a, b = int(found.contacts.block_a[i]), int(found.contacts.block_b[i])
        near = _ELSEWHERE * float(min(size[a], size[b]))
        joints = np.flatnonzero((low == a) & (high == b))
        keep[i] = all(
            _corner_distance(contacts, int(j), found.contacts.polygon(i)) > near for j in joints
        )
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
            ends[i, side] = any(_corner_distance(contacts, int(j), middle) <= near for j in joints)
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


def _corner_distance(contacts: Contacts, interface: int, points: Floats) -> float:
    """[m] from an interface to the nearest of some points (p, 3)."""
    polygon = contacts.polygon(interface)
    local = (points - polygon[0]) @ contacts.frame[interface].T
    flat = (polygon - polygon[0]) @ contacts.frame[interface, 1:].T
    shape = shapely.convex_hull(shapely.multipoints(flat))
    beside = shapely.distance(shapely.points(local[:, 1:]), shape)
    return float(np.hypot(local[:, 0], beside).min())


def further_of(model: Model, parts: bool = False) -> Further | None:
    """What touches with edges and corners that were not searched; None where they were.

    ``parts`` as in :func:`further_contacts`.
    """
    report = model.report
    if report is None or report.options.edges is not EdgeContacts.ISOLATED:
        return None
    return further_contacts(model.assembly, model.contacts, report.options, parts)


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
