"""Plane regions of any shape, with shapely: rings in, simple polygons without holes out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from drystone.base.arrays import ROUNDING, Floats, Ints
from drystone.base.errors import InputError
from drystone.geometry.frames import area_vector, frames_from_normals
from drystone.geometry.polyhedron import Loop

Regions: TypeAlias = NDArray[Any]
"""(q,) shapely polygons."""
_Overlay: TypeAlias = Callable[..., Any]


def regions(corner: Floats, ring_start: Ints, ring_region: Ints) -> Regions:
    """Shapely polygons from rings.

    Parameters
    ----------
    corner : (l, 2)
    ring_start : (r + 1,)
    ring_region : (r,) ascending
        Region of each ring; the first ring of a region is its outline, the others are holes.

    Returns
    -------
    (q,) polygons; made valid where an outline crosses itself
    """
    if len(ring_region) == 0:
        return np.zeros(0, dtype=object)
    ring_of = np.repeat(np.arange(len(ring_region)), np.diff(ring_start))
    rings = shapely.linearrings(corner, indices=ring_of)
    outline = np.concatenate([[True], np.diff(ring_region) > 0])
    polygons = shapely.polygons(rings[outline])
    if not outline.all():
        order = np.cumsum(outline) - 1
        holed = np.unique(order[~outline])
        for i in holed:
            mine = rings[order == i]
            polygons[i] = shapely.polygons(mine[0], holes=mine[1:])
    return valid(polygons)


def inside(shape: Any, middle: Floats) -> Floats:
    """A point (2,) of a polygon: its middle, or where it is widest if that lies beside it."""
    if shape.contains(shapely.Point(middle)):
        return middle
    return np.array(shapely.get_point(shapely.maximum_inscribed_circle(shape), 0).coords[0])


def valid(shapes: Regions) -> Regions:
    """The same shapes; those that cross themselves are replaced by the area that they cover."""
    bad = np.flatnonzero(~shapely.is_valid(shapes))
    if len(bad) == 0:
        return shapes
    mended: Regions = np.array(shapes, dtype=object)
    for i in bad:
        parts = shapely.get_parts(shapely.get_parts(shapely.make_valid(shapes[i])))
        mended[i] = shapely.multipolygons(parts[shapely.area(parts) > 0.0])
    return mended


def overlay(operation: _Overlay, one: Any, other: Any) -> Any:
    """``shapely.intersection`` or ``shapely.difference``, repeated on a fine grid where it fails.

    The exact overlay can fail for shapes whose outlines nearly coincide. On a grid of 1e-10 of
    their extent it is safe, and the lost area is negligible.
    """
    try:
        return operation(one, other)
    except shapely.errors.GEOSException:
        extent = np.ravel([shapely.bounds(one), shapely.bounds(other)])
        grid = 1e-10 * float(np.nanmax(np.abs(extent)))
        return operation(one, other, grid_size=grid)


def pieces_of(shapes: Regions) -> tuple[Floats, Ints, Ints]:
    """Simple counter-clockwise polygons that make up shapes, without parts of zero area.

    Parameters
    ----------
    shapes : (q,) shapely geometries
        A polygon with holes is cut through each hole, along the direction of its longest edge.

    Returns
    -------
    corner : (l, 2)
    start : (s + 1,)
    row : (s,) ascending, the shape that each piece belongs to
    """
    parts, row = _polygons(shapes, np.arange(len(shapes), dtype=np.intp))
    while (holed := shapely.get_num_interior_rings(parts) > 0).any():
        halves, source = _polygons(
            np.array([h for p in parts[holed] for h in _halved(p)], dtype=object),
            np.repeat(row[holed], 2),
        )
        parts = np.concatenate([parts[~holed], halves])
        row = np.concatenate([row[~holed], source])
        order = np.argsort(row, kind="stable")
        parts, row = parts[order], row[order]
    if len(parts) == 0:
        return np.zeros((0, 2)), np.zeros(1, dtype=np.intp), row
    rings = shapely.get_exterior_ring(parts)
    turned = np.where(shapely.is_ccw(rings), rings, shapely.reverse(rings))
    corner, ring = shapely.get_coordinates(turned, return_index=True)
    last = np.concatenate([np.diff(ring) > 0, [True]])
    corner, ring = corner[~last], ring[~last]
    start = np.searchsorted(ring, np.arange(len(parts) + 1)).astype(np.intp)
    return corner, start, row


def _polygons(shapes: Regions, row: Ints) -> tuple[Regions, Ints]:
    """The polygons with an area in shapes of any kind, and their rows."""
    for _ in range(2):  # a collection may hold a multipolygon
        shapes, source = shapely.get_parts(shapes, return_index=True)
        row = row[source]
    keep = (shapely.get_type_id(shapes) == shapely.GeometryType.POLYGON) & (
        shapely.area(shapes) > 0.0
    )
    return shapes[keep], row[keep]


def _halved(polygon: Any) -> list[Any]:
    """A polygon with holes, cut along a line through its first hole."""
    outline = shapely.get_coordinates(shapely.get_exterior_ring(polygon))
    edge = np.diff(outline, axis=0)
    length = np.hypot(edge[:, 0], edge[:, 1])
    along = edge[int(np.argmax(length))] / length.max()
    across = np.array([-along[1], along[0]])
    hole = shapely.get_coordinates(shapely.get_interior_ring(polygon, 0))
    middle = 0.5 * (hole.min(axis=0) + hole.max(axis=0))
    far = 2.0 * float(np.abs(outline - middle).max()) + 1.0 * length.max()
    ends = middle + np.outer([-far, far], across)
    side = far * along
    halves = [shapely.polygons(np.concatenate([ends, ends[::-1] + s * side])) for s in (1.0, -1.0)]
    return [overlay(shapely.intersection, polygon, half) for half in halves]


def half_plane(slope: Floats, height: float, reach: float) -> shapely.Polygon | None:
    """The region ``slope . x + height >= 0`` up to ``reach``; first edge on the line."""
    size = float(np.linalg.norm(slope))
    if size < ROUNDING:
        return None
    across = slope / size
    along = np.array([-across[1], across[0]])
    foot = -height / size * across
    reach += abs(height) / size
    return shapely.Polygon(
        [
            foot - reach * along,
            foot + reach * along,
            foot + reach * (along + across),
            foot + reach * (across - along),
        ]
    )


def parts_of(shape: shapely.Geometry, kind: str) -> list[shapely.Geometry]:
    """The simple parts of one kind."""
    found = []
    for part in shapely.get_parts(shape):
        found += parts_of(part, kind) if part.geom_type.startswith(("Multi", "Geom")) else [part]
    return [part for part in found if part.geom_type == kind and not part.is_empty]


def rings_of(polygon: shapely.Polygon, least: float) -> list[Floats]:
    """A polygon as counter-clockwise loops (c, 2) without holes; slivers are left out."""
    if polygon.area < least:
        return []
    oriented = shapely.geometry.polygon.orient(polygon)
    rings = [np.array(ring.coords)[:-1] for ring in (oriented.exterior, *oriented.interiors)]
    if len(rings) == 1:
        return rings
    flat = np.concatenate(rings)
    start = np.cumsum([0, *(len(ring) for ring in rings)])
    loops = [tuple(range(a, b)) for a, b in pairwise(start.tolist())]
    raised = np.column_stack([flat, np.zeros(len(flat))])
    return [flat[list(loop)] for loop in faces_with_holes(raised, [loops])]


def faces_with_holes(vertices: Floats, faces: Sequence[Sequence[Loop]]) -> list[Loop]:
    """Faces as simple loops: a face with holes becomes triangles between the same vertices.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Per face its outline (counter-clockwise from outside), then its holes (clockwise).

    Raises
    ------
    InputError
        The holes of a face do not lie inside it.

    Examples
    --------
    >>> ring = [[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0], [1, 1, 0], [1, 2, 0], [2, 2, 0]]
    >>> len(faces_with_holes(np.array(ring, dtype=float), [[(0, 1, 2, 3), (4, 5, 6)]]))
    7
    """
    simple: list[Loop] = []
    for number, (outline, *holes) in enumerate(faces):
        if holes:
            simple += _triangles(vertices, outline, holes, number)
        else:
            simple.append(tuple(outline))
    return simple


def _triangles(vertices: Floats, outline: Loop, holes: Sequence[Loop], number: int) -> list[Loop]:
    corners = np.array([*outline, *(corner for hole in holes for corner in hole)], dtype=np.intp)
    area = area_vector(vertices[list(outline)])
    length = float(np.linalg.norm(area))
    if length == 0.0:
        raise InputError(f"face {number} has no area")
    _, u, v = frames_from_normals((area / length)[None])[0]
    flat = np.stack([vertices @ u, vertices @ v], axis=1)
    region = shapely.Polygon(flat[list(outline)], [flat[list(hole)] for hole in holes])
    if not region.is_valid:
        raise InputError(
            f"face {number} has holes that do not lie inside it", remedy="model the face again"
        )
    known = {tuple(flat[i].tolist()): int(i) for i in corners}
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(region))
    loops: list[Loop] = []
    for triangle in shapely.orient_polygons(triangles):
        ring = shapely.get_coordinates(triangle)[:3].tolist()
        loops.append(tuple(known[tuple(point)] for point in ring))
    return loops
