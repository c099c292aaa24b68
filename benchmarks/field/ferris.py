"""The walls of Ferris and Tin-Loi 2001: bricks of 0.4 x 0.175 m, with openings.

Source: International Journal of Mechanical Sciences 43, 209-224. Friction 0.65; every block is
pushed along x in proportion to its weight; the wall stands on a fixed block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drystone import Assembly, models

LENGTH, DEPTH, HEIGHT = 0.4, 0.2, 0.175
"""[m] of a brick; the depth, which does not matter, is ours."""


@dataclass(frozen=True)
class Wall:
    """Courses from the bottom, and limits of the horizontal load by the weight.

    Attributes
    ----------
    rows
        Lengths in bricks from left to right; negative is an opening.
    associated
        No forces balance more.
    non_associated
        The least with which it can fall, where one is quoted.
    """

    rows: Sequence[Sequence[float]]
    associated: float
    non_associated: float | None


WALLS = {
    1: Wall(
        [
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
        ],
        0.64286,
        0.63982,
    ),
    2: Wall(
        [
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
        ],
        0.58,
        0.56262,
    ),
    3: Wall(
        [
            [1, 1, 1, 1],
            [0.5, 1, 1, 1, 0.5],
            [1, 1, 1, 1],
            [0.5, 1, -1, 1, 0.5],
            [1, 0.5, -1, 0.5, 1],
            [0.5, 1, -1, 1, 0.5],
            [1, 0.5, -1, 0.5, 1],
            [0.5, 1, -1, 1, 0.5],
            [1, 1, 1, 1],
            [0.5, 1, 1, 1, 0.5],
            [1, 1, 1, 1],
        ],
        0.40369,
        0.35582,
    ),
    4: Wall(
        [
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
            [1, -1, 1, -1, 1],
            [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5],
            [1, -1, 1, -1, 1],
            [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5],
            [1, -1, 1, -1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 0.5],
        ],
        0.33195,
        0.29643,
    ),
    5: Wall(
        [
            [0.5, 1, 1, 0.5],
            [1, 1, 1],
            [0.5, 1, 1, 0.5],
            [1, -1, 1],
            [0.5, 0.5, -1, 0.5, 0.5],
            [1, -1, 1],
            [0.5, 0.5, -1, 0.5, 0.5],
            [1, -1, 1],
            [0.5, 1, 1, 0.5],
            [1, 1, 1],
            [0.5, 1, 1, 0.5],
            [1, -1, 1],
            [0.5, 0.5, -1, 0.5, 0.5],
            [1, -1, 1],
            [0.5, 0.5, -1, 0.5, 0.5],
            [1, -1, 1],
            [0.5, 1, 1, 0.5],
            [1, 1, 1],
            [0.5, 1, 1, 0.5],
        ],
        0.23964,
        0.21488,
    ),
    6: Wall(
        [
            [0.5, 1, 1, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1, 1, 1],
            [0.5, 1, -1, 1, 1, -1, 1, 0.5],
            [1, 0.5, -1, 0.5, 1, 0.5, -1, 0.5, 1],
            [0.5, 1, -1, 1, 1, -1, 1, 0.5],
            [1, 0.5, -1, 0.5, 1, 0.5, -1, 0.5, 1],
            [0.5, 1, -1, 1, 1, -1, 1, 0.5],
            [1, 1, 1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1, 1, 1],
            [0.5, 1, -1, 1, 1, -1, 1, 0.5],
            [1, 0.5, -1, 0.5, 1, 0.5, -1, 0.5, 1],
            [0.5, 1, -1, 1, 1, -1, 1, 0.5],
            [1, 0.5, -1, 0.5, 1, 0.5, -1, 0.5, 1],
            [0.5, 1, -1, 1, 1, -1, 1, 0.5],
            [1, 1, 1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 1, 1, 0.5],
            [1, 1, 1, 1, 1, 1, 1],
            [0.5, 1, 1, 1, 1, 1, 1, 0.5],
        ],
        0.34783,
        None,
    ),
}


def wall_of_rows(
    rows: Sequence[Sequence[float]], length: float = LENGTH, height: float = HEIGHT
) -> Assembly:
    """The wall of bricks of a length and a height [m] on a fixed block, which is as long as it."""
    total = sum(abs(part) for part in rows[0]) * length
    ground = models.box((total, DEPTH, height), (0.0, 0.0, -height), "ground")
    blocks = [ground]
    for course, row in enumerate(rows):
        x = 0.0
        for place, part in enumerate(row):
            size = abs(part) * length
            if part > 0.0:
                name = f"c{course:02d}-b{place:02d}"
                corner = (x, 0.0, course * height)
                blocks.append(models.box((size, DEPTH, height), corner, name))
            x += size
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


__all__ = ["WALLS", "Wall", "wall_of_rows"]
