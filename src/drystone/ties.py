"""Ties: they pull two blocks together at their centroids, and never press."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.errors import InputError
from drystone.base.units import FORCES, measured
from drystone.contacts import Contacts, joined_contacts
from drystone.geometry.frames import frames_from_normals
from drystone.joint_capacity import NO_LIMIT, JointCapacity
from drystone.model import Model

PLATE = 0.1
"""Side of the plate of a tie, and of the head of a prop, relative to the size of the block on it.
Chosen: a small jack."""

_POINT = 0.01
"""Size of the corners of a tie by its own, chosen."""


def tied(model: Model, block: int, other: int, strength: float = NO_LIMIT) -> Model:
    """The model with a tie from the centroid of a block to that of another one.

    It is a joint without friction that presses the block towards the other one. It has the area of
    a plate, drawn together to a point at the centroid, so that it resists no turn. It yields at its
    strength [N], as a joint crushes.
    """
    centroid = model.assembly.centroid
    along = centroid[other] - centroid[block]
    frame = frames_from_normals((along / np.linalg.norm(along))[None])
    half = 0.5 * PLATE * float(model.assembly.size[block])
    square = _POINT * half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    plate = Contacts(
        np.array([other]),
        np.array([block]),
        frame,
        np.array([4.0 * half**2]),
        np.zeros(1),
        centroid[block] + square @ frame[0, 1:],
        np.zeros(4, dtype=np.intp),
    )
    if strength < NO_LIMIT or model.contacts.capacity is not None:
        whole = strength / _POINT**2 if strength < NO_LIMIT else NO_LIMIT
        plate = plate.with_capacity(replace(JointCapacity.dry(1), compression=np.array([whole])))
    return model.with_contacts(joined_contacts(model.contacts, plate))


def with_ties(model: Model, ties: Iterable[tuple[str, str]]) -> Model:
    """The model with a tie from the first to the second block of each pair of names.

    Pairs with a block that is not there are left out.
    """
    for pair in ties:
        if all(name in model.assembly for name in pair):
            model = tied(model, *model.assembly.indices(list(pair)).tolist())
    return model


def with_tie_words(model: Model, given: Iterable[str]) -> Model:
    """The model with more ties, each as ``BLOCK:BLOCK`` or ``BLOCK:BLOCK:STRENGTH``.

    Raises
    ------
    InputError
        There is no such block, both are one, or the strength is no force above zero.
    """
    for text in given:
        try:
            model = tied(model, *_read(text, model.assembly))
        except InputError as error:
            raise error.located(f"tie {text[:60]}") from error
    return model


def _read(text: str, assembly: Assembly) -> tuple[int, int, float]:
    """The blocks of a tie and its strength [N]."""
    names, strength = [one.strip() for one in text.split(":")], NO_LIMIT
    if len(names) == 3:
        strength = measured(names.pop(), FORCES, what="strength")
    if len(names) != 2 or not strength > 0.0:
        raise InputError("is no tie with a strength", remedy="write BLOCK:BLOCK:20kN")
    first, second = assembly.indices(names).tolist()
    if first == second or assembly.fixed[[first, second]].all():
        raise InputError("nothing is tied", remedy="name two blocks, one of them free")
    return first, second, strength


def strengths(assembly: Assembly, contacts: Contacts) -> dict[str, float]:
    """The pull [N] at which each tie yields, by its blocks; infinite without a limit."""
    names, strength = assembly.names, contacts.tie_strength
    return {
        f"{names[contacts.block_b[i]]}:{names[contacts.block_a[i]]}": float(strength[i])
        for i in np.flatnonzero(contacts.ties).tolist()
    }
