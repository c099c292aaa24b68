"""Struts, ropes, clamps and centring as joints of a stage, each with its one-sidedness.

Where an item acts on a block there is an interface with an added fixed block:

- a strut pushes along its axis, from its foot to its head, and never pulls;
- a rope pulls towards its anchor and never pushes (Deuss and others 2014);
- centring carries the free lower face of a block: it pushes and rubs, and never pulls;
- a clamp, or a hand, pushes and pulls with a limited force and a limited moment.

A strut and a rope have one corner without friction; the normal is the direction of the force.
Limits of struts, ropes and centring are compared with the forces of the state that was found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.settings import Options
from drystone.contacts import Contacts, joined_contacts
from drystone.geometry.frames import area_vector, frames_from_normals
from drystone.geometry.polyhedron import BOX
from drystone.geometry.solid import distance
from drystone.joint_capacity import NO_LIMIT, JointCapacity
from drystone.model import Model
from drystone.results import Result
from drystone.sequence.scaffold_seats import surface_triangles

TOUCHING = 0.01
"""Distance of an end from its block, by the size of the block, that is still taken as touching."""
THICK = 0.02
"""Width of the body that stands for a strut, a rope or a clamp, by the size of its block: it is
there to be seen and carries nothing by it."""


class _Joint(NamedTuple):
    """Where an item acts: corners (c, 3), direction (3,) of its push, ends (2, 3) of its body.

    ``pull`` [N] is the largest force against the push.
    """

    corner: Floats
    push: Floats
    ends: tuple[Floats, Floats]
    area: float = 0.0
    friction: float = 0.0
    pull: float = 0.0


@dataclass(frozen=True, eq=False)
class ScaffoldItem(Options):
    """What holds one block.

    Parameters
    ----------
    block
        Position or name of the block.
    limit : [N] > 0
        Largest force of the whole item; infinite when left out.

    Raises
    ------
    InputError
        A point is none, or a limit is not above zero.
    """

    block: int | str
    limit: float = float("inf")

    def _points(self, *names: str) -> None:
        """Take the fields of these names as points (3,)."""
        for name in names:
            point = frozen_floats(getattr(self, name), (3,), f"{self._place()}: its {name}")
            object.__setattr__(self, name, point)

    def _place(self) -> str:
        return f"{type(self).__name__.lower()} of block '{self.block}'"

    @property
    def length(self) -> float:
        """[m] of material that it takes."""
        return 0.0

    def joint(self, body: Block) -> _Joint:
        """Where it acts on its block."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Strut(ScaffoldItem):
    """Pushes a block from a foot, on the ground or on another block.

    Attributes
    ----------
    head, foot : (3,) [m]
        Where it touches the block, and where it stands.
    on
        Block on which it stands, which bears the force; the ground when left out.
    friction
        Coefficient of its head, where it is braced against swaying. Without, its force is along it.
    """

    head: Sequence[float] = (0.0, 0.0, 0.0)
    foot: Sequence[float] = (0.0, 0.0, 0.0)
    on: int | str | None = None
    friction: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._points("head", "foot")
        if self.on is not None and self.on == self.block:
            raise InputError(
                "it stands on the block that it props", where=self._place(), remedy="name another"
            )

    @property
    def length(self) -> float:
        """[m]"""
        return float(np.linalg.norm(np.subtract(self.head, self.foot)))

    def joint(self, body: Block) -> _Joint:  # noqa: ARG002
        """Its head, pushed away from the foot."""
        head, foot = np.asarray(self.head), np.asarray(self.foot)
        return _Joint(head[None], head - foot, (foot, head), friction=self.friction)


