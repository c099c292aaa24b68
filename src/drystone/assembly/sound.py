"""Blocks whose surface touches or crosses itself."""

from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakSet

import numpy as np

from drystone.assembly.block import Block
from drystone.base.arrays import Bools
from drystone.base.errors import DefectKind, InputError
from drystone.geometry.selfcontact import self_contacts

_SOUND: WeakSet[Block] = WeakSet()
"""Blocks that were found sound; a block never changes."""


def self_touching(blocks: Sequence[Block]) -> list[tuple[int, InputError]]:
    """Which of some blocks touch or cross themselves, and the error of each.

    A block that was made with ``checked=False`` is taken as it is.
    """
    new = [i for i, block in enumerate(blocks) if block.checked and block not in _SOUND]
    chosen = [blocks[i] for i in new]
    found = self_contacts([one.vertices for one in chosen], [one.faces for one in chosen])
    faulty = {body for body, _ in found}
    _SOUND.update(block for i, block in enumerate(chosen) if i not in faulty)
    return [
        (
            new[body],
            InputError(
                f"its surface {what}",
                where=f"block '{chosen[body].name}'",
                remedy="separate the parts there, or split it into two blocks",
                kind=DefectKind.TOUCHING if what.startswith("touches") else DefectKind.CROSSING,
            ),
        )
        for body, what in found
    ]


def require_sound(blocks: Sequence[Block], simple: Bools | None = None) -> None:
    """Raise InputError where a block touches or crosses itself; not where (n,) it is known not to.

    What is known once is not looked at again.
    """
    if simple is not None:
        _SOUND.update(blocks[i] for i in np.flatnonzero(simple).tolist())
    for _, error in self_touching(blocks):
        raise error
