"""Virtual interfaces in words: ``kern``, ``0.5``, ``-z``, of all joints or of those of blocks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone import virtual
from drystone.base.arrays import Bools, Floats
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.model import Model

_WHERE = "virtual"


def virtual_contacts(model: Model, words: Sequence[str]) -> Contacts:
    """The contacts of a model, some of them reduced.

    Parameters
    ----------
    model
    words
        Each is ``WHAT`` or ``WHAT@BLOCKS``: the joints of one block, or those between several,
        separated by commas; ``supports`` means the joints with fixed blocks. ``WHAT`` is ``kern``,
        a share of the size from 0 (a point) to 1, or a direction, such as ``-z``, ``x=0.2``,
        ``1,0,1``, or ``in`` and ``out``, to and from the middle of the supports: the joint is
        compressed towards that side to a share of its extent, to the edge when left out.

    Raises
    ------
    InputError
        It cannot be read, or names what does not exist.

    Examples
    --------
    >>> from drystone.models import tower
    >>> made = virtual_contacts(Model.of(tower(3)), ["kern", "x=0.5@block-0"])
    >>> made.area.round(3).tolist()
    [0.028, 0.056]
    """
    made = model.contacts
    for word in [words] if isinstance(words, str) else words:
        what, _, blocks = word.partition("@")
        try:
            made = _reduced(model, made, what.strip(), _joints(model, blocks.strip()))
        except InputError as error:
            raise error.located(_WHERE) from error
    return made


def _joints(model: Model, blocks: str) -> Bools:
    """Which interfaces (m,) are meant."""
    contacts = model.contacts
    if not blocks:
        return np.ones(contacts.count, dtype=bool)
    fixed = model.assembly.fixed
    if blocks == "supports" and blocks not in model.assembly.names:
        beside: Bools = fixed[contacts.block_a] | fixed[contacts.block_b]
        return beside
    which = model.assembly.indices([name.strip() for name in blocks.split(",")])
    mine = np.isin(contacts.block_a, which), np.isin(contacts.block_b, which)
    found: Bools = mine[0] & mine[1] if len(which) > 1 else mine[0] | mine[1]
    if not found.any():
        raise InputError(f"there is no joint of {blocks}", remedy="name blocks that touch")
    return found


def _reduced(model: Model, contacts: Contacts, what: str, which: Bools) -> Contacts:
    if what == "kern":
        return virtual.to_kern(contacts, which)
    direction, _, share = what.partition("=")
    try:
        towards = _direction(model, contacts, direction)
        size = float(what) if towards is None else float(share or 0.0)
    except ValueError as error:
        remedy = "write kern, a share such as 0.5, or a side such as -z=0.2 or in=0.2"
        raise InputError(f"'{what}' is no virtual interface", remedy=remedy) from error
    if towards is None:
        return virtual.shrink(contacts, size, which)
    return virtual.shift(contacts, towards, size, which)


def _direction(model: Model, contacts: Contacts, text: str) -> list[float] | Floats | None:
    """Vectors (3,) or (m, 3) of a text such as ``-z`` or ``in``; None where it is no direction."""
    if text in ("in", "out"):
        middle = model.assembly.centroid[model.assembly.fixed].mean(axis=0)
        away = virtual.section_centroids(contacts) - middle
        return -away if text == "in" else away
    if text.lstrip("+-") in ("x", "y", "z"):
        sign = -1.0 if text.startswith("-") else 1.0
        return [sign * (text[-1] == axis) for axis in "xyz"]
    return [float(one) for one in text.split(",")] if "," in text else None
