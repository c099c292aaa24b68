"""Virtual interfaces: joints with a reduced polygon, as new contacts.

Forces at the corners of a smaller polygon keep the centre of pressure inside it. Reduced joints
describe other states of equilibrium: within the kern, at the extrados or the intrados, or with a
margin all around. What a joint bears beyond friction shrinks with its area; ties stay as they are.
Where no such state exists, the penalised form of :func:`drystone.solve_rbe` shows the joints in
which the thrust line leaves the polygon.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, dot, frozen_floats
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.base.settings import hold
from drystone.contacts import Contacts
from drystone.geometry.frames import unit
from drystone.geometry.kern import Sections, kern, sections

_Choice = Sequence[int] | Ints | Bools | None
"""Interfaces by position or mask; all when None."""

JointSections = tuple[Floats, Floats, Sections]
"""What :func:`joint_sections` gives."""


def local_corners(contacts: Contacts) -> tuple[Floats, Floats]:
    """Mean corner (m, 3) [m] of every interface, and the corners (k, 2) about it along u and v.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    """
    if contacts.count == 0:
        return np.zeros((0, 3)), np.zeros((0, 2))
    origin = contacts.corners.mean(contacts.point)
    away = contacts.point - origin[contacts.interface]
    flat: Floats = np.einsum("kij,kj->ki", contacts.frame[contacts.interface, 1:], away)
    return origin, flat


def joint_sections(contacts: Contacts) -> JointSections:
    """Mean corners (m, 3), corners about them (k, 2), and the moments of every interface.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    """
    origin, flat = local_corners(contacts)
    return origin, flat, sections(flat, contacts.corners)


def section_centroids(contacts: Contacts) -> Floats:
    """Centroid (m, 3) [m] of the area of every interface.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    """
    origin, _, made = joint_sections(contacts)
    return origin + np.einsum("mi,mij->mj", made.centroid, contacts.frame[:, 1:])


def shrink(contacts: Contacts, factor: float, interfaces: _Choice = None) -> Contacts:
    """Interfaces scaled about their centroids.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    factor : >= 0, <= 1
        From 0 (a point) to 1 (unchanged).
    interfaces
        Which; all when left out.

    Raises
    ------
    InputError
        The factor is outside 0 to 1, or an interface does not exist.
    """
    centre = section_centroids(contacts)[contacts.interface]
    return _reshaped(contacts, centre + factor * (contacts.point - centre), interfaces)


def shift(
    contacts: Contacts, direction: Any, factor: float, interfaces: _Choice = None
) -> Contacts:
    """Interfaces compressed towards the side that lies farthest along a direction.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    direction : (3,) or (m, 3)
        One for all, or one for each interface; its component in the plane of the interface counts.
    factor : >= 0, <= 1
        Remaining share of the extent along the direction: 0 keeps only the edge.
    interfaces
        Which; all when left out.

    Raises
    ------
    InputError
        A direction is normal to one of the chosen interfaces.
    """
    mask = _mask(contacts, interfaces)
    given = np.asarray(direction, dtype=np.float64)
    if given.ndim == 1:
        given = np.broadcast_to(unit(given, "direction"), (contacts.count, 3))
    given = frozen_floats(given, (contacts.count, 3), "direction")
    normal = contacts.frame[:, 0]
    plane = given - dot(given, normal)[:, None] * normal
    length = np.linalg.norm(plane, axis=1)
    lost = np.flatnonzero(mask & (length <= 1e-9 * np.linalg.norm(given, axis=1)))
    if len(lost):
        raise InputError(
            "the direction is normal to the interface",
            where=f"interface {lost[0]}",
            remedy="give a direction with a component in its plane, or leave the interface out",
        )
    plane /= np.where(length > 0.0, length, 1.0)[:, None]
    along = dot(contacts.point, plane[contacts.interface])
    far = contacts.corners.spread(contacts.corners.max(along))
    moved = contacts.point + ((1.0 - factor) * (far - along))[:, None] * plane[contacts.interface]
    return _reshaped(contacts, moved, mask)


def to_kern(contacts: Contacts, interfaces: _Choice = None) -> Contacts:
    """Interfaces reduced to their kerns: a force there puts the whole joint in compression.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    interfaces
        Which, by number or a mask (m,); all when left out.
    """
    mask = _mask(contacts, interfaces)
    origin, flat = local_corners(contacts)
    loops = [flat[contacts.start[i] : contacts.start[i + 1]] for i in range(contacts.count)]
    return _replaced(contacts, origin, [kern(c) if mask[i] else c for i, c in enumerate(loops)])


def _mask(contacts: Contacts, interfaces: _Choice) -> Bools:
    mask = np.zeros(contacts.count, dtype=bool)
    try:
        mask[slice(None) if interfaces is None else np.asarray(interfaces)] = True
    except IndexError as error:
        raise InputError(
            f"there is no such interface: {error}", remedy=f"0 to {contacts.count - 1} exist"
        ) from error
    return mask & ~contacts.ties


def _reshaped(contacts: Contacts, point: Floats, interfaces: _Choice) -> Contacts:
    """Contacts with moved corners of the chosen interfaces; coincident corners are merged."""
    mask = _mask(contacts, interfaces)
    kept = np.where(mask[contacts.interface, None], point, contacts.point)
    moved = replace(contacts, point=kept)
    origin, flat = local_corners(moved)
    _, before = local_corners(contacts)
    size = np.sqrt((before**2).sum(axis=1))
    loops = []
    for i in range(contacts.count):
        part = slice(contacts.start[i], contacts.start[i + 1])
        loops.append(_distinct(flat[part], ROUNDING * float(size[part].max())))
    return _replaced(contacts, origin, loops)


def _distinct(corners: Floats, least: float) -> Floats:
    """A loop without repeated corners. A loop without area becomes its two ends, or one point."""
    if len(corners) < 2:
        return corners
    spread = corners - corners.mean(axis=0)
    far = spread[np.argmax((spread**2).sum(axis=1))]
    length = float(np.linalg.norm(far))
    if length <= least:
        return corners.mean(axis=0, keepdims=True)
    across = spread @ np.array([-far[1], far[0]]) / length
    if np.abs(across).max() <= least:
        along = spread @ far
        return corners[[int(np.argmin(along)), int(np.argmax(along))]]
    apart = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1) > least
    return corners[apart]


def _replaced(contacts: Contacts, origin: Floats, loops: list[Floats]) -> Contacts:
    """The same joints with other corners, given about ``origin`` along u and v."""
    if not loops:
        return contacts
    count = np.array([len(loop) for loop in loops], dtype=np.intp)
    interface = np.repeat(np.arange(contacts.count, dtype=np.intp), count)
    flat = np.concatenate(loops)
    start = Ragged.from_counts(count).start
    point = origin[interface] + np.einsum("ki,kij->kj", flat, contacts.frame[interface, 1:])
    area = np.where(contacts.ties, contacts.area, sections(flat, start).area)
    return contacts.with_areas(area, point=point, interface=interface)


__all__ = [
    "joint_sections",
    "local_corners",
    "section_centroids",
    "shift",
    "shrink",
    "to_kern",
]

hold(globals())
