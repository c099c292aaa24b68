"""Large displacement as an analysis: states until the blocks cannot follow any farther."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias, Unpack

import numpy as np

from drystone.base.arrays import SAME, Bools, Floats, cross, frozen, frozen_floats, lengths
from drystone.base.declared import Offered
from drystone.base.errors import InputError
from drystone.base.settings import Clock, checked_call
from drystone.base.units import quantity
from drystone.contacts import Contacts
from drystone.io.opening import Given, LongHow, as_model
from drystone.loads import LoadCase
from drystone.loads.applied import Shaken, arms_of_loads
from drystone.loads.case import STANDARD_GRAVITY
from drystone.mechanics.bodies import Bodies, build_bodies, numbered_axes, numbered_forces
from drystone.mechanics.corners import CARRIER, Carrier
from drystone.mechanics.drive import DrivenState, Driver
from drystone.mechanics.follow import Bounds, Ended
from drystone.mechanics.meeting import (
    FARTHEST,
    Apart,
    faces_apart,
    followed_model,
    model_with_met,
    with_what_touches,
)
from drystone.model import Model
from drystone.settlement.large_types import Drive, End, LargeDisplacement, LargeState
from drystone.settlement.path import STIFFER, block_motions, scaled_motion, support_motion
from drystone.settlement.settlement_types import SettlementOptions

Tell: TypeAlias = Callable[[float], None]
"""Called with the share of the motion that is done."""

STAGE = {
    Drive.LOAD: "pushing",
    Drive.SUPPORTS: "moving the supports",
    Drive.FRICTION: "reducing the friction",
}

MOVES = 1e-2
"""Share of the largest motion from which a block moves. Measured: return walls beside a facade that
overturns move by a thousandth; counted, they change its displacement from 0.301 to 0.212 m and e*
from 1 to 0.54."""

WATCHED = 0.3
"""[s] between two states that are watched. Chosen: a picture of 400 blocks takes a tenth of it."""


@checked_call
def push(
    given: Given,
    live: LoadCase | Sequence[float] = (1.0, 0.0, 0.0),
    *,
    to: float | None = None,
    options: SettlementOptions | None = None,
    **how: Unpack[LongHow],
) -> LargeDisplacement:
    """Push a structure until it needs no push any more: load against displacement.

    A load grows on top of that of the model. Its displacement is prescribed and its factor found,
    so that the curve goes on beyond the largest load, where a structure of rigid blocks makes most
    of its motion. The displacement at which the factor has fallen to zero is the displacement
    capacity: let go there, the structure falls. Quasi-static: no inertia. The forces keep their
    direction and move with their blocks, at points that were given off them; others from above
    where they enter them. Each increment needs the one before, so an ``executor`` has nothing to
    share.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    live
        The load that grows: ``BLOCK:WHAT[@X,Y,Z]`` as for ``--load``, ``seismic:KX,KY``, or a load
        case of the file by its name; left out, all masses are pushed along x. In Python a load
        case, or forces on all masses as shares (3,) of their weight at 9.81 m/s2.
    to : [m] > 0, < inf
        Displacement of the block that moves farthest at which it ends; left out, twice the mean
        size of a block.
    options
        ``fall``, ``carrier``, ``overlap``, ``tangential``, ``pace`` and ``step_limit`` are used;
        where neither it nor the model chooses a carrier, the moving block carries the ends of
        joints.

    Raises
    ------
    InputError
        The load has no force on a free block, ``to`` is not above zero, joints carry more than
        friction, or what was given cannot be made into a model.

    Examples
    --------
    A block 1 m wide and 2 m high rocks: the factor begins at 1/2 and falls to zero as the centroid
    comes to stand over the edge.

    >>> import drystone
    >>> from drystone.models import box
    >>> blocks = (box((3, 3, 1), (-1, -1, -1), "base"), box((1, 1, 2), (0, 0, 0), "block"))
    >>> column = drystone.Assembly(blocks).with_fixed(["base"])
    >>> found = drystone.settlement.push(column, friction=1.0)
    >>> round(found.peak, 3), round(found.capacity, 2)
    (0.5, 0.5)
    """
    clock = Clock.of(how)
    model = as_model(given, **how)
    if isinstance(live, LoadCase):
        case = LoadCase.of(model.assembly, live)
    else:
        case = _of_masses(model, live)
    free, grows = model.assembly.free, case.beside(model.load)
    wrench, arms = grows.wrench, arms_of_loads(model.assembly, grows)[free]
    if not np.any(wrench[free, :3]):
        raise InputError(
            "the load that grows has no force on a free block", remedy="push a free block"
        )
    shaken = Shaken.of(model.assembly, model.load + case) if case.shake.any() else None
    if shaken is not None:
        model = replace(model, notes=(*model.notes, shaken.words))

    def run(_: Model, bodies: Bodies, driver: Driver, tell: Tell) -> tuple[Ended, float, float]:
        acting = wrench[free]
        by = bodies.length_unit * bodies.radius[free, None]
        grown = np.concatenate([acting[:, :3], acting[:, 3:] / by], axis=1) / bodies.force_unit
        around = arms / (by[..., None] * bodies.force_unit)
        # the displacement along the whole load, by the forces of it that are counted, is their mean
        size = np.linalg.norm(grown[:, :3], axis=1)
        whole = float(np.linalg.norm(grown)) * bodies.length_unit
        reach = 2.0 if to is None else to / bodies.length_unit
        ended = driver.grow(grown, around, reach, tell)
        # where it is still pushed: what has fallen off may have let the others return
        pushed = [one for one in driver.kept() if one.load > 0.0] or [driver.now()]
        moved = block_motions(bodies, (pushed[-1].pose,))[0][free, :3]
        along = np.abs((grown[:, :3] * moved).sum(axis=1))
        moves = along >= MOVES * size * (along / np.where(size, size, np.inf)).max()
        return ended, whole / float(size[moves].sum()), 1.0

    return replace(_driven(model, Drive.LOAD, run, options, clock), grows=case.name)


@checked_call
def move_supports(
    given: Given,
    motion: Mapping[int | str, Any] | None = None,
    *,
    to: float | None = None,
    options: SettlementOptions | None = None,
    watch: Callable[[LargeState], None] | None = None,
    **how: Unpack[LongHow],
) -> LargeDisplacement:
    """Move supports by finite amounts until the blocks fall: how far, and with which forces.

    Parameters
    ----------
    given
    motion
        Per support its translation [m] (3,), or translation and rotation vector [m, rad] (6,), as
        in :func:`drystone.settle`.
    to : [m] > 0, < inf
        The motion is made larger or smaller until the corner of a support that moves farthest moves
        by this; left out, it is taken as it is.
    options
        As in :func:`push`.
    watch
        Called with the blocks as they are while they are followed, a few times a second.

    Raises
    ------
    InputError
        No support moves, or ``to`` is not above zero.
    """
    clock = Clock.of(how)
    model = as_model(given, **how)
    moving = support_motion(model, motion)
    longest = 0.0 if moving is None else _longest(model, moving)
    if moving is None or longest == 0.0:
        raise InputError("no support moves", remedy='give a motion, such as {"base": (0, 0, -0.1)}')
    if to is not None:
        moving, longest = moving * (to / longest), to
    still = model.with_load(replace(model.load, motion=None))

    watched = 0.0

    def run(used: Model, bodies: Bodies, driver: Driver, tell: Tell) -> tuple[Ended, float, float]:
        def told(share: float) -> None:
            nonlocal watched
            tell(share)
            if watch is not None and driver.last and clock.elapsed_s > watched + WATCHED:
                watched = clock.elapsed_s
                apart = faces_apart(used, FARTHEST)
                unit = bodies.force_unit
                watch(large_state(used, apart, bodies, driver.last[1], driver.met, longest, unit))

        ended = driver.shift(scaled_motion(bodies, moving), longest / bodies.length_unit, told)
        return ended, longest, bodies.force_unit

    return _driven(still, Drive.SUPPORTS, run, options, clock)


@checked_call
def reduce_friction(
    given: Given,
    *,
    options: SettlementOptions | None = None,
    **how: Unpack[LongHow],
) -> LargeDisplacement:
    """Let all friction coefficients decay from their values to zero, until the blocks fall.

    The last load is the share of the friction at which they fall.

    Parameters
    ----------
    options
        As in :func:`push`.
    """
    clock = Clock.of(how)
    model = as_model(given, **how)

    def run(_: Model, bodies: Bodies, driver: Driver, tell: Tell) -> tuple[Ended, float, float]:
        return driver.slacken(tell), bodies.length_unit, 1.0

    return _driven(model, Drive.FRICTION, run, options, clock)


def _driven(
    model: Model,
    drive: Drive,
    run: Callable[[Model, Bodies, Driver, Tell], tuple[Ended, float, float]],
    options: SettlementOptions | None,
    clock: Clock,
) -> LargeDisplacement:
    """One run; ``run`` gives how it ended, and a displacement and a load of one in m and N.

    What does not stand at its beginning is begun again with the edges and corners that touch.
    """
    chosen = SettlementOptions.of(options)
    why = "what a joint still carries after it has moved is not known"
    model.require_dry("large displacement", why, yielding=True)
    model.require_still()
    if not len(model.assembly.free):
        raise InputError("every block is fixed", remedy="leave a block free")
    apart = faces_apart(model, FARTHEST)
    part, gap = followed_model(model, apart)
    carrier = chosen.carrier or CARRIER[model.ends] or Carrier.MOVING
    tell = clock.shares(STAGE[drive])
    overlap = chosen.overlap
    while True:
        bodies = build_bodies(part, carrier, overlap=overlap, tangential=chosen.tangential, gap=gap)
        bounds = Bounds(chosen.fall, chosen.pace, chosen.step_limit)
        driver = Driver(bodies, bounds, stop=clock.late)
        ended = driver.rest()
        length = load = 1.0
        if ended is Ended.RESTS:
            ended, length, load = run(model, bodies, driver, tell)
        else:
            driver.note()
        if ended is not Ended.SOFT:
            break
        overlap *= STIFFER
    clock.tell(STAGE[drive], 100, 100)
    curve = np.array(driver.curve) * (length, load)
    shown, mine, kept = model_with_met(model, apart, driver.met)
    states = tuple(state_of(shown, bodies, one, mine, kept, length, load) for one in driver.kept())
    end = End[ended.name]
    stopped = ""
    if end is End.STOPPED:
        stopped = clock.reason or f"{chosen.step_limit} steps were made"
    fallen = None
    if end is End.FALLS:
        fallen = state_of(shown, bodies, driver.now(), mine, kept, length, load)
    found = LargeDisplacement(
        drive, shown, frozen(curve[:, 0].copy()), frozen(curve[:, 1].copy()), states, end, "",
        fallen, chosen, stopped=stopped, time_s={"solve": clock.elapsed_s},
    )  # fmt: skip
    if fallen is not None and len(curve) < 2:
        touching = with_what_touches(model, fallen.positions)
        if touching is not None:
            return _driven(touching, drive, run, options, clock)
    return replace(found, message=_said(found, driver))


def _longest(model: Model, motion: Floats) -> float:
    """Largest motion [m] of a corner of a support, to first order, for motions (n, 6) [m, rad]."""
    blocks, centroid = model.assembly.blocks, model.assembly.centroid
    ways = [
        motion[i, :3] + np.cross(motion[i, 3:], blocks[i].vertices - centroid[i])
        for i in np.flatnonzero(motion.any(axis=1))
    ]
    return max((float(np.linalg.norm(way, axis=1).max()) for way in ways), default=0.0)


def _of_masses(model: Model, shares: Sequence[float]) -> LoadCase:
    """Forces on all masses as shares (3,) of their weight."""
    given = frozen_floats(shares, (3,), "the load that grows")
    size = float(np.linalg.norm(given))
    if size == 0.0:
        raise InputError("the load that grows is zero", remedy="give a direction such as (1, 0, 0)")
    load = LoadCase.gravity(model.assembly, STANDARD_GRAVITY * size, given)
    name = f"{', '.join(f'{x:g}' for x in given)} of the weight"
    return LoadCase(load.wrench, name, acceleration=load.acceleration, shake=load.acceleration)


def _said(found: LargeDisplacement, driver: Driver) -> str:
    """A sentence for a person."""
    if len(found.displacement) < 2 and found.end is not End.STOPPED:
        before = {
            Drive.LOAD: "before the load grows",
            Drive.SUPPORTS: "before its supports move",
            Drive.FRICTION: "with all of its friction",
        }
        return f"it does not stand {before[found.drive]}"
    unit = f" {found.unit}" if found.unit else ""
    far, last = quantity(float(found.displacement[-1]), "m"), found.load[-1]
    if found.drive is Drive.FRICTION:
        if found.end is End.FALLS:
            return f"it falls at {last:.3g} of its friction, '{_mover(driver, found)}' first"
        reached = found.end is End.REACHED
        what = "without any friction" if reached else f"at {last:.3g} of its friction"
        return f"it is still at rest {what}, moved by {far}"
    load = _plain(found)
    last = load[-1]
    peak = f"at most {load.max():.4g}{unit}"
    if found.drive is Drive.LOAD:  # blocks that jam may carry more than what set them in motion
        peak += f" at {quantity(float(found.displacement[load.argmax()]), 'm')}"
    if found.drive is Drive.SUPPORTS and load.min() < 0.0:
        peak = f"from {load.min():.4g} to {load.max():.4g}{unit}"
    if found.capacity is not None and found.end is End.SPENT:
        return f"{peak}; moved by {quantity(found.capacity, 'm')} it falls without this load"
    if found.end is End.FALLS:
        return f"{peak}; it falls at {far}, '{_mover(driver, found)}' first"
    if found.end is End.HELD:
        return f"nothing gives way at {far}, where it is {last:.4g}{unit}"
    if found.drive is Drive.LOAD and found.end is End.REACHED:
        moved = lengths(found.states[-1].positions[:, :3])
        far = f"'{found.assembly.names[moved.argmax()]}' had moved by {quantity(moved.max(), 'm')}"
        return f"{peak}; followed until {far}, where it is {last:.4g}"
    why = {End.REACHED: "followed", End.LOST: "no further position was found, followed"}
    told = why.get(found.end, f"{found.stopped}, followed")
    return f"{peak}; {told} to {far}, where it is {last:.4g}{unit}"


def _plain(found: LargeDisplacement) -> Floats:
    """The load (s,) without what is only rounding: a millionth of the weight."""
    load = found.load
    if found.drive is not Drive.SUPPORTS:
        return load
    weight = np.linalg.norm(found.model.load.wrench[:, :3], axis=1).sum()
    return np.where(np.abs(load) > SAME * weight, load, 0.0)


def _mover(driver: Driver, found: LargeDisplacement) -> str:
    """The block that moves farthest while what drives is held."""
    return found.assembly.names[int(driver.bodies.free[int(np.argmax(driver.travel))])]


OFFERED = Offered(
    push, "arch.json seismic:0,1 --to 0.01", ("to",), names=("to", "options.pace", "time_limit_s")
)


def large_state(
    model: Model,
    apart: Apart,
    bodies: Bodies,
    moment: DrivenState,
    met: Bools,
    length: float,
    load: float,
) -> LargeState:
    """A moment in m and N, for the interfaces of the model and those that blocks have met."""
    shown, mine, kept = model_with_met(model, apart, met)
    return state_of(shown, bodies, moment, mine, kept, length, load)


def state_of(
    model: Model,
    bodies: Bodies,
    moment: DrivenState,
    mine: Bools,
    kept: Bools,
    length: float,
    load: float,
) -> LargeState:
    """A moment in m and N, for all interfaces of the model.

    ``mine`` are the corners of the model that were followed; the moment has them among others, they
    are ``kept``.
    """
    contacts = model.contacts
    origin = model.assembly.centroid[bodies.free].mean(axis=0)
    point = contacts.point.copy()
    point[mine] = moment.placed.point[kept] * bodies.length_unit + origin
    axes = numbered_axes(bodies, moment.placed.axes)[kept]
    local = numbered_forces(bodies, moment.response.force)[kept]
    frame = contacts.frame.copy()
    frame[model.active] = _frames(contacts, model.active, axes, local[:, 0])
    force = np.zeros((contacts.corner_count, 3))
    world = np.einsum("ki,kij->kj", local, axes)
    of_interface = frame[contacts.interface[mine]]
    force[mine] = np.einsum("kij,kj->ki", of_interface, world) * bodies.force_unit
    moved = replace(contacts, point=point, frame=frame)
    return LargeState(
        length * moment.displacement,
        load * moment.load,
        frozen(block_motions(bodies, (moment.pose,))[0]),
        moved,
        frozen(force),
    )


def _frames(contacts: Contacts, active: Bools, axes: Floats, pressure: Floats) -> Floats:
    """(m, 3, 3) of the active interfaces: the mean of their corners, weighted by the pressure."""
    number = np.cumsum(active) - 1
    owner = number[contacts.interface[active[contacts.interface]]]
    total = np.bincount(owner, pressure, minlength=int(active.sum()))
    weight = np.where(total[owner] > 0.0, pressure, 1.0)
    sums = np.zeros((int(active.sum()), 3, 3))
    np.add.at(sums, owner, weight[:, None, None] * axes)
    n = sums[:, 0] / np.linalg.norm(sums[:, 0], axis=1, keepdims=True)
    u = sums[:, 1] - (sums[:, 1] * n).sum(axis=1, keepdims=True) * n
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return np.stack([n, u, cross(n, u)], axis=1)
