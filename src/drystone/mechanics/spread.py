"""The same joints with contact points spread over their faces.

How pressure is spread within a joint is as unknown as between joints. Forces at the corners alone
are one extreme. With points inside, the same springs give the pressure of a whole face. Each point
is an interface of its own, with the area for which it stands.
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Bools, lengths
from drystone.contacts import Contacts
from drystone.geometry.quadrature import face_points
from drystone.joints import Resultants, bearable, sliding_use, utilisation_of
from drystone.virtual import joint_sections

MUCH, TWISTED = 0.5, 0.01
"""Use of a face, and the part of it that is torsion, from which on its corners may be needed.
Measured on 148 models that stand and have joints that turn: spread points do not hold two lunes,
used to 1.00. From a use of 1 on, or a part of 0.03, they would be missed, both or one; from nothing
on twice as many are tried, and no more is found."""


def turned_faces(contacts: Contacts, resultants: Resultants) -> Bools:
    """The faces (m,) that turn, if one is used so much that its torsion may need its corners.

    Otherwise none. A sum tells which faces may be used so much: that of the use by the force, and
    of the torque by what friction in proportion to the distance from the centre of pressure would
    resist. Force and torque together are resisted better.
    """
    origin, corners, made = joint_sections(contacts)
    at = np.einsum("mij,mj->mi", contacts.frame[:, 1:], resultants.position - origin)
    far = contacts.corners.max(lengths(corners - at[contacts.interface]))
    resisted = bearable(contacts, resultants.normal) * np.trace(made.inertia, axis1=1, axis2=2)
    sliding = sliding_use(contacts, resultants)
    twist = np.abs(resultants.torque) * far

    def may_exceed(least: float) -> Bools:
        return np.asarray(twist > np.maximum(least - sliding, TWISTED) * resisted)

    much = may_exceed(MUCH)
    if not much.any():
        return much
    twisted = sliding + TWISTED
    enough = np.where(much, np.maximum(MUCH, twisted), twisted)
    used = utilisation_of(contacts, resultants, may_exceed(0.0), enough)
    found: Bools = (used > twisted) & (used[much] > enough[much]).any()
    return found


def spread(contacts: Contacts, faces: Bools) -> Contacts:
    """The contacts with points on some faces in place of their corners, the faces that stay first.

    Parameters
    ----------
    contacts
        Of dry joints.
    faces : (m,)
        Lines and points among them stay as they are: they have no area.
    """
    origin, corners, made = joint_sections(contacts)
    chosen = faces & (made.area > 0.0)
    which = np.flatnonzero(chosen)
    part, row = contacts.corners.take(which)
    found = face_points(corners[row], part.start)
    owner = which[found.loops.owner]
    axes = contacts.frame[owner, 1:]
    kept = contacts.select(~chosen)
    point = origin[owner] + np.einsum("pi,pij->pj", found.place, axes)
    count = len(owner)

    def both(name: str) -> np.ndarray:
        return np.concatenate([getattr(kept, name), getattr(contacts, name)[owner]])

    return Contacts(
        both("block_a"),
        both("block_b"),
        both("frame"),
        np.concatenate([kept.area, found.area]),
        both("friction"),
        np.concatenate([kept.point, point]),
        np.concatenate([kept.interface, kept.count + np.arange(count)]),
    )
