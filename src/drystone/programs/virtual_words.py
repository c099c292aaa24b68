"""Virtual interfaces in words: ``kern``, ``0.5``, ``-z``, of all joints or of those of blocks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone import virtual
from drystone.base.arrays import Bools
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.model import Model
from drystone.supports import UP

_WHERE = "virtual"


def virtual_contacts(model: Model, words: Sequence[str]) -> Contacts:
    """The contacts of a model, some of them reduced.

    Parameters
    ----------
    model
    words
        Each is ``WHAT`` or ``WHAT@BLOCKS``: the joints of one block, or those between several,
        separated by commas. ``WHAT`` is ``kern``, a share of the size from 0 (a point) to 1, or a
        direction, such as ``-z``, ``x=0.2`` or ``1,0,1``: the joint is compressed towards that side
        to a share of its extent, to the edge when left out.

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
            made = _reduced(made, what.strip(), _joints(model, blocks))
        except InputError as error:
            raise error.located(_WHERE) from error
    return made


def _joints(model: Model, blocks: str) -> Bools:
    """Which interfaces (m,) are meant."""
    contacts = model.contacts
    if not blocks:
        return np.ones(contacts.count, dtype=bool)
    which = model.assembly.indices([name.strip() for name in blocks.split(",")])
    mine = np.isin(contacts.block_a, which), np.isin(contacts.block_b, which)
    found: Bools = mine[0] & mine[1] if len(which) > 1 else mine[0] | mine[1]
    if not found.any():
        raise InputError(f"there is no joint of {blocks}", remedy="name blocks that touch")
    return found


def _reduced(contacts: Contacts, what: str, which: Bools) -> Contacts:
    if what == "kern":
        return virtual.to_kern(contacts, which)
    direction, equals, share = what.partition("=")
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": UP}
    sign = -1.0 if direction.startswith("-") else 1.0
    axis = axes.get(direction.lstrip("+-"))
    try:
        share_alone = axis is None and "," not in direction and not equals
        size = float(direction) if share_alone else float(share) if equals else 0.0
        given = [] if share_alone or axis else [float(one) for one in direction.split(",")]
    except ValueError as error:
        remedy = "write kern, a share such as 0.5, or a direction such as -z=0.2"
        raise InputError(f"'{what}' is no virtual interface", remedy=remedy) from error
    if share_alone:
        return virtual.shrink(contacts, size, which)
    towards = given if axis is None else sign * np.asarray(axis)
    return virtual.shift(contacts, towards, size, which)
