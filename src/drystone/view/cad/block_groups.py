"""Groups of blocks by their state, as layers and materials of CAD programs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Ints
from drystone.base.display import OneLine
from drystone.view.scenes.scene import Scene, SceneStage
from drystone.view.style.palette import ROLE_COLOUR, STATE_COLOUR, STATE_LABEL, State

NAMES = {State.FREE: "blocks", State.SUPPORT: "supports", State.FALLING: "falling blocks"}


@dataclass(frozen=True, eq=False)
class BlockGroup(OneLine):
    """Blocks that share a layer and a material.

    Attributes
    ----------
    name
    colour
        ``#rrggbb``.
    member : (b,)
    """

    name: str
    colour: str
    member: Ints


def stage_of_scene(scene: Scene, stage: int | None) -> SceneStage:
    """A stage by its number; when left out, the one that a figure shows."""
    return scene.stages[scene.still if stage is None else stage]


def block_groups(stage: SceneStage) -> tuple[BlockGroup, ...]:
    """The blocks in place, by their state; free blocks that need help are a group of their own."""
    state = stage.state
    needy = np.zeros(len(state), dtype=bool)
    if stage.prop is not None:
        needy = (state == State.FREE) & (np.linalg.norm(stage.prop, axis=1) > 0.0)
    groups = []
    for one in State:
        member = np.flatnonzero((state == one) & ~needy)
        if one is not State.ABSENT and len(member):
            name = NAMES.get(one, STATE_LABEL[one])
            groups.append(BlockGroup(name, STATE_COLOUR["light"][one], member))
    if needy.any():
        groups.append(
            BlockGroup("blocks that need help", ROLE_COLOUR["light"]["help"], np.flatnonzero(needy))
        )
    return tuple(groups)


__all__ = ["BlockGroup", "block_groups", "stage_of_scene"]
