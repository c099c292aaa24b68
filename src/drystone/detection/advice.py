"""Suggestions of a contact report."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.display import named, rounded_up
from drystone.base.errors import counted
from drystone.detection.face_overlaps import Overlap
from drystone.detection.misses import Shortfall
from drystone.detection.tolerances import (
    LARGEST,
    SHOWN,
    DetectionOptions,
    Missed,
    Reason,
    millimetres,
)

Pair = tuple[int, int]
"""Two blocks by their positions."""


def suggestions(
    names: Sequence[str],
    options: DetectionOptions,
    *,
    missed: Sequence[Missed],
    shortfalls: Sequence[Shortfall],
    overlaps: Sequence[Overlap],
    duplicates: Sequence[Pair],
    parts: Sequence[Pair],
    undirected: Sequence[Pair],
    isolated: Sequence[int],
    farther: Sequence[Missed],
) -> tuple[str, ...]:
    """Sentences that say which options would join more pairs of blocks.

    The arguments are the attributes of a :class:`ContactReport`; ``undirected`` includes the near
    ones.
    """
    said = []
    apart = [m for m in missed if not m.joined]
    for reason, knob, unit, digits in (
        (Reason.GAP, "gap", "", 2),
        (Reason.ANGLE, "angle", " degrees", 2),
    ):
        needed: dict[Pair, float] = {}
        for miss in apart:
            if miss.reason is reason and not np.isnan(miss.needed):
                pair = (miss.block_a, miss.block_b)
                needed[pair] = min(miss.needed, needed.get(pair, np.inf))
        if needed:
            now = f"{getattr(options, knob):g}"
            said.append(f"raise {knob} from {now} to {_steps(needed, digits, unit)}")
    said += _for_curved_joints(shortfalls, options)
    said += _for_overlaps(overlaps, set(duplicates), apart)
    if parts:
        said.append("split separate parts into blocks (--split, drystone.repair.split_components)")
    explained = {i for pair in undirected for i in pair}
    explained |= {i for p in overlaps for i in (p.block_a, p.block_b)}
    explained |= {i for miss in apart for i in (miss.block_a, miss.block_b)}
    alone = {*isolated} - explained
    wide = [m for m in farther if {m.block_a, m.block_b} & alone and m.needed <= LARGEST["gap"]]
    said += _for_wide_gaps(names, wide)
    explained |= {i for miss in wide for i in (miss.block_a, miss.block_b)}
    lost = [names[i] for i in isolated if i not in explained]
    if lost and len(names) > 1:
        said.append(f"nothing is near {named(lost, SHOWN)}: is a block missing, or in other units?")
    return tuple(said)


def _for_wide_gaps(names: Sequence[str], wide: Sequence[Missed]) -> list[str]:
    """The gap that joins blocks which touch nothing, and are farther apart than near misses."""
    if not wide:
        return []
    first, most = min(wide, key=lambda miss: miss.gap), max(miss.needed for miss in wide)
    pairs = counted(len({(miss.block_a, miss.block_b) for miss in wide}), "pair")
    return [
        f"'{names[first.block_a]}' and '{names[first.block_b]}' are {millimetres(first.gap)} mm"
        f" apart: --gap {option_for(most):g} joins {pairs} of blocks that touch nothing"
    ]


def _steps(needed: dict[Pair, float], digits: int, unit: str) -> str:
    """The value that joins the first of several pairs, and the one that joins all."""
    values = sorted(needed.values())
    all_of_them = option_for(values[-1], digits)
    first = option_for(values[0], digits)
    joins = f"{all_of_them:g}{unit} to join {counted(len(values), 'more pair')}"
    if first >= all_of_them:
        return joins
    at_once = sum(value <= first for value in values)
    return f"{first:g}{unit} to join {counted(at_once, 'more pair')}, or to {joins}"


def _for_overlaps(
    overlaps: Sequence[Overlap], twice: set[Pair], apart: Sequence[Missed]
) -> list[str]:
    """What to do about blocks that overlap or occur twice."""
    said = []
    if twice:
        pairs = counted(len(twice), "pair")
        said.append(f"{pairs} of blocks are the same block twice: remove one of the two")
    joinable = {
        (m.block_a, m.block_b)
        for m in apart
        if m.reason in (Reason.ANGLE, Reason.OVERLAP) and not np.isnan(m.needed)
    }
    deep = {(p.block_a, p.block_b) for p in overlaps} - twice - joinable
    if deep:
        several = counted(len(deep), "pair of blocks overlaps", "pairs of blocks overlap")
        said.append(f"{several}: move them apart in the model")
    return said


def _for_curved_joints(shortfalls: Sequence[Shortfall], options: DetectionOptions) -> list[str]:
    """How to find the missing area of joints whose two sides are meshed too differently."""
    if not shortfalls:
        return []
    steps = []
    for knob, unit in (("gap", ""), ("angle", " degrees")):
        now = getattr(options, knob)
        most = max(getattr(short, knob) for short in shortfalls)
        if most > now:
            steps.append((knob, now, option_for(most), unit))
    number = counted(len(shortfalls), "curved joint")
    finer = f"mesh both sides of {number} finer, or alike, to find all of the area"
    if not steps or any(value > LARGEST[knob] for knob, _, value, _ in steps):
        return [finer]
    raised = " and ".join(f"{k} from {now:g} to {value:g}{unit}" for k, now, value, unit in steps)
    return [f"{finer}; or raise {raised}"]


def option_for(needed: float, digits: int = 2) -> float:
    """The value of an option that is enough: above what is needed, which noise may reach."""
    return rounded_up(needed * (1.0 + 1e-9), digits)
