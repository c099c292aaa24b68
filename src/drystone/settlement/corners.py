"""Where each corner of an interface is when one block slides over the other.

A corner is where two edges of the interface meet, and each edge is an edge of one of the two
blocks, or of both where their faces end flush. When block b slides by s over block a, an edge of b
moves along and an edge of a stays. With the outward normals ``m`` of the two edges, their share
``w`` (1: of b, 0: of a) and the distance ``r`` by which the face of the other block goes on beyond
them, the corner moves over a by x:

    m . x = min(m . s, r)      of b: then the face of a ends, and the edge is that of a
    m . x = min(0, m . s + r)  of a: then the face of b ends

so that the corner is always on both faces. Where the two faces have nothing in common any more, the
corner carries nothing.
"""

from __future__ import annotations

import enum
from typing import NamedTuple

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, cross
from drystone.contacts import Contacts
from drystone.geometry.body.polyhedron import Faces

FLUSH = 1e-6
"""Distance below which an edge of an interface lies on an edge of a block, by the block's size."""
STRAIGHT = 1e-6
"""Sine of the angle between two edges below which they are one side."""
BENT = 1e-3
"""Sine of the angle between two faces of a block above which they meet at an edge."""
FLUSH_REACH = 0.02
"""By the smaller block's size, how far an edge where both faces end flush goes with the block that
carries it: the other face is taken as longer by as much as what stands may move."""
COPLANAR = 0.01
"""Largest distance between an interface and a face that it lies on, by the block's size, and
largest sine of the angle between them: contacts are found on faces that are not quite flat."""


class Carrier(enum.Enum):
    """Which block carries the ends of a joint where the faces of both end flush."""

    MOVING = "moving"
    """The block that is farther from the supports."""
    RESTING = "resting"
    """The block that is nearer to the supports."""


class Ends(NamedTuple):
    """The two edges that end at each corner: the one that follows, and the one before.

    Attributes
    ----------
    outward : (k, 2, 2) normals m, local u and v
    share : (k, 2) w
    tangent : (k, 2, 2) x by s, before a face ends
    sense : (k, 2) sign of ``m . s`` towards the end of the other face
    reach : (k, 2) r [m]
    joint : (k,) interface of each corner
    after : (k,) corner that follows around its interface
    place : (k, 2) [m] corners in the axes u and v of their interface
    """

    outward: Floats
    share: Floats
    tangent: Floats
    sense: Floats
    reach: Floats
    joint: Ints
    after: Ints
    place: Floats


def joint_ends(assembly: Assembly, contacts: Contacts, carrier: Carrier) -> Ends:
    """The ends of all interfaces.

    Parameters
    ----------
    assembly, contacts
    carrier
        The choice at edges that belong to both blocks.
    """
    after, before = _neighbours(contacts)
    outward = _outward(contacts, after)
    (of_a, bend_a), (of_b, bend_b) = _edge_owners(assembly, contacts, outward)
    away = distance_from_supports(assembly, contacts)
    far = np.sign(away[contacts.block_b] - away[contacts.block_a])
    joint = contacts.interface
    both = (0.5 + 0.5 * (far if carrier is Carrier.MOVING else -far))[joint]
    both = np.where(_fitted(bend_a, bend_b), bend_b > bend_a, both)
    share = np.where(of_b & ~of_a, 1.0, np.where(of_a & ~of_b, 0.0, both))
    reach = _reach(assembly, contacts, of_a, of_b, outward)
    edges = np.stack([outward, outward[before]], axis=1)
    weight = np.stack([share, share[before]], axis=1)
    limit = np.stack([reach, reach[before]], axis=1)
    bent = np.abs(np.linalg.det(edges)) > STRAIGHT
    # lines, points, and corners in the middle of a side have one share in every direction
    edges[~bent] = np.eye(2)
    weight[~bent] = weight[~bent].mean(axis=1, keepdims=True)
    limit[~bent] = np.inf
    axes = contacts.frame[joint, 1:]
    place = np.einsum("kij,kj->ki", axes, contacts.point - contacts.point[contacts.start[joint]])
    tangent: Floats = np.asarray(
        np.linalg.solve(edges, weight[:, :, None] * edges), dtype=np.float64
    )
    sense = (weight == 1.0).astype(np.float64) - (weight == 0.0)
    return Ends(edges, weight, tangent, sense, limit, joint, after, place)


