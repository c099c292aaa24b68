"""Follow the blocks of one model, or of many, until they rest or fall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, TypeAlias, Unpack

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import first_of, rounded_up
from drystone.base.errors import InputError
from drystone.base.ragged import linked
from drystone.base.settings import Clock, Stop, Workers, checked_call
from drystone.base.workers import WorkerPool
from drystone.contacts import joined_contacts
from drystone.detection.tolerances import millimetres
from drystone.io.opening import Given, LongHow, supported_model
from drystone.mechanics.corners import Carrier
from drystone.mechanics.follow import Course
from drystone.mechanics.increments import FEW
from drystone.mechanics.meeting import Apart, faces_apart, followed_model, with_what_touches
from drystone.mechanics.vertices_met import still_on_faces, vertices_met
from drystone.model import Model
from drystone.settlement.path import FollowedCase, carriers_of, path_of, support_motion
from drystone.settlement.settlement_types import (
    Outcome,
    Settlement,
    SettlementOptions,
    SettlementPath,
    rest_residuals,
)

_UNKNOWN = "what a joint still carries after it has moved is not known"


def outcome_of(paths: tuple[SettlementPath, ...], clock: Clock) -> tuple[Outcome, str]:
    """The outcome of all paths, and a sentence."""
    first = paths[0]
    for one in paths:
        if one.outcome is Outcome.UNKNOWN:
            why = f"not at rest, {one.share:.1e} of the load is not carried"
            if one.residuals is not None:
                left = one.residuals.largest
                why = f"at rest but for a block that is left with {left:.1e} of what it feels"
            why = clock.reason or why
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
    if path.displacement[path.model.assembly.fixed].any():
        return f"it comes to rest on the moved supports, blocks moved by {moved:.2g} m at most"
    far = "" if path.outcome is Outcome.RESTS else ", farther than what stands does"
    return (
        f"it comes to rest after settling by {moved:.2g} m, {travel:.2g} of a block's size{far}"
        f"{_said_met(path)}"
    )


def said_longer(*paths: SettlementPath) -> str:
    """How much longer faces make it stand, by those of these paths that rest."""
    rests = [one for one in paths if one.outcome is Outcome.RESTS]
    beyond = max(one.beyond for one in rests)
    if not beyond > 0.0:
        return ""
    far = millimetres(rounded_up(1e3 * beyond, 2) / 1e3)
    if rests[0].carrier is Carrier.LONGER:
        return f"; it slides over ends of faces, and stands where these go on {far} mm farther"
    other = "resting" if rests[0].carrier is Carrier.MOVING else "moving"
    longer = f"go on more than {far} mm beyond those ends"
    return f"; it stands where the faces of the {other} block {longer}"


def _said_met(path: SettlementPath) -> str:
    """Which blocks have met."""
    names, contacts = path.model.assembly.names, path.model.contacts
    pairs = {(int(contacts.block_a[i]), int(contacts.block_b[i])): None for i in path.met}
    told = [f"'{names[a]}' meets '{names[b]}'" for a, b in pairs]
    return "".join(f", {one}" for one in first_of(told, "pairs more"))


_Run: TypeAlias = tuple[SettlementPath, bool, dict[Carrier, Course]]

MEETINGS = 3
"""How often what falls is followed again because vertices meet faces. Chosen."""


@checked_call
def settle(
    given: Given,
    motion: Mapping[int | str, Any] | None = None,
    *,
    options: SettlementOptions | None = None,
    **how: Unpack[LongHow],
) -> Settlement:
    """Follow the blocks step by step until they rest or fall.

    Contacts are stiff springs with path-dependent Coulomb friction. Translations and rotations are
    finite: corners and faces move with their blocks. Forces of the load keep their direction and
    act where they did on their blocks. Besides the interfaces of the model, faces act that blocks
    meet while they move: those that are parallel to 2 degrees and face each other at up to ``fall``
    of a block's size. What falls is followed again with the vertices that would pass through a
    face.

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
        No block is free, one that is not fixed is to be moved, or what was given cannot be made
        into a model.

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
    clock = Clock.of(how)
    model = supported_model(given, **how)
    model.require_dry("settlement", _UNKNOWN, yielding=True)
    if not len(model.assembly.free):
        raise InputError("every block is fixed", remedy="leave a block free")
    moving = support_motion(model, motion)
    model = model.with_load(replace(model.load, motion=None))
    found = _carried(model, moving, chosen, clock)
    falls = found.outcome is Outcome.FALLS
    more = with_what_touches(model, found.displacement) if falls else None
    if more is not None:
        found = _carried(more, moving, chosen, clock)
    if found.outcome is not Outcome.ENDS_DECIDE:
        return found
    return replace(found, message=f"{found.message}{said_longer(*found.paths)}")


