"""Structures of the literature as prisms along y: the bridge, the shelf and the snake.

Source of the figures: Kao, Iannuzzo, Thomaszewski, Coros, Van Mele, Block 2022, "Coupled
Rigid-Block Analysis", Computer-Aided Design 146; Kao 2023, doctoral dissertation, ETH Zurich; the
public samples of compas_cra (Block Research Group).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.solids import prism, require, sections, welded


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
    require(fix in (None, 1, 2, 3), f"there is no fix {fix}", "1, 2, 3 or none")
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
