"""No proof of falling rests on edges and corners that touch and were not searched."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, cross
from drystone.base.display import named
from drystone.base.errors import counted
from drystone.checks import block_speed, mechanism_defects
from drystone.contacts import Contacts, joined_contacts
from drystone.detection import EdgeContacts
from drystone.detection.further import Further, further_contacts, held_everywhere
from drystone.detection.parallel_edges import ParallelEdges
from drystone.mechanics.meeting import least_friction
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability.proofs import MECHANISM_TOLERANCE, part_of_fall, withdrawn


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
    further = _further(model) if found.verdict is Verdict.UNSTABLE else None
    if further is None:
        return found
    moving = part_of_fall(found)

    def of_moving(contacts: Contacts) -> Bools:
        """Those (m,) of a block that moves."""
        chosen: Bools = moving[contacts.block_a] | moving[contacts.block_b]
        return chosen

    lines = further.contacts.select(of_moving(further.contacts))
    lines = lines.with_friction(least_friction(model, lines))
    if _may_hold(found, lines):
        return check(_with(model, lines))
    edges = further.parallel
    edges = edges.take(moving[edges.block_a] | moving[edges.block_b])
    turned = _turned(found, edges)
    if turned is not None:
        straight = np.zeros(len(edges))
        friction = least_friction(model, edges.contacts(straight, straight))

        def pressed(turn: Floats) -> Result:
            """The verdict where the edges press in one direction of their range."""
            return check(_with(model, edges.contacts(turn, friction)))

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
        if check(_with(model, held)).verdict is not Verdict.UNSTABLE:
            return _undecided(found, meet, "corners")
    return found


def may_touch_more(model: Model) -> bool:
    """Whether pairs of blocks are near, or touch with edges and corners that are no contacts."""
    if model.unjoined:
        return True
    found = _further(model)
    if found is None:
        return False
    return bool(len(found.contacts) or len(found.parallel) or len(found.corners))


def _further(model: Model) -> Further | None:
    """What touches with edges and corners that were not searched; None where they were."""
    report = model.report
    if report is None or report.options.edges is not EdgeContacts.ISOLATED:
        return None
    return further_contacts(model.assembly, model.contacts, report.options)


def _may_hold(found: Result, more: Contacts) -> bool:
    """Whether the motion of what falls is none where the blocks touch as well."""
    if not len(more) or found.mechanism is None:
        return len(more) > 0
    touching = found.model.with_contacts(more)
    return mechanism_defects(touching, found.mechanism)[0] > MECHANISM_TOLERANCE


def _turned(found: Result, edges: ParallelEdges) -> Floats | None:
    """The end (m,) of the range of each normal to which the edges move; None where they pass."""
    if not len(edges):
        return None
    if found.mechanism is None:
        return np.ones(len(edges))
    motion, centroid = found.mechanism, found.assembly.centroid
    at_a, at_b = (
        motion[block, None, :3]
        + cross(motion[block, None, 3:], edges.point - centroid[block, None])
        for block in (edges.block_a, edges.block_b)
    )
    opening, turned = edges.approached(at_b - at_a)
    speed = float(block_speed(found.assembly, motion).max(initial=0.0))
    return turned if opening.min() < -MECHANISM_TOLERANCE * speed else None


def _with(model: Model, more: Contacts) -> Model:
    """The model with more contacts, and a note of them."""
    names = model.assembly.names
    pairs = sorted(set(zip(more.block_a.tolist(), more.block_b.tolist(), strict=True)))
    told = named([f"{names[a]}-{names[b]}" for a, b in pairs])
    note = f"edges and corners touch as well, where it would fall without: {told}"
    joined = joined_contacts(model.contacts, more)
    return replace(model, contacts=joined, notes=(*model.notes, note))


def _undecided(found: Result, pairs: Ints, what: str) -> Result:
    """UNDECIDED: nobody knows in which direction some pairs (u, 2) press."""
    (a, b), names = pairs[0], found.assembly.names
    said = f"{what} of '{names[a]}' and '{names[b]}' meet"
    if len(pairs) > 1:
        said += f", and those of {counted(len(pairs) - 1, 'more pair')}"
    return withdrawn(found, f"it depends on the direction in which edges press: {said}")
