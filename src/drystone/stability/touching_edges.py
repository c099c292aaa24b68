"""No proof of falling rests on edges and corners that touch and were not searched.

Contacts of edges and corners that the search of contacts leaves out are looked for on what falls.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.errors import counted
from drystone.checks import mechanism_defects
from drystone.contacts import Contacts
from drystone.detection.parallel_edges import ParallelEdges
from drystone.geometry.frames import frames_from_normals
from drystone.mechanics.meeting import least_friction
from drystone.mechanics.touching import approach, further_of, near_edges, with_edges
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability.proofs import MECHANISM_TOLERANCE, part_of_fall, withdrawn


def held_everywhere(pairs: Ints, bounds: Floats, friction: float) -> Contacts:
    """Contacts that hold pairs (u, 2) in every direction where they meet.

    Parameters
    ----------
    pairs
    bounds : (n, 2, 3) [m]
        Lowest and highest corner of each block.
    friction
    """
    both = bounds[pairs]
    middle = 0.5 * (both[:, :, 0].max(axis=1) + both[:, :, 1].min(axis=1))
    count, normal = 6 * len(pairs), np.concatenate([np.eye(3), -np.eye(3)])
    return Contacts(
        np.repeat(pairs[:, 0], 6),
        np.repeat(pairs[:, 1], 6),
        frames_from_normals(np.tile(normal, (len(pairs), 1))),
        np.zeros(count),
        np.full(count, friction),
        np.repeat(middle, 6, axis=0),
        np.arange(count, dtype=np.intp),
    )


def unless_edges_hold(found: Result, check: Callable[[Model], Result]) -> Result:
    """The result as it is, or that with the edges and corners that touch and may hold what falls.

    Parallel edges that meet press along a normal that may have a range of directions. They hold
    where they hold with the middle one and with both ends; where they do not hold with each of
    them, nobody knows. Edges that pass each other along a face, as those of a block that slides out
    of a wall, do not press.

    Parameters
    ----------
    found
    check
        Gives the verdict on the same model with more contacts.
    """
    model = found.model
    further = further_of(model) if found.verdict is Verdict.UNSTABLE else None
    if further is None:
        return found
    moving = part_of_fall(found)
    touching = _with_lines(found, further.contacts, moving)
    if touching is not None:
        return check(touching)
    edges = further.parallel
    edges = edges.take(moving[edges.block_a] | moving[edges.block_b])
    turned = _turned(found, edges)
    if turned is not None:
        straight = np.zeros(len(edges))
        friction = least_friction(model, edges.contacts(straight, straight))

        def pressed(turn: Floats) -> Result:
            """The verdict where the edges press in one direction of their range."""
            return check(with_edges(model, edges.contacts(turn, friction)))

        middle = pressed(straight)
        if middle.verdict is Verdict.UNSTABLE or all(
            pressed(end).verdict is middle.verdict for end in (turned, -turned)
        ):
            return middle
        return _undecided(found, np.stack([edges.block_a, edges.block_b], axis=1), "parallel edges")
    meet = further.corners[moving[further.corners].any(axis=1)]
    if len(meet):
        most = float(model.contacts.friction.max(initial=1.0))
        held = held_everywhere(meet, model.assembly.bounds, most)
        if check(with_edges(model, held)).verdict is not Verdict.UNSTABLE:
            return _undecided(found, meet, "corners")
    return found


def may_touch_more(model: Model) -> bool:
    """Whether pairs of blocks, or their edges, are near, or touch and are no contacts."""
    found = further_of(model)
    touch = found and (len(found.contacts) or len(found.parallel) or len(found.corners))
    return bool(model.unjoined or touch or near_edges(model, np.ones(len(model), dtype=bool)))


def _with_lines(found: Result, more: Contacts, moving: Bools) -> Model | None:
    """The model with those of moving blocks (n,), where they may hold what falls."""
    more = more.select(moving[more.block_a] | moving[more.block_b])
    if not len(more):
        return None
    model, motion = found.model, found.mechanism
    more = more.with_friction(least_friction(model, more))
    free = motion is not None and mechanism_defects(model.with_contacts(more), motion)
    return None if free and free[0] <= MECHANISM_TOLERANCE else with_edges(model, more)


def _undecided(found: Result, pairs: Ints, what: str) -> Result:
    """UNDECIDED: nobody knows in which direction some pairs (u, 2) press."""
    (a, b), names = pairs[0], found.assembly.names
    said = f"{what} of '{names[a]}' and '{names[b]}' meet"
    if len(pairs) > 1:
        said += f", and those of {counted(len(pairs) - 1, 'more pair')}"
    return withdrawn(found, f"it depends on the direction in which edges press: {said}")


def _turned(found: Result, edges: ParallelEdges) -> Floats | None:
    """The end (m,) of the range of each normal to which the edges move; None where they pass."""
    if not len(edges):
        return None
    if found.mechanism is None:
        return np.ones(len(edges))
    closing, turned = approach(found.assembly, edges, found.mechanism)
    return turned if closing.max() > MECHANISM_TOLERANCE else None
