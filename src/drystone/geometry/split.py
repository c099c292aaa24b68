"""Polyhedra cut by planes, and by wedges of two planes, into closed pieces."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.geometry.coincidence import distinct
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.holes import faces_with_holes
from drystone.geometry.polygon import area_vector
from drystone.geometry.polyhedron import Loop
from drystone.geometry.soup import split_solids

_SAME = 1e-9
"""Points closer than this share of the body's extent are one point. The value is above the rounding
of intersections and below the length of any edge."""

Piece = tuple[Floats, list[Loop]]
"""Vertices (v, 3) [m], and faces as loops of them."""


def split(
    vertices: Floats, faces: Sequence[Loop], normals: Floats, points: Floats
) -> tuple[list[Piece], list[Piece]]:
    """The pieces of a body inside the half spaces, and those outside.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Planar, counter-clockwise seen from outside.
    normals : (p, 3)
        Of one or two planes; each half space is on the side of the normal.
    points : (p, 3) [m]
        One of each plane.

    Returns
    -------
    inside, outside
        Closed pieces; may be empty.

    Raises
    ------
    InputError
        A plane lies on a face.

    Examples
    --------
    >>> from drystone.models import box
    >>> cube = box((1.0, 1.0, 1.0))
    >>> above, below = split(
    ...     cube.vertices, cube.faces, np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, 0.25]]))
    >>> [len(piece[1]) for piece in (*above, *below)]
    [6, 6]
    """
    extent = float(np.ptp(vertices, axis=0).max())
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    inside: list[Floats] = []
    outside: list[Floats] = []
    chords: list[list[Floats]] = [[] for _ in normals]
    for loop in faces:
        corner = vertices[list(loop)]
        area = area_vector(corner)
        frame = frames_from_normals((area / np.linalg.norm(area))[None])[0]
        flat = (corner - corner[0]) @ frame[1:].T
        polygon = shapely.Polygon(flat)
        region = shapely.box(*(2.0 * extent * np.array([-1.0, -1.0, 1.0, 1.0])))
        for number, (normal, point) in enumerate(zip(normals, points, strict=True)):
            slope, height = frame[1:] @ normal, float((corner[0] - point) @ normal)
            line = half_plane(slope, height, 4.0 * extent)
            if line is None:
                if abs(height) < _SAME * extent:
                    raise InputError("a plane of the cut lies on a face", remedy="move the cut")
                if height < 0.0:
                    region = shapely.Polygon()
                continue
            region = shapely.intersection(region, line)
            edge = shapely.LineString(np.array(line.exterior.coords)[:2])
            for part in parts_of(shapely.intersection(polygon, edge), "LineString"):
                chords[number].append(corner[0] + np.array(part.coords)[[0, -1]] @ frame[1:])
        for target, piece in (
            (inside, shapely.intersection(polygon, region)),
            (outside, shapely.difference(polygon, region)),
        ):
            target += [
                corner[0] + ring @ frame[1:]
                for part in parts_of(piece, "Polygon")
                for ring in rings_of(part, _SAME * extent**2)
            ]
    for number, (normal, point) in enumerate(zip(normals, points, strict=True)):
        caps = _caps(chords[number], normal, point, np.delete(normals, number, 0),
                     np.delete(points, number, 0), extent)  # fmt: skip
        inside += [cap[::-1] for cap in caps]
        outside += caps
    return _pieces(inside, extent), _pieces(outside, extent)


def half_plane(slope: Floats, height: float, reach: float) -> shapely.Polygon | None:
    """The region ``slope . x + height >= 0`` up to ``reach``; first edge on the line."""
    size = float(np.linalg.norm(slope))
    if size < _SAME:
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


def _caps(
    chords: Sequence[Floats], normal: Floats, point: Floats, others: Floats, at: Floats,
    extent: float,
) -> list[Floats]:  # fmt: skip
    """The section of the body by a plane, inside the other half spaces."""
    if not chords:
        return []
    frame = frames_from_normals(normal[None])[0]
    ends = np.concatenate(chords)
    kept, number = distinct(ends, _SAME * extent)
    places = (ends[kept] - point) @ frame[1:].T
    pairs = np.unique(np.sort(number.reshape(-1, 2), axis=1), axis=0)
    lines = [shapely.LineString(places[pair]) for pair in pairs if pair[0] != pair[1]]
    section = shapely.Polygon()
    for ring in shapely.get_parts(shapely.polygonize(lines)):
        outline = shapely.Polygon(ring.exterior)
        section = shapely.symmetric_difference(section, outline)
    for other, place in zip(others, at, strict=True):
        line = half_plane(frame[1:] @ other, float((point - place) @ other), 4.0 * extent)
        if line is not None:
            section = shapely.intersection(section, line)
    return [
        point + ring @ frame[1:]
        for part in parts_of(section, "Polygon")
        for ring in rings_of(part, _SAME * extent**2)
    ]


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


def _pieces(loops: Sequence[Floats], extent: float) -> list[Piece]:
    """Closed pieces from loose faces."""
    if not loops:
        return []
    corners = np.concatenate(loops)
    kept, number = distinct(corners, _SAME * extent)
    vertices = corners[kept]
    ends = np.cumsum([len(loop) for loop in loops])[:-1]
    faces = [tuple(dict.fromkeys(part.tolist())) for part in np.split(number, ends)]
    faces = [face for face in faces if len(face) > 2]
    return [(vertices, [faces[i] for i in some]) for some in split_solids(vertices, faces)]