def flush_ends(assembly: Assembly, contacts: Contacts) -> bool:
    """Whether the carrier makes a difference: somewhere an edge belongs to both blocks."""
    outward = _outward(contacts, _neighbours(contacts)[0])
    (of_a, bend_a), (of_b, bend_b) = _edge_owners(assembly, contacts, outward)
    away = distance_from_supports(assembly, contacts)
    unlike = (away[contacts.block_a] != away[contacts.block_b])[contacts.interface]
    return bool(((of_a == of_b) & unlike & ~_fitted(bend_a, bend_b)).any())


def _fitted(bend_a: Floats, bend_b: Floats) -> Bools:
    """(k,) whether a convex edge of one block lies in a re-entrant edge of the other."""
    return np.asarray((np.minimum(bend_a, bend_b) < -BENT) & (np.maximum(bend_a, bend_b) > BENT))


def slid(ends: Ends, slide: Floats) -> tuple[Floats, Floats, Bools]:
    """Where corners go when b slides over a by (k, 2).

    Returns the motion x (k, 2), its derivative (k, 2, 2), and which are still on both faces (k,).
    """
    along = (ends.outward @ slide[:, :, None])[:, :, 0]
    beyond = ends.sense * along > ends.reach
    if not beyond.any():
        carried = (ends.tangent @ slide[:, :, None])[:, :, 0]
        return carried, ends.tangent, np.ones(len(along), dtype=bool)
    weight = np.where(beyond, 1.0 - ends.share, ends.share)
    # of b: r beyond the end of the face of a; of a: s + r beyond the end of that of b
    shift = weight * along + np.where(beyond, ends.reach, 0.0)
    right = np.concatenate([shift[:, :, None], weight[:, :, None] * ends.outward], axis=2)
    solved: Floats = np.asarray(np.linalg.solve(ends.outward, right), dtype=np.float64)
    carried = solved[:, :, 0]
    return carried, solved[:, :, 1:], _on_both(ends, carried)


def _on_both(ends: Ends, carried: Floats) -> Bools:
    """(k,) whether the two faces of the interface still have an area in common."""
    edge = ends.place[ends.after] - ends.place
    now = edge + carried[ends.after] - carried
    spot = ends.place + carried
    twice = spot[:, 0] * now[:, 1] - spot[:, 1] * now[:, 0]
    was = ends.place[:, 0] * edge[:, 1] - ends.place[:, 1] * edge[:, 0]
    count = int(ends.joint.max(initial=-1)) + 1
    area, before = (np.bincount(ends.joint, one, count) for one in (twice, was))
    forward = np.bincount(ends.joint, (edge * now).sum(axis=1) > 0.0, count) > 0
    # an interface that is a line or a point has no area to lose
    flat = before <= 1e-12 * np.bincount(ends.joint, (edge**2).sum(axis=1), count)
    return np.asarray((flat | ((area > 0.0) & forward))[ends.joint])


def _reach(
    assembly: Assembly, contacts: Contacts, of_a: Bools, of_b: Bools, outward: Floats
) -> Floats:
    """(k,) [m] how far the face of the block that does not carry the edge goes on beyond it."""
    size = np.minimum(
        np.cbrt(assembly.volume)[contacts.block_a], np.cbrt(assembly.volume)[contacts.block_b]
    )
    reach = np.where(of_a & of_b, FLUSH_REACH * size[contacts.interface], np.inf)
    after, _ = _neighbours(contacts)
    sides = _FaceSides(assembly)
    for block, alone in ((contacts.block_a, of_b & ~of_a), (contacts.block_b, of_a & ~of_b)):
        alone = alone & outward.any(axis=1)
        for i in np.unique(contacts.interface[alone]).tolist():
            here = np.flatnonzero(alone & (contacts.interface == i))
            frame, origin = contacts.frame[i], contacts.point[contacts.start[i]]
            segments = sides.in_plane(int(block[i]), frame, origin)
            middle = 0.5 * (contacts.point[here] + contacts.point[after[here]])
            at = (middle - origin) @ frame[1:].T
            reach[here] = _to_the_end(at, outward[here], segments)
    return reach


