"""A region that falls as a sentence: how it moves, why, and what would hold it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.errors import counted
from drystone.design.joint_motion import JointMotion, JointState
from drystone.design.needs import Needs
from drystone.design.words import (
    NAMED,
    force_words,
    friction_words,
    glue_words,
    joint_name,
    listed,
    names_of,
    newtons,
    place,
    rounded_up,
)
from drystone.model import Model

_STEEP = 0.5
"""A motion is downwards or upwards if the vertical component of its direction is larger than
this."""


def sentence(
    model: Model, blocks: tuple[int, ...], joints: Sequence[JointState], needs: Needs
) -> str:
    """The motion of a region, its cause, and what would hold it, as text."""
    subject = ("block " if len(blocks) == 1 else "blocks ") + names_of(model, blocks)
    parts = [f"{subject} {_motion(model, blocks, joints)}", _cause(model, blocks, joints)]
    return "; ".join(part for part in (*parts, _remedy(model, blocks, needs)) if part)


_ALONE = {
    JointMotion.SLIDES: "slide along each other",
    JointMotion.HINGES: "turn about the edges of their joints",
}
"""What blocks of a region do at the joints between them."""


def _motion(model: Model, blocks: tuple[int, ...], joints: Sequence[JointState]) -> str:
    said: list[str] = []
    for kind in (JointMotion.SLIDES, JointMotion.HINGES, JointMotion.DROPS, JointMotion.LIFTS):
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
    rest = rest.replace("an edge", "edges") if edges else rest
    return f"{first.removesuffix('s') if several else first} {rest}"


def _cause(model: Model, blocks: tuple[int, ...], joints: Sequence[JointState]) -> str:
    """The joints that carry nothing, else those that slide or are hinges."""
    them = "it" if len(blocks) == 1 else "them"
    idle = [j for j in joints if j.idle]
    if len(idle) == len(joints):
        return f"nothing presses on {them}"
    said = [
        _joints_with(model, blocks, [j for j in joints if j.idle], "carries nothing"),
        _joints_with(model, blocks, [j for j in joints if j.spent], "has no friction left"),
    ]
    if len(blocks) > 1:
        said.append(_joints_with(model, (), [j for j in joints if j.hinge], "is a hinge"))
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
    ways = []
    missing = ""
    props = needs.props.props
    if len(props) == 1:
        at = "" if len(blocks) == 1 else f" on '{model.assembly.names[props[0].block]}'"
        ways.append(f"a support{at} that takes {newtons(props[0].size)} at {place(props[0].point)}")
    elif props:
        total = newtons(sum(one.size for one in props))
        on = names_of(model, [one.block for one in props])
        ways.append(f"{len(props)} supports on {on} that take {total} together")
    elif float(np.linalg.norm(needs.force)) > 0.0:
        missing = f"{force_words(needs.force)} at {place(needs.point)} is missing"
    if needs.friction is not None:
        ways.append(friction_words("there", needs.friction))
    if needs.ballast is not None:
        name = model.assembly.names[needs.ballast.at[0]]
        ways.append(f"a weight of {newtons(needs.ballast.value)} on '{name}'")
    if needs.turn is not None:
        name = joint_name(model, blocks, needs.turn.at[0])
        ways.append(f"{name} turned by {rounded_up(needs.turn.value, 2):g} degrees")
    if needs.glue:
        ways.append(glue_words(model, needs.glue[0].at, needs.glue[0].value))
    hold = f"{', or '.join(ways)} would hold {them}" if ways else ""
    return "; ".join(part for part in (missing, hold) if part)
