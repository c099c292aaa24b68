"""The block that carries each corner of an interface.

A corner is where two edges of the interface meet, and each edge is an edge of one of the two
blocks, or of both where their faces end flush. When block b slides by s over block a, an edge of b
moves along and an edge of a stays. With the outward normals ``m`` of the two edges and their share
``w`` (1: of b, 0: of a) the corner moves over a by ``T s``:

    m1 . T s = w1 m1 . s,    m2 . T s = w2 m2 . s
"""

from __future__ import annotations

import enum

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, cross
from drystone.contacts import Contacts

FLUSH = 1e-6
"""Distance below which an edge of an interface lies on an edge of a block, by the block's size."""
STRAIGHT = 1e-6
"""Sine of the angle between two edges below which they are one side."""


class Carrier(enum.Enum):
    """Which block carries the ends of a joint where the faces of both end flush."""

    MOVING = "moving"
    """The block that is farther from the supports."""
    RESTING = "resting"
    """The block that is nearer to the supports."""


def shares(assembly: Assembly, contacts: Contacts, carrier: Carrier) -> Floats:
    """T (k, 2, 2), local u and v, of each corner.

    Parameters
    ----------
    assembly, contacts
    carrier
        The choice at edges that belong to both blocks.
    """
    of_a, of_b = _edge_owners(assembly, contacts)
    away = distance_from_supports(assembly, contacts)
    far = np.sign(away[contacts.block_b] - away[contacts.block_a])
    both = 0.5 + 0.5 * (far if carrier is Carrier.MOVING else -far)
    share = np.where(of_b & ~of_a, 1.0, np.where(of_a & ~of_b, 0.0, both[contacts.interface]))
    after, before = _neighbours(contacts)
    outward = _outward(contacts, after)
    edges = np.stack([outward, outward[before]], axis=1)
    weight = np.stack([share, share[before]], axis=1)
    bent = np.abs(np.linalg.det(edges)) > STRAIGHT
    # lines, points, and corners in the middle of a side have one share in every direction
    edges[~bent] = np.eye(2)
    weight[~bent] = weight[~bent].mean(axis=1, keepdims=True)
    return np.asarray(np.linalg.solve(edges, weight[:, :, None] * edges), dtype=np.float64)


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


def _edge_owners(assembly: Assembly, contacts: Contacts) -> tuple[Bools, Bools]:
    """(k,) whether the edge from each corner to the next lies on an edge of block a, and of b."""
    after, _ = _neighbours(contacts)
    middle = 0.5 * (contacts.point + contacts.point[after])
    along = contacts.point[after] - contacts.point
    found = []
    segments = _block_edges(assembly)
    for block in (contacts.block_a, contacts.block_b):
        of_corner = block[contacts.interface]
        owned = np.zeros(len(middle), dtype=bool)
        order = np.argsort(of_corner, kind="stable")
        starts = np.searchsorted(of_corner[order], np.arange(len(assembly) + 1))
        for i in np.unique(of_corner).tolist():
            here = order[starts[i] : starts[i + 1]]
            owned[here] = _on_edges(middle[here], along[here], segments[i], assembly.size[i])
        found.append(owned)
    return found[0], found[1]


def _block_edges(assembly: Assembly) -> list[Floats]:
    """Per block the ends (e, 2, 3) of the sides of its faces."""
    faces = assembly.faces
    following = np.arange(len(faces.loop)) + 1
    following[faces.start[1:] - 1] = faces.start[:-1]
    ends = np.stack([faces.point[faces.loop], faces.point[faces.loop[following]]], axis=1)
    owner = np.repeat(faces.owner, np.diff(faces.start))
    bounds = np.searchsorted(owner, np.arange(len(assembly) + 1))
    return [ends[bounds[i] : bounds[i + 1]] for i in range(len(assembly))]


def _on_edges(middle: Floats, along: Floats, segments: Floats, size: float) -> Bools:
    """(k,) whether a point lies on one of the segments (e, 2, 3) that runs along a direction."""
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
    return np.asarray((near & parallel).any(axis=1))


__all__ = ["Carrier", "distance_from_supports", "shares"]
