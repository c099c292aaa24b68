"""The linear program of forces, on joints of bounded stiffness, that lack least.

Unknowns are the normal force of each corner that presses and its shear, against the slide; a change
of the motion, when it may change; a cohesion, so much shear as every joint carries beyond its
friction, by the load of its lighter block; and the load that is left unbalanced. The last two are
made small together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drystone.arrays import Floats, Ints
from drystone.formulations.compatible import slide_directions
from drystone.formulations.corner_blocks import NORMAL, CornerBlocks
from drystone.formulations.improvement import TURN
from drystone.formulations.rest.compliance import corner_load, wrench_size
from drystone.solvers.conic import Cones, ConicOptions, ConicStatus, solve_conic
from drystone.solvers.triplets import Triplets
from drystone.statics import Statics

DEAR = 3.0
"""What load left unbalanced costs, by its share of a block's load, where cohesion costs 1."""


@dataclass(frozen=True, eq=False)
class Reach:
    """What may change.

    Attributes
    ----------
    force : (k, 3)
        Its friction turns as the slides do.
    trust
        Share of a slide by which it may change.
    """

    force: Floats
    trust: float


@dataclass(frozen=True, eq=False)
class Lacking:
    """The forces that lack least.

    Attributes
    ----------
    change : (n, 6) of the motion; none where it was held
    normal, shear : (c,) of the corners that were chosen
    lack
        Cohesion, and dear for the load that is left.
    """

    change: Floats
    normal: Floats
    shear: Floats
    lack: float


def least_lack(
    statics: Statics,
    moved: Floats,
    corner: Ints,
    spread: float,
    reach: Reach | None = None,
    *,
    tolerance: float = 1e-10,
    stop: Callable[[], bool] | None = None,
) -> Lacking | None:
    """Forces at some corners that lack least, and within reach a change of motion.

    Parameters
    ----------
    statics
    moved : (k, 3)
        Corner displacements, in units in which the softest joint has a stiffness of 1.
    corner : (c,)
        Corners that press, with a force between 1 and ``spread`` times their overlap; the others
        stay open.
    spread
    reach
        Left out, the motion is held.
    tolerance
        Of the program, relative.
    stop

    Returns
    -------
    Lacking
        None if the program fails.
    """
    count, wrenches = len(corner), 6 * statics.free_count
    elsewhere = np.ones(statics.corner_count, dtype=bool)
    elsewhere[corner] = False
    others = np.flatnonzero(elsewhere)
    moves, turns, opens = (0, 0, 0) if reach is None else (wrenches, 4 * count, len(others))
    # unknowns: change of motion, normal forces, shear, cohesion, unbalanced rest up and down
    normal, shear, cohesion = moves, moves + count, moves + 2 * count
    rest = cohesion + 1
    bounds = 4 * count + 1 + 2 * wrenches
    rows = Triplets(wrenches + bounds + turns + opens, rest + 2 * wrenches)
    blocks = CornerBlocks(statics, corner)
    closing = blocks.along(NORMAL)
    direction = slide_directions(moved)[corner]
    along = blocks.along(np.concatenate([np.zeros((count, 1)), direction], axis=1))
    rows.add(blocks.freedom, normal + blocks.local, closing)
    rows.add(blocks.freedom, shear + blocks.local, -along)
    rows.diagonal(0, rest, np.ones(wrenches))
    rows.diagonal(0, rest + wrenches, np.full(wrenches, -1.0))
    # shear is not below zero, nor beyond friction and cohesion; forces agree with overlaps
    every, first = np.arange(count), wrenches
    rows.diagonal(first, shear, np.full(count, -1.0))
    first += count
    rows.diagonal(first, shear, np.ones(count))
    rows.diagonal(first, normal, -statics.friction[corner])
    rows.add(first + every, np.full(count, cohesion), -corner_load(statics)[corner])
    first += count
    rows.diagonal(first, normal, np.full(count, -1.0))
    rows.diagonal(first + count, normal, np.ones(count))
    overlap = np.maximum(-moved[corner, 0], 0.0)
    right = [-statics.load.ravel(), np.zeros(2 * count), -overlap, spread * overlap]
    right.append(np.zeros(1 + 2 * wrenches))
    rows.diagonal(first + 2 * count, cohesion, np.full(1 + 2 * wrenches, -1.0))
    if reach is not None:
        rows.add(first + blocks.local, blocks.freedom, -closing)
        rows.add(first + count + blocks.local, blocks.freedom, spread * closing)
        first += 2 * count + 1 + 2 * wrenches
        # turning the slide of a corner turns its friction
        slide = np.linalg.norm(moved[corner, 1:], axis=1) + 1e-12
        across = np.stack([np.zeros(count), -direction[:, 1], direction[:, 0]], axis=1)
        sideways = blocks.along(across)
        held = np.linalg.norm(reach.force[corner, 1:], axis=1) / slide
        rows.add(*blocks.crossed(-sideways * held[blocks.local], sideways))
        # a corner that hardly slides may turn its slide round
        right.append(np.tile(reach.trust * np.maximum(slide, TURN * slide.mean()), 4))
        for axis in (1, 2):
            values = blocks.along(np.eye(3)[axis])
            for sign in (1.0, -1.0):
                rows.add(first + blocks.local, blocks.freedom, sign * values)
                first += count
        opening = CornerBlocks(statics, others)
        rows.add(first + opening.local, opening.freedom, -opening.along(NORMAL))
        right.append(np.maximum(moved[others, 0], 0.0))
    load = wrench_size(statics.load)
    dear = np.repeat(DEAR / np.where(load > 0.0, load, 1.0), 6)
    cost = np.concatenate([np.zeros(cohesion), [1.0], dear, dear])
    solution = solve_conic(
        np.concatenate(
            [np.full(moves, 1e-10), np.full(2 * count, 1e-10), np.zeros(1 + 2 * wrenches)]
        ),
        cost,
        rows.csc(),
        np.concatenate(right),
        Cones(zero=wrenches, nonnegative=bounds + turns + opens),
        ConicOptions(tolerance=tolerance),
        stop=stop,
    )
    if solution.status is not ConicStatus.SOLVED:
        return None
    x = solution.x
    return Lacking(x[:moves].reshape(-1, 6), x[normal:shear], x[shear:cohesion], float(cost @ x))
