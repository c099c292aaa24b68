"""Blocks on which nothing presses: they fall freely."""

from __future__ import annotations

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, dot
from drystone.checks import block_speed, point_motion
from drystone.contacts import Contacts

APPROACH = 1e-3
"""A corner is pressed when free blocks approach it by more than this share of their speed: it then
overlaps by as much of their motion, and the source bounds slides by a thousand overlaps."""

NO_APPROACH = 1e-7
"""The same for faces along which blocks fall freely: less is rounding of their coordinates."""


def unpressed(
    assembly: Assembly, contacts: Contacts, acceleration: Floats, least: float = APPROACH
) -> Bools:
    """The largest set (n,) of free blocks whose free motion approaches no corner.

    Parameters
    ----------
    assembly, contacts
    acceleration : (n, 6)
        Of each block under its load alone; blocks outside the set rest.
    least
        Share of its speed by which a block that is pressed approaches a corner. A block at a joint
        that is not dry counts as pressed.
    """
    speed = block_speed(assembly, acceleration)
    falling = ~assembly.fixed & (speed > 0.0)
    joint = contacts.interface
    holds = ~contacts.dry[joint]  # a joint that pulls or coheres need not be pressed
    a, b = contacts.block_a, contacts.block_b
    away_a, away_b = _along_normals(assembly, contacts, acceleration)

    def approach(opening: Floats, reach: Floats) -> Bools:
        near = (opening < -least * reach[joint]) | holds
        return np.bincount(joint[near], minlength=contacts.count) > 0

    both = approach(away_b - away_a, np.maximum(speed[a], speed[b]))
    only_a, only_b = approach(-away_a, speed[a]), approach(away_b, speed[b])
    while falling.any():
        of_a, of_b = falling[a], falling[b]
        pressed = (of_a & of_b & both) | (of_a & ~of_b & only_a) | (of_b & ~of_a & only_b)
        if not pressed.any():
            break
        falling[a[pressed]] = falling[b[pressed]] = False
    return falling


def closing_blocks(assembly: Assembly, contacts: Contacts, motion: Floats) -> Bools:
    """The blocks (n,) of which a corner closes by a share of their way in a motion (n, 6)."""
    away_a, away_b = _along_normals(assembly, contacts, motion)
    speed = block_speed(assembly, motion)
    found = np.zeros(len(assembly), dtype=bool)
    for block in (contacts.block_a, contacts.block_b):
        of_corner = block[contacts.interface]
        found[of_corner[away_b - away_a < -APPROACH * speed[of_corner]]] = True
    return found


def _along_normals(assembly: Assembly, contacts: Contacts, motion: Floats) -> tuple[Floats, Floats]:
    """(k,) motion of each corner along the normal of its joint, with block a and with block b."""
    of_a, of_b = (
        dot(
            point_motion(assembly, contacts, motion, block[contacts.interface]),
            contacts.frame[contacts.interface, 0],
        )
        for block in (contacts.block_a, contacts.block_b)
    )
    return of_a, of_b


def beside_supports(assembly: Assembly, contacts: Contacts, falling: Bools) -> bool:
    """Whether blocks (n,) that fall touch none but each other and supports.

    A free block that stands without them may still settle against them.
    """
    a, b = contacts.block_a, contacts.block_b
    other = np.where(falling[a], b, a)[falling[a] != falling[b]]
    return bool(assembly.fixed[other].all())
