"""How much of their friction joints use: by a force along their faces, and by a torque.

A dry face bears the torque that friction resists under a linear pressure that does not pull.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import (
    ROUNDING,
    Bools,
    Floats,
    Ints,
    cross,
    dot,
    frozen,
    lengths,
    plane_cross,
)
from drystone.base.ragged import Ragged
from drystone.contacts import Contacts
from drystone.geometry.kern import Sections, edge_ratio, linear_pressure
from drystone.geometry.quadrature import FacePoints, cut_face_points
from drystone.geometry.slipping import Slip, clipped, slip_use
from drystone.joints import Resultants, bearable
from drystone.virtual import JointSections, joint_sections

LINE = 2e-4
"""Width of a line as a face, by its length: so it has twice the least area of a corner."""

TWISTED = 1e-3
"""A smaller torque, by the friction of a face times the root of its area, is not counted."""


def sliding_use(contacts: Contacts, resultants: Resultants) -> Floats:
    """Tangential by the largest tangential force that it can bear (m,); infinite for none."""
    normal, tangential = resultants.normal, resultants.tangential
    capacity = bearable(contacts, normal)
    least = ROUNDING * max(float(normal.max(initial=0.0)), 1e-300)
    loaded = (normal > least) | ~contacts.dry
    return frozen(
        np.where(
            loaded & (capacity > 0.0),
            tangential / np.where(capacity > 0.0, capacity, 1.0),
            np.where(loaded & (tangential > least), np.inf, 0.0),
        )
    )


def utilisation_of(contacts: Contacts, resultants: Resultants) -> Floats:
    """Force and torque in the plane by the largest that it can bear (m,); infinite for none.

    A dry face bears the torque that friction resists under a linear pressure that does not pull.
    Above 1 it needs forces at its corners, which resist more. A line is a narrow face; points bear
    forces only.
    """
    used = sliding_use(contacts, resultants).copy()
    contacts = lines_as_faces(contacts)
    which = np.flatnonzero(twisted(contacts, resultants))
    if len(which):
        faces = PressedFaces.of(contacts, resultants, which, joint_sections(contacts))
        used[which] = np.maximum(used[which], faces.slip(contacts, resultants).use)
    return frozen(used)


def lines_as_faces(contacts: Contacts) -> Contacts:
    """The same interfaces, of which dry lines are narrow faces of four corners."""
    lines = (contacts.corners.counts == 2) & (contacts.area == 0.0) & contacts.dry
    if not lines.any():
        return contacts
    which = np.flatnonzero(lines)
    start, end = contacts.point[contacts.start[which]], contacts.point[contacts.start[which] + 1]
    across = 0.5 * LINE * cross(contacts.frame[which, 0], end - start)
    corners = np.stack([start - across, end - across, end + across, start + across], axis=1)
    others = ~lines[contacts.interface]
    interface = np.concatenate([contacts.interface[others], which.repeat(4)])
    point = np.concatenate([contacts.point[others], corners.reshape(-1, 3)])
    order = np.argsort(interface, kind="stable")
    area = contacts.area.copy()
    area[which] = LINE * lengths(end - start) ** 2
    return replace(contacts, area=area, point=point[order], interface=interface[order])


def twisted(contacts: Contacts, resultants: Resultants) -> Bools:
    """The dry faces (m,) that are pressed and whose torque counts."""
    normal = resultants.normal
    bound = np.maximum(bearable(contacts, normal), 0.0)
    turned: Bools = np.abs(resultants.torque) > TWISTED * np.sqrt(contacts.area) * bound
    turned &= resultants.loaded
    turned &= contacts.dry & (contacts.area > 0.0) & (bound > 0.0)
    return turned


@dataclass(frozen=True, eq=False)
class PressedFaces:
    """The linear pressure of t faces, along u and v.

    Attributes
    ----------
    which : (t,)
    loops : Ragged
        Corners of each face.
    corners : (l, 2) [m]
        From the centre of pressure, as all places here.
    area : (t,) [m2]
    plane : (t, 3)
        As :func:`drystone.geometry.kern.linear_pressure` gives it. The pressure has its centre
        at the origin, or just within the rim for a force on it.
    """

    which: Ints
    loops: Ragged
    corners: Floats
    area: Floats
    plane: Floats

    @classmethod
    def of(
        cls, contacts: Contacts, resultants: Resultants, which: Ints, joints: JointSections
    ) -> PressedFaces:
        """Some faces (t,) under their forces; ``joints`` are the sections of all."""
        loops, row = contacts.corners.take(which)
        origin, corners, made = joints
        centre = _along_faces(contacts, resultants.position - origin, which)
        local = corners[row] - centre[loops.owner]
        area, centroid = made.area[which], made.centroid[which] - centre
        some = Sections(area, centroid, made.inertia[which], made.inverse[which])
        far = edge_ratio(some, local, loops, np.zeros_like(centre))
        rim = 1.0 - TWISTED  # a force there acts just within it
        within = centroid * (1.0 - rim / np.maximum(far, rim))[:, None]
        return cls(which, loops, local, area, linear_pressure(some, local, loops, within))

    def slip(self, contacts: Contacts, resultants: Resultants, least: Floats | float = 0.0) -> Slip:
        """How much of their friction force and torque use (t,), and how they slip."""
        which, owner = self.which, self.loops.owner
        height = self.plane[owner, 0] + dot(self.corners, self.plane[owner, 1:])
        loops, corners = clipped(self.loops, self.corners, height)
        each = self.area / bearable(contacts, resultants.normal)[which]
        force = each[:, None] * _along_faces(contacts, resultants.force, which)
        return slip_use(corners, loops, self.plane, force, each * resultants.torque[which], least)

    def points(self, wanted: Bools, pole: Floats) -> FacePoints:
        """As many points of some (t,) as make their torsion about poles (t, 2) right."""
        loops, row = self.loops.take(wanted)
        return cut_face_points(self.corners[row], loops, self.plane[wanted], pole[wanted])


def _along_faces(contacts: Contacts, vectors: Floats, which: Ints) -> Floats:
    """Vectors (m, 3) of some interfaces (t,) along u and v, (t, 2)."""
    return np.einsum("mij,mj->mi", contacts.frame[which, 1:], vectors[which])


MUCH, TURNED, LEVER = 0.97, 0.01, 0.75
"""Use of a face, and the part of it that is torsion, from which on it has points. What uses less
carries its force and torque as it is. Measured on 148 models that stand and have joints that turn:
spread points do not hold two lunes, used to 1.00. From a part of 0.03 one would be missed. From a
use of 0.95 one dome is not found to stand at once, and from 0.9 one of 2,000 blocks that is tilted
by 20 degrees has a third more points; from 0.99 points are added five times in place of twice. And
least mean distance of pressure from its centre, by that of the centre from the rim, of a face that
is pressed in part. Measured on 23,000 convex and concave ones: 0.83 or more."""


def spread_where_turned(
    contacts: Contacts, resultants: Resultants
) -> tuple[Contacts, Bools, Floats] | None:
    """The contacts of dry joints with points on the faces that turn in place of their corners.

    How pressure is spread within a joint is as unknown as between joints. Forces at the corners
    alone are one extreme. With points inside, the same springs give the pressure of a whole face.
    Each point is an interface of its own, with the area for which it stands.

    None unless one is used so much that its torsion may need its corners. Which of those that are
    pressed all over may be is told by friction that grows with the distance from the centre of
    pressure, beside that against the force, at the corner used most. They resist better. Of those
    that are pressed in part it is told by the use of force and torque each alone: both together use
    no more than the sum. Faces that stay are first; with it come which corners (k,) these are,
    and the forces (p, 3) [N] of the others as if each pressed evenly, local n, u, v.
    """
    given, contacts = contacts, lines_as_faces(contacts)
    turns = np.flatnonzero(twisted(contacts, resultants))
    if not len(turns):
        return None
    faces = contacts.select(turns)
    forces = Resultants(*(each[turns] for each in vars(resultants).values()))
    origin, corners, made = sections = joint_sections(faces)
    axes, joint = faces.frame[:, 1:], faces.interface
    centre = np.einsum("mij,mj->mi", axes, forces.position - origin)
    bound = bearable(faces, forces.normal)
    force = np.einsum("mij,mj->mi", axes, forces.force) / bound[:, None]
    polar = bound * np.trace(made.inertia, axis1=1, axis2=2)
    turn = (forces.torque / polar)[joint, None] * [-1.0, 1.0]
    away = corners - centre[joint]
    across = turn * away[:, ::-1]
    together = faces.corners.max(lengths(force[joint] + across))
    sliding = sliding_use(faces, forces)
    least = np.maximum(MUCH, sliding + TURNED)
    lever = np.einsum("mij,mj->mi", made.inverse, centre - made.centroid)
    opened = faces.corners.min(dot(corners - made.centroid[joint], lever[joint])) < -1.0
    edge = corners[faces.corners.following] - corners
    rim = faces.corners.min(plane_cross(away, edge) / np.maximum(lengths(edge), 1e-300))
    alone = np.abs(forces.torque) / bound > (least - sliding) * LEVER * rim
    which = np.flatnonzero(np.where(opened, alone, together > least))
    if not len(which):
        return None
    pressed = PressedFaces.of(faces, forces, which, sections)
    slip = pressed.slip(faces, forces, least[which])
    wanted = slip.use > least[which]
    if not wanted.any():
        return None
    points = pressed.points(wanted, slip.pole)
    owner = turns[which[wanted]][points.loops.owner]
    away = np.einsum("pi,pij->pj", points.place, contacts.frame[owner, 1:])
    spread = given.with_points(owner, resultants.position[owner] + away, points.area)
    stays = np.isin(np.arange(contacts.count), owner, invert=True)
    share = points.area / np.bincount(owner, points.area, contacts.count)[owner]
    force = np.einsum("pij,pj->pi", contacts.frame[owner], resultants.force[owner])
    return spread, stays[given.interface], share[:, None] * force
