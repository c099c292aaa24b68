"""Environments of gymnasium for those who learn to build: a model is put up block by block.

The extra ``gym`` installs gymnasium. ``gymnasium.make("drystone.gym:drystone/Assembly-v0",
given=model)`` makes one too.

A hand or a robot places a block and lets it go, or holds it. When a block is let go, all that are
held are let go with it, as the blocks of a step of a plan are. When a hand is needed for the next
block, the one held longest is let go, as robots that take turns do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, NamedTuple, TypeAlias, Unpack

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, frozen, frozen_floats, marked, unit, whole
from drystone.base.errors import InputError, MissingDependency
from drystone.base.settings import Options
from drystone.io.opening import Given, How
from drystone.limits import Imperfections, imperfect
from drystone.sequence import (
    PlanOptions,
    RemovalTest,
    Rules,
    StageAnswer,
    StagedModel,
    Structure,
    plan,
)
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
        bound: BoundRules = bind(options.rules, self.staged, self.removal)
        self.bound = bound.without_what_falls(lambda left: structure.stands([*members(left)]))
        self.blocks = tuple(members(self.bound.there & ~self.bound.core))
        if not self.blocks:
            raise InputError("there is no block to place", remedy="leave some out of the supports")
        self.before = [0] * len(structure.model)  # per block those that come first
        for first in self.blocks:
            for then in members(self.bound.after[first]):
                self.before[then] |= 1 << first
        self.shape = (
            len(self.blocks), max(1, len(options.directions)), max(1, len(options.rules.robots)),
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
            if len(bound.able):
                busy = np.isin(np.arange(len(bound.able)), [*self.held.values()])
                robots = bound.able[:, block] & ~busy
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
        whole = self.placed == site.bound.there
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


try:
    import gymnasium
    from gymnasium.spaces import Discrete, MultiDiscrete
    from gymnasium.vector import SyncVectorEnv
except ImportError as error:
    raise MissingDependency("gymnasium", extra="gym", purpose="environments") from error


class AssemblyEnv(gymnasium.Env):  # type: ignore[misc]  # gymnasium is not there for every check
    """A structure that is put up block by block.

    An action is a block to place, with the way in, the robot and whether it is held, where there is
    a choice; :meth:`action` makes one. An observation is the state (n,) of each block to place: 0
    is not there, 1 in place, 2 held by a hand, 2 + r held by robot r. An episode ends when all are
    in place and none is held; or with a failure: a stage is not shown to stand, a block is placed
    that cannot be, a robot holds more than it carries (less may do), or nothing can be placed any
    more.

    ``info`` has ``action_mask`` (a,), of the actions that are possible; after a step also
    ``verdict``, that of :func:`drystone.check` on what is in place, ``friction_left``,
    ``falling`` (n,) and ``failed``, the reason.

    Parameters
    ----------
    given
        A structure, whose answers are shared; or a model, an assembly or a file that ``how`` turns
        into one.
    options
    reward
        The reward of the outcome of a step.

    Examples
    --------
    >>> from drystone.models import tower
    >>> env = AssemblyEnv(tower(3))
    >>> state, info = env.reset(seed=0)
    >>> state.tolist(), np.flatnonzero(info["action_mask"]).tolist()
    ([0, 0], [0, 1, 3])
    >>> state, reward, ended, cut, info = env.step(env.action("block-1"))
    >>> state.tolist(), ended, info["verdict"]
    ([1, 0], False, 'stable')
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(
        self,
        given: Structure | Given,
        *,
        options: BuildingOptions | None = None,
        reward: Reward = friction_left_reward,
        **how: Unpack[How],
    ) -> None:
        structure = given if isinstance(given, Structure) else Structure(given, **how)
        self.structure, self.options = structure, BuildingOptions.of(options)
        self.reward = reward
        self.site = Site(structure, self.options)
        self._building = Building(self.site, structure)
        count = len(self.site.blocks)
        self.action_space = Discrete(int(np.prod(self.site.shape)))
        self.observation_space = MultiDiscrete([2 + self.site.shape[2]] * count)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Ints, dict[str, Any]]:
        """Begin anew; with ``noise`` joints are drawn again."""
        super().reset(seed=seed, options=options)
        structure, noise = self.structure, self.options.noise
        if noise is not None:
            model = structure.model
            drawn = imperfect(model.contacts, noise, int(self.np_random.integers(2**32)))
            structure = Structure(
                model.with_contacts(drawn), robust=structure.robust, each_s=structure.each_s,
                kept=structure.kept,
            )  # fmt: skip
        self._building = Building(self.site, structure)
        return self._building.state, {"action_mask": self.action_masks().astype(np.int8)}

    def step(self, action: int) -> tuple[Ints, float, bool, bool, dict[str, Any]]:
        """Place a block."""
        outcome = self._building.place(int(action))
        info = {"action_mask": self.action_masks().astype(np.int8), **self._told(outcome)}
        ended = self._building.done
        return self._building.state, float(self.reward(outcome)), ended, False, info

    def action_masks(self) -> Bools:
        """Which actions (a,) are possible; of all of them an ended episode has none."""
        return self._building.mask

    def action(self, block: str | int, direction: int = 0, robot: int = 0, hold: int = 0) -> int:
        """The action that places a block, by its name or position in the model.

        Raises
        ------
        InputError
            It is not among the blocks to place, or there is no such direction, robot or hold.
        """
        (position,) = self.site.staged.assembly.indices([block]).tolist()
        if position not in self.site.blocks:
            raise InputError(f"'{block}' is no block to place", remedy="give one that is not fixed")
        chosen = Choice(self.site.blocks.index(position), direction, robot, int(hold))
        for name, one, most in zip(chosen._fields, chosen, self.site.shape, strict=True):
            if not 0 <= whole(one, name) < most:
                raise InputError(f"{name} is {one}", remedy=f"give 0 to {most - 1}")
        return self.site.action(chosen)

    def _told(self, outcome: PlacedBlock) -> dict[str, Any]:
        answer = outcome.answer
        falling = marked([] if answer is None else list(answer.falling), len(self.structure.model))
        return {
            "verdict": "" if answer is None else answer.verdict.value,
            "friction_left": 0.0 if answer is None else answer.friction_left,
            "falling": falling,
            "failed": outcome.failed,
        }


