"""The first motion of blocks at their joints, and the forces in the joints at that moment."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Bools, Floats, frozen
from drystone.base.display import OneLine
from drystone.checks import block_speed, corner_motion
from drystone.contacts import Contacts
from drystone.geometry.kern import edge_ratio
from drystone.joints import LOADED, Resultants, resultants_of, utilisation_of
from drystone.model import Model
from drystone.virtual import joint_sections

STILL = 1e-2
"""A corner is at rest, or a gap stays closed, if the motion there is below this share of the larger
motion of the two blocks. Chosen: half a degree of direction."""

_FULL = 1e-3
"""Friction is at its limit, and a joint is a hinge, within this share of the limit. Chosen: above
the error due to weak ground springs."""


class JointMotion(enum.Enum):
    """The first motion of a block relative to a neighbour."""

    STAYS = "stays on"
    SLIDES = "slides along"
    HINGES = "hinges about an edge of"
    LIFTS = "lifts off"
    DROPS = "drops away from"


@dataclass(frozen=True, eq=False)
class JointState(OneLine):
    """Motion and forces at one interface of a block that needs help.

    Attributes
    ----------
    interface
        Its position in the contacts of the model.
    block, neighbour
        Positions of the block that needs help, and of the other one.
    motion
    direction : (3,) unit
        Direction of the motion of the block relative to its neighbour, at the middle of the
        interface; zero if it stays.
    edge : (2, 3) [m]
        Ends of the edge about which it hinges; ``None`` for other motions.
    normal : [N]
        Normal force during the first motion.
    friction_use
        Tangential force divided by its limit.
    idle
        It carries nothing.
    spent
        Its friction is at the limit.
    hinge
        It presses along one edge only.
    """

    interface: int
    block: int
    neighbour: int
    motion: JointMotion
    direction: Floats
    edge: Floats | None
    normal: float
    friction_use: float
    idle: bool
    spent: bool
    hinge: bool


def joint_states(
    model: Model, needy: Bools, interfaces: Bools, motion: Floats, force: Floats | None
) -> tuple[JointState, ...]:
    """The state of each chosen interface; between two falling blocks, seen from the first one.

    Parameters
    ----------
    model
    needy : (n,)
    interfaces : (m,)
    motion : (n, 6)
    force : (k, 3) [N], local n, u, v; zero when left out
    """
    contacts = model.contacts
    moved = corner_motion(model.assembly, contacts, motion)
    speed = block_speed(model.assembly, motion)
    given = np.zeros((contacts.corner_count, 3)) if force is None else force
    resultants = resultants_of(contacts, given)
    weight = np.linalg.norm(model.load.wrench[:, :3], axis=1)
    seen_from_a = needy[contacts.block_a] | ~needy[contacts.block_b]
    block = np.where(seen_from_a, contacts.block_a, contacts.block_b)
    neighbour = np.where(seen_from_a, contacts.block_b, contacts.block_a)
    idle = resultants.normal <= max(LOADED, 1e-6) * weight[block]
    use = np.where(idle, 0.0, utilisation_of(contacts, resultants))
    hinge = ~idle & (_eccentricity(contacts, resultants) >= 1.0 - _FULL)
    states = []
    for i in np.flatnonzero(interfaces).tolist():
        sign = -1.0 if seen_from_a[i] else 1.0
        corners = moved[contacts.start[i] : contacts.start[i + 1]]
        reach = float(max(speed[block[i]], speed[neighbour[i]]))
        kind = _kind(corners, reach, sign * contacts.frame[i, 0], contacts.frame[i], sign)
        mean = sign * contacts.frame[i].T @ corners.mean(axis=0)
        size = float(np.linalg.norm(mean))
        states.append(
            JointState(
                i,
                int(block[i]),
                int(neighbour[i]),
                kind,
                frozen(np.zeros(3) if kind is JointMotion.STAYS or size == 0.0 else mean / size),
                _edge(contacts, i, corners) if kind is JointMotion.HINGES else None,
                float(resultants.normal[i]),
                float(use[i]),
                bool(idle[i]),
                bool(use[i] >= 1.0 - _FULL),
                bool(hinge[i]),
            )
        )
    return tuple(states)


def _eccentricity(contacts: Contacts, resultants: Resultants) -> Floats:
    """Eccentricity (m,) of the resultant relative to the edge of the joint: 1 is a hinge."""
    origin, corners, made = joint_sections(contacts)
    at = np.einsum("mij,mj->mi", contacts.frame[:, 1:], resultants.position - origin)
    return edge_ratio(made, corners, contacts.start, at)


def _kind(moved: Floats, reach: float, away: Floats, frame: Floats, sign: float) -> JointMotion:
    """The kind of motion from that of the corners (c, 3), local, of block b against a.

    Parameters
    ----------
    moved, reach
    away : (3,)
        Unit normal from the neighbour to the block.
    frame, sign
        Of the interface; 1 where the block is block b.
    """
    opening, slide = moved[:, 0], np.linalg.norm(moved[:, 1:], axis=1)
    if max(np.abs(opening).max(), slide.max()) <= STILL * reach:
        return JointMotion.STAYS
    closed = opening <= STILL * np.maximum(slide.max(), reach * STILL)
    if closed.all():
        return JointMotion.SLIDES
    if closed.any():
        return JointMotion.HINGES
    mean = sign * frame.T @ moved.mean(axis=0)
    return JointMotion.DROPS if away[2] < 0.0 and mean[2] < 0.0 else JointMotion.LIFTS


def _edge(contacts: Contacts, interface: int, moved: Floats) -> Floats:
    """The two corners that open least."""
    order = np.argsort(moved[:, 0], kind="stable")[:2]
    corners: Floats = contacts.polygon(interface)[np.sort(order)]
    return frozen(np.array(corners))