def settle_for_verdict(
    model: Model,
    *,
    options: SettlementOptions | None = None,
    executor: Workers | None = None,
    stop: Stop | None = None,
    felt: Floats | None = None,
    falls: dict[Carrier, Course] | None = None,
    near: SettlementPath | None = None,
) -> Settlement:
    """As :func:`settle`, where only the verdict counts, without :func:`said_longer`.

    Of many blocks the path ends where a block has moved farther than ``rest_within``: wherever it
    goes from there, the structure does not stand. ``felt``, ``falls``, ``near``: see
    :class:`FollowedCase`.
    """
    chosen, clock = SettlementOptions.of(options), Clock(float("inf"), stop, workers=executor)
    begun = any(one in falls for one in carriers_of(model, chosen)) if falls else False
    left_at = chosen.rest_within if len(model.assembly.free) > FEW else np.inf
    follow = partial(_carried, model, None, chosen, clock, left_at, felt, near=near)
    found = follow(falls)
    # what ends otherwise than those that fell is followed in full
    return follow() if begun and found.outcome is not Outcome.FALLS else found


def _carried(
    model: Model,
    moving: Floats | None,
    chosen: SettlementOptions,
    clock: Clock,
    left_at: float = np.inf,
    felt: Floats | None = None,
    falls: dict[Carrier, Course] | None = None,
    near: SettlementPath | None = None,
) -> Settlement:
    """Where the blocks end; what falls is followed again with the vertices that meet a face."""
    began = clock.elapsed_s
    apart = faces_apart(model, chosen.fall)
    falls = {} if falls is None else falls
    case = FollowedCase(model, apart, chosen, clock, moving, left_at, felt, falls, near)
    tried = [(case, _begun(case))]
    while len(tried) <= MEETINGS and (more := _with_met(*tried[-1])) is not None:
        begun = _begun(more)
        if not _on_faces(begun[0][0]):
            break
        tried.append((more, begun))
    case, paths = _with_other_carrier(tried)
    if len(tried) > 1:
        falls.clear()
        falls.update(case.falls)
    paths = _part_by_part(case, paths)
    outcome, message = outcome_of(paths, clock)
    spent = {"solve": clock.elapsed_s - began}
    return Settlement(outcome, message, paths, chosen, stopped=clock.reason, time_s=spent)


def _with_met(case: FollowedCase, begun: list[_Run]) -> FollowedCase | None:
    """What falls, with the vertices that pass through a face; None where there are none."""
    path, *_ = begun[0]
    if path.outcome is not Outcome.FALLS or case.clock.late():
        return None
    part, _ = followed_model(case.model, case.apart)
    met = vertices_met(part, path.positions, case.chosen.fall)
    if not len(met.contacts):
        return None
    every = joined_contacts(case.apart.contacts, met.contacts)
    apart = Apart(every, np.concatenate([case.apart.gap, met.gap]))
    # the falls that are known are of joints that are not all
    return replace(case, apart=apart, near=None, falls={})


def _with_other_carrier(
    tried: list[tuple[FollowedCase, list[_Run]]],
) -> tuple[FollowedCase, tuple[SettlementPath, ...]]:
    """The last of some cases with more and more vertices in which they count, and all its paths.

    What falls with all vertices falls without some of them: those cases have no other carrier.
    """
    if tried[-1][1][0][0].outcome is Outcome.FALLS:
        paths = _paths(*tried[-1])
        falls = all(path.outcome is Outcome.FALLS and _on_faces(path) for path in paths)
        if falls or len(tried) == 1:
            return tried[-1][0], paths
    found = tried[0][0], _paths(*tried[0])
    for case, begun in tried[1:]:
        if any(path.outcome is not Outcome.FALLS for path in found[1]):
            break
        again = _paths(case, begun)
        if not all(_on_faces(path) for path in again):
            break
        found = case, again
    return found


def _part_by_part(
    case: FollowedCase, paths: tuple[SettlementPath, ...]
) -> tuple[SettlementPath, ...]:
    """The paths; where many do not rest, those of parts that neither touch nor may meet, if all do.

    Few blocks that rest far are followed again on stiffer springs, which many are not: what
    stands beside them must not change their end. A part that falls may end on another one.
    """
    found: list[tuple[Ints, tuple[SettlementPath, ...]]] = []
    for blocks in _parts(case) if {path.outcome for path in paths} != {Outcome.RESTS} else ():
        one = case.model.subset(blocks.tolist())
        left_at = case.left_at if len(one.assembly.free) > FEW else np.inf
        alone = _carried(one, None, case.chosen, case.clock, left_at)
        if not alone.rests or any(path.met for path in alone.paths):
            return paths
        found.append((blocks, alone.paths))
    return _joined(case.model, found) if found else paths


def _parts(case: FollowedCase) -> list[Ints]:
    """Of many blocks those that touch or may meet, with all supports; none if all of them do."""
    if case.motion is not None or not case.many:
        return []
    fixed = case.model.assembly.fixed
    joints = followed_model(case.model, case.apart)[0].contacts
    free = ~(fixed[joints.block_a] | fixed[joints.block_b])
    part = linked(joints.block_a[free], joints.block_b[free], len(fixed))
    numbers = np.unique(part[~fixed])
    some = numbers if len(numbers) > 1 else ()
    return [np.flatnonzero(fixed | (part == number)) for number in some]


