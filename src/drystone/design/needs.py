"""What falling blocks need, as numbers: the least change of each kind with which they stand."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from drystone.base.arrays import Floats, Ints, frozen
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.design.bench import Bench
from drystone.design.changed_model import acceleration_of
from drystone.design.changes import (
    Change,
    ballast_change,
    friction_change,
    glue_changes,
    joint_change,
)
from drystone.design.margin import SMALL_REGION
from drystone.design.props import NO_PROPS, SHARES, PropSearch, find_props
from drystone.design.regions import tension_if_glued
from drystone.model import Model

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
class Need(OneLine):
    """The least change of a kind with which a region stands.

    Attributes
    ----------
    value
        A weight or the strength of glue [N], or the turn of a joint [degrees], without a sign. Each
        glued joint carries this pull and this shear, spread over its area.
    at
        The block that is weighted, or the interfaces that are glued or turned.
    jams
        Largest force of a joint by the load of the region, where it holds by jamming; else 0.
    """

    value: float
    at: tuple[int, ...]
    jams: float = 0.0


@dataclass(frozen=True, eq=False)
class Needs(OneLine):
    """Help with which a region would stand; ``None`` if not found.

    Blocks and interfaces are those of the whole model.

    Attributes
    ----------
    wrench : (r, 6) [N, N m]
        The wrench that would hold each block of the region, about its centroid.
    force, point : (3,) [N], (3,) [m]
        The same as one force, and its point of action.
    pulls
        The joints in tension if all were glued without limit, the largest tension first.
    props
        The prop with the least force, else a few that hold it together; and what was tried.
    friction
        Least coefficient of the joints of the region.
    ballast
        The least weight on one block.
    turn
        The least turn of one joint about one of its edges.
    glue
        Glue alone with which it stands, the least strength first: in the joints of two blocks each,
        or for regions of more than four blocks in all joints that pull, up to forty blocks.
    """

    wrench: Floats
    force: Floats
    point: Floats
    pulls: tuple[Pull, ...]
    props: PropSearch = NO_PROPS
    friction: float | None = None
    ballast: Need | None = None
    turn: Need | None = None
    glue: tuple[Need, ...] = ()


def search_needs(bench: Bench, needs: Needs) -> Iterator[dict[str, Any]]:
    """The needs of the region of a bench, one after the other, as fields of :class:`Needs`.

    ``needs`` is what is known of them.

    Raises
    ------
    Stopped
    """
    small = len(bench.own) <= SMALL_REGION
    yield {"props": props_of(bench, needs).renumbered(bench.blocks)}
    yield {"friction": _friction(bench)}
    if len(bench.own) <= SEARCHED and acceleration_of(bench.local).any():
        weights = [ballast_change(bench.local, len(bench.own), i) for i in bench.own]
        yield {"ballast": _smallest(bench, weights, bench.region)}
    if small:
        yield {"turn": _turn(bench)}
    if bench.large:
        yield {"pulls": pulls_of_region(bench)}
    else:
        yield {"glue": _glue(bench, needs.pulls)}


def props_of(bench: Bench, needs: Needs) -> PropSearch:
    """The props that hold the region of a bench, sought at the blocks with the largest need first.

    Raises
    ------
    Stopped
    """
    few = SMALL_REGION if bench.large else SEARCHED
    size = np.linalg.norm(needs.wrench[:, :3], axis=1)
    small = len(bench.own) <= SMALL_REGION
    return find_props(
        bench.local,
        bench.own,
        bench.motion,
        bench.stop,
        single=np.argsort(-size, kind="stable")[:few].tolist(),
        shares=SHARES if small else SHARES[:1],
    )


def _friction(bench: Bench) -> float | None:
    """The least coefficient of all joints."""
    joints = range(bench.local.contacts.count)
    value = bench.least(friction_change(bench.local, joints, "")) if joints else None
    return None if value is None else round(value, 6)


def _turn(bench: Bench) -> Need | None:
    """The least turn of a joint, to either side."""
    turns, at = [], []
    for k, side in product(range(bench.local.contacts.count), (1.0, -1.0)):
        with contextlib.suppress(InputError):  # it is not plane
            turns.append(joint_change(bench.local, "turn", [k], side))
            at.append(int(bench.interfaces[k]))
    return _smallest(bench, turns, at)


def _glue(bench: Bench, pulls: Sequence[Pull]) -> tuple[Need, ...]:
    """Glue alone, the least strength first."""
    inner = {int(whole): k for k, whole in enumerate(bench.interfaces)}
    pulling = [(inner[pull.interface], pull.force) for pull in pulls]
    found = []
    for some, change in glue_changes(bench.local, len(bench.own), pulling, SMALL_REGION).items():
        value = bench.least(replace(change, steps=change.steps[-1:]))
        if value is not None:
            found.append(Need(value, tuple(bench.interfaces[list(some)].tolist())))
    return tuple(sorted(found, key=lambda one: one.value))


def _smallest(bench: Bench, changes: Sequence[Change], at: Sequence[int]) -> Need | None:
    """The smallest of the least values of some changes, each of a block or of a joint."""
    best = bench.smallest(changes)
    if best is None:
        return None
    jam = bench.jam(*best)
    return Need(best[1], (at[list(changes).index(best[0])],), jam.times if jam else 0.0)


def pulls_of_region(bench: Bench) -> tuple[Pull, ...]:
    """The joints of the region of a bench that would pull if all were glued."""
    tension = tension_if_glued(bench.local, bench.stop)
    return pulls_of(bench.local.contacts, tension, bench.interfaces)


def pulls_of(contacts: Contacts, tension: Floats | None, interfaces: Ints) -> tuple[Pull, ...]:
    """The joints of a glued structure in tension, the largest tension first.

    Parameters
    ----------
    contacts
    tension : (k,) [N]
        Of each corner.
    interfaces : (m,)
        Positions of its interfaces in the whole model.
    """
    if tension is None or not contacts.count or contacts.count != len(interfaces):
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

    Of the points on the line of action it is the one nearest to the middle of the blocks.
    """
    centroid = model.assembly.centroid[list(blocks)]
    middle: Floats = centroid.mean(axis=0)
    force: Floats = wrench[:, :3].sum(axis=0)
    moment = wrench[:, 3:].sum(axis=0) + np.cross(centroid - middle, wrench[:, :3]).sum(axis=0)
    square = float(force @ force)
    return force, middle + np.cross(force, moment) / square if square > 0.0 else middle
