"""A stage of some blocks as one of more blocks: the others are absent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from drystone.answer.scene import Layer, SceneStage, State
from drystone.assembly import Assembly
from drystone.base.arrays import Ints
from drystone.contacts import Contacts, joined_contacts
from drystone.model import Model


def stage_among(
    stage: SceneStage, blocks: int, contacts: Contacts, kept: Ints, interface: Ints
) -> SceneStage:
    """A stage of some blocks as one of all blocks.

    Parameters
    ----------
    stage
    blocks, contacts
        Number of all blocks, and all their interfaces.
    kept, interface : (s,), (j,)
        Positions of the blocks and interfaces of the stage among all.
    """
    here = np.zeros(contacts.count, dtype=bool)
    here[interface] = True
    corner = np.flatnonzero(here[contacts.interface])
    count = {"block": blocks, "interface": contacts.count, "corner": contacts.corner_count}
    place = {"block": kept, "interface": interface, "corner": corner}

    def spread(values: Any, kind: str) -> Any:
        if values is None:
            return None
        out = np.zeros((count[kind], *values.shape[1:]), dtype=values.dtype)
        out[place[kind]] = values
        return out

    path = None
    if stage.path is not None:
        path = np.zeros((len(stage.path), blocks, 6))
        path[:, kept] = stage.path
    state = np.full(blocks, State.ABSENT, dtype=np.intp)
    state[kept] = stage.state
    return replace(
        stage,
        state=state,
        motion=spread(stage.motion, "block"),
        path=path,
        prop=spread(stage.prop, "block"),
        force=spread(stage.force, "corner"),
        layers=tuple(_layer_among(layer, interface, kept) for layer in stage.layers),
        **{
            name: spread(getattr(stage, name), "interface")
            for name in ("normal", "tangential", "utilisation", "pressure_centre")
        },
    )


def _layer_among(layer: Layer, interface: Ints, kept: Ints) -> Layer:
    return replace(
        layer,
        interface=None if layer.interface is None else interface[layer.interface],
        block=None if layer.block is None else kept[layer.block],
    )


def side_by_side(
    models: Sequence[Model], stages: Sequence[SceneStage], names: Sequence[str]
) -> tuple[Assembly, Contacts, tuple[SceneStage, ...]]:
    """Stages of models with other blocks as stages of all these blocks.

    Parameters
    ----------
    models
    stages
        One of each model, in which the blocks of the others are absent.
    names
        What is added to the names of the blocks of each model.
    """
    first, blocks, fixed = 0, [], []
    contacts = Contacts.empty()
    places = []
    total = sum(len(model) for model in models)
    for model, name in zip(models, names, strict=True):
        kept = np.arange(first, first + len(model))
        joints = np.arange(contacts.count, contacts.count + model.contacts.count)
        own = model.contacts.select(np.ones(model.contacts.count, dtype=bool), kept)
        contacts = joined_contacts(contacts, own) if contacts.count else own
        blocks += [replace(one, name=f"{one.name}{name}") for one in model.assembly.blocks]
        fixed.append(model.assembly.fixed)
        places.append((kept, joints))
        first += len(model)
    made = tuple(
        stage_among(stage, total, contacts, kept, joints)
        for stage, (kept, joints) in zip(stages, places, strict=True)
    )
    return Assembly(tuple(blocks), np.concatenate(fixed)), contacts, made