class _FaceSides:
    """The sides of the faces of all blocks."""

    def __init__(self, assembly: Assembly) -> None:
        faces: Faces = assembly.faces
        following = np.arange(len(faces.loop)) + 1
        following[faces.start[1:] - 1] = faces.start[:-1]
        self.begin, self.end = faces.point[faces.loop], faces.point[faces.loop[following]]
        self.face = np.repeat(np.arange(faces.count), np.diff(faces.start))
        # relative to the first corner of the face, so a distant origin costs no digits
        first = self.begin[faces.start[:-1]][self.face]
        twice = np.zeros((faces.count, 3))
        np.add.at(twice, self.face, cross(self.begin - first, self.end - first))
        length = np.linalg.norm(twice, axis=1, keepdims=True)
        self.normal = twice / np.where(length > 0.0, length, 1.0)
        owner = faces.owner[self.face]
        order = np.argsort(owner, kind="stable")
        bounds = np.searchsorted(owner[order], np.arange(len(assembly) + 1))
        self.of_block = [order[bounds[i] : bounds[i + 1]] for i in range(len(assembly))]
        self.size = np.cbrt(assembly.volume)

    def in_plane(self, block: int, frame: Floats, origin: Floats) -> Floats:
        """Ends (e, 2, 2), local u and v, of the outer sides of the faces of a block in a plane."""
        here = self.of_block[block]
        begin, end = self.begin[here] - origin, self.end[here] - origin
        size = self.size[block]
        lean = np.linalg.norm(cross(self.normal[self.face[here]], frame[0][None]), axis=1)
        near = np.maximum(np.abs(begin @ frame[0]), np.abs(end @ frame[0])) < COPLANAR * size
        flat = (lean < COPLANAR) & near
        ends = np.stack([begin[flat], end[flat]], axis=1) @ frame[1:].T
        # sides between two faces in the plane are no ends
        back = np.abs(ends[:, None, ::-1] - ends[None]).max(axis=(2, 3), initial=0.0)
        inner = (back < FLUSH * size).any(axis=1)
        return np.asarray(ends[~inner])


def _to_the_end(at: Floats, outward: Floats, segments: Floats) -> Floats:
    """(c,) distance from points (c, 2) along directions (c, 2) to one of segments (e, 2, 2)."""
    run = segments[:, 1] - segments[:, 0]
    arm = segments[None, :, 0] - at[:, None]
    turn = outward[:, None, 0] * run[None, :, 1] - outward[:, None, 1] * run[None, :, 0]
    safe = np.where(np.abs(turn) > 0.0, turn, 1.0)
    far = (arm[..., 0] * run[None, :, 1] - arm[..., 1] * run[None, :, 0]) / safe
    part = (arm[..., 0] * outward[:, None, 1] - arm[..., 1] * outward[:, None, 0]) / safe
    length = np.linalg.norm(run, axis=1)[None]
    met = (np.abs(turn) > 1e-6 * length) & (far > 0.0) & (part >= 0.0) & (part <= 1.0)
    return np.asarray(np.where(met, far, np.inf).min(axis=1, initial=np.inf))


def distance_from_supports(assembly: Assembly, contacts: Contacts) -> Ints:
    """Number of joints (n,) between each block and the nearest support; n if not connected."""
    count = len(assembly)
    away = np.where(assembly.fixed, 0, count)
    a, b = contacts.block_a, contacts.block_b
    while True:
        nearer = away.copy()
        np.minimum.at(nearer, a, away[b] + 1)
        np.minimum.at(nearer, b, away[a] + 1)
        if (nearer == away).all():
            return away
        away = nearer


