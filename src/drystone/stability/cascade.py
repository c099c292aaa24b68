"""The cascade that ends with forces and a motion, or with a proof that it falls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.progress import Progress
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import solve_equilibrium
from drystone.formulations.improvement import CompatibleState
from drystone.formulations.rest import compliance
from drystone.formulations.stiffness_range import ROUNDING, stiffness_ratio
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.settlement import Outcome, Settlement, settle
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import CLEARLY, MUCH, Attempts, Candidate
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Clock, Problem
from drystone.stability.programs.rbe import ANY_FORCES
from drystone.stability.proofs import (
    FALLING_SHARE,
    NO_APPROACH,
    beside_supports,
    closing_blocks,
    first_motion,
    found_mechanism,
    free_acceleration,
    moving_blocks,
    unpressed,
)
from drystone.stability.screening import SLIP_LENGTH
from drystone.stability.search_starts import SLIDE_LIMIT, StateSearch

SENSITIVE = "sensitive to how the joints press"
NOT_REACHED = "forces could balance the loads, but the loads alone do not bring them about"


class Cascade:
    """The cascade: free fall, rest, impossibility, other stiffnesses, search, first motion.

    Parameters
    ----------
    problem, options, progress, clock
    known : (n, 6) [m, rad] each
        Rest states of a similar model by the number of the contact stiffness, 0 for the uniform
        one. The same stiffness is tried from there first.

    Attributes
    ----------
    rests
        As ``known``, of this model.
    """

    def __init__(
        self,
        problem: Problem,
        options: CheckOptions,
        progress: Progress | None,
        clock: Clock,
        known: Mapping[int, Floats] | None = None,
    ) -> None:
        self.problem = problem
        self.options = options
        self.progress = progress
        self.clock = clock
        self.known = known or {}
        self.rests: dict[int, Floats] = {}
        self.iterations = 0
        self.equal_overlap = self.balances = False
        self.stiffness_ratio = 1.0
        self.stage = "free fall"
        self.attempts = Attempts(problem, clock)
        self.settlement: Settlement | None = None

    def run(self) -> Result:
        """The verdict, with its proof."""
        problem = self.problem
        if problem.statics.free_count == 0:
            return self._nothing_free()
        if self.options.uniform:
            strict = replace(self.options, samples=0, settle=False, uniform=False)
            once = Cascade(problem, strict, self.progress, self.clock, self.known)
            found = once.run()
            self.attempts, self.rests = once.attempts, once.rests
            if not found.stable or self.clock.late():
                return replace(found, options=self.options)
        dropped = self._free_fall()
        return self._after_free_fall() if dropped is None else dropped

    @one_blas_thread()
    def _after_free_fall(self) -> Result:
        """The verdict where something presses on every block."""
        problem = self.problem
        attempts, uniform = self.attempts, self.uniform
        if not uniform.stands and not self.clock.late():
            if self.collapse is not None:
                return self._unstable("no contact forces can balance the loads", self.collapse)
            if not attempts.falling:
                # no convergence: a smooth law converges more easily
                smooth = compliance.uniform(problem.statics, slip=SLIP_LENGTH)
                uniform = attempts.attempt(smooth, again=True)
        if uniform.stands:
            self.rests[0] = uniform.displacement
        # settlement and the search know dry joints only
        settle = self.options.settle and problem.statics.dry
        if not (settle and attempts.falling):  # otherwise the stiffness decides, whatever others do
            self._other_stiffnesses(uniform)
        decided = not settle or len(attempts.standing) == attempts.tried
        if attempts.standing and (decided or self.clock.late()):
            return self._stable(uniform)
        if settle and not self.clock.late():
            return self._followed(uniform)
        self._report("search", 2 + self.options.samples)
        found = self._search()
        if found is not None:
            return self._sensitive(found)
        return self._first_motion()

    @cached_property
    def uniform(self) -> Candidate:
        """The answer of uniform contact stiffness."""
        self._report("rest state", 0)
        springs, attempts = compliance.uniform(self.problem.statics), self.attempts
        if attempts.standing:
            return attempts.standing[0]
        found = None
        if 0 in self.known and self.problem.statics.dry:
            found = attempts.nearby(springs, attempts.start(springs, self.known[0]))
        # without friction equilibrium decides
        much = MUCH if self.problem.statics.friction.any() else CLEARLY
        return found or attempts.attempt(
            springs, falls=lambda: self.collapse is not None, much=much
        )

    def _other_stiffnesses(self, uniform: Candidate) -> None:
        """Rest states for the samples of the stiffness, once.

        Without friction the motion of a joint is normal to its limits. Then all stiffnesses give
        the same answer (static theorem of limit analysis).
        """
        attempts, statics = self.attempts, self.problem.statics
        if attempts.tried > 1 or (uniform.stands and not statics.friction.any()):
            return
        samples = compliance.samples(statics, self.options.samples, self.options.seed)
        for number, sample in enumerate(samples):
            if self.clock.late():
                break
            self._report("stiffness samples", 2 + number)
            rests = [self.known[1 + number]] if 1 + number in self.known else []
            if uniform.stands:
                rests.append(uniform.displacement)
            # a start is scaled as if forces were in proportion to the motion
            found = attempts.attempt_from(sample, rests if statics.dry else ())
            if found.stands:
                self.rests[1 + number] = found.displacement
            elif self.options.uniform:  # settlement decides
                break

    def _free_fall(self) -> Result | None:
        """UNSTABLE when the loads press some blocks against nothing and the others stand.

        A free block that touches those that would fall may settle against them: a rest state in
        which something presses on each of them shows that it does. Without one, and where they
        press a little, as on a plug that hardly tapers, following the blocks decides.

        Contact forces answer pressing. Blocks that the loads accelerate without approaching any
        corner feel none, at whatever friction: a block between two vertical walls falls, and so do
        several in a row, although forces that nothing provides could hold them.
        """
        problem = self.problem
        acceleration = free_acceleration(problem)
        assembly, contacts = problem.model.assembly, problem.model.contacts
        falling = unpressed(assembly, contacts, acceleration)
        if not falling.any():
            return None
        apart = beside_supports(assembly, contacts, falling)
        settle = self.options.settle and problem.statics.dry
        if not settle and not apart:
            return None
        if settle:
            surely = apart and unpressed(assembly, contacts, acceleration, NO_APPROACH).all(
                where=falling
            )
            if not apart and self._caught(falling):
                return None
            why = "hardly anything presses on some of its blocks at first"
            followed = None if surely else self._follow()
            if followed is not None and followed.outcome is Outcome.RESTS:
                return self._rests(followed, why)
            if followed is not None and followed.outcome is Outcome.ENDS_DECIDE:
                return self._open(followed, why)
            if followed is not None and followed.outcome is Outcome.UNKNOWN and not apart:
                return None
        rest = problem.without(falling)
        if rest is not None:
            part = Cascade(rest, self.options, None, self.clock).run()
            self.iterations += part.iterations
            if part.verdict is not Verdict.STABLE:
                return None
        motion = np.where(falling[:, None], acceleration, 0.0)
        return self._answer(
            Verdict.UNSTABLE,
            "nothing presses on the blocks that fall, so nothing holds them",
            mechanism=problem.normalised(motion),
            prop=0.0 - np.where(falling[:, None], problem.model.load.wrench, 0.0),
            falling=tuple(int(i) for i in np.flatnonzero(falling)),
        )

    @one_blas_thread()
    def _caught(self, falling: Bools) -> bool:
        """Whether uniform stiffness has a rest state in which something presses on blocks (n,)."""
        model, state = self.problem.model, self.uniform
        if not state.stands:
            return False
        return bool(
            closing_blocks(model.assembly, model.contacts, state.displacement)[falling].all()
        )

    @one_blas_thread()
    def _follow(self) -> Settlement:
        """The motion of the blocks by finite steps."""
        if self.settlement is None:
            self._report("settlement", 2 + self.options.samples)
            model, options = self.problem.model, self.options.settlement
            self.settlement = settle(model, options=options, stop=self.clock.late)
            self.iterations += sum(path.iterations for path in self.settlement.paths)
        return self.settlement

    def _followed(self, uniform: Candidate) -> Result:
        """The verdict of finite steps, where the contact stiffness decides."""
        found = self._follow()
        if found.outcome is Outcome.UNKNOWN:
            self._other_stiffnesses(uniform)
        stood, tried = len(self.attempts.standing), self.attempts.tried
        held = f"{stood or 'none'} of {tried} contact stiffnesses tried would hold it in place"
        if tried == 1:
            held = "uniform contact stiffness would not hold it in place"
        if found.outcome is Outcome.RESTS:
            return self._rests(found, held)
        if found.outcome is Outcome.UNKNOWN and not stood and tried > self.options.samples:
            return replace(self._first_motion(), settlement=found)
        if found.outcome not in (Outcome.FALLS, Outcome.DISPLACED):
            return self._open(found, held)
        motions = (first_motion(self.problem, one.state) for one in self.attempts.falling)
        motion = next((one for one in motions if one is not None), None)
        if motion is None:
            motion = self.problem.normalised(found.displacement)
        words = f"{found.message}; {held}: {SENSITIVE}"
        if not stood and self.balances:
            words = f"{NOT_REACHED}; {found.message}; shims or prestress might hold it: {SENSITIVE}"
        return replace(self._unstable(words, motion), settlement=found)

    def _rests(self, found: Settlement, why: str) -> Result:
        """STABLE after settling, with a rest state in place if some stiffness has one.

        Otherwise the forces are those on the moved blocks, in the axes of the first joints. Faces
        that were met are the last joints of the model of the result.
        """
        words = f"{found.message}; {why}: {SENSITIVE}"
        for one in self.attempts.standing[:1]:
            return self._answer(
                Verdict.STABLE,
                words,
                force=one.force,
                displacement=one.displacement,
                residuals=one.residuals,
                settlement=found,
            )
        path = found.path
        contacts = path.model.contacts
        world = np.einsum("ki,kij->kj", path.force, path.axes)
        return self._answer(
            Verdict.STABLE,
            words,
            model=path.model,
            force=np.einsum("kij,kj->ki", contacts.frame[contacts.interface], world),
            displacement=path.displacement,
            residuals=path.residuals,
            settlement=found,
        )

    def _open(self, found: Settlement, why: str) -> Result:
        """UNDECIDED, with the result of following the blocks."""
        return self._answer(
            Verdict.UNDECIDED, f"{found.message}; {why}: {SENSITIVE}", settlement=found
        )

    @cached_property
    def collapse(self) -> Floats | None:
        """The collapse mechanism (n, 6); None if forces balance the loads, or if none was found."""
        self._report("equilibrium", 1)
        balance = solve_equilibrium(
            self.problem.statics,
            cone=FrictionCone.exact(),
            options=ConicOptions(gap=ANY_FORCES, time_limit_s=self.clock.left_s),
            stop=self.clock.late,
        )
        self.iterations += balance.raw.iterations
        self.balances = balance.raw.status is ConicStatus.SOLVED
        return None if self.balances else found_mechanism(self.problem, balance, self.clock.late)

    def _search(self) -> Candidate | None:
        """A state by convex steps, on joints whose stiffnesses differ as little as necessary.

        Without a bound on their ratio, forces due to prestress only would hold almost every wedge.
        """
        if not self.options.search or self.clock.late() or not self.problem.statics.dry:
            return None
        look = StateSearch(
            self.problem,
            self.clock,
            tries=self.options.search_tries,
            seed=self.options.seed,
            first=self.attempts.stalled,
        )
        try:
            for state in look.states(
                self.options.stiffness_ratio, reduce=self.options.reduce_ratio
            ):
                candidate = self._answering(look, state)
                if candidate is not None:
                    self.stiffness_ratio = stiffness_ratio(self.problem.statics, state)
                    if not self.options.reduce_ratio:
                        return candidate
                    return self._with_equal_overlap(look, state) or candidate
        finally:
            self.iterations += look.iterations
        return None

    def _answering(self, look: StateSearch, state: CompatibleState) -> Candidate | None:
        """The state as a proof that it stands, if it is one."""
        if look.slide(state) > SLIDE_LIMIT:
            return None
        candidate = self.attempts.examine(state.motion, state.force)
        return candidate if candidate.stands else None

    def _with_equal_overlap(self, look: StateSearch, state: CompatibleState) -> Candidate | None:
        """The nearest state of eq. 5.6, if its stiffness ratio is within the bound.

        Equal overlaps do not mean equal stiffnesses: these differ like the forces.
        """
        equal = look.equal_overlap(state.motion)
        ratio = stiffness_ratio(self.problem.statics, equal)
        if ratio > self.options.stiffness_ratio * ROUNDING:
            return None
        candidate = self._answering(look, equal)
        if candidate is not None:
            self.equal_overlap, self.stiffness_ratio = True, ratio
        return candidate

    # -- the answers ----------------------------------------------------------------------------
    def _nothing_free(self) -> Result:
        corners = self.problem.model.contacts.corner_count
        return self._answer(
            Verdict.STABLE,
            "every block is fixed",
            force=np.zeros((corners, 3)),
            displacement=np.zeros((len(self.problem.model.assembly), 6)),
            residuals=Residuals(),
        )

    def _stable(self, uniform: Candidate) -> Result:
        tried, stood = self.attempts.tried, len(self.attempts.standing)
        if tried == 1:
            words = "stands"
        elif stood == tried:
            words = f"stands for all {tried} contact stiffnesses tried"
        else:
            words = f"stands for {stood} of {tried} contact stiffnesses tried: {SENSITIVE}"
        left = 1 + self.options.samples - tried
        if self.clock.reason and left > 0:
            words += f"; {self.clock.reason} before {left} more could be tried"
        best = uniform if uniform.stands else self.attempts.standing[0]
        return self._answer(
            Verdict.STABLE,
            words,
            force=best.force,
            displacement=best.displacement,
            residuals=best.residuals,
        )

    def _sensitive(self, found: Candidate) -> Result:
        how = "eq. 5.6 is met"
        if not self.equal_overlap:
            times = (
                f"{self.stiffness_ratio:.0f}"
                if self.stiffness_ratio >= 10.0
                else f"{self.stiffness_ratio:.1f}"
            )
            how = f"it can rest where one joint is {times} times as stiff as another"
        return self._answer(
            Verdict.STABLE,
            f"{how}, but none of {self.attempts.tried} contact stiffnesses tried leads to rest: "
            f"{SENSITIVE}",
            force=found.force,
            displacement=found.displacement,
            residuals=found.residuals,
            stiffness_ratio=self.stiffness_ratio,
        )

    def _first_motion(self) -> Result:
        problem = self.problem
        left_out = f"; {self.clock.reason} before all else was tried" if self.clock.late() else ""
        for state in self.attempts.falling_states():
            motion = first_motion(problem, state)
            if motion is not None:
                words = "it starts to move"
                if self.balances:
                    words = f"{NOT_REACHED}; {words}"
                return self._unstable(words + left_out, motion)
        tried = self.attempts.tried
        those = f"{tried} stiffness distribution{'' if tried == 1 else 's'}"
        words = f"no rest state in {those}, and no proof that there is none; more samples may help"
        if self.clock.late():
            steps = self.iterations + self.attempts.iterations
            done = f"no rest state in {those}" if tried else "no stiffness distribution tried out"
            words = f"{done}; {self.clock.reason} in '{self.stage}' (steps: {steps})"
        return self._answer(Verdict.UNDECIDED, words)

    def _unstable(self, message: str, mechanism: Floats) -> Result:
        """UNSTABLE, with the blocks and props of the state on ground springs if there is one."""
        problem = self.problem
        falling = moving_blocks(problem.model.assembly, mechanism)
        prop = force = None
        for trial in self.attempts.falling[:1]:
            share = problem.ground_share(trial.ground)
            chosen = problem.statics.free[share > FALLING_SHARE * share.max()]
            falling = tuple(int(i) for i in chosen)
            prop = -problem.wrench(trial.ground)
            force = trial.force
        return self._answer(
            Verdict.UNSTABLE,
            message,
            mechanism=mechanism,
            prop=prop,
            force_with_props=force,
            falling=falling,
        )

    def _answer(
        self, verdict: Verdict, message: str, model: Model | None = None, **found: object
    ) -> Result:
        self._report("done", 3 + self.options.samples)
        elapsed, checking = self.clock.elapsed_s, self.attempts.checking_s
        return Result(
            method="check",
            verdict=verdict,
            model=self.problem.model if model is None else model,
            message=message,
            samples=Samples(self.attempts.tried, len(self.attempts.standing)),
            stopped=self.clock.reason,
            options=self.options,
            solver="rest state by interior points",
            iterations=self.iterations + self.attempts.iterations,
            time_s={"solve": elapsed - checking, "check": checking},
            **found,  # type: ignore[arg-type]
        )

    def _report(self, stage: str, done: int) -> None:
        if not self.clock.reason:
            self.stage = stage
        if self.progress is not None:
            self.progress(stage, done, 3 + self.options.samples)
