"""Follow the blocks of one model, or of many, until they rest or fall."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike
from typing import Any, Unpack

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, of_type
from drystone.base.display import shortened
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, How, supported_model
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.results import Residuals
from drystone.settlement.bodies import Bodies, build_bodies
from drystone.settlement.faces.both_carriers import ends_alike
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
from drystone.settlement.springs import DENSE, BlockPositions, rotation_vectors
from drystone.settlement.together import tracks_of

TOLD = 3
"""Pairs of blocks that met meanwhile and are named in the message."""
SMALL, AT_ONCE = 8, 32
"""Free blocks up to which models are computed together, and models at once: from timings."""
STIFFER, STIFFEST = 1e-2, 1e-9
"""Overlap of the next try by the last where springs are too soft, and the smallest: below it gaps
are lost in rounding."""
STIFF_STEPS = 400
"""Increments on stiffer springs after which a verdict is undecided. On the Armadillo vault those
that rest take 230; on stiffer springs a block takes a hundred times as many steps to leave."""


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
    return _carried(model, moving, chosen, clock, executor, progress)


def settle_for_verdict(
    model: Model,
    *,
    options: SettlementOptions | None = None,
    executor: Workers | None = None,
    stop: Stop | None = None,
) -> Settlement:
    """As :func:`settle`, where only the verdict counts.

    Of many blocks the path ends where a block has moved farther than ``rest_within``: wherever it
    goes from there, the structure does not stand.
    """
    chosen, clock = SettlementOptions.of(options), Clock(float("inf"), stop)
    left_at = chosen.rest_within if len(model.assembly.free) > DENSE else np.inf
    return _carried(model, None, chosen, clock, executor, None, left_at)


def _carried(
    model: Model,
    moving: Floats | None,
    chosen: SettlementOptions,
    clock: Clock,
    executor: Workers | None,
    progress: Progress | None,
    left_at: float = np.inf,
) -> Settlement:
    """The paths of all carriers; those after one that is unknown are left out."""
    if not len(model.assembly.free):
        return _nothing_free(model, chosen, clock.elapsed_s)
    carriers = _carriers(model, chosen)
    apart = faces_apart(model, chosen.fall)
    tries = [(one, one is not carriers[-1]) for one in carriers]
    task = partial(_tried, model, apart, moving, chosen, clock, left_at)
    known: list[tuple[SettlementPath, bool]] = []
    if executor is not None and len(carriers) > 1:
        with WorkerPool(executor) as pool:
            known = list(pool.answers(task, tries, clock.late))
    paths: tuple[SettlementPath, ...] = ()
    for number, carrier in enumerate(tries):
        # of many blocks the forces are much the same for both carriers
        stiff = paths[-1].overlap if paths and left_at < np.inf else None
        if number < len(known):
            path, last = known[number]
        else:  # also where the workers were ended early: the beginning of the others
            path, last = task(carrier, progress=progress, overlap=stiff)
        paths += (path,)
        if last or path.outcome is Outcome.UNKNOWN:
            break  # then the outcome is unknown, whatever the other one does
    return _told(paths, chosen, clock, clock.elapsed_s)


@checked_call
def settle_many(
    models: Iterable[Given],
    *,
    options: SettlementOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> tuple[Settlement, ...]:
    """:func:`settle` of many models; small ones with equal numbers of corners are computed at once.

    64 runs of one block are four times as fast as one after another.

    Parameters
    ----------
    models
        As :func:`settle` takes them, in order.
    options
        Of every settlement.

    Raises
    ------
    InputError
        As for :func:`settle`, or ``models`` is a single model.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import wedge
    >>> from drystone.settlement import settle_many
    >>> block = drystone.Model.of(wedge("b"), friction=0.84)
    >>> tilts = [drystone.LoadCase.tilt(block.assembly, (1.0, 0.0, 0.0), at) for at in (40, 70)]
    >>> [one.outcome.value for one in settle_many([block.with_load(tilt) for tilt in tilts])]
    ['comes to rest', 'falls']
    """
    one = isinstance(models, str | bytes | PathLike | Assembly | Model)
    if one or not isinstance(models, Iterable):
        said = f"the models are {shortened(repr(models), 60)}"
        raise InputError(said, remedy="give a list of models, such as [model]")
    chosen = SettlementOptions.of(options)
    clock = Clock(time_limit_s, stop)
    ready = [_ready(one, how) for one in models]
    groups = [ready[at : at + AT_ONCE] for at in range(0, len(ready), AT_ONCE)]
    found: list[Settlement] = []
    with WorkerPool(executor) as pool:
        for some in pool.answers(partial(_settled, chosen, clock), groups):
            found += some
            if progress is not None:
                progress("models", len(found), len(ready))
    return tuple(found)


def _ready(given: Given, how: How) -> tuple[Model, Floats | None]:
    """A model without the motion of its supports, and that motion."""
    model = supported_model(given, **how)
    model.require_dry("settlement", "what a joint still carries after it has moved is not known")
    return model.with_load(replace(model.load, motion=None)), support_motion(model, None)


def _settled(
    chosen: SettlementOptions, clock: Clock, models: Sequence[tuple[Model, Floats | None]]
) -> list[Settlement]:
    """The settlements of some models; runs of one shape are computed together."""
    began = clock.elapsed_s
    paths: dict[tuple[int, Carrier], SettlementPath] = {}
    carriers = [_carriers(model, chosen) if len(model.assembly.free) else () for model, _ in models]
    asked = [number for number, some in enumerate(carriers) if some]
    for turn in range(2):
        asked = [number for number in asked if len(carriers[number]) > turn]
        tries = [(*models[i], carriers[i][turn], turn + 1 < len(carriers[i])) for i in asked]
        found = _side_by_side(chosen, clock, tries)
        paths |= {(i, carriers[i][turn]): path for i, (path, _) in zip(asked, found, strict=True)}
        asked = [i for i, (_, last) in zip(asked, found, strict=True) if not last]
    each = (clock.elapsed_s - began) / max(len(models), 1)
    told = []
    for number, (model, _) in enumerate(models):
        mine = tuple(paths[number, one] for one in Carrier if (number, one) in paths)
        told.append(
            _told(mine, chosen, clock, each) if mine else _nothing_free(model, chosen, each)
        )
    return told


def _side_by_side(
    chosen: SettlementOptions,
    clock: Clock,
    models: Sequence[tuple[Model, Floats | None, Carrier, bool]],
) -> list[tuple[SettlementPath, bool]]:
    """As :func:`_path` of each; runs of one shape are computed together."""
    runs: list[tuple[int, Apart, Follower]] = []
    paths: dict[int, tuple[SettlementPath, bool]] = {}
    for number, (model, motion, carrier, first) in enumerate(models):
        apart = faces_apart(model, chosen.fall)
        if motion is None and len(model.assembly.free) <= SMALL:
            runs.append(
                (number, apart, _follower(model, apart, carrier, chosen, clock, chosen.overlap))
            )
        else:
            paths[number] = _path(model, apart, carrier, first, motion, chosen, clock)
    tracks = tracks_of(
        [(one, one.whole_run(None, earlier_loads(one.bodies, chosen.loading))) for *_, one in runs]
    )
    for (number, apart, one), track in zip(runs, tracks, strict=True):
        model, _, carrier, first = models[number]
        if _too_soft(track, chosen.overlap):
            stiffer = STIFFER * chosen.overlap
            paths[number] = _path(
                model, apart, carrier, first, None, chosen, clock, overlap=stiffer
            )
        else:
            bodies = one.bodies
            paths[number] = _judged(
                model, apart, carrier, first, False, chosen, clock, bodies, track
            )
    return [paths[number] for number in range(len(models))]


def _told(
    paths: tuple[SettlementPath, ...], chosen: SettlementOptions, clock: Clock, spent_s: float
) -> Settlement:
    outcome, message = _outcome_of(paths, clock)
    return Settlement(outcome, message, paths, clock.reason, chosen, {"solve": spent_s})


def _nothing_free(model: Model, chosen: SettlementOptions, spent_s: float) -> Settlement:
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
    said = {"solve": spent_s}
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


def _tried(
    model: Model,
    apart: Apart,
    motion: Floats | None,
    chosen: SettlementOptions,
    clock: Clock,
    left_at: float,
    carrier: tuple[Carrier, bool],
    progress: Progress | None = None,
    overlap: float | None = None,
) -> tuple[SettlementPath, bool]:
    return _path(model, apart, *carrier, motion, chosen, clock, progress, overlap, left_at)


def _path(
    model: Model,
    apart: Apart,
    carrier: Carrier,
    first: bool,
    motion: Floats | None,
    chosen: SettlementOptions,
    clock: Clock,
    progress: Progress | None = None,
    overlap: float | None = None,
    left_at: float = np.inf,
) -> tuple[SettlementPath, bool]:
    """One run, in physical numbers, and whether the other carrier need not be tried.

    ``first``: there is another one.
    """
    stage = f"following the blocks, ends carried by the {carrier.value} block"
    most = 0

    def tell(travel: float) -> None:
        nonlocal most
        most = max(most, min(int(100.0 * travel / chosen.fall), 99))
        if progress is not None:
            progress(stage, most, 100)

    overlap = chosen.overlap if overlap is None else overlap
    while True:
        follower = _follower(model, apart, carrier, chosen, clock, overlap, tell, left_at)
        if left_at < np.inf and overlap < chosen.overlap:
            follower.step_limit = min(chosen.step_limit, STIFF_STEPS)
        bodies = follower.bodies
        track = follower.run(
            None if motion is None else scaled_motion(bodies, motion),
            earlier_loads(bodies, chosen.loading),
        )
        if not _too_soft(track, overlap):
            break
        overlap *= STIFFER
    if progress is not None:
        progress(stage, 100, 100)
    return _judged(model, apart, carrier, first, motion is not None, chosen, clock, bodies, track)


def _follower(
    model: Model,
    apart: Apart,
    carrier: Carrier,
    chosen: SettlementOptions,
    clock: Clock,
    overlap: float,
    tell: Callable[[float], None] | None = None,
    left_at: float = np.inf,
) -> Follower:
    """A run that has not begun."""
    part, gap = followed_model(model, apart)
    bodies = build_bodies(part, carrier, overlap=overlap, tangential=chosen.tangential, gap=gap)
    return Follower(
        bodies,
        fall=chosen.fall,
        pace=chosen.pace,
        step_limit=chosen.step_limit,
        stop=clock.late,
        tell=tell,
        left_at=left_at,
    )


def _too_soft(track: Track, overlap: float) -> bool:
    """Whether it fell on springs that were squeezed, and stiffer ones are to be tried."""
    return track.ended in ("falls", "leaves") and track.squeezed and overlap > STIFFEST


def _judged(
    model: Model,
    apart: Apart,
    carrier: Carrier,
    first: bool,
    moving: bool,
    chosen: SettlementOptions,
    clock: Clock,
    bodies: Bodies,
    track: Track,
) -> tuple[SettlementPath, bool]:
    """A track in physical numbers, with its outcome; ``moving``: supports have moved.

    The other carrier need not be tried where the outcome is unknown, whatever it says, and where it
    would say the same.
    """
    path = _physical(model, apart, bodies, track, carrier)
    path = _with_outcome(path, track, moving, chosen, clock)
    if path.outcome is Outcome.UNKNOWN or not first:
        return path, True
    part, gap = followed_model(model, apart)
    return path, ends_alike(part.assembly, part.contacts, gap, carrier, bodies, track.frames)


def _with_outcome(
    path: SettlementPath, track: Track, moving: bool, chosen: SettlementOptions, clock: Clock
) -> SettlementPath:
    travel = float(track.travel.max(initial=0.0))
    if track.ended != "rests":
        # out of steps: where a block is beyond what stands and still moves, it does not stand
        moved_on = not moving and not clock.reason and travel > chosen.rest_within
        return replace(path, outcome=Outcome.FALLS) if moved_on else path
    residuals = rest_residuals(path.moved_model(), path.force, path.gap)
    if residuals.largest > PROVEN:
        return replace(path, residuals=residuals, outcome=Outcome.UNKNOWN)
    # blocks move as far as the supports that they follow
    near = moving or travel <= chosen.rest_within
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
        bodies.overlap,
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


__all__ = [
    "block_motions",
    "scaled_motion",
    "settle",
    "settle_for_verdict",
    "settle_many",
    "support_motion",
]
