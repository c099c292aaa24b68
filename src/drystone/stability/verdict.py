"""The verdict: does it stand by contact and friction alone, without prestress?

1. Nothing presses on some of its blocks: UNSTABLE. They fall.
2. Uniform contact springs hold it, and it does not slide far: STABLE.
3. No contact forces balance the loads: UNSTABLE, with the mechanism.
4. Else its blocks are followed by finite steps. They rest: STABLE after settling. They fall:
   UNSTABLE. The ends of the joints decide, or nobody knows: UNDECIDED.

Joints that pull or cohere cannot be followed. There other contact stiffnesses are tried in place
of it, and a first motion on ground springs proves a fall. Other stiffnesses change no verdict of
dry joints: they are tried where it is asked whether it stands with each of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import DrystoneError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import solve_equilibrium
from drystone.formulations.nearest_mechanism import (
    NearestMechanism,
    nearest_mechanism,
    nearest_mechanisms,
)
from drystone.io.opening import Given, How, supported_model
from drystone.mechanics import law
from drystone.mechanics.law import Compliance
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.settlement import Outcome, Settlement, SettlementOptions
from drystone.settlement.settling import settle_for_verdict
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Attempt, Candidate
from drystone.stability.check_options import SAMPLES, CheckOptions
from drystone.stability.free_fall import (
    NO_APPROACH,
    beside_supports,
    closing_blocks,
    unpressed,
)
from drystone.stability.near_pairs import unless_near_pairs_hold
from drystone.stability.problem import Problem
from drystone.stability.programs.rbe import ANY_FORCES
from drystone.stability.proofs import (
    FALLING_SHARE,
    balanced,
    first_motion,
    found_mechanism,
    moving_blocks,
    sound_mechanism,
)

SLIDES_FAR = 20.0
"""Slide by overlap, in the rest state, from which on the blocks are followed. A slide changes the
friction on its way, and one so long occurs close to a limit. Measured on the published models: 24
or more where following shows a fall. Domes, vaults, walls and arches near their limits: 8 at most
if they do not slide as a whole."""

ROUNDS = 3
"""How often light blocks are given what they feel, by the forces found before. Measured: a boulder
on three pebbles of 3e-16 of its weight stands after the second time."""

SENSITIVE = "sensitive to how the joints press"
UNBALANCED = "no contact forces can balance the loads"


@checked_call
def check(
    given: Given,
    *,
    options: CheckOptions | None = None,
    start: Floats | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
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
    problem = Problem.build(supported_model(given, **how))
    asked = Asked(problem, CheckOptions.of(options), Clock(time_limit_s, stop), progress)
    return decided(asked, executor, near=start)


def check_problem(
    problem: Problem,
    *,
    options: CheckOptions,
    near: Floats | None = None,
    rest: Candidate | None = None,
    executor: Workers | None = None,
    stop: Stop | None = None,
) -> Result:
    """As :func:`drystone.check` of a problem that was built, for plans and limits.

    Parameters
    ----------
    problem, options
    near : (n, 6) [m, rad]
        The rest state of a similar model with the same blocks.
    rest
        The rest state of this model with uniform stiffness, where it is known already.
    executor, stop
    """
    asked = Asked(problem, options, Clock(float("inf"), stop))
    return decided(asked, executor, near=near, rest=rest)


@one_blas_thread()
def check_side_by_side(
    models: Sequence[Model], options: CheckOptions
) -> list[Result | DrystoneError]:
    """The result of :func:`drystone.check` of each model, or why it has none.

    Of small models with dry joints the mechanisms are looked for together, before all else.
    """
    clock = Clock(float("inf"))
    problems: list[Problem | DrystoneError] = []
    for model in models:
        try:
            problems.append(Problem.build(model))
        except DrystoneError as error:
            problems.append(error)
    first = [one for one in problems if isinstance(one, Problem) and one.equilibrium_first]
    known = nearest_mechanisms([one.system for one in first]) if first else []
    nearest = dict(zip(first, known, strict=True))
    shared_s = clock.elapsed_s / max(len(models), 1)
    found: list[Result | DrystoneError] = []
    for problem in problems:
        if isinstance(problem, Problem):
            own = Clock(float("inf"))
            own.began -= shared_s
            asked = Asked(problem, options, own, None, nearest.get(problem))
            found.append(decided(asked))
        else:
            found.append(problem)
    return found


def decided(
    asked: Asked,
    executor: Workers | None = None,
    *,
    near: Floats | None = None,
    rest: Candidate | None = None,
) -> Result:
    """The verdict, with its proof; no proof of falling rests on pairs that were not joined.

    Parameters
    ----------
    asked, executor
    near : (n, 6) [m, rad]
        The rest state of a similar model with the same blocks.
    rest
        The rest state of this model with uniform stiffness, where it is known already.
    """
    if asked.problem.statics.free_count == 0:
        return asked.nothing_free()

    def touching(model: Model) -> Result:
        """The verdict on the same blocks with more contacts."""
        more = Asked(Problem.build(model), asked.options, asked.clock)
        return decided(more, executor)

    with WorkerPool(executor) as pool:
        found = _decided(asked, pool, near, rest)
    return unless_near_pairs_hold(found, touching)


@one_blas_thread()
def _decided(asked: Asked, pool: WorkerPool, near: Floats | None, rest: Candidate | None) -> Result:
    problem, options, late = asked.problem, asked.options, asked.clock.late
    freely = _free_fall(asked)
    if freely is not None:
        return freely
    asked.report("rest state", 0)
    uniform = rest
    if uniform is None and near is not None and problem.statics.dry:
        uniform = asked.attempt().begun_at(near)
    if uniform is None:
        # where a known rest state leads nowhere a mechanism is likely, and is found soon
        first = asked.nearest is not None or (near is not None and problem.equilibrium_first)
        if first and asked.collapse is not None:
            return asked.unstable(UNBALANCED, asked.collapse)
        uniform = asked.attempt().from_nothing(falls=lambda: asked.collapse is not None)
    asked.count(uniform)
    if not uniform.stands and not late() and asked.collapse is not None:
        return asked.unstable(UNBALANCED, asked.collapse, uniform)
    felt = None if uniform.stands else _by_what_blocks_feel(asked, uniform)
    if felt is not None:
        return asked.stable(felt)
    follows = options.settle and problem.statics.dry
    if uniform.stands:
        if problem.statics.friction.any():  # without it equilibrium decides (static theorem)
            asked.try_others(pool, max(options.samples, int(follows)), uniform)
        if late() or not (follows and _doubtful(asked, uniform)):
            return asked.stable(uniform)
    elif options.uniform or not follows:
        if not options.uniform:
            asked.try_others(pool, SAMPLES if options.settle else options.samples)
        others = [one for one in asked.tried if one.stands]
        return asked.stable(others[0]) if others else asked.first_motion(uniform)
    return asked.no_answer() if late() else _followed(asked, pool, uniform)


def _free_fall(asked: Asked) -> Result | None:
    """UNSTABLE when the loads press some blocks against nothing and the others stand.

    Contact forces answer pressing. Blocks that the loads accelerate without approaching any
    corner feel none, at whatever friction: a block between two vertical walls falls, and so do
    several in a row, although forces that nothing provides could hold them. Of blocks that touch
    other free ones this is not known: those may settle against them.
    """
    problem, model = asked.problem, asked.problem.model
    falling, acceleration = problem.unpressed, problem.acceleration
    if not beside_supports(model.assembly, model.contacts, falling):
        return None
    strictly = unpressed(model.assembly, model.contacts, acceleration, NO_APPROACH)
    if not falling.any() or not strictly.all(where=falling):
        return None
    others = problem.without(falling)
    if others is not None:
        part = decided(Asked(others, asked.options, asked.clock))
        asked.steps += part.iterations
        if not part.stable:
            return None
    return asked.answer(
        Verdict.UNSTABLE,
        "nothing presses on the blocks that fall, so nothing holds them",
        mechanism=problem.normalised(np.where(falling[:, None], acceleration, 0.0)),
        prop=0.0 - np.where(falling[:, None], model.load.wrench, 0.0),
        falling=tuple(int(i) for i in np.flatnonzero(falling)),
    )


def _doubtful(asked: Asked, rest: Candidate) -> bool:
    """Whether blocks that uniform stiffness holds must be followed.

    The springs with which they are followed do not hold them, or they slide far on those; or
    hardly anything presses on some blocks at first, nor in the rest state. Of blocks beside
    supports the rest state does not count.
    """
    problem, model = asked.problem, asked.problem.model
    alike = asked.tried[1] if len(asked.tried) > 1 else rest
    if not alike.stands or problem.slide_by_overlap(alike.displacement) > SLIDES_FAR:
        return True
    falling = problem.unpressed
    if not falling.any() or beside_supports(model.assembly, model.contacts, falling):
        return bool(falling.any())
    closing = closing_blocks(model.assembly, model.contacts, rest.displacement)
    return not closing[falling].all()


def _by_what_blocks_feel(asked: Asked, uniform: Candidate) -> Candidate | None:
    """A rest state where blocks feel little, or much more than their load, if there is one.

    Joints are then softer in proportion, or slip later. What a block feels is at first taken from
    any forces that balance the loads: on uniform springs heavy blocks that turn may throw it away.
    """
    force = uniform.force
    if asked.nearest is not None:
        force = asked.problem.force(asked.nearest.force)
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


def _followed(asked: Asked, pool: WorkerPool, uniform: Candidate) -> Result:
    """The verdict of blocks that are followed by finite steps."""
    asked.report("settlement", 2)
    clock, options = asked.clock, asked.options.settlement
    hardly = asked.problem.unpressed.any()
    if hardly:  # a plug that hardly tapers presses more and more on a long way
        options = replace(options, fall=max(options.fall, SettlementOptions().fall))
    found = settle_for_verdict(
        asked.problem.model,
        options=options,
        executor=pool.executor,
        stop=clock.late,
    )
    if found.stopped:  # by the clock of the check, which knows why
        message = found.message.replace(found.stopped, clock.reason)
        found = replace(found, message=message, stopped=clock.reason)
    asked.steps += sum(path.iterations for path in found.paths)
    held = "uniform contact stiffness would not hold it in place"
    if hardly:
        held = "hardly anything presses on some of its blocks at first"
    elif uniform.stands:
        held = "it slides far where uniform contact stiffness holds it"
        stood, tried = sum(one.stands for one in asked.tried), len(asked.tried)
        if stood < tried:
            held = f"{stood} of {tried} contact stiffnesses tried would hold it in place"
    words = f"{found.message}; {held}: {SENSITIVE}"
    if found.outcome is Outcome.RESTS:
        if not uniform.stands or hardly:
            return asked.settles(found, words)
        # that it slides far was the only doubt
        certain = all(one.stands for one in asked.tried)
        return asked.stable(uniform) if certain else asked.stable(uniform, words, found)
    if found.outcome in (Outcome.UNKNOWN, Outcome.ENDS_DECIDE):
        if clock.late():
            return asked.no_answer()
        return asked.answer(Verdict.UNDECIDED, words, settlement=found)
    if hardly:
        words = f"{held}, and {found.message}"
    elif not uniform.stands and asked.balances:
        reached = "forces could balance the loads, but the loads alone do not bring them about"
        words = f"{reached}; {found.message}; shims or prestress might hold it: {SENSITIVE}"
    motion = next(asked.first_motions(), None)
    if motion is None and not uniform.stands:
        asked.try_others(pool, SAMPLES)
        motion = next(asked.first_motions(), None)
    if motion is None:
        motion = asked.problem.normalised(found.displacement)
    return replace(asked.unstable(words, motion, uniform), settlement=found)


@dataclass(eq=False)
class Asked:
    """What was asked, what was found so far, and every result that a check can end with.

    Attributes
    ----------
    problem, options, clock, progress
    nearest
        The mechanism nearest to free fall, once it is known.
    tried
        The answer of each contact stiffness, the uniform one first.
    steps
        Of all calculations.
    balances
        Whether some forces are known to balance the loads.
    stage
        What is being calculated.
    """

    problem: Problem
    options: CheckOptions
    clock: Clock
    progress: Progress | None = None
    nearest: NearestMechanism | None = None
    tried: tuple[Candidate, ...] = ()
    steps: int = 0
    balances: bool = False
    stage: str = "rest state"

    def report(self, stage: str, done: int) -> None:
        """Say what is calculated next."""
        if not self.clock.reason:
            self.stage = stage
        if self.progress is not None:
            self.progress(stage, done, 3 + self.options.samples)

    def attempt(self, springs: Compliance | None = None) -> Attempt:
        """The try of some springs, of uniform ones by default."""
        chosen = law.uniform(self.problem.statics) if springs is None else springs
        return Attempt(self.problem, chosen, self.clock.late)

    def count(self, found: Candidate) -> None:
        """Keep the answer of a stiffness, if it was not interrupted."""
        self.steps += found.steps
        if found.stands or found.falling is not None or not self.clock.late():
            self.tried += (found,)

    def try_others(self, pool: WorkerPool, count: int, rest: Candidate | None = None) -> None:
        """Rest states with other contact stiffnesses, from that of the uniform one.

        The first has the springs with which blocks are followed.
        """
        options, statics = self.options, self.problem.statics
        springs = law.samples(
            statics, count, options.seed, tangential=options.settlement.tangential
        )
        self.report("stiffness samples", 2)
        near = rest.displacement if rest is not None and statics.dry else None
        task = partial(_attempted, self.problem, self.clock, near)
        for number, found in enumerate(pool.answers(task, springs, self.clock.late), start=1):
            self.count(found)
            self.report("stiffness samples", min(2 + number, 2 + options.samples))

    @cached_property
    def collapse(self) -> Floats | None:
        """The collapse mechanism (n, 6); None if forces balance the loads, or if none was found."""
        self.report("equilibrium", 1)
        problem, late = self.problem, self.clock.late
        if problem.statics.dry:
            if self.nearest is None:
                self.nearest = nearest_mechanism(problem.system, stop=late)
            nearest = self.nearest
            self.steps += nearest.iterations
            if nearest.motion is not None:
                motion = sound_mechanism(problem, nearest.motion)
                if motion is not None:
                    return motion
            elif balanced(problem, nearest.force):
                self.balances = True
                return None
        balance = solve_equilibrium(
            problem.statics,
            cone=FrictionCone.exact(),
            options=ConicOptions(gap=ANY_FORCES, time_limit_s=self.clock.left_s),
            stop=late,
        )
        self.steps += balance.raw.iterations
        self.balances = balance.raw.status is ConicStatus.SOLVED
        return None if self.balances else found_mechanism(problem, balance, late)

    def first_motions(self) -> Iterator[Floats]:
        """First motions (n, 6) of states on ground springs, then of that on weaker springs."""
        falling = [one.falling for one in self.tried if one.falling is not None]
        for state in falling:
            motion = first_motion(self.problem, state)
            if motion is not None:
                yield motion
        if falling and not self.clock.late():
            motion = first_motion(self.problem, self.attempt().falling())
            if motion is not None:
                yield motion

    def nothing_free(self) -> Result:
        """STABLE: there is nothing to calculate."""
        model = self.problem.model
        return self.answer(
            Verdict.STABLE,
            "every block is fixed",
            force=np.zeros((model.contacts.corner_count, 3)),
            displacement=np.zeros((len(model.assembly), 6)),
            residuals=Residuals(),
        )

    def stable(
        self, rest: Candidate, words: str = "", settlement: Settlement | None = None
    ) -> Result:
        """STABLE with a rest state in place."""
        tried, stood = len(self.tried), sum(one.stands for one in self.tried)
        words = words or "stands"
        if settlement is None and tried > 2:
            words = f"stands, whichever joints press more ({tried} contact stiffnesses tried)"
            if stood < tried:
                words = f"stands for {stood} of {tried} contact stiffnesses tried: {SENSITIVE}"
        left = 1 + self.options.samples - tried
        if self.clock.reason and left > 0:
            words += f"; {self.clock.reason} before {left} more could be tried"
        return self.answer(
            Verdict.STABLE,
            words,
            force=rest.force,
            displacement=rest.displacement,
            residuals=rest.residuals,
            settlement=settlement,
        )

    def settles(self, found: Settlement, words: str) -> Result:
        """STABLE after settling: forces on the moved blocks, in the axes of the first joints.

        Faces that were met are the last joints of the model of the result.
        """
        path = found.path
        contacts = path.model.contacts
        world = np.einsum("ki,kij->kj", path.force, path.axes)
        return self.answer(
            Verdict.STABLE,
            words,
            model=path.model,
            force=np.einsum("kij,kj->ki", contacts.frame[contacts.interface], world),
            displacement=path.displacement,
            residuals=path.residuals,
            settlement=found,
        )

    def unstable(self, message: str, mechanism: Floats, leaning: Candidate | None = None) -> Result:
        """UNSTABLE, with the blocks and props of a state on ground springs if there is one.

        Otherwise the props hold the blocks against the accelerations of the mechanism that was
        found.
        """
        problem = self.problem
        falling = moving_blocks(problem.model.assembly, mechanism)
        prop = force = None
        if leaning is not None and leaning.falling is not None:
            ground = leaning.falling.ground
            share = problem.ground_share(ground)
            chosen = problem.statics.free[share > FALLING_SHARE * share.max()]
            falling = tuple(int(i) for i in chosen)
            prop, force = -problem.wrench(ground), leaning.force
        elif self.nearest is not None and self.nearest.motion is not None:
            left = self.nearest.force
            force = problem.force(left)
            prop = -problem.wrench(problem.statics.load + problem.statics.wrench(left))
        return self.answer(
            Verdict.UNSTABLE,
            message,
            mechanism=mechanism,
            prop=prop,
            force_with_props=force,
            falling=falling,
        )

    def first_motion(self, uniform: Candidate) -> Result:
        """UNSTABLE with a first motion; UNDECIDED where none was found."""
        left_out = f"; {self.clock.reason} before all else was tried" if self.clock.late() else ""
        for motion in self.first_motions():
            words = "it starts to move"
            if self.balances:
                words = f"forces could balance the loads, but they do not arise; {words}"
            return self.unstable(words + left_out, motion, uniform)
        return self.no_answer()

    def no_answer(self) -> Result:
        """UNDECIDED: neither a rest state nor a motion is shown."""
        tried = len(self.tried)
        those = f"{tried} stiffness distribution{'' if tried == 1 else 's'}"
        words = f"no rest state in {those}, and no proof that there is none; more samples may help"
        if self.clock.late():
            done = f"no rest state in {those}" if tried else "no stiffness distribution tried out"
            words = f"{done}; {self.clock.reason} in '{self.stage}' (steps: {self.steps})"
        return self.answer(Verdict.UNDECIDED, words)

    def answer(
        self, verdict: Verdict, message: str, model: Model | None = None, **found: Any
    ) -> Result:
        """A result, with the counts and times of the check."""
        self.report("done", 3 + self.options.samples)
        return Result(
            method="check",
            verdict=verdict,
            model=self.problem.model if model is None else model,
            message=message,
            samples=Samples(len(self.tried), sum(one.stands for one in self.tried)),
            stopped=self.clock.reason,
            options=self.options,
            solver="rest state by interior points",
            iterations=self.steps,
            time_s={"solve": self.clock.elapsed_s},
            **found,
        )


@one_blas_thread()
def _attempted(
    problem: Problem, clock: Clock, near: Floats | None, springs: Compliance
) -> Candidate:
    attempt = Attempt(problem, springs, clock.late)
    found = None if near is None else attempt.begun_at(near)
    return attempt.from_nothing() if found is None else found
