"""The faces of an assembly as planar patches: coplanar neighbours merged, deviations measured.

Patches as chords of a curved surface: their distance from it, and the sign of its curvature.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, cross, dot
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged, linked, sum_by_owner
from drystone.geometry.frames import area_vectors
from drystone.geometry.halfedge import (
    NOISE,
    SMOOTH,
    HalfEdges,
    half_edges,
    joined_faces,
    outlines,
    turn_angles,
)
from drystone.geometry.polyhedron import Faces

EXACT = 1e-4
"""Distances below this share of the block size count as none: gaps have no block between them, and
faces are one polygon. Chosen: thinner than any block, and fine meshes of a curve are not flattened.
"""


def coplanar_groups(faces: Faces, edges: HalfEdges, turn: Floats, size: Floats) -> Ints:
    """Group (f,) of each face, numbered by first face: coplanar neighbours share one."""
    flat = (edges.twin >= 0) & (np.abs(turn) < NOISE)
    if not flat.any():
        return np.arange(faces.count, dtype=np.intp)
    group = joined_faces(edges, flat, faces.count)
    many = np.bincount(group)[group] > 1
    corner_face = edges.face
    point = faces.point[faces.loop]
    total = sum_by_owner(faces.area_vectors, group, int(group.max()) + 1)
    normal = unit_rows(total, np.linalg.norm(total, axis=1))
    corner_group = group[corner_face]
    share = np.bincount(corner_group)
    middle = sum_by_owner(point, corner_group, len(share)) / share[:, None]
    height = np.abs(dot(point - middle[corner_group], normal[corner_group]))
    worst = np.zeros(len(share))
    np.maximum.at(worst, corner_group, height)
    keep = many & (worst[group] <= EXACT * size[faces.owner])
    apart = np.where(keep, group, len(share) + np.arange(faces.count))
    _, first, label = np.unique(apart, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.intp)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[label.ravel()]


def rings_of(faces: Faces, edges: HalfEdges, group: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Vertex loops, their starts, the patch of each ring, the first face of each patch."""
    number, face = np.unique(group, return_index=True)
    if len(number) == faces.count:
        return faces.loop, faces.start, group, face.astype(np.intp)
    loop, start, owner = outlines(faces, edges, group)
    vectors = area_vectors(faces.point[loop], start)
    total = sum_by_owner(faces.area_vectors, group, len(number))
    hole = -dot(vectors, total[owner])  # holes have the opposite orientation
    order = np.lexsort((hole, owner))
    length = np.diff(start)
    begin = Ragged.from_counts(length[order]).start
    source = np.repeat(start[order] - begin[:-1], length[order]) + np.arange(len(loop))
    return loop[source], begin, owner[order], face.astype(np.intp)


def without_straight(corner: Floats, start: Ints, size: Floats) -> tuple[Floats, Ints]:
    """Rings without the corners on straight lines that merging faces leaves."""
    while True:
        after = Ragged(start).following
        before = np.argsort(after)
        ring = np.repeat(np.arange(len(start) - 1), np.diff(start))
        chord = corner[after] - corner[before]
        length = np.linalg.norm(chord, axis=1)
        off = np.linalg.norm(cross(chord, corner - corner[before]), axis=1)
        straight = off <= ROUNDING * size[ring] * length
        straight &= ~straight[before]  # of two neighbours only one
        straight &= (np.diff(start) > 3)[ring]
        if not straight.any():
            return corner, start
        lost = np.bincount(ring, straight, minlength=len(start) - 1).astype(np.intp)
        start = Ragged.from_counts(np.diff(start) - lost).start
        corner = corner[~straight]


def unit_rows(vectors: Floats, length: Floats) -> Floats:
    """Vectors (r, 3) divided by their length (r,); zero where the length is zero."""
    safe = np.where(length > 0.0, length, 1.0)[:, None]
    return np.where(length[:, None] > 0.0, vectors / safe, 0.0)


_FACETED = np.deg2rad(50.0)
"""[rad] The same for triangles, whose edges cross the curve in any direction. Chosen: above the 42
degrees between the faces of an icosahedron."""


