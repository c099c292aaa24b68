"""No proof of falling rests on a pair of blocks that is near and was not joined."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from drystone.contacts import joined_contacts
from drystone.detection.unjoined import contacts_if_joined, words_on
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability.proofs import part_of_fall, withdrawn


def unless_near_pairs_hold(found: Result, check: Callable[[Model], Result]) -> Result:
    """The result as it is, or UNDECIDED where blocks fall only because near pairs do not touch.

    Parameters
    ----------
    found
    check
        Gives the verdict on the same model whose near pairs touch. Where it falls even so, that is
        the proof: what moves without them moves with fewer contacts too.
    """
    if found.verdict is not Verdict.UNSTABLE or not found.model.unjoined:
        return found
    model, names = found.model, found.assembly.names
    moving = part_of_fall(found)
    near = [m for m in model.unjoined if moving[m.block_a] or moving[m.block_b]]
    if not near:
        return found
    most = float(model.contacts.friction.max(initial=1.0))  # none may be known: more than stone has
    more = contacts_if_joined(near, model.assembly.bounds, most)
    if model.contacts.dry.all():
        touching = replace(
            model, contacts=joined_contacts(model.contacts, more), unjoined=(), report=None
        )
        even_so = check(touching)
        if even_so.verdict is Verdict.UNSTABLE:
            return replace(even_so, model=model, force_with_props=None)  # of more contacts
    said = f"it falls as drawn, and may stand if near blocks touch: {words_on(near, names)}"
    return withdrawn(found, said)
