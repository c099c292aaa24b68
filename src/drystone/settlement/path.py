"""One run of a model, with one carrier of the ends of joints, in metres and newtons.

A corner at an end where the faces of both blocks end flush goes with the block that carries it. The
two choices put the corner in places that differ by how far one face has slid over the other, along
the normal of the end. Where that is tiny while the corner presses, both choices lead to the same
motion: a wall that topples hinges on its edges, and hardly slides.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, Ints, lengths
from drystone.base.settings import Clock
from drystone.checks import FORCE_TOLERANCE
from drystone.contacts import Contacts
from drystone.geometry.frames import rotations
from drystone.loads import LoadCase
from drystone.loads.placing import filled
from drystone.mechanics.bodies import (
    LIGHT,
    BlockPositions,
    Bodies,
    build_bodies,
    farther_out,
    numbered_axes,
    numbered_forces,
    rotation_vectors,
)
from drystone.mechanics.corners import CARRIER, Carrier, as_turned, flush_ends, joint_ends
from drystone.mechanics.follow import Bounds, Course, Ended, Follower, Track
from drystone.mechanics.increments import FEW, travelled
from drystone.mechanics.meeting import Apart, followed_model, model_with_met
from drystone.mechanics.soft_springs import STIFFEST
from drystone.mechanics.vertices_met import ROWS
from drystone.model import Model
from drystone.settlement.settlement_types import (
    Outcome,
    SettlementOptions,
    SettlementPath,
    earlier_loads,
    rest_residuals,
)

ALIKE = 2e-4
"""Distance of the two places of a corner, by the mean size of a block, that decides nothing: as
long as an increment. Measured where both were followed: at most 1e-4 in 31 models whose two motions
were the same, 2e-3 or more in six wedges whose motions were not; there the larger of two components
was taken, here the length, up to 1.4 times as long."""


def ends_alike(
    assembly: Assembly,
    contacts: Contacts,
    gap: Floats,
    carrier: Carrier,
    bodies: Bodies,
    frames: tuple[BlockPositions, ...],
) -> bool:
    """Whether the other carrier would have led to the same motion.

    Parameters
    ----------
    assembly, contacts
        Whose blocks were followed.
    gap : (k, 2) [m]
        Distance of each corner from the faces of a and b at the beginning, along n.
    carrier
        With which they were followed.
    bodies
        The same, scaled.
    frames
        Their poses.
    """
    other = Carrier.RESTING if carrier is Carrier.MOVING else Carrier.MOVING
    ends = as_turned(joint_ends(assembly, contacts, other, gap), bodies.turned)
    change = bodies.ends.tangent - ends.tangent
    corner = np.flatnonzero(change.any(axis=(1, 2)))
    step = max(ROWS // max(len(corner), 1), 1)
    return all(
        _farthest(bodies, corner, change[corner], frames[at : at + step]) <= ALIKE
        for at in range(0, len(frames), step)
    )


def beyond_ends(bodies: Bodies, pose: BlockPositions, longer: bool) -> float:
    """How far corners that press have gone beyond the ends of faces, scaled.

    Of faces that are taken as longer than drawn, or of the others: by so much the face of the block
    that does not carry the corner has to be longer.
    """
    ends = bodies.ends
    which = (ends.reach > ends.drawn) == longer
    corner = np.flatnonzero(which.any(axis=1))
    local = _apart(bodies, corner, (pose,))[0]
    along = np.einsum("kij,kj->ki", ends.outward[corner], local[:, 1:]) * ends.sense[corner]
    counts = which[corner] & (local[:, :1] < bodies.overlap)
    return float(np.where(counts, along - ends.drawn[corner], 0.0).max(initial=0.0))


def _near(bodies: Bodies, track: Track, way: float) -> BlockPositions:
    """The last pose with no block farther from its first place than some way by its size."""
    free, first = bodies.free, track.frames[0]
    for pose in reversed(track.frames):
        gone = pose.place[free] - first.place[free]
        if travelled(gone, pose.turn[free], bodies.radius[free], bodies.size[free]).max() <= way:
            return pose
    return first


def _farthest(
    bodies: Bodies, corner: Ints, change: Floats, frames: tuple[BlockPositions, ...]
) -> float:
    """Largest distance of the two places of a corner that presses, in some poses."""
    local = _apart(bodies, corner, frames)
    moved = lengths((change @ local[..., 1:, None])[..., 0])
    return float(np.where(local[..., 0] < bodies.overlap, moved, 0.0).max(initial=0.0))


def _apart(bodies: Bodies, corner: Ints, frames: tuple[BlockPositions, ...]) -> Floats:
    """(s, c, 3) from the corner on a to that on b in the axes of a, in some poses."""
    place = np.stack([one.place for one in frames])
    turn = np.stack([one.turn for one in frames])
    a, b = bodies.block_a[corner], bodies.block_b[corner]
    turn_a = turn[:, a]
    apart = place[:, b] + (turn[:, b] @ bodies.arm_b[corner][:, :, None])[..., 0]
    apart -= place[:, a] + (turn_a @ bodies.arm_a[corner][:, :, None])[..., 0]
    return (bodies.frame[corner] @ (turn_a.swapaxes(2, 3) @ apart[..., None]))[..., 0]


STIFFER = 1e-2
"""Overlap of the next try by the last where springs are too soft."""
TOO_FAR, FIRMER = 0.005, 0.1
"""Of many blocks: displacement of a block relative to its size from which a rest state is checked
on stiffer springs, and their overlap by the usual one. Springs of 1e-6 alone move the Armadillo
vault by 1 % of a block at a friction of 0.29. On springs ten times as stiff it moves by 0.1 %, and
a block slides out."""
STIFF_STEPS = 1500
"""Increments on stiffer springs after which a verdict is undecided. The Armadillo vault rests after
200 at 21 degrees and after 1,050 at 21.5. On stiffer springs a block takes a hundred times
as many steps to leave."""


def support_motion(model: Model, motion: Mapping[int | str, Any] | None) -> Floats | None:
    """(n, 6) [m, rad] of the supports; None where none moves."""
    assembly, case = model.assembly, model.load
    if motion is not None:
        moved = (LoadCase.settlement(assembly, block, one) for block, one in motion.items())
        case = model.with_load(sum(moved, case)).load  # refused where it cannot be calculated with
    if case.motion is None:
        return None
    case.require_prescribed(assembly)
    return case.motion


@dataclass(frozen=True, eq=False)
class FollowedCase:
    """What is followed, with each carrier of the ends of joints.

    Attributes
    ----------
    model
    apart
        Faces that its blocks may meet.
    chosen, clock
    motion : (n, 6) [m, rad]
        Of the supports; None where they stay.
    left_at
        Displacement of a block relative to its size at which a run ends.
    felt : (k, 3) [N]
        Corner forces that its blocks may feel at rest, if they are known.
    falls
        The course of the first run that fell, by carrier: with another shear stiffness, if there
        was one.
    near
        Many blocks are followed from where this run of similar joints rests, and from the beginning
        only if they do not rest again.
    """

    model: Model
    apart: Apart
    chosen: SettlementOptions
    clock: Clock
    motion: Floats | None = None
    left_at: float = np.inf
    felt: Floats | None = None
    falls: dict[Carrier, Course] = field(default_factory=dict)
    near: SettlementPath | None = None

    @property
    def many(self) -> bool:
        """Whether it has many blocks."""
        return len(self.model.assembly.free) > FEW

    def follower(
        self,
        carrier: Carrier,
        overlap: float,
        tell: Callable[[float], None] | None = None,
        felt: Floats | None = None,
    ) -> Follower:
        """A run that has not begun; with the corner forces (k, 3) that blocks feel, if known."""
        chosen, (part, gap) = self.chosen, followed_model(self.model, self.apart)
        bodies = build_bodies(part, carrier, overlap=overlap, tangential=chosen.tangential, gap=gap)
        if felt is None and self.felt is not None:
            kept = self.felt[self.model.active[self.model.contacts.interface]]
            more = len(bodies.block_a) - len(kept)
            felt = np.concatenate([kept / bodies.force_unit, np.zeros((more, 3))])
        bodies = bodies if felt is None else bodies.with_felt(felt)
        bounds = Bounds(chosen.fall, chosen.pace, chosen.step_limit, self.left_at)
        known = self.falls.get(carrier, ())
        return Follower(bodies, bounds, stop=self.clock.late, tell=tell, known=known)


def carriers_of(model: Model, chosen: SettlementOptions) -> tuple[Carrier, ...]:
    """The carriers to follow: two if the ends of loaded joints allow both."""
    carrier = chosen.carrier or CARRIER[model.ends]
    if carrier is not None:
        return (carrier,)
    return (Carrier.MOVING, Carrier.RESTING) if _flush(model) else (Carrier.MOVING,)


@lru_cache(maxsize=2)
def _flush(model: Model) -> bool:
    """Asked of one model in each of its runs: of a vault of 97 blocks it takes 10 ms."""
    return flush_ends(model.assembly, model.contacts.select(model.active))


def path_of(
    case: FollowedCase,
    carrier: Carrier,
    first: bool,
    *,
    overlap: float | None = None,
    other: SettlementPath | None = None,
) -> tuple[SettlementPath, bool]:
    """One run, in physical numbers, and whether the other carrier need not be tried.

    ``first``: there is another one. ``other``: its run. Many blocks that rest with the other
    carrier are followed from there; only if they do not rest again, from the beginning.
    """
    motion, chosen = case.motion, case.chosen
    if other is not None and motion is None and case.many:
        again = _from_rest(case, carrier, other)
        if again is not None:
            return again, not first
    stage = f"following the blocks, ends carried by the {carrier.value} block"
    tell = case.clock.shares(stage)
    overlap = chosen.overlap if overlap is None else overlap
    far: tuple[Bodies, Track] | None = None
    felt: Floats | None = None
    almost: tuple[Bodies, Track] | None = None
    while True:
        follower = case.follower(carrier, overlap, lambda far: tell(far / chosen.fall), felt)
        if case.left_at < np.inf and overlap < chosen.overlap:
            follower.step_limit = min(chosen.step_limit, STIFF_STEPS)
        bodies = follower.bodies
        track = follower.run(
            None if motion is None else scaled_motion(bodies, motion),
            earlier_loads(bodies, chosen.loading),
        )
        if case.felt is not None and track.ended not in (Ended.RESTS, Ended.FALLS):
            case = replace(case, felt=None)
        elif track.ended is Ended.SOFT:
            overlap *= STIFFER
        elif motion is None and overlap == chosen.overlap and _moved_much(bodies, track):
            overlap *= FIRMER
        elif motion is None and far is None and _rests_far(bodies, track, chosen):
            far = bodies, track
            overlap *= STIFFER
        elif (
            felt is None
            and (left := _left_by_light_ones(case, carrier, bodies, track)) > FORCE_TOLERANCE
        ):
            felt = track.response.force
            almost = (bodies, track) if left < LIGHT else None
        else:
            break
    if far is not None and not _rests_nearer(track, far[1]):
        bodies, track = far
    if almost is not None and track.ended is not Ended.RESTS:
        bodies, track = almost  # neither shown to rest nor to fall
    if track.ended is Ended.FALLS:
        case.falls.setdefault(carrier, follower.course)
    case.clock.tell(stage, 100, 100)
    return _path_after(case, carrier, first, bodies, track)


def _left_by_light_ones(
    case: FollowedCase, carrier: Carrier, bodies: Bodies, track: Track
) -> float:
    """Share of what a block feels that is not carried where all but light blocks rest; else 0."""
    if track.ended is not Ended.RESTS or not bodies.with_felt(track.response.force).light:
        return 0.0
    path = _physical(case, carrier, bodies, track)
    return rest_residuals(path).largest


def _rests_far(bodies: Bodies, track: Track, chosen: SettlementOptions) -> bool:
    """Whether few blocks rest farther than what stands does, which their springs may have caused.

    A plug that hardly tapers presses with many times its weight, and moves far before its springs
    do. On stiffer springs it moves less in proportion.
    """
    few = len(bodies.free) <= FEW and bodies.overlap > STIFFEST
    return few and track.ended is Ended.RESTS and float(track.travel.max()) > chosen.rest_within


def _rests_nearer(track: Track, before: Track) -> bool:
    """Whether blocks rest after less than half of their way on softer springs."""
    return track.ended is Ended.RESTS and 2.0 * track.travel.max() < before.travel.max()


def _moved_much(bodies: Bodies, track: Track) -> bool:
    """Whether springs of many blocks may have moved them to where they rest."""
    many = len(bodies.free) > FEW and bodies.overlap > STIFFEST
    return many and track.ended is Ended.RESTS and float(track.travel.max()) > TOO_FAR


def _from_rest(
    case: FollowedCase, carrier: Carrier, other: SettlementPath
) -> SettlementPath | None:
    """The rest state with one carrier near that with the other; None where it is not found."""
    if other.outcome is not Outcome.RESTS or other.met:
        return None
    model, chosen = case.model, case.chosen
    follower = replace(case, left_at=chosen.rest_within).follower(carrier, other.overlap)
    bodies, moved = follower.bodies, other.positions[-1]
    pose = BlockPositions(
        bodies.centroid + moved[:, :3] / bodies.length_unit, rotations(moved[:, 3:])
    )
    kept = other.force[model.active[model.contacts.interface]]
    own = filled(kept / bodies.force_unit, len(bodies.block_a))
    friction = numbered_forces(bodies, own)[:, 1:]
    follower.begin_at(pose, friction)
    follower.step_limit = min(chosen.step_limit, STIFF_STEPS)
    track = follower.run()
    if track.ended is not Ended.RESTS:
        return None
    path, _ = _path_after(case, carrier, False, bodies, track)
    return path if path.outcome is Outcome.RESTS else None


def _path_after(
    case: FollowedCase, carrier: Carrier, first: bool, bodies: Bodies, track: Track
) -> tuple[SettlementPath, bool]:
    """A track in physical numbers, with its outcome.

    The other carrier need not be tried where the outcome is unknown, whatever it says, and where it
    would say the same.
    """
    path = _with_outcome(_physical(case, carrier, bodies, track), track, case)
    if path.outcome is Outcome.UNKNOWN or not first:
        return path, True
    if bodies.overlap < case.chosen.overlap and not case.many:
        return path, False  # on stiffer springs a smaller distance of the ends decides
    part, gap = followed_model(case.model, case.apart)
    return path, ends_alike(part.assembly, part.contacts, gap, carrier, bodies, track.frames)


def _with_outcome(path: SettlementPath, track: Track, case: FollowedCase) -> SettlementPath:
    chosen, moving = case.chosen, case.motion is not None
    travel = float(track.travel.max(initial=0.0))
    if track.ended is not Ended.RESTS:
        # out of steps: where a block is beyond what stands and still moves, it does not stand
        moved_on = not moving and not case.clock.reason and travel > chosen.rest_within
        return replace(path, outcome=Outcome.FALLS) if moved_on else path
    residuals = rest_residuals(path)
    if residuals.largest > FORCE_TOLERANCE:
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


def _physical(case: FollowedCase, carrier: Carrier, bodies: Bodies, track: Track) -> SettlementPath:
    """A track in m, rad and N, for all corners of the model and of the faces that were met."""
    joints = len(case.model.contacts)
    model, corners, kept = model_with_met(case.model, case.apart, track.met)
    contacts = model.contacts
    positions = block_motions(bodies, track.frames)
    force = np.zeros((contacts.corner_count, 3))
    force[corners] = numbered_forces(bodies, track.response.force)[kept] * bodies.force_unit
    point, axes = contacts.point.copy(), contacts.frame[contacts.interface].copy()
    gap = np.zeros(contacts.corner_count)
    origin = model.assembly.centroid[bodies.free].mean(axis=0) if len(bodies.free) else 0.0
    point[corners] = track.placed.point[kept] * bodies.length_unit + origin
    axes[corners] = numbered_axes(bodies, track.placed.axes)[kept]
    gap[corners] = track.placed.gap[kept] * bodies.length_unit
    out = np.einsum(
        "kij,kj->ki", contacts.frame[contacts.interface], farther_out(contacts, contacts.point)
    )
    corner = point.copy()
    corner[corners] -= bodies.length_unit * np.einsum("ki,kij->kj", out, axes)[corners]
    travel = np.zeros(len(model.assembly))
    travel[bodies.free] = track.travel
    rests = track.ended is Ended.RESTS
    pose = track.frames[-1] if rests else _near(bodies, track, case.chosen.rest_within)
    return SettlementPath(
        carrier,
        Outcome.FALLS if track.ended is Ended.FALLS else Outcome.UNKNOWN,
        model,
        positions,
        travel,
        force,
        point,
        corner,
        axes,
        gap,
        None,
        track.share,
        track.steps,
        track.iterations,
        tuple(range(joints, len(model.contacts))),
        bodies.overlap,
        beyond_ends(bodies, pose, longer=rests) * bodies.length_unit,
        case.chosen.tangential,
    )


def block_motions(bodies: Bodies, poses: tuple[BlockPositions, ...]) -> Floats:
    """(s, n, 6) [m, rad] from the beginning."""
    gone = (np.stack([pose.place for pose in poses]) - bodies.centroid) * bodies.length_unit
    turn = np.concatenate([pose.turn for pose in poses])
    return np.concatenate([gone, rotation_vectors(turn).reshape(gone.shape)], axis=2)
