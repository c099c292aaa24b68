"""Where each corner of an interface is when one block slides over the other.

A corner is where two edges of the interface meet, and each edge is an edge of one of the two
blocks, or of both where their faces end flush. When block b slides by s over block a, an edge of b
moves along and an edge of a stays. Where a convex edge of one block lies in a re-entrant edge of
the other, as between the strips of a curved joint, it is that of the convex one. With the outward
normals ``m`` of the two edges, their share ``w`` (1: of b, 0: of a) and the distance ``r`` by which
the face of the other block goes on beyond them, the corner moves over a by x:

    m . x = min(m . s, r)      of b: then the face of a ends, and the edge is that of a
    m . x = min(0, m . s + r)  of a: then the face of b ends

so that the corner is always on both faces. Where the two faces have nothing in common any more, the
corner carries nothing.
"""

from __future__ import annotations

import enum
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, SAME, Bools, Floats, Ints, dot, plane_cross
from drystone.contacts import Contacts
from drystone.geometry.halfedge import BENT
from drystone.mechanics.face_edges import FaceSides, to_the_end
from drystone.model import FlushEnds, Model

FLUSH_REACH = 0.02
"""By the smaller block's size, how far an edge where both faces end flush goes with the block that
carries it: the other face is taken as longer by as much as what stands may move."""

NEARER = 0.5
"""An edge of an imperfect joint belongs to both blocks, unless the nearest edge of one is so much
nearer than that of the other, which is not flush with it. Chosen."""


class Carrier(enum.Enum):
    """Which block carries the ends of a joint where the faces of both end flush."""

    MOVING = "moving"
    """The block that is farther from the supports."""
    RESTING = "resting"
    """The block that is nearer to the supports."""
    EXACT = "exact"
    """Neither goes on beyond the end of the other: the faces end where they are drawn."""
    LONGER = "longer"
    """As moving, and faces that are longer by less than what stands may move go on as well."""


