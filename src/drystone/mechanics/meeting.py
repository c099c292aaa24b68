"""Faces that are apart at the beginning and that blocks may meet as they move.

Two faces that are nearly parallel, face each other and lie apart get an interface whose corners
have a gap. It carries nothing until the gap closes.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, Ints, frozen
from drystone.contacts import DEFAULT_FRICTION, Contacts, joined_contacts
from drystone.detection import DetectionOptions, EdgeContacts, find_contacts
from drystone.detection.tolerances import LARGEST
from drystone.mechanics.corners import FaceSides
from drystone.model import Model

FARTHEST = LARGEST["gap"]
"""Largest distance of two faces that may meet, by the smaller block's size."""
BETWEEN = 1e-3
"""By the block's size, how far outside of the two faces a joint of the model may lie that is taken
as the joint of these faces: joints are found halfway between faces that are not quite flat."""
PARALLEL = 0.99
"""Cosine of the largest angle between the normals of a face and of its interface."""


class Apart(NamedTuple):
    """Interfaces that are open at the beginning.

    Attributes
    ----------
    contacts
        Between the faces.
    gap : (k, 2) [m]
        Distance of each corner from the faces of a and b, along n.
    """

    contacts: Contacts
    gap: Floats


@lru_cache(maxsize=2)
def faces_apart(model: Model, reach: float) -> Apart:
    """The faces that blocks may meet.

    Parameters
    ----------
    model
    reach
        Largest distance of two faces, by the smaller block's size.
    """
    assembly = model.assembly
    found = _facing(assembly, min(reach, FARTHEST))
    contacts, size = found.contacts, np.cbrt(assembly.volume)
    a, b = contacts.block_a, contacts.block_b
    margin = BETWEEN * np.minimum(size[a], size[b])
    keep = ~(assembly.fixed[a] & assembly.fixed[b])
    for i in np.flatnonzero(keep).tolist():
        keep[i] = not _is_joint(model.contacts, found, i, float(margin[i]))
    chosen = contacts.select(keep)
    gap = found.gap[keep[contacts.interface]]
    return Apart(chosen.with_friction(least_friction(model, chosen)), gap)


@lru_cache(maxsize=4)
def _facing(assembly: Assembly, reach: float) -> Apart:
    """The faces that are apart; a limit asks for those of the same blocks again and again."""
    options = DetectionOptions(gap=reach, search=reach, edges=EdgeContacts.NEVER, inexact=False)
    found = find_contacts(assembly, options=options)
    sides = FaceSides(assembly)
    most = SAME * np.minimum(sides.size[found.contacts.block_a], sides.size[found.contacts.block_b])
    near = np.abs(found.report.gap) > most
    contacts = found.contacts.select(near)
    a, b = contacts.block_a, contacts.block_b
    gap = np.stack(
        [_distance(sides, contacts, a, -1.0), _distance(sides, contacts, b, 1.0)], axis=1
    )
    least = np.full(len(contacts), np.inf)
    np.minimum.at(least, contacts.interface, gap.sum(axis=1))
    apart = least > most[near]
    return Apart(contacts.select(apart), frozen(gap[apart[contacts.interface]]))


def _distance(sides: FaceSides, contacts: Contacts, block: Ints, sign: float) -> Floats:
    """(k,) [m] along n from each corner to the face of its block; -inf where there is none."""
    found = np.full(contacts.corner_count, -np.inf)
    for i in range(len(contacts)):
        corners = slice(contacts.start[i], contacts.start[i + 1])
        n, point = sign * contacts.frame[i, 0], contacts.point[corners]
        here = sides.of_block[int(block[i])]
        faces, first = np.unique(sides.face[here], return_index=True)
        begin, normal = sides.begin[here][first], sides.normal[faces]
        # the face of a looks along n and lies on the side of a; that of b the other way round
        facing = normal @ n < -PARALLEL
        if not facing.any():
            continue
        begin, normal = begin[facing], normal[facing]
        far = ((begin[None] - point[:, None]) * normal).sum(axis=2) / (normal @ n)
        middle = far.mean(axis=0)
        nearest = np.where(middle > 0.0, middle, np.inf).argmin()
        found[corners] = far[:, nearest]
    return found


def _is_joint(joints: Contacts, apart: Apart, i: int, margin: float) -> bool:
    """Whether the model has a joint of the same two faces."""
    contacts = apart.contacts
    corners = slice(contacts.start[i], contacts.start[i + 1])
    n, middle = contacts.frame[i, 0], contacts.point[corners].mean(axis=0)
    reach = 0.5 * float(apart.gap[corners].sum(axis=1).max()) + margin
    pair = [contacts.block_a[i], contacts.block_b[i]]
    same: Bools = np.isin(joints.block_a, pair) & np.isin(joints.block_b, pair)
    same &= np.abs(joints.frame[:, 0] @ n) > PARALLEL
    off = np.abs((joints.point[joints.start[:-1][same]] - middle) @ n)
    return bool((off < reach).any())


def least_friction(model: Model, contacts: Contacts) -> Floats:
    """Coefficients (m,) of contacts that are no joints: the least of the joints of the blocks."""
    joints = model.contacts
    fallback = float(joints.friction.min()) if len(joints) else DEFAULT_FRICTION
    least = np.full(len(model.assembly), np.inf)
    for block in (joints.block_a, joints.block_b):
        np.minimum.at(least, block, joints.friction)
    found = np.minimum(least[contacts.block_a], least[contacts.block_b])
    return np.where(np.isfinite(found), found, fallback)


def followed_model(model: Model, apart: Apart) -> tuple[Model, Floats]:
    """The model with the interfaces that a free block takes part in or may meet, and their gaps."""
    part = _followed(model, apart.contacts)
    touch = part.contacts.corner_count - len(apart.gap)
    return part, np.concatenate([np.zeros((touch, 2)), apart.gap])


@lru_cache(maxsize=2)
def _followed(model: Model, apart: Contacts) -> Model:
    return model.with_contacts(joined_contacts(model.contacts.select(model.active), apart))


def model_with_met(model: Model, apart: Apart, met: Bools) -> tuple[Model, Bools, Bools]:
    """The model with the interfaces that were met on the way.

    Parameters
    ----------
    model, apart
    met : (k,)
        Whether a corner of what :func:`followed_model` gives has ever pressed.

    Returns
    -------
    model
    followed : (l,)
        Corners of that model that were followed.
    kept : (k,)
        Corners that were followed and are in that model.
    """
    own = model.active[model.contacts.interface]
    followed = np.ones(int(own.sum()), dtype=bool)
    later = apart.contacts.interface[met[len(followed) :]]
    joints = np.bincount(later, minlength=len(apart.contacts)) > 0
    mine = joints[apart.contacts.interface]
    whole = model.with_contacts(joined_contacts(model.contacts, apart.contacts.select(joints)))
    ones = np.ones(int(mine.sum()), dtype=bool)
    return whole, np.concatenate([own, ones]), np.concatenate([followed, mine])