@dataclass(frozen=True, eq=False)
class Rope(ScaffoldItem):
    """Pulls a block towards an anchor.

    Attributes
    ----------
    at, anchor : (3,) [m]
        Where it is tied to the block, and where it hangs from.
    """

    at: Sequence[float] = (0.0, 0.0, 0.0)
    anchor: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._points("at", "anchor")

    @property
    def length(self) -> float:
        """[m]"""
        return float(np.linalg.norm(np.subtract(self.at, self.anchor)))

    def joint(self, body: Block) -> _Joint:  # noqa: ARG002
        """Its knot, pulled towards the anchor."""
        at, anchor = np.asarray(self.at), np.asarray(self.anchor)
        return _Joint(at[None], anchor - at, (at, anchor))


@dataclass(frozen=True, eq=False)
class Clamp(ScaffoldItem):
    """Holds a block at its centroid, pushing and pulling.

    Attributes
    ----------
    moment : [N m] > 0
        Largest moment about the centroid.
    """

    moment: float = float("inf")

    def joint(self, body: Block) -> _Joint:
        """Four corners about the centroid, which pull too."""
        reach = 0.25 * body.size
        ring = reach * np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0]])
        up = np.array([0.0, 0.0, 1.0])
        ends = (body.centroid, body.centroid + 0.2 * body.size * up)
        pull = min(self.limit, NO_LIMIT)
        return _Joint(body.centroid + ring, up, ends, 2.0 * reach**2, pull=pull)


@dataclass(frozen=True, eq=False)
class Centring(ScaffoldItem):
    """Carries the free lower face of a block.

    Attributes
    ----------
    face : (c, 3) [m]
        Its corners, counter-clockwise from outside the block.
    friction
        Coefficient.
    height : [m]
        Of the face above the ground, which counts as length.
    """

    face: Floats = None  # type: ignore[assignment]  # always given
    friction: float = 0.6
    height: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        face = frozen_floats(self.face, (None, 3), f"{self._place()}: its face")
        if len(face) < 3:
            raise InputError(
                f"its face has {counted(len(face), 'corner')}",
                where=self._place(),
                remedy="give three or more",
            )
        object.__setattr__(self, "face", face)

    @property
    def length(self) -> float:
        """[m]"""
        return self.height

    def joint(self, body: Block) -> _Joint:
        """The face, pushed inwards."""
        turned = self.face[::-1]  # counter-clockwise about the inward normal
        inward = area_vector(turned)
        area = float(np.linalg.norm(inward))
        low = self.face.mean(axis=0)
        ends = (low - 0.1 * body.size * inward / max(area, 1e-300), low)
        return _Joint(turned, inward, ends, area, self.friction)


@dataclass(frozen=True, eq=False)
class ScaffoldedModel(OneLine):
    """A model with items.

    Attributes
    ----------
    model
        With a fixed block and an interface for each item, behind its own.
    items
    """

    model: Model
    items: tuple[ScaffoldItem, ...]

    def force(self, result: Result) -> Floats:
        """(i,) [N] that each item supplies in a state, the length of its resultant."""
        found = result.resultants.force[self._first :]
        return np.asarray(np.linalg.norm(found, axis=1))

    def moment(self, result: Result) -> Floats:
        """(i,) [N m] that each item supplies about the centroid of its block."""
        contacts, found = self.model.contacts, result.resultants
        first = self._first
        arm = found.position[first:] - self.model.assembly.centroid[contacts.block_b[first:]]
        twist = found.torque[first:, None] * contacts.frame[first:, 0]
        return np.asarray(np.linalg.norm(np.cross(arm, found.force[first:]) + twist, axis=1))

    def overloaded(self, result: Result) -> tuple[int, ...]:
        """Items whose limits are exceeded in a state."""
        force, moment = self.force(result), self.moment(result)
        return tuple(
            i
            for i, item in enumerate(self.items)
            if force[i] > item.limit or (isinstance(item, Clamp) and moment[i] > item.moment)
        )

    @property
    def _first(self) -> int:
        """Interface of the first item."""
        return self.model.contacts.count - len(self.items)