def _joined(
    model: Model, parts: Sequence[tuple[Ints, tuple[SettlementPath, ...]]]
) -> tuple[SettlementPath, ...]:
    """The paths of a model whose parts all rest; some parts have one for both carriers."""
    most = max(len(paths) for _, paths in parts)
    return tuple(
        _one_path(model, [(blocks, paths[min(k, len(paths) - 1)]) for blocks, paths in parts])
        for k in range(most)
    )


def _one_path(model: Model, parts: Sequence[tuple[Ints, SettlementPath]]) -> SettlementPath:
    """One path of parts of a model that all rest; those that rest early stay there."""
    contacts, count = model.contacts, len(model.assembly)
    frames = max(len(path.positions) for _, path in parts)
    positions, travel = np.zeros((frames, count, 6)), np.zeros(count)
    force, gap = np.zeros((contacts.corner_count, 3)), np.zeros(contacts.corner_count)
    point, corner = contacts.point.copy(), contacts.point.copy()
    axes = contacts.frame[contacts.interface].copy()
    for blocks, path in parts:
        own = np.isin(contacts.block_a, blocks) & np.isin(contacts.block_b, blocks) & model.active
        corners, at = own[contacts.interface], path.model.active[path.model.contacts.interface]
        last = np.minimum(np.arange(frames), len(path.positions) - 1)
        positions[:, blocks], travel[blocks] = path.positions[last], path.travel
        force[corners], gap[corners] = path.force[at], path.gap[at]
        point[corners], corner[corners] = path.point[at], path.corner[at]
        axes[corners] = path.axes[at]
    longest = max((path for _, path in parts), key=lambda one: one.steps)
    whole = replace(
        longest, carrier=parts[0][1].carrier, model=model, positions=positions, travel=travel,
        force=force, point=point, corner=corner, axes=axes, gap=gap,
        share=max(path.share for _, path in parts),
        iterations=sum(path.iterations for _, path in parts),
        overlap=min(path.overlap for _, path in parts),
        beyond=max(path.beyond for _, path in parts),
    )  # fmt: skip
    return replace(whole, residuals=rest_residuals(whole))


def _on_faces(path: SettlementPath) -> bool:
    """Whether the vertices that met a face and press at the end are still on it."""
    contacts = path.model.contacts
    pressed = contacts.corners.any(np.asarray(path.force.any(axis=1)))
    points = [i for i in path.met if pressed[i] and len(contacts.polygon(i)) == 1]
    return not points or still_on_faces(path.model, path.displacement, path.point, points)


def _tries(case: FollowedCase) -> list[tuple[Carrier, bool]]:
    """The carriers, and whether there is another one after each."""
    carriers = carriers_of(case.model, case.chosen)
    return [(one, one is not carriers[-1]) for one in carriers]


def _begun(case: FollowedCase) -> list[_Run]:
    """The run with the first carrier; of few blocks that workers follow those with all."""
    clock, tries = case.clock, _tries(case)
    # of many blocks, the second run depends on the first one
    if clock.workers is not None and len(tries) > 1 and not case.many:
        with WorkerPool(clock.workers) as pool:
            if known := list(pool.answers(partial(_tried, case), tries, clock.late)):
                return known
    # also where the workers were ended early
    return [(*path_of(case, *tries[0], overlap=None, other=case.near), case.falls)]


def _paths(case: FollowedCase, known: list[_Run]) -> tuple[SettlementPath, ...]:
    """The paths of all carriers; those after one that is unknown are left out."""
    left_at, tries = case.left_at, _tries(case)
    paths: tuple[SettlementPath, ...] = ()
    for number, which in enumerate(tries):
        # of many blocks the forces are much the same for both carriers
        stiff = paths[-1].overlap if paths and left_at < np.inf else None
        asked = case
        if paths and case.many and case.motion is None and paths[-1].outcome is Outcome.FALLS:
            # farther than what stands, wherever it goes from there both carriers end alike
            asked = replace(case, left_at=min(left_at, case.chosen.rest_within))
        if number < len(known):
            path, last, falls = known[number]
            case.falls.update(falls)
        else:
            path, last = path_of(asked, *which, overlap=stiff, other=paths[-1])
        paths += (path,)
        if last or path.outcome is Outcome.UNKNOWN:
            break  # then the outcome is unknown, whatever the other one does
    if case.many and len(paths) == 2:
        first, second = paths
        rests = first.outcome is Outcome.FALLS and second.outcome is Outcome.RESTS
        if rests and second.overlap < first.overlap:
            # the springs of the first run were too soft as well
            path, _ = path_of(case, *tries[0], overlap=second.overlap, other=second)
            paths = path, second
    return paths


def _tried(case: FollowedCase, which: tuple[Carrier, bool]) -> _Run:
    """A run in a worker, and the course of what fell there, which its caller does not see."""
    return *path_of(case, *which), case.falls