CARRIER = {None: None, FlushEnds.LONGER: Carrier.MOVING, FlushEnds.EXACT: Carrier.EXACT}
"""The carrier that a model asks for by its ``ends``, if any."""


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
    drawn : (k, 2) r [m] of the faces as they are drawn: less where they are taken as longer
    """

    outward: Floats
    share: Floats
    tangent: Floats
    sense: Floats
    reach: Floats
    joint: Ints
    after: Ints
    place: Floats
    drawn: Floats


def joint_ends(assembly: Assembly, contacts: Contacts, carrier: Carrier, gap: Floats) -> Ends:
    """The ends of all interfaces.

    Parameters
    ----------
    assembly, contacts
    carrier
        The choice at edges that belong to both blocks.
    gap : (k, 2) [m]
        Distance of each corner from the faces of a and b, along n.
    """
    after = contacts.corners.following
    before = np.argsort(after)
    edges_of = _edges(assembly, contacts, gap.tobytes())
    of_a, of_b = edges_of.owned
    away = distance_from_supports(assembly, contacts)
    far = np.sign(away[contacts.block_b] - away[contacts.block_a])
    joint = contacts.interface
    both = (0.5 + 0.5 * (-far if carrier is Carrier.RESTING else far))[joint]
    both = np.where(edges_of.fitted, edges_of.bend[1] > 0.0, both)
    share = np.where(of_b & ~of_a, 1.0, np.where(of_a & ~of_b, 0.0, both))
    outward, reach = edges_of.outward, edges_of.reach
    flush = (of_a == of_b) & (far != 0.0)[joint] & ~edges_of.fitted
    drawn = np.where(flush, 0.0, reach)
    if carrier is Carrier.EXACT:
        reach = drawn
    if carrier is Carrier.LONGER:
        reach = np.where(edges_of.fitted, reach, np.maximum(reach, edges_of.longer))
    edges = np.stack([outward, outward[before]], axis=1)
    weight = np.stack([share, share[before]], axis=1)
    limit, least = (np.stack([one, one[before]], axis=1) for one in (reach, drawn))
    bent = np.abs(np.linalg.det(edges)) > SAME
    # lines, points, and corners in the middle of a side have one share in every direction
    edges[~bent] = np.eye(2)
    weight[~bent] = weight[~bent].mean(axis=1, keepdims=True)
    limit[~bent] = least[~bent] = np.inf
    axes = contacts.frame[joint, 1:]
    place = np.einsum("kij,kj->ki", axes, contacts.point - contacts.point[contacts.start[joint]])
    tangent: Floats = np.asarray(
        np.linalg.solve(edges, weight[:, :, None] * edges), dtype=np.float64
    )
    sense = (weight == 1.0).astype(np.float64) - (weight == 0.0)
    return Ends(edges, weight, tangent, sense, limit, joint, after, place, least)


def flush_ends(assembly: Assembly, contacts: Contacts) -> bool:
    """Whether the carrier makes a difference: somewhere an edge belongs to both blocks."""
    edges = _edges(assembly, contacts, bytes(16 * contacts.corner_count))
    away = distance_from_supports(assembly, contacts)
    unlike = (away[contacts.block_a] != away[contacts.block_b])[contacts.interface]
    return bool(((edges.owned[0] == edges.owned[1]) & unlike & ~edges.fitted).any())


@lru_cache(maxsize=2)
def _edges(assembly: Assembly, contacts: Contacts, gap: bytes) -> _Edges:
    """Those of one model are asked for with both carriers and with other shear stiffnesses."""
    return _Edges(assembly, contacts, np.frombuffer(gap).reshape(-1, 2))


class _Edges:
    """The edges from each corner to the next.

    Attributes
    ----------
    outward : (k, 2) normals, local u and v; zero for a point
    owned : (k,) each, whether the edge lies on an edge of a, and of b
    bend : (k,) each, of the surfaces of a and b there
    fitted : (k,)
        Whether a convex edge of one block lies in a re-entrant edge of the other.
    """

    def __init__(self, assembly: Assembly, contacts: Contacts, gap: Floats) -> None:
        self.contacts, self.sides = contacts, FaceSides(assembly)
        self.volume = assembly.volume
        self.after = contacts.corners.following
        along = contacts.point[self.after] - contacts.point
        axes = contacts.frame[contacts.interface]
        run = np.einsum("kij,kj->ki", axes[:, 1:], along)
        length = np.linalg.norm(run, axis=1, keepdims=True)
        run = run / np.where(length > 0.0, length, 1.0)
        self.outward = np.stack([run[:, 1], -run[:, 0]], axis=1)
        out = np.einsum("kij,ki->kj", axes[:, 1:], self.outward)
        n = axes[:, 0]
        self.points = [contacts.point - gap[:, :1] * n, contacts.point + gap[:, 1:] * n]
        found = [
            self.sides.owned(block, self._middle(point), along, out)
            for block, point in zip(self.contacts.corner_blocks, self.points, strict=True)
        ]
        self.owned = found[0][0], found[1][0]
        self.bend = found[0][1], found[1][1]
        if not (self.owned[0] | self.owned[1]).any():
            self.owned = self._nearest(along)
        least, most = np.minimum(*self.bend), np.maximum(*self.bend)
        self.fitted: Bools = (least < -BENT) & (most > BENT)

    def _middle(self, point: Floats) -> Floats:
        """(k, 3) the middle of each edge between some corners (k, 3)."""
        return np.asarray(0.5 * (point + point[self.after]))

    def _nearest(self, along: Floats) -> tuple[Bools, Bools]:
        """The same where no edge is one of a block, as of imperfect joints: by the nearest ones."""
        off_a, off_b = (
            self.sides.nearest(block, self._middle(point), along)
            for block, point in zip(self.contacts.corner_blocks, self.points, strict=True)
        )
        flush = self.longer
        of_a, of_b = off_a < NEARER * off_b, off_b < NEARER * off_a
        return of_a & (off_b > flush), of_b & (off_a > flush)

    @property
    def longer(self) -> Floats:
        """(k,) [m] by how much a face that ends at an edge is taken as longer."""
        smaller = np.minimum(*(self.volume[block] for block in self.contacts.corner_blocks))
        return np.asarray(FLUSH_REACH * np.cbrt(smaller))

    @cached_property
    def reach(self) -> Floats:
        """(k,) [m] how far the face of the block that does not carry the edge goes on beyond it."""
        contacts, (of_a, of_b) = self.contacts, self.owned
        reach = np.where(of_a & of_b, self.longer, np.inf)
        for block, point, alone in zip(
            (contacts.block_a, contacts.block_b), self.points, (of_b & ~of_a, of_a & ~of_b),
            strict=True,
        ):  # fmt: skip
            edge = np.flatnonzero(alone & self.outward.any(axis=1))
            joints, row = np.unique(contacts.interface[edge], return_inverse=True)
            frame, origin = contacts.frame[joints], point[contacts.start[joints]]
            segments = self.sides.in_planes(block[joints], frame, origin)
            arm = self._middle(point)[edge] - origin[row]
            at = (frame[row, 1:] @ arm[:, :, None])[..., 0]
            reach[edge] = to_the_end(at, self.outward[edge], row, *segments)
        return reach


def slid(ends: Ends, outlines: tuple[Floats, Bools], slide: Floats) -> tuple[Floats, Floats, Bools]:
    """Where corners go when b slides over a by (k, 2).

    Returns the motion x (k, 2), its derivative (k, 2, 2), and which are still on both faces (k,).
    """
    along, carried = (
        each[:, :, 0] * slide[:, :1] + each[:, :, 1] * slide[:, 1:]
        for each in (ends.outward, ends.tangent)
    )
    beyond, tangent = ends.sense * along > ends.reach, ends.tangent
    some = np.flatnonzero(beyond.any(axis=1))
    if len(some):
        outward, over = ends.outward[some], beyond[some]
        weight = np.where(over, 1.0 - ends.share[some], ends.share[some])
        # of b: r beyond the end of the face of a; of a: s + r beyond the end of that of b
        shift = weight * along[some] + np.where(over, ends.reach[some], 0.0)
        right = np.concatenate([shift[:, :, None], weight[:, :, None] * outward], axis=2)
        solved: Floats = np.asarray(np.linalg.solve(outward, right), dtype=np.float64)
        tangent = tangent.copy()
        carried[some], tangent[some] = solved[:, :, 0], solved[:, :, 1:]
    return carried, tangent, _on_both(ends, outlines, carried)


def _on_both(ends: Ends, outlines: tuple[Floats, Bools], carried: Floats) -> Bools:
    """(k,) whether the two faces of the interface still have an area in common."""
    edge, flat = outlines
    now = edge + carried[ends.after] - carried
    area = np.bincount(ends.joint, plane_cross(ends.place + carried, now), len(flat))
    forward = np.bincount(ends.joint, dot(edge, now) > 0.0, len(flat)) > 0
    return np.asarray((flat | ((area > 0.0) & forward))[ends.joint])


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


def turned_joints(model: Model) -> Bools:
    """(m,) whether the corners of an interface slide over the face of b, not over that of a.

    They slide over the block with fewer joints to a support; of two with the same number over the
    larger one, then over the lower one along the load, then over the one nearer to the centroid of
    the model. Only blocks that are alike in all of this go by their numbers: the corners lie on the
    face of one block, and once one has turned, the two choices differ by a small share of the way.
    """
    assembly, contacts = model.assembly, model.contacts
    a, b = contacts.block_a, contacts.block_b
    away = distance_from_supports(assembly, contacts)
    size = np.cbrt(assembly.volume)
    least = SAME * np.minimum(size[a], size[b])
    loads = model.load.wrench[assembly.free, :3]
    load = loads.sum(axis=0)
    strength = float(np.linalg.norm(load))
    some = strength > ROUNDING * float(np.linalg.norm(loads, axis=1).sum())
    down = load / strength if some else np.zeros(3)
    middle = assembly.volume @ assembly.centroid / assembly.volume.sum()
    from_middle = assembly.centroid - middle
    turned = np.zeros(len(a), dtype=bool)
    decided = np.zeros(len(a), dtype=bool)
    ranks: tuple[tuple[Floats, Floats | float], ...] = (
        (-away.astype(np.float64), 0.0),
        (size, least),
        (from_middle @ down, least),
        (-np.linalg.norm(from_middle, axis=1), least),
    )
    for rank, margin in ranks:
        more = rank[b] - rank[a]
        turned |= ~decided & (more > margin)
        decided |= np.abs(more) > margin
    return turned


def as_turned(ends: Ends, turned: Bools) -> Ends:
    """The ends of joints, where a and b change their roles at some corners (k,).

    The normal n and the axis v change their signs, u does not. What moved with b moves with a, and
    the corners go round the other way.
    """
    mirror = np.array([1.0, -1.0])
    before = np.argsort(ends.after)
    here = turned[:, None]
    # the edge that follows becomes the one before
    outward, tangent = ends.outward[:, ::-1] * mirror, np.eye(2) - ends.tangent
    return Ends(
        outward=np.where(here[:, :, None], outward, ends.outward),
        share=np.where(here, 1.0 - ends.share[:, ::-1], ends.share),
        tangent=np.where(here[:, :, None], mirror[:, None] * tangent * mirror, ends.tangent),
        sense=np.where(here, -ends.sense[:, ::-1], ends.sense),
        reach=np.where(here, ends.reach[:, ::-1], ends.reach),
        joint=ends.joint,
        after=np.where(turned, before, ends.after),
        place=np.where(here, ends.place * mirror, ends.place),
        drawn=np.where(here, ends.drawn[:, ::-1], ends.drawn),
    )
