"""Blocks from cells on a surface: sizes, pins through the thickness, side faces, polyhedra."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any, TypeAlias

import numpy as np
import shapely

from drystone.assembly import DEFAULT_DENSITY, Block
from drystone.base.arrays import ROUNDING, Floats, Ints, dot
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.geometry.frames import area_vectors, frames_from_normals
from drystone.geometry.polyhedron import loop_edges, used_vertices
from drystone.geometry.triangulate import triangulate, warp_and_view
from drystone.shells.patch import Shape, curvatures, numbers
from drystone.shells.pattern import Tessellation

_LEAST_COSINE = 0.5
"""Least cosine between the normal of a vertex and the flat cells around it. Chosen: beyond 60
degrees the faces of a block no longer approximate the surface."""


HOOK = ((0.4, 1.4), (0.84, 0.185), (0.74, 0.1))
"""Corners of a joggle, from the intrados: position through the thickness, divided by half the
thickness h, and height, divided by h t with the slope t. The first face has the slope t, the
undercut 0.85 t. No translation is free because 0.85 < 1. A rotation about a point (1, -z) is free
where z <= 0.6 / t - 1.4 t and z >= 0.26 / (0.85 t) - 0.1 t. Such points exist up to t = 0.475. At a
slope of 10 degrees the angle at the ridge is 36 degrees, so the contact search treats it as an edge
and not as a curved surface."""

Polygon: TypeAlias = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Pins(OneLine):
    """Lines of points through the thickness, one line per vertex of the tessellation.

    Attributes
    ----------
    point : (p, 3) [m]
        From the intrados to the extrados, vertex after vertex: two points, or five where the bed
        joint has a joggle.
    start : (v + 1,) vertex i has the points start[i] to start[i + 1]
    faceted
        Whether a warped side face is two triangles.
    """

    point: Floats
    start: Ints
    faceted: bool = False

    def of(self, vertex: int) -> range:
        """Points of one vertex, intrados first."""
        return range(int(self.start[vertex]), int(self.start[vertex + 1]))


def vertex_means(mesh: Tessellation, per_cell: Floats) -> Floats:
    """Mean (v,) at each vertex of a value per cell (c,)."""
    loop, start = mesh.loops
    return _corner_means(loop, np.repeat(per_cell, np.diff(start)), len(mesh.point))


def _corner_means(loop: Ints, value: Floats, count: int) -> Floats:
    """(count,) mean at each vertex of a value per corner (l,) of the loops."""
    corners = np.maximum(np.bincount(loop, minlength=count), 1)
    return np.bincount(loop, value, minlength=count) / corners


def _facet_means(mesh: Tessellation, point: Floats, vector: Floats) -> Floats:
    """Mean component (v,) of each vertex's vector (v, 3) normal to the flat cells around it.

    The cells have their vertices at ``point`` (v, 3).
    """
    loop, start = mesh.loops
    area = area_vectors(point[loop], start)
    facet = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), 1e-300)
    across = dot(vector[loop], np.repeat(facet, np.diff(start), axis=0))
    return _corner_means(loop, across, len(point))


def raise_pins(mesh: Tessellation, thickness: Floats) -> Pins:
    """Straight pins along the normals, half the thickness (v,) [m] to each side.

    Raises
    ------
    InputError
        The surface turns by more than 60 degrees across a block.
    """
    # pins divided by this give blocks the required thickness, measured normal to their faces
    cosine = _facet_means(mesh, mesh.point, mesh.normal)
    steep = cosine < _LEAST_COSINE
    if steep.any():
        raise InputError(
            "is too large: the surface turns by more than 60 degrees beside it",
            where=f"block '{mesh.name_at(int(np.argmax(steep)))}'",
            remedy="give more courses and blocks",
        )
    half = 0.5 * thickness / cosine
    low = mesh.point - half[:, None] * mesh.normal
    high = mesh.point + half[:, None] * mesh.normal
    point = np.stack([low, high], axis=1).reshape(-1, 3)
    return Pins(point, 2 * np.arange(len(low) + 1, dtype=np.intp))


def add_joggle(mesh: Tessellation, pins: Pins, joggle_deg: float) -> Pins:
    """Give straight pins on bed lines between two courses a joggle.

    The section of a bed joint has four faces. From the intrados it rises at ``joggle_deg``
    [degrees] to a ridge, falls, returns under the ridge, and then runs to the extrados. No
    translation opens all four faces, so the upper block cannot be lifted straight. It can be
    removed by a rotation about the direction of the course, with a centre below the extrados. A
    negative joggle is the mirror image; the rotation is then inwards. The joggle lies in the plane
    of the head joint that ends at the pin, so the head joint stays planar.
    """
    low, high = pins.point[0::2], pins.point[1::2]
    middle, along = 0.5 * (low + high), high - low
    length = np.linalg.norm(along, axis=1, keepdims=True)
    up = mesh.up.copy()
    heads = np.array(sorted(mesh.heads), dtype=np.intp).reshape(-1, 2)
    rise = middle[heads[:, 1]] - middle[heads[:, 0]]
    rise *= np.sign(dot(rise, mesh.up[heads[:, 0]]))[:, None]
    up[heads[:, 0]] = rise
    up[heads[:, 1]] = rise
    axis = along / length
    up -= dot(up, axis)[:, None] * axis
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    half, slope = 0.5 * length, np.tan(np.deg2rad(abs(joggle_deg)))
    side = 1.0 if joggle_deg >= 0.0 else -1.0
    count = np.where(mesh.inner, 2 + len(HOOK), 2)
    start = Ragged.from_counts(count).start
    point = np.empty((start[-1], 3))
    point[start[:-1]], point[start[1:] - 1] = low, high
    first = start[:-1][mesh.inner]
    for i, (across, rise_by) in enumerate(HOOK if side > 0.0 else HOOK[::-1], start=1):
        corner = middle + half * (side * across * axis + slope * rise_by * up)
        point[first + i] = corner[mesh.inner]
    return Pins(point, start)


def keep_thickness(mesh: Tessellation, pins: Pins, thickness: Floats) -> Pins:
    """Lengthen tilted pins until the blocks have the required thickness.

    The thickness is measured normal to the faces. A pin grows along its own line, so planar joints
    between straight pins stay planar.
    """
    first, last = pins.start[:-1], pins.start[1:] - 1
    low, high = pins.point[first], pins.point[last]
    middle = 0.5 * (low + high)
    across = _facet_means(mesh, middle, high - low)
    factor = np.clip(thickness / np.maximum(across, 1e-300), 0.5, 2.0)
    pin = np.repeat(np.arange(len(middle)), np.diff(pins.start))
    grown = middle[pin] + factor[pin, None] * (pins.point - middle[pin])
    return replace(pins, point=grown)


def _side_polygons(mesh: Tessellation, pins: Pins, edge: tuple[int, int]) -> list[tuple[int, ...]]:
    """Side faces of the cell on the left of an edge, outwards.

    One; four at a joggle; two where a warped face is faceted, with the same diagonal for both
    cells.
    """
    a, b = pins.of(edge[0]), pins.of(edge[1])
    if pins.faceted and _is_warped(pins.point[[a[0], b[0], b[1], a[1]]]):
        if edge[0] < edge[1]:
            return [(a[0], b[0], b[1]), (a[0], b[1], a[1])]
        return [(a[0], b[0], a[1]), (b[0], b[1], a[1])]
    head = (min(edge), max(edge)) in mesh.heads
    if len(a) == len(b) and not head:
        return [(a[i], b[i], b[i + 1], a[i + 1]) for i in range(len(a) - 1)]
    return [(*b, *reversed(a))]


def _is_warped(corner: Floats) -> bool:
    """Whether four corners (4, 3) [m] are not in one plane."""
    across = np.cross(corner[2] - corner[0], corner[3] - corner[1])
    size = float(np.linalg.norm(across))
    return bool(abs((corner[1] - corner[0]) @ across) > ROUNDING * size**1.5)


def joint_polygons(mesh: Tessellation, pins: Pins) -> list[tuple[int, ...]]:
    """Every side face once."""
    seen: set[frozenset[int]] = set()
    polygons = []
    for cell in mesh.cells:
        for edge in loop_edges(cell):
            key = frozenset(edge)
            if key not in seen:
                seen.add(key)
                polygons += _side_polygons(mesh, pins, edge)
    return polygons


def cell_faces(
    mesh: Tessellation, pins: Pins, cell: Sequence[int]
) -> tuple[tuple[int, ...], tuple[int, ...], list[tuple[int, ...]]]:
    """Intrados, extrados and side faces of one cell, all outwards."""
    low = tuple(int(pins.start[v]) for v in reversed(cell))
    high = tuple(int(pins.start[v + 1]) - 1 for v in cell)
    edges = loop_edges(cell)
    return low, high, [face for edge in edges for face in _side_polygons(mesh, pins, edge)]


def make_blocks(
    mesh: Tessellation,
    pins: Pins,
    metadata: Sequence[dict[str, Any]],
    *,
    density: float = DEFAULT_DENSITY,
) -> list[Block]:
    """One block per cell; neighbours share the corners of their common faces.

    Inner and outer faces stay polygons, also slightly warped ones. A warped face stands for the fan
    about the mean of its corners. Where this fan would fold over, the face becomes triangles.

    Raises
    ------
    InputError
        A block is inside out, or a face crosses itself; the block is named.
    """
    _refuse_crossed_faces(mesh, pins)
    blocks = []
    every = [cell_faces(mesh, pins, cell) for cell in mesh.cells]
    caps = _solid_caps(pins, [cap for low, high, _ in every for cap in (low, high)])
    for k, (name, data) in enumerate(zip(mesh.names, metadata, strict=True)):
        faces = [*caps[2 * k], *caps[2 * k + 1], *every[k][2]]
        used, loops = used_vertices(faces)
        block = Block(pins.point[used], tuple(loops), name, density, data)
        if block.repairs:
            raise InputError(
                "is turned inside out",
                where=f"block '{name}'",
                remedy="use a smaller thickness, wedge or joggle, or larger blocks",
            )
        blocks.append(block)
    return blocks


def _solid_caps(pins: Pins, caps: Sequence[Polygon]) -> list[list[Polygon]]:
    """Every inner and outer face as one polygon, or as triangles where its fan would fold over."""
    loop, start = np.concatenate(caps), Ragged.of(caps).start
    height, seen = warp_and_view(pins.point[loop], start)
    area = np.linalg.norm(area_vectors(pins.point[loop], start), axis=1)
    made = [[cap] for cap in caps]
    for i in np.flatnonzero((height > ROUNDING * np.sqrt(area)) & ~seen).tolist():
        corner = np.array(caps[i], dtype=np.intp)
        triangle, _ = triangulate(pins.point[corner], np.array([0, len(corner)]))
        made[i] = [tuple(row) for row in corner[triangle].tolist()]
    return made


def _refuse_crossed_faces(mesh: Tessellation, pins: Pins) -> None:
    """Raise for a face that, seen along its normal, is no simple polygon."""
    faces, owner = [], []
    for c, cell in enumerate(mesh.cells):
        low, high, sides = cell_faces(mesh, pins, cell)
        faces += [low, high, *sides]
        owner += [c] * (2 + len(sides))
    loop, start = np.concatenate(faces), Ragged.of(faces).start
    corner = pins.point[loop]
    area = area_vectors(corner, start)
    size = np.linalg.norm(area, axis=1)
    axes = frames_from_normals(area / np.maximum(size, 1e-300)[:, None])
    face = np.repeat(np.arange(len(faces)), np.diff(start))
    flat = np.einsum("lij,lj->li", axes[face, 1:], corner - corner[start[:-1]][face])
    ring = shapely.linearrings(flat, indices=face)
    bad = ~shapely.is_simple(ring) | (size <= 0.0)
    if bad.any():
        raise InputError(
            "has a face that crosses itself",
            where=f"block '{mesh.names[owner[int(np.flatnonzero(bad)[0])]]}'",
            remedy="use a smaller thickness, wedge or joggle, or larger blocks",
        )


Thickness: TypeAlias = float | Sequence[float] | Callable[[Floats], Floats]
"""[m]: one value, one per course, or a function of points (k, 3) on the middle surface."""

_LARGEST_SHARE = 2.0 / 3.0
"""Share of the sagitta at which a flat cell lies half outside and half inside the surface."""


def mean_width(mesh: Tessellation) -> float:
    """[m], square root of the mean area of a cell: the size of a block."""
    loop, start = mesh.loops
    area = np.linalg.norm(area_vectors(mesh.point[loop], start), axis=1)
    return float(np.sqrt(area.mean()))


def check_radius(shape: Shape, thickness: float) -> None:
    """Check that a shell is thinner than its smallest radius of curvature.

    Raises
    ------
    InputError
        It is thicker.
    """
    grid = (np.arange(17) + 0.5) / 17.0
    for patch in shape.patches:
        bend = np.abs(curvatures(patch, grid[:, None], grid[None, :])).max(axis=2)
        sharpest = float(bend.max())
        if sharpest * thickness >= 1.0:
            i, j = np.unravel_index(int(np.argmax(bend)), bend.shape)
            raise InputError(
                f"thickness {thickness:.3g} m is larger than the radius of curvature "
                f"{1.0 / sharpest:.3g} m near u {grid[i]:.2f}, v {grid[j]:.2f}",
                where=f"patch '{patch.name}'",
                remedy="make it thinner or less curved",
            )


def shape_volume(shape: Shape, thickness: float) -> float:
    """[m3] of the smooth shell of constant thickness about the shape's patches.

    ``t dA (1 + K t^2 / 12)`` with the Gaussian curvature K (Steiner), by the midpoint rule.

    Parameters
    ----------
    shape
        Its patches are summed.
    thickness : [m]
        The same everywhere, half of it to each side.
    """
    total = 0.0
    for patch in shape.patches:
        u, v, area = patch.parts
        gauss = curvatures(patch, u, v).prod(axis=2)
        total += float((area * thickness * (1.0 + gauss * thickness**2 / 12.0)).sum())
    return total


def vertex_thickness(mesh: Tessellation, thickness: Thickness) -> Floats:
    """(v,) [m] thickness at each vertex; per course, the mean of the cells that meet there.

    Raises
    ------
    InputError
        Not positive, not finite, or of another length.
    """
    if callable(thickness):
        values = numbers(thickness(mesh.point), "thicknesses")
    elif isinstance(thickness, Real):
        values = np.full(len(mesh.point), float(thickness))
    else:
        each = numbers(thickness, "thicknesses")
        courses = int(mesh.course.max()) + 1
        if each.shape not in ((courses,), (courses - 1,)):
            raise InputError(
                f"{each.size} thicknesses for {courses} courses", remedy="give one per course"
            )
        per_cell = each[np.minimum(mesh.course, len(each) - 1)]
        values = vertex_means(mesh, per_cell)
    if values.shape != (len(mesh.point),):
        raise InputError(f"the thickness has shape {values.shape} for {len(mesh.point)} corners")
    if not (np.isfinite(values) & (values > 0.0)).all():
        k = int(np.flatnonzero(~(np.isfinite(values) & (values > 0.0)))[0])
        raise InputError(
            f"the thickness is {values[k]}",
            where=f"corner at {np.round(mesh.point[k], 3).tolist()}",
            remedy="give metres above zero",
        )
    return values


def fit_cells(mesh: Tessellation, shape: Shape) -> tuple[Tessellation, float]:
    """Move the vertices along their normals until the flat cells have the area of the surface.

    A chord is shorter than its arc. Cells with their corners on a curved surface have too little
    area, and the shell too little volume. Every vertex moves along its normal by a share of the
    mean rise of the surface over the cells around it. The share is the same for all vertices.

    Returns
    -------
    mesh
    largest : [m] largest move
    """
    loop, start = mesh.loops
    area = area_vectors(mesh.point[loop], start)
    size = np.linalg.norm(area, axis=1)
    middle = Ragged(start).mean(mesh.point[loop])
    rise = dot(mesh.crest - middle, area) / np.maximum(size, 1e-300)
    move = vertex_means(mesh, np.nan_to_num(rise))[:, None] * mesh.normal
    known = np.isfinite(rise)
    wanted = sum(float(patch.parts[2].sum()) for patch in shape.patches)

    def missing_area(share: float) -> float:
        moved = area_vectors((mesh.point + share * move)[loop], start)
        return wanted - float(np.linalg.norm(moved, axis=1)[known].sum())

    at_zero, at_limit = missing_area(0.0), missing_area(_LARGEST_SHARE)
    if at_zero <= 0.0 or at_limit >= at_zero:
        return mesh, 0.0
    share = min(_LARGEST_SHARE, _LARGEST_SHARE * at_zero / (at_zero - at_limit))
    largest = float(np.linalg.norm(share * move, axis=1).max())
    return replace(mesh, point=mesh.point + share * move), largest
