"""Small models of the literature on coupled rigid-block analysis: wedges, H, A, shelf, concave.

Coordinates are (x, z) in a vertical plane, extruded along y. Source of all dimensions and of the
results quoted: Kao, Iannuzzo, Thomaszewski, Coros, Van Mele, Block 2022, "Coupled Rigid-Block
Analysis", Computer-Aided Design 146, and Kao 2023, doctoral dissertation, ETH Zurich.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.geometry.arrays import Floats
from drystone.models.solids import prism, rectangle, require, welded

Point2 = tuple[float, float]

WEDGES: dict[str, tuple[float, float, float]] = {
    "a": (0.6, 1.5392304845413263, 1.6),
    "b": (0.6, 1.5392304845413263, 2.8),
    "c": (1.0, 1.0773502691896257, 2.3381),
    "d": (1.0, 1.0773502691896257, 1.1381),
}
"""Half width and height of the shoulders, and height of the top [m]: grooves of 60 and 30 degrees
to the horizontal, each with a low and a high wedge."""


def wedge(kind: Literal["a", "b", "c", "d"]) -> Assembly:
    """A free wedge in a V-shaped groove of two fixed blocks: two joints, published tilt limits.

    Types ``a`` (low) and ``b`` (high) sit in a steep groove, ``c`` (high) and ``d`` (low) in a
    shallow one.

    Returns
    -------
    Assembly
        ``left`` and ``right``, fixed, and ``wedge``.
    """
    require(kind in WEDGES, f"there is no wedge of type '{kind}'", f"one of {', '.join(WEDGES)}")
    w, shoulder, top = WEDGES[kind]
    half = [(-2.0, 0.0), (0.0, 0.0), (0.0, 0.5), (-w, shoulder), (-2.0, shoulder)]
    free = [(0.0, 0.5), (w, shoulder), (w, top), (-w, top), (-w, shoulder)]
    y = (0.0, 1.0)
    blocks = (
        prism(half, y, "left"),
        prism([(-x, z) for x, z in half], y, "right"),
        prism(free, y, "wedge"),
    )
    return Assembly(blocks, np.array([True, True, False]))


def h_model() -> Assembly:
    """A block between two fixed vertical walls: it falls, whatever the friction.

    Forces that balance it exist for any friction above zero (the walls can squeeze), but nothing
    presses it against the walls, so they cannot arise without prestress.

    Returns
    -------
    Assembly
        ``left`` and ``right``, fixed, and ``block``.
    """
    y = (-0.5, 0.5)
    wall = [(0.9, -1.0), (1.1, -1.0), (1.1, 1.4), (0.9, 1.4)]
    blocks = (
        prism([(-x, z) for x, z in wall], y, "left"),
        prism(wall, y, "right"),
        prism([(-0.9, -0.2), (0.9, -0.2), (0.9, 0.6), (-0.9, 0.6)], y, "block"),
    )
    return Assembly(blocks, np.array([True, True, False]))


def a_model() -> Assembly:
    """A block that widens downwards between two fixed walls leaning inwards at 60 degrees.

    It falls, whatever the friction, although balancing forces exist from a friction coefficient of
    tan(30 deg) on, where a wall can push upwards.

    Returns
    -------
    Assembly
        ``left`` and ``right``, fixed, and ``block``.
    """
    y = (-0.5, 0.5)
    foot, head = (1.154701, -0.2), (0.69282, 0.6)
    slope = np.array(foot) - np.array(head)
    outward = 0.2 * np.array([-slope[1], slope[0]]) / np.linalg.norm(slope)
    wall = [foot, head, (head[0] + outward[0], head[1] + outward[1]),
            (foot[0] + outward[0], foot[1] + outward[1])]  # fmt: skip
    mirror = [(-x, z) for x, z in (head, foot)]
    blocks = (
        prism([(-x, z) for x, z in wall], y, "left"),
        prism(wall, y, "right"),
        prism([foot, head, *mirror], y, "block"),
    )
    return Assembly(blocks, np.array([True, True, False]))


SHELF_INNER: list[Point2] = [
    (-0.868882, -0.87345),
    (-0.868882, 0.872753),
    (0.888724, 0.872753),
    (0.888724, -0.87345),
]
SHELF_OUTER: list[Point2] = [(-1.0, -1.0), (-1.0, 1.0), (1.02, 1.0), (1.02, -1.0)]
SHELF_BLOCKS: list[list[Point2]] = [
    [
        (0.888724, -0.87345),
        (0.888724, -0.661407),
        (0.37335, -0.31684),
        (0.24233, -0.433398),
        (0.681333, -0.87345),
    ],
    [
        (-0.486807, -0.309234),
        (-0.621771, -0.329051),
        (-0.744577, -0.87345),
        (-0.694381, -0.87345),
    ],
    [
        (0.24233, -0.433398),
        (0.37335, -0.31684),
        (-0.197525, -0.157744),
        (-0.260482, -0.276003),
    ],
    [
        (-0.868882, -0.365335),
        (-0.260482, -0.276003),
        (-0.197525, -0.157744),
        (-0.868882, -0.286212),
    ],
    [(0.888724, 0.604556), (0.118158, -0.245721), (0.260081, -0.285274), (0.888724, 0.535643)],
    [(-0.868882, 0.55351), (-0.868882, 0.459924), (-0.417475, -0.199833), (-0.281918, -0.173893)],
    [(-0.317294, 0.476387), (0.232698, -0.119334), (0.319403, -0.023659), (-0.29348, 0.510968)],
    [(-0.044342, 0.872753), (-0.079224, 0.872753), (-0.61238, 0.235636), (-0.542618, 0.149183)],
    [(0.381899, 0.872753), (0.503441, 0.179418), (0.582957, 0.267159), (0.419334, 0.872753)],
    [
        (-0.24924, 0.872753),
        (-0.274876, 0.872753),
        (-0.284267, 0.627729),
        (-0.243736, 0.676163),
    ],
]
"""Blocks 1 to 10, corners (x, z) [m]; given to a micrometre, and they touch to that."""


def shelf() -> Assembly:
    """A shelf of ten slanted pieces in a fixed frame; at a friction of 0.9 two of them fall.

    Blocks 9 and 10 are pinched between a slanted piece and the top of the frame: forces that would
    balance them exist, but nothing presses them into being. The other eight stand without them.

    Returns
    -------
    Assembly
        ``frame``, fixed, then ``block-1`` to ``block-10``: their numbers are their positions.
    """
    y = (0.0, 0.2)
    loops: list[Floats] = []
    for i in range(4):
        j = (i + 1) % 4
        ring = [SHELF_OUTER[i], SHELF_OUTER[j], SHELF_INNER[j], SHELF_INNER[i]]
        loops += [np.array([(x, at, z) for x, z in ring]) for at in y]
        for (x0, z0), (x1, z1) in ((ring[0], ring[1]), (ring[2], ring[3])):
            loops.append(np.array([(x0, y[0], z0), (x1, y[0], z1), (x1, y[1], z1), (x0, y[1], z0)]))
    blocks: list[Block] = [welded(loops, "frame")]
    blocks += [prism(section, y, f"block-{i}") for i, section in enumerate(SHELF_BLOCKS, 1)]
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


def concave(length: Literal["short", "long"] = "short") -> Assembly:
    """A plank with wings that hooks into a fixed slab: two concave blocks, seven joints.

    The plank passes under the slab and cantilevers beyond it, to x = 1 (``short``) or 2 (``long``).
    Published limits about the slab's edge for a friction of 0.84: 40 degrees (short, about +y) and
    54 (long, about +x+y); 5 and 9 for 0.10.

    Returns
    -------
    Assembly
        ``slab``, fixed, and ``plank``.
    """
    require(length in ("short", "long"), f"no plank is '{length}'", "short or long")
    slab = welded(_slab_faces(), "slab")
    plank = welded(_plank_faces(1.0 if length == "short" else 2.0), "plank")
    return Assembly((slab, plank), np.array([True, False]))


def _loop(axis: int, at: float, plane: Sequence[Point2]) -> Floats:
    return np.insert(np.array(plane), axis, at, axis=1)


def _slab_faces() -> list[Floats]:
    under = [(-1.5, -0.5), (0.1, -0.5), (0.1, -0.3), (-0.8, -0.3),
             (-0.8, 0.3), (0.1, 0.3), (0.1, 0.5), (-1.5, 0.5)]  # fmt: skip
    flank = [(-1.5, 0.0), (0.1, 0.0), (0.1, 0.1), (-0.5, 0.1), (-0.5, 0.2), (-1.5, 0.2)]
    loops = [
        _loop(2, 0.0, under),
        rectangle(2, 0.2, (-1.5, -0.5), (-0.5, 0.5)),
        rectangle(2, 0.1, (-0.8, -0.5), (-0.3, 0.3)),
        rectangle(0, -1.5, (-0.5, 0.5), (0.0, 0.2)),
        rectangle(0, -0.8, (-0.3, 0.3), (0.0, 0.1)),
        _loop(0, -0.5, [(-0.5, 0.1), (-0.3, 0.1), (0.3, 0.1), (0.5, 0.1), (0.5, 0.2), (-0.5, 0.2)]),
    ]
    for side in (-1.0, 1.0):
        bar = (0.3 * side, 0.5 * side)
        loops += [
            _loop(1, 0.5 * side, flank),
            _loop(1, 0.3 * side, [(-0.8, 0.0), (0.1, 0.0), (0.1, 0.1), (-0.5, 0.1), (-0.8, 0.1)]),
            rectangle(2, 0.1, (-0.5, 0.1), bar),
            rectangle(0, 0.1, bar, (0.0, 0.1)),
        ]
    return loops


def _plank_faces(end: float) -> list[Floats]:
    wing = [(-0.5, 0.1), (-0.3, 0.1), (0.3, 0.1), (0.5, 0.1), (0.5, 0.2), (-0.5, 0.2)]
    edge = [(-0.8, 0.0), (end, 0.0), (end, 0.1), (0.1, 0.1), (-0.5, 0.1), (-0.8, 0.1)]
    loops = [
        rectangle(2, 0.0, (-0.8, end), (-0.3, 0.3)),
        rectangle(2, 0.1, (-0.8, -0.5), (-0.3, 0.3)),
        rectangle(2, 0.1, (0.1, end), (-0.3, 0.3)),
        rectangle(2, 0.2, (-0.5, 0.1), (-0.5, 0.5)),
        rectangle(0, -0.8, (-0.3, 0.3), (0.0, 0.1)),
        rectangle(0, end, (-0.3, 0.3), (0.0, 0.1)),
        _loop(0, -0.5, wing),
        _loop(0, 0.1, wing),
    ]
    for side in (-1.0, 1.0):
        loops += [
            _loop(1, 0.3 * side, edge),
            rectangle(2, 0.1, (-0.5, 0.1), (0.3 * side, 0.5 * side)),
            rectangle(1, 0.5 * side, (-0.5, 0.1), (0.1, 0.2)),
        ]
    return loops


__all__ = ["a_model", "concave", "h_model", "shelf", "wedge"]
