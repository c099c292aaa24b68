"""Bodies whose surface has several closed shells: separate parts and cavities."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Floats
from drystone.geometry.polyhedron import (
    Loop,
    face_components,
    fan_triangles,
    mass_properties,
    stack_faces,
)
from drystone.geometry.solid import winding_number


def separate_parts(vertices: Floats, faces: Sequence[Loop]) -> tuple[list[list[Loop]], int]:
    """Parts of a body, each with its cavities, with all shells correctly oriented.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Closed, and consistently oriented within each shell.

    Returns
    -------
    parts
        Per part its loops. One part for a body that is in one piece.
    turned
        Number of shells that were inside out. A shell inside an even number of others is the
        outside of a part. A shell inside an odd number of others bounds a cavity.
    """
    components = face_components(faces)
    if len(components) == 1:
        return [list(faces)], 0
    loops = [[faces[i] for i in component] for component in components]
    stacked = stack_faces([vertices] * len(loops), loops)
    volume = mass_properties(stacked, len(loops))[0]
    corners = [vertices[sorted({v for loop in one for v in loop})] for one in loops]
    around = _shells_around(vertices, loops, corners)
    turned = 0
    for i, shell in enumerate(loops):
        cavity = len(around[i]) % 2 == 1
        if (volume[i] < 0.0) != cavity:
            loops[i] = [loop[::-1] for loop in shell]
            turned += 1
    parts: dict[int, list[Loop]] = {}
    for i, shell in enumerate(loops):
        home = i
        if len(around[i]) % 2 == 1:
            home = min(around[i], key=lambda j: abs(volume[j]))
        parts.setdefault(home, []).extend(shell)
    return list(parts.values()), turned


def _shells_around(
    vertices: Floats, loops: Sequence[Sequence[Loop]], corners: Sequence[Floats]
) -> list[list[int]]:
    """For each shell those that contain most of its vertices."""
    low = np.array([points.min(axis=0) for points in corners])
    high = np.array([points.max(axis=0) for points in corners])
    found: list[list[int]] = []
    for shell, points in enumerate(corners):
        inside = (low <= low[shell]).all(axis=1) & (high >= high[shell]).all(axis=1)
        inside[shell] = False
        found.append([])
        for other in np.flatnonzero(inside).tolist():
            surface = fan_triangles(stack_faces([vertices], [loops[other]]))[0]
            if float(np.median(np.abs(winding_number(points, surface)))) > 0.75:
                found[-1].append(other)
    return found
