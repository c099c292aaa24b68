"""An environment of gymnasium per model, several that share a structure, and the planner."""

from __future__ import annotations

from functools import partial
from typing import Any, ClassVar, Unpack

import numpy as np

from drystone.base.arrays import Bools, Ints, whole
from drystone.base.errors import InputError, MissingDependency
from drystone.gym.building import (
    Building,
    BuildingOptions,
    Choice,
    PlacedBlock,
    Reward,
    Site,
    friction_left_reward,
)
from drystone.io.opening import Given, How
from drystone.limits import imperfect
from drystone.sequence import PlanOptions, Structure, plan

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
    that cannot be, a robot holds more than it carries, or nothing can be placed any more.

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
        answer, n = outcome.answer, len(self.structure.model)
        falling = np.zeros(n, dtype=bool)
        if answer is None:
            return {
                "verdict": "",
                "friction_left": 0.0,
                "falling": falling,
                "failed": outcome.failed,
            }
        falling[list(answer.falling)] = True
        return {
            "verdict": answer.verdict.value,
            "friction_left": answer.friction_left,
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
