"""Joints changed until every block is placed alone: plan, change the joint of a block, plan again.

Where a block must be held or propped, or cannot be put in, one of its joints with the blocks that
are already there is turned or made a wedge, the smallest change first. A change is planned when the
block stands with it in its stage, and kept when the whole needs less help.

Source: Kao 2023, chapter 7.3 (discretise, check, modify, sequence, and back).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeAlias, Unpack

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.base.arrays import Bools, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import Options, checked_call
from drystone.base.table import Table
from drystone.design.joint_surgery import still_edge, turn_joint, wedge_joint
from drystone.design.search import improved
from drystone.io.opening import Given, How, supported_model
from drystone.model import Model
from drystone.sequence import Plan, PlanOptions, check_once, plan

_Need: TypeAlias = tuple[bool, int, int, int, int]
"""What a plan needs: whether there is none, blocks that cannot be put in, props, blocks placed
together with another one."""


@dataclass(frozen=True)
class RecutOptions(Options):
    """Changes of joints that are tried.

    Attributes
    ----------
    angles_deg : [degrees]
        Each joint is turned by the angle about an edge, to both sides, then made a wedge of it.
    most
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


@dataclass(frozen=True)
class RecutJoint(OneLine):
    """A change of a joint that was kept.

    Attributes
    ----------
    blocks
        Names of the block that needed help and of the one it touches.
    kind
        ``turn`` or ``wedge``.
    angle_deg : [degrees]
        Of a wedge: above zero the first block is the wedge, below zero the groove.
    why
        The help that the block needed.
    """

    blocks: tuple[str, str]
    kind: str
    angle_deg: float
    why: str


@dataclass(frozen=True, eq=False)
class Recut(Answer):
    """A model with changed joints, and its plan.

    Attributes
    ----------
    model
    plan
    changes
    tried
        Number of changes that were tried.
    message
        How it ended.
    """

    model: Model
    plan: Plan
    changes: tuple[RecutJoint, ...]
    tried: int
    message: str

    @property
    def free(self) -> bool:
        """Whether every block is placed alone and stands at once."""
        return not any(_need(self.plan))

    def _summary(self) -> str:
        return self.message

    @property
    def title(self) -> str:
        """How it ended."""
        return self.message[0].upper() + self.message[1:]

    def sentences(self) -> Sequence[Sentence]:
        """Whether every block is free, and how it ended."""
        role = Role.GOOD if self.free else Role.BAD
        return [Sentence("FREE" if self.free else "NOT FREE", role), Sentence(self.message)]

    def tables(self) -> Sequence[Table]:
        """The changes of joints that were kept."""
        changes = self.changes
        columns = {
            "block_a": [one.blocks[0] for one in changes],
            "block_b": [one.blocks[1] for one in changes],
            "kind": [one.kind for one in changes],
            "angle_deg": [one.angle_deg for one in changes],
            "why": [one.why for one in changes],
        }
        return [Table("changes", columns, {"angle_deg": "deg"})]

    def layers(self) -> Scene:
        """The plan."""
        return self.plan.layers()

    def numbers(self) -> Mapping[str, Any]:
        """Whether every block is free, and the plan."""
        return {
            "free": self.free,
            "message": self.message,
            "tried": self.tried,
            "plan": self.plan.numbers(),
        }


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
) -> Recut:
    """Change joints until every block is placed alone and stands at once.

    Parameters
    ----------
    given
        A model, which may fall as it is; or an assembly or a file that ``how`` turns into one.
    options

    Raises
    ------
    InputError
        What was given cannot be made into a model.

    Examples
    --------
    >>> from drystone.models import snake
    >>> found = recut_joints(snake(), friction=0.66)
    >>> found.free, [(one.kind, one.angle_deg) for one in found.changes]
    (True, [('wedge', 10.0)])
    """
    chosen = RecutOptions.of(options)
    model = supported_model(given, **how)
    clock = Clock(time_limit_s, stop)
    # a prop of what does not stand is one more block that needs help
    thus = replace(chosen.plan, anyway=True)
    planned = partial(plan, options=thus, executor=executor, stop=clock.late)
    tried = 0

    def proposals(now: _Planned) -> Iterator[_Planned]:
        nonlocal tried
        for block, held, why in _helped(now.plan):
            changes = _changes(now.model, now.plan, block, chosen.angles_deg)
            for one, other, kind, angle in changes:
                if clock.late() or tried >= chosen.most:
                    return
                tried += 1
                if progress is not None:
                    progress("changing joints", tried, chosen.most)
                made = _changed(now.model, one, kind, angle, block)
                if made is None or not _stands(made, now.plan, block, held):
                    continue
                found = planned(made)
                if not found.stopped:
                    names = now.model.assembly.names[block], now.model.assembly.names[other]
                    change = RecutJoint(names, kind, angle, why)
                    yield _Planned(made, found, (*now.changes, change))

    best = improved(_Planned(model, planned(model), ()), proposals, clock.late)
    if not any(best.rank) and not best.plan.stopped:
        words = "every block is free"
    elif clock.late() or tried >= chosen.most:
        words = f"{clock.reason or 'the limit of changes was reached'} before all was free"
    else:
        words = "no change that is tried needs less help"
    words += f": {counted(len(best.changes), 'joint')} changed, {counted(tried, 'change')} tried"
    return Recut(best.model, best.plan, best.changes, tried, words)


