"""The needs of falling blocks, as numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Floats, Ints, frozen
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.changed_model import acceleration_of
from drystone.design.joint_changes import change_of
from drystone.design.props import LARGE_REGION, PropSearch, quickly_stands
from drystone.geometry.solid import crossings
from drystone.geometry.triangulate import triangulate
from drystone.model import Model
from drystone.results import Result

ROUGHEST = 4.0
"""Largest tried friction coefficient. Chosen: it corresponds to 76 degrees, where a joint acts like
a key."""

HEAVIEST = 10.0
"""Largest tried ballast, relative to the weight of the region. Chosen."""

TURNED = 0.05
"""[degrees] Width at which the search for a turn ends. Chosen."""

TURNS = (5.0, 15.0, 35.0)
"""[degrees] Turns of a joint that are tried before the least one is searched. Chosen."""

FRICTION = 0.01
"""Width at which the search for a friction coefficient ends. Chosen: friction is hardly ever known
better."""

_CLOSE = 0.01
"""Relative width at which a search for a least value ends."""

SEARCHED = 12
"""Number of blocks of a region for which a prop is tried, those with the largest need first; fewer
in a large region. In a region of more blocks no ballast is tried: a weight on one of them hardly
ever holds it."""


@dataclass(frozen=True, eq=False)
class Pull(OneLine):
    """Tension that a joint would carry if it were glued.

    Attributes
    ----------
    interface
    force : [N]
        Sum over its corners.
    point : (3,) [m]
        Where it acts.
    stress : [Pa]
        Force by area.
    """

    interface: int
    force: float
    point: Floats
    stress: float


@dataclass(frozen=True, eq=False)
class Ballast(OneLine):
    """Weight on a block that makes a region stand.

    Attributes
    ----------
    block
    force : [N]
    """

    block: int
    force: float


@dataclass(frozen=True, eq=False)
class JointTurn(OneLine):
    """A turn of a joint plane that makes a region stand.

    Attributes
    ----------
    interface
    angle : [degrees]
        About one edge of the joint; without a sign.
    """

    interface: int
    angle: float


@dataclass(frozen=True, eq=False)
class Glue(OneLine):
    """Glue that makes a region stand.

    Attributes
    ----------
    interfaces
        The joints that are glued.
    strength : [N]
        The least pull, and the least shear, that each of them carries, spread over its area. Where
        a joint is bent, only a part of it pulls: its whole pull is then smaller than this.
    """

    interfaces: tuple[int, ...]
    strength: float


@dataclass(frozen=True, eq=False)
class Needs(OneLine):
    """Help with which a region would stand; ``None`` if not found.

    Attributes
    ----------
    wrench : (r, 6) [N, N m]
        The wrench that would hold each block of the region, about its centroid.
    force, point : (3,) [N], (3,) [m]
        The same as one force, and its point of action.
    props
        The prop with the least force, else a few that hold it together; and what was tried.
    pulls
        The joints in tension if all were glued without limit, the largest tension first; interfaces
        of the whole model.
    glue
        Glue alone with which it stands, the least strength first: in the joints of two blocks each,
        or for regions of more than four blocks in all joints that pull, up to forty blocks;
        interfaces of the whole model.
    friction
        Least coefficient of the joints of the region.
    ballast
        The least weight on one block.
    turn
        The least turn of one joint; interface of the whole model.
    """

    wrench: Floats
    force: Floats
    point: Floats
    props: PropSearch
    pulls: tuple[Pull, ...]
    glue: tuple[Glue, ...]
    friction: float | None
    ballast: Ballast | None
    turn: JointTurn | None = None


def least(
    stands: Callable[[float], bool], low: float, high: float, width: float = 0.0
) -> float | None:
    """The least value at which ``stands`` is true, between ``low`` and ``high``.

    It is false at ``low``. The returned value was tried; ``None`` if it is false at ``high``. The
    search ends at a width, or at :data:`_CLOSE` of the value when left out. With a width it goes by
    whole widths from ``low``: searches with the same width give the same value.
    """
    if not stands(high):
        return None
    while high - low > (1.0 + 1e-9) * (width or _CLOSE * high):
        middle = 0.5 * (low + high)
        if width:
            middle = low + width * max(1, round((middle - low) / width))
        if stands(middle):
            high = middle
        else:
            low = middle
    return high


def friction_needed(model: Model, stop: Callable[[], bool] | None = None) -> float | None:
    """Least coefficient of the active joints, in hundredths, at which a model that falls stands.

    Joints with a larger coefficient keep it.
    """
    own = model.contacts.friction
    near: dict[int, Floats] | None = {} if len(model) > LARGE_REGION else None

    def stands(value: float) -> bool:
        rough = np.where(model.active, np.maximum(own, value), own)
        return quickly_stands(model.with_friction(rough), stop, near)

    low = float(own[model.active].min(initial=ROUGHEST))
    found = least(stands, FRICTION * np.floor(low / FRICTION), ROUGHEST, FRICTION)
    return None if found is None else round(found, 6)


def ballast_needed(
    model: Model, blocks: tuple[int, ...], stop: Callable[[], bool] | None = None
) -> Ballast | None:
    """The least weight at the centroid of one of the blocks at which a model stands.

    ``None`` if there is none, or for more than :data:`SEARCHED` blocks.
    """
    down = acceleration_of(model)
    size = float(np.linalg.norm(down))
    if size == 0.0 or len(blocks) > SEARCHED:
        return None
    own = float(model.assembly.mass[list(blocks)].sum()) * size
    best: Ballast | None = None
    for block in blocks:

        def stands(weight: float, block: int = block) -> bool:
            return quickly_stands(ballasted(model, block, weight), stop)

        steps = [share * own for share in (0.1, 0.3, 1.0, 3.0, HEAVIEST)]
        low = 0.0
        for high in steps:
            if best is not None and low >= best.force:
                break
            found = least(stands, low, high) if stands(high) else None
            if found is not None:
                if best is None or found < best.force:
                    best = Ballast(block, found)
                break
            low = high
    return best


def ballasted(model: Model, block: int, weight: float) -> Model:
    """The model with an additional weight [N] at the centroid of a block."""
    down = acceleration_of(model)
    wrench = np.array(model.load.wrench)
    wrench[block, :3] += weight * down / np.linalg.norm(down)
    name = f"{model.load.name} + {weight:.3g} N on {model.assembly.names[block]}"
    return model.with_load(replace(model.load, wrench=wrench, name=name))


def turn_needed(model: Model, stop: Callable[[], bool] | None = None) -> JointTurn | None:
    """The least turn of one joint plane, about one of its edges, with which a model stands."""
    best: JointTurn | None = None
    every = np.arange(model.contacts.count)
    for interface in every.tolist():
        for side in (1.0, -1.0):

            def stands(angle: float, interface: int = interface, side: float = side) -> bool:
                try:
                    turned = change_of("turn", [interface], side, angle)(model, every, every)
                except InputError:  # a face would be swallowed
                    return False
                return quickly_stands(turned, stop)

            low = 0.0
            for high in TURNS:
                most = high if best is None else min(high, best.angle)
                found = least(stands, low, most, TURNED) if most > low else None
                if found is not None:
                    best = JointTurn(interface, found)
                    break
                low = high
    return best


def pulls_of(glued: Result, interfaces: Ints) -> tuple[Pull, ...]:
    """The joints of a glued structure in tension, the largest tension first.

    Parameters
    ----------
    glued
        A penalty result.
    interfaces : (m,)
        Positions of its interfaces in the whole model.
    """
    contacts, tension = glued.contacts, glued.tension
    if tension is None or not contacts.count:
        return ()
    total = np.bincount(contacts.interface, tension, minlength=contacts.count)
    pulls = []
    for i in np.argsort(-total):
        if total[i] <= 1e-3 * total.max() or total[i] <= 0.0:
            break
        corners = slice(contacts.start[i], contacts.start[i + 1])
        point = tension[corners] @ contacts.point[corners] / total[i]
        area = float(contacts.area[i])
        stress = float(total[i]) / area if area > 0.0 else np.inf
        pulls.append(Pull(int(interfaces[i]), float(total[i]), frozen(point), stress))
    return tuple(pulls)


def one_force(model: Model, blocks: tuple[int, ...], wrench: Floats) -> tuple[Floats, Floats]:
    """The sum of wrenches on some blocks as one force (3,) [N], and its point of action (3,) [m].

    The point is where the line of action enters the blocks, or the point of the line nearest to the
    centroid if the line misses the blocks.
    """
    centroid = model.assembly.centroid[list(blocks)]
    middle = centroid.mean(axis=0)
    force: Floats = wrench[:, :3].sum(axis=0)
    moment = wrench[:, 3:].sum(axis=0) + np.cross(centroid - middle, wrench[:, :3]).sum(axis=0)
    square = float(force @ force)
    if square == 0.0:
        return force, middle
    at = middle + np.cross(force, moment) / square
    along = force / np.sqrt(square)
    best = np.inf
    for i in blocks:
        body = model.assembly.blocks[i]
        best = min(best, _entry(body.vertices, body.faces, at, along))
    point: Floats = at + (best if np.isfinite(best) else 0.0) * along
    return force, point


def _entry(
    vertices: Floats, faces: tuple[tuple[int, ...], ...], at: Floats, along: Floats
) -> float:
    """Position along a line at which it enters a body; infinite if it misses the body."""
    reach = 2.0 * float(np.linalg.norm(vertices - at, axis=1).max())
    loop = np.concatenate([np.asarray(face, dtype=np.intp) for face in faces])
    ends = np.cumsum([0, *(len(face) for face in faces)]).astype(np.intp)
    corner = vertices[loop][triangulate(vertices[loop], ends)[0]]
    start, end = at - reach * along, at + reach * along
    shape = (len(corner), 3)
    hit, share = crossings(np.broadcast_to(start, shape), np.broadcast_to(end, shape), corner)
    return float((2.0 * share[hit].min() - 1.0) * reach) if hit.any() else np.inf
