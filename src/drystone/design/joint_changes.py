"""Changes of the joints of a region by a value, on any model that has the region."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from drystone.assembly import Block
from drystone.base.arrays import Floats, Ints
from drystone.base.errors import InputError
from drystone.design.block_surgery import insert_block
from drystone.design.joint_cut import JointRecut, recut
from drystone.design.joint_plane import joint_plane
from drystone.design.joint_surgery import move_cut, still_edge, turn_cut, wedge_cut
from drystone.model import Model

Change: TypeAlias = Callable[[Model, Ints, Ints], Model]
"""A change of a model that has a region: its blocks and its interfaces are given by their positions
in that model."""


def joint_width(model: Model, interface: int) -> float:
    """Width [m] of a joint across the horizontal line in it."""
    joint = joint_plane(model, interface)
    low, high = joint.reach(joint.frame[2])
    return high - low


def words_of(kind: str, name: str) -> Callable[[float], str]:
    """A change of joints in words, from its value."""
    if kind == "let-in":
        return lambda value: f"{name} let in by {1e3 * value:.0f} mm"
    if kind == "turn":
        return lambda value: f"{name} turned by {value:.2f} degrees"
    return lambda value: f"{name} made a wedge of {value:.1f} degrees"


def change_of(kind: str, group: list[int], side: float, value: float) -> Change:
    """The change of joints by a value, in degrees, or in metres where they are let in."""

    def one(model: Model, k: int) -> JointRecut:
        joint = joint_plane(model, k)
        if kind == "turn":
            return turn_cut(joint, side * value, pivot=still_edge(model, k, side))
        return (wedge_cut if kind == "wedge" else move_cut)(joint, side * value)

    def make(model: Model, _: Ints, interfaces: Ints) -> Model:
        return recut(model, [one(model, k) for k in interfaces[group].tolist()])

    return make


def interface_near(model: Model, one: int, other: int, centre: Floats) -> int:
    """The interface between two blocks whose middle is nearest to a point (3,) [m]."""
    contacts = model.contacts
    pair = ((contacts.block_a == one) & (contacts.block_b == other)) | (
        (contacts.block_a == other) & (contacts.block_b == one)
    )
    some = np.flatnonzero(pair)
    if not len(some):
        names = model.assembly.names
        raise InputError(f"'{names[one]}' and '{names[other]}' no longer touch")
    away = np.linalg.norm(contacts.centroid[some] - centre, axis=1)
    return int(some[int(np.argmin(away))])


def with_block(body: Block, model: Model, *_: Ints) -> Model:
    """The model with a free block more."""
    return insert_block(model, body)
