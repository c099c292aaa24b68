"""No proof of falling rests on edges and corners that touch and were not searched.

Contacts of edges and corners that the search of contacts leaves out are looked for on what falls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, cross
from drystone.base.display import named
from drystone.base.errors import counted
from drystone.checks import block_speed, mechanism_defects
from drystone.contacts import Contacts, joined_contacts
from drystone.detection import EdgeContacts
from drystone.detection.candidates import near_blocks
from drystone.detection.detection_options import DetectionOptions
from drystone.detection.edgecontacts import edge_contacts
from drystone.detection.parallel_edges import ParallelEdges, parallel_edges
from drystone.detection.patches import patches_of
from drystone.geometry.frames import frames_from_normals
from drystone.mechanics.meeting import least_friction
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability.proofs import MECHANISM_TOLERANCE, part_of_fall, withdrawn

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


def held_everywhere(pairs: Ints, bounds: Floats, friction: float) -> Contacts:
    """Contacts that hold pairs (u, 2) in every direction where they meet.

    Parameters
    ----------
    pairs
    bounds : (n, 2, 3) [m]
        Lowest and highest corner of each block.
    friction
    """
    both = bounds[pairs]
    middle = 0.5 * (both[:, :, 0].max(axis=1) + both[:, :, 1].min(axis=1))
    count, normal = 6 * len(pairs), np.concatenate([np.eye(3), -np.eye(3)])
    return Contacts(
        np.repeat(pairs[:, 0], 6),
        np.repeat(pairs[:, 1], 6),
        frames_from_normals(np.tile(normal, (len(pairs), 1))),
        np.zeros(count),
        np.full(count, friction),
        np.repeat(middle, 6, axis=0),
        np.arange(count, dtype=np.intp),
    )


@lru_cache(maxsize=8)
def _searched(assembly: Assembly, known: bytes, options: DetectionOptions) -> Further:
    """A limit asks for the same blocks again and again."""
    patches = patches_of(assembly)
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


def unless_edges_hold(found: Result, check: Callable[[Model], Result]) -> Result:
    """The result as it is, or that with the edges and corners that touch and may hold what falls.

    Parallel edges that meet press along a normal that may have a range of directions. They hold
    where they hold with the middle one and with both ends; where they do not hold with each of
    them, nobody knows. Edges that pass each other along a face, as those of a block that slides out
    of a wall, do not press.

    Parameters
    ----------
    found
    check
        Gives the verdict on the same model with more contacts.
    """
    model = found.model
    further = _further(model) if found.verdict is Verdict.UNSTABLE else None
    if further is None:
        return found
    moving = part_of_fall(found)

    def of_moving(contacts: Contacts) -> Bools:
        """Those (m,) of a block that moves."""
        chosen: Bools = moving[contacts.block_a] | moving[contacts.block_b]
        return chosen

    lines = further.contacts.select(of_moving(further.contacts))
    lines = lines.with_friction(least_friction(model, lines))
    if _may_hold(found, lines):
        return check(_with(model, lines))
    edges = further.parallel
    edges = edges.take(moving[edges.block_a] | moving[edges.block_b])
    turned = _turned(found, edges)
    if turned is not None:
        straight = np.zeros(len(edges))
        friction = least_friction(model, edges.contacts(straight, straight))

        def pressed(turn: Floats) -> Result:
            """The verdict where the edges press in one direction of their range."""
            return check(_with(model, edges.contacts(turn, friction)))

        middle = pressed(straight)
        if middle.verdict is Verdict.UNSTABLE or all(
            pressed(end).verdict is middle.verdict for end in (turned, -turned)
        ):
            return middle
        return _undecided(found, np.stack([edges.block_a, edges.block_b], axis=1), "parallel edges")
    meet = further.corners[moving[further.corners].any(axis=1)]
    if len(meet):
        most = float(model.contacts.friction.max(initial=1.0))
        held = held_everywhere(meet, model.assembly.bounds, most)
        if check(_with(model, held)).verdict is not Verdict.UNSTABLE:
            return _undecided(found, meet, "corners")
    return found


def may_touch_more(model: Model) -> bool:
    """Whether pairs of blocks are near, or touch with edges and corners that are no contacts."""
    if model.unjoined:
        return True
    found = _further(model)
    if found is None:
        return False
    return bool(len(found.contacts) or len(found.parallel) or len(found.corners))


def _further(model: Model) -> Further | None:
    """What touches with edges and corners that were not searched; None where they were."""
    report = model.report
    if report is None or report.options.edges is not EdgeContacts.ISOLATED:
        return None
    return further_contacts(model.assembly, model.contacts, report.options)


def _may_hold(found: Result, more: Contacts) -> bool:
    """Whether the motion of what falls is none where the blocks touch as well."""
    if not len(more) or found.mechanism is None:
        return len(more) > 0
    touching = found.model.with_contacts(more)
    return mechanism_defects(touching, found.mechanism)[0] > MECHANISM_TOLERANCE


def _turned(found: Result, edges: ParallelEdges) -> Floats | None:
    """The end (m,) of the range of each normal to which the edges move; None where they pass."""
    if not len(edges):
        return None
    if found.mechanism is None:
        return np.ones(len(edges))
    motion, centroid = found.mechanism, found.assembly.centroid
    at_a, at_b = (
        motion[block, None, :3]
        + cross(motion[block, None, 3:], edges.point - centroid[block, None])
        for block in (edges.block_a, edges.block_b)
    )
    opening, turned = edges.approached(at_b - at_a)
    speed = float(block_speed(found.assembly, motion).max(initial=0.0))
    return turned if opening.min() < -MECHANISM_TOLERANCE * speed else None


def _with(model: Model, more: Contacts) -> Model:
    """The model with more contacts, and a note of them."""
    names = model.assembly.names
    pairs = sorted(set(zip(more.block_a.tolist(), more.block_b.tolist(), strict=True)))
    told = named([f"{names[a]}-{names[b]}" for a, b in pairs])
    note = f"edges and corners touch as well, where it would fall without: {told}"
    joined = joined_contacts(model.contacts, more)
    return replace(model, contacts=joined, notes=(*model.notes, note))


def _undecided(found: Result, pairs: Ints, what: str) -> Result:
    """UNDECIDED: nobody knows in which direction some pairs (u, 2) press."""
    (a, b), names = pairs[0], found.assembly.names
    said = f"{what} of '{names[a]}' and '{names[b]}' meet"
    if len(pairs) > 1:
        said += f", and those of {counted(len(pairs) - 1, 'more pair')}"
    return withdrawn(found, f"it depends on the direction in which edges press: {said}")
