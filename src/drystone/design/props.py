"""Props: a fixed block against a face, and the force on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from drystone.assembly import Block
from drystone.base.arrays import Floats, frozen
from drystone.base.display import OneLine
from drystone.base.progress import Stopped
from drystone.contacts import Contacts
from drystone.design.changed_model import changed, fresh_name, usual_friction
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.plane.polygon import area_vector
from drystone.model import Model
from drystone.results import Result
from drystone.stability import CheckOptions, check, check_near
from drystone.stability.resting import stands_for_all, try_rest
from drystone.stability.screening import stage_screening

HEAD = 0.1
"""Side of the head of a prop relative to the size of the block on it. Chosen: a small jack."""

_AGAINST = 0.2
"""A prop is possible where a face moves towards it with at least this share of its speed. Chosen:
12 degrees between motion and face."""

_NEAR = 0.01
"""A joint lies on a face when its distance and its angle are below this share (of the size of the
block). Chosen: above the tolerance of the contact search."""

SHARES = (0.0, 0.4, 0.7, -0.4, -0.7)
"""Places on a face, from its middle to its ends."""

SMALL_REGION = 4
"""Largest number of blocks with which all places are tried; with more blocks only the middle of
each face."""

LARGE_REGION = 40
"""Number of blocks of a region above which less is tried: each trial takes a second with 350."""

QUICK = CheckOptions(samples=0, settle=False)
"""One stiffness: if a model stands with it, it stands; the full check follows."""


def quick_check(model: Model, stop: Callable[[], bool] | None = None) -> Result:
    """The check with one stiffness, for searches.

    Raises
    ------
    Stopped
        ``stop`` said so; what the check found by then says nothing.
    """
    result = check(model, options=QUICK, stop=stop)
    if result.stopped:
        raise Stopped
    return result


def quickly_stands(
    model: Model,
    stop: Callable[[], bool] | None = None,
    near: dict[int, Floats] | None = None,
) -> bool:
    """Whether :func:`quick_check` finds a model to stand; without the proof where it falls.

    Parameters
    ----------
    model
    stop
    near
        Rest states of the last model that stood, among models with the same blocks; changed. For
        large models: from there rest is found in a tenth of the time, and more often.

    Raises
    ------
    Stopped
        As there.
    """
    if near is None:
        stands = stands_evenly(model, stop)
    else:
        stands = stands_near(model, near, samples=0, stop=stop)
    if not stands and stop is not None and stop():
        raise Stopped
    return stands


def stands_evenly(model: Model, stop: Callable[[], bool] | None = None) -> bool:
    """Whether a model stands with uniform stiffness, for searches.

    Of few blocks the rest state is looked for as in the stages of a plan. In 176 trials on the
    shelf one that stands was missed, and what falls took half of the time.
    """
    free = model.assembly.free.size
    if free > SMALL_REGION:
        return stands_for_all(model, samples=0, stop=stop)
    levels = stage_screening(free)
    return any(try_rest(model, screening=level, stop=stop).stable for level in levels)


def stands_near(
    model: Model,
    near: dict[int, Floats],
    *,
    samples: int | None = None,
    stop: Callable[[], bool] | None = None,
) -> bool:
    """Whether a model stands for all contact stiffnesses, begun at rest states that it updates."""
    count = CheckOptions().samples if samples is None else samples
    options = CheckOptions(samples=count, settle=False, uniform=True)
    result, rests = check_near(model, near, options=options, stop=stop)
    stands = result.stable and result.samples.standing == result.samples.tried == count + 1
    if stands:
        near.update(rests)
    return stands


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
    """

    block: int
    outline: Floats
    normal: Floats


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


