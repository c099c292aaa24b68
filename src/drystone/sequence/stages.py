"""Stages: blocks in place, held blocks, the answer whether the stage stands, and who gives it.

A stage is two sets of free blocks, stored as bits of integers. Supports are always in place. A held
block is held by a prop, a hand or a robot; it counts as fixed.

The complete structure: which blocks touch, which are connected, and how high they are.

Blocks that are not connected through free blocks do not influence each other. So a stage is divided
into connected parts. Each part is checked and cached separately: after the removal of a block only
its part is checked again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Clock
from drystone.loads import LoadCase
from drystone.model import Model, OfModel
from drystone.results import Result, Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability import PATIENT, CheckOptions, Screening, try_rest
from drystone.stability.asked import Asked
from drystone.stability.attempts import Candidate
from drystone.stability.problem import UNBALANCED, Problem
from drystone.stability.verdict import decided


class Stage(NamedTuple):
    """Blocks in place and, among them, those that are held; one bit per block.

    A ``quick`` look replaces the check: it can prove that the stage stands, not that it falls. Both
    may start from the rest state of a similar stage ``near``, given by its blocks in place and held
    blocks.
    """

    placed: int
    held: int = 0
    quick: bool = False
    near: tuple[int, int] | None = None

    def __repr__(self) -> str:
        return f"Stage({self.placed.bit_count()} blocks in place, {self.held.bit_count()} held)"


def mask_of(blocks: Iterable[int]) -> int:
    """The set of some blocks as the bits of an integer.

    Examples
    --------
    >>> mask_of([0, 2])
    5
    """
    mask = 0
    for block in blocks:
        mask |= 1 << int(block)
    return mask


def members(mask: int) -> Iterator[int]:
    """The blocks of a set, ascending.

    Examples
    --------
    >>> list(members(5))
    [0, 2]
    """
    while mask:
        lowest = mask & -mask
        yield lowest.bit_length() - 1
        mask ^= lowest


@dataclass(frozen=True, eq=False)
class StageAnswer(OneLine):
    """Whether a stage, or one part of it, stands.

    Attributes
    ----------
    verdict
    message
    falling
        Positions of the blocks that fall.
    reaction : block to (6,) [N, N m]
        Force on each held block, and moment about its centroid. In a part it balances the contact
        forces only; in a stage also the load of the block. Joints between two held or fixed blocks
        carry no force, so this is an upper bound.
    used
        Largest share of what a joint bears along its face that the sum of its forces needs. Joints
        with hardly any force are left out.
    corner : (c,)
        Corners of the whole model with ``force`` (c, 3) [N]; empty if not kept.
    settled
        Result of following the blocks, where contact stiffness decides; else empty.
    rest : (b, 6) [m, rad]
        Rest state of a part, as a start for similar stages: displacements of its moving blocks,
        ascending; empty if not kept.
    uniform
        The rest state of a part with uniform stiffness, where a quick look found it.
    motion : (b, 6) [m, rad]
        Mechanism of a part that falls, of its moving blocks, ascending; empty if not kept.
    missing : (b, 6) [N, N m]
        What its moving blocks missed at first, where it was followed and those that fell moved
        alone; else empty.
    sensitive
        Whether it stands only for some of the contact stiffnesses tried, or after settling.
    """

    verdict: Verdict
    message: str = ""
    falling: tuple[int, ...] = ()
    reaction: Mapping[int, Floats] = field(default_factory=dict)
    used: float = 0.0
    corner: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    force: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    rest: Floats = field(default_factory=lambda: np.zeros((0, 6)))
    settled: str = ""
    uniform: Candidate | None = None
    motion: Floats = field(default_factory=lambda: np.zeros((0, 6)))
    missing: Floats = field(default_factory=lambda: np.zeros((0, 6)))
    sensitive: bool = False

    @property
    def friction_left(self) -> float:
        """Share left of the friction of its most used joint, 0 to 1; 0 if it falls, else NaN."""
        if self.verdict is Verdict.UNDECIDED:
            return float("nan")
        return max(0.0, 1.0 - self.used) if self.stands else 0.0

    @property
    def stands(self) -> bool:
        """Whether the verdict is STABLE."""
        return self.verdict is Verdict.STABLE


Check: TypeAlias = Callable[[Model], Result]
"""Gives the verdict on a model. Other processes must be able to import it."""

ALIKE = "it begins to fall as a part did that was followed and fell"

SMOOTHLY = PATIENT.with_slip_lengths(10.0)
"""Slip length by the local overlap. At a friction coefficient of 0.84 the smooth law then begins
about as stiff as the stick-slip law."""


@dataclass(frozen=True)
class StageCheck:
    """The verdict of :func:`drystone.check` on a stage, which may begin at a known rest state.

    A stage that must stand with uniform stiffness also does so if a rest state with the smooth
    friction law leads to it. Measured on the bridge of the source at friction 0.5 to 1.0: of four
    stages of its order without help no other one is found.

    Attributes
    ----------
    options
    each_s : [s]
        Time limit of every check; what is not decided until then is UNDECIDED.
    brief
        Where a similar stage stands and this one does not rest near it, ask for a mechanism first.
        It is the answer then: which blocks would fall freely is not looked for. Where there is none
        few blocks begin with the forces that balance the loads.
    """

    options: CheckOptions = field(default_factory=CheckOptions)
    each_s: float = float("inf")
    brief: bool = False

    def __call__(self, model: Model) -> Result:
        """The verdict on a model."""
        return self.begun_at(Problem.build(model))

    @one_blas_thread()
    def begun_at(
        self,
        problem: Problem,
        near: Floats | None = None,
        rest: Candidate | None = None,
        missing: Sequence[Floats] = (),
    ) -> Result:
        """The verdict on the problem of a stage.

        Parameters
        ----------
        problem
        near : (n, 6) [m, rad]
            The rest state of a similar stage: one with a block more or less has almost the same.
            Not used where joints pull: what is found then has the rounding of its start, and
            which stages are known depends on the executor.
        rest
            The rest state with uniform stiffness, where it is known already.
        missing : each (n, 6) [N, N m]
            What blocks missed that fell when similar stages were followed. Where they begin to
            fall alike here, a brief check ends with that.
        """
        asked = Asked(problem, self.options, Clock(self.each_s))
        near = near if problem.statics.dry else None
        if self.brief and near is not None and rest is None:
            attempt = asked.attempt()
            rest, start, near = attempt.begun_at(near), near, None
            for missed in missing if rest is None else ():
                alike = asked.attempt().begun_to_fall(start, missed)
                if alike is not None:
                    return asked.unstable(ALIKE, *alike)
            motion = asked.falls_alone(attempt.last.motion) if rest is None else None
            motion = asked.collapse if rest is None and motion is None else motion
            if motion is not None:
                return asked.unstable(UNBALANCED, motion)
            if rest is None and problem.equilibrium_first and not problem.has_light:
                rest = asked.attempt().from_balance(asked.balance)
        found = decided(asked, near=near, rest=rest)
        shown = found.verdict is not Verdict.UNDECIDED or found.samples.standing > 0
        if shown or not self.options.uniform:
            return found
        smooth = try_rest(problem, screening=SMOOTHLY, start=near, time_limit_s=self.each_s)
        if not smooth.stable:
            return found
        followed = Asked(problem, replace(self.options, uniform=False), Clock(self.each_s))
        return decided(followed, near=smooth.displacement)


def check_once(model: Model, start: Floats | None = None) -> Result:
    """The verdict with uniform contact stiffness; ``start`` as in :func:`drystone.check`.

    Parameters
    ----------
    model
        Is not changed.
    start : (n, 6) [m, rad]
        ``displacement`` of the result of a similar model with the same blocks; it saves time.
    """
    once = StageCheck(CheckOptions(samples=0, settle=False))
    return once.begun_at(Problem.build(model), start)


check_both = StageCheck(CheckOptions(uniform=True))
"""Stands with uniform contact stiffness, and by the verdict of :func:`drystone.check`.

