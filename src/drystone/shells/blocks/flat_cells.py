"""Flat cells that replace a curved surface and have its area."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.geometry.plane import polygon
from drystone.shells.blocks.materialise import flat_loops, vertex_means
from drystone.shells.bond.tessellation import Tessellation
from drystone.shells.surface.shape import Shape

LARGEST_SHARE = 2.0 / 3.0
"""Share of the sagitta at which a flat cell lies half outside and half inside the surface."""


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
    middle = polygon.loop_means(mesh.point[loop], start)
    rise = np.einsum("ci,ci->c", mesh.crest - middle, area) / np.maximum(size, 1e-300)
    move = vertex_means(mesh, np.nan_to_num(rise))[:, None] * mesh.normal
    known = np.isfinite(rise)
    wanted = _surface_area(shape)

    def missing_area(share: float) -> float:
        moved = polygon.area_vectors((mesh.point + share * move)[loop], start)
        return wanted - float(np.linalg.norm(moved, axis=1)[known].sum())

    at_zero, at_limit = missing_area(0.0), missing_area(LARGEST_SHARE)
    if at_zero <= 0.0 or at_limit >= at_zero:
        return mesh, 0.0
    share = min(LARGEST_SHARE, LARGEST_SHARE * at_zero / (at_zero - at_limit))
    largest = float(np.linalg.norm(share * move, axis=1).max())
    return replace(mesh, point=mesh.point + share * move), largest


def _surface_area(shape: Shape) -> float:
    grid = (np.arange(64) + 0.5) / 64.0
    total = 0.0
    for patch in shape.patches:
        by_u, by_v = patch.tangents(grid[:, None], grid[None, :])
        total += float(np.linalg.norm(np.cross(by_u, by_v), axis=2).sum()) / 64.0**2
    return total
