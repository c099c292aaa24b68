"""Joints changed until every block is placed alone: plan, change the joint of a block, plan again.

Where a block must be held or propped, or cannot be put in, one of its joints with the blocks that
are already there is turned or made a wedge, the smallest change first. A change is planned when the
block stands with it in its stage, and kept when the whole needs less help.

Source: Kao 2023, chapter 7.3 (discretise, check, modify, sequence, and back).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Unpack

import numpy as np

from drystone.base.arrays import Bools, frozen_floats
from drystone.base.declared import Offered
from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import Options, checked_call
from drystone.design.built import Buildable, Help, helped
from drystone.design.changed import Kept
from drystone.design.joint_surgery import still_edge, turn_joint, wedge_joint
from drystone.design.search import improved
from drystone.io.opening import Given, How, supported_model
from drystone.model import Model
from drystone.sequence import Plan, PlanOptions, check_once, plan


@dataclass(frozen=True)
class RecutOptions(Options):
    """Changes of joints that are tried.

    Attributes
    ----------
    angles_deg : [degrees]
        Each joint is turned by the angle about an edge, to both sides, then made a wedge of it.
    most : >= 1
        Number of changes that are tried in all.
    plan
        Options of the plans.
    """

    angles_deg: tuple[float, ...] = (10.0, 20.0, 30.0)
    most: int = 200
    plan: PlanOptions = field(default_factory=PlanOptions)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_below(1, "most")
        angles = frozen_floats(self.angles_deg, (None,), "angles_deg")
        if not ((angles > 0.0) & (angles < 60.0)).all():
            raise InputError("angles must lie between 0 and 60 degrees", where="angles_deg")


@checked_call
def recut_joints(
    given: Given,
    *,
    options: RecutOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Buildable:
    """Change joints until every block is placed alone and stands at once.

    Parameters
    ----------
    given
        A model, which may fall as it is; or an assembly or a file that ``how`` turns into one.
    options

    Returns
    -------
    Buildable
        Its changes name the block that needed help and the one that it touches. The value of a
        wedge is above zero where the first of them is the wedge, below zero where it is the groove.

    Raises
    ------
    InputError
        What was given cannot be made into a model.

    Examples
    --------
    >>> from drystone.models import snake
    >>> found = recut_joints(snake(), friction=0.66)
    >>> found.free, [(one.kind, one.value) for one in found.changes]
    (True, [('wedge', 10.0)])
    """
    chosen = RecutOptions.of(options)
    model = supported_model(given, **how)
    clock = Clock(time_limit_s, stop, progress)
    # a prop of what does not stand is one more block that needs help
    thus = replace(chosen.plan, anyway=True)
    planned = partial(plan, options=thus, executor=executor, stop=clock.late)
    tried = 0

    def proposals(now: _Planned) -> Iterator[_Planned]:
        nonlocal tried
        for block, beside, joint, kept in _changes(now, chosen.angles_deg):
            if clock.late() or tried >= chosen.most:
                return
            tried += 1
            clock.tell("changing joints", tried, chosen.most)
            made = _changed(now.model, joint, kept, block)
            if made is None or not _stands(made, now.plan, block, beside):
                continue
            found = planned(made)
            if not found.stopped:
                yield _Planned(made, found, (*now.changes, kept))

    first = _Planned(model, planned(model))
    best = improved(first, proposals, clock.late)
    if not any(best.rank) and not best.plan.stopped:
        words = "every block is free"
    elif clock.late() or tried >= chosen.most:
        words = f"{clock.reason or 'the limit of changes was reached'} before all was free"
    else:
        words = "no change that is tried needs less help"
    words += f": {counted(len(best.changes), 'joint')} changed, {counted(tried, 'change')} tried"
    return Buildable(best.model, best.plan, best.changes, (words,), tried, first.rank)


@dataclass(frozen=True, eq=False)
class _Planned:
    """A model with some joints changed, and its plan."""

    model: Model
    plan: Plan
    changes: tuple[Kept, ...] = ()

    @property
    def rank(self) -> Help:
        """What the plan needs."""
        return Help.of(self.plan)


def _changes(
    now: _Planned, angles: Sequence[float]
) -> Iterator[tuple[int, tuple[int, ...], int, Kept]]:
    """Blocks that need help, the props beside each, a joint of it, and what it is changed to.

    The smallest changes of a block come first, of its joints with blocks in place those that carry
    most.
    """
    contacts, names = now.model.contacts, now.model.assembly.names
    level = np.abs(contacts.frame[:, 0] @ now.plan.model.up) * contacts.area
    for block, beside, why in helped(now.plan):
        own = (contacts.block_a == block) | (contacts.block_b == block)
        other = np.where(contacts.block_a == block, contacts.block_b, contacts.block_a)
        joints = np.flatnonzero(own & _placed_before(now.plan, block)[other])
        order = joints[np.argsort(-level[joints], kind="stable")].tolist()
        for size, joint, kind, sign in product(angles, order, ("turn", "wedge"), (1.0, -1.0)):
            ends = names[block], names[other[joint]]
            yield block, beside, joint, Kept(kind, ends, why, sign * size)


def _placed_before(found: Plan, block: int) -> Bools:
    """(n,) blocks in place when a block comes; all others for one that cannot be put in."""
    if block not in found.step_of:
        return np.arange(len(found.model.assembly)) != block
    there = np.array(found.model.assembly.fixed)
    for step in found.steps[: found.step_of[block]]:
        there[list(step.blocks)] = True
    return there


def _changed(model: Model, joint: int, kept: Kept, block: int) -> Model | None:
    """The model with the change, seen from a block; None where the surgery refuses it."""
    try:
        if kept.kind == "wedge":
            return wedge_joint(model, joint, kept.value, first=block)
        pivot = still_edge(model, joint, kept.value, block)
        return turn_joint(model, joint, kept.value, pivot=pivot, first=block)
    except InputError:
        return None


def _stands(made: Model, found: Plan, block: int, beside: tuple[int, ...]) -> bool:
    """Whether the block stands when it is placed, with the props beside it."""
    there = _placed_before(found, block)
    there[block] = True
    still = sorted({*np.flatnonzero(made.assembly.fixed).tolist(), *beside} - {block})
    stage = made.with_supports([b for b in still if there[b]])
    return check_once(stage.subset(np.flatnonzero(there).tolist())).stable


OFFERED = Offered(
    recut_joints,
    "arch.json --hands 3 --most 2",
    ("options.plan.rules.hands", "options.most"),
    "model",
    ("options.plan.rules.hands", "options.most", "time_limit_s"),
)
