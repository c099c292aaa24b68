"""Why a model falls, and what it became when it was mended, as scenes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.design.causes.diagnosed import Diagnosis
from drystone.geometry.body.polyhedron import edges_of
from drystone.model import Model
from drystone.results import Result
from drystone.view.scenes.change_marks import added_blocks, change_layers
from drystone.view.scenes.header import facts_of
from drystone.view.scenes.scene import Layer, LayerKind, Scene
from drystone.view.scenes.staging import result_scene, stage_of
from drystone.view.style.palette import State


def diagnosis_scene(found: Diagnosis, source: str = "") -> Scene:
    """The model with its first motion and the forces that would hold it.

    Examples
    --------
    >>> from drystone.design import diagnose
    >>> from drystone.models import shelf
    >>> scene = diagnosis_scene(diagnose(shelf(), friction=0.9))
    >>> [layer.key for layer in scene.stages[0].layers if layer.kind is LayerKind.ARROWS]
    ['help']
    """
    stage = stage_of(found.result, "diagnosis")
    point, force = found.props
    props = Layer(
        "help", "props that would hold it", LayerKind.ARROWS, "help", point, force,
        single=True, width=2.0, group="help",
    )  # fmt: skip
    shown = [layer for layer in stage.layers if layer.kind is not LayerKind.ARROWS]
    stage = replace(
        stage,
        message="; ".join(found.sentences),
        motion=found.motion if found.regions else None,
        prop=None,
        layers=(*shown, props) if len(point) else tuple(shown),
    )
    return replace(result_scene(found.result, source), stages=(stage,))


def mended_scene(before: Model, result: Result, source: str = "", change: str = "") -> Scene:
    """A mended model, with the edges of the blocks that changed as they were, and what was added.

    Parameters
    ----------
    before
        The model that was mended.
    result
        Of the mended model.
    source
        The file of the model that was mended.
    change
        What was changed, for the head of the picture.
    """
    kept = {id(block) for block in result.assembly.blocks}
    lines = [
        block.vertices[edges_of(block.faces)]
        for block in before.assembly.blocks
        if id(block) not in kept
    ]
    stage = stage_of(result, "mended")
    layers = [*stage.layers, *change_layers(before, result.model)]
    if lines:
        ends = np.concatenate(lines)
        ghost = Layer(
            "before", "edges before", LayerKind.LINES, "missed", ends[:, 0], ends[:, 1] - ends[:, 0]
        )
        layers.append(ghost)
    added = added_blocks(before, result.model) & (stage.state != State.FALLING)
    state = np.where(added, State.ADDED, stage.state)
    stage = replace(stage, state=state, layers=tuple(layers))
    facts = dict(facts_of(result.assembly, result.contacts, result.model.load, source))
    if change:
        facts["Changed"] = change
    return Scene(result.assembly, result.contacts, (stage,), "drystone: mended", facts)


__all__ = ["diagnosis_scene", "mended_scene"]
