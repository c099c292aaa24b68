"""The shelf of Kao 2023, section 6.3: ten slanted pieces in a frame, and three changes.

Sections (x, z) [m] in a vertical plane, extruded along y. Source of the figures: Kao, Iannuzzo,
Thomaszewski, Coros, Van Mele, Block 2022, "Coupled Rigid-Block Analysis", Computer-Aided Design
146; Kao 2023, doctoral dissertation, ETH Zurich, figure 6.18; the public samples of compas_cra.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.solids import prism, require, welded

Point2 = tuple[float, float]

DEPTH = (0.0, 0.2)
"""[m], from y to y."""

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
"""Blocks 1 to 10, corners (x, z) [m], rounded to a micrometre."""

FIXES: dict[int, dict[int, list[Point2]]] = {
    1: {
        11: [(-0.0307, 0.28174), (0.012961, 0.243654), (0.446621, 0.503547), (0.439186, 0.545962)],
    },
    2: {
        9: [
            (0.381899, 0.872753), (0.503441, 0.179418), (0.582957, 0.267159),
            (0.419334, 0.872753), (0.393648, 0.894588),
        ],
    },
    3: {
        5: [
            (0.503441, 0.179418), (0.118158, -0.245721), (0.260081, -0.285274),
            (0.888724, 0.535643), (0.888724, 0.604556), (0.582957, 0.267159), (0.549861, 0.15667),
        ],
        9: [
            (0.419334, 0.872753), (0.381899, 0.872753), (0.503441, 0.179418),
            (0.549861, 0.15667), (0.582957, 0.267159),
        ],
    },
}  # fmt: skip
"""Blocks that each fix adds or changes: a strut against block 9; block 9 with a tip in a notch of
the lid; block 9 with a foot in a notch of block 5."""


def shelf(fix: Literal[1, 2, 3] | None = None) -> Assembly:
    """A shelf of ten slanted pieces in a fixed frame; at a friction of 0.9 two of them fall.

    Blocks 9 and 10 are between a slanted piece and the top of the frame. Forces that would balance
    them exist, but only as prestress. The other eight stand without them.

    Parameters
    ----------
    fix
        One of the source's three changes, each of which holds block 9; block 10 still falls.

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
    require(fix in (None, *FIXES), f"there is no fix {fix}", "1, 2, 3 or none")
    sections = dict(enumerate(SHELF_BLOCKS, 1))
    if fix is not None:
        sections |= FIXES[fix]
    pieces = [prism(section, DEPTH, f"block-{i}") for i, section in sections.items()]
    if fix is None:
        blocks: list[Block] = [_frame(), *pieces]
    else:
        blocks = [_open_frame(), *pieces, prism(_lid(fix), DEPTH, "lid")]
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


def _frame() -> Block:
    """The frame as one ring."""
    loops: list[Floats] = []
    for i in range(4):
        j = (i + 1) % 4
        ring = [SHELF_OUTER[i], SHELF_OUTER[j], SHELF_INNER[j], SHELF_INNER[i]]
        loops += [np.array([(x, at, z) for x, z in ring]) for at in DEPTH]
        for (x0, z0), (x1, z1) in ((ring[0], ring[1]), (ring[2], ring[3])):
            near, far = DEPTH
            loops.append(np.array([(x0, near, z0), (x1, near, z1), (x1, far, z1), (x0, far, z0)]))
    return welded(loops, "frame")


def _open_frame() -> Block:
    """The frame without its top, whose ends are mitred."""
    low_left, high_left, high_right, low_right = range(4)
    order = (high_left, low_left, low_right, high_right)
    outline = [SHELF_OUTER[i] for i in order] + [SHELF_INNER[i] for i in reversed(order)]
    return prism(outline, DEPTH, "frame")


def _lid(fix: int) -> list[Point2]:
    """The top of the frame; the second fix cuts a notch into it."""
    (left, right), outer = SHELF_INNER[1:3], SHELF_OUTER[1:3]
    notch = [(0.381899, 0.872753), (0.393648, 0.894588), (0.419334, 0.872753)] if fix == 2 else []
    return [left, *notch, right, outer[1], outer[0]]
