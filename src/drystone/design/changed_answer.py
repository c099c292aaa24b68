"""What a changed structure says of itself; pictures show it with the edges of what it was."""

from __future__ import annotations

from abc import abstractmethod
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drystone.answer import Answer, Layer, LayerKind, Role, Scene, Sentence, State
from drystone.base.arrays import Floats
from drystone.base.errors import counted
from drystone.base.table import Table
from drystone.design.changed_model import ties_of
from drystone.geometry.polyhedron import edges_of
from drystone.joint_capacity import JointCapacity
from drystone.model import Model
from drystone.results import Result

_EQUAL = 1e-6
"""Strengths, coefficients and weights that differ by less than this share are equal: rounding."""

_WIDE = 3.0
"""Width of marked joints and of ties, relative to the usual lines; chosen by eye."""


class ChangedAnswer(Answer):
    """A structure that was changed, with its check.

    Attributes
    ----------
    model
        With the change.
    result
        Its check, or that of the case of the margin in which it falls.
    """

    model: Model
    result: Result

    @property
    @abstractmethod
    def unchanged(self) -> Model:
        """The structure without the change."""

    @property
    @abstractmethod
    def change(self) -> str:
        """What was changed, in a few words."""

    @property
    def stands_now(self) -> bool:
        """Whether it stands as was asked for."""
        return self.result.stable

    @property
    def title(self) -> str:
        """What was changed."""
        return self.change

    def sentences(self) -> Sequence[Sentence]:
        """The verdict on the changed structure, and what was changed."""
        word, result = self.result.verdict.upper(), self.result
        role = Role.GOOD if self.stands_now else Role.BAD if result.falls else Role.UNSURE
        return [Sentence(f"{word}, changed", role), Sentence(self.change)]

    def tables(self) -> Sequence[Table]:
        """Those of the check."""
        return self.result.tables()

    def layers(self) -> Scene:
        """The changed structure, the edges of the blocks as they were, and what was added."""
        before, result = self.unchanged, self.result
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
            start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
            label = "edges before"
            layers.append(Layer("before", label, LayerKind.LINES, "missed", start, along))
        names = result.assembly.names
        added = np.array([name not in before.assembly for name in names], dtype=bool)
        added &= stage.state != State.FALLING
        state = np.where(added, State.ADDED, stage.state)
        stage = replace(stage, state=state, layers=tuple(layers))
        facts = {**result.asked.facts(), "Changed": self.change}
        if before.origin.file:
            facts["File"] = replace(result.asked, file=before.origin.file).facts()["File"]
        shown = {name: text for name, text in facts.items() if text}
        return Scene(result.assembly, result.contacts, (stage,), "drystone: mended", shown)


@dataclass(frozen=True, eq=False)
class ChangedByHand(ChangedAnswer):
    """A change that was made by hand, with the check of what it gave.

    Attributes
    ----------
    before
        The structure without the change.
    result
        Of the changed structure.
    words
        What was changed, in a few words.
    """

    before: Model
    result: Result
    words: str = "mended"

    @property
    def unchanged(self) -> Model:
        """The structure without the change."""
        return self.before

    @property
    def change(self) -> str:
        """What was changed, in a few words."""
        return self.words

    @property
    def model(self) -> Model:  # type: ignore[override]
        """The changed structure."""
        return self.result.model

    def numbers(self) -> Mapping[str, Any]:
        """Those of the check."""
        return self.result.numbers()


@dataclass(frozen=True, eq=False)
class ChangedStructure(ChangedAnswer):
    """A structure that was changed in rounds so that it stands.

    Attributes
    ----------
    before, model
        The structure without the change, and with it.
    result
        The check of ``model``, or that of the case of the margin in which it falls.
    stands
        Whether it stands at the margin.
    rounds
    message
    """

    before: Model
    model: Model
    result: Result
    stands: bool
    rounds: int
    message: str

    def _summary(self) -> str:
        return self.message

    @property
    def unchanged(self) -> Model:
        """The structure without the change."""
        return self.before

    @property
    def change(self) -> str:
        """What was changed, in a few words."""
        return self.message

    @property
    def stands_now(self) -> bool:
        """Whether it stands at the margin."""
        return self.stands

    def sentences(self) -> Sequence[Sentence]:
        """The verdict on the changed structure, how it came about, and its check."""
        verdict, _ = super().sentences()
        return [verdict, Sentence(self.message), Sentence(self.result.message)]

    def numbers(self) -> Mapping[str, Any]:
        """Whether it stands, and how it came about."""
        return {
            "stands": self.stands,
            "verdict": self.result.verdict,
            "message": self.message,
            "check": self.result.message,
            "rounds": self.rounds,
        }


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
