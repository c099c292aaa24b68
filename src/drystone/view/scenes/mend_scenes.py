"""Why a model falls, and what it became when it was mended, as scenes."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np

from drystone.answer.scene import Layer, LayerKind, Scene, State
from drystone.base.arrays import Floats
from drystone.base.errors import counted
from drystone.design.changed_model import ties_of
from drystone.geometry.polyhedron import edges_of
from drystone.joint_capacity import JointCapacity
from drystone.model import Model
from drystone.results import Result

_EQUAL = 1e-6
"""Strengths, coefficients and weights that differ by less than this share are equal: rounding."""

_WIDE = 3.0
"""Width of marked joints and of ties, relative to the usual lines; chosen by eye."""


def mended_scene(before: Model, result: Result, change: str = "") -> Scene:
    """A mended model, with the edges of the blocks that changed as they were, and what was added.

    Parameters
    ----------
    before
        The model that was mended.
    result
        Of the mended model.
    change
        What was changed, for the head of the picture.
    """
    kept = {id(block) for block in result.assembly.blocks}
    lines = [
        block.vertices[edges_of(block.faces)]
        for block in before.assembly.blocks
        if id(block) not in kept
    ]
    stage = result.stage("mended")
    layers = [*stage.layers, *_change_layers(before, result.model)]
    if lines:
        ends = np.concatenate(lines)
        ghost = Layer(
            "before", "edges before", LayerKind.LINES, "missed", ends[:, 0], ends[:, 1] - ends[:, 0]
        )
        layers.append(ghost)
    added = np.array([name not in before.assembly for name in result.assembly.names], dtype=bool)
    added &= stage.state != State.FALLING
    state = np.where(added, State.ADDED, stage.state)
    stage = replace(stage, state=state, layers=tuple(layers))
    facts = result.asked.facts()
    if change:
        facts["Changed"] = change
    return Scene(result.assembly, result.contacts, (stage,), "drystone: mended", facts)


def _change_layers(before: Model, after: Model) -> tuple[Layer, ...]:
    """Glued and rougher joints, ties and weights that the model after has, and the other has not.

    Joints are compared by the names of their blocks.

    Examples
    --------
    >>> from drystone.models import tower
    >>> dry = Model.of(tower(3), friction=0.6)
    >>> glued = dry.with_capacity(JointCapacity.of(dry.contacts, tension=[0.0, 50.0]))
    >>> [layer.label for layer in _change_layers(dry, glued)]
    ['1 glued joint']
    """
    contacts, joint, tie = after.contacts, _joints(after), ties_of(after)
    strength = _largest(before, _strength(before))
    friction = _largest(before, np.asarray(before.contacts.friction))
    ties = {_joints(before)[k] for k in np.flatnonzero(ties_of(before))}
    edges: dict[str, list[tuple[Floats, Floats]]] = defaultdict(list)
    marked: dict[str, set[tuple[str, ...]]] = defaultdict(set)
    for k, (pair, force) in enumerate(zip(joint, _strength(after), strict=True)):
        points = contacts.polygon(k)
        key = ""
        if tie[k]:
            if pair not in ties:
                key = "ties"
                points = after.assembly.centroid[[contacts.block_a[k], contacts.block_b[k]]]
        elif force > (1.0 + _EQUAL) * strength.get(pair, 0.0):
            key = "glued"
        elif contacts.friction[k] > (1.0 + _EQUAL) * friction.get(pair, np.inf):
            key = "rougher"
        if key:
            edges[key].append((points, np.roll(points, -1, axis=0) - points))
            marked[key].add(pair)
    made = []
    for key, what, colour in (
        ("glued", "glued joint", "added"),
        ("rougher", "rougher joint", "kern"),
        ("ties", "tie", "added"),
    ):
        if edges[key]:
            start, along = (np.concatenate(one) for one in zip(*edges[key], strict=True))
            label = counted(len(marked[key]), what)
            made.append(Layer(key, label, LayerKind.LINES, colour, start, along, width=_WIDE))
    return (*made, *_weights(before, after))


def _joints(model: Model) -> list[tuple[str, ...]]:
    """The names of the two blocks of each interface."""
    names, contacts = model.assembly.names, model.contacts
    pairs = zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
    return [tuple(sorted((names[a], names[b]))) for a, b in pairs]


def _strength(model: Model) -> Floats:
    """Pull and cohesion (m,) [N] of each interface, added up."""
    capacity = model.contacts.capacity or JointCapacity.of(model.contacts)
    total: Floats = capacity.tension + capacity.cohesion
    return total


def _largest(model: Model, value: Floats) -> dict[tuple[str, ...], float]:
    """The largest of the values (m,) of the interfaces of each joint."""
    out: dict[tuple[str, ...], float] = {}
    for pair, one in zip(_joints(model), value.tolist(), strict=True):
        out[pair] = max(one, out.get(pair, 0.0))
    return out


def _weights(before: Model, after: Model) -> tuple[Layer, ...]:
    """The forces on blocks that did not change themselves and carry more."""
    old = {name: i for i, name in enumerate(before.assembly.names)}
    block, more = [], []
    for i, (name, one) in enumerate(zip(after.assembly.names, after.assembly.blocks, strict=True)):
        if name not in old or before.assembly.blocks[old[name]] is not one:
            continue
        force, was = after.load.wrench[i, :3], before.load.wrench[old[name], :3]
        if np.linalg.norm(force - was) > _EQUAL * np.linalg.norm(was):
            block.append(i)
            more.append(force - was)
    if not block:
        return ()
    return (
        Layer(
            "weights", counted(len(block), "added weight"), LayerKind.ARROWS, "added",
            after.assembly.centroid[block], np.array(more), block=np.array(block),
            single=True, width=2.0, group="help",
        ),
    )  # fmt: skip
