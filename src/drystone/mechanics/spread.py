"""The same joints with contact points spread over their faces.

How pressure is spread within a joint is as unknown as between joints. Forces at the corners alone
are one extreme. With points inside, the same springs give the pressure of a whole face. Each point
is an interface of its own, with the area for which it stands.
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Bools
from drystone.contacts import Contacts
from drystone.geometry.quadrature import face_points
from drystone.virtual import joint_sections


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
