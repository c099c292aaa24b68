"""Whether joints crush, of what stands without a limit of strength; and mortar that breaks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import ROUNDING, Bools, Floats, lengths
from drystone.base.display import rounded_down
from drystone.base.errors import counted
from drystone.base.settings import Clock, Stop
from drystone.checks import (
    FORCE_TOLERANCE,
    Residuals,
    check_forces,
    crushed_most,
    crushing_share,
    normal_force_by_strength,
)
from drystone.contacts import Contacts
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import LoadFactors
from drystone.joint_capacity import NO_LIMIT, JointCapacity
from drystone.joints import linear_strength_use, plane_pressure
from drystone.mechanics import law
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.settlement import Outcome, SettlementOptions
from drystone.settlement.settling import settle_for_verdict
from drystone.solvers.program import ConicStatus
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Attempt, Candidate
from drystone.stability.problem import UNBALANCED, Problem, checked_mechanism, moving_blocks, undone
from drystone.ties import joint_words
from drystone.virtual import joint_sections

WEAK = "no contact forces within the strength of"
_REACHED = 0.999
"""Share of its strength from which a joint reaches it: forces are asked for that carry a thousandth
more than all loads, so that they use less where they can."""


@dataclass(frozen=True, eq=False)
class Carried:
    """The largest share of the loads that forces within the strength balance.

    Attributes
    ----------
    share
        1 at most.
    force : (k, 3) [N]
        That balance all of them, where they do.
    residuals
        Of these forces.
    mechanism : (n, 6)
        The proof that none do, where it is one.
    iterations
    """

    share: float
    force: Floats | None
    residuals: Residuals
    mechanism: Floats | None
    iterations: int


def carried(
    problem: Problem,
    cone: FrictionCone,
    late: Callable[[], bool],
    whether: bool = False,
    rubs: Floats | None = None,
) -> Carried:
    """What share of its loads a model carries whose joints crush.

    With ``whether`` a share below 1 may be too small, by half of what it is below 1. With ``rubs``
    (k,), the friction of corners by the unit of force, joints rub no more than that in all; less
    than all loads proves nothing then.
    """
    statics = problem.statics
    none = replace(statics, load=np.zeros_like(statics.load))
    found = LoadFactors(none, cone, enough=1.0, whether=whether, rubs=rubs)(statics.load, late)
    share, state = found.factor, found.state
    steps = state.raw.iterations
    if state.raw.status is ConicStatus.SOLVED and share >= 1.0:  # all sets are convex, with zero
        force = problem.force(state.force / share)
        pull = None if state.pull is None else problem.force(state.pull[:, None] / share)
        return Carried(1.0, force, check_forces(problem.model, force, pull=pull), None, steps)
    proof = checked_mechanism(problem, state) if rubs is None else None
    if whether and rubs is None and proof is None and share < 1.0 and not late():
        return carried(problem, cone, late)
    return Carried(min(share, 1.0), None, Residuals(), proof, steps)


def crushing_factor(model: Model, *, stop: Stop | None = None) -> float | None:
    """The factor on all loads up to which forces within the strength of the joints balance them.

    Parameters
    ----------
    model
    stop

    Returns
    -------
    float or None
        None where no joint crushes, of more than 150 blocks, as for the margin of tilt, and where
        it was not found.
    """
    if len(model) > 150 or not model.contacts.crushes.any():
        return None
    statics = Problem.build(model).statics
    none = replace(statics, load=np.zeros_like(statics.load))
    found = LoadFactors(none, FrictionCone.exact())(statics.load, stop).factor
    return found if 0.0 < found < np.inf else None


def crushing_words(model: Model, share: float | None, motion: Floats) -> str:
    """How much of the loads is carried, if known, why no more, and the joint that crushes most.

    What falls with nothing crushed slides or turns. What crushing resists less
    than weights do is not said to crush.
    """
    crushes = model.contacts.crushes
    stone, at = (crushes & ~model.contacts.ties).any(), crushed_most(model, motion)
    bare = (crushes & (model.contacts.area == 0.0)).any()
    edges = "; edges and corners have no area and carry nothing" if bare else ""
    if at is None:
        return f"{UNBALANCED}; no {'joint crushes' if stone else 'tie yields'}{edges}"
    words = f"{WEAK} its {'joints' if stone else 'ties'} balance the loads"
    words += "" if share is None else f", only {rounded_down(share, 3):g} of them, the weight too"
    words += edges
    _, which, fails = joint_words(model.assembly, model.contacts, at)
    if crushing_share(model, motion) > 0.5:
        words = f"{'it crushes' if fails == 'crushes' else 'ties yield'}: {words}"
    return f"{words}; the {which} {fails} most"


@one_blas_thread()
def within_strength(
    problem: Problem,
    decide: Callable[[Model], Result],
    clock: Clock,
    settlement: SettlementOptions,
) -> Result:
    """The verdict of a model whose joints crush.

    Without the limits of strength it must not fall. If it stands with the forces found there within
    them, it stands. Otherwise other forces are asked for, as crushing lets them move (it is
    ductile): none prove that it falls. Where some exist, friction may jam in them what the loads do
    not. So it stands with those alone that rub no more than uniform springs press for, or not at
    all (Drucker 1954: then friction does not throw it over). Else what has ties is followed by
    finite steps, and what has none is undecided.

    Parameters
    ----------
    problem
    decide
        Gives the verdict on a model without limits of strength.
    clock
    settlement
        How blocks are followed.
    """
    model = problem.model
    found = decide(model.without_crushing())
    crushes = found.model.with_contacts(model.contacts.carried_to(found.contacts))
    found = replace(found, model=crushes, message=_with_what_was_tried(found))
    if found.falls:
        return found
    if found.force is not None:
        residuals = check_forces(crushes, found.force, found.displacement)
        if residuals.crushing <= FORCE_TOLERANCE:
            return replace(found, residuals=residuals)
    most = carried(problem, FrictionCone.exact(), clock.late)
    found = replace(found, iterations=found.iterations + most.iterations)
    if most.mechanism is not None:
        return replace(
            undone(found, crushing_words(crushes, most.share, most.mechanism)),
            verdict=Verdict.UNSTABLE,
            mechanism=most.mechanism,
            falling=moving_blocks(model.assembly, most.mechanism),
        )
    if not found.stable:
        return found
    if most.force is None or most.residuals.largest > FORCE_TOLERANCE:
        words = ["no forces within the strength of its joints were found", clock.reason]
        return replace(undone(found, "; ".join(filter(None, words))), stopped=clock.reason)
    kept = replace(
        found, model=model, force=most.force, displacement=None, residuals=most.residuals
    )
    return _where_it_yields(found, kept, problem, clock, settlement)


def _with_what_was_tried(found: Result) -> str:
    """The words of a verdict without limits of strength, that tell so where stiffnesses count."""
    counts = found.stable and (found.sensitive or found.options.samples)
    return f"{found.message} without a limit of strength, one within" if counts else found.message


def _where_it_yields(
    found: Result, kept: Result, problem: Problem, clock: Clock, settlement: SettlementOptions
) -> Result:
    """The verdict where forces within the strength exist, but not those that were found without.

    Parameters
    ----------
    found
        STABLE without limits of strength.
    kept
        The same, with forces within the strength.
    problem, clock, settlement
        As in :func:`within_strength`.
    """
    model, ties, steps = problem.model, problem.model.contacts.ties, found.iterations
    stone = bool((model.contacts.crushes & ~ties).any())
    why = "of the forces that uniform springs bring about none were found within it"
    if found.sensitive and stone:
        why = found.message
    for forces in _brought_about(model, found.sensitive and stone, clock):
        steps += forces.iterations
        if forces.force is not None and forces.residuals.largest <= FORCE_TOLERANCE:
            told = replace(kept, force=forces.force, residuals=forces.residuals)
            words = f"{found.message}{_reached(told if stone else kept)}"  # ties may yield early
            return replace(told, message=words, iterations=steps)
    less, path = _with_stone_of_any_strength(model), None
    if less.contacts.crushes.any() and (less.contacts.plain | ties).all():
        path = settle_for_verdict(less, options=settlement, stop=clock.late)
        steps += path.iterations
        if path.rests and not stone:
            words = f"{path.message}; ties yield"
            return replace(kept, message=words, settlement=path, iterations=steps)
        why = path.message
    found = replace(found, iterations=steps)
    if path is None or path.outcome is not Outcome.FALLS:
        words = (
            "forces within the strength of its joints balance the loads, but whether crushing "
            f"brings them about is not known: {why}"
        )
        return replace(undone(found, words), settlement=path, stopped=clock.reason)
    motion = problem.normalised(path.displacement)
    return replace(
        undone(found, f"ties yield, and {path.message}"),
        verdict=Verdict.UNSTABLE,
        mechanism=motion,
        falling=moving_blocks(model.assembly, motion),
        settlement=path,
    )


def _brought_about(model: Model, sensitive: bool, clock: Clock) -> Iterator[Carried]:
    """Forces that loads may bring about, which crushing lets move but friction does not jam.

    First those of uniform springs, of which ties pull by their strength at most. Where stone
    crushes, those within the strength as these springs press: measured on 107 models at their
    limits, with 1 % more strength all have elastic-plastic forces as well, whose joints rub no more
    than they press. Then as springs press whose faces are so small that their stress blocks
    suffice: rings that are not bonded need it. (On faces between these columns that lean on others
    stood at 17 % less strength.) At last those without any friction; only these where it is
    ``sensitive``, as springs say nothing then.
    """
    contacts, size = model.contacts, np.full(model.contacts.count, 0.0 if sensitive else 1.0)
    stone = bool((contacts.crushes & ~contacts.ties).any())
    most = contacts.tie_strength[contacts.interface] * contacts.corner_share
    while size.min(initial=1.0) > 0.0 and not clock.late():
        problem = Problem.build(model.with_contacts(_on_parts(contacts, size)).without_crushing())
        yields = most[problem.corners] / problem.statics.force_unit
        springs = replace(law.uniform(problem.statics), most=yields)
        state = Attempt(problem, springs, clock.late).from_nothing()
        force = _on_whole_faces(contacts, state.force, size)
        first = size.min(initial=1.0) == 1.0
        told = force if state.stands and first else None
        yield Carried(1.0, told, check_forces(model, force), None, state.steps)
        use = normal_force_by_strength(contacts, np.maximum(force[:, 0], 0.0))[0]
        within = use.max(where=~contacts.ties, initial=0.0) <= 1.0
        if state.stands and stone and (first or within):
            yield _as_pressed(model, force, clock)
        if within or not state.stands:
            break
        size = _smaller(contacts, force, use, size)
    if stone:
        yield _as_pressed(model, None, clock)


def _as_pressed(model: Model, force: Floats | None, clock: Clock) -> Carried:
    """Forces within the strength, of joints that others (k, 3) [N] press; of any without friction.

    None of these joints rubs more than it does with either.
    """
    contacts, whole = model.contacts, Problem.build(model)
    statics, corners = whole.statics, whole.corners
    normal, bears = np.zeros(statics.corner_count), np.ones(contacts.count, dtype=bool)
    if force is not None:
        normal = force[corners, 0] / statics.force_unit
        pressed = np.abs(normal) > ROUNDING * statics.corner_load
        bears = np.isin(np.arange(contacts.count), contacts.interface[corners][pressed])
    stays = bears[contacts.interface]
    rubs = law.uniform(statics).friction.bound(np.maximum(normal, 0.0))[stays[corners]]
    part = Problem.build(model.with_contacts(contacts.select(bears)))
    found = carried(part, FrictionCone.exact(), clock.late, whether=True, rubs=rubs)
    if found.force is None:
        return found
    every = np.zeros((len(stays), 3))
    every[stays] = found.force
    return replace(found, force=every)


def _with_stone_of_any_strength(model: Model) -> Model:
    """The model whose ties alone have a strength."""
    contacts, capacity = model.contacts, model.contacts.capacity
    if capacity is None or not contacts.ties.any():
        return model.without_crushing()
    strength = np.where(contacts.ties, capacity.compression, NO_LIMIT)
    return model.with_capacity(replace(capacity, compression=strength))


def _on_whole_faces(contacts: Contacts, force: Floats, size: Floats) -> Floats:
    """Forces (k, 3) [N] at corners of whole faces that are those on shares (m,) of their size."""
    share = size[contacts.interface, None]
    whole = contacts.corners.spread(contacts.corners.sum(force))
    return share * force + (1.0 - share) * contacts.corner_share[:, None] * whole


def _on_parts(contacts: Contacts, size: Floats) -> Contacts:
    """The interfaces on faces of shares (m,) of their size, about their centroids."""
    shrunk = (size < 1.0)[contacts.interface]
    share, centre = size[contacts.interface, None], contacts.centroid[contacts.interface]
    point = np.where(shrunk[:, None], centre + share * (contacts.point - centre), contacts.point)
    return contacts.with_areas(contacts.area * size**2, point=point)


def _reached(found: Result) -> str:
    """Whether what stands reaches the strength of its joints, said after why it stands."""
    stone = (found.contacts.crushes & ~found.contacts.ties).any()
    if found.strength_use.max(initial=0.0) < _REACHED:
        return f", also within the strength of its {'joints' if stone else 'ties'}"
    words = "the stone reaches its strength where its joints press most"
    return f"; {words if stone else 'ties yield'}"


@one_blas_thread()
def with_brittle_mortar(model: Model, decide: Callable[[Model], Result], clock: Clock) -> Result:
    """The verdict of a model whose joints lose their pull and cohesion where they crack.

    What stands with every joint cracked stands. Otherwise forces are found on uniform springs that
    pull as well as they press, as of mortar that is not cracked; a joint in whose face a linear
    pressure exceeds the pull, or the shear exceeds cohesion and friction, cracks; and again without
    it, until none cracks. Where what is left has no rest state, it must fall even if the joints
    left were ductile.

    Where joints crush as well, the linear pressure of those that hold is below the strength, and
    those that cracked carry stress blocks. What presses more is lost: a joint that holds cracks,
    the face of another one shrinks, and forces are found again. So it stands with less than there
    is. That it falls is shown of what cracks before anything is lost.

    Parameters
    ----------
    model
    decide
        Gives the verdict on a model with joints cracked, or with ductile ones.
    clock
    """
    found = decide(model.cracked())
    if found.stable:
        contacts = model.contacts.carried_to(found.contacts)
        words = f"{found.message}, with every joint of mortar cracked"
        return replace(found, model=found.model.with_contacts(contacts), message=words)
    contacts, capacity = model.contacts, model.contacts.capacity
    if capacity is None:
        return found
    mortar = (capacity.tension > 0.0) | (capacity.cohesion > 0.0)
    end = _cracked_in_turn(model, mortar, clock)
    steps = found.iterations + end.steps
    found = replace(found, model=model, iterations=steps)
    if end.force is not None:
        return _uncracked(found, end.force, end.holds, mortar)
    if clock.late():
        words = f"{clock.reason} before it was known which joints of mortar crack"
        return undone(replace(found, stopped=clock.reason), words)
    ductile = model.with_capacity(replace(capacity.cracked(~end.sound), brittle=False))
    rest = decide(ductile) if end.sound.any() else found
    count = int((mortar & ~end.sound).sum())
    words = f"its mortar cracks in {counted(count, 'joint')}, and " if count else ""
    if rest.falls:
        words += f"what is left falls: {rest.message}" if count else rest.message
        return replace(rest, model=model, message=words, iterations=steps)
    words += "whether what is left falls was not shown"
    if contacts.crushes.any():
        words += (
            "; stone reaches its strength in some joint (ductile mortar tells a bound from above)"
        )
    return undone(found, words)


class _Followed(NamedTuple):
    """How far joints crack: those that hold (m,), also before strength was lost, and the steps.

    With forces (k, 3) [N] that the joints carry, where they were found.
    """

    holds: Bools
    sound: Bools
    steps: int
    force: Floats | None = None


def _cracked_in_turn(model: Model, mortar: Bools, clock: Clock) -> _Followed:
    """Joints of mortar (m,) crack until none does, and what crushes too much is lost."""
    contacts, holds, steps = model.contacts, mortar, 0
    size = np.ones(len(mortar))
    sound: Bools | None = None
    while holds.any() and size.min() > 0.0 and not clock.late():
        state = _elastic(model, holds, size, clock)
        steps += state.steps
        if not state.stands:
            break
        breaking = holds & cracks(contacts, state.force)
        use = _strength_use(contacts, state.force, holds)
        if breaking.any():
            holds = holds & ~breaking
        elif use.max() <= 1.0:
            return _Followed(holds, holds, steps, state.force)
        else:
            sound = holds if sound is None else sound
            size = np.where(holds, 1.0, _smaller(contacts, state.force, use, size))
            holds = holds & (use <= 1.0)
    return _Followed(holds, holds if sound is None else sound, steps)


def _elastic(model: Model, holds: Bools, size: Floats, clock: Clock) -> Candidate:
    """The state on uniform springs that pull where joints hold, on shares of the size of faces.

    Its forces (k, 3) [N] are those at the corners of the whole faces.
    """
    contacts = _bonded(model, holds).without_crushing().contacts
    problem = Problem.build(model.with_contacts(_on_parts(contacts, size)))
    state = Attempt(problem, law.uniform(problem.statics), clock.late).from_nothing()
    return replace(state, force=_on_whole_faces(contacts, state.force, size))


def _bonded(model: Model, holds: Bools) -> Model:
    """The model whose joints pull and do not crush where they hold, and neither pull elsewhere."""
    capacity = model.contacts.capacity or JointCapacity.dry(len(holds))
    bonded = np.where(holds, NO_LIMIT, 0.0)
    strength = np.where(holds, NO_LIMIT, capacity.compression)
    pulls = replace(capacity, tension=bonded, cohesion=bonded, compression=strength)
    return model.with_capacity(pulls)


def _strength_use(contacts: Contacts, force: Floats, holds: Bools) -> Floats:
    """Share (m,) of its strength that each joint needs: by a linear pressure where it holds."""
    use = normal_force_by_strength(contacts, np.maximum(force[:, 0], 0.0))[0]
    return np.where(holds, linear_strength_use(contacts, force), use)


def _smaller(contacts: Contacts, force: Floats, use: Floats, size: Floats) -> Floats:
    """Shares (m,) of the size of faces on whose rim stress blocks carry what presses too much.

    Of a face under N, bent about one axis, it is ``1 - N / (f A)``; a little less, so that it ends.
    """
    strength = np.inf if contacts.capacity is None else contacts.capacity.compression
    lost = np.maximum(contacts.corners.sum(force[:, 0]) / strength, (1.0 - size) * use)
    return np.where(use > 1.0, 1.0 - 1.01 * lost, size)


def _uncracked(found: Result, force: Floats, holds: Bools, mortar: Bools) -> Result:
    """STABLE with forces (k, 3) [N] that joints which hold carry elastically, others as dry."""
    residuals = check_forces(_bonded(found.model, holds), force)
    cracked = int((mortar & ~holds).sum())
    told = f"{counted(cracked, 'joint')} of it cracked" if cracked else "uncracked"
    if residuals.largest > FORCE_TOLERANCE:
        return undone(found, f"its mortar holds ({told}), but no exact forces were found")
    words = f"stands on its mortar, {told}"
    stands = replace(undone(found, words), verdict=Verdict.STABLE)
    return replace(stands, force=force, residuals=residuals)


def cracks(contacts: Contacts, force: Floats) -> Bools:
    """Interfaces (m,) whose mortar corner forces (k, 3) [N], local n, u, v, exceed.

    The pressure is linear over the face, as of a plane section, and pulls as well, up to the
    tension and to cohesion by friction; the shear is even, torsion adds to it by the distance from
    the centroid, and friction is that of the mean pressure. Edges and points carry at corners.
    """
    capacity = contacts.capacity
    if capacity is None:
        return np.zeros(contacts.count, dtype=bool)
    corners, owner = contacts.corners, contacts.interface
    _, flat, made = joint_sections(contacts)
    face = (contacts.area > 0.0) & (corners.counts > 2)
    area = np.where(face, made.area, 1.0)
    arm = flat - made.centroid[owner]
    total = corners.sum(force) / area[:, None]
    torque = corners.sum(arm[:, 0] * force[:, 2] - arm[:, 1] * force[:, 1]) / area
    polar = np.where(face, np.trace(made.inertia, axis1=1, axis2=2), 1.0)
    turned = np.stack([-arm[:, 1], arm[:, 0]], axis=1) * (torque / polar)[owner, None]
    inside = face[owner]
    pressure = np.where(inside, plane_pressure(contacts, force), force[:, 0])
    shear = np.where(inside, lengths(total[owner, 1:] + turned), lengths(force[:, 1:]))
    pull, cohesion, _ = contacts.corner_capacity
    friction = contacts.friction
    slides = np.divide(
        capacity.cohesion, friction, out=np.full(len(area), np.inf), where=friction > 0
    )
    most = np.where(inside, (np.minimum(capacity.tension, slides) / area)[owner], pull)
    holds = np.where(inside, (capacity.cohesion / area + friction * total[:, 0])[owner],
                     cohesion + friction[owner] * force[:, 0])  # fmt: skip
    over = (-pressure > most * (1.0 + 1e-9)) | (shear > np.maximum(holds, 0.0) * (1.0 + 1e-9))
    unlimited = (capacity.tension >= NO_LIMIT) & (capacity.cohesion >= NO_LIMIT)
    return corners.any(over) & ~unlimited
