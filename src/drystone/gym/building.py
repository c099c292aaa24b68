"""A structure that is put up block by block: what may be placed, and what comes of it.

A hand or a robot places a block and lets it go, or holds it. When a block is let go, all that are
held are let go with it, as the blocks of a step of a plan are. When a hand is needed for the next
block, the one held longest is let go, as robots that take turns do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, frozen, frozen_floats, unit
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.limits import Imperfections
from drystone.sequence import RemovalTest, Rules, StageAnswer, StagedModel, Structure
from drystone.sequence.rules import BoundRules, bind
from drystone.sequence.stage_tree import overloads
from drystone.sequence.stages import members


@dataclass(frozen=True)
class BuildingOptions(Options):
    """What is chosen with a block, and how exactly it is placed.

    Attributes
    ----------
    rules
        Hands or robots and what they lift; what comes before what; blocks that are there at first.
        The order is that of the learner. With one hand nothing is held. With robots the action says
        which one places the block.
    directions : (d, 3)
        Motions into place, one of which is chosen with a block, such as ``[(0, 0, -1)]`` for those
        from above. When left out, a block can be placed where any motion is free.
    noise
        Each episode draws joints with these imperfections: ``Imperfections(tolerance=0.001)`` is
        blocks that are placed, or made, a millimetre off.
    """

    rules: Rules = field(default_factory=Rules)
    directions: Sequence[Sequence[float]] = ()
    noise: Imperfections | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (isinstance(self.directions, Sequence) and len(self.directions) == 0):
            found, length = unit(frozen_floats(self.directions, (None, 3), "directions"))
            if not (length > 0.0).all():
                raise InputError("a direction has no length", remedy="leave it out")
            object.__setattr__(self, "directions", tuple(map(tuple, found.tolist())))


class Choice(NamedTuple):
    """What an action means: positions among free blocks, directions and robots."""

    block: int
    direction: int = 0
    robot: int = 0
    hold: int = 0


@dataclass(frozen=True, eq=False)
class PlacedBlock:
    """What comes of an action.

    Attributes
    ----------
    share
        One by the number of blocks to place.
    complete
        Whether every block is in place, and none is held.
    failed
        Why the episode ends without that; else empty.
    answer
        Whether it stands; None where nothing was placed.
    """

    share: float
    complete: bool
    failed: str
    answer: StageAnswer | None


Reward: TypeAlias = Callable[[PlacedBlock], float]


def friction_left_reward(outcome: PlacedBlock) -> float:
    """The friction left by the number of blocks; 1 more when complete, and -1 for a failure.

    It is a share, as in :class:`drystone.sequence.StageAnswer`. What is not shown to stand is a
    failure.
    """
    if outcome.failed or outcome.answer is None:
        return -1.0
    return outcome.share * outcome.answer.friction_left + float(outcome.complete)


class Site:
    """A structure, and the rules by which it is put up."""

    def __init__(self, structure: Structure, options: BuildingOptions) -> None:
        self.structure, self.options = structure, options
        self.ways: Floats = np.array(options.directions, dtype=np.float64).reshape(-1, 3)
        self.staged = StagedModel(structure.model)
        self.removal = RemovalTest(self.staged)
        self.bound: BoundRules = bind(options.rules, self.staged, self.removal)
        self.blocks = tuple(members(self.staged.everything & ~self.bound.core))
        if not self.blocks:
            raise InputError("there is no block to place", remedy="leave some out of the supports")
        self.before = [0] * len(structure.model)  # per block those that come first
        for first in self.blocks:
            for then in members(self.bound.after[first]):
                self.before[then] |= 1 << first
        robots, assembly = options.rules.robots, self.staged.assembly
        able = [robot.manages(assembly.centroid, assembly.mass) for robot in robots]
        self.able: Bools = np.array(able).reshape(len(robots), len(assembly))
        self.shape = (
            len(self.blocks), max(1, len(options.directions)), max(1, len(robots)),
            1 + (self.bound.hands > 1),
        )  # fmt: skip

    def choice(self, action: int) -> Choice:
        """What an action means."""
        return Choice(*(int(one) for one in np.unravel_index(action, self.shape)))

    def action(self, choice: Choice) -> int:
        """The number of a choice."""
        return int(np.ravel_multi_index(choice, self.shape))

    def free_ways(self, block: int, placed: int) -> Bools:
        """Whether a block can be moved in among others on each way (d,)."""
        if not len(self.ways):
            return np.array([self.removal.free(block, placed)])
        return self.removal.leaves(block, placed, -self.ways)


class Building:
    """The blocks in place and those held, in one episode.

    Parameters
    ----------
    site
    structure
        What is asked whether it stands; that of the site, or one with other joints.
    """

    def __init__(self, site: Site, structure: Structure) -> None:
        self.site, self.structure = site, structure
        self.placed = site.bound.core
        self.held: dict[int, int] = {}  # block: its robot, the one held longest first
        self.done = False
        self.mask: Bools = self._allowed()

    @property
    def state(self) -> Ints:
        """Of each block (n,): 0 is not there, 1 in place, 2 held, or 2 + its robot."""
        return np.array(
            [2 + self.held[b] if b in self.held else self.placed >> b & 1 for b in self.site.blocks]
        )

    def _hands(self, blocks: Sequence[int]) -> int:
        return int(self.site.bound.lifters[blocks].sum()) if blocks else 0

    def _allowed(self) -> Bools:
        """Which actions (a,) are possible: nothing is in the way, and a hand is free."""
        site, bound = self.site, self.site.bound
        out = np.zeros(site.shape, dtype=bool)
        idle = bound.hands - self._hands([*self.held])
        for number, block in enumerate(site.blocks):
            if self.placed >> block & 1 or site.before[block] & ~self.placed:
                continue
            ways = site.free_ways(block, self.placed | 1 << block)
            robots = np.array([bound.lifters[block] <= idle])
            if len(site.able):
                busy = np.isin(np.arange(len(site.able)), [*self.held.values()])
                robots = site.able[:, block] & ~busy
            here = ways[:, None] & robots
            near = site.staged.neighbours[block] & self.placed
            out[number, :, :, 0] = here & bool(near or site.staged.grounds[block])
            if site.shape[3] > 1:
                out[number, :, :, 1] = here & (bound.lifters[block] < bound.hands)
        return frozen(out.reshape(-1))

    def place(self, action: int) -> PlacedBlock:
        """Place a block."""
        site, share = self.site, 1.0 / len(self.site.blocks)
        if not self.mask[action]:
            return self._ended(PlacedBlock(share, False, "the block cannot be placed", None))
        choice = site.choice(action)
        block = site.blocks[choice.block]
        self.placed |= 1 << block
        if choice.hold:
            self.held[block] = choice.robot
            while self._hands([*self.held]) >= site.bound.hands:
                del self.held[next(iter(self.held))]
        else:
            self.held.clear()
        answer = self.structure.stands([*members(self.placed)], held=[*self.held])
        failed = "" if answer.stands else answer.message or "it falls"
        if overloads(answer, [*self.held], site.bound.limit, site.staged):
            failed = "a held block is too heavy"
        whole = self.placed == site.staged.everything
        complete = whole and not self.held and not failed
        if failed or complete:
            return self._ended(PlacedBlock(share, complete, failed, answer))
        self.mask = self._allowed()
        if not self.mask.any():
            failed = "blocks are held at the end" if whole else "no other block can be placed"
            return self._ended(PlacedBlock(share, False, failed, answer))
        return PlacedBlock(share, False, "", answer)

    def _ended(self, outcome: PlacedBlock) -> PlacedBlock:
        self.done, self.mask = True, frozen(np.zeros_like(self.mask))
        return outcome
