"""A diagnosis as text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import counted
from drystone.design.joint_motion import JointMotion, JointState
from drystone.model import Model
from drystone.results import Result

if TYPE_CHECKING:
    from drystone.design.needs import Needs

_NAMED = 4
"""Number of blocks of a region that are named. Chosen. The others are counted."""

_UPRIGHT = 0.1
"""A joint is neither upper nor lower if the vertical component of its normal is below this: 6
degrees."""

_PLUMB = 0.995
"""A force is upward or downward if the vertical component of its direction is larger: 6 degrees."""

_STEEP = 0.5
"""A motion is downwards or upwards if the vertical component of its direction is larger than
this."""


def newtons(size: float) -> str:
    """A force as text, with three digits."""
    for unit, factor in (("MN", 1e6), ("kN", 1e3)):
        if abs(size) >= factor:
            return f"{size / factor:.3g} {unit}"
    return f"{size:.3g} N"


def _force_words(force: Floats) -> str:
    """A force (3,) [N] as text, with its direction.

    Examples
    --------
    >>> _force_words(np.array([0.0, 0.0, 20.0])), _force_words(np.array([-3e3, 0.0, 4e3]))
    ('an upward force of 20 N', 'a force of 5 kN in the direction (-0.6, 0, 0.8)')
    """
    size = float(np.linalg.norm(force))
    way = force / size
    for name, z in (("an upward", 1.0), ("a downward", -1.0)):
        if z * way[2] > _PLUMB:
            return f"{name} force of {newtons(size)}"
    told = ", ".join(f"{round(float(x), 2) + 0.0:g}" for x in way)
    return f"a force of {newtons(size)} in the direction ({told})"


def _rounded_up(value: float, digits: int = 3) -> float:
    """A value rounded up to some digits, so that what is told is enough.

    Examples
    --------
    >>> _rounded_up(1.2001), _rounded_up(86.01), _rounded_up(0.5)
    (1.21, 86.1, 0.5)
    """
    if value <= 0.0:
        return value
    step = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    return float(f"{math.ceil(value / step * (1.0 - 1e-9)) * step:.{digits}g}")


def glue_words(model: Model, interfaces: Sequence[int], strength: float) -> str:
    """Glue in some joints as text, with its strength [N] rounded up."""
    ends = {(int(model.contacts.block_a[k]), int(model.contacts.block_b[k])) for k in interfaces}
    where = f" between {names_of(model, ends.pop())}" if len(ends) == 1 else ""
    carried = f"a pull, and a shear, of {newtons(_rounded_up(strength))}"
    if len(interfaces) == 1:
        return f"glue{where} that carries {carried}"
    return f"glue in {len(interfaces)} joints{where}, each of which carries {carried}"


def friction_words(where: str, value: float) -> str:
    """A friction coefficient as text, rounded up to hundredths."""
    return f"friction of {math.ceil(100.0 * value - 1e-6) / 100.0:.2f} {where}".rstrip(",")


def place(point: Floats) -> str:
    """A point [m] as text, to a millimetre."""
    return "(" + ", ".join(f"{round(float(x), 3) + 0.0:g}" for x in point) + ") m"


def names_of(model: Model, blocks: Sequence[int]) -> str:
    """Names of blocks in a sentence."""
    named = [f"'{model.assembly.names[i]}'" for i in blocks]
    if len(named) > _NAMED:
        named = [*named[: _NAMED - 1], f"{len(named) - _NAMED + 1} more"]
    return " and ".join([", ".join(named[:-1]), named[-1]] if len(named) > 1 else named)


def joint_name(model: Model, blocks: Sequence[int], interface: int) -> str:
    """A joint of some blocks as text: lower, upper, upright or inner, and the other block."""
    contacts = model.contacts
    a, b = int(contacts.block_a[interface]), int(contacts.block_b[interface])
    if a in blocks and b in blocks:
        return f"the joint of {names_of(model, [a, b])}"
    own, other = (a, b) if a in blocks else (b, a)
    if abs(contacts.frame[interface, 0, 2]) < _UPRIGHT:
        return f"the joint with {names_of(model, [other])}"
    above = contacts.centroid[interface][2] > model.assembly.centroid[own][2]
    return f"the {'upper' if above else 'lower'} joint, with {names_of(model, [other])},"


def nothing(result: Result) -> str:
    """The sentence if no region was found."""
    if result.stable:
        return "it stands: nothing is missing"
    return f"no block shows that it needs help ({result.message})"


def friction_of_all(value: float, said: Sequence[float | None]) -> str:
    """The friction with which the whole model stands, as text.

    ``said`` are the coefficients of the regions, of which the sentences before told.
    """
    if len(said) == 1 and said[0] is not None and value == said[0]:
        return "the same friction in all joints would hold the whole model"
    return f"{friction_words('in all joints', value)} would hold the whole model"


def sentence(
    model: Model, blocks: tuple[int, ...], joints: Sequence[JointState], needs: Needs
) -> str:
    """The motion of a region, its cause, and what would hold it, as text."""
    subject = ("block " if len(blocks) == 1 else "blocks ") + names_of(model, blocks)
    parts = [f"{subject} {_motion(model, blocks, joints)}", _cause(model, blocks, joints)]
    return "; ".join(part for part in (*parts, _remedy(model, blocks, needs)) if part)


def _motion(model: Model, blocks: tuple[int, ...], joints: Sequence[JointState]) -> str:
    one = len(blocks) == 1
    said: list[str] = []
    for kind in (JointMotion.SLIDES, JointMotion.HINGES, JointMotion.DROPS, JointMotion.LIFTS):
        mine = [j for j in joints if j.motion is kind]
        outer = [j for j in mine if j.neighbour not in blocks]
        if not mine or (kind is JointMotion.LIFTS and said):
            continue
        verb = kind.value if one else _plural(kind)
        if kind is JointMotion.SLIDES:
            vertical = float(np.mean([j.direction[2] for j in mine]))
            way = "down " if vertical < -_STEEP else "up " if vertical > _STEEP else ""
            verb = verb.replace(" along", f" {way}along")
        others = list(dict.fromkeys(j.neighbour for j in outer))
        if len(others) > 1:
            verb = verb.replace("an edge", "edges")
        if others:
            said.append(f"{verb} {names_of(model, others)}")
        elif not one:
            said.append(
                {
                    JointMotion.SLIDES: "slide along each other",
                    JointMotion.HINGES: "turn about the edges of their joints",
                }.get(kind, "part from each other")
            )
    if not said:
        said = ["falls" if one else "fall"]
    return " and ".join([", ".join(said[:-1]), said[-1]] if len(said) > 1 else said)


def _plural(kind: JointMotion) -> str:
    first, _, rest = kind.value.partition(" ")
    return f"{first.removesuffix('s')} {rest}"


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
    if blocks and len(outer) == len(some) <= _NAMED:
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
        missing = f"{_force_words(needs.force)} at {place(needs.point)} is missing"
    if needs.friction is not None:
        ways.append(friction_words("there", needs.friction))
    if needs.ballast is not None:
        name = model.assembly.names[needs.ballast.at[0]]
        ways.append(f"a weight of {newtons(needs.ballast.value)} on '{name}'")
    if needs.turn is not None:
        name = joint_name(model, blocks, needs.turn.at[0])
        ways.append(f"{name} turned by {_rounded_up(needs.turn.value, 2):g} degrees")
    if needs.glue:
        ways.append(glue_words(model, needs.glue[0].at, needs.glue[0].value))
    hold = f"{', or '.join(ways)} would hold {them}" if ways else ""
    return "; ".join(part for part in (missing, hold) if part)
