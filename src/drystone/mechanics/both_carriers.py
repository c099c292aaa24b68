"""Whether it matters which of two blocks carries an end where the faces of both end flush.

A corner at such an end goes with the block that carries it. The two choices put the corner in
places that differ by how far one face has slid over the other, along the normal of the end. Where
that is tiny while the corner presses, both choices lead to the same motion: a wall that
topples hinges on its edges, and hardly slides.
"""

from __future__ import annotations

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, Ints, lengths
from drystone.contacts import Contacts
from drystone.mechanics.bodies import Bodies
from drystone.mechanics.corners import Carrier, joint_ends
from drystone.mechanics.positions import BlockPositions
from drystone.mechanics.roles import as_turned

ALIKE = 2e-4
"""Distance of the two places of a corner, by the mean size of a block, that decides nothing: as
long as an increment. Measured where both were followed: at most 1e-4 in 31 models whose two motions
were the same, 2e-3 or more in six wedges whose motions were not; there the larger of two components
was taken, here the length, up to 1.4 times as long."""

ROWS = 100_000
"""Corners times poses that are looked at together."""


def ends_alike(
    assembly: Assembly,
    contacts: Contacts,
    gap: Floats,
    carrier: Carrier,
    bodies: Bodies,
    frames: tuple[BlockPositions, ...],
) -> bool:
    """Whether the other carrier would have led to the same motion.

    Parameters
    ----------
    assembly, contacts
        Whose blocks were followed.
    gap : (k, 2) [m]
        Distance of each corner from the faces of a and b at the beginning, along n.
    carrier
        With which they were followed.
    bodies
        The same, scaled.
    frames
        Their poses.
    """
    other = Carrier.RESTING if carrier is Carrier.MOVING else Carrier.MOVING
    ends = as_turned(joint_ends(assembly, contacts, other, gap), bodies.turned)
    change = bodies.ends.tangent - ends.tangent
    corner = np.flatnonzero(change.any(axis=(1, 2)))
    step = max(ROWS // max(len(corner), 1), 1)
    return all(
        _farthest(bodies, corner, change[corner], frames[at : at + step]) <= ALIKE
        for at in range(0, len(frames), step)
    )


def beyond_flush_ends(bodies: Bodies, pose: BlockPositions) -> float:
    """How far corners that press have gone beyond ends where both faces end, scaled.

    By so much the face of the block that does not carry them has to be longer.
    """
    corner = np.flatnonzero(bodies.ends.flush.any(axis=1))
    local = _apart(bodies, corner, (pose,))[0]
    ends = bodies.ends
    along = np.einsum("kij,kj->ki", ends.outward[corner], local[:, 1:]) * ends.sense[corner]
    counts = ends.flush[corner] & (local[:, :1] < bodies.overlap)
    return float(np.where(counts, along, 0.0).max(initial=0.0))


def _farthest(
    bodies: Bodies, corner: Ints, change: Floats, frames: tuple[BlockPositions, ...]
) -> float:
    """Largest distance of the two places of a corner that presses, in some poses."""
    local = _apart(bodies, corner, frames)
    moved = lengths((change @ local[..., 1:, None])[..., 0])
    return float(np.where(local[..., 0] < bodies.overlap, moved, 0.0).max(initial=0.0))


def _apart(bodies: Bodies, corner: Ints, frames: tuple[BlockPositions, ...]) -> Floats:
    """(s, c, 3) from the corner on a to that on b in the axes of a, in some poses."""
    place = np.stack([one.place for one in frames])
    turn = np.stack([one.turn for one in frames])
    a, b = bodies.block_a[corner], bodies.block_b[corner]
    turn_a = turn[:, a]
    apart = place[:, b] + (turn[:, b] @ bodies.arm_b[corner][:, :, None])[..., 0]
    apart -= place[:, a] + (turn_a @ bodies.arm_a[corner][:, :, None])[..., 0]
    local: Floats = (bodies.frame[corner] @ (turn_a.swapaxes(2, 3) @ apart[..., None]))[..., 0]
    return local
