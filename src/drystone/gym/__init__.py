"""Environments of gymnasium for those who learn to build: a model is put up block by block.

The extra ``gym`` installs gymnasium. ``gymnasium.make("drystone.gym:drystone/Assembly-v0",
given=model)`` makes one too.
"""

from drystone.gym.assembly_env import (
    AssemblyEnv,
    BuildingOptions,
    PlacedBlock,
    assembly_envs,
    expert_actions,
    friction_left_reward,
)

__all__ = [
    "AssemblyEnv",
    "BuildingOptions",
    "PlacedBlock",
    "assembly_envs",
    "expert_actions",
    "friction_left_reward",
]
