"""Small models of the literature on coupled rigid-block analysis: wedges, H, A, concave.

Coordinates are (x, z) in a vertical plane, extruded along y. Source of all dimensions and of the
results quoted: Kao, Iannuzzo, Thomaszewski, Coros, Van Mele, Block 2022, "Coupled Rigid-Block
Analysis", Computer-Aided Design 146, and Kao 2023, doctoral dissertation, ETH Zurich.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
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


def wedge(kind: Literal["a", "b", "c", "d"], longer: float = 0.0) -> Assembly:
    """A free wedge in a V-shaped groove of two fixed blocks: two joints, published tilt limits.

    Types ``a`` (low) and ``b`` (high) sit in a steep groove, ``c`` (high) and ``d`` (low) in a
    shallow one.

    Parameters
    ----------
    kind
    longer : [m]
        By how much the groove is longer than the wedge at both ends; zero in the source.

    Returns
    -------
    Assembly
        ``left`` and ``right``, fixed, and ``wedge``.
    """
    require(longer >= 0.0, f"the groove is longer by {longer} m", "give 0 or more")
    require(kind in WEDGES, f"there is no wedge of type '{kind}'", f"one of {', '.join(WEDGES)}")
    w, shoulder, top = WEDGES[kind]
    half = [(-2.0, 0.0), (0.0, 0.0), (0.0, 0.5), (-w, shoulder), (-2.0, shoulder)]
    free = [(0.0, 0.5), (w, shoulder), (w, top), (-w, top), (-w, shoulder)]
    y = (-longer, 1.0 + longer)
    blocks = (
        prism(half, y, "left"),
        prism([(-x, z) for x, z in half], y, "right"),
        prism(free, (0.0, 1.0), "wedge"),
    )
    return Assembly(blocks, np.array([True, True, False]))


def h_model() -> Assembly:
    """A block between two fixed vertical walls: it falls, whatever the friction.

    Forces that balance it exist for any friction above zero. But nothing presses it against the
    walls: without prestress these forces do not arise.

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

    It falls, whatever the friction, although forces that balance it exist for friction coefficients
    of tan(30 deg) and more.

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


def concave(length: Literal["short", "long"] = "short") -> Assembly:
    """A plank with wings, hooked into a fixed slab: two concave blocks, seven joints.

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
