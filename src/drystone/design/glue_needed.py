"""The least glue with which a region stands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Ints
from drystone.base.display import OneLine
from drystone.design.missing import Glue, least
from drystone.design.props import LARGE_REGION, SMALL_REGION, quickly_stands
from drystone.joint_capacity import JointCapacity
from drystone.model import Model

STRONGEST = 10.0
"""Largest tried strength of glue in one joint, relative to the weight of the region; of the same
glue in all joints that pull, relative to the largest pull there. Chosen."""


@dataclass(frozen=True, eq=False)
class GlueTrial(OneLine):
    """Joints of a local model that can be glued, and the strengths [N] to try.

    Attributes
    ----------
    interfaces
    most
        Largest strength.
    close
        Accuracy of the least strength.
    """

    interfaces: tuple[int, ...]
    most: float
    close: float


def glue_trials(model: Model, count: int, pulling: Sequence[tuple[int, float]]) -> list[GlueTrial]:
    """Joints of a local model to be glued: of two blocks each; in a larger region all that pull.

    Parameters
    ----------
    model
    count
        Number of blocks of the region, the first ones of the model.
    pulling
        The interfaces that pull, and their forces [N].
    """
    contacts = model.contacts
    if count <= SMALL_REGION:
        weight = float(np.linalg.norm(model.load.wrench[:count, :3].sum(axis=0)))
        pairs = list(zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True))
        return [
            GlueTrial(
                tuple(k for k, other in enumerate(pairs) if other == pair),
                STRONGEST * weight,
                0.01 * weight,
            )
            for pair in dict.fromkeys(pairs)
        ]
    if not pulling:
        return []
    most = max(force for _, force in pulling)
    close = (0.1 if count > LARGE_REGION else 0.02) * most
    return [GlueTrial(tuple(k for k, _ in pulling), STRONGEST * most, close)]


def glue_needed(
    model: Model,
    count: int,
    pulling: Sequence[tuple[int, float]],
    stop: Callable[[], bool] | None = None,
) -> tuple[Glue, ...]:
    """The glue with which a local model stands, the least strength first; parameters as above."""
    found = []
    for trial in glue_trials(model, count, pulling):

        def stands(strength: float, joints: tuple[int, ...] = trial.interfaces) -> bool:
            return quickly_stands(glued(model, np.array(joints), strength), stop)

        strength = least(stands, 0.0, trial.most, trial.close)
        if strength is not None:
            found.append(Glue(trial.interfaces, strength))
    return tuple(sorted(found, key=lambda glue: glue.strength))


def glued(model: Model, joints: Ints, strength: float) -> Model:
    """The model with glue in some joints, each of a strength [N] against pull and against shear."""
    before = model.contacts.capacity or JointCapacity.of(model.contacts)
    tension, cohesion = np.array(before.tension), np.array(before.cohesion)
    tension[joints] = np.maximum(tension[joints], strength)
    cohesion[joints] = np.maximum(cohesion[joints], strength)
    return model.with_capacity(JointCapacity(tension, cohesion, before.shear))