def curvature(
    faces: Faces, edges: HalfEdges, turn: Floats, group: Ints, area: Floats, triangle: Bools
) -> tuple[Floats, Floats, Bools, Bools]:
    """The surface that each patch approximates, from the turning angles (h,) [rad] at half-edges.

    A strip of width w with the angle t to its neighbours is a chord of a curve. Its sag is w t / 8
    and its angle to the curve at its edges t / 2. The narrower of two neighbours gives w, so a
    chamfer does not make a large face curved. Two triangles may form a warped quadrilateral, and
    the other side of the joint may be cut along the other diagonal. Then the distance in the middle
    is w t, half of it for each side, with w the mean width of the triangle. The angle between the
    sides is that between the facets at a corner and their mean.

    Parameters
    ----------
    group : (f,) patch of each face
    area : (p,) [m2]
    triangle : (p,) bool

    Returns
    -------
    sag : (p,) [m], distance of the patch from the surface
    bend : (p,) [rad], angle between them
    bulges, hollow : (p,) bool
        Whether the surface is convex, or concave, at the patch or at a neighbour of it.
    """
    count = len(area)
    sag, bend = np.zeros(count), np.zeros(count)
    bulges, hollow = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    border = group[edges.face] != group[edges.face[edges.twin]]
    curved = _across_curves(edges, turn, group, triangle)
    smooth = np.flatnonzero(border & curved)
    if len(smooth) == 0:
        return sag, bend, bulges, hollow
    here, there = group[edges.face[smooth]], group[edges.face[edges.twin[smooth]]]
    along = faces.point[faces.loop[edges.after[smooth]]] - faces.point[faces.loop[smooth]]
    length = np.maximum(np.linalg.norm(along, axis=1), np.finfo(np.float64).tiny)
    own, other = (area[i] / np.maximum(length, np.sqrt(area[i])) for i in (here, there))
    narrow = np.minimum(own, other)
    share = narrow / np.where(own > 0.0, own, 1.0)
    angle = np.abs(turn[smooth])
    np.maximum.at(sag, here, narrow * angle * np.where(triangle[here], 0.5, 0.125))
    np.maximum.at(bend, here, 0.5 * angle * share)
    if triangle[here].any():
        _turn_to_corners(bend, faces, edges, curved, group, triangle)
    for turned, sign in ((bulges, 1.0), (hollow, -1.0)):
        turns = sign * turn[smooth] > NOISE
        turned[here[turns]] = True
        turned[here[turned[there]]] = True  # extended to the neighbours
    return sag, bend, bulges, hollow


def _across_curves(edges: HalfEdges, turn: Floats, group: Ints, triangle: Bools) -> Bools:
    """Whether each half-edge (h,) lies on a smooth surface and not at a crease."""
    three = triangle[group[edges.face]] & triangle[group[edges.face[edges.twin]]]
    return (edges.twin >= 0) & (np.abs(turn) < np.where(three, _FACETED, SMOOTH))


def _turn_to_corners(
    bend: Floats, faces: Faces, edges: HalfEdges, smooth: Bools, group: Ints, triangle: Bools
) -> None:
    """Raise the bend (p,) of triangles to their angle to the mean normal at a corner.

    The mean of the facets at the corner is weighted by area.
    """
    joins = np.flatnonzero(smooth)
    beside = edges.after[edges.twin[joins]]  # the same corner, in the face across the edge
    fan = linked(joins, beside, len(edges.face))
    vector = faces.area_vectors[edges.face]
    mean = sum_by_owner(vector, fan, int(fan.max()) + 1)[fan]
    sine = np.linalg.norm(np.cross(vector, mean), axis=1)
    angle = np.arctan2(sine, dot(vector, mean))
    patch = group[edges.face]
    chosen = triangle[patch]
    np.maximum.at(bend, patch[chosen], angle[chosen])


_REENTRANT = np.deg2rad(0.5)
"""[rad] A block is convex when no edge turns inwards by more. Chosen: above the noise of warped
faces."""
_COARSE = 1e-3
"""Largest rounding of coordinates, relative to the block size. Chosen: a fifth of the gap within
which faces touch."""
_FOLDED = 1e-12
"""A face with a smaller area vector, relative to the surface of its block, has no area."""


