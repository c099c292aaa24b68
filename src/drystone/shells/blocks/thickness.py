"""The thickness of a shell at the vertices of its cells."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Real
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.shells.blocks.materialise import vertex_means
from drystone.shells.bond.tessellation import Tessellation
from drystone.shells.surface.lengths import numbers

Thickness: TypeAlias = float | Sequence[float] | Callable[[Floats], Floats]
"""[m]: one value, one per course, or a function of points (k, 3) on the middle surface."""


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
