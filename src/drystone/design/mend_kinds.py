"""The kinds of mends, and what makes each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from drystone.design.added_mends import ballast_mends, prop_mends, support_mends, tie_mends
from drystone.design.bench import Bench, MendCandidate
from drystone.design.changed_mends import (
    friction_mends,
    glue_mends,
    joints_mends,
    merge_mends,
    thicker_mends,
)

MAKERS: Mapping[str, Callable[[Bench], Iterator[MendCandidate]]] = {
    "support": support_mends,
    "prop": prop_mends,
    "tie": tie_mends,
    "friction": friction_mends,
    "turn": partial(joints_mends, kind="turn"),
    "wedge": partial(joints_mends, kind="wedge"),
    "let-in": partial(joints_mends, kind="let-in"),
    "thicker": thicker_mends,
    "ballast": ballast_mends,
    "glue": glue_mends,
    "merge": merge_mends,
}
"""The changes of each kind that hold the region of a bench in its local model."""

KINDS = tuple(MAKERS)
"""The kinds of mends."""