@dataclass(frozen=True)
class Patches:
    """Planar patches of the surfaces of all blocks, ordered by block.

    Letters: p patches, r rings (outline first, then holes), l corners, n blocks.

    Attributes
    ----------
    corner : (l, 3) [m], relative to ``origin``
    ring_start : (r + 1,) corners of each ring
    first_ring : (p + 1,) rings of each patch
    owner : (p,) block
    face : (p,) number of its (first) face in the block
    normal : (p, 3) outwards
    centre : (p, 3) [m], mean of the outline's corners
    area : (p,) [m2]
    warp : (p,) [m], largest distance of a corner from the plane
    sag : (p,) [m], distance of the plane from the curved surface that the patch stands for
    bend : (p,) [rad], angle between the plane and that surface
    tilt : (p,) [rad], angle between the plane and the warped face
    bulges, hollow : (p,) whether that surface is convex, or concave, there
    convex : (p,) whether the patch is one convex polygon
    low, high : (p, 3) [m], bounding box
    first_patch : (n + 1,) patches of each block
    size : (n,) [m], six times volume over surface
    block_convex : (n,)
    one_surface : (n,) whether the block's surface is connected and without handles
    origin : (3,) [m]
    """

    corner: Floats
    ring_start: Ints
    first_ring: Ints
    owner: Ints
    face: Ints
    normal: Floats
    centre: Floats
    area: Floats
    warp: Floats
    sag: Floats
    bend: Floats
    tilt: Floats
    bulges: Bools
    hollow: Bools
    convex: Bools
    low: Floats
    high: Floats
    first_patch: Ints
    size: Floats
    block_convex: Bools
    one_surface: Bools
    origin: Floats

    @property
    def count(self) -> int:
        """Number of patches."""
        return len(self.owner)

    def of_faces(self, block: Ints, face: Ints) -> Ints:
        """The patches (q,) by their blocks and faces; where there is none, any."""
        most = int(self.face.max(initial=0)) + 1
        place = np.searchsorted(self.owner * most + self.face, block * most + face)
        return np.minimum(place, self.count - 1)

    @cached_property
    def of_block(self) -> Ragged:
        """Which patches belong to which block."""
        return Ragged(self.first_patch)

    @cached_property
    def boxes(self) -> tuple[Floats, Floats]:
        """Lowest and highest corner (n, 3) of each block [m], relative to ``origin``."""
        return self.of_block.min(self.low), self.of_block.max(self.high)

    @cached_property
    def rectangles(self) -> tuple[Floats, Floats, Floats]:
        """Rectangles around the patches, along their longest edges.

        Their axes (p, 2, 3), half their lengths (p, 2) [m], and their middles (p, 3) [m].
        """
        along = self.corner[Ragged(self.ring_start).following] - self.corner
        corners, square = Ragged(self.ring_start[self.first_ring]), dot(along, along)
        longest = np.flatnonzero(square == corners.spread(corners.max(square)))
        first = longest[np.unique(corners.owner[longest], return_index=True)[1]]
        u = along[first] / np.sqrt(square[first])[:, None]
        axes = np.stack([u, cross(self.normal, u)], axis=1)
        local = self.corner - corners.spread(self.centre)
        flat = np.stack([dot(local, corners.spread(axes[:, k])) for k in (0, 1)], axis=1)
        low, high = corners.min(flat), corners.max(flat)
        middle = self.centre + np.einsum("pk,pki->pi", 0.5 * (low + high), axes)
        return axes, 0.5 * (high - low), middle

    @cached_property
    def length(self) -> Floats:
        """Longest dimension (n,) [m] of each block: of a box, its diagonal."""
        area = self.area[:, None]
        middle = self.of_block.sum(area * self.centre) / self.of_block.sum(area)
        corners = Ragged(self.ring_start[self.first_ring[self.first_patch]])
        away = self.corner - corners.spread(middle)
        return 2.0 * np.sqrt(corners.max(dot(away, away)))


def patches_of(assembly: Assembly) -> Patches:
    """Patches of an assembly.

    Neighbouring faces in one plane become one patch, possibly with holes. Coordinates are relative
    to the middle of the assembly, so a distant origin costs no digits.
    """
    faces, origin = _centred(assembly)
    _refuse_rounded(assembly, origin)
    vectors = faces.area_vectors
    area = np.linalg.norm(vectors, axis=1)
    surface: Floats = np.bincount(faces.owner, area, minlength=len(assembly)).astype(np.float64)
    size = 6.0 * assembly.volume / surface
    _refuse_folded(assembly, faces, area, surface)
    normal = unit_rows(vectors, area)
    edges = half_edges(faces)
    turn = turn_angles(faces, edges, normal)
    block_convex, one_surface = _convex_blocks(faces, edges, turn, len(assembly))
    group = coplanar_groups(faces, edges, turn, size)
    loop, ring_start, ring_patch, face = rings_of(faces, edges, group)
    _refuse_flattened(assembly, faces.owner[face], ring_patch)
    corner = faces.point[loop]
    if len(face) < faces.count:
        corner, ring_start = without_straight(
            corner, ring_start, size[faces.owner[face]][ring_patch]
        )
    first_ring = np.searchsorted(ring_patch, np.arange(len(face) + 1)).astype(np.intp)
    if len(face) < faces.count:
        vectors = Ragged(first_ring).sum(area_vectors(corner, ring_start))
        area = np.sqrt(dot(vectors, vectors))
        normal = unit_rows(vectors, area)
    owner = faces.owner[face]
    centre = Ragged(ring_start).mean(corner)[first_ring[:-1]]
    corners = Ragged(ring_start[first_ring])
    height = np.abs(dot(corner - corners.spread(centre), corners.spread(normal)))
    warp = corners.max(height)
    sag, bend, bulges, hollow = curvature(faces, edges, turn, group, area, corners.counts == 3)
    width = np.sqrt(np.where(area > 0.0, area, 1.0))
    first_face = np.searchsorted(faces.owner, np.arange(len(assembly)))
    return Patches(
        corner=corner,
        ring_start=ring_start,
        first_ring=first_ring,
        owner=owner,
        face=face - first_face[owner],
        normal=normal,
        centre=centre,
        area=area,
        warp=warp,
        sag=sag,
        bend=bend,
        tilt=np.arctan2(2.0 * warp, width),
        bulges=bulges,
        hollow=hollow,
        convex=_convex_patches(corner, ring_start, ring_patch, normal, len(face)),
        low=corners.min(corner),
        high=corners.max(corner),
        first_patch=np.searchsorted(owner, np.arange(len(assembly) + 1)).astype(np.intp),
        size=size,
        block_convex=block_convex,
        one_surface=one_surface,
        origin=origin,
    )


