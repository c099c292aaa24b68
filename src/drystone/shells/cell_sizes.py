"""Sizes of a shape and of its cells: volume, width, thickness, and the area of flat cells."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from numbers import Real
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats, dot
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.geometry import polygon
from drystone.shells.lengths import numbers
from drystone.shells.materialise import flat_loops, vertex_means
from drystone.shells.patch import Patch, curvatures
from drystone.shells.pattern import Tessellation
from drystone.shells.shape import Shape

SAMPLES = 64
"""Samples along u and v for areas and volumes. Chosen: the error for a dome is 1e-4."""

Thickness: TypeAlias = float | Sequence[float] | Callable[[Floats], Floats]
"""[m]: one value, one per course, or a function of points (k, 3) on the middle surface."""

_LARGEST_SHARE = 2.0 / 3.0
"""Share of the sagitta at which a flat cell lies half outside and half inside the surface."""


def mean_width(mesh: Tessellation) -> float:
    """[m], square root of the mean area of a cell: the size of a block."""
    loop, start = flat_loops(mesh.cells)
    area = np.linalg.norm(polygon.area_vectors(mesh.point[loop], start), axis=1)
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
    """
    total = 0.0
    for patch in shape.patches:
        u, v, area = _parts(patch)
        gauss = curvatures(patch, u, v).prod(axis=2)
        total += float((area * thickness * (1.0 + gauss * thickness**2 / 12.0)).sum())
    return total


def _parts(patch: Patch) -> tuple[Floats, Floats, Floats]:
    """Middles (p, 1) and (1, p) in u and v of small parts of a patch, and their areas (p, p)."""
    grid = (np.arange(SAMPLES) + 0.5) / SAMPLES
    u, v = grid[:, None], grid[None, :]
    return u, v, np.linalg.norm(np.cross(*patch.tangents(u, v)), axis=2) / SAMPLES**2


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
    loop, start = flat_loops(mesh.cells)
    area = polygon.area_vectors(mesh.point[loop], start)
    size = np.linalg.norm(area, axis=1)
    middle = Ragged(start).mean(mesh.point[loop])
    rise = dot(mesh.crest - middle, area) / np.maximum(size, 1e-300)
    move = vertex_means(mesh, np.nan_to_num(rise))[:, None] * mesh.normal
    known = np.isfinite(rise)
    wanted = sum(float(_parts(patch)[2].sum()) for patch in shape.patches)

    def missing_area(share: float) -> float:
        moved = polygon.area_vectors((mesh.point + share * move)[loop], start)
        return wanted - float(np.linalg.norm(moved, axis=1)[known].sum())

    at_zero, at_limit = missing_area(0.0), missing_area(_LARGEST_SHARE)
    if at_zero <= 0.0 or at_limit >= at_zero:
        return mesh, 0.0
    share = min(_LARGEST_SHARE, _LARGEST_SHARE * at_zero / (at_zero - at_limit))
    largest = float(np.linalg.norm(share * move, axis=1).max())
    return replace(mesh, point=mesh.point + share * move), largest
