"""A shape cut into blocks that stand: cut, check, plan, and cut again where the plan needs help.

The cuts are made from the bottom up. All blocks below a cut are fixed. The part above is one block;
it must stand on the cut face by contact and friction. Each place has a list of cuts, in the order
of preference: the horizontal plane, planes turned about the horizontal edge across the lean,
notches, and the same at other heights. A place takes its first cut on which the part above stands.
The blocks are planned; where one is not free, the loop goes back to the cut under it and takes the
next one. Where a place has no cut left, the place below takes its next one.

Joints changed until every block is placed alone: plan, change the joint of a block, plan again.

Where a block must be held or propped, or cannot be put in, one of its joints with the blocks that
are already there is turned or made a wedge, the smallest change first. A change is planned when the
block stands with it in its stage, and kept when the whole needs less help.

Source: Kao et al. 2022 (design loop of stability-aware blocks); Kao 2023, chapter 7.3 (discretise,
check, modify, sequence, and back).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Unpack

import numpy as np

from drystone.answer.question import UP
from drystone.assembly import Assembly, Block
from drystone.base.arrays import Bools, Floats
from drystone.base.declared import Offered
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, LongWork, Options, checked_call
from drystone.design.changed import Buildable, Help, Kept, helped
from drystone.design.surgery import (
    Cut,
    split_block,
    still_edge,
    tilted_cuts,
    turn_joint,
    wedge_joint,
)
from drystone.design.words import place as at_place
from drystone.geometry.frames import unit
from drystone.io.opening import Given, LongHow, supported_model
from drystone.model import FlushEnds, Model
from drystone.sequence import Plan, PlanOptions, check_both, check_once, plan

UPRIGHT = 1e-3
"""Lean, as a share of the height, below which the edge of turned cuts lies along y."""

_TURNS = (0.0, 10.0, -10.0, 20.0, -20.0, 30.0, -30.0)
"""[degrees] By which the plane at a place is turned. Chosen."""

_NOTCH = 20.0
"""[degrees] Of the groove in which the part above sits, where no plane does. Chosen."""

_SHIFTS = (0.0, -0.2, 0.2)
"""Shares of the height of a block by which all these are moved. Chosen."""


@dataclass(frozen=True)
class CutOptions(Options):
    """Options of :func:`cut_until_free`.

    Attributes
    ----------
    blocks : >= 2
        Number of blocks; the lowest is the support.
    friction : coefficient >= 0
        Of all joints.
    ends
        What becomes of flush ends of joints where blocks are followed; left out, undecided where
        they decide.
    most : >= 1
        Number of plans after which the loop ends.
    plan
        Options of the plans.
    """

    blocks: int = 4
    friction: float = 0.6
    ends: FlushEnds | None = None
    most: int = 40
    plan: PlanOptions = field(default_factory=PlanOptions)

    def model(self, assembly: Assembly) -> Model:
        """Blocks with joints as chosen."""
        return replace(Model.of(assembly, friction=self.friction), ends=self.ends)


@checked_call
def cut_until_free(
    block: Block,
    proposals: Sequence[Sequence[Cut]] | None = None,
    *,
    options: CutOptions | None = None,
    **work: Unpack[LongWork],
) -> Buildable:
    """Cut a shape into blocks that are all placed alone and stand at once.

    Parameters
    ----------
    block
        The shape; its lowest part becomes the support.
    proposals
        Per place, from the bottom up, cuts in the order of preference. A cut that misses the shape,
        or divides it into more than two parts, is passed over. When left out: planes at equal
        heights, tilted, shifted and with a notch.
    options

    Examples
    --------
    >>> from drystone.models import prism
    >>> tower = prism([(0, 0), (1, 0), (1.7, 4), (0.7, 4)], (0, 1), "tower")
    >>> found = cut_until_free(tower)
    >>> found.free, len(found.model)
    (True, 4)
    """
    chosen = CutOptions.of(options)
    choices = proposed_cuts(block, chosen.blocks) if proposals is None else proposals
    if not choices:
        raise InputError("no place to cut at", where="proposals", remedy="give one or more")
    clock = Clock.of(work)
    first = [0] * len(choices)
    log: list[str] = []
    model = chosen.model(Assembly((block,), np.array([True])))
    kept: tuple[Kept, ...] = ()
    found: Plan | None = None
    words = f"not every block is free after {counted(chosen.most, 'plan')}"
    for done in range(chosen.most):
        if clock.late():
            words = f"{clock.reason} before all was free"
            break
        clock.tell("cutting", done, chosen.most)
        pieces, used = _cut(block, choices, first, chosen)
        if len(used) < len(choices):
            place, why = len(used), "on none of its cuts the part above stands"
        else:
            kept = tuple(_kept(some[k]) for some, k in zip(choices, used, strict=True))
            assembly = Assembly(pieces, np.arange(len(pieces)) == 0)
            model = chosen.model(assembly)
            found = plan(model, options=chosen.plan, executor=clock.workers, stop=clock.late)
            needy = _helped(found)
            if needy is None:
                count = counted(len(log), "recut")
                words = f"every block of {len(pieces)} is free after {count}"
                break
            place, why = needy
        log.append(f"cut {place} changed: {why}")
        # without blocks, no further cut of this place is left
        used = [*used, *[len(one) for one in choices[len(used) :]]]
        while place >= 0 and used[place] + 1 >= len(choices[place]):
            place -= 1
        if place < 0:
            words = "no proposed cuts make every block free"
            break
        first[place:] = [used[place] + 1, *[0] * (len(choices) - place - 1)]
    return Buildable(model, found, kept, (*log, words), len(log))


def _cut(
    block: Block, choices: Sequence[Sequence[Cut]], first: Sequence[int], options: CutOptions
) -> tuple[tuple[Block, ...], list[int]]:
    """Blocks, and the number of the cut taken at each place; up to one where none is accepted."""
    pieces: list[Block] = []
    used: list[int] = []
    rest = block
    for place, some in enumerate(choices):
        for number in range(first[place], len(some)):
            parts = _parts(rest, some[number], options)
            if parts is not None:
                rest, below = parts
                pieces.append(below.renamed(f"c{place:02d}-block"))
                used.append(number)
                break
        else:
            break
    return (*pieces, rest.renamed(f"c{len(pieces):02d}-block")), used


def _parts(rest: Block, cut: Cut, options: CutOptions) -> tuple[Block, Block] | None:
    """The part above a cut and that below; None unless there are two, and the one above stands."""
    try:
        above, below = split_block(rest, cut)
    except InputError:  # it misses what is left of the block
        return None
    if len(above) > 1 or len(below) > 1:
        return None
    both = (below[0].renamed("below"), above[0].renamed("above"))
    pair = Assembly(both, np.array([True, False]))
    stands = check_both(options.model(pair)).stable
    return (above[0], below[0]) if stands else None


def _kept(cut: Cut) -> Kept:
    """A cut as a change: its slope [degrees], where it is, and its notch."""
    normal = unit(cut.normal)
    slope = float(np.rad2deg(np.arctan2(np.hypot(normal[0], normal[1]), normal[2])))
    notch = f", with a notch of {cut.wedge_deg:g} degrees" if cut.wedge_deg else ""
    words = f"a cut at {at_place(np.asarray(cut.point))}, {slope:.3g} degrees from level{notch}"
    return Kept("cut", (), words, slope)


def _helped(found: Plan) -> tuple[int, str] | None:
    """The cut under the lowest block that is not free, and why; None if all are free."""
    names = found.model.assembly.names
    if not found.steps:
        falling = found.complete.falling
        block = min(falling) if falling else len(names) - 1
        return max(0, block - 1), f"{names[block]}: {found.message}"
    for block, _, why in sorted(helped(found)):
        return max(0, block - 1), f"{names[block]} is {found.status[block].value}: {why}"
    bad = next((one for one in found.steps if not one.answer.stands), None)
    if bad is None:
        return None
    return max(0, bad.blocks[-1] - 1), f"{names[bad.blocks[-1]]}: {bad.answer.message}"


def proposed_cuts(block: Block, count: int) -> list[list[Cut]]:
    """Per place between a number of blocks, from the bottom up, cuts in the order of preference."""
    low, high = float(block.vertices[:, 2].min()), float(block.vertices[:, 2].max())
    height = (high - low) / count
    heights = low + height * np.arange(1, count)
    lean = _middle(block, float(heights[-1])) - _middle(block, low + 0.01 * height)
    lean[2] = 0.0
    leans = float(np.linalg.norm(lean)) > UPRIGHT * (high - low)
    edge = np.cross(UP, lean) if leans else np.array([0.0, 1.0, 0.0])
    out = []
    for z in heights.tolist():
        some: list[Cut] = []
        for shift in _SHIFTS:
            point = _middle(block, z + shift * height)
            some += [*tilted_cuts(point, UP, edge, _TURNS), Cut(point, UP, _NOTCH, edge)]
        out.append(some)
    return out


def _middle(block: Block, z: float) -> Floats:
    """The mean corner of the section of a block at a height."""
    above, _ = split_block(block, Cut(np.array([0.0, 0.0, z]), UP))
    corners = np.concatenate([piece.vertices for piece in above])
    near = np.abs(corners[:, 2] - z) <= 1e-6 * float(np.ptp(block.vertices[:, 2]))
    return np.asarray(np.append(corners[near, :2].mean(axis=0), z))


@dataclass(frozen=True)
class RecutOptions(Options):
    """Changes of joints that are tried.

    Attributes
    ----------
    angles_deg : [degrees] > 0, < 60
        Each joint is turned by the angle about an edge, to both sides, then made a wedge of it.
    most : >= 1
        Number of changes that are tried in all.
    plan
        Options of the plans.
    """

    angles_deg: tuple[float, ...] = (10.0, 20.0, 30.0)
    most: int = 200
    plan: PlanOptions = field(default_factory=PlanOptions)


@checked_call
def recut_joints(
    given: Given,
    *,
    options: RecutOptions | None = None,
    **how: Unpack[LongHow],
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
    clock = Clock.of(how)
    model = supported_model(given, **how)
    # a prop of what does not stand is one more block that needs help
    thus = replace(chosen.plan, anyway=True)
    planned = partial(plan, options=thus, executor=clock.workers, stop=clock.late)
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

    first = best = _Planned(model, planned(model))
    while better := next((one for one in proposals(best) if one.rank < best.rank), None):
        best = better
    if not any(best.rank) and not best.plan.stopped:
        words = "every block is free"
    elif clock.late() or tried >= chosen.most:
        words = f"{clock.reason or 'the limit of changes was reached'} before all was free"
    else:
        words = f"no {'further ' if best.changes else ''}change that is tried needs less help"
    words += f": {counted(len(best.changes), 'joint')} changed, {counted(tried, 'change')} tried"
    if best.changes and any(best.rank):
        words += f"; {best.rank}, before {first.rank}"
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
            words = f"{sign * size:g} degrees; {why}"
            yield block, beside, joint, Kept(kind, ends, words, sign * size)


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
