"""The same joints with contact points spread over their faces.

How pressure is spread within a joint is as unknown as between joints. Forces at the corners alone
are one extreme. With points inside, the same springs give the pressure of a whole face. Each point
is an interface of its own, with the area for which it stands.
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import lengths
from drystone.contacts import Contacts
from drystone.joints import (
    Resultants,
    bearable,
    points_of_faces,
    sliding_use,
    twisted,
    twisted_use,
)
from drystone.virtual import joint_sections

MUCH, TWISTED = 0.5, 0.01
"""Use of a face, and the part of it that is torsion, from which on its corners may be needed.
Measured on 148 models that stand and have joints that turn: spread points do not hold two lunes,
used to 1.00. From a use of 1 on, or a part of 0.03, they would be missed, both or one; from nothing
on twice as many are tried, and no more is found."""


def spread_where_turned(contacts: Contacts, resultants: Resultants) -> Contacts | None:
    """The contacts of dry joints with points on the faces that turn in place of their corners.

    None unless one is used so much that its torsion may need its corners. Which may be is told by
    friction that grows with the distance from the centre of pressure, beside that against the
    force, at the corner used most. Faces pressed all over resist better. Those that stay are first.
    """
    turns = twisted(contacts, resultants)
    if not turns.any():
        return None
    origin, corners, made = joint_sections(contacts)
    axes, joint = contacts.frame[:, 1:], contacts.interface
    centre = np.einsum("mij,mj->mi", axes, resultants.position - origin)
    bound = np.where(turns, bearable(contacts, resultants.normal), np.inf)
    force = np.einsum("mij,mj->mi", axes, resultants.force) / bound[:, None]
    polar = bound * np.where(turns, np.trace(made.inertia, axis1=1, axis2=2), 1.0)
    turn = (resultants.torque / polar)[joint, None] * [-1.0, 1.0]
    across = turn * (corners - centre[joint])[:, ::-1]
    together = contacts.corners.max(lengths(force[joint] + across))
    least = sliding_use(contacts, resultants) + TWISTED
    much = turns & (together > np.maximum(MUCH, least))
    if not much.any():
        return None
    which = np.flatnonzero(turns & (contacts.corners.max(lengths(across)) > TWISTED))
    much, least = much[which], least[which]
    enough = np.where(much, np.maximum(MUCH, least), least)
    points = points_of_faces(contacts, which)
    used = twisted_use(contacts, resultants, which, points, enough)
    if not (used[much] > enough[much]).any():
        return None
    loops, row = points.loops.take(used > least)
    which = which[used > least]
    kept = contacts.select(np.isin(np.arange(contacts.count), which, invert=True))
    owner = which[loops.owner]
    point = origin[owner] + np.einsum("pi,pij->pj", points.place[row], contacts.frame[owner, 1:])

    def both(name: str) -> np.ndarray:
        return np.concatenate([getattr(kept, name), getattr(contacts, name)[owner]])

    return Contacts(
        both("block_a"),
        both("block_b"),
        both("frame"),
        np.concatenate([kept.area, points.area[row]]),
        both("friction"),
        np.concatenate([kept.point, point]),
        np.concatenate([kept.interface, kept.count + np.arange(len(owner))]),
    )
