"""How a region begins to move: motion and forces at each of its joints, and as a sentence."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import ROUNDING, Bools, Floats, frozen, lengths
from drystone.base.display import OneLine, rounded_up
from drystone.base.errors import counted
from drystone.base.units import quantity
from drystone.checks import block_speed, corner_motion, moving_joints
from drystone.contacts import Contacts
from drystone.design.needs import Needs
from drystone.design.words import (
    NAMED,
    force_words,
    friction_words,
    glue_words,
    joint_name,
    listed,
    names_of,
    place,
)
from drystone.friction_use import utilisation_of
from drystone.joints import resultants_of
from drystone.model import Model

STILL = 1e-2
"""A joint is at rest if the motion of its corners is below this share of the larger
motion of the two blocks. Chosen: half a degree of direction."""

_FULL = 1e-3
"""Friction is at its limit within this share of it. Chosen: above the error due to weak ground
springs."""


_STEEP = 0.5
"""A motion is downwards or upwards if the vertical component of its direction is larger than
this."""


class JointMotion(enum.Enum):
    """The first motion of a block relative to a neighbour."""

    STAYS = "stays on"
    """The corners of the joint hardly move against each other."""
    CRUSHES = "moves by crushing on"
    """They approach each other where the joint is as full as its strength lets it be."""
    SLIDES = "slides along"
    """The face moves along the other without opening."""
    TURNS = "turns about the normal of its joint with"
    """It slides, and one point of the face stays where it is."""
    HINGES = "hinges about an edge of"
    """The joint opens, but for an edge or a corner."""
    DROPS = "drops away from"
    """The joint opens everywhere, and the block moves down from under its neighbour."""
    LIFTS = "lifts off"
    """The joint opens everywhere, and the block moves in any other direction."""


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
        interface, in its plane where it slides; zero if it stays.
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
    seen_from_a = needy[contacts.block_a] | ~needy[contacts.block_b]
    block = np.where(seen_from_a, contacts.block_a, contacts.block_b)
    neighbour = np.where(seen_from_a, contacts.block_b, contacts.block_a)
    idle = resultants.normal <= max(ROUNDING, 1e-6) * lengths(model.load.wrench[block, :3])
    use = np.where(idle, 0.0, utilisation_of(contacts, resultants))
    hinge, slide, _ = moving_joints(model, motion)
    states = []
    for i in np.flatnonzero(interfaces).tolist():
        sign = -1.0 if seen_from_a[i] else 1.0
        corners = moved[contacts.start[i] : contacts.start[i + 1]]
        reach = float(max(speed[block[i]], speed[neighbour[i]]))
        kind = JointMotion.STAYS
        if lengths(corners).max() > STILL * reach:
            away = sign * contacts.frame[i, 0]
            kind = _kind(corners, away, sign * contacts.frame[i].T, bool(hinge[i]), bool(slide[i]))
            if contacts.crushes[i] and corners[:, 0].min() < -STILL * reach:
                kind = JointMotion.CRUSHES
        mean = corners.mean(axis=0)
        mean[0] *= kind is not JointMotion.SLIDES  # a proof opens it by the angle of friction
        mean = sign * contacts.frame[i].T @ mean
        size = float(np.linalg.norm(mean))
        stays = kind is JointMotion.STAYS or size == 0.0
        direction = frozen(np.zeros(3) if stays else mean / size)
        edge = _edge(contacts, i, corners) if kind is JointMotion.HINGES else None
        states.append(JointState(
            i, int(block[i]), int(neighbour[i]), kind, direction, edge,
            float(resultants.normal[i]), float(use[i]), bool(idle[i]), bool(use[i] >= 1.0 - _FULL),
        ))  # fmt: skip
    return tuple(states)


def _kind(moved: Floats, away: Floats, frame: Floats, hinge: bool, slide: bool) -> JointMotion:
    """The kind of motion from that of the corners (c, 3), local, of block b against a.

    Parameters
    ----------
    moved
    away : (3,)
        Unit normal from the neighbour to the block.
    frame : (3, 3)
        From local axes to the motion of the block against its neighbour.
    hinge, slide
        Whether it turns about an edge, and whether it slides.
    """
    if hinge:
        return JointMotion.HINGES
    mean = moved.mean(axis=0)  # less than the rest where the centre of the turn is in the face
    if slide:
        turned = lengths((moved - mean)[:, 1:]).max()
        return JointMotion.TURNS if np.hypot(*mean[1:]) < turned else JointMotion.SLIDES
    return JointMotion.DROPS if away[2] < 0.0 and (frame @ mean)[2] < 0.0 else JointMotion.LIFTS


def _edge(contacts: Contacts, interface: int, moved: Floats) -> Floats:
    """The two corners that open least."""
    order = np.argsort(moved[:, 0], kind="stable")[:2]
    return frozen(np.array(contacts.polygon(interface)[np.sort(order)]))


def sentence(
    model: Model, blocks: tuple[int, ...], joints: Sequence[JointState], needs: Needs, hinge: Bools
) -> str:
    """The motion of a region, its cause, and what would hold it, as text.

    ``hinge`` (m,) are the hinges of the motion that is drawn, of all regions.
    """
    subject = ("block " if len(blocks) == 1 else "blocks ") + names_of(model, blocks)
    parts = [f"{subject} {_motion(model, blocks, joints)}", _beyond(model, blocks, joints)]
    parts.append(_cause(model, blocks, joints, hinge))
    return "; ".join(part for part in (*parts, _remedy(model, blocks, needs)) if part)


_ALONE = {
    JointMotion.CRUSHES: "crush at the joints between them",
    JointMotion.SLIDES: "slide along each other",
    JointMotion.TURNS: "turn about the normals of their joints",
    JointMotion.HINGES: "turn about the edges of their joints",
}
"""What blocks of a region do at the joints between them."""


def _motion(model: Model, blocks: tuple[int, ...], joints: Sequence[JointState]) -> str:
    said: list[str] = []
    for kind in list(JointMotion)[1:]:
        mine = [j for j in joints if j.motion is kind]
        others = list(dict.fromkeys(j.neighbour for j in mine if j.neighbour not in blocks))
        if not mine or (kind is JointMotion.LIFTS and said):
            continue
        if others:
            verb = _verb(kind, mine, len(blocks) > 1, len(others) > 1)
            said.append(f"{verb} {names_of(model, others)}")
        elif len(blocks) > 1:
            said.append(_ALONE.get(kind, "part from each other"))
    return listed(said or ["falls" if len(blocks) == 1 else "fall"])


def _verb(kind: JointMotion, mine: Sequence[JointState], several: bool, edges: bool) -> str:
    """The motion of one block or of several, along one other block or about edges of several."""
    first, _, rest = kind.value.partition(" ")
    if kind is JointMotion.SLIDES:
        vertical = float(np.mean([j.direction[2] for j in mine]))
        way = "down " if vertical < -_STEEP else "up " if vertical > _STEEP else ""
        rest = f"{way}{rest}"
    rest = rest.replace("its", "their") if several else rest
    rest = rest.replace("an edge", "edges").replace("joint", "joints") if edges else rest
    return f"{first.removesuffix('s') if several else first} {rest}"


def _beyond(model: Model, blocks: tuple[int, ...], joints: Sequence[JointState]) -> str:
    """How far the centre of one block that its weight alone pulls is beyond the edge of a joint."""
    turns = [one for one in joints if one.edge is not None]
    force, moment = model.load.wrench[blocks[0]].reshape(2, 3)
    aside = float(np.linalg.norm([*force[:2], *moment / model.assembly.size[blocks[0]]]))
    if len(blocks) > 1 or len(turns) != 1 or aside > -STILL * force[2]:
        return ""
    (one,) = turns
    first, last = np.asarray(one.edge)
    out = np.cross(last - first, (0.0, 0.0, 1.0))
    out *= -np.sign((model.contacts.centroid[one.interface] - first) @ out)
    reach = (model.assembly.centroid[blocks[0]] - first) @ out
    if reach <= STILL * model.assembly.size[blocks[0]] * np.linalg.norm(out):
        return ""
    over = quantity(float(reach / np.linalg.norm(out)), "m")
    neighbour = names_of(model, [one.neighbour])
    return f"its centre is {over} beyond the edge of its joint with {neighbour}"


def _cause(
    model: Model, blocks: tuple[int, ...], joints: Sequence[JointState], hinge: Bools
) -> str:
    """The joints that carry nothing, else those that slide or are hinges."""
    idle = [j for j in joints if j.idle]
    if len(idle) == len(joints):
        return f"nothing presses on {'it' if len(blocks) == 1 else 'them'}"
    said = [
        _joints_with(model, blocks, [j for j in joints if j.idle], "carries nothing"),
        _joints_with(model, blocks, [j for j in joints if j.spent], "has no friction left"),
    ]
    if len(blocks) > 1:
        turns = [joint for joint in joints if hinge[joint.interface]]
        said.append(_joints_with(model, (), turns, "is a hinge"))
    return ", ".join(part for part in said if part)


def _joints_with(
    model: Model, blocks: tuple[int, ...], some: Sequence[JointState], what: str
) -> str:
    """The given joints as text, with names if they are few."""
    if not some:
        return ""
    outer = list(dict.fromkeys(j.neighbour for j in some if j.neighbour not in blocks))
    if len(outer) == 1 and len(some) == 1:
        return f"the joint with {names_of(model, outer)} {what}"
    verb, _, rest = what.partition(" ")
    verb = {"carries": "carry", "has": "have", "is": "are"}[verb]
    rest = rest.replace("a hinge", "hinges")
    if blocks and len(outer) == len(some) <= NAMED:
        return f"the joints with {names_of(model, outer)} {verb} {rest}"
    return f"{counted(len(some), 'joint')} {what if len(some) == 1 else f'{verb} {rest}'}"


def _remedy(model: Model, blocks: tuple[int, ...], needs: Needs) -> str:
    them = "it" if len(blocks) == 1 else "them"
    ways = _supports(model, blocks, needs)
    missing = ""
    # those of several blocks may balance each other: their sum holds nothing
    if not ways and len(blocks) == 1 and float(np.linalg.norm(needs.force)) > 0.0:
        missing = f"a force of {force_words(needs.force)} at {place(needs.point)} is missing"
        force, moment = np.linalg.norm(needs.wrench[0].reshape(2, 3), axis=1)
        low, high = model.assembly.bounds[blocks[0]]
        if ((needs.point < low) | (needs.point > high)).any():  # nothing can push there
            missing = f"a force of {force_words(needs.force)} at its centre and a moment of"
            missing += f" {quantity(moment, 'N m')} are missing"
        if force * model.assembly.size[blocks[0]] < STILL * moment:
            missing = f"a moment of {quantity(moment, 'N m')} is missing"
    if needs.friction is not None:
        ways.append(friction_words("there", needs.friction))
    if needs.ballast is not None:
        name = model.assembly.names[needs.ballast.at[0]]
        ways.append(f"a weight of {quantity(needs.ballast.value, 'N')} on '{name}'")
    if needs.turn is not None:
        name = joint_name(model, blocks, needs.turn.at[0])
        jams = " (which jams)" if needs.turn.jams else ""
        ways.append(f"{name} turned by {rounded_up(needs.turn.value, 2):g} degrees{jams}")
    if needs.glue:
        ways.append(glue_words(model, needs.glue[0].at, needs.glue[0].value))
    hold = f"{', or '.join(ways)} would hold {them}" if ways else ""
    return "; ".join(part for part in (missing, hold) if part)


def _supports(model: Model, blocks: tuple[int, ...], needs: Needs) -> list[str]:
    """The props that hold it; none where none were found."""
    props = needs.props.props
    if not props:
        return []
    if len(props) > 1:
        on, total = names_of(model, [one.block for one in props]), sum(one.size for one in props)
        return [f"{len(props)} supports on {on} that give {quantity(total, 'N')} together"]
    at = "" if len(blocks) == 1 else f" on '{model.assembly.names[props[0].block]}'"
    return [f"a support{at} that gives {force_words(props[0].force)} at {place(props[0].point)}"]
