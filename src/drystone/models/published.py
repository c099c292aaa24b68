"""Structures of the literature on coupled rigid-block analysis: prisms, wedges, H, A, concave.

Coordinates are (x, z) in a vertical plane, extruded along y. Source of all dimensions and of the
results quoted: Kao, Iannuzzo, Thomaszewski, Coros, Van Mele, Block 2022, "Coupled Rigid-Block
Analysis", Computer-Aided Design 146, and Kao 2023, doctoral dissertation, ETH Zurich.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.simple import of_boxes, prism, sections, welded


def bridge(*, load: bool = False) -> Assembly:
    """A bridge of nine blocks between two abutments, which is built without centring.

    Under self-weight alone every block can be placed without help at a friction coefficient of
    0.35, and none at 0.34 (Kao 2023, section 7.2.4). The left half mirrors the right one. The
    openings in its abutments are left out: the abutments are fixed.

    Parameters
    ----------
    load
        Whether five boxes stand on the deck, 3.51 times as dense as the bridge (figure 7.4).

    Returns
    -------
    Assembly
        ``abutment-0`` and ``abutment-1``, fixed, ``block-2`` to ``block-10``, of which 8 is the
        keystone, and ``load-11`` to ``load-15``: their numbers are their positions.

    Examples
    --------
    >>> assembly = bridge()
    >>> len(assembly), assembly.names[8]
    (11, 'block-8')
    """
    given = sections("bridge")
    span, deck = (0.0, given["depth"]), given["deck"]
    made: dict[int, Block] = {8: prism(given["keystone"], span, "block-8")}
    for key, corners in given["right"].items():
        number = int(key)
        kind = "block" if number else "abutment"
        made[number] = prism(corners, span, f"{kind}-{number}")
        made[number + 1] = prism([(-x, z) for x, z in corners], span, f"{kind}-{number + 1}")
    for key, (left, right, top) in given["load"].items() if load else ():
        corner = np.array([(left, deck), (right, deck), (right, top), (left, top)])
        for number, side in ((int(key), 1.0), (26 - int(key), -1.0)):
            density = given["load-density"] * DEFAULT_DENSITY
            made[number] = prism(corner * (side, 1.0), span, f"load-{number}", density)
    blocks = tuple(made[number] for number in sorted(made))
    return Assembly(blocks, np.arange(len(blocks)) < 2)


def shelf(fix: Literal[1, 2, 3] | None = None) -> Assembly:
    """A shelf of ten slanted pieces in a fixed frame; at a friction of 0.9 two of them fall.

    Blocks 9 and 10 are between a slanted piece and the top of the frame. Forces that would balance
    them exist, but only as prestress. The other eight stand without them (Kao 2023, section 6.3).

    Parameters
    ----------
    fix
        One of the source's three changes (figure 6.18), each of which holds block 9; block 10
        still falls. They are a strut against block 9; block 9 with a tip in a notch of the lid;
        block 9 with a foot in a notch of block 5.

    Returns
    -------
    Assembly
        ``frame``, fixed, then ``block-1`` to ``block-10``: their numbers are their positions. With
        the first fix ``block-11``, a strut. With a fix the top of the frame is a free ``lid``.

    Examples
    --------
    >>> shelf(1).names[-2:]
    ('block-11', 'lid')
    """
    given = sections("shelf")
    parts = given["blocks"] | given["fixes"].get(str(fix), {})
    depth = given["depth"]
    pieces = [prism(section, depth, f"block-{i}") for i, section in parts.items()]
    inner, outer = given["inner"], given["outer"]
    if fix is None:
        blocks: list[Block] = [_ring(inner, outer, depth), *pieces]
    else:
        around = [1, 0, 3, 2]  # without its top, whose ends are mitred
        outline = [*(outer[i] for i in around), *(inner[i] for i in around[::-1])]
        # the tip of the second fix is in a notch of the lid
        notch = [parts["9"][i] for i in (0, -1, -2)] if fix == 2 else []
        lid = [inner[1], *notch, inner[2], outer[2], outer[1]]
        blocks = [prism(outline, depth, "frame"), *pieces, prism(lid, depth, "lid")]
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


def _ring(inner: list[list[float]], outer: list[list[float]], depth: list[float]) -> Block:
    """The frame of the shelf as one ring, from its corners."""
    loops: list[Floats] = []
    for i in range(4):
        j = (i + 1) % 4
        ring = [outer[i], outer[j], inner[j], inner[i]]
        loops += [np.array([(x, at, z) for x, z in ring]) for at in depth]
        for (x0, z0), (x1, z1) in ((ring[0], ring[1]), (ring[2], ring[3])):
            near, far = depth
            loops.append(np.array([(x0, near, z0), (x1, near, z1), (x1, far, z1), (x0, far, z0)]))
    return welded(loops, "frame")


def snake() -> Assembly:
    """The snake: each block leans over the one below and is hooked behind its end.

    It stands for friction coefficients of 0.6 and more (0.7 in the source; Kao 2023, section 7.2).

    Returns
    -------
    Assembly
        ``foot``, fixed, and ``block-1`` to ``block-3``, 1 m deep.

    Examples
    --------
    >>> snake().names
    ('foot', 'block-1', 'block-2', 'block-3')
    """
    names = ("foot", "block-1", "block-2", "block-3")
    pairs = zip(names, sections("snake"), strict=True)
    made = [prism(section, (0.0, 1.0), name) for name, section in pairs]
    return Assembly(tuple(made), np.arange(len(made)) == 0)


WEDGES: dict[str, tuple[float, float, float]] = {
    "a": (0.6, 1.5392304845413263, 1.6),
    "b": (0.6, 1.5392304845413263, 2.8),
    "c": (1.0, 1.0773502691896257, 2.3381),
    "d": (1.0, 1.0773502691896257, 1.1381),
}
"""Half width and height of the shoulders, and height of the top [m]: grooves of 60 and 30 degrees
to the horizontal, each with a low and a high wedge."""


def wedge(kind: Literal["a", "b", "c", "d"] = "a", longer: float = 0.0) -> Assembly:
    """A free wedge in a V-shaped groove of two fixed blocks: two joints, published tilt limits.

    Types ``a`` (low) and ``b`` (high) sit in a steep groove, ``c`` (high) and ``d`` (low) in a
    shallow one.

    Parameters
    ----------
    kind
    longer : [m] >= 0
        By how much the groove is longer than the wedge at both ends; zero in the source.

    Returns
    -------
    Assembly
        ``left`` and ``right``, fixed, and ``wedge``.
    """
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

    Parameters
    ----------
    length
        Of the plank.

    Returns
    -------
    Assembly
        ``slab``, fixed, and ``plank``.
    """
    end = 1.0 if length == "short" else 2.0
    slab = of_boxes(
        "slab", ((-1.5, -0.5, 0.0), (-0.8, 0.5, 0.2)), ((-0.8, -0.3, 0.1), (-0.5, 0.3, 0.2)),
        ((-0.8, -0.5, 0.0), (-0.5, -0.3, 0.2)), ((-0.5, -0.5, 0.0), (0.1, -0.3, 0.1)),
        ((-0.8, 0.3, 0.0), (-0.5, 0.5, 0.2)), ((-0.5, 0.3, 0.0), (0.1, 0.5, 0.1)),
    )  # fmt: skip
    wings = ((-0.5, -0.5, 0.1), (0.1, 0.5, 0.2))
    plank = of_boxes("plank", ((-0.8, -0.3, 0.0), (end, 0.3, 0.1)), wings)
    return Assembly((slab, plank), np.array([True, False]))
