"""What a check has found so far, and every result that it can end with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from drystone.base.arrays import Bools, Floats, lengths
from drystone.base.settings import Clock, Options
from drystone.base.workers import WorkerPool
from drystone.checks import unbalanced_wrench
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import ANY_FORCES, EquilibriumSolution, solve_equilibrium
from drystone.formulations.nearest_mechanism import NearestMechanism, nearest_mechanism
from drystone.friction_use import spread_where_turned
from drystone.joints import resultants_of
from drystone.mechanics import law
from drystone.mechanics.law import Compliance
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Sensitivity, Verdict
from drystone.settlement import Settlement, SettlementOptions
from drystone.solvers.program import ConicOptions, ConicStatus
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Attempt, Candidate
from drystone.stability.problem import (
    FALLING_SHARE,
    Problem,
    balanced,
    checked_mechanism,
    first_motion,
    moving_blocks,
    sound_mechanism,
)

SAMPLES = 4
"""Other contact stiffnesses, at most, that tell robust from sensitive."""


@dataclass(frozen=True)
class CheckOptions(Options):
    """Options of :func:`check`.

    Attributes
    ----------
    samples : >= 0
        Number of contact stiffness distributions that are tried at most besides the uniform one
        where it stands. They change no verdict; with 4 of them it is known whether it stands
        whichever joints press more (robust), or not (sensitive). Two are random; one, with more
        than 120 joints, where all random ones are alike, or where joints turn much. One more
        carries on points spread over such joints then, with 0 as well.
    settle
        Where uniform stiffness does not decide, follow the blocks by finite steps
        (:func:`drystone.settle`); their motion gives the verdict.
    settlement
        How they are followed; by default until a block has moved by a twentieth of its size. What
        stands moves no farther than a fiftieth.
    stiff_shear : > 0, < inf
        Tangential by normal stiffness with which blocks are followed once more, where joints
        decide: UNDECIDED where the two ways end otherwise. With ``None`` they are followed once,
        with that of ``settlement``. Measured on 107 models near limits: three wedges that 0.17
        alone would decide end otherwise at 0.5; at 1 six, the others beyond their limits.
    uniform
        Stable only where uniform contact stiffness holds it too. What falls with it is not
        followed.
    seed : >= 0
        Of the random stiffness distributions.
    """

    samples: int = 0
    settle: bool = True
    settlement: SettlementOptions = SettlementOptions(fall=0.05)  # noqa: RUF009 - frozen
    stiff_shear: float | None = 0.5
    uniform: bool = False
    seed: int = 0

    @classmethod
    def robust(cls) -> CheckOptions:
        """Options of the question whether it stands whichever joints press more."""
        return cls(samples=SAMPLES)


LOST = 1e-4
"""Unbalanced share of what a block feels from which on its load is lost beside heavier ones."""


@dataclass(eq=False)
class Asked:
    """What was asked, what was found so far, and every result that a check can end with.

    Attributes
    ----------
    problem, options, clock
    nearest
        The mechanism nearest to free fall, once it is known.
    tried
        The answer of each contact stiffness, the uniform one first.
    planned
        How many stiffnesses there are to try.
    sensitive_to
        What the answer is known to depend on.
    on_faces
        The one of them that carries on points spread over the faces, where that may matter.
    steps
        Of all calculations.
    balances
        Whether some forces are known to balance the loads.
    stage
        What is being calculated.
    explains
        Whether it is looked for what would change the verdict, which it does not change.
    """

    problem: Problem
    options: CheckOptions
    clock: Clock
    nearest: NearestMechanism | None = None
    tried: tuple[Candidate, ...] = ()
    planned: int = 1
    sensitive_to: frozenset[Sensitivity] = frozenset()
    on_faces: Candidate | None = None
    steps: int = 0
    balances: bool = False
    stage: str = "rest state"
    explains: bool = True

    def report(self, stage: str, done: int) -> None:
        """Say what is calculated next."""
        if not self.clock.reason:
            self.stage = stage
        self.clock.tell(stage, done, 3 + self.options.samples)

    def depends_on(self, what: Sensitivity) -> None:
        """Keep what the answer depends on."""
        self.sensitive_to |= {what}

    @property
    def sensitive(self) -> str:
        """What the answer depends on, in words."""
        those = [one.value for one in self.reasons] or [Sensitivity.JOINTS.value]
        return f"sensitive to {' and '.join(those)}"

    @property
    def reasons(self) -> tuple[Sensitivity, ...]:
        """What the answer depends on, in their order."""
        return tuple(one for one in Sensitivity if one in self.sensitive_to)

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

        The first has the springs with which blocks are followed. Random ones have smooth friction
        as well, and begin at the last one that is alike in all joints and stands. Measured: on the
        Armadillo vault, tilted by 0 and 5 degrees, they take 8 to 10 factorisations in place of 20
        to 23, and elsewhere as many. From a rest state on, another one that does not hold it ends
        them.
        """
        options, statics = self.options, self.problem.statics
        tangential = options.settlement.tangential
        groups = law.samples(statics, count, options.seed, tangential=tangential)
        self.planned = len(self.tried) + sum(len(springs) for springs in groups)
        self.report("stiffness samples", 2)
        near, reason = rest, Sensitivity.SHEAR
        for springs in groups:
            task = partial(_attempted, self.problem, self.clock, near)
            for found in pool.answers(task, springs, self.clock.late):
                self.count(found)
                self.report("stiffness samples", min(1 + len(self.tried), 2 + options.samples))
                if found.stands:
                    near = rest and found
                elif not self.clock.late():
                    self.depends_on(reason)
                reason = Sensitivity.JOINTS
                if rest is not None and reason in self.sensitive_to:
                    self.planned = len(self.tried)
                    return

    def on_spread_points(self, force: Floats, model: Model) -> tuple[Model, Bools, Floats] | None:
        """The model with points on faces whose forces (k, 3) [N] may need their corners, if any.

        And which of its corners (k,) stay, first, and the forces (p, 3) [N] of the points.
        """
        points = spread_where_turned(model.contacts, resultants_of(model.contacts, force))
        return None if points is None else (model.with_contacts(points[0]), *points[1:])

    def not_held(self, model: Model, rest: Candidate) -> Model | None:
        """The model with points spread over its faces, where uniform springs do not hold it.

        None where they do, or late. Faces that are used much only then have points as well.
        """
        while True:
            problem = Problem.build(model)
            attempt = Attempt(problem, law.uniform(problem.statics), self.clock.late)
            found = attempt.begun_at(rest.displacement)
            self.on_faces = rest = attempt.from_nothing() if found is None else found
            more = self.on_spread_points(rest.force, model) if rest.stands else None
            if more is None:
                break
            model, self.steps = more[0], self.steps + rest.steps
        self.count(replace(rest, falling=None))  # a state of more corners than the model has
        if rest.stands or self.clock.late():
            return None
        self.depends_on(Sensitivity.PRESSURE)
        return model

    @cached_property
    def collapse(self) -> Floats | None:
        """The collapse mechanism (n, 6); None if forces balance the loads, or if none was found."""
        self.report("equilibrium", 1)
        problem, late = self.problem, self.clock.late
        if problem.statics.dry:
            if self.nearest is None:
                self.nearest = nearest_mechanism(problem.statics, stop=late)
            nearest = self.nearest
            self.steps += nearest.iterations
            if nearest.motion is not None:
                motion = sound_mechanism(problem, nearest.motion)
                if motion is not None:
                    return motion
            elif balanced(problem, nearest.force):
                self.balances = True
                return None
        balance, motion = self._any_forces(problem)
        self.balances = balance.raw.status is ConicStatus.SOLVED
        return motion if motion is not None else self._of_light_blocks(balance.force)

    def falls_alone(self, motion: Floats) -> Floats | None:
        """The mechanism (n, 6) of the blocks that move most in a scaled motion, others at rest.

        Measured on 1,000 subsets of a wall: of 104 parts that fall by a mechanism and do not rest
        near a similar part 96 fall so, mostly one to five blocks.
        """
        size = np.abs(motion).max(axis=1)
        moving = size > FALLING_SHARE * size.max()
        if moving.all() or not moving.any():
            return None
        statics = self.problem.statics.with_free(moving)
        found = nearest_mechanism(statics, stop=self.clock.late)
        self.steps += found.iterations
        if found.motion is None:
            return None
        whole = np.zeros_like(motion)
        whole[moving] = found.motion
        return sound_mechanism(self.problem, whole)

    @property
    def balance(self) -> Floats | None:
        """Corner forces (k, 3) [N] that balance the loads, where there are some that are known."""
        return None if self.nearest is None else self.problem.force(self.nearest.force)

    def _any_forces(self, problem: Problem) -> tuple[EquilibriumSolution, Floats | None]:
        """What a program finds to balance the loads; else the mechanism (n, 6), if it is found."""
        options = ConicOptions(gap=ANY_FORCES, time_limit_s=self.clock.left_s)
        late, cone = self.clock.late, FrictionCone.exact()
        found = solve_equilibrium(problem.statics, cone=cone, options=options, stop=late)
        self.steps += found.raw.iterations
        solved = found.raw.status is ConicStatus.SOLVED
        return found, None if solved else checked_mechanism(problem, found)

    def _of_light_blocks(self, force: Floats) -> Floats | None:
        """The mechanism (n, 6) of blocks whose loads are lost in the rounding of heavier ones.

        What scaled forces (k, 3) balance is held still. A motion of the rest is one of all blocks.
        """
        problem, model = self.problem, self.problem.model
        wrench, scale = unbalanced_wrench(model, problem.force(force))
        lost = (lengths(wrench) > LOST * scale) & ~model.assembly.fixed
        if not lost.any() or lost[~model.assembly.fixed].all() or self.clock.late():
            return None
        found, motion = self._any_forces(problem.with_others_fixed(lost))
        self.balances &= found.raw.status is ConicStatus.SOLVED
        return motion

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

    def smooth_motion(self) -> Floats | None:
        """The first motion (n, 6) with smooth friction, which is followed more easily, if any."""
        smooth = law.uniform(self.problem.statics, slip=10.0)
        return first_motion(self.problem, self.attempt(smooth).falling())

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
        words = words or self.stands()
        left = self.planned - len(self.tried)
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

    def stands(self) -> str:
        """How far it stands whichever joints press more, and not on their corners only."""
        tried, stood = len(self.tried), sum(one.stands for one in self.tried)
        if stood < tried:
            return f"stands for {stood} of {tried} contact stiffnesses tried: {self.sensitive}"
        if not self.options.samples:
            return "stands"
        spread = "" if self.on_faces is None else ", one with pressure spread over the faces"
        return f"stands, whichever joints press more ({tried} contact stiffnesses tried{spread})"

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
            leaning = next((one for one in self.tried if one.falling is not None), uniform)
            return self.unstable(words + left_out, motion, leaning)
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
            sensitive_to=self.reasons if verdict is not Verdict.UNSTABLE else (),
            options=self.options,
            solver="rest state by interior points",
            iterations=self.steps,
            time_s={"solve": self.clock.elapsed_s},
            **found,
        )


@one_blas_thread()
def _attempted(
    problem: Problem, clock: Clock, rest: Candidate | None, springs: Compliance
) -> Candidate:
    attempt = Attempt(problem, springs, clock.late)
    found = None if rest is None else attempt.with_forces_of(rest)
    return attempt.from_nothing() if found is None else found
