"""The outcome of the runs of one model, and the sentence about it."""

from __future__ import annotations

import numpy as np

from drystone.base.progress import Clock
from drystone.detection.advice import rounded_up
from drystone.detection.reasons import millimetres
from drystone.mechanics.corners import Carrier
from drystone.settlement.settlement_types import Outcome, SettlementPath

TOLD = 3
"""Pairs of blocks that met meanwhile and are named in the message."""


def outcome_of(paths: tuple[SettlementPath, ...], clock: Clock) -> tuple[Outcome, str]:
    """The outcome of all paths, and a sentence."""
    first = paths[0]
    for one in paths:
        if one.outcome is Outcome.UNKNOWN:
            why = f"not at rest, {one.share:.1e} of the load is not carried"
            if one.residuals is not None:
                left = one.residuals.largest
                why = f"at rest but for a block that is left with {left:.1e} of what it feels"
            why = clock.reason or why
            return Outcome.UNKNOWN, f"{why} after {one.steps} steps"
    stands = [one.outcome is Outcome.RESTS for one in paths]
    if any(stands) and not all(stands):
        said = "; ".join(f"carried by the {one.carrier.value} block, {_said(one)}" for one in paths)
        longer = _said_longer(paths[stands.index(True)])
        return Outcome.ENDS_DECIDE, f"the ends of the joints decide: {said}{longer}"
    # of two that rest, the one that settles more; of two that do not, the one that falls
    worst = max(paths, key=lambda one: (one.outcome is Outcome.FALLS, one.travel.max(initial=0.0)))
    chosen = worst if worst.outcome is not first.outcome else first
    return chosen.outcome, _said(chosen)


def _said(path: SettlementPath) -> str:
    travel = float(path.travel.max(initial=0.0))
    if path.outcome is Outcome.FALLS:
        name = path.model.assembly.names[int(np.argmax(path.travel))]
        return f"it falls: '{name}' has moved by {travel:.2f} of its size and still moves"
    moved = float(np.linalg.norm(path.displacement[:, :3], axis=1).max(initial=0.0))
    if path.displacement[path.model.assembly.fixed].any():
        return f"it comes to rest on the moved supports, blocks moved by {moved:.2g} m at most"
    far = "" if path.outcome is Outcome.RESTS else ", farther than what stands does"
    return (
        f"it comes to rest after settling by {moved:.2g} m, {travel:.2g} of a block's size{far}"
        f"{_said_met(path)}"
    )


def _said_longer(path: SettlementPath) -> str:
    """What would make it stand with either carrier."""
    if not path.beyond > 0.0:
        return ""
    other = "resting" if path.carrier is Carrier.MOVING else "moving"
    far = millimetres(rounded_up(1e3 * path.beyond, 2) / 1e3)
    return f"; it stands where the faces of the {other} block go on {far} mm beyond those ends"


def _said_met(path: SettlementPath) -> str:
    """Which blocks have met."""
    names, contacts = path.model.assembly.names, path.model.contacts
    pairs = {(int(contacts.block_a[i]), int(contacts.block_b[i])): None for i in path.met}
    told = [f"'{names[a]}' meets '{names[b]}'" for a, b in list(pairs)[:TOLD]]
    more = [f"and {len(pairs) - TOLD} pairs more"] if len(pairs) > TOLD else []
    return "".join(f", {one}" for one in told + more)