def with_scaffold(model: Model, items: Sequence[ScaffoldItem]) -> ScaffoldedModel:
    """A model whose blocks are held by items.

    A check of the model does not use the limits of struts, ropes and centring:
    :meth:`ScaffoldedModel.overloaded` tells which items exceed their limits in its result.

    Parameters
    ----------
    model
    items

    Raises
    ------
    InputError
        A block is not known, an item has no length, or it does not touch its block.
    """
    assembly = model.assembly
    for k, item in enumerate(items):
        if not isinstance(item, ScaffoldItem):
            raise InputError(f"{item!r} is no strut, rope, clamp or centring", where=f"item {k}")
        body = assembly.blocks[int(assembly.indices([item.block])[0])]
        where = f"item {k} at block '{body.name}'"
        if isinstance(item, Strut):
            _require_touching(body, item.head, f"{where}: its head")
            if item.on is not None:
                under = assembly.blocks[int(assembly.indices([item.on])[0])]
                _require_touching(under, item.foot, f"{where}: its foot")
        elif isinstance(item, Rope):
            _require_touching(body, item.at, where)
        elif isinstance(item, Centring):
            _require_touching(body, item.face, f"{where}: its face")
        if not np.linalg.norm(item.joint(body).push) > 0.0:
            raise InputError("it has no length", where=where, remedy="give two different points")
    return with_items(model, items)


def with_items(model: Model, items: Sequence[ScaffoldItem]) -> ScaffoldedModel:
    """A model whose blocks are held by items that touch them."""
    assembly = model.assembly
    bodies: list[Block] = []
    pairs: list[tuple[int, int]] = []
    joints: list[_Joint] = []
    for k, item in enumerate(items):
        block = int(assembly.indices([item.block])[0])
        on = item.on if isinstance(item, Strut) else None
        under = len(model) + k if on is None else int(assembly.indices([on])[0])
        joint = item.joint(assembly.blocks[block])
        bodies.append(_bar(*joint.ends, THICK * float(assembly.size[block]), f"scaffold-{k:03d}"))
        pairs.append((under, block))
        joints.append(joint)
    whole = Model(
        Assembly(
            (*assembly.blocks, *bodies), np.append(assembly.fixed, np.ones(len(bodies), dtype=bool))
        ),
        joined_contacts(model.contacts, _interfaces(pairs, joints)),
        model.load.of_blocks(np.arange(len(model)), len(model) + len(bodies)),
        notes=model.notes,
        ends=model.ends,
    )
    return ScaffoldedModel(whole, tuple(items))


def _require_touching(body: Block, points: Any, where: str) -> None:
    """Refuse points that are away from the surface of a block."""
    triangles, _ = surface_triangles(body)
    away = float(distance(np.reshape(points, (-1, 3)), triangles).max())
    if away > TOUCHING * body.size:
        raise InputError(
            f"it is {away:.3g} m away from block '{body.name}'",
            where=where,
            remedy="give a point of its surface",
        )


def _bar(one: Floats, other: Floats, width: float, name: str) -> Block:
    """A square bar between two points."""
    axis = other - one
    frame = frames_from_normals((axis / np.linalg.norm(axis))[None])[0]
    flat = 0.5 * width * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    ring = flat @ frame[1:]
    return Block(np.concatenate([one + ring, other + ring]), BOX, name)


def _interfaces(pairs: Sequence[tuple[int, int]], joints: Sequence[_Joint]) -> Contacts:
    """The interfaces of items."""
    if not joints:
        return Contacts.empty()
    under, block = np.array(pairs, dtype=np.intp).T
    unit = np.array([joint.push / np.linalg.norm(joint.push) for joint in joints])
    corners = [len(joint.corner) for joint in joints]
    pull = np.array([joint.pull for joint in joints])
    return Contacts(
        under,
        block,
        frames_from_normals(unit),
        np.array([joint.area for joint in joints]),
        np.array([joint.friction for joint in joints]),
        np.concatenate([joint.corner for joint in joints]),
        np.repeat(np.arange(len(joints)), corners),
        JointCapacity(pull, pull, brittle=False) if pull.any() else None,
    )
