"""How far two answers may differ, and what is told where they differ more."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.same_answers.asking import WIDTH, Answer

DIRECTION = math.cos(math.radians(15.0))
"""Of first motions: coarse, since the mechanism of several blocks is found to a tolerance."""
SHARE = 0.3
"""A block that moved farthest still moves by this share of the largest motion."""
ROOM = {
    "reaction": (2e-5, 0.0),
    "thrust": (0.02, 0.02),
    "equilibrium": (2.0 * WIDTH, WIDTH),
    "stands": (2.0 * WIDTH, WIDTH),
    "falls": (2.0 * WIDTH, WIDTH),
    "cost": (1e-3, 0.02),
    "value": (1e-3, 0.02),
    "travel": (1e-5, 0.02),
    "moved": (1e-5, 0.05),
}
"""Absolute, and by the frozen value: the brackets of limits end at ``WIDTH``, mends are searched
to a hundredth, and the thrust of an indeterminate structure is that of the assumed stiffness."""

JOINTS_DECIDE = {"settles", "sensitive"}
"""Words of one state: other stiffnesses do not hold it. When they were frozen it was followed then;
now it is only where uniform stiffness does not hold it either."""


def plain(answer: Answer) -> Answer:
    """What is kept of an answer."""
    return {name: value for name, value in answer.items() if not name.startswith("_")}


def differences(frozen: Answer, now: Answer) -> Iterator[tuple[str, Any, Any]]:
    """What differs, the frozen value and the value now."""
    for name in {**frozen, **plain(now)}:
        before, after = frozen.get(name), now.get(name)
        if not _same(name, before, after, now):
            yield name, before, after


def _same(name: str, before: Any, after: Any, now: Answer) -> bool:
    if name == "word" and {before, after} == JOINTS_DECIDE:
        return True
    if name in ("thrust", "unbalanced") and before is None:
        return not (name == "unbalanced" and after)  # it was frozen as one that settles
    if name == "drift" and (before is None or after is None):
        return True
    if before is None or after is None:
        return before is after
    if name == "drift":
        return float(np.dot(before, after)) >= DIRECTION
    if name == "moves":
        return _moves_alike(before, now["_motion"])
    if name == "order":
        # another order with the same help is as good: the help has names of its own
        return sorted(before) == sorted(after)
    if name in ROOM:
        return _close(before, after, *ROOM[name])
    return bool(before == after)


def _moves_alike(before: list[float], motion: Any) -> bool:
    """Whether the block that moved farthest moves in the same direction."""
    block, direction = int(before[0]), before[1:]
    size = float(np.linalg.norm(motion[block]))
    return size >= SHARE and float(np.dot(motion[block], direction)) >= DIRECTION * size


def _close(before: Any, after: Any, absolute: float, relative: float) -> bool:
    """Numbers, lists of numbers, or blocks by their positions."""
    if isinstance(before, str) or isinstance(after, str):
        return bool(before == after)
    one, other = np.atleast_1d(before).astype(float), np.atleast_1d(after).astype(float)
    if one.shape != other.shape:
        return False
    # nothing by nothing: a kind of mend without a value
    both = np.isnan(one) & np.isnan(other)
    room = absolute + relative * np.abs(one).max(initial=0.0)
    return bool((both | (np.abs(one - other) <= room)).all())
