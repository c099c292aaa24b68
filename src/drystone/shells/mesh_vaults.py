"""Vaults from support to support through an open mesh that stands on three or more supports.

The mesh is mapped to a regular polygon whose sides are its supports and its open sides in turn.
Lines from the middle of each support to the middle of the polygon divide it into vaults, one at
each open side. Their courses are arches from one support to the next.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CloughTocher2DInterpolator

from drystone.base.arrays import Floats, frozen_points
from drystone.base.errors import InputError
from drystone.shells.flat_mesh import border_of, mapped, side_between, turns_of, welded
from drystone.shells.formfinding import find_form
from drystone.shells.patch import Side
from drystone.shells.shape import Edge, Shape
from drystone.shells.shell_families import vaults_between
from drystone.shells.sources import patch_from_grid

_NODES = 25
"""Points along u and v of each vault, as of a form that is found."""


def vaults_from_mesh(
    vertices: object,
    faces: Sequence[Sequence[int]],
    *,
    corners: Sequence[int] | None = None,
    name: str = "mesh",
) -> Shape:
    """Vaults through an open mesh with one border, one at each open side.

    Parameters
    ----------
    vertices : (p, 3) [m]
    faces
        Loops of vertices.
    corners
        The two ends of each support, three supports or more, in their order along the border. When
        left out: the turns of the border, of which the lower sides are the supports.
    name

    Raises
    ------
    InputError
        The mesh is closed or has several borders, or its corners are not those of three supports
        or more.

    Notes
    -----
    Every inner vertex lies at the mean of its neighbours, weighted by inverse length (source:
    Floater 1997). Between the vertices the surface is a smooth interpolation.
    """
    points = frozen_points(vertices, (None, 3), "vertices")
    points, loops, named = welded(points, faces, corners)
    border = border_of(loops, name)
    chosen = named if named is not None else _support_ends(points, border)
    if len(chosen) < 6 or len(chosen) % 2:
        raise InputError(
            f"its border has {len(chosen)} corners",
            where=f"mesh '{name}'",
            remedy="name the two ends of each support, three supports or more, along the border",
        )
    angle = 2.0 * np.pi * np.arange(len(chosen)) / len(chosen)
    polygon = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
    place = mapped(points, loops, border, chosen, polygon[:, :2], name)
    surface = CloughTocher2DInterpolator(place, points)
    open_sides = 0.5 * (polygon[1::2] + np.roll(polygon[0::2], -1, axis=0))
    plan = vaults_between(polygon.reshape(-1, 2, 3), open_sides, name="vaults")
    borders = [Edge(k, Side.BOTTOM) for k in range(len(plan.patches))]
    held = plan.supported_on(*plan.supports, *borders)  # a net over it has smooth lines
    flat = find_form(held, height=1.0, rows=_NODES, columns=_NODES).shape
    share = np.linspace(0.0, 1.0, _NODES)
    patches = []
    for k, vault in enumerate(flat.patches):
        inside = (1.0 - 1e-9) * vault.point(share[:, None], share[None, :])[..., :2]  # of the hull
        grid = surface(inside.reshape(-1, 2)).reshape(_NODES, _NODES, 3)
        patches.append(patch_from_grid(grid, breaks=[_NODES // 2], name=f"vault {k} of {name}"))
    return Shape(tuple(patches), plan.seams, plan.supports, name=name)


def several_supports(vertices: object, faces: Sequence[Sequence[int]]) -> bool:
    """Whether the border of a mesh turns as sharply at six corners or more.

    Raises
    ------
    InputError
        The mesh is closed or has several borders.
    """
    points, loops, _ = welded(frozen_points(vertices, (None, 3), "vertices"), faces, None)
    return bool(_support_ends(points, border_of(loops, "surface")))


def _support_ends(points: Floats, border: list[int]) -> list[int]:
    """The ends of the supports, along the border; none where these are not three or more.

    Corners are the turns at least half as sharp as the sharpest one. Of the sides between them
    every other one is a support, the lower ones.
    """
    turn = turns_of(points, border)
    ends = [border[i] for i in np.flatnonzero(turn >= 0.5 * turn.max()).tolist()]
    if len(ends) < 6 or len(ends) % 2:
        return []
    heights = [
        float(points[side_between(border, one, other), 2].mean())
        for one, other in zip(ends, [*ends[1:], ends[0]], strict=True)
    ]
    return ends if sum(heights[0::2]) <= sum(heights[1::2]) else [*ends[1:], ends[0]]
