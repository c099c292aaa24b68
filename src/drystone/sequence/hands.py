"""Whether hands can hold a group while it is placed block by block."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from drystone.base.arrays import Floats
from drystone.loads import STANDARD_GRAVITY
from drystone.sequence.rules import BoundRules
from drystone.sequence.stages import Stage, StageAnswer, mask_of
from drystone.sequence.states import Node
from drystone.sequence.structure import Structure


def can_hold(
    answer_of: Callable[[Stage], StageAnswer], bound: BoundRules, model: Structure, node: Node
) -> bool:
    """Whether the group of a node can be placed while hands hold its placed blocks.

    Parameters
    ----------
    answer_of
        Function that gives the answer of a stage in between.
    bound
        Payload, and number of hands per block.
    model
    node
    """
    if len(node.group) < 2 or node.parent is None:
        return True
    for stage in _held_stages(node):
        answer = answer_of(stage)
        if not answer.stands or overloads(answer, node.group, bound.limit, model):
            return False
    return True


def overloads(answer: StageAnswer, group: Sequence[int], limit: Floats, model: Structure) -> bool:
    """Whether a hand carries more than its payload while a group is placed.

    Parameters
    ----------
    answer
        Of a stage in between.
    group
    limit : (n,) [kg]
        Mass whose weight the hands of a block can hold.
    model
    """
    load, mass = model.load.wrench, model.assembly.mass
    for block in group:
        if block not in answer.reaction:
            continue
        # without a load: standard gravity
        weight = float(np.linalg.norm(load[block, :3])) / float(mass[block]) or STANDARD_GRAVITY
        force = float(np.linalg.norm(answer.reaction[block][:3]))
        if force > (1.0 + 1e-6) * float(limit[block]) * weight:
            return True
    return False


def _held_stages(node: Node) -> list[Stage]:
    """Stages within a step, backwards: after the removal of each block except the last."""
    placed = node.placed | mask_of(node.group)
    near = (node.placed, node.props)
    out = []
    for number, block in enumerate(node.group[:-1]):
        placed &= ~(1 << block)
        held = node.props | mask_of(node.group[number + 1 :])
        out.append(Stage(placed, held, None, near))
    return out
