"""The verdict: does it stand by contact and friction alone, without prestress?

1. Nothing presses on some of its blocks: UNSTABLE. They fall.
2. Uniform contact springs hold it by friction, and it does not slide far: STABLE.
3. No contact forces balance the loads: UNSTABLE, with the mechanism.
4. Else its blocks are followed by finite steps. They rest: STABLE after settling. They fall:
   UNSTABLE. The ends of the joints decide, or nobody knows: UNDECIDED.

Joints that pull or cohere cannot be followed. There other contact stiffnesses are tried in place
of it, and a first motion on ground springs proves a fall. Other stiffnesses change no verdict of
dry joints: they are tried where it is asked whether it stands with each of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TypeAlias, Unpack

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.settings import Clock, checked_call
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, LongHow, supported_model
from drystone.joints import SWAY
from drystone.mechanics import law
from drystone.model import Model
from drystone.results import Result, Sensitivity, Verdict
from drystone.settlement import UNDECIDED, Carrier, Outcome, Settlement, SettlementOptions
from drystone.settlement.settling import said_longer, settle_for_verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.asked import SAMPLES, Asked, CheckOptions
from drystone.stability.attempts import Attempt, Candidate
from drystone.stability.problem import (
    NO_APPROACH,
    UNBALANCED,
    Problem,
    beside_supports,
    closing_blocks,
)
from drystone.stability.strength import with_brittle_mortar, within_strength
from drystone.stability.touching_edges import unless_more_holds

SLIDES_FAR = 20.0
"""Slide by overlap, in the rest state, from which on the blocks are followed. A slide changes the
friction on its way, and one so long occurs close to a limit. Measured on the published models: 24
or more where following shows a fall. Domes, vaults, walls and arches near their limits: 8 at most
if they do not slide as a whole. Without friction: 4 or more where following shows a fall, 0.002 at
most in walls."""

ROUNDS = 3
"""How often light blocks are given what they feel, by the forces found before. Measured: a boulder
on three pebbles of 3e-16 of its weight stands after the second time."""

FREELY = "nothing presses on the blocks that fall, so nothing holds them"

_Follow: TypeAlias = Callable[..., Settlement]


@checked_call
def check(
    given: Given,
    *,
    options: CheckOptions | None = None,
    start: Floats | None = None,
    **how: Unpack[LongHow],
) -> Result:
    """Does the assembly stand by contact and friction alone, without prestress?

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    options
    start : (n, 6) [m, rad]
        ``displacement`` of the result of a similar model with the same blocks. It saves time where
        the model stands, and does not change the verdict.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion that pass every check; UNSTABLE with a mechanism;
        UNDECIDED with a list of what was tried. ``samples`` has the number of assumed contact
        stiffnesses with a rest state.

    Raises
    ------
    InputError
        What was given cannot be made into a model, or the start has another shape.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import arch
    >>> drystone.check(arch(0.15), friction=0.9).verdict
    <Verdict.STABLE: 'stable'>
    """
    clock = Clock.of(how)
    problem = Problem.build(supported_model(given, **how))
    return decided(Asked(problem, CheckOptions.of(options), clock), near=start)


def decided(
    asked: Asked,
    *,
    near: Floats | None = None,
    rest: Candidate | None = None,
) -> Result:
    """The verdict, with its proof; no proof of falling rests on pairs that were not joined.

    Parameters
    ----------
    asked
    near : (n, 6) [m, rad]
        The rest state of a similar model with the same blocks.
    rest
        The rest state of this model with uniform stiffness, where it is known already.
    """
    problem, contacts = asked.problem, asked.problem.model.contacts
    if problem.model.assembly.fixed.all():
        return asked.nothing_free()
    if contacts.brittle or (contacts.crushes.any() and problem.statics.crushing is not None):

        def other(model: Model) -> Result:
            """The verdict on the same blocks with other capacities of joints."""
            part = Asked(Problem.build(model), asked.options, asked.clock)
            return decided(part, near=near)

        if contacts.brittle:
            return with_brittle_mortar(problem.model, other, asked.clock)
        return within_strength(problem, other, asked.clock, asked.options.settlement)

    def touching(model: Model, explains: bool = asked.explains) -> Result:
        """The verdict on the same blocks with more contacts."""
        more = Asked(Problem.build(model), asked.options, asked.clock, explains=explains)
        return decided(more)

    with WorkerPool(asked.clock.workers) as pool:
        found = _decided(asked, pool, near, rest)
    return unless_more_holds(found, touching, partial(touching, explains=False))


@one_blas_thread()
def _decided(asked: Asked, pool: WorkerPool, near: Floats | None, rest: Candidate | None) -> Result:
    freely = _free_fall(asked, FREELY) if _surely_free(asked.problem) else None
    if freely is not None:
        return freely
    asked.report("rest state", 0)
    uniform = _by_one_stiffness(asked, near, rest)
    seeks = uniform is None or not (uniform.stands or asked.clock.late())
    if seeks and asked.collapse is not None:
        return _falls(asked, asked.collapse, uniform)
    assert uniform is not None  # else there is a mechanism
    return (_held if uniform.stands else _not_held)(asked, pool, uniform)


def _by_one_stiffness(
    asked: Asked, near: Floats | None, found: Candidate | None
) -> Candidate | None:
    """Where uniform stiffness leads, if not found; None where a mechanism is known before."""
    problem = asked.problem
    if found is None and near is not None:
        found = asked.attempt().begun_at(near)
    if found is None:
        # where a known rest state leads nowhere a mechanism is likely, and is found soon
        first = asked.nearest is not None or (near is not None and problem.equilibrium_first)
        if first and asked.collapse is not None:
            return None
        found = asked.attempt().from_nothing(
            falls=lambda: asked.collapse is not None,
            # uniform springs say little of light blocks, which are followed by what they feel
            balance=None if asked.problem.has_light else lambda: asked.balance,
        )
    asked.count(found)
    return found


def _held(asked: Asked, pool: WorkerPool, uniform: Candidate) -> Result:
    """The verdict where uniform stiffness holds the blocks: what slides far is followed."""
    follows, late = asked.options.settle and asked.problem.statics.dry, asked.clock.late
    spread = _not_on_faces(asked, pool, uniform, follows)
    if late() or not (follows and _doubtful(asked, uniform)):
        words = _on_faces(asked, asked.stands(), spread if follows else None)
        return asked.stable(uniform, words)
    return _followed(asked, pool, uniform, spread)


def _not_on_faces(
    asked: Asked, pool: WorkerPool, uniform: Candidate, follows: bool
) -> Model | None:
    """Try other stiffnesses; the model with points on its faces, where its springs hold it not."""
    problem, options, late = asked.problem, asked.options, asked.clock.late
    spread: Model | None = None
    if problem.statics.dry and (options.samples or (options.settle and not options.uniform)):
        spread, *_ = asked.on_spread_points(uniform.force, problem.model) or (None,)
    if problem.statics.friction.any():  # without it forces balance for all (static theorem)
        count = max(options.samples - (spread is not None), int(follows))
        asked.try_others(pool, count, uniform)
    return None if spread is None or late() else asked.not_held(spread, uniform)


def _not_held(asked: Asked, pool: WorkerPool, uniform: Candidate) -> Result:
    """The verdict where it does not: others may hold them, and else they are followed."""
    problem, options = asked.problem, asked.options
    felt = _by_what_blocks_feel(asked, uniform)
    if felt is not None:
        if not problem.statics.friction.any():  # forces balance for all (static theorem)
            return asked.stable(felt)
        asked.depends_on(Sensitivity.WEIGHTS)
        softer = "stands where joints of light blocks are softer, by what these blocks feel"
        return asked.stable(felt, f"{softer}: {asked.sensitive}")
    if options.settle and problem.statics.dry and not options.uniform:
        return _followed(asked, pool, uniform, None)
    if not options.uniform:
        asked.try_others(pool, SAMPLES if options.settle else options.samples)
    others = [one for one in asked.tried if one.stands]
    return asked.stable(others[0]) if others else asked.first_motion(uniform)


def _falls(asked: Asked, collapse: Floats, uniform: Candidate | None = None) -> Result:
    """UNSTABLE where no forces balance the loads: freely where that is why, else as a mechanism."""
    before = _surely_free(asked.problem)  # then the others were found not to stand
    freely = None if before else _free_fall(asked, f"{FREELY}; {UNBALANCED}")
    return asked.unstable(UNBALANCED, collapse, uniform) if freely is None else freely


def _surely_free(problem: Problem) -> bool:
    """Whether nothing at all presses on some blocks that touch each other and supports only.

    Contact forces answer pressing. Blocks that the loads accelerate without approaching any
    corner feel none, at whatever friction: a block between two vertical walls falls, and so do
    several in a row, although forces that nothing provides could hold them. Of blocks that touch
    other free ones this is not known: those may settle against them.
    """
    falling, model = problem.unpressed, problem.model
    if not (falling.any() and beside_supports(model.assembly, model.contacts, falling)):
        return False
    return bool(problem.approaching_none(NO_APPROACH).all(where=falling))


def _free_fall(asked: Asked, words: str) -> Result | None:
    """UNSTABLE with the blocks on which nothing presses, where the others stand without them."""
    problem, falling = asked.problem, asked.problem.unpressed
    if not falling.any():
        return None
    others = problem.without(falling)
    if others is not None:
        part = decided(Asked(others, asked.options, asked.clock, explains=False))
        asked.steps += part.iterations
        if not part.stable:
            return None
    return asked.answer(
        Verdict.UNSTABLE,
        words,
        mechanism=problem.normalised(np.where(falling[:, None], problem.acceleration, 0.0)),
        prop=0.0 - np.where(falling[:, None], problem.model.load.wrench, 0.0),
        falling=tuple(int(i) for i in np.flatnonzero(falling)),
    )


def _doubtful(asked: Asked, rest: Candidate) -> bool:
    """Whether blocks that uniform stiffness holds must be followed.

    The springs with which they are followed do not hold them, or they slide far on those: without
    friction even a little, since the forces may be those of a chain stood on its head. Or hardly
    anything presses on some blocks at first, nor in the rest state. Of blocks beside supports the
    rest state does not count.
    """
    problem, model = asked.problem, asked.problem.model
    alike = asked.tried[1] if len(asked.tried) > 1 else rest
    far = SLIDES_FAR if problem.statics.friction.any() else 1.0 / SLIDES_FAR
    if not alike.stands or problem.slides_by_overlap(alike.displacement, far):
        return True
    falling = problem.unpressed
    if not falling.any() or beside_supports(model.assembly, model.contacts, falling):
        return bool(falling.any())
    closing = closing_blocks(model.assembly, model.contacts, rest.displacement)
    return not closing[falling].all()


def _on_faces(asked: Asked, words: str, spread: Model | None) -> str:
    """What stands on the corners of its joints, and what it does on points spread over the faces.

    Parameters
    ----------
    asked
    words
    spread
        The model with these points, where its springs do not hold it.
    """
    if spread is None or not asked.explains:
        return words
    found = settle_for_verdict(spread, options=asked.options.settlement, stop=asked.clock.late)
    asked.steps += found.iterations
    return f"{words}; with pressure spread over the faces {found.message}"


def _by_what_blocks_feel(asked: Asked, uniform: Candidate) -> Candidate | None:
    """A rest state where blocks feel little, or much more than their load, if there is one.

    Joints are then softer in proportion, or slip later. What a block feels is at first taken from
    any forces that balance the loads: on uniform springs heavy blocks that turn may throw it away.
    """
    force = _balance(asked, uniform)
    for _ in range(ROUNDS):
        problem = asked.problem.with_felt(force)
        if problem is None or asked.clock.late():
            break
        springs = law.uniform(problem.statics)
        found = Attempt(problem, springs, asked.clock.late).from_nothing()
        asked.steps += found.steps
        if found.stands:
            asked.tried = (found, *asked.tried[1:])
            return found
        force = found.force
    return None


def _balance(asked: Asked, uniform: Candidate) -> Floats:
    """Corner forces (k, 3) [N] that balance the loads, where there are some."""
    known = asked.balance
    return uniform.force if known is None else known


def _with_stiff_shear(
    asked: Asked, follow: _Follow, found: Settlement, options: SettlementOptions
) -> Settlement:
    """The same where the blocks end alike with stiffer joints along their faces; else both ways.

    The shear stiffness of joints is unknown as well. What is not followed to an end says nothing.
    """
    stiff = asked.options.stiff_shear
    ends = (Outcome.RESTS, Outcome.DISPLACED, Outcome.FALLS)
    rubs = bool(asked.problem.model.contacts.friction.any())
    if stiff is None or not rubs or found.outcome not in ends or asked.clock.late():
        return found
    other = follow(asked.problem.model, options=replace(options, tangential=stiff))
    alike = (other.outcome is Outcome.RESTS) == (found.outcome is Outcome.RESTS)
    if other.outcome is Outcome.UNKNOWN or (alike and other.outcome in ends):
        return found
    asked.depends_on(Sensitivity.SHEAR)
    ways = {options.tangential: found, stiff: other}
    said = [f"at {shear:g} of the normal one {one.message}" for shear, one in ways.items()]
    takes = "" if alike else _taken_to_stand(asked, follow, ways, options)
    return replace(
        found,
        outcome=Outcome.SHEAR_DECIDES,
        message=f"it depends on the shear stiffness of the joints: {'; '.join(said)}{takes}",
        paths=(*found.paths, *other.paths),
    )


def _with_longer_faces(
    asked: Asked, follow: _Follow, found: Settlement, options: SettlementOptions
) -> Settlement:
    """The same, saying how long faces have to be with stiffer joints along them too."""
    stiff = asked.options.stiff_shear
    told = said_longer(*found.paths)
    if stiff is not None and asked.explains and not asked.clock.late():
        carrier = next(one.carrier for one in found.paths if one.outcome is Outcome.RESTS)
        chosen = replace(options, tangential=stiff, carrier=carrier)
        other = follow(asked.problem.model, options=chosen)
        asked.steps += other.iterations
        if other.rests:
            told = said_longer(*found.paths, *other.paths)
        elif other.outcome is Outcome.FALLS:
            told = f"; with a shear stiffness of {stiff:g} of the normal one it falls there too"
    return replace(found, message=f"{found.message}{told}")


def _over_ends(
    asked: Asked, follow: _Follow, found: Settlement, options: SettlementOptions
) -> Settlement:
    """The same, saying how much longer faces would hold what falls over their ends."""
    if not any(one.outcome is Outcome.FALLS and one.beyond > 0.0 for one in found.paths):
        return found
    ways: list[Settlement] = []
    for shear in sorted({options.tangential, asked.options.stiff_shear or options.tangential}):
        chosen = replace(options, tangential=shear, carrier=Carrier.LONGER)
        ways.append(follow(asked.problem.model, options=chosen))
        asked.steps += ways[-1].iterations
        if not ways[-1].rests:
            return found
    told = said_longer(*(path for way in ways for path in way.paths))
    return replace(found, message=f"{found.message}{told}")


def _with_spread_points(asked: Asked, found: Settlement, options: SettlementOptions) -> Settlement:
    """The same, saying what blocks that rest otherwise do on points spread over the faces.

    Faces that may need their corners have points, those that do so only then as well; faces that
    have opened press where they touch. What is not followed to an end says nothing.
    """
    model, now = asked.problem.model, found
    opened = SWAY * np.cbrt(model.assembly.volume[model.assembly.free]).mean()
    while not asked.clock.late():
        path = next((one for one in now.paths if one.outcome is Outcome.RESTS), None)
        if path is None:
            break
        contacts = model.contacts
        gap, force = (one[: contacts.corner_count] for one in (path.gap, path.force))
        closed = contacts.corners.max(gap)[contacts.interface] < opened
        more = asked.on_spread_points(np.where(closed[:, None], force, 0.0), model)
        if more is None:
            break
        asked.depends_on(Sensitivity.PRESSURE)
        if now.outcome is not Outcome.RESTS or not asked.explains:
            break
        model, stays, pressed = more
        near = replace(path, model=model, force=np.concatenate([force[stays], pressed]))
        now = settle_for_verdict(model, options=options, stop=asked.clock.late, near=near)
        asked.steps += now.iterations
    if now.outcome in (Outcome.RESTS, Outcome.UNKNOWN, found.outcome):
        return found
    return replace(
        found, message=f"{found.message}; with pressure spread over the faces {now.message}"
    )


def _taken_to_stand(
    asked: Asked, follow: _Follow, ways: dict[float, Settlement], options: SettlementOptions
) -> str:
    """The shear stiffness from which they rest, and the friction with which they do so both ways.

    Each is the least of a few that were followed. How many are is chosen, and that the search ends
    after three times the Newton steps of the two motions.
    """
    if not asked.explains:
        return ""
    model, late = asked.problem.model, asked.clock.late
    left = 3 * sum(way.iterations for way in ways.values())

    def rests(shear: float, friction: float = 1.0) -> bool:
        rough = model.with_friction(friction * model.contacts.friction)
        chosen = replace(options, tangential=shear)
        found = follow(rough, options=chosen, falls=None)
        nonlocal left
        left -= found.iterations
        return found.rests

    moves, held = sorted(ways, key=lambda shear: ways[shear].rests)
    for _ in range(3):
        between = float(f"{0.5 * (held + moves):.2g}")
        held, moves = (between, moves) if rests(between) else (held, between)
    rougher = (x for x in (1.02, 1.05, 1.1, 1.2) if left > 0 and all(rests(one, x) for one in ways))
    least = next(rougher, None)
    more = "; up to 1.2 times the friction was not found to hold it both ways"
    if least is not None:
        more = f", and both ways with {least:g} times the friction"
    return "" if late() else f"; it would stand at {held:g} and not at {moves:g}{more}"


def _followed(asked: Asked, pool: WorkerPool, uniform: Candidate, spread: Model | None) -> Result:
    """The verdict of blocks that are followed by finite steps; ``spread`` as :func:`_on_faces`."""
    if asked.clock.late():
        return asked.no_answer()
    asked.report("settlement", 2)
    clock, options = asked.clock, asked.options.settlement
    hardly = asked.problem.unpressed.any()
    if hardly:  # a plug that hardly tapers presses more and more on a long way
        options = replace(options, fall=max(options.fall, SettlementOptions().fall))
    light, felt = asked.problem.has_light, None
    if light:
        felt = _balance(asked, uniform)
    model, workers = asked.problem.model, pool.executor
    follow = partial(settle_for_verdict, executor=workers, stop=clock.late, falls={})
    found = follow(model, options=options, felt=felt)
    if light and found.rests:
        felt = found.paths[-1].force[: model.contacts.corner_count]
    follow = partial(follow, felt=felt)
    certain = uniform.stands and not hardly and all(one.stands for one in asked.tried)
    if found.outcome is Outcome.ENDS_DECIDE:
        asked.depends_on(Sensitivity.ENDS)
        found = _with_longer_faces(asked, follow, found, options)
    elif not (certain and found.outcome is Outcome.RESTS):
        found = _with_stiff_shear(asked, follow, found, options)
        found = _over_ends(asked, follow, found, options)
    settles = hardly or not uniform.stands
    if settles:  # otherwise this was asked of the rest state
        found = _with_spread_points(asked, found, options)
    asked.steps += found.iterations
    if not uniform.stands:
        light &= uniform.falling is None
        asked.depends_on(Sensitivity.WEIGHTS if light else Sensitivity.JOINTS)
    held = _how_held(asked, uniform)
    words = f"{found.message}; {held}"
    doubted = f"{words}: {asked.sensitive}"
    if found.outcome is Outcome.RESTS:
        if settles:
            return asked.settles(found, doubted)
        if certain:  # that it slides far was the only doubt
            return asked.stable(uniform)
        return asked.stable(uniform, _on_faces(asked, doubted, spread), found)
    if found.outcome in (Outcome.UNKNOWN, *UNDECIDED):
        if clock.late():
            return asked.no_answer()
        return asked.answer(Verdict.UNDECIDED, doubted, settlement=found)
    return _fallen(asked, uniform, found, held)


def _how_held(asked: Asked, uniform: Candidate) -> str:
    """How stiffness holds what is followed, or does not."""
    stood, tried = sum(one.stands for one in asked.tried), len(asked.tried)
    if asked.problem.unpressed.any():
        return "hardly anything presses on some of its blocks at first"
    if not uniform.stands:
        would = "would not" if uniform.falling is not None else "was not found to"
        return f"uniform contact stiffness {would} hold it in place"
    if stood < tried:
        return f"{stood} of {tried} contact stiffnesses tried would hold it in place"
    if not asked.problem.statics.friction.any():
        return "forces balance the loads, but without friction nothing brings it back"
    return "it slides far where uniform contact stiffness holds it"


def _fallen(asked: Asked, uniform: Candidate, found: Settlement, held: str) -> Result:
    """UNSTABLE of blocks that were followed and fall."""
    words = f"{found.message}; {held}"
    if asked.problem.unpressed.any():
        words = f"{held}, and {found.message}"
        freely = None if uniform.stands else _free_fall(asked, words)
        if freely is not None:
            return replace(freely, settlement=found)
    elif not uniform.stands and asked.balances:
        reached = "forces could balance the loads, but the loads alone do not bring them about"
        words = f"{reached}; {found.message}; shims or prestress might hold it"
    motion = next(asked.first_motions(), None)
    if motion is None and not uniform.stands:
        motion = asked.smooth_motion()
    if motion is None:
        motion = asked.problem.normalised(found.displacement)
    return replace(asked.unstable(words, motion, uniform), settlement=found)