The default for stages of a plan. A stage that falls with uniform stiffness is not relied upon,
although it may stand after settling. Where it slides far, settlement decides."""

check_thoroughly = StageCheck()
"""The verdict of :func:`drystone.check`; settlement where contact stiffness decides."""

CHECKED = 1000
"""Most corners of a connected part with which every stage of a plan is checked, also where a quick
look shows that it stands, and with which the complete structure may stand after settling."""


@dataclass(frozen=True, eq=False)
class StagedModel(OfModel, OneLine):
    """The complete model, and how its stages are checked.

    Attributes
    ----------
    model
    check
        Function that gives the verdict on a stage.
    quick
        How a stage is looked at before its check; None: it is checked at once.
    """

    model: Model
    check: Check = check_both
    quick: Screening | None = None

    def __post_init__(self) -> None:
        self.model.require_still()
        if not self.assembly.fixed.any():
            raise InputError("no block is fixed", remedy="fix the supports")

    @property
    def load(self) -> LoadCase:
        """The load of the model."""
        return self.model.load

    @cached_property
    def everything(self) -> int:
        """The set of all free blocks."""
        return mask_of(self.assembly.free.tolist())

    @cached_property
    def _touching(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Per block the sets of free blocks and of supports that touch it."""
        free, grounds = [0] * len(self.assembly), [0] * len(self.assembly)
        pairs = zip(self.contacts.block_a.tolist(), self.contacts.block_b.tolist(), strict=True)
        fixed = self.assembly.fixed.tolist()
        for a, b in pairs:
            (grounds if fixed[b] else free)[a] |= 1 << b
            (grounds if fixed[a] else free)[b] |= 1 << a
        return tuple(free), tuple(grounds)

    @property
    def neighbours(self) -> tuple[int, ...]:
        """Per block the set of free blocks that touch it."""
        return self._touching[0]

    @property
    def grounds(self) -> tuple[int, ...]:
        """Per block the set of supports that touch it."""
        return self._touching[1]

    @cached_property
    def up(self) -> Floats:
        """Unit vector (3,) opposite to the total load; z if there is no load."""
        total = self.load.wrench[self.assembly.free, :3].sum(axis=0)
        size = float(np.linalg.norm(total))
        return -total / size if size > 0.0 else np.array([0.0, 0.0, 1.0])

    @cached_property
    def height(self) -> Floats:
        """Heights (n,) [m] of the centroids, opposite to the load."""
        return self.assembly.centroid @ self.up

    def around(self, blocks: int) -> int:
        """The set of free blocks that touch some blocks."""
        near = 0
        for block in members(blocks):
            near |= self.neighbours[block]
        return near

    def _reached(self, start: int, within: int) -> int:
        """The set of blocks that are connected to some blocks through blocks of a set."""
        near, reached, left = self.neighbours, start, start
        while left:
            lowest = left & -left
            new = near[lowest.bit_length() - 1] & within & ~reached
            reached |= new
            left ^= lowest | new
        return reached

    def parts(self, stage: Stage) -> list[Stage]:
        """The connected parts of a stage, each with its adjacent held blocks."""
        left = moving = stage.placed & ~stage.held
        out = []
        while left:
            reached = self._reached(left & -left, moving)
            held = self.around(reached) & stage.held
            out.append(Stage(reached | held, held, stage.quick, stage.near))
            left &= ~reached
        return out

    def cut_out(self, stage: Stage) -> tuple[Model, Ints]:
        """The model of a stage, its held blocks fixed, and the positions of its blocks."""
        fixed = np.flatnonzero(self.assembly.fixed).tolist()
        blocks = np.array(sorted([*fixed, *members(stage.placed)]), dtype=np.intp)
        resting = self.model.with_supports([*fixed, *members(stage.held)])
        return resting.subset(blocks), blocks

    @cached_property
    def largest(self) -> tuple[int, int]:
        """Most free blocks and most corners of a connected part of the complete structure."""
        part = np.full(len(self.assembly), -1)
        for number, one in enumerate(self.parts(Stage(self.everything))):
            part[list(members(one.placed))] = number
        joined = np.maximum(part[self.contacts.block_a], part[self.contacts.block_b])
        corners = joined[self.contacts.interface]
        blocks, points = np.bincount(part[part >= 0]), np.bincount(corners[corners >= 0])
        return int(blocks.max(initial=0)), int(points.max(initial=0))

    @property
    def small(self) -> bool:
        """Whether every stage of a plan is checked."""
        return self.largest[1] <= CHECKED

    def floating(self, placed: int) -> int:
        """Blocks in place that are not connected to a support through blocks in place."""
        return placed & ~self._reached(placed & self.grounded, placed)

    @cached_property
    def grounded(self) -> int:
        """Free blocks that touch a support."""
        return mask_of(b for b in self.assembly.free.tolist() if self.grounds[b])
