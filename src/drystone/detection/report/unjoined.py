"""Pairs of blocks that are near each other and were not joined, as the contacts they would have."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import counted
from drystone.base.ragged import Ragged
from drystone.contacts import Contacts
from drystone.detection.report.advice import rounded_up
from drystone.detection.report.reasons import Missed, Reason, millimetres
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.polygon import area_vectors


def among(unjoined: Iterable[Missed], blocks: Ints) -> tuple[Missed, ...]:
    """Those between two of some blocks, which are numbered anew in their order."""
    new = {int(block): i for i, block in enumerate(blocks)}
    return tuple(
        replace(miss, block_a=new[miss.block_a], block_b=new[miss.block_b])
        for miss in unjoined
        if miss.block_a in new and miss.block_b in new
    )


def contacts_if_joined(unjoined: Sequence[Missed], friction: float) -> Contacts | None:
    """The interfaces that the pairs would have; None where one of them has no known place."""
    rows = [_polygon_and_normal(miss) for miss in unjoined]
    if not all(len(point) for point, _ in rows):
        return None
    count = np.array([len(point) for point, _ in rows], dtype=np.intp)
    return Contacts(
        np.array([miss.block_a for miss in unjoined], dtype=np.intp),
        np.array([miss.block_b for miss in unjoined], dtype=np.intp),
        frames_from_normals(np.array([normal for _, normal in rows]).reshape(-1, 3)),
        np.array([miss.area for miss in unjoined]),
        np.full(len(unjoined), friction),
        np.concatenate([np.zeros((0, 3)), *(point for point, _ in rows)]),
        np.repeat(np.arange(len(unjoined), dtype=np.intp), count),
    )


def _polygon_and_normal(miss: Missed) -> tuple[Floats, Floats]:
    """The corners, and the normal from a to b, of the interface that a pair would have."""
    point = miss.polygon
    if len(point) == 0:
        return point, np.zeros(3)
    if miss.area > 0.0:
        normal = area_vectors(point, Ragged.from_counts([len(point)]).start)[0]
    else:  # a band across the gap, or a line across it
        normal = (point[-1] - point[0]) * np.sign(miss.gap)
        half = len(point) // 2
        point = 0.5 * (point[:half] + point[: half - 1 : -1])
    return point, normal / np.linalg.norm(normal)


def words_on(unjoined: Sequence[Missed], names: Sequence[str]) -> str:
    """How the first of several pairs lies, how many more there are, and what joins them."""
    first = unjoined[0]
    said = f"'{names[first.block_a]}' and '{names[first.block_b]}' {_how(first)}"
    pairs = {(miss.block_a, miss.block_b) for miss in unjoined}
    if len(pairs) > 1:
        more = counted(len(pairs) - 1, "more pair is", "more pairs are")
        said += f", and {more} near each other"
    needed: dict[str, float] = {}
    for miss in unjoined:
        if not np.isnan(miss.needed):
            name = "angle" if miss.reason is Reason.ANGLE else "gap"
            needed[name] = max(needed.get(name, 0.0), miss.needed)
    if not needed:
        return f"{said}; draw them so that they touch, or far apart"
    options = " ".join(f"--{name} {rounded_up(value, 2):g}" for name, value in needed.items())
    return f"{said}; join them with {options}, or draw them far apart"


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
