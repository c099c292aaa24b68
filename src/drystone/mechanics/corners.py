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
from collections.abc import Iterator
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import (
    ROUNDING,
    SAME,
    Bools,
    Floats,
    Ints,
    cross,
    dot,
    lengths,
    plane_cross,
    unit,
)
from drystone.base.ragged import BATCH, Ragged, expand
from drystone.contacts import Contacts
from drystone.geometry.halfedge import BENT
from drystone.model import FlushEnds, Model

COPLANAR = 0.01
"""Largest distance between an interface and a face that it lies on, by the block's size, and
largest sine of the angle between them: contacts are found on faces that are not quite flat."""

ASKEW = 0.1
"""Sine of the angle between an edge of an imperfect interface and that edge of a block that it
stands for."""


class FaceSides:
    """The sides of the faces of all blocks.

    Attributes
    ----------
    begin, end : (e, 3) [m]
    face : (e,) the face of each
    normal : (f, 3) outward, of each face
    of_block
        The sides of each block.
    """

    def __init__(self, assembly: Assembly) -> None:
        faces = assembly.faces
        self.begin = faces.point[faces.loop]
        self.end = self.begin[faces.corners.following]
        self.axis, self.length = unit(self.end - self.begin)
        self.face, self.normal = faces.corners.owner, faces.normals
        self.of_block = Ragged.from_owners(faces.owner[self.face], len(assembly))
        self.size = np.cbrt(assembly.volume)
        self.largest = assembly.size

    def in_planes(self, block: Ints, frame: Floats, origin: Floats) -> tuple[Ragged, Floats]:
        """The outer sides of the faces of blocks (r,) in a plane each.

        Parameters
        ----------
        block, frame, origin
            Axes (r, 3, 3) of the planes, rows n, u, v, and a point (r, 3) [m] of each.

        Returns
        -------
        of_row
            Which sides belong to which plane.
        ends : (s, 2, 2) [m]
            Local u and v of both ends of each side.
        """
        rows, ends = [np.zeros(0, dtype=np.intp)], [np.zeros((0, 2, 2))]
        for row, side in _pairs(self.of_block, block):
            n, size = frame[row, 0], self.size[block[row]]
            arms = [self.begin[side] - origin[row], self.end[side] - origin[row]]
            near = np.maximum(*(np.abs(dot(arm, n)) for arm in arms)) < COPLANAR * size
            flat = np.flatnonzero(near)
            lean = lengths(cross(self.normal[self.face[side[flat]]], n[flat]))
            flat = flat[lean < COPLANAR]
            rows.append(row[flat])
            axes = frame[row[flat], 1:]
            ends.append(np.stack([(axes @ arm[flat, :, None])[..., 0] for arm in arms], axis=1))
        row, found = np.concatenate(rows), np.concatenate(ends)
        # sides between two faces in the plane are no ends
        outer = np.ones(len(row), dtype=bool)
        for one, other in _pairs(Ragged.from_owners(row, len(block)), row):
            back = np.abs(found[one, ::-1] - found[other]).max(axis=(1, 2), initial=0.0)
            outer[one[back < SAME * self.size[block[row[one]]]]] = False
        return Ragged.from_owners(row[outer], len(block)), found[outer]

    def owned(
        self, block: Ints, middle: Floats, along: Floats, outward: Floats
    ) -> tuple[Bools, Floats]:
        """Which edges (k,) of interfaces are edges of a block (k,) each, and their bend (k,).

        The bend is the sine of the angle by which the block's surface turns away from the interface
        at the edge: positive at a convex edge, negative at a re-entrant one.

        Parameters
        ----------
        block
        middle, along : (k, 3) [m]
            The middle of each edge, and its end less its beginning.
        outward : (k, 3)
            Normal of the edge in the plane of its interface.
        """
        owned, bend = np.zeros(len(block), dtype=bool), np.zeros(len(block))
        direction, margin = unit(along)[0], SAME * self.largest[block]
        for edge, side in _pairs(self.of_block, block):
            axis, most = self.axis[side], margin[edge]
            arm = middle[edge] - self.begin[side]
            at = dot(arm, axis)
            near = (at > -most) & (at < self.length[side] + most)
            near &= lengths(arm - at[:, None] * axis) < most
            edge, side, axis = edge[near], side[near], axis[near]
            # an edge without length, as of a point, runs along every side
            parallel = lengths(cross(direction[edge], axis)) < 1e-3
            edge, side = edge[parallel], side[parallel]
            owned[edge] = True
            turned = dot(outward[edge], self.normal[self.face[side]])
            order = np.argsort(-np.abs(turned), kind="stable")[::-1]
            bend[edge[order]] = turned[order]  # the last one counts, which turns most
        return owned, bend

    def nearest(self, block: Ints, middle: Floats, along: Floats) -> Floats:
        """Distance (k,) [m] of edges, as for :meth:`owned`, from the nearest edge of a block.

        Edges of the block that run in another direction do not count.
        """
        found, direction = np.full(len(block), np.inf), unit(along)[0]
        for edge, side in _pairs(self.of_block, block):
            axis = self.axis[side]
            alike = lengths(cross(direction[edge], axis)) < ASKEW
            edge, side, axis = edge[alike], side[alike], axis[alike]
            arm = middle[edge] - self.begin[side]
            at = np.clip(dot(arm, axis), 0.0, self.length[side])
            np.minimum.at(found, edge, lengths(arm - at[:, None] * axis))
        return found


