"""Where struts, ropes and centring meet a block: free parts of its true surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import shapely
import shapely.affinity
import shapely.ops

from drystone.assembly import Assembly, Block
from drystone.base.arrays import ROUNDING, Floats, Ints, unit
from drystone.base.display import OneLine
from drystone.base.ragged import Ragged
from drystone.free_faces import FreePart, free_parts
from drystone.geometry.facets import smooth_runs
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.planar import parts_of
from drystone.geometry.polyhedron import Faces, stack_faces
from drystone.geometry.solid import crossings, winding_number
from drystone.geometry.triangulate import fan_warped, triangulate
from drystone.model import Model
from drystone.supports import props_of

INSET = 0.6
"""Distance of heads and knots from the middle of their seat, by that of its corners; chosen, well
inside the seat."""
LEAST_FREE = 0.05
"""Least share of a face that must be free of joints for an item; chosen."""
_ROUNDED = 0.05
"""Corners of a seat are left out where they change it by less, relative to the root of its area.
Chosen: a round seat has some eight corners."""


@dataclass(frozen=True, eq=False)
class Seat(OneLine):
    """A smooth part of the surface of a block that no joint covers.

    Attributes
    ----------
    region
        The part, seen along ``axes[0]``, in the plane of ``axes[1]`` and ``axes[2]``.
    axes : (3, 3)
        Rows: the mean normal of the part, outwards, and two across.
    along : (3,) unit
        The direction in which it was asked to look.
    middle : (3,) [m]
        Near the part; tells it from other parts behind each other.
    surface : (t, 3, 3) [m]
        Triangles of the block that look that way.
    """

    region: shapely.Polygon
    axes: Floats
    along: Floats
    middle: Floats
    surface: Floats

    @property
    def normal(self) -> Floats:
        """Mean outward normal (3,)."""
        return self.axes[0]

    @property
    def outline(self) -> Floats:
        """Its corners (c, 3) [m], on the surface, counter-clockwise from outside the block."""
        return self._on_surface(self._corners)

    @property
    def heads(self) -> Floats:
        """A point (c, 3) [m] of the surface near each corner, well inside the seat."""
        centre = np.array(self.region.centroid.coords[0])
        near = centre + INSET * (self._corners - centre)
        within = self.region.buffer(-0.1 * _ROUNDED * np.sqrt(self.region.area))
        for i, place in enumerate(shapely.points(near)):
            if not within.covers(place):  # the seat has a hole there, or turns inwards
                near[i] = shapely.ops.nearest_points(within, place)[0].coords[0]
        return self._on_surface(near)

    def nearest(self, point: Floats) -> Floats:
        """The point (3,) [m] well inside the seat nearest to where a point (3,) would fall."""
        inner = shapely.affinity.scale(self.region, INSET, INSET, origin="centroid")
        inner = inner.intersection(self.region)
        height = (point - self.middle) @ self.normal / (self.along @ self.normal)
        place = shapely.Point(self.axes[1:] @ (point - height * self.along))
        near = shapely.get_coordinates(shapely.ops.nearest_points(inner, place)[0])
        return self._on_surface(near)[0]

    @property
    def _corners(self) -> Floats:
        """(c, 2) [m]"""
        shape = self.region.simplify(_ROUNDED * np.sqrt(self.region.area))
        return np.array(shapely.geometry.polygon.orient(shape).exterior.coords)[:-1]

    def _on_surface(self, flat: Floats) -> Floats:
        """Points (p, 3) [m] of the surface over points (p, 2) of the plane."""
        triangle = self.surface @ self.axes.T
        corner, one, two = triangle[:, 0], *(triangle[:, i] - triangle[:, 0] for i in (1, 2))
        twice = one[:, 1] * two[:, 2] - one[:, 2] * two[:, 1]
        wanted = float(self.normal @ self.middle)
        out = np.empty((len(flat), 3))
        for i, place in enumerate(flat):
            x, y = (place - corner[:, 1:]).T
            s = (x * two[:, 2] - y * two[:, 1]) / twice
            t = (y * one[:, 1] - x * one[:, 2]) / twice
            inside = np.minimum(np.minimum(s, t), 1.0 - s - t)
            height = corner[:, 0] + s * one[:, 0] + t * two[:, 0]
            hit = inside >= min(float(inside.max()), -ROUNDING)
            best = np.argmin(np.where(hit, np.abs(height - wanted), np.inf))
            out[i] = np.append(height[best], place) @ self.axes
        return out


def seat_on(model: Model, block: int, direction: Floats, least: float) -> Seat | None:
    """The seat of a block that looks most along a direction, by its area.

    Parameters
    ----------
    model
        Complete: what is a joint in it is no seat.
    block
    direction : (3,) unit
    least
        Smallest cosine between the direction and the facets of a seat.

    Returns
    -------
    Seat or None
        None where every part that looks that way is covered.
    """
    parts = [
        part
        for part in free_parts(model, block, away=0.0)
        if part.normal @ direction > least and part.share > LEAST_FREE
    ]
    if not parts:
        return None
    run = _smooth(parts)
    facing = np.array([part.area * float(part.normal @ direction) for part in parts])
    chosen = np.flatnonzero(run == np.bincount(run, facing).argmax())
    mine = [parts[i] for i in chosen]
    vector = np.array([part.area * part.normal for part in mine])
    axes = frames_from_normals(unit(vector.sum(axis=0))[0][None])[0]
    middle = np.average([part.middle for part in mine], axis=0, weights=facing[chosen])
    surface, _ = surface_triangles(model.assembly.blocks[block])
    facets = surface[_normals(surface) @ axes[0] > least]
    return Seat(_seen(mine, axes), axes, direction, middle, facets)


def _smooth(parts: Sequence[FreePart]) -> Ints:
    """Number of the smooth run of each part."""
    outlines = [part.outline for part in parts]
    start = Ragged.of(outlines).start
    return smooth_runs(np.concatenate(outlines), start, np.zeros(len(parts), dtype=np.intp))


def _seen(parts: Sequence[FreePart], axes: Floats) -> shapely.Polygon:
    """The largest connected region of some parts, seen along ``axes[0]``."""
    shapes = [
        shapely.transform(one.shape, partial(_projected, one.origin, one.frame, axes))
        for one in parts
    ]
    if len(shapes) == 1:
        return shapes[0]
    crack = 1e-6 * np.sqrt(max(shape.area for shape in shapes))
    whole = shapely.union_all([shape.buffer(crack) for shape in shapes]).buffer(-crack)
    return max(parts_of(whole, "Polygon"), key=lambda one: float(one.area))


def _projected(origin: Floats, frame: Floats, axes: Floats, flat: Floats) -> Floats:
    """Points (p, 2) of the plane of a frame, in the plane of ``axes[1:]``."""
    return (origin + flat @ frame[1:]) @ axes[1:].T


def surface_triangles(of: Block | Assembly) -> tuple[Floats, Ints]:
    """The true surface as triangles (t, 3, 3) [m], and the block of each (t,).

    A warped face is its fan about the mean of its corners, as in its volume.
    """
    faces: Faces = of.faces if isinstance(of, Assembly) else stack_faces([of.vertices], [of.faces])
    faces = fan_warped(faces)
    corner = faces.point[faces.loop]
    triangle, face = triangulate(corner, faces.start)
    return corner[triangle], faces.owner[face]


class Landing(NamedTuple):
    """What a line meets: a block, where (3,) [m], and the outward normal (3,) of its face there."""

    block: int
    point: Floats
    normal: Floats


def first_met(
    surface: tuple[Floats, Ints], block: int, start: Floats, end: Floats
) -> Landing | None:
    """What a line (3,) to (3,) [m] from a block meets first of the others; None if nothing.

    Parameters
    ----------
    surface
        That of all blocks, by :func:`surface_triangles`.
    block
    start, end
    """
    triangles, owner = (part[surface[1] != block] for part in surface)
    from_, to = (np.broadcast_to(one, (len(owner), 3)) for one in (start, end))
    hit, share = crossings(from_, to, triangles)
    if not hit.any():
        return None
    first = int(np.argmin(np.where(hit, share, np.inf)))
    normal = _normals(triangles[first : first + 1])[0]
    return Landing(int(owner[first]), start + share[first] * (end - start), normal)


def along(
    assembly: Assembly, start: Floats, end: Floats, ends: Sequence[int]
) -> tuple[float, list[int]]:
    """How much of a line (3,) to (3,) [m] lies in no block [m], and the blocks that it pierces.

    ``ends``: those at its ends, which are left out.
    """
    triangles, owner = surface_triangles(assembly)
    hit, share = crossings(start, end, triangles)
    cuts = np.unique([0.0, *share[hit], 1.0])
    middle = start + 0.5 * (cuts[1:] + cuts[:-1])[:, None] * (end - start)
    free = np.diff(cuts)[winding_number(middle, triangles) < 0.5].sum()
    met = np.unique(owner[hit]).tolist()
    deep = {i: np.ptp(share[hit & (owner == i)]) for i in met if i not in ends}
    far = float(np.linalg.norm(end - start))
    return float(free * far), [i for i, part in deep.items() if part > ROUNDING]


def post_ways(assembly: Assembly, blocks: Ints, point: Floats, way: Floats) -> Floats:
    """Posts (p, 3) [m], as drawn, from points (p, 3) [m] of blocks along unit vectors (p, 3).

    They end on the support that they meet, or downwards at the level of the lowest corner of the
    model where nothing is in between; else they have half the size of their blocks.
    """
    stands = ~props_of(assembly)
    triangles, owner = surface_triangles(assembly)
    surface = triangles[stands[owner]], owner[stands[owner]]
    low, high = assembly.bounds[stands, 0].min(axis=0), assembly.bounds[stands, 1].max(axis=0)
    far, long = float(np.linalg.norm(high - low)), 0.5 * assembly.size[blocks]
    for i, (block, at, along) in enumerate(zip(blocks.tolist(), point, way, strict=True)):
        met = first_met(surface, block, at, at + far * along)
        if met is not None and assembly.fixed[met.block]:
            long[i] = (met.point - at) @ along
        elif met is None and along[2] < -np.sqrt(0.5) and at[2] - low[2] > long[i]:
            long[i] = (low[2] - at[2]) / along[2]
    return long[:, None] * way


def _normals(triangles: Floats) -> Floats:
    """Unit normals (t, 3) of triangles."""
    a, b, c = triangles.transpose(1, 0, 2)
    return unit(np.cross(b - a, c - a))[0]
