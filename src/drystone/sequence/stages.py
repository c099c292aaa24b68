"""Stages: blocks in place, held blocks, the answer whether the stage stands, and who gives it.

A stage is two sets of free blocks, stored as bits of integers. Supports are always in place. A held
block is held by a prop, a hand or a robot; it counts as fixed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.progress import Clock
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability import PATIENT, CheckOptions, check, try_rest
from drystone.stability.asked import Asked
from drystone.stability.attempts import Candidate
from drystone.stability.problem import Problem
from drystone.stability.screening import SLIP_LENGTH
from drystone.stability.verdict import UNBALANCED, decided


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


SMOOTHLY = PATIENT.with_slip_lengths(SLIP_LENGTH)


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
        It is the answer then: which blocks would fall freely is not looked for.
    """

    options: CheckOptions = field(default_factory=CheckOptions)
    each_s: float = float("inf")
    brief: bool = False

    def __call__(self, model: Model) -> Result:
        """The verdict on a model."""
        return self.begun_at(Problem.build(model))

    @one_blas_thread()
    def begun_at(
        self, problem: Problem, near: Floats | None = None, rest: Candidate | None = None
    ) -> Result:
        """The verdict on the problem of a stage.

        Parameters
        ----------
        problem
        near : (n, 6) [m, rad]
            The rest state of a similar stage: one with a block more or less has almost the same.
        rest
            The rest state with uniform stiffness, where it is known already.
        """
        asked = Asked(problem, self.options, Clock(self.each_s))
        if self.brief and near is not None and rest is None and problem.statics.dry:
            rest, near = asked.attempt().begun_at(near), None
            if rest is None and asked.collapse is not None:
                return asked.unstable(UNBALANCED, asked.collapse)
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
    """The verdict with uniform contact stiffness; ``start`` as in :func:`drystone.check`."""
    return check(model, options=CheckOptions(samples=0, settle=False), start=start)


check_both = StageCheck(CheckOptions(uniform=True))
"""Stands with uniform contact stiffness, and by the verdict of :func:`drystone.check`.

The default for stages of a plan. A stage that falls with uniform stiffness is not relied upon,
although it may stand after settling. Where it slides far, settlement decides."""

check_thoroughly = StageCheck()
"""The verdict of :func:`drystone.check`; settlement where contact stiffness decides."""
