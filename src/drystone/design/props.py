"""Props: a fixed block against a face, and the force on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from drystone.assembly import Block
from drystone.base.arrays import Floats, Ints, frozen
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.contacts import Contacts
from drystone.design.changed_model import changed, fresh_name, usual_friction
from drystone.design.margin import LARGE_REGION, soon_at_rest
from drystone.free_faces import FreePart, free_parts
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.polygon import area_vector
from drystone.model import Model
from drystone.ties import PLATE

_AGAINST = 0.2
"""A prop is possible where a face moves towards it with at least this share of its speed. Chosen:
12 degrees between motion and face."""

SHARES = (0.0, 0.4, 0.7, -0.4, -0.7)
"""Places on a face, from its middle to its ends."""


@dataclass(frozen=True, eq=False)
class PropSeat(OneLine):
    """A place for a prop against a block.

    Attributes
    ----------
    block
    outline : (c, 3) [m]
        Of the head, on a face of the block, counter-clockwise about the normal.
    normal : (3,) unit
        From the prop into the block.
    covered
        Whether joints cover a part of the face.
    """

    block: int
    outline: Floats
    normal: Floats
    covered: bool = False


@dataclass(frozen=True, eq=False)
class PropForce(OneLine):
    """A prop that holds a region, and its force.

    Attributes
    ----------
    seat
        Its place.
    point : (3,) [m]
    force : (3,) [N]
        On the block.
    """

    seat: PropSeat
    point: Floats
    force: Floats

    @property
    def block(self) -> int:
        """Position of the block that rests on it."""
        return self.seat.block

    @property
    def size(self) -> float:
        """[N]."""
        return float(np.linalg.norm(self.force))


@dataclass(frozen=True)
class PropSearch(OneLine):
    """The props that hold a model, and what was tried.

    Attributes
    ----------
    props
        None of which can be left out; empty where none hold it.
    tried
        The kinds of places, as text.
    """

    props: tuple[PropForce, ...]
    tried: str

    def renumbered(self, place: Ints) -> PropSearch:
        """The same with blocks numbered as in another model, by their places (n,) in it."""
        moved = [
            replace(one, seat=replace(one.seat, block=int(place[one.block]))) for one in self.props
        ]
        return replace(self, props=tuple(moved))


NO_PROPS = PropSearch((), "")
"""No prop was looked for."""


def seats(
    model: Model, block: int, motion: Floats, shares: Sequence[float] = SHARES, *, low: bool = False
) -> Iterator[PropSeat]:
    """Places for a prop against a block: on each free part of its faces that move forward.

    On a part they lie on a line through its middle, along its steepest direction.

    Parameters
    ----------
    model
    block
    motion : (6,)
        First motion of the block.
    shares
        Of the distance from the middle of a part to its end.
    low
        On the other faces that look along the load, in place of those that move forward.
    """
    body = model.assembly.blocks[block]
    half = 0.5 * PLATE * body.size
    load = model.load.wrench[block, :3]
    for part in free_parts(model, block):
        speed = motion[:3] + np.cross(motion[3:], part.middle - body.centroid)
        forward = bool(part.normal @ speed > _AGAINST * np.linalg.norm(speed))
        lower = bool(part.normal @ load > _AGAINST * np.linalg.norm(load))
        if part.area >= half**2 and (lower and not forward if low else forward):
            yield from _heads(part, block, half, shares)


def _heads(part: FreePart, block: int, half: float, shares: Sequence[float]) -> Iterator[PropSeat]:
    """Heads of a size on a free part of a face, where they fit."""
    frame, shape, centre = part.frame, part.shape, part.inside
    down = frame[1:] @ np.array([0.0, 0.0, -1.0])
    steep = float(np.linalg.norm(down))
    along = down / steep if steep > _AGAINST else np.array([1.0, 0.0])
    reach = (np.array(shape.exterior.coords) - centre) @ along
    for share in shares:
        at = centre + share * (reach.max() if share > 0.0 else -reach.min()) * along
        head = shapely.intersection(shapely.box(*(at - half), *(at + half)), shape)
        if head.geom_type == "Polygon" and head.area > half**2:
            ring = np.array(shapely.geometry.polygon.orient(head).exterior.coords)[:-1]
            outline = frozen(part.origin + ring @ frame[1:])
            yield PropSeat(block, outline, frozen(frame[0]), part.covered)


def propped(model: Model, seat: PropSeat) -> Model:
    """The model with a fixed prop against a block; the joint between them is the last one."""
    patch, count = np.asarray(seat.outline), len(seat.outline)
    foot = patch - PLATE * model.assembly.size[seat.block] * np.asarray(seat.normal)
    here = range(count)
    sides = [(i, (i + 1) % count, (i + 1) % count + count, i + count) for i in here]
    faces = (tuple(i + count for i in here), tuple(reversed(here)), *sides)
    prop = Block(np.concatenate([foot, patch]), faces, fresh_name(model, "prop"))
    area = area_vector(patch)
    contacts = Contacts(
        np.array([len(model)]),
        np.array([seat.block]),
        frames_from_normals(np.asarray(seat.normal)[None]),
        np.array([float(np.linalg.norm(area))]),
        np.array([usual_friction(model)]),
        patch,
        np.zeros(count, dtype=np.intp),
    )
    return changed(model, added=(prop,), fixed=(True,), contacts=contacts)


def find_props(
    model: Model,
    blocks: Sequence[int],
    motion: Floats,
    stop: Callable[[], bool] | None = None,
    *,
    single: Sequence[int] | None = None,
    shares: Sequence[float] = SHARES,
) -> PropSearch:
    """The one prop with the smallest force that holds a model, else a few that hold it together.

    Of a large model it is the first one.

    Places are free parts of faces, also of those that joints cover partly. A single prop is tried
    on the faces that move forward, then on others that look along the load. Where none is enough,
    one prop is set under each block, then one under every free part; each one that is not needed is
    taken away.

    Parameters
    ----------
    model
    blocks
        That may be propped.
    motion : (n, 6)
        First motion of the blocks.
    stop
    single
        Those of the blocks at which a single prop is tried; all when left out.
    shares
        As for :func:`seats`, for a single prop.

    Raises
    ------
    Stopped
    """
    tried: list[PropSeat] = []
    for low in (False, True):
        some = blocks if single is None else single
        places = [one for i in some for one in seats(model, int(i), motion[i], shares, low=low)]
        forces = []
        for one in places:
            forces += _forces(model, [one], stop)
            if forces and len(blocks) > LARGE_REGION:  # each trial is slow
                break
        if forces:
            return PropSearch((min(forces, key=lambda one: one.size),), "")
        tried += places
    said = f"one prop at {counted(len(tried), 'place')} on free parts of faces"
    covered = sum(one.covered for one in tried)
    if covered:
        said += f", {covered} of them beside joints"
    if len(blocks) > LARGE_REGION:
        return PropSearch((), said)
    said += ", one under each of its blocks, and one under every free part of their faces"
    return PropSearch(tuple(_few_props(model, blocks, motion, stop)), said)


def _few_props(
    model: Model, blocks: Sequence[int], motion: Floats, stop: Callable[[], bool] | None
) -> list[PropForce]:
    """Props that hold a model together, none of which can be left out; empty where none do."""
    places = [
        [
            seat
            for low in (False, True)
            for seat in seats(model, int(i), motion[i], SHARES[:1], low=low)
        ]
        for i in blocks
    ]
    for chosen in ([some[0] for some in places if some], [one for some in places for one in some]):
        held = _forces(model, chosen, stop) if chosen else []
        if held:
            return _needed(model, held, stop)
    return []


def _needed(
    model: Model, held: list[PropForce], stop: Callable[[], bool] | None
) -> list[PropForce]:
    """Those of some props that hold a model that are needed, the first ones left out first."""
    for seat in [one.seat for one in held]:
        fewer = [one.seat for one in held if one.seat is not seat]
        held = (_forces(model, fewer, stop) if fewer else []) or held
    return held


def with_props(model: Model, some: Sequence[PropSeat]) -> Model:
    """The model with props at some places."""
    for seat in some:
        model = propped(model, seat)
    return model


def _forces(
    model: Model, some: Sequence[PropSeat], stop: Callable[[], bool] | None
) -> list[PropForce]:
    """The forces of some props, if they are soon found to hold a model; else none."""
    rest = soon_at_rest(with_props(model, some), stop)
    if not rest.stable:
        return []
    found = rest.resultants
    last = zip(some, found.position[-len(some) :], found.force[-len(some) :], strict=True)
    return [PropForce(seat, frozen(at), frozen(force)) for seat, at, force in last]
