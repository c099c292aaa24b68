"""Sizes of a shape and of its cells."""

from __future__ import annotations

import numpy as np

from drystone.base.errors import InputError
from drystone.geometry.plane import polygon
from drystone.shells.blocks.materialise import flat_loops
from drystone.shells.bond.tessellation import Tessellation
from drystone.shells.surface.patch import curvatures
from drystone.shells.surface.shape import Shape

SAMPLES = 48
"""Samples along u and v for volumes. Chosen: the error for a dome is 1e-4."""


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
    grid = (np.arange(SAMPLES) + 0.5) / SAMPLES
    total = 0.0
    for patch in shape.patches:
        by_u, by_v = patch.tangents(grid[:, None], grid[None, :])
        area = np.linalg.norm(np.cross(by_u, by_v), axis=2) / SAMPLES**2
        gauss = curvatures(patch, grid[:, None], grid[None, :]).prod(axis=2)
        total += float((thickness * area * (1.0 + gauss * thickness**2 / 12.0)).sum())
    return total
