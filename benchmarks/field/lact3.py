"""The portal, the wall and the arch of LACT3 on a tilting table.

Source: Hua, Buzzetti, Pingaro, da Silva and Milani 2025, LACT3 1.0 (GabrieleMilani/LACT3_v1.0):
the coordinates of its sample drawings, here to 0.1 mm, and the tilt angles at collapse that its
own solver test holds. They are those of limit analysis with associated friction; a linear program
of ours finds them to half a percent. The structures are plane; the depth, which does not matter,
is ours.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone import Assembly
from drystone.models.simple import prism

DEPTH = 0.2
"""[m], ours."""
WIDTH = 2.5
"""[m] Of the plate under the portal; its piers are mirror images about the middle."""

Polygon = Sequence[tuple[float, float]]


def _box(left: float, right: float, low: float, high: float) -> Polygon:
    return [(left, low), (right, low), (right, high), (left, high)]


PIER: list[Polygon] = [
    _box(0.15, 0.5364, 0.3, 0.45),
    _box(0.5364, 0.65, 0.3, 0.45),
    [(0.15, 0.45), (0.3432, 0.45), (0.2905, 0.6), (0.15, 0.6)],
    [(0.3432, 0.45), (0.65, 0.45), (0.65, 0.6), (0.2905, 0.6)],
    _box(0.15, 0.5301, 0.6, 0.8),
    _box(0.5301, 0.65, 0.6, 0.8),
    _box(0.15, 0.4219, 0.8, 0.9),
    _box(0.4219, 0.65, 0.8, 1.0186),
    _box(0.15, 0.4219, 0.9, 1.0186),
    _box(0.2545, 0.65, 1.0186, 1.0931),
    _box(0.15, 0.2545, 1.0186, 1.3),
    [(0.2545, 1.0931), (0.4522, 1.0931), (0.4522, 1.2718), (0.2545, 1.3)],
]
"""Corners (x, z) [m] of the blocks of the left pier."""
ABOVE: list[Polygon] = [
    _box(0.4522, 2.0478, 1.0931, 1.2718),
    _box(0.15, 0.2545, 1.3, 1.4158),
    [(0.2545, 1.3), (0.4522, 1.2718), (0.8444, 1.2718), (0.8444, 1.4158), (0.2545, 1.4158)],
    _box(0.8444, 1.1799, 1.2718, 1.4158),
    _box(1.1799, 1.5749, 1.2718, 1.4158),
    _box(1.5749, 2.0478, 1.2718, 1.5239),
    [(2.0478, 1.2718), (2.2455, 1.3), (2.2455, 1.5239), (2.0478, 1.5239)],
    _box(2.2455, 2.35, 1.3, 1.5239),
    _box(0.15, 0.6621, 1.4158, 1.5988),
    _box(0.6621, 1.0121, 1.4158, 1.5988),
    _box(1.0121, 1.5749, 1.4158, 1.5988),
    _box(1.5749, 2.35, 1.5239, 1.5988),
    _box(0.15, 0.8908, 1.5988, 1.9402),
    _box(0.8908, 1.4462, 1.5988, 1.9402),
    _box(1.4462, 2.35, 1.5988, 1.7695),
    _box(1.4462, 2.35, 1.7695, 1.9402),
]
"""The lintel and the blocks above it."""

BRICK, COURSE = 0.25, 1.5 / 27
"""[m] Length and height of a brick of the wall."""
_EVEN: Sequence[float] = [1, -1, 1, 0.5, -2, 0.5, 1, 1]
_ODD: Sequence[float] = [0.5, 0.5, -1, 0.5, 1, -2, 1, 1, 0.5]
WALL: list[Sequence[float]] = [
    [1] * 8,
    [0.5, 0.5, -1, 0.5, 1, 1, 1, 1, 1, 0.5],
    *[_EVEN, _ODD] * 11,
    [1, -1, 1, 3, 1, 1],
    [0.5, *[1] * 7, 0.5],
    [1] * 8,
]
"""Courses from the bottom with a door and a window; see :mod:`benchmarks.field.ferris`."""

RADIUS, THICKNESS, ANGLE, VOUSSOIRS = 0.34515, 0.0563, 180.0 * 25 / 27, 25
"""Of the arch [m, degrees]: 27 equal voussoirs, of which the outermost belong to the plate."""

ANGLES = {"portal": (27.30, 30.0), "wall": (16.73, 26.0), "arch": (17.10, 30.0)}
"""Tilt at collapse and friction angle [degrees]."""


def portal() -> Assembly:
    """Two piers of irregular blocks, a lintel, and a wall above it, on a fixed plate."""
    mirrored = [[(WIDTH - x, z) for x, z in reversed(polygon)] for polygon in PIER]
    shapes = [_box(0.0, WIDTH, 0.0, 0.3), *PIER, *mirrored, *ABOVE]
    blocks = [
        prism(polygon, (0.0, DEPTH), f"block-{i:02d}" if i else "ground")
        for i, polygon in enumerate(shapes)
    ]
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


__all__ = [
    "ANGLE",
    "ANGLES",
    "BRICK",
    "COURSE",
    "RADIUS",
    "THICKNESS",
    "VOUSSOIRS",
    "WALL",
    "portal",
]