def seats(
    model: Model, block: int, motion: Floats, shares: Sequence[float] = SHARES
) -> Iterator[PropSeat]:
    """Places for a prop: on each free face of a block that moves forward.

    On a face they lie on a line through its middle, along its steepest direction.

    Parameters
    ----------
    model
    block
    motion : (6,)
        First motion of the block.
    shares
        Of the distance from the middle of a face to its end.
    """
    body = model.assembly.blocks[block]
    half = 0.5 * HEAD * body.size
    for loop in body.faces:
        corner = body.vertices[list(loop)]
        area = area_vector(corner)
        size = float(np.linalg.norm(area))
        middle = corner.mean(axis=0)
        speed = motion[:3] + np.cross(motion[3:], middle - body.centroid)
        if area @ speed <= _AGAINST * size * float(np.linalg.norm(speed)):
            continue
        frame = frames_from_normals(-area[None] / size)[0]
        bare = _bare(model, block, corner, frame)
        if bare.area < half**2:
            continue
        down = frame[1:] @ np.array([0.0, 0.0, -1.0])
        steep = float(np.linalg.norm(down))
        along = down / steep if steep > _AGAINST else np.array([1.0, 0.0])
        centre = np.array(bare.centroid.coords[0])
        reach = (np.array(bare.exterior.coords) - centre) @ along
        for share in shares:
            at = centre + share * (reach.max() if share > 0.0 else -reach.min()) * along
            head = shapely.intersection(shapely.box(*(at - half), *(at + half)), bare)
            if head.geom_type == "Polygon" and head.area > half**2:
                ring = np.array(shapely.geometry.polygon.orient(head).exterior.coords)[:-1]
                yield PropSeat(block, frozen(corner[0] + ring @ frame[1:]), frozen(frame[0]))


def _bare(model: Model, block: int, corner: Floats, frame: Floats) -> shapely.Polygon:
    """The largest part of a face that no joint covers, in the plane of its frame."""
    contacts = model.contacts
    left = shapely.Polygon((corner - corner[0]) @ frame[1:].T)
    near = _NEAR * model.assembly.size[block]
    for i in np.flatnonzero((contacts.block_a == block) | (contacts.block_b == block)):
        joint = contacts.polygon(int(i)) - corner[0]
        flat = abs(float(contacts.frame[i, 0] @ frame[0])) > 1.0 - _NEAR
        if len(joint) > 2 and flat and np.abs(joint @ frame[0]).max() < near:
            left = shapely.difference(left, shapely.Polygon(joint @ frame[1:].T).buffer(near))
    parts = [part for part in shapely.get_parts(left) if part.geom_type == "Polygon"]
    return max(parts, key=lambda part: part.area, default=shapely.Polygon())


def propped(model: Model, seat: PropSeat) -> tuple[Model, int]:
    """The model with a fixed prop against a block, and the number of the interface between them."""
    patch, count = np.asarray(seat.outline), len(seat.outline)
    foot = patch - HEAD * model.assembly.size[seat.block] * np.asarray(seat.normal)
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
    held = changed(model, added=(prop,), fixed=(True,), contacts=contacts)
    return held, held.contacts.count - 1


def least_prop(
    model: Model,
    blocks: Sequence[int],
    motion: Floats,
    stop: Callable[[], bool] | None = None,
    shares: Sequence[float] = SHARES,
) -> PropForce | None:
    """The prop at one of the blocks that holds the model with the smallest force.

    ``None`` if no single prop is sufficient, or no block has a free face that moves forward.

    Parameters
    ----------
    model
    blocks
    motion : (n, 6)
        First motion of the blocks.
    stop
    shares
        As for :func:`seats`.

    Raises
    ------
    Stopped
    """
    best: PropForce | None = None
    for block in blocks:
        for seat in seats(model, int(block), motion[block], shares):
            held, number = propped(model, seat)
            if not quickly_stands(held, stop):
                continue
            resultant = quick_check(held, stop).resultants
            point, force = resultant.position[number], resultant.force[number]
            found = PropForce(seat, frozen(point), frozen(force))
            if best is None or found.size < best.size:
                best = found
    return best
