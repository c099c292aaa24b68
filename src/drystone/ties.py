"""Ties: they pull two blocks together at their centroids, and never press."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools
from drystone.contacts import Contacts, joined_contacts
from drystone.geometry.frames import frames_from_normals
from drystone.model import Model

PLATE = 0.1
"""Side of the plate of a tie, and of the head of a prop, relative to the size of the block on it.
Chosen: a small jack."""

_POINT = 0.01
"""Size of the corners of a tie by its own, chosen."""


def tied(model: Model, block: int, other: int) -> Model:
    """The model with a tie from the centroid of a block to that of another one.

    It is a joint without friction that presses the block towards the other one. It has the area of
    a plate, drawn together to a point at the centroid, so that it resists no turn.
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
    return model.with_contacts(joined_contacts(model.contacts, plate))


def with_ties(model: Model, ties: Iterable[tuple[str, str]]) -> Model:
    """The model with a tie from the first to the second block of each pair of names.

    Pairs with a block that is not there are left out.
    """
    for pair in ties:
        if all(name in model.assembly for name in pair):
            model = tied(model, *model.assembly.indices(list(pair)).tolist())
    return model


def ties_of(assembly: Assembly, contacts: Contacts) -> Bools:
    """The interfaces (m,) that are ties: at the centroid of a block, where no search finds one."""
    out = np.zeros(contacts.count, dtype=bool)
    for block in (contacts.block_a, contacts.block_b):
        away = np.linalg.norm(contacts.centroid - assembly.centroid[block], axis=1)
        out |= away < SAME * assembly.size[block]
    return out