def assembly_envs(
    given: Structure | Given,
    count: int,
    *,
    options: BuildingOptions | None = None,
    reward: Reward = friction_left_reward,
    **how: Unpack[How],
) -> SyncVectorEnv:
    """Environments side by side, as a vector environment; what one finds out all of them know.

    Parameters
    ----------
    given
        As of :class:`AssemblyEnv`.
    count
        Number of environments.
    """
    whole(count, "count", least=1)
    structure = given if isinstance(given, Structure) else Structure(given, **how)
    return SyncVectorEnv([partial(AssemblyEnv, structure, options=options, reward=reward)] * count)


def expert_actions(env: AssemblyEnv) -> list[int]:
    """The order of the planner as actions, from the beginning of an episode without noise.

    Raises
    ------
    InputError
        There is no plan, or none without props, or a block of it cannot be placed as asked.
    """
    names = env.structure.model.assembly.names
    found = plan(env.structure.model, options=PlanOptions(rules=env.options.rules))
    if not found.stable or found.props:
        props = ", ".join(f"'{names[one.block]}'" for one in found.props[:3])
        why = f"it props {props}" if props else found.message
        raise InputError(f"the planner has no order for hands alone: {why}", remedy="allow more")
    site = env.site
    building, actions = Building(site, env.structure), []
    for step in found.steps:
        for block, motion in zip(step.blocks, step.motion, strict=True):
            able = building.mask.reshape(site.shape)[site.blocks.index(block)]
            hold = int(block != step.blocks[-1])
            ways = able[:, :, hold].any(axis=1) if hold < site.shape[3] else np.zeros(1, dtype=bool)
            if not ways.any():
                said = f"the planner places '{names[block]}' in another way"
                raise InputError(said, remedy="give more directions or hands")
            near = site.ways @ motion if len(site.ways) else np.ones(1)
            way = int(np.argmax(np.where(ways, near, -np.inf)))
            robot = int(np.argmax(able[way, :, hold]))
            actions.append(site.action(Choice(site.blocks.index(block), way, robot, hold)))
            building.place(actions[-1])
    return actions


gymnasium.register("drystone/Assembly-v0", entry_point=AssemblyEnv)

__all__ = [
    "AssemblyEnv",
    "BuildingOptions",
    "PlacedBlock",
    "assembly_envs",
    "expert_actions",
    "friction_left_reward",
]
