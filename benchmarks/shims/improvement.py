"""A state with forces, how friction turns with its slides, and a trust region on these.

:mod:`benchmarks.shims.stiffness_range` steps with them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from benchmarks.shims.compatible import (
    slide_directions,
    unit_wrenches,
    wrenches_along,
)
from drystone.base.arrays import Floats, Ints
from drystone.mechanics.statics import Statics
from drystone.solvers.program import ProgramBuilder, Variable

TURN = 0.02
"""Least permitted change of a slide, relative to the mean slide."""


@dataclass(frozen=True, eq=False)
class CompatibleState:
    """Forces compatible with a motion, and the unbalanced load.

    Attributes
    ----------
    motion : (n, 6) with a largest overlap of 1 at the corners
    force : (k, 3)
    unbalanced
        Euclidean norm of the unbalanced scaled wrenches; 0 is a solution.
    iterations
        Convex programs solved.
    """

    motion: Floats
    force: Floats
    unbalanced: float
    iterations: int


def turned_friction(statics: Statics, moved: Floats, corner: Ints, held: Floats) -> Any:
    """Change of wrenches (6 n, 6 n) by a change of motion, due to the rotation of the slide.

    Parameters
    ----------
    statics
    moved : (k, 3)
        Corner displacements.
    corner : (c,)
    held : (c,)
        Friction force divided by slide.
    """
    direction = slide_directions(moved)[corner]
    zero = np.zeros(len(corner))
    across = np.stack([zero, -direction[:, 1], direction[:, 0]], axis=1)
    freedom, value = wrenches_along(statics, corner, across)
    row, column = np.repeat(freedom, 12, axis=1), np.tile(freedom, 12)
    product = -np.repeat(held[:, None] * value, 12, axis=1) * np.tile(value, 12)
    meets = (row >= 0) & (column >= 0)
    size = 6 * statics.free_count
    return sparse.csr_matrix((product[meets], (row[meets], column[meets])), shape=(size, size))


def add_trust_region(
    program: ProgramBuilder,
    statics: Statics,
    change: Variable,
    corner: Ints,
    slide: Floats,
    trust: float,
) -> None:
    """Rows that bound the change of slides (c,) to a share of them."""
    # a corner that slides little may reverse its slide
    reach = trust * np.maximum(slide, TURN * slide.mean())
    for axis in (1, 2):
        along = unit_wrenches(statics, corner, np.eye(3)[axis]).T
        program.at_most(f"largest slide {axis}", reach, (change, along))
        program.at_most(f"least slide {axis}", reach, (change, -along))
