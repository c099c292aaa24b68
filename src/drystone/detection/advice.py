"""Suggestions of a contact report.

Pairs of blocks that are near each other and were not joined, as the contacts they would have.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import named, rounded_up
from drystone.base.errors import counted
from drystone.base.ragged import Ragged
from drystone.contacts import Contacts
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
from drystone.geometry.frames import area_vectors, frames_from_normals

Pair = tuple[int, int]
"""Two blocks by their positions."""


def suggestions(report: Any) -> tuple[str, ...]:
    """Sentences that say which options would join more pairs of blocks of a ``ContactReport``."""
    names, options, overlaps = report.names, report.options, report.overlaps_left
    said = []
    apart = [m for m in report.missed if not m.joined]
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
    said += _for_curved_joints(report.shortfalls, options)
    said += _for_overlaps(overlaps, apart)
    if report.parts:
        said.append("split separate parts into blocks (--split, drystone.repair.split_components)")
    explained = {i for pair in report.undirected for i in pair}
    explained |= {i for p in overlaps for i in (p.block_a, p.block_b)}
    explained |= {i for miss in apart for i in (miss.block_a, miss.block_b)}
    alone = {*report.isolated} - explained
    wide = [
        m for m in report.farther if {m.block_a, m.block_b} & alone and m.needed <= LARGEST["gap"]
    ]
    said += _for_wide_gaps(names, wide)
    explained |= {i for miss in wide for i in (miss.block_a, miss.block_b)}
    lost = [names[i] for i in report.isolated if i not in explained]
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


def _for_overlaps(overlaps: Sequence[Overlap], apart: Sequence[Missed]) -> list[str]:
    """What to do about blocks that overlap."""
    joinable = {
        (m.block_a, m.block_b)
        for m in apart
        if m.reason in (Reason.ANGLE, Reason.OVERLAP) and not np.isnan(m.needed)
    }
    deep = {(p.block_a, p.block_b) for p in overlaps} - joinable
    if not deep:
        return []
    several = counted(len(deep), "pair of blocks overlaps", "pairs of blocks overlap")
    return [f"{several}: move them apart in the model, or remove what is there twice"]


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


def among(unjoined: Iterable[Missed], blocks: Ints) -> tuple[Missed, ...]:
    """Those between two of some blocks, which are numbered anew in their order."""
    new = {int(block): i for i, block in enumerate(blocks)}
    return tuple(
        replace(miss, block_a=new[miss.block_a], block_b=new[miss.block_b])
        for miss in unjoined
        if miss.block_a in new and miss.block_b in new
    )


def contacts_if_joined(unjoined: Sequence[Missed], bounds: Floats, friction: float) -> Contacts:
    """The interfaces that the pairs would have.

    Where blocks overlap without faces that face each other, nobody can say which faces are meant,
    nor which way edges press that meet without a gap. They are held in every direction, by the
    sides of the box that both are in.

    Parameters
    ----------
    unjoined
    bounds : (n, 2, 3) [m]
        Lowest and highest corner of each block.
    friction
        Coefficient of every interface.
    """
    rows = [
        (miss, point, normal)
        for miss in unjoined
        for point, normal in ([_face(miss)] if _has_normal(miss) else _sides(miss, bounds))
    ]
    corner = [point for _, point, _ in rows]
    start = Ragged.of(corner).start
    area = np.linalg.norm(area_vectors(np.concatenate(corner), start), axis=1)
    count = np.diff(start)
    return Contacts(
        np.array([miss.block_a for miss, _, _ in rows], dtype=np.intp),
        np.array([miss.block_b for miss, _, _ in rows], dtype=np.intp),
        frames_from_normals(np.array([normal for _, _, normal in rows])),
        np.where(count > 2, area, 0.0),
        np.full(len(rows), friction),
        np.concatenate(corner),
        np.repeat(np.arange(len(rows), dtype=np.intp), count),
    )


def _has_normal(miss: Missed) -> bool:
    """Whether it is known which way the two blocks would press."""
    across = len(miss.polygon) > 0 and miss.gap != 0.0 and (miss.polygon[-1] != miss.polygon[0])
    return miss.area > 0.0 or bool(np.any(across))


def _face(miss: Missed) -> tuple[Floats, Floats]:
    """The corners, and the normal from a to b, of the interface that a pair would have."""
    point = miss.polygon
    if miss.area > 0.0:
        normal = area_vectors(point, Ragged.of([point]).start)[0]
    else:  # a band across the gap, or a line across it
        normal = (point[-1] - point[0]) * np.sign(miss.gap)
        half = len(point) // 2
        point = 0.5 * (point[:half] + point[: half - 1 : -1])
    return point, normal / np.linalg.norm(normal)


def _sides(miss: Missed, bounds: Floats) -> list[tuple[Floats, Floats]]:
    """The corners and outward normals of the sides of the box that two blocks share."""
    pair = bounds[[miss.block_a, miss.block_b]]
    low, high = pair[:, 0].max(axis=0), pair[:, 1].min(axis=0)
    sides = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for normal, at in ((-np.eye(3)[axis], low), (np.eye(3)[axis], high)):
            point = np.tile(at, (4, 1))
            point[:, u] = low[u], high[u], high[u], low[u]
            point[:, v] = low[v], low[v], high[v], high[v]
            sides.append((point if normal[axis] > 0.0 else point[::-1], normal))
    return sides


def words_on(unjoined: Sequence[Missed], names: Sequence[str]) -> str:
    """How the first of several pairs lies, how many more there are, and what joins them."""
    first = unjoined[0]
    said = f"'{names[first.block_a]}' and '{names[first.block_b]}' {_how(first)}"
    pairs = {(miss.block_a, miss.block_b) for miss in unjoined}
    if len(pairs) > 1:
        more = counted(len(pairs) - 1, "more pair is", "more pairs are")
        said += f", and {more} near each other"
    needed = _needed(unjoined)
    if not needed:
        return f"{said}; draw them so that they touch, or far apart"
    options = " ".join(f"--{name} {option_for(value):g}" for name, value in needed.items())
    return f"{said}; join them with {options}, or draw a gap that is meant wider: no option says so"


def _needed(unjoined: Sequence[Missed]) -> dict[str, float]:
    """The options that join what can be joined, by their names."""
    needed: dict[str, float] = {}
    for miss in unjoined:
        if miss.reason is Reason.GAP and miss.needed > LARGEST["gap"]:
            continue  # steep faces that no gap joins
        if not np.isnan(miss.needed):
            name = "angle" if miss.reason is Reason.ANGLE else "gap"
            needed[name] = max(needed.get(name, 0.0), miss.needed)
            if name == "gap" and miss.angle > DetectionOptions().angle:
                needed["angle"] = max(needed.get("angle", 0.0), miss.angle)
    return needed


def _how(miss: Missed) -> str:
    if miss.reason is Reason.OVERLAP:
        return f"are {millimetres(-miss.gap)} mm deep in each other"
    if miss.reason is Reason.GAP:
        return f"are {millimetres(miss.gap)} mm apart"
    if miss.reason is Reason.ANGLE:
        return f"have faces {miss.angle:.3g} degrees from parallel"
    if miss.reason is Reason.PARTLY:
        return f"touch on a part of their faces, {miss.angle:.3g} degrees from parallel"
    if miss.reason is Reason.WARP:
        return "have faces that are too warped"
    return "share only a sliver of their faces"