kept_patches_of = lru_cache(maxsize=2)(patches_of)
"""The same for what asks for an assembly again and again: 3 kB a block stay in memory."""


def _centred(assembly: Assembly) -> tuple[Faces, Floats]:
    faces = assembly.faces
    origin = 0.5 * (faces.point.min(axis=0) + faces.point.max(axis=0))
    return Faces(faces.point - origin, faces.loop, faces.start, faces.owner), origin


def _refuse_rounded(assembly: Assembly, origin: Floats) -> None:
    """Raise for a block so far from the origin that rounding changes its shape."""
    reach = np.maximum(np.abs(assembly.bounds).max(axis=(1, 2)), np.abs(origin).max())
    lost = np.flatnonzero(np.spacing(reach) > _COARSE * assembly.size)
    if len(lost):
        block = int(lost[0])
        raise InputError(
            f"it is {assembly.size[block]:.3g} m across, with coordinates or neighbours up to"
            f" {reach[block]:.3g} m: rounding changes its shape",
            where=f"block '{assembly.names[block]}'",
            remedy="move the model nearer to the origin, or check its units",
        )


def _refuse_folded(assembly: Assembly, faces: Faces, area: Floats, surface: Floats) -> None:
    """Raise for a face that is folded onto itself.

    It has no area, but its corners are not on one line.
    """
    flat = np.flatnonzero(area <= _FOLDED * surface[faces.owner])
    for face in flat.tolist():
        corner = faces.point[faces.loop[faces.start[face] : faces.start[face + 1]]]
        local = corner - corner.mean(axis=0)
        spread = np.linalg.norm(np.cross(local, np.roll(local, -1, axis=0)), axis=1).sum()
        if spread > 1e3 * _FOLDED * surface[faces.owner[face]]:
            block = int(faces.owner[face])
            number = face - int(np.searchsorted(faces.owner, block))
            raise InputError(
                f"face {number} is folded onto itself: it has corners but no area",
                where=f"block '{assembly.names[block]}'",
                remedy="its corners are out of order, or the face is twisted: split or rebuild it",
            )


def _refuse_flattened(assembly: Assembly, owner: Ints, ring_patch: Ints) -> None:
    """Raise for a block whose faces all lie in one plane, so that they have no outline."""
    flat = np.flatnonzero(np.bincount(ring_patch, minlength=len(owner)) == 0)
    if len(flat):
        raise InputError(
            "its faces lie in one plane, as far as its coordinates tell",
            where=f"block '{assembly.names[int(owner[flat[0]])]}'",
            remedy="it is too thin for where it lies: move the assembly to the origin, or repair "
            "or remove the block",
        )


def _convex_blocks(faces: Faces, edges: HalfEdges, turn: Floats, count: int) -> tuple[Bools, Bools]:
    """Which blocks are convex, and which surfaces are connected without handles."""
    reentrant = np.bincount(faces.owner[edges.face], turn < -_REENTRANT, minlength=count)
    half = np.bincount(faces.owner[edges.face], minlength=count)
    face = np.bincount(faces.owner, minlength=count)
    vertex_owner = np.zeros(len(faces.point), dtype=np.intp)
    vertex_owner[faces.loop] = faces.owner[edges.face]
    vertex = np.bincount(vertex_owner, minlength=count)
    one_surface: Bools = 2 * vertex - half + 2 * face == 4
    return one_surface & (reentrant == 0), one_surface


def _convex_patches(
    corner: Floats, ring_start: Ints, ring_patch: Ints, normal: Floats, count: int
) -> Bools:
    after = Ragged(ring_start).following
    edge = corner[after] - corner
    ring = np.repeat(np.arange(len(ring_start) - 1), np.diff(ring_start))
    turn = dot(cross(edge, edge[after]), normal[ring_patch[ring]])
    square = dot(edge, edge)
    inward = turn < -ROUNDING * (square + square[after])
    bad = np.bincount(ring_patch[ring], inward, minlength=count)
    rings = np.bincount(ring_patch, minlength=count)
    return (bad == 0) & (rings == 1)
