"""Follow the blocks of a model until they rest or fall."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import Floats, of_type
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, How, supported_model
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.results import Residuals
from drystone.settlement.bodies import Bodies, build_bodies
from drystone.settlement.faces.corners import Carrier, flush_ends
from drystone.settlement.faces.meeting import Apart, faces_apart, followed_model, model_with_met
from drystone.settlement.follow import Follower, Track
from drystone.settlement.loading_order import earlier_loads
from drystone.settlement.proof import PROVEN, rest_residuals
from drystone.settlement.settlement_types import (
    Outcome,
    Settlement,
    SettlementOptions,
    SettlementPath,
)
from drystone.settlement.springs import BlockPositions, rotation_vectors

TOLD = 3
"""Pairs of blocks that met meanwhile and are named in the message."""
STIFFER, STIFFEST = 1e-2, 1e-9
"""Overlap of the next try by the last where springs are too soft, and the smallest: below it gaps
are lost in rounding."""


@checked_call
def settle(
    given: Given,
    motion: Mapping[int | str, Any] | None = None,
    *,
    options: SettlementOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Settlement:
    """Follow the blocks step by step until they rest or fall.

    Contacts are stiff springs with path-dependent Coulomb friction. Translations and rotations are
    finite: corners and faces move with their blocks. Wrenches of the load keep their direction and
    act about the moved centroids. Besides the interfaces of the model, faces act that blocks meet
    while they move: those that are parallel to 2 degrees and face each other at up to ``fall`` of a
    block's size.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    motion
        Motion of supports after rest under the load: per fixed block its translation [m] (3,),
        or translation and rotation [m, rad] (6,) about its centroid; world axes. It is added to the
        motion in the load (:meth:`drystone.LoadCase.settlement`).
    options

    Raises
    ------
    InputError
        A block that is not fixed is to be moved, or what was given cannot be made into a model.

    Examples
    --------
    A wedge that no uniform stiffness holds slides by half a percent of its size, turns and jams:

    >>> import drystone
    >>> from drystone.models import wedge
    >>> from drystone.settlement import SettlementOptions
    >>> tilted = drystone.LoadCase.tilt(wedge("b"), (1.0, 0.0, 0.0), 50.0)
    >>> model = drystone.Model.of(wedge("b"), friction=0.84, load=tilted)
    >>> settled = drystone.settle(model, options=SettlementOptions(carrier="moving"))
    >>> settled.outcome, round(settled.travel, 3)
    (<Outcome.RESTS: 'comes to rest'>, 0.005)
    """
    chosen = SettlementOptions.of(options)
    model = supported_model(given, **how)
    model.require_dry("settlement", "what a joint still carries after it has moved is not known")
    clock = Clock(time_limit_s, stop)
    moving = support_motion(model, motion)
    model = model.with_load(replace(model.load, motion=None))
    if not len(model.assembly.free):
        return _nothing_free(model, chosen, clock)
    carriers = _carriers(model, chosen)
    apart = faces_apart(model, chosen.fall)
    task = partial(_path, model, apart, motion=moving, chosen=chosen, clock=clock)
    if executor is None or len(carriers) == 1:
        paths = tuple(task(one, progress=progress) for one in carriers)
    else:
        with WorkerPool(executor) as pool:
            paths = tuple(pool.answers(task, carriers, clock.late))
        # where it was ended early: the beginning of the others
        paths += tuple(task(one, progress=progress) for one in carriers[len(paths) :])
    outcome, message = _outcome_of(paths, clock)
    return Settlement(outcome, message, paths, clock.reason, chosen, {"solve": clock.elapsed_s})


def _nothing_free(model: Model, chosen: SettlementOptions, clock: Clock) -> Settlement:
    """Every block is a support."""
    contacts, count = model.contacts, len(model.assembly)
    corners = contacts.corner_count
    path = SettlementPath(
        Carrier.MOVING,
        Outcome.RESTS,
        model,
        np.zeros((1, count, 6)),
        np.zeros(count),
        np.zeros((corners, 3)),
        contacts.point,
        contacts.frame[contacts.interface],
        np.zeros(corners),
        Residuals(),
        0.0,
        0,
        0,
    )
    said = {"solve": clock.elapsed_s}
    return Settlement(Outcome.RESTS, "every block is fixed", (path,), "", chosen, said)


def _carriers(model: Model, chosen: SettlementOptions) -> tuple[Carrier, ...]:
    """The carriers to follow: two if the ends of loaded joints allow both."""
    if chosen.carrier is not None:
        return (chosen.carrier,)
    contacts = model.contacts.select(model.active)
    flush = flush_ends(model.assembly, contacts)
    return (Carrier.MOVING, Carrier.RESTING) if flush else (Carrier.MOVING,)


def support_motion(model: Model, motion: Mapping[int | str, Any] | None) -> Floats | None:
    """(n, 6) [m, rad] of the supports; None where none moves."""
    assembly, case = model.assembly, model.load
    if motion is not None:
        remedy = 'give translations by name of the block, such as {"base": (0.0, 0.0, -0.01)}'
        of_type(motion, Mapping, "the motion", remedy)  # type: ignore[type-abstract]
        for block, one in motion.items():
            case = case + LoadCase.settlement(assembly, block, one)
    if case.motion is None:
        return None
    for i in np.flatnonzero(case.motion.any(axis=1) & ~assembly.fixed):
        raise InputError(
            f"block '{assembly.names[i]}' is not fixed, so its motion is not prescribed",
            remedy="move a support, or load the block",
        )
    return case.motion


def _path(
    model: Model,
    apart: Apart,
    carrier: Carrier,
    motion: Floats | None,
    chosen: SettlementOptions,
    clock: Clock,
    progress: Progress | None = None,
) -> SettlementPath:
    """One run, in physical numbers."""
    part, gap = followed_model(model, apart)
    stage = f"following the blocks, ends carried by the {carrier.value} block"
    most = 0

    def tell(travel: float) -> None:
        nonlocal most
        most = max(most, min(int(100.0 * travel / chosen.fall), 99))
        if progress is not None:
            progress(stage, most, 100)

    overlap = chosen.overlap
    while True:
        bodies = build_bodies(part, carrier, overlap=overlap, tangential=chosen.tangential, gap=gap)
        follower = Follower(
            bodies,
            fall=chosen.fall,
            pace=chosen.pace,
            step_limit=chosen.step_limit,
            stop=clock.late,
            tell=tell,
        )
        track = follower.run(
            None if motion is None else scaled_motion(bodies, motion),
            earlier_loads(bodies, chosen.loading),
        )
        if track.ended != "falls" or not track.squeezed or overlap <= STIFFEST:
            break
        overlap *= STIFFER
    if progress is not None:
        progress(stage, 100, 100)
    path = _physical(model, apart, bodies, track, carrier)
    travel = float(track.travel.max(initial=0.0))
    if track.ended != "rests":
        # out of steps: where a block is beyond what stands and still moves, it does not stand
        moved_on = motion is None and not clock.reason and travel > chosen.rest_within
        return replace(path, outcome=Outcome.FALLS) if moved_on else path
    residuals = rest_residuals(path.moved_model(), path.force, path.gap)
    if residuals.largest > PROVEN:
        return replace(path, residuals=residuals, outcome=Outcome.UNKNOWN)
    # blocks move as far as the supports that they follow
    near = motion is not None or travel <= chosen.rest_within
    return replace(path, residuals=residuals, outcome=Outcome.RESTS if near else Outcome.DISPLACED)


def scaled_motion(bodies: Bodies, motion: Floats) -> Floats:
    """Motions (n, 6) [m, rad] as the steps take them."""
    out = motion.copy()
    out[:, :3] /= bodies.length_unit
    out[:, 3:] *= bodies.radius[:, None]
    return out


def _physical(
    model: Model, apart: Apart, bodies: Bodies, track: Track, carrier: Carrier
) -> SettlementPath:
    """A track in m, rad and N, for all corners of the model and of the faces that were met."""
    joints = len(model.contacts)
    model, corners, kept = model_with_met(model, apart, track.met)
    contacts = model.contacts
    positions = block_motions(bodies, track.frames)
    force = np.zeros((contacts.corner_count, 3))
    force[corners] = track.response.force[kept] * bodies.force_unit
    point, axes = contacts.point.copy(), contacts.frame[contacts.interface].copy()
    gap = np.zeros(contacts.corner_count)
    origin = model.assembly.centroid[bodies.free].mean(axis=0) if len(bodies.free) else 0.0
    point[corners] = track.placed.point[kept] * bodies.length_unit + origin
    axes[corners] = track.placed.axes[kept]
    gap[corners] = track.placed.gap[kept] * bodies.length_unit
    travel = np.zeros(len(model.assembly))
    travel[bodies.free] = track.travel
    ends = {"falls": Outcome.FALLS}
    return SettlementPath(
        carrier,
        ends.get(track.ended, Outcome.UNKNOWN),
        model,
        positions,
        travel,
        force,
        point,
        axes,
        gap,
        None,
        track.share,
        track.steps,
        track.iterations,
        tuple(range(joints, len(model.contacts))),
    )


def block_motions(bodies: Bodies, poses: tuple[BlockPositions, ...]) -> Floats:
    """(s, n, 6) [m, rad] from the beginning."""
    gone = (np.stack([pose.place for pose in poses]) - bodies.centroid) * bodies.length_unit
    turn = np.concatenate([pose.turn for pose in poses])
    return np.concatenate([gone, rotation_vectors(turn).reshape(gone.shape)], axis=2)


def _outcome_of(paths: tuple[SettlementPath, ...], clock: Clock) -> tuple[Outcome, str]:
    """The outcome of all paths, and a sentence."""
    first = paths[0]
    for one in paths:
        if one.outcome is Outcome.UNKNOWN:
            why = clock.reason or f"not at rest, {one.share:.1e} of the load is not carried"
            return Outcome.UNKNOWN, f"{why} after {one.steps} steps"
    stands = [one.outcome is Outcome.RESTS for one in paths]
    if any(stands) and not all(stands):
        said = "; ".join(f"carried by the {one.carrier.value} block, {_said(one)}" for one in paths)
        return Outcome.ENDS_DECIDE, f"the ends of the joints decide: {said}"
    # of two that rest, the one that settles more; of two that do not, the one that falls
    worst = max(paths, key=lambda one: (one.outcome is Outcome.FALLS, one.travel.max(initial=0.0)))
    chosen = worst if worst.outcome is not first.outcome else first
    return chosen.outcome, _said(chosen)


def _said(path: SettlementPath) -> str:
    travel = float(path.travel.max(initial=0.0))
    if path.outcome is Outcome.FALLS:
        name = path.model.assembly.names[int(np.argmax(path.travel))]
        return f"it falls: '{name}' has moved by {travel:.2f} of its size and still moves"
    moved = float(np.linalg.norm(path.displacement[:, :3], axis=1).max(initial=0.0))
    far = "" if path.outcome is Outcome.RESTS else ", farther than what stands does"
    return (
        f"it comes to rest after settling by {moved:.2g} m, {travel:.2g} of a block's size{far}"
        f"{_said_met(path)}"
    )


def _said_met(path: SettlementPath) -> str:
    """Which blocks have met."""
    names, contacts = path.model.assembly.names, path.model.contacts
    pairs = {(int(contacts.block_a[i]), int(contacts.block_b[i])): None for i in path.met}
    told = [f"'{names[a]}' meets '{names[b]}'" for a, b in list(pairs)[:TOLD]]
    more = [f"and {len(pairs) - TOLD} pairs more"] if len(pairs) > TOLD else []
    return "".join(f", {one}" for one in told + more)


__all__ = ["block_motions", "scaled_motion", "settle", "support_motion"]
