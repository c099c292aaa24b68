"""Whether a structure is its own image: it then tilts alike about an axis and about its image.

And a part of it stands where its image does.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import SAME, Floats, Ints
from drystone.contacts import Contacts
from drystone.geometry.frames import LEVEL_AXES
from drystone.loads.applied import is_vertical
from drystone.model import Model

_TURNS = [
    np.diag([x, y, 1.0])[order]
    for x, y in product((1.0, -1.0), repeat=2)
    for order in ([0, 1, 2], [1, 0, 2])
]
"""Quarter turns about the vertical, and mirrors across x, y and their diagonals."""


def unlike_axes(model: Model) -> dict[str, Floats]:
    """Those of the four level axes about which it need be tilted: the first of those alike.

    About two axes a structure tilts alike where a turn or a mirror that makes it itself takes one
    to the other. Joints that do more than press and rub, and loads that are not vertical, are not
    looked at.
    """
    found: dict[str, Floats] = {}
    for name, axis in LEVEL_AXES.items():
        if not any(_tilts_alike(model, one, np.array(axis)) for one in found.values()):
            found[name] = np.array(axis)
    return found


def _tilts_alike(model: Model, one: Floats, other: Floats) -> bool:
    """Whether some turn or mirror takes an axis of rotation (3,) to another one.

    A mirror turns it the other way as well.
    """
    ways = (turn for turn in _TURNS if np.array_equal(np.linalg.det(turn) * turn @ one, other))
    return any(_own_image(model, turn) is not None for turn in ways)


class Image(NamedTuple):
    """A turn or mirror that makes a structure itself.

    Attributes
    ----------
    block, corner : (n,), (k,) where each one goes
    turn : (3, 3)
    """

    block: Ints
    corner: Ints
    turn: Floats

    def of(self, values: Floats) -> Floats:
        """Vectors (m, 6), the last three of them axial, after it."""
        axial = np.linalg.det(self.turn) * self.turn
        return np.concatenate([values[:, :3] @ self.turn.T, values[:, 3:] @ axial.T], axis=1)

    def of_forces(self, contacts: Contacts, corner: Ints, force: Floats) -> Floats:
        """Corner forces (c, 3), local n, u, v, where they are after it."""
        joint, there = contacts.interface[corner], contacts.interface[self.corner[corner]]
        same = self.block[contacts.block_b[joint]] == contacts.block_b[there]
        world = np.einsum("ki,kij->kj", force, contacts.frame[joint]) @ self.turn.T
        return np.einsum(
            "kij,kj->ki", contacts.frame[there], np.where(same[:, None], world, -world)
        )


def own_images(model: Model) -> list[Image]:
    """The images of a structure in which blocks have other places."""
    found = (_own_image(model, turn) for turn in _TURNS)
    every = {one.block.tobytes(): one for one in found if one is not None}
    return [one for one in every.values() if (np.diff(one.block) != 1).any()]


def _own_image(model: Model, turn: Floats) -> Image | None:
    """The image by a turn (3, 3).

    None where blocks, loads and corners do not all lie on others of their kind then.
    """
    assembly, contacts = model.assembly, model.contacts
    if contacts.capacity is not None or not is_vertical(model.load):
        return None
    size, middle = float(assembly.size.mean()), assembly.centroid.mean(axis=0)

    def image(place: Floats, before: Floats, after: Floats) -> Ints | None:
        """Which of some places (p, 3) with numbers (p, q) each comes to lie on; None if not all."""
        here = np.hstack([(place - middle) / size, before])
        there = np.hstack([(place - middle) / size @ turn.T, after])
        some = np.sin(np.arange(1.0, 1.0 + here.shape[1]))  # along which no two places are alike
        order, other = np.argsort(here @ some), np.argsort(there @ some)
        if np.abs(here[order] - there[other]).max(initial=0.0) >= SAME:
            return None
        return order[np.argsort(other)]

    largest = np.abs(model.load.wrench).max(initial=np.finfo(float).tiny)
    weight = model.load.wrench[:, 2] / largest
    kind = np.stack([weight, assembly.fixed], axis=1)
    block = image(assembly.centroid, kind, kind)
    if block is None:
        return None
    owner = assembly.faces.owner
    shape = np.stack([owner, block[owner]])[:, :, None].astype(np.float64)
    if image(assembly.faces.middles, *shape) is None:
        return None
    joint, pair = contacts.interface, contacts.corner_blocks
    normal = contacts.frame[joint, 0]

    def kinds(pair: Ints, normal: Floats) -> Floats:
        """Both blocks (2, k) of corners, the normal from the one before, and friction."""
        way = np.where(pair[0] < pair[1], 1.0, -1.0)[:, None]
        return np.hstack([np.sort(pair, axis=0).T, way * normal, contacts.friction[joint, None]])

    before, after = kinds(pair, normal), kinds(block[pair], normal @ turn.T)
    corner = image(contacts.point, before, after)
    return None if corner is None else Image(block, corner, turn)
