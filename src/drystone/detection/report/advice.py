"""What a contact report suggests, and how it words numbers and names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from drystone.detection.options import LARGEST
from drystone.detection.report.reasons import Reason

if TYPE_CHECKING:
    from drystone.detection.report.contact_report import ContactReport
    from drystone.detection.report.reasons import Missed

SHOWN = 8
"""Names listed in one line."""


def suggestions(report: ContactReport) -> tuple[str, ...]:
    """What would join more pairs of blocks that do not touch yet, in plain words."""
    said = []
    apart = [m for m in report.missed if not m.joined]
    for reason, knob, unit, digits in (
        (Reason.GAP, "gap", "", 2),
        (Reason.ANGLE, "angle", " degrees", 2),
    ):
        needed: dict[tuple[int, int], float] = {}
        for miss in apart:
            if miss.reason is reason and not np.isnan(miss.needed):
                pair = (miss.block_a, miss.block_b)
                needed[pair] = min(miss.needed, needed.get(pair, np.inf))
        if needed:
            now = f"{getattr(report.options, knob):g}"
            said.append(f"raise {knob} from {now} to {_steps(needed, digits, unit)}")
    said += _for_curved_joints(report)
    said += _for_overlaps(report, apart)
    if report.parts:
        said.append("split separate parts into blocks (--split, drystone.repair.split_shells)")
    explained = {i for pair in (*report.undirected, *report.near_undirected) for i in pair}
    explained |= {i for p in report.overlaps for i in (p.block_a, p.block_b)}
    explained |= {i for miss in apart for i in (miss.block_a, miss.block_b)}
    lost = [report.names[i] for i in report.isolated if i not in explained]
    if lost and len(report.names) > 1:
        said.append(f"nothing is near {listed(lost)}: is a block missing, or in other units?")
    return tuple(said)


def _steps(needed: dict[tuple[int, int], float], digits: int, unit: str) -> str:
    """The value that joins the first of several pairs, and the one that joins all."""
    values = sorted(needed.values())
    all_of_them = _rounded_up(values[-1], digits)
    first = _rounded_up(values[0], digits)
    joins = f"{all_of_them:g}{unit} to join {counted(len(values), 'more pair')}"
    if first >= all_of_them:
        return joins
    at_once = sum(value <= first for value in values)
    return f"{first:g}{unit} to join {counted(at_once, 'more pair')}, or to {joins}"


def _for_overlaps(report: ContactReport, apart: list[Missed]) -> list[str]:
    """What to do about blocks that overlap, or are there twice."""
    said = []
    twice = set(report.duplicates)
    if twice:
        pairs = counted(len(twice), "pair")
        said.append(f"{pairs} of blocks are one block twice: remove one of the two")
    joinable = {
        (m.block_a, m.block_b)
        for m in apart
        if m.reason in (Reason.ANGLE, Reason.OVERLAP) and not np.isnan(m.needed)
    }
    deep = {(p.block_a, p.block_b) for p in report.overlaps} - twice - joinable
    if deep:
        said.append(f"{counted(len(deep), 'pair')} of blocks overlap: move them apart in the model")
    return said


def _for_curved_joints(report: ContactReport) -> list[str]:
    """What would find the rest of joints that are meshed too differently on their two sides."""
    if not report.shortfalls:
        return []
    options = report.options
    steps = []
    for knob, unit in (("gap", ""), ("angle", " degrees")):
        now = getattr(options, knob)
        most = max(getattr(short, knob) for short in report.shortfalls)
        if most > now:
            steps.append((knob, now, _rounded_up(most, 2), unit))
    number = counted(len(report.shortfalls), "curved joint")
    finer = f"mesh both sides of {number} finer, or alike, to find all of the area"
    if not steps or any(value > LARGEST[knob] for knob, _, value, _ in steps):
        return [finer]
    raised = " and ".join(f"{k} from {now:g} to {value:g}{unit}" for k, now, value, unit in steps)
    return [f"{finer}; or raise {raised}"]


def _rounded_up(value: float, digits: int) -> float:
    """The next larger number with a few significant digits, so that it is enough."""
    step = 10.0 ** (np.floor(np.log10(value)) - digits + 1)
    return float((np.floor(value / step * (1.0 + 1e-9)) + 1.0) * step)


def counted(number: int, noun: str) -> str:
    """A number of things in words.

    Examples
    --------
    >>> counted(1, "pair"), counted(1200, "pair")
    ('1 pair', '1,200 pairs')
    """
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def listed(items: Sequence[str]) -> str:
    """The first of several names, and how many more there are."""
    more = f" and {len(items) - SHOWN} more" if len(items) > SHOWN else ""
    return ", ".join(items[:SHOWN]) + more


def millimetres(length: float) -> str:
    """A length [m] in millimetres, to three digits or a nanometre, and never as a power of ten.

    Examples
    --------
    >>> millimetres(0.0), millimetres(0.0012345), millimetres(-12.345)
    ('0', '1.23', '-12,345')
    """
    value = round(1e3 * float(length), 6) + 0.0
    return f"{value:,.0f}" if abs(value) >= 1e3 else f"{value:.3g}"


__all__ = ["SHOWN", "counted", "listed", "millimetres", "suggestions"]