@dataclass(frozen=True, eq=False)
class _Planned:
    """A model with some joints changed, and its plan."""

    model: Model
    plan: Plan
    changes: tuple[RecutJoint, ...]

    @property
    def rank(self) -> _Need:
        """What the plan needs."""
        return _need(self.plan)


def _need(found: Plan) -> _Need:
    return not found.steps, len(found.impossible), *found.help


def _helped(found: Plan) -> Iterator[tuple[int, tuple[int, ...], str]]:
    """Blocks that need help, the first placed first, with the props beside them, and why."""
    for block, why in found.impossible.items():
        yield block, (), why
    done: set[int] = set()
    for step in found.steps:
        together = step.blocks if len(step.blocks) > 1 else ()
        for block in (*together, *step.props):
            if block not in done:
                done.add(block)
                yield block, tuple(b for b in step.props if b != block), step.why or "it is propped"


def _changes(
    model: Model, found: Plan, block: int, angles: Sequence[float]
) -> Iterator[tuple[int, int, str, float]]:
    """Interface, the other block, kind and angle, small first; joints that carry most first."""
    contacts = model.contacts
    there = _placed_before(found, block)
    own = (contacts.block_a == block) | (contacts.block_b == block)
    other = np.where(contacts.block_a == block, contacts.block_b, contacts.block_a)
    level = np.abs(contacts.frame[:, 0] @ found.model.up) * contacts.area
    joints = np.flatnonzero(own & there[other])
    for angle in angles:
        for joint in joints[np.argsort(-level[joints], kind="stable")].tolist():
            for kind in ("turn", "wedge"):
                for sign in (1.0, -1.0):
                    yield joint, int(other[joint]), kind, sign * angle


def _placed_before(found: Plan, block: int) -> Bools:
    """(n,) blocks in place when a block comes; all others for one that cannot be put in."""
    if block not in found.step_of:
        return np.arange(len(found.model.assembly)) != block
    there = np.array(found.model.assembly.fixed)
    there[list(found.impossible)] = True
    for step in found.steps[: found.step_of[block]]:
        there[list(step.blocks)] = True
    return there


def _changed(model: Model, joint: int, kind: str, angle: float, block: int) -> Model | None:
    """The model with the change, seen from a block; None where the surgery refuses it."""
    try:
        if kind == "wedge":
            return wedge_joint(model, joint, angle, first=block)
        pivot = still_edge(model, joint, angle, block)
        return turn_joint(model, joint, angle, pivot=pivot, first=block)
    except InputError:
        return None


def _stands(made: Model, found: Plan, block: int, held: tuple[int, ...]) -> bool:
    """Whether the block stands when it is placed, with other blocks held."""
    there = _placed_before(found, block)
    there[block] = True
    still = sorted({*np.flatnonzero(made.assembly.fixed).tolist(), *held} - {block})
    stage = made.with_supports([b for b in still if there[b]])
    return check_once(stage.subset(np.flatnonzero(there).tolist())).stable
