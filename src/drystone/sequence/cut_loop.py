"""A monolith cut into blocks until its plan needs no help: cut, plan, and recut where it fails.

Each place has a list of cuts, in the order of preference: the horizontal plane, planes turned about
the horizontal edge across the lean, notches, and the same at other heights. A place takes its first
cut on which the part above stands. The blocks are planned; where one is not free, the loop goes
back to the cut under it and takes the next one. Where a place has no cut left, the place below
takes its next one.

Source: Kao 2023, chapter 7.3 (discretise, check, modify, sequence, and back).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import Options, checked_call
from drystone.model import Model
from drystone.sequence.cuts import Cut, CutDesign, Trial, cut_block, stands_on_cut, tilted_cuts
from drystone.sequence.planner import PlanOptions, plan
from drystone.sequence.plans import Plan, Status

UP = np.array([0.0, 0.0, 1.0])
UPRIGHT = 1e-3
"""Lean, as a share of the height, below which the edge of turned cuts lies along y."""


@dataclass(frozen=True)
class CutOptions(Options):
    """Which cuts are tried at each place.

    Attributes
    ----------
    blocks
        Number of blocks; the lowest is the support.
    friction
    tilts_deg : [degrees]
        Angles by which the plane is turned, each to both sides, after the horizontal plane.
    notches_deg : [degrees]
        Angles of the grooves in which the part above sits, after the planes.
    shifts
        Shares of the height of a block by which the cuts are moved, after those at the place.
    most
        Number of plans after which the loop ends.
    plan
        Options of the plans.
    """

    blocks: int = 4
    friction: float = 0.6
    tilts_deg: tuple[float, ...] = (10.0, 20.0, 30.0)
    notches_deg: tuple[float, ...] = (20.0,)
    shifts: tuple[float, ...] = (-0.2, 0.2)
    most: int = 40
    plan: PlanOptions = field(default_factory=PlanOptions)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_below(2, "blocks")
        self._refuse_below(1, "most")
        self._refuse_below(0.0, "friction")
        for name in ("tilts_deg", "notches_deg"):
            angles = frozen_floats(getattr(self, name), (None,), name)
            if not ((angles > 0.0) & (angles < 60.0)).all():
                raise InputError("angles must lie between 0 and 60 degrees", where=name)
        if not (np.abs(frozen_floats(self.shifts, (None,), "shifts")) < 0.5).all():
            raise InputError("shares must lie between -0.5 and 0.5", where="shifts")


@dataclass(frozen=True, eq=False)
class CutLoop(OneLine):
    """Blocks cut from one shape, and their plan.

    Attributes
    ----------
    design
        The last blocks; None if no cut lets the parts above stand.
    plan
        Of the last blocks; None without ``design``.
    recuts
        Why the loop went back, one sentence each, with the place, from 0.
    message
        How it ended.
    """

    design: CutDesign | None
    plan: Plan | None
    recuts: tuple[tuple[int, str], ...]
    message: str

    @property
    def free(self) -> bool:
        """Whether every block is placed alone and stands at once."""
        return self.plan is not None and not _helped(self.plan)

    def _summary(self) -> str:
        return self.message


@checked_call
def cut_until_free(
    block: Block,
    *,
    options: CutOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> CutLoop:
    """Cut a shape into blocks that are all placed alone and stand at once.

    Parameters
    ----------
    block
        The shape; its lowest part becomes the support.
    options

    Examples
    --------
    >>> from drystone.models import prism
    >>> tower = prism([(0, 0), (1, 0), (1.7, 4), (0.7, 4)], (0, 1), "tower")
    >>> found = cut_until_free(tower)
    >>> found.free, len(found.design.assembly)
    (True, 4)
    """
    chosen = CutOptions.of(options)
    choices = proposed_cuts(block, chosen)
    clock = Clock(time_limit_s, stop)
    first = [0] * len(choices)
    recuts: list[tuple[int, str]] = []
    design: CutDesign | None = None
    found: Plan | None = None
    for done in range(chosen.most):
        if clock.late():
            return CutLoop(design, found, tuple(recuts), f"{clock.reason} before all was free")
        if progress is not None:
            progress("cutting", done, chosen.most)
        made, used, failed = _cut(block, choices, first, chosen)
        if made is None:
            place, why = failed, "on none of its cuts the part above stands"
        else:
            design = made
            model = Model.of(design.assembly, friction=chosen.friction)
            found = plan(model, options=chosen.plan, executor=executor, stop=clock.late)
            helped = _helped(found)
            if not helped:
                count = counted(len(recuts), "recut")
                words = f"every block of {len(design.assembly)} is free after {count}"
                return CutLoop(design, found, tuple(recuts), words)
            place, why = helped
        recuts.append((place, why))
        # without a design, no further cut of this place is left
        used = [*used, *[len(one) for one in choices[len(used) :]]]
        while place >= 0 and used[place] + 1 >= len(choices[place]):
            place -= 1
        if place < 0:
            return CutLoop(design, found, tuple(recuts), "no proposed cuts make every block free")
        first[place:] = [used[place] + 1, *[0] * (len(choices) - place - 1)]
    words = f"not every block is free after {counted(chosen.most, 'plan')}"
    return CutLoop(design, found, tuple(recuts), words)


def proposed_cuts(block: Block, options: CutOptions) -> list[list[Cut]]:
    """Per place, from the bottom up, the cuts in the order of preference."""
    low, high = float(block.vertices[:, 2].min()), float(block.vertices[:, 2].max())
    height = (high - low) / options.blocks
    heights = low + height * np.arange(1, options.blocks)
    middles = [_middle(block, float(z)) for z in heights]
    lean = middles[-1] - _middle(block, low + 0.01 * height)
    lean[2] = 0.0
    leans = float(np.linalg.norm(lean)) > UPRIGHT * (high - low)
    edge = np.cross(UP, lean) if leans else np.array([0.0, 1.0, 0.0])
    turns = [0.0, *(sign * tilt for tilt in options.tilts_deg for sign in (1.0, -1.0))]
    out = []
    for z in heights:
        some: list[Cut] = []
        for shift in (0.0, *options.shifts):
            point = _middle(block, float(z) + shift * height)
            some += tilted_cuts(point, UP, edge, turns)
            some += [Cut(point, UP, notch, edge) for notch in options.notches_deg]
        out.append(some)
    return out


def _middle(block: Block, z: float) -> Floats:
    """The mean corner of the section of a block at a height."""
    above, _ = cut_block(block, Cut(np.array([0.0, 0.0, z]), UP))
    corners = np.concatenate([piece.vertices for piece in above])
    near = np.abs(corners[:, 2] - z) <= 1e-6 * float(np.ptp(block.vertices[:, 2]))
    return np.asarray(np.append(corners[near, :2].mean(axis=0), z))


def _cut(
    block: Block, choices: Sequence[Sequence[Cut]], first: Sequence[int], options: CutOptions
) -> tuple[CutDesign | None, list[int], int]:
    """Blocks, the cut taken at each place, and the place without a cut if there is one."""
    pieces: list[Block] = []
    trials: list[Trial] = []
    used: list[int] = []
    rest = block
    for place, some in enumerate(choices):
        for number in range(first[place], len(some)):
            try:
                above, below = cut_block(rest, some[number])
            except InputError:  # it misses what is left of the block
                continue
            if len(above) > 1 or len(below) > 1:
                continue
            result = stands_on_cut(below[0], above[0], options.friction)
            trials.append(Trial(place, some[number], result))
            if result.stable:
                pieces.append(below[0].renamed(f"c{place:02d}-block"))
                rest = above[0]
                used.append(number)
                break
        else:
            return None, used, place
    pieces.append(rest.renamed(f"c{len(choices):02d}-block"))
    assembly = Assembly(tuple(pieces), np.arange(len(pieces)) == 0)
    return CutDesign(assembly, tuple(trials)), used, len(choices)


def _helped(found: Plan) -> tuple[int, str] | None:
    """The cut under the lowest block that is not free, and why; None if all are free."""
    names = found.model.assembly.names
    if not found.steps:
        falling = found.complete.falling
        place = min(falling) if falling else len(names) - 1
        return max(0, place - 1), f"{names[place]}: {found.message}"
    for block, status in enumerate(found.status):
        if status in (Status.HELD, Status.PROPPED, Status.IMPOSSIBLE):
            why = found.impossible.get(block, found.steps[found.step_of.get(block, 0)].why)
            return max(0, block - 1), f"{names[block]} is {status.value}: {why}"
    bad = next((one for one in found.steps if not one.answer.stands), None)
    if bad is None:
        return None
    return max(0, bad.blocks[-1] - 1), f"{names[bad.blocks[-1]]}: {bad.answer.message}"
