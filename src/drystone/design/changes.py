"""Changes of a region: what each makes of a model, its values, its cost and its words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from drystone.assembly import Block
from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.units import quantity
from drystone.contacts import Contacts
from drystone.design.changed_model import acceleration_of
from drystone.design.joint_cut import JointRecut, joint_plane, recut
from drystone.design.props import PropSeat, with_props
from drystone.design.surgery import insert_block, move_cut, still_edge, turn_cut, wedge_cut
from drystone.design.words import friction_words, glue_words, names_of, place
from drystone.joint_capacity import JointCapacity
from drystone.model import Model

ROUGHEST = 4.0
"""Largest tried friction coefficient. Chosen: it corresponds to 76 degrees, where a joint acts like
a key."""

MOST = 10.0
"""Largest tried ballast, and largest tried strength of glue in one joint, relative to the weight of
the region; of the same glue in all joints that pull, relative to the largest pull there. Chosen."""

FRICTION = 0.01
"""Width at which the search for a friction coefficient ends. Chosen: friction is hardly ever known
better."""

_JOINTS = {
    "turn": ((5.0, 15.0, 35.0), 0.05),
    "wedge": ((5.0, 10.0, 25.0, 45.0), 0.25),
    "let-in": ((0.1, 0.25, 0.5, 1.0), 0.01),
}
"""Values that are tried before the least one is searched, and its width: [degrees], or relative to
the width of the joint. Chosen. A very small wedge locks rigid blocks, but not real ones, so none
below the first value is tried, no smaller step, and no turn below a degree."""

_GLUE_SHARES = (0.01, 0.1, 0.3, 1.0)
"""Strengths of glue that are tried before the least one is searched, by the largest one."""

_BALLAST_SHARES = (0.1, 0.3, 1.0, 3.0, MOST)
"""Weights that are tried before the least one is searched, by that of the region."""

_SHAPES = ("slide", "turn", "wedge", "let-in", "thicker")
"""Kinds that change the shape or the place of blocks. A ledge of a few millimetres that comes of it
carries as rigid blocks do, and crushes in a wall."""

_LET_IN = " (of the two blocks of a joint one is cut so deep, the other as much longer)"

Surgery: TypeAlias = Callable[[Model, Ints, Ints], Model]
"""What a change makes of a model that has a region: its blocks and its interfaces are given by
their positions in that model."""


@dataclass(frozen=True, eq=False)
class Change(OneLine):
    """A change of a region by a value.

    Attributes
    ----------
    kind
        See :data:`drystone.design.mend_kinds.KINDS`.
    surgery
        What it makes of a model by a value; as :data:`Surgery`.
    words
        The same as text.
    steps
        Rising values that are tried before the least one is searched. The last one is the largest;
        one alone is not varied.
    close
        Accuracy of the least value; a hundredth of it when zero.
    low
        No value below this one is tried.
    joints
        Number of joints that are touched.
    added
        Number of things that are added.
    beyond
        Blocks of the whole model, that the region does not touch, of which the change makes use.
    grows
        Whether a larger value hardly ever holds less, so that the largest one is tried first.
    rest : (n + added, 6) [m, rad]
        Where the blocks of a large region rest with it, if that is known.
    """

    kind: str
    surgery: Callable[[float, Model, Ints, Ints], Model]
    words: Callable[[float], str]
    steps: tuple[float, ...]
    close: float = 0.0
    low: float = 0.0
    joints: int = 0
    added: int = 0
    beyond: tuple[int, ...] = ()
    grows: bool = False
    rest: Floats | None = None

    @classmethod
    def single(
        cls,
        kind: str,
        make: Surgery,
        words: str,
        value: float = 0.0,
        joints: int = 0,
        added: int = 0,
    ) -> Change:
        """A change with nothing to vary."""
        return cls(
            kind, lambda _, *given: make(*given), lambda _: words, (value,), 0.0, value, joints,
            added,
        )  # fmt: skip

    def make(self, value: float) -> Surgery:
        """The change by a value; what touches only then is no joint where shapes change."""
        made = partial(self.surgery, value)
        return partial(_without_new_joints, made) if self.kind in _SHAPES else made

    def above(self, known: float) -> Change:
        """The same from a value on that is known to be the least, or lower than that."""
        low = max(self.low, known - self.close)
        return replace(self, low=low, steps=(known, *(x for x in self.steps if x > known)))


def _without_new_joints(made: Surgery, model: Model, *where: Ints) -> Model:
    """A changed model of the same blocks, without joints of two that did not touch before."""
    after, old = made(model, *where), model.contacts
    new = after.contacts
    return after.with_contacts(
        new.select(np.isin(_pairs(new, len(model)), _pairs(old, len(model))))
    )


def _pairs(contacts: Contacts, count: int) -> Ints:
    """A number (m,) for the two blocks of each interface, in either order."""
    ends = np.sort([contacts.block_a, contacts.block_b], axis=0)
    return ends[0] * count + ends[1]


def friction_change(model: Model, group: Sequence[int], where: str) -> Change:
    """The least friction coefficient of some joints."""

    def make(value: float, model: Model, _: Ints, interfaces: Ints) -> Model:
        friction = np.array(model.contacts.friction)
        at = interfaces[list(group)]
        friction[at] = np.maximum(friction[at], value)
        return model.with_friction(friction)

    own = float(model.contacts.friction[list(group)].min())
    low = FRICTION * float(np.floor(own / FRICTION))
    steps = tuple(x for x in (1.0, 2.0, ROUGHEST) if x > low)
    words = partial(friction_words, where)
    return Change("friction", make, words, steps, FRICTION, low, len(group), grows=True)


def joint_change(model: Model, kind: str, sides: Mapping[int, float], name: str = "") -> Change:
    """Joints turned, made wedges or let in, each to a side, 1 or -1, by [degrees] or [m].

    Raises
    ------
    InputError
        One of them has no area, or is not convex.
    """

    def cut(model: Model, k: int, side: float, value: float) -> JointRecut:
        joint = joint_plane(model, k)
        if kind == "turn":
            return turn_cut(joint, side * value, pivot=still_edge(model, k, side))
        return (wedge_cut if kind == "wedge" else move_cut)(joint, side * value)

    def make(value: float, model: Model, _: Ints, interfaces: Ints) -> Model:
        each = zip(interfaces[list(sides)], sides.values(), strict=True)
        return recut(model, [cut(model, int(k), side, value) for k, side in each])

    words = {
        "turn": lambda value: f"{name} turned by {value:.2f} degrees",
        "wedge": lambda value: f"{name} made a wedge of {value:.1f} degrees",
        "let-in": lambda value: f"{name} let in by {1e3 * value:.0f} mm{_LET_IN}",
    }[kind]
    width = 1.0
    steps, close = _JOINTS[kind]
    planes = [joint_plane(model, k) for k in sides]
    if kind == "let-in":
        width = min(float(np.ptp(joint.reach(joint.frame[2]))) for joint in planes)
    steps = tuple(width * step for step in steps)
    low = 1.0 if kind == "turn" else steps[0]
    return Change(kind, make, words, steps, width * close, low, len(sides), len(sides))


def glue_change(
    joints: tuple[int, ...], steps: tuple[float, ...], close: float, words: Callable[[float], str]
) -> Change:
    """The same glue in some joints; steps and accuracy as of :class:`Change`."""

    def make(strength: float, model: Model, _: Ints, at: Ints) -> Model:
        return glued(model, at[list(joints)], strength)

    count = len(joints)
    return Change("glue", make, words, steps, close, 0.0, count, count, grows=True)


def glue_changes(
    model: Model, count: int, pulling: Sequence[tuple[int, float]], few: int
) -> dict[tuple[int, ...], Change]:
    """Glue in the joints of two blocks each; in a region of more than a few in all that pull.

    Parameters
    ----------
    model
        Local.
    count
        Number of blocks of the region, the first ones of the model.
    pulling
        The interfaces that pull, and their forces [N].
    few
    """
    contacts = model.contacts
    if count <= few:
        weight = float(np.linalg.norm(model.load.wrench[:count, :3].sum(axis=0)))
        pairs = list(zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True))
        groups = [
            tuple(k for k, one in enumerate(pairs) if one == pair) for pair in dict.fromkeys(pairs)
        ]
        most, close = MOST * weight, 0.01 * weight
    elif pulling:
        groups = [tuple(k for k, _ in pulling)]
        largest = max(force for _, force in pulling)
        # each trial of a large region takes a second
        most, close = MOST * largest, (0.1 if count > 10 * few else 0.02) * largest
    else:
        return {}
    steps = tuple(share * most for share in _GLUE_SHARES)
    return {
        joints: glue_change(joints, steps, close, partial(glue_words, model, joints))
        for joints in groups
    }


def ballast_change(model: Model, count: int, on: Mapping[int, Floats]) -> Change:
    """The least weight [N] on each of some blocks of a region, at points (3,) [m]."""

    def make(weight: float, model: Model, blocks: Ints, _: Ints) -> Model:
        for block, at in on.items():
            model = ballasted(model, int(blocks[block]), weight, at)
        return model

    def words(weight: float) -> str:
        told = f"a weight of {quantity(weight, 'N')} on"
        if len(on) > 1:
            return f"{told} each of {names_of(model, list(on))}"
        return f"{told} {names_of(model, list(on))} at {place(next(iter(on.values())))}"

    own = float(model.assembly.mass[:count].sum() * np.linalg.norm(acceleration_of(model)))
    steps = tuple(share * own for share in _BALLAST_SHARES)
    return Change("ballast", make, words, steps, added=len(on))


def glued(model: Model, joints: Ints, strength: float) -> Model:
    """The model with glue in some joints, each of a strength [N] against pull and against shear.

    It is ductile where the model has no brittle joints.
    """
    before = model.contacts.capacity or JointCapacity.of(model.contacts, brittle=False)
    tension, cohesion = np.array(before.tension), np.array(before.cohesion)
    tension[joints] = np.maximum(tension[joints], strength)
    cohesion[joints] = np.maximum(cohesion[joints], strength)
    return model.with_capacity(replace(before, tension=tension, cohesion=cohesion))


def ballasted(model: Model, block: int, weight: float, at: Floats | None = None) -> Model:
    """The model with an additional weight [N] at a point (3,) [m] of a block, or its centroid."""
    down = acceleration_of(model)
    force, wrench = weight * down / np.linalg.norm(down), np.array(model.load.wrench)
    arm = np.zeros(3) if at is None else at - model.assembly.centroid[block]
    wrench[block] += np.concatenate([force, np.cross(arm, force)])
    name = f"{model.load.name} + {weight:.3g} N on {model.assembly.names[block]}"
    return model.with_load(replace(model.load, wrench=wrench, name=name))


def props_at(chosen: Sequence[PropSeat], *, smooth: bool) -> Surgery:
    """Props against blocks of a region, with smooth heads or rough ones."""

    def make(model: Model, blocks: Ints, _: Ints) -> Model:
        seats = [replace(one, block=int(blocks[one.block])) for one in chosen]
        return with_props(model, seats, smooth=smooth)

    return make


def block_added(body: Block) -> Surgery:
    """A free block more."""
    return lambda model, *_: insert_block(model, body)
