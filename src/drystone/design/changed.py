"""What a structure became: the changes that were kept, the help its plan needs, its picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from drystone.answer import Answer, Layer, LayerKind, Question, Role, Scene, Sentence, State
from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, cross
from drystone.base.display import OneLine, named, rounded_down
from drystone.base.errors import InputError, counted
from drystone.base.table import Table
from drystone.design.props import posts
from drystone.geometry.polyhedron import edges_of
from drystone.joint_capacity import JointCapacity
from drystone.model import Model
from drystone.results import Result
from drystone.sequence import Plan
from drystone.shells import Layout

_HELD = (
    "the force of the tie is that with the blocks around what falls held; the ties below have that "
    "with all blocks free"
)

_WIDE = 3.0
"""Width of marked joints and of ties, relative to the usual lines; chosen by eye."""


@dataclass(frozen=True)
class Kept(OneLine):
    """A change that was kept.

    Attributes
    ----------
    kind
    blocks
        Names: of the blocks of the region that it holds, or of the joint that is changed.
    description
    value
        In degrees, as a coefficient, as a share or in newtons; see the description.
    joints
        Number of joints that are touched.
    added
        Number of blocks, props, ties or weights that are added, and of joints that are glued or
        cut anew.
    volume : [m3]
        Sum of the changes of volume of all blocks.
    cost
        ``joints + 2 added + 10 volume / volume of the region + 5 friction that is added``, where
        what is moved counts by the way, divided by the size of the block, and weights as stone.
    held
        Names of blocks of other regions that were held during the search.
    jams
        Largest force of a joint by the load of the region, where it holds by jamming; else 0.
    """

    kind: str
    blocks: tuple[str, ...]
    description: str
    value: float
    joints: int = 1
    added: int = 0
    volume: float = 0.0
    cost: float = 0.0
    held: tuple[str, ...] = ()
    jams: float = 0.0

    def _summary(self) -> str:
        return f"'{self.description}', cost {self.cost:.3g}"

    @property
    def whose(self) -> str:
        """The blocks of its region, unless the description names one of them."""
        told = any(f"'{name}'" in self.description for name in self.blocks)
        return "" if told else named(self.blocks)


def table_of(changes: Sequence[Kept]) -> Table:
    """A row for each change that was kept."""
    columns: dict[str, list[Any]] = {
        name: [getattr(one, name) for one in changes]
        for name in ("kind", "blocks", "value", "cost", "description")
    }
    columns["blocks"] = [named(blocks) for blocks in columns["blocks"]]
    return Table("changes", columns)


@dataclass(frozen=True, eq=False)
class Changed(Answer):
    """A structure that was changed, with its check; pictures show the edges of what it was.

    Attributes
    ----------
    before, model
        The structure without the changes, and with them.
    result
        The check of ``model``, or that of the case of the margin in which it falls.
    stands
        Whether it stands as was asked for; no, where the check held other blocks that still fall.
    words
        What was changed, in a few words; empty where nothing was.
    changes
        Those that were kept, in their order.
    log
        How it came about, one sentence each.
    x : (p,)
        Values of the variables of the search: sharpness of each interface of ``before`` [degrees],
        or moves of vertices [m].
    value, first
        What was to be best, after the changes and before them: volume [m3], reach [m], or the
        share of the load that needs help.
    rounds
        Of the search.
    """

    before: Model
    model: Model
    result: Result
    stands: bool
    words: str = ""
    changes: tuple[Kept, ...] = ()
    log: tuple[str, ...] = ()
    x: Floats = field(default_factory=partial(np.zeros, 0))
    value: float = float("nan")
    first: float = float("nan")
    rounds: int = 0

    @classmethod
    def by_hand(cls, before: Model, result: Result, words: str = "mended") -> Changed:
        """What was changed by hand, with the check of what that gave."""
        return cls(before, result.model, result, result.stable, words)

    @property
    def change(self) -> Kept:
        """The first one of its changes, the only one of a mend."""
        return self.changes[0]

    @property
    def price(self) -> str:
        """Its cost, and its margin where that is known, in words."""
        told, margin = f"cost {self.change.cost:.3g}", self.result.tilt_margin
        if margin is None:
            return told
        tilt = rounded_down(margin, 2)
        return told + (f", margin: {tilt:g} degrees of tilt" if tilt >= 0.1 else ", no margin")

    @cached_property
    def touched(self) -> frozenset[tuple[str, ...]]:
        """Names of the blocks that are another or hold otherwise, and of those of such joints.

        What was not there before has no name.
        """
        names = self.before.assembly
        changed = (key for key, *_ in _signed(self.before) ^ _signed(self.model))
        return frozenset(tuple(x if x in names else "" for x in key) for key in changed)

    def far_from(self, other: Changed) -> tuple[bool, int, float]:
        """How far a mend is from another: by its size, by what is touched, by its value."""
        own, its = self.change, other.change
        apart = len(self.touched ^ other.touched)
        return (own.joints, own.added) != (its.joints, its.added), apart, abs(own.value - its.value)

    @property
    def held(self) -> tuple[str, ...]:
        """Blocks that still fall: the check held them, and the structure does not."""
        free = {self.model.assembly.names[i] for i in self.model.assembly.free}
        now = self.result.assembly
        return tuple(now.names[i] for i in np.flatnonzero(now.fixed) if now.names[i] in free)

    @property
    def message(self) -> str:
        """How it ended."""
        return self.log[-1] if self.log else ""

    @property
    def title(self) -> str:
        """What was changed."""
        return self.words or self.message

    @cached_property
    def asked(self) -> Question:
        """What was asked, of the file of the structure before."""
        return replace(super().asked, file=self.before.origin.file or self.model.origin.file)

    def sentences(self) -> Sequence[Sentence]:
        """The verdict on the changed structure, what was changed, and how it came about."""
        result = self.result
        role = Role.GOOD if self.stands else Role.BAD if result.falls else Role.UNSURE
        at_margin = self.stands or result.model is self.model
        word = result.verdict.upper() if at_margin else "STANDS, not at the margin"
        word = "HOLDS ONE PART, OTHERS STILL FALL" if self.held else word
        word += ", changed" if self.words else ""
        steps = any(step.description in one for one in self.log for step in self.changes)
        told = dict.fromkeys([*([] if steps else [self.title]), *self.log, self._still_falls])
        told.pop("", None)
        said = [Sentence(word, role), *map(Sentence, told)]
        tied = any(change.kind == "tie" for change in self.changes)
        return [*said, Sentence(_HELD, Role.REMARK)] if tied else said

    @property
    def _still_falls(self) -> str:
        """Which blocks still fall, though the check held them."""
        return f"still falls, held in this trial only: {named(self.held)}" if self.held else ""

    def tables(self) -> Sequence[Table]:
        """The changes, the free mass before and after, and what the check has."""
        masses = {"before": [free_mass(self.before)], "after": [free_mass(self.model)]}
        mass = Table("free mass", masses, dict.fromkeys(masses, "kg"))
        own = [table_of(self.changes), mass] if self.changes else []
        return [*own, *self.result.tables()]

    def numbers(self) -> Mapping[str, Any]:
        """Whether it stands, and how it came about."""
        return {
            "stands": self.stands,
            "verdict": self.result.verdict,
            "message": self.message,
            "check": self.result.message,
            "rounds": self.rounds,
            "value": self.value,
            "first": self.first,
            "variables": self.x,
            "log": self.log,
        }

    def as_mend(self) -> dict[str, Any]:
        """Its only change and its verdict, as plain values."""
        told = {"verdict": self.result.verdict, "message": self.result.message}
        return {**asdict(self.change), **told}

    def layers(self) -> Scene:
        """The changed structure, the edges that are gone, and what was added."""
        before, result = self.before, self.result
        stage = result.stage("mended")
        known = {layer.key for layer in stage.layers}
        marked = [one for one in _marked(before, result.model) if one.key not in known]
        layers = [*stage.layers, *marked, *_weights(before, result.model)]
        layers += _outlines(before.assembly, result.assembly)
        names = result.assembly.names
        added = np.array([name not in before.assembly for name in names], dtype=bool)
        layers += _props(result.model, stage.layers, added)
        added &= stage.state != State.FALLING
        state = np.where(added, State.ADDED, stage.state)
        stage = replace(stage, state=state, layers=tuple(layers))
        if self.held:
            state[result.assembly.indices(self.held)] = State.FALLING
            stage = replace(stage, headline=f"S{self._still_falls[1:]}", role=Role.UNSURE)
        facts = {**self.asked.facts(), "Changed": self.words}
        shown = {name: text for name, text in facts.items() if text}
        return Scene(result.assembly, result.contacts, (stage,), "drystone: mended", shown)


def _props(model: Model, layers: Sequence[Layer], added: Bools) -> list[Layer]:
    """The forces of supports that are added: a block without contact shows no direction."""
    contacts, made = model.contacts, []
    for one in layers:
        if one.key == "reactions" and one.vector is not None and one.interface is not None:
            ends = np.stack([contacts.block_a[one.interface], contacts.block_b[one.interface]])
            own = added[ends].any(axis=0)
            other = np.where(added[ends[0]], ends[1], ends[0])[own]
            made += posts(model.assembly, other, one.position[own], one.vector[own])
    return made


def _outlines(before: Assembly, after: Assembly) -> list[Layer]:
    """The edges of blocks that changed, or are gone, as they were."""
    now = {block.name: block for block in after.blocks}
    parts = [
        _without(block.vertices[edges_of(block.faces)], other.vertices[edges_of(other.faces)])
        if other is not None
        else block.vertices[edges_of(block.faces)]
        for block in before.blocks
        if (other := now.get(block.name)) is not block
    ]
    ends = np.concatenate([*parts, np.zeros((0, 2, 3))])
    if not len(ends):
        return []
    start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    kind, colour = LayerKind.LINES, "missed"
    return [Layer("before", "edges before", kind, colour, start, along, width=0.5)]


def _without(edges: Floats, others: Floats) -> Floats:
    """Parts (p, 2, 3) of edges (e, 2, 3) that do not lie on others (f, 2, 3)."""
    left = []
    for start, end in edges:
        size = float(np.linalg.norm(end - start))
        way = (end - start) / size
        along = (others - start) @ way
        off = np.linalg.norm(others - start - along[..., None] * way, axis=2).max(axis=1)
        spans = np.sort(along[off < SAME * size], axis=1)
        places = np.unique(np.clip([0.0, size, *spans.ravel()], 0.0, size))
        for low, high in pairwise(places.tolist()):
            middle = 0.5 * (low + high)
            hidden = ((spans[:, 0] < middle) & (middle < spans[:, 1])).any()
            if not hidden and high - low > SAME * size:
                left.append([start + low * way, start + high * way])
    return np.array(left).reshape(-1, 2, 3)


def _marked(before: Model, after: Model) -> list[Layer]:
    """Glued and rougher joints, and ties, that the model after has, and the other has not.

    Joints are compared by the names of their blocks.

    Examples
    --------
    >>> from drystone.models import tower
    >>> dry = Model.of(tower(3), friction=0.6)
    >>> glued = dry.with_capacity(JointCapacity.of(dry.contacts, tension=[0.0, 50.0]))
    >>> [layer.label for layer in _marked(dry, glued)]
    ['1 glued joint']
    """
    was: dict[tuple[str, ...], Floats] = {}
    for pair, values in zip(_joints(before), _values(before), strict=True):
        was[pair] = np.maximum(values, was.get(pair, 0.0))
    contacts, pairs, tie = after.contacts, _joints(after), after.contacts.ties
    old = np.array([was.get(one, (0.0, np.inf, 0.0)) for one in pairs]).reshape(-1, 3)
    more = _values(after) > (1.0 + SAME) * old
    glued, rougher = more[:, 0] & ~tie, more[:, 1] & ~more[:, 0] & ~tie
    layers = []
    for key, what, colour, chosen in (
        ("glued", "glued joint", "added", glued),
        ("rougher", "rougher joint", "kern", rougher),
        ("tie-forces", "tie", "added", more[:, 2]),
    ):
        some = np.flatnonzero(chosen).tolist()
        if not some:
            continue
        ends = after.assembly.centroid[np.stack([contacts.block_a, contacts.block_b], axis=1)]
        rings = [ends[k] if key == "tie-forces" else contacts.polygon(k) for k in some]
        start = np.concatenate(rings)
        along = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings]) - start
        label = counted(len({pairs[k] for k in some}), what)
        layers.append(Layer(key, label, LayerKind.LINES, colour, start, along, width=_WIDE))
    return layers


def _joints(model: Model) -> list[tuple[str, ...]]:
    """The names of the two blocks of each interface."""
    names, contacts = model.assembly.names, model.contacts
    pairs = zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
    return [tuple(sorted((names[a], names[b]))) for a, b in pairs]


def _signed(model: Model) -> set[tuple[Any, ...]]:
    """Names of blocks, and of those of joints, with what a change makes another."""
    each, fixed = model.assembly.blocks, model.assembly.fixed.tolist()
    blocks = [((one.name,), id(one), held) for one, held in zip(each, fixed, strict=True)]
    joints = zip(_joints(model), *_values(model).T.tolist(), strict=True)
    return {*blocks, *joints}


def _values(model: Model) -> Floats:
    """Of each interface (m, 3): pull plus cohesion [N], friction, and 1 for a tie."""
    capacity = model.contacts.capacity or JointCapacity.of(model.contacts)
    tie = model.contacts.ties
    return np.stack(
        [capacity.tension + capacity.cohesion, model.contacts.friction, tie.astype(np.float64)],
        axis=1,
    )


def _weights(before: Model, after: Model) -> list[Layer]:
    """The forces on blocks that did not change themselves and carry more."""
    old = {id(block): i for i, block in enumerate(before.assembly.blocks)}
    same = [(i, old[id(one)]) for i, one in enumerate(after.assembly.blocks) if id(one) in old]
    now, was = np.array(same, dtype=np.intp).reshape(-1, 2).T
    before_them = before.load.wrench[was, :3]
    more = after.load.wrench[now, :3] - before_them
    size = np.linalg.norm(more, axis=1)
    chosen = size > SAME * np.linalg.norm(before_them, axis=1)
    if not chosen.any():
        return []
    block, force = now[chosen], more[chosen]
    moment = (after.load.wrench[now, 3:] - before.load.wrench[was, 3:])[chosen]
    at = after.assembly.centroid[block] + cross(force, moment) / size[chosen, None] ** 2
    return [
        Layer(
            "weights", counted(len(block), "added weight"), LayerKind.ARROWS, "added",
            at, force, block=block,
            single=True, width=2.0, group="help",
        )
    ]  # fmt: skip


def free_mass(model: Model) -> float:
    """The mass [kg] of the free blocks."""
    return float(model.assembly.mass[model.assembly.free].sum())


class Help(NamedTuple):
    """The help that a plan needs, in order of what is less: fewer props, then fewer held blocks.

    Attributes
    ----------
    unplanned
        Whether there is no plan.
    impossible, propped, held
        Numbers of blocks; the first ones cannot be put in.
    together
        Number of blocks that are placed at once with another one.
    """

    unplanned: bool
    impossible: int
    propped: int
    held: int
    together: int

    @property
    def blocks(self) -> int:
        """Number of blocks that need help: propped, held or not to be put in."""
        return self.impossible + self.propped + self.held

    @classmethod
    def of(cls, found: Plan) -> Help:
        """What a plan needs."""
        return cls(not found.steps, len(found.impossible), *found.help)

    def __str__(self) -> str:
        if not any(self):
            return "every block stands when it is placed"
        some = counted(self.propped + self.impossible, "block")
        return f"{some} propped, {self.held} held"


def helped(found: Plan) -> Iterator[tuple[int, tuple[int, ...], str]]:
    """Blocks that need help, the first placed first, with the props beside them, and why."""
    for block, why in found.impossible.items():
        yield block, (), why
    done: set[int] = set()
    for step in found.steps:
        together = step.blocks if len(step.blocks) > 1 else ()
        for block in (*together, *step.props):
            if block not in done:
                done.add(block)
                yield block, tuple(b for b in step.props if b != block), step.why or "it is propped"


@dataclass(frozen=True, eq=False)
class Buildable(Answer):
    """A structure that was changed until it is built with less help, and its plan.

    Attributes
    ----------
    model
        With the changes.
    plan
        ``None`` where there is none.
    changes
        Those that were kept, in their order.
    log
        How it came about, one sentence each.
    tried
        Number of changes that were tried.
    before
        The help that was needed without the changes, where that is known.
    layout
        Of a shell, with a wedge for each bed line between two courses, from the springing.
    """

    model: Model
    plan: Plan | None
    changes: tuple[Kept, ...]
    log: tuple[str, ...]
    tried: int = 0
    before: Help | None = None
    layout: Layout | None = None

    @property
    def help(self) -> Help | None:
        """What the plan needs."""
        return None if self.plan is None else Help.of(self.plan)

    @property
    def free(self) -> bool:
        """Whether every block is placed alone and stands at once."""
        return self.help is not None and not any(self.help)

    @property
    def message(self) -> str:
        """How it ended."""
        return self.log[-1]

    @property
    def title(self) -> str:
        """How it ended."""
        return self.message[0].upper() + self.message[1:]

    def sentences(self) -> Sequence[Sentence]:
        """Whether every block is free, how it ended, and how it came about."""
        role = Role.GOOD if self.free else Role.BAD
        told = (self.message, *self.log[:-1])
        return [Sentence("FREE" if self.free else "NOT FREE", role), *map(Sentence, told)]

    def tables(self) -> Sequence[Table]:
        """The changes that were kept."""
        return [table_of(self.changes)]

    def layers(self) -> Scene:
        """The plan."""
        if self.plan is None:
            raise InputError("there is no picture: there is no plan", remedy="try other changes")
        return self.plan.layers()

    def numbers(self) -> Mapping[str, Any]:
        """Whether every block is free, how it came about, and the plan."""
        return {
            "free": self.free,
            "message": self.message,
            "log": self.log,
            "tried": self.tried,
            "help": self.help and self.help._asdict(),
            "before": self.before and self.before._asdict(),
            "wedges": self.layout and self.layout.wedge,
            "plan": None if self.plan is None else self.plan.numbers(),
        }
