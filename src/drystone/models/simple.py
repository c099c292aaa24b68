"""Boxes, towers and other models with a closed-form answer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block

BOX_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
"""Faces of a hexahedron whose vertices are the bottom loop 0 to 3, counter-clockwise from above,
and the top loop 4 to 7 over it."""


def box(
    size: Sequence[float],
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    name: str = "box",
    density: float = DEFAULT_DENSITY,
) -> Block:
    """An axis-aligned box with its lowest corner at ``origin`` [m] and edges ``size`` [m]."""
    x, y, z = (float(s) for s in size)
    low = np.array([[0, 0, 0], [x, 0, 0], [x, y, 0], [0, y, 0]], dtype=np.float64)
    vertices = np.concatenate([low, low + np.array([0.0, 0.0, z])]) + np.asarray(
        origin, dtype=np.float64
    )
    return Block(vertices, BOX_FACES, name, density)


def tower(count: int, edge: float = 1.0) -> Assembly:
    """``count`` cubes of ``edge`` [m] on top of each other, the lowest fixed."""
    blocks = [
        box((edge, edge, edge), (0.0, 0.0, i * edge), name=f"block-{i}") for i in range(count)
    ]
    return Assembly(tuple(blocks), np.arange(count) == 0)
