"""No proof of falling rests on what touches and was not searched, or is near and was not joined.

Contacts of edges and corners that the search of contacts leaves out are looked for on what falls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.errors import counted
from drystone.checks import mechanism_defects
from drystone.contacts import Contacts, joined_contacts
from drystone.detection import Missed
from drystone.detection.advice import contacts_if_joined, words_on
from drystone.detection.parallel_edges import ParallelEdges
from drystone.mechanics.meeting import approach, further_of, least_friction, near_edges, with_edges
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability.problem import (
    MECHANISM_TOLERANCE,
    part_of_fall,
    withdrawn,
)


def unless_more_holds(
    found: Result,
    check: Callable[[Model], Result],
    falls: Callable[[Model], Result] | None = None,
) -> Result:
    """The result as it is, or that with what touches or is near and may hold what falls.

    Parameters
    ----------
    found
    check
        Gives the verdict on the same model with more contacts, and asks this of it as well.
    falls
        The same where only a verdict of falling is used, and words on what stands are not.
    """
    if found.verdict is not Verdict.UNSTABLE:
        return found
    model, moving = found.model, part_of_fall(found)
    held = _unless_edges_hold(found, moving, check)
    if held is not found:
        return held
    near, meet = _near(model, moving), _corners(model, moving)
    if not near and not len(meet):
        return found
    if model.contacts.dry.all() or not near:
        # what moves although these are held moves without them too
        even_so = (falls or check)(_with_all_held(model, near, meet))
        if even_so.verdict is Verdict.UNSTABLE:
            return replace(even_so, model=model, force_with_props=None)  # of more contacts
    if len(meet):
        return _undecided(found, meet, "corners")
    said = words_on(near, found.assembly.names)
    return withdrawn(found, f"it falls as drawn, and may stand if near blocks touch: {said}")


def _near(model: Model, moving: Bools) -> list[Missed]:
    """The pairs of moving blocks (n,) that are near and were not joined."""
    known = [miss for miss in model.unjoined if moving[[miss.block_a, miss.block_b]].any()]
    return [*known, *near_edges(model, moving)]


def _corners(model: Model, moving: Bools) -> Ints:
    """The pairs (u, 2) of moving blocks (n,) that meet at corners only."""
    further = further_of(model)
    if further is None:
        return np.zeros((0, 2), dtype=np.intp)
    return further.corners[moving[further.corners].any(axis=1)]


def _with_all_held(model: Model, near: list[Missed], meet: Ints) -> Model:
    """The model whose near pairs touch, and whose corners that meet (u, 2) are held."""
    corners = [Missed.overlap(a, b, 0.0, joined=False) for a, b in meet.tolist()]
    friction = model.contacts.friction
    most = float(friction.max()) if len(friction) else 1.0  # none is known: more than stone has
    more = contacts_if_joined([*near, *corners], model.assembly.bounds, most)
    contacts = joined_contacts(model.contacts, more)
    return replace(model, contacts=contacts, unjoined=(), report=None if near else model.report)


def _unless_edges_hold(found: Result, moving: Bools, check: Callable[[Model], Result]) -> Result:
    """The result as it is, or that with the edges and corners that touch and may hold what falls.

    Parallel edges that meet press along a normal that may have a range of directions. They hold
    where they hold with the middle one and with both ends; where they do not hold with each of
    them, nobody knows. Edges that pass each other along a face, as those of a block that slides out
    of a wall, do not press.

    Parameters
    ----------
    found
    moving : (n,)
        The blocks that fall.
    check
        Gives the verdict on the same model with more contacts.
    """
    model = found.model
    further = further_of(model)
    if further is None:
        return found
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
        for end in (turned, -turned):
            if middle.verdict is Verdict.UNSTABLE and _moves(
                model, edges.contacts(end, friction), middle.mechanism
            ):
                continue
            if pressed(end).verdict is not middle.verdict:
                pairs = np.stack([edges.block_a, edges.block_b], axis=1)
                return _undecided(found, pairs, "parallel edges")
        return middle
    return found


def may_touch_more(model: Model, parts: bool = False) -> bool:
    """Whether pairs of blocks, or their edges, are near, or touch and are no contacts.

    ``parts``: also where other blocks are gone.
    """
    found = further_of(model, parts)
    touch = found and (len(found.contacts) or len(found.parallel) or len(found.corners))
    return bool(model.unjoined or touch or near_edges(model, np.ones(len(model), dtype=bool)))


def _with_lines(found: Result, more: Contacts, moving: Bools) -> Model | None:
    """The model with those of moving blocks (n,), where they may hold what falls."""
    some = moving[more.block_a] | moving[more.block_b]
    if not some.any():
        return None
    more = more.select(some)
    model = found.model
    more = more.with_friction(least_friction(model, more))
    return None if _moves(model, more, found.mechanism) else with_edges(model, more)


def _moves(model: Model, more: Contacts, motion: Floats | None) -> bool:
    """Whether a motion (n, 6) of the blocks is free beside some contacts."""
    free = motion is not None and mechanism_defects(model.with_contacts(more), motion)
    return bool(free and free[0] <= MECHANISM_TOLERANCE)


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