def _neighbours(contacts: Contacts) -> tuple[Ints, Ints]:
    """(k,) the corner that follows each around its interface, and the one before."""
    start = contacts.start
    after = np.arange(contacts.corner_count) + 1
    after[start[1:] - 1] = start[:-1]
    before = np.empty_like(after)
    before[after] = np.arange(len(after))
    return after, before


def _outward(contacts: Contacts, after: Ints) -> Floats:
    """(k, 2) normal of the edge from each corner to the next, in its plane; zero for a point."""
    edge = contacts.point[after] - contacts.point
    axes = contacts.frame[contacts.interface, 1:]
    along = np.einsum("kij,kj->ki", axes, edge)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along = along / np.where(length > 0.0, length, 1.0)
    return np.stack([along[:, 1], -along[:, 0]], axis=1)


def _edge_owners(
    assembly: Assembly, contacts: Contacts, outward: Floats
) -> list[tuple[Bools, Floats]]:
    """For blocks a and b, of the edge from each corner to the next: is it theirs, and its bend.

    The bend (k,) is the sine of the angle by which the block's surface turns away from the
    interface at the edge: positive at a convex edge, negative at a re-entrant one.
    """
    after, _ = _neighbours(contacts)
    middle = 0.5 * (contacts.point + contacts.point[after])
    along = contacts.point[after] - contacts.point
    away = np.einsum("kij,ki->kj", contacts.frame[contacts.interface, 1:], outward)
    found = []
    segments, normals = _block_edges(assembly)
    for block in (contacts.block_a, contacts.block_b):
        of_corner = block[contacts.interface]
        owned, bend = np.zeros(len(middle), dtype=bool), np.zeros(len(middle))
        order = np.argsort(of_corner, kind="stable")
        starts = np.searchsorted(of_corner[order], np.arange(len(assembly) + 1))
        for i in np.unique(of_corner).tolist():
            here = order[starts[i] : starts[i + 1]]
            on = _on_edges(middle[here], along[here], segments[i], assembly.size[i])
            owned[here] = on.any(axis=1)
            turned = np.where(on, away[here] @ normals[i].T, 0.0)
            most = np.abs(turned).argmax(axis=1)
            bend[here] = turned[np.arange(len(here)), most]
        found.append((owned, bend))
    return found


def _block_edges(assembly: Assembly) -> tuple[list[Floats], list[Floats]]:
    """Per block the ends (e, 2, 3) of the sides of its faces, and normals (e, 3) of the faces."""
    faces = assembly.faces
    following = np.arange(len(faces.loop)) + 1
    following[faces.start[1:] - 1] = faces.start[:-1]
    ends = np.stack([faces.point[faces.loop], faces.point[faces.loop[following]]], axis=1)
    owner = np.repeat(faces.owner, np.diff(faces.start))
    bounds = np.searchsorted(owner, np.arange(len(assembly) + 1))
    normal = _FaceSides(assembly).normal[np.repeat(np.arange(faces.count), np.diff(faces.start))]
    parts = [slice(bounds[i], bounds[i + 1]) for i in range(len(assembly))]
    return [ends[part] for part in parts], [normal[part] for part in parts]


def _on_edges(middle: Floats, along: Floats, segments: Floats, size: float) -> Bools:
    """(k, e) whether a point lies on a segment (e, 2, 3) that runs along a direction."""
    begin, run = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(run, axis=1)
    axis = run / np.where(length > 0.0, length, 1.0)[:, None]
    arm = middle[:, None] - begin[None]
    at = np.einsum("kej,ej->ke", arm, axis)
    off = np.linalg.norm(arm - at[..., None] * axis[None], axis=2)
    near = (off < FLUSH * size) & (at > -FLUSH * size) & (at < length + FLUSH * size)
    reach = np.linalg.norm(along, axis=1)
    direction = along / np.where(reach > 0.0, reach, 1.0)[:, None]
    askew = np.linalg.norm(cross(direction[:, None], axis[None]), axis=2)
    parallel = (askew < 1e-3) | (reach == 0.0)[:, None]
    return np.asarray(near & parallel)


__all__ = ["Carrier", "Ends", "distance_from_supports", "flush_ends", "joint_ends", "slid"]