def _pairs(of_row: Ragged, row: Ints) -> Iterator[tuple[Ints, Ints]]:
    """Things, each with all items of its row (t,), some things at a time."""
    first, count = of_row.first[row], of_row.counts[row]
    for some in Ragged.from_counts(count).batches(BATCH // 10):
        one, item = expand(first[some], count[some])
        yield some[one], item


def to_the_end(at: Floats, outward: Floats, row: Ints, of_row: Ragged, segments: Floats) -> Floats:
    """(c,) distance from points (c, 2) along directions (c, 2) to a segment of their row (c,).

    Parameters
    ----------
    at, outward, row
    of_row
        The segments of each row.
    segments : (s, 2, 2)
    """
    run, found = segments[:, 1] - segments[:, 0], np.full(len(at), np.inf)
    length = lengths(run)
    for one, item in _pairs(of_row, row):
        arm, out, side = segments[item, 0] - at[one], outward[one], run[item]
        turn = plane_cross(out, side)
        safe = np.where(np.abs(turn) > 0.0, turn, 1.0)
        far, part = plane_cross(arm, side) / safe, plane_cross(arm, out) / safe
        met = (np.abs(turn) > 1e-6 * length[item]) & (far > 0.0) & (part >= 0.0) & (part <= 1.0)
        np.minimum.at(found, one[met], far[met])
    return found


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
    rods = (contacts.rod > 0.0)[joint]  # each end stays on its block
    share = np.where(rods, 0.5, share)
    flush = (of_a == of_b) & (far != 0.0)[joint] & ~edges_of.fitted & ~rods
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


class Rails(NamedTuple):
    """What of :class:`Ends` every slide takes, with the corner last: sums over k are faster.

    Attributes
    ----------
    guide : (2, 4, k) m and x of both edges, by each component of the slide
    sense, reach : (2, k)
    place, edge : (2, k) of corners, and from each to the next
    flat : (m,) interfaces without an area to lose
    """

    guide: Floats
    sense: Floats
    reach: Floats
    place: Floats
    edge: Floats
    flat: Bools

    @classmethod
    def of(cls, ends: Ends) -> Rails:
        """Those of some ends."""
        guide = np.concatenate([ends.outward, ends.tangent], axis=1).transpose(2, 1, 0)
        edge = ends.place[ends.after] - ends.place
        twice, square = (
            np.bincount(ends.joint, one) for one in (plane_cross(ends.place, edge), dot(edge, edge))
        )
        sense, reach, place = (
            np.ascontiguousarray(one.T) for one in (ends.sense, ends.reach, ends.place)
        )
        flat = twice <= 1e-12 * square
        return cls(
            np.ascontiguousarray(guide), sense, reach, place, np.ascontiguousarray(edge.T), flat
        )


def slid(ends: Ends, rails: Rails, slide: Floats) -> tuple[Floats, Floats, Bools]:
    """Where corners go when b slides over a by (2, k).

    Returns the motion x (2, k), its derivative (k, 2, 2), and which are still on both faces (k,).
    """
    both = rails.guide[0] * slide[0]
    both += rails.guide[1] * slide[1]
    along, carried = both[:2], both[2:]
    beyond, tangent = rails.sense * along > rails.reach, ends.tangent
    if beyond.any():
        some = np.flatnonzero(beyond.any(axis=0))
        outward, over = ends.outward[some], beyond[:, some].T
        weight = np.where(over, 1.0 - ends.share[some], ends.share[some])
        # of b: r beyond the end of the face of a; of a: s + r beyond the end of that of b
        shift = weight * along[:, some].T + np.where(over, ends.reach[some], 0.0)
        right = np.concatenate([shift[:, :, None], weight[:, :, None] * outward], axis=2)
        solved: Floats = np.asarray(np.linalg.solve(outward, right), dtype=np.float64)
        tangent = tangent.copy()
        carried[:, some], tangent[some] = solved[:, :, 0].T, solved[:, :, 1:]
    return carried, tangent, _on_both(ends, rails, carried)


def _on_both(ends: Ends, rails: Rails, carried: Floats) -> Bools:
    """(k,) whether the two faces of the interface still have an area in common."""
    edge, flat, place = rails.edge, rails.flat, rails.place + carried
    now = edge + carried.take(ends.after, axis=1)
    now -= carried
    area = np.bincount(ends.joint, place[0] * now[1] - place[1] * now[0], len(flat))
    forward = np.bincount(ends.joint, edge[0] * now[0] + edge[1] * now[1] > 0.0, len(flat)) > 0
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
