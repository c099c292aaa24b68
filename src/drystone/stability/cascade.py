"""The cascade that ends with forces and a motion, or with a proof that it falls."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.progress import Clock, Progress, Workers
from drystone.base.workers import WorkerPool
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import solve_equilibrium
from drystone.formulations.improvement import CompatibleState
from drystone.formulations.nearest_mechanism import NearestMechanism, nearest_mechanism
from drystone.formulations.rest import compliance
from drystone.formulations.rest.compliance import Compliance
from drystone.formulations.stiffness_range import ROUNDING, stiffness_ratio
from drystone.results import Result, Verdict
from drystone.settlement import Outcome, Settlement, settle
from drystone.settlement.settling import settle_for_verdict
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import (
    CLEARLY,
    MUCH,
    Attempts,
    Candidate,
    Record,
)
from drystone.stability.check_answers import NOT_REACHED, SENSITIVE, Answers
from drystone.stability.check_options import CheckOptions
from drystone.stability.free_fall import (
    NO_APPROACH,
    beside_supports,
    closing_blocks,
    unpressed,
)
from drystone.stability.problem import Problem
from drystone.stability.programs.rbe import ANY_FORCES
from drystone.stability.proofs import (
    balanced,
    first_motion,
    found_mechanism,
    sound_mechanism,
)
from drystone.stability.screening import QUICK, SLIP_LENGTH
from drystone.stability.search_starts import SLIDE_LIMIT, StateSearch
from drystone.stability.stiffness_samples import (
    NONE_FOUND,
    TriedStiffnesses,
    attempt_sample,
    samples_to_try,
)

UNBALANCED = "no contact forces can balance the loads"

SLIDES_FAR = 20.0
"""Slide by overlap, in the rest state with the springs of settlement, from which on the blocks are
followed although every stiffness stands. A slide changes the friction on its way, and one so long
occurs close to a limit. Measured on the published models: 24 or more where following shows a fall.
Domes, vaults, walls and arches near their limits: 8 at most if they do not slide as a whole."""


FOLLOWED = -1
"""In place of the number of a stiffness: the rest state with the springs of settlement of a similar
model whose blocks were followed to rest."""

SETTLES_ALIKE = "it settles as a similar stage that was followed to rest"


ROUNDS = 3
"""How often light blocks are given what they feel, by the forces found before. Measured: a boulder
on three pebbles of 3e-16 of its weight stands after the second time."""


class Cascade:
    """The cascade: free fall, rest, impossibility, other stiffnesses, search, first motion.

    Parameters
    ----------
    problem, options, progress, clock, executor
    known : (n, 6) [m, rad] each
        Rest states of a similar model by the number of the contact stiffness, 0 for the uniform
        one. The same stiffness is tried from there first. Empty: none was found. Then it is looked
        for briefly, and again where following the blocks does not show that they rest. FOLLOWED:
        blocks that do not slide farther than there are not followed again.
    within
        Numbers (m,) of the interfaces in a larger model, and how many interfaces that has: the
        stiffness of each interface is then drawn as it is there.
    robust
        Whether only standing with every stiffness counts: the first that does not hold it ends the
        check.
    witness
        Whether other stiffnesses are tried after one that does not hold, and for a first motion
        where blocks were followed to a fall. Their motion is told where there is none.
    nearest
        The mechanism nearest to free fall, where it is known already.
    rest
        The rest state of uniform stiffness, where it is known already.
    tried
        What other checks of this model have tried. What is found here is added.

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
        executor: Workers | None = None,
        known: Mapping[int, Floats] | None = None,
        within: tuple[Ints, int] | None = None,
        robust: bool = False,
        witness: bool = True,
        nearest: NearestMechanism | None = None,
        rest: Candidate | None = None,
        tried: TriedStiffnesses | None = None,
    ) -> None:
        self.problem = problem
        self.options = options
        self.clock = clock
        self.executor = executor
        self.known = known or {}
        self.within = within
        self.robust = robust
        self.witness = witness
        self.nearest = nearest
        self.rest = rest
        self.tried = TriedStiffnesses() if tried is None else tried
        self.rests: dict[int, Floats] = {}
        self.pool = WorkerPool(None)
        self.answers = Answers(problem, options, progress, clock)
        self.attempts = self.answers.attempts
        if rest is not None:
            self.attempts.add(Record([rest], tried=1))
        self.settlement: Settlement | None = None

    def run(self) -> Result:
        """The verdict, with its proof."""
        problem = self.problem
        if problem.statics.free_count == 0:
            return self.answers.nothing_free()
        if self.options.uniform:
            strict = replace(self.options, samples=0, settle=False, uniform=False)
            progress = self.answers.progress
            once = Cascade(
                problem,
                strict,
                progress,
                self.clock,
                self.executor,
                self.known,
                nearest=self.nearest,
                rest=self.rest,
            )
            found = once.run()
            self.attempts, self.rests = once.attempts, once.rests
            self.answers.attempts = self.attempts
            if not found.stable or self.clock.late():
                return replace(found, options=self.options)
        with WorkerPool(self.executor) as self.pool:
            dropped = self._free_fall()
            return self._after_free_fall() if dropped is None else dropped

    @one_blas_thread()
    def _after_free_fall(self) -> Result:
        """The verdict where something presses on every block."""
        problem, attempts = self.problem, self.attempts
        if 0 in self.known:
            # where a known rest state leads nowhere a mechanism is likely, and is found soon
            small = problem.statics.full_transposed is not None and problem.statics.dry
            doubtful = small and self._nearby is None
        else:
            # a fall then has the wrenches of the mechanism, not those of a state on the ground
            doubtful = self.nearest is not None and not attempts.standing
        if doubtful and self.collapse is not None:
            return self.answers.unstable(UNBALANCED, self.collapse)
        uniform = self.uniform
        if not uniform.stands and not self.clock.late():
            if self.collapse is not None:
                return self.answers.unstable(UNBALANCED, self.collapse)
            if not attempts.falling:
                # no convergence: a smooth law converges more easily
                smooth = compliance.uniform(problem.statics, slip=SLIP_LENGTH)
                uniform = self.uniform = attempts.attempt(smooth, again=True)
                if uniform.stands:
                    self.tried.uniform = uniform
        if uniform.stands:
            self.rests[0] = uniform.displacement
            if FOLLOWED in self.known:
                self.rests[FOLLOWED] = self.known[FOLLOWED]
        elif self.robust:
            return self.answers.answer(Verdict.UNDECIDED, "uniform contact stiffness does not hold")
        # settlement and the search know dry joints only
        follows = self.options.settle and problem.statics.dry
        if not follows or uniform.stands:  # otherwise the stiffness decides, whatever others do
            self._other_stiffnesses(uniform)
        decided = not follows or self.robustly
        if attempts.standing and (decided or self.clock.late()):
            return self.answers.stable(uniform)
        stands = self._by_what_blocks_feel(uniform)
        if stands is not None:
            return stands
        if follows and uniform.stands and self._settles_alike():
            return self.answers.stable(uniform, SETTLES_ALIKE)
        if follows and not self.clock.late():
            return self._followed(uniform)
        self.answers.report("search", 2 + self.options.samples)
        found = self._search()
        return self.answers.first_motion() if found is None else found

    def _by_what_blocks_feel(self, uniform: Candidate) -> Result | None:
        """STABLE with every stiffness, where blocks feel little, or much more than their load.

        Joints are then softer in proportion, or slip later. None where there are no such blocks, or
        where it is not shown. What a block feels is at first taken from any forces that balance the
        loads: on uniform springs heavy blocks that turn may throw it away.
        """
        if self.problem.statics.felt is not None:
            return None  # this is such a try
        force, options = uniform.force, replace(self.options, settle=False, uniform=False)
        if self.nearest is not None and not uniform.stands:
            force = self.problem.force(self.nearest.force)
        for _ in range(ROUNDS):
            problem = self.problem.with_felt(force)
            if problem is None or self.clock.late():
                return None
            inner = Cascade(
                problem,
                options,
                self.answers.progress,
                self.clock,
                self.pool.executor,
                within=self.within,
                robust=True,
                nearest=self.nearest,
            )
            found = inner.run()
            self.answers.iterations += found.iterations
            if found.stable and inner.robustly:
                self.attempts, self.rests = inner.attempts, inner.rests
                return replace(found, options=self.options)
            force = inner.uniform.force
        return None

    @cached_property
    def uniform(self) -> Candidate:
        """The answer of uniform contact stiffness."""
        self.answers.report("rest state", 0)
        if self._nearby is not None:
            return self._nearby
        if self.tried.uniform is not None:
            self.attempts.add(Record([self.tried.uniform], tried=1))
            return self.tried.uniform
        # without friction equilibrium decides
        much = MUCH if self.problem.statics.friction.any() else CLEARLY
        springs = compliance.uniform(self.problem.statics)
        found = self.attempts.attempt(springs, falls=lambda: self.collapse is not None, much=much)
        if found.stands:
            self.tried.uniform = found
        return found

    @cached_property
    def _nearby(self) -> Candidate | None:
        """The rest state of uniform stiffness near a known one, or one that was found before."""
        if self.attempts.standing:
            return self.attempts.standing[0]
        if 0 not in self.known or not self.problem.statics.dry:
            return None
        springs = compliance.uniform(self.problem.statics)
        found = self.attempts.nearby(springs, self.attempts.start(springs, self.known[0]))
        return found or self._smooth_nearby(springs)

    @property
    def robustly(self) -> bool:
        """Whether each stiffness that was tried stands, without sliding far."""
        attempts = self.attempts
        if not attempts.standing or len(attempts.standing) < attempts.tried:
            return False
        like_settlement = self.rests.get(1)
        if like_settlement is None or not self.problem.statics.dry:
            return True
        if not len(like_settlement):
            return False  # it was stopped before
        return self.problem.slide_by_overlap(like_settlement) <= SLIDES_FAR

    def _settles_alike(self) -> bool:
        """Whether the blocks slide on the way on which those of a similar model came to rest."""
        here, followed = self.rests.get(1), self.known.get(FOLLOWED)
        if here is None or followed is None or not len(here):
            return False
        return self.problem.slide_beyond(here, followed) <= SLIDES_FAR

    def _smooth_nearby(self, springs: Compliance) -> Candidate | None:
        """The rest state of a smooth law near the known one; none where stick-slip shows a fall.

        A check from nothing accepts it as well. It follows stick-slip for longer before.
        """
        problem, attempts = self.problem, self.attempts
        smooth = compliance.uniform(problem.statics, slip=SLIP_LENGTH)
        tries = Attempts(problem, self.clock)
        found = tries.nearby(smooth, tries.start(smooth, self.known[0]))
        if found is None:
            return None
        quickly = tries.attempt(springs, QUICK, again=True)
        attempts.iterations += tries.iterations
        if tries.falling:
            return None
        if quickly.stands:
            found = quickly
        attempts.tried += 1
        attempts.standing.append(found)
        return found

    def _other_stiffnesses(self, uniform: Candidate) -> None:
        """Rest states for the samples of the stiffness, once.

        Without friction the motion of a joint is normal to its limits. Then all stiffnesses give
        the same answer (static theorem of limit analysis).
        """
        attempts, statics = self.attempts, self.problem.statics
        if attempts.tried > 1 or (uniform.stands and not statics.friction.any()):
            return
        if not self.options.samples:
            return
        samples = samples_to_try(
            attempts, self.options, uniform, self.known, self.within, self.tried
        )
        self.answers.report("stiffness samples", 2)
        lead = self.options.uniform
        task = partial(attempt_sample, self.problem, self.clock, lead)
        tried = self.pool.answers(task, samples, self.clock.late)
        for number, record in enumerate(tried, start=1):
            attempts.add(record)
            self.answers.report("stiffness samples", 2 + number)
            if record.standing:
                self.rests[number] = record.standing[0].displacement
                continue
            whole = not samples[number - 1].briefly and not self.clock.late()
            if whole and uniform is self.tried.uniform:
                self.tried.failed[number] = record
            if self.options.uniform or self.robust or not self.witness:
                # settlement decides, or nothing is left
                self.rests[number] = NONE_FOUND
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
        falling, acceleration = problem.unpressed, problem.acceleration
        assembly, contacts = problem.model.assembly, problem.model.contacts
        if not falling.any():
            return None
        apart = beside_supports(assembly, contacts, falling)
        follows = self.options.settle and problem.statics.dry
        if not follows and not apart:
            return None
        if follows:
            surely = apart and unpressed(assembly, contacts, acceleration, NO_APPROACH).all(
                where=falling
            )
            if not apart and self._caught(falling):
                return None
            why = "hardly anything presses on some of its blocks at first"
            # a plug that hardly tapers presses more and more on a long way
            followed = None if surely else self._follow(settle)
            if followed is not None and followed.outcome is Outcome.RESTS:
                return self.answers.rests(followed, why)
            if followed is not None and followed.outcome is Outcome.ENDS_DECIDE:
                return self.answers.undecided(followed, why)
            if followed is not None and followed.outcome is Outcome.UNKNOWN and not apart:
                return None
        rest = problem.without(falling)
        if rest is not None:
            part = Cascade(rest, self.options, None, self.clock, self.pool.executor).run()
            self.answers.iterations += part.iterations
            if part.verdict is not Verdict.STABLE:
                return None
        motion = np.where(falling[:, None], acceleration, 0.0)
        return self.answers.answer(
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
    def _follow(self, follow: Callable[..., Settlement] = settle_for_verdict) -> Settlement:
        """The motion of the blocks by finite steps."""
        if self.settlement is None:
            self.answers.report("settlement", 2 + self.options.samples)
            model, options = self.problem.model, self.options.settlement
            self.settlement = follow(
                model, options=options, executor=self.pool.executor, stop=self.clock.late
            )
            self.answers.iterations += sum(path.iterations for path in self.settlement.paths)
        return self.settlement

    def _followed(self, uniform: Candidate) -> Result:
        """The verdict of finite steps, where the contact stiffness decides."""
        found = self._follow()
        doubted = [number for number, near in self.known.items() if not len(near)]
        if doubted and found.outcome is not Outcome.RESTS and uniform.stands:
            self.known = {n: near for n, near in self.known.items() if n not in doubted}
            del self.attempts.standing[1:]
            self.attempts.tried = 1
            self._other_stiffnesses(uniform)
            if self.robustly:
                return self.answers.stable(uniform)
        moves = found.outcome in (Outcome.FALLS, Outcome.DISPLACED)
        told = not moves or not self.witness or self._first_motion() is not None
        if found.outcome is Outcome.UNKNOWN or not told:
            self._other_stiffnesses(uniform)
        stood, tried = len(self.attempts.standing), self.attempts.tried
        held = f"{stood or 'none'} of {tried} contact stiffnesses tried would hold it in place"
        if tried == 1:
            held = "uniform contact stiffness would not hold it in place"
        if found.outcome is Outcome.RESTS:
            if len(self.rests.get(1, NONE_FOUND)):
                self.rests[FOLLOWED] = self.rests[1]
            # that it slides far was the only doubt
            certain = uniform.stands and stood == tried
            return self.answers.stable(uniform) if certain else self.answers.rests(found, held)
        if found.outcome is Outcome.UNKNOWN and not stood and tried > self.options.samples:
            return replace(self.answers.first_motion(), settlement=found)
        if not moves:
            return self.answers.undecided(found, held)
        motion = self._first_motion()
        if motion is None:
            motion = self.problem.normalised(found.displacement)
        words = f"{found.message}; {held}: {SENSITIVE}"
        if not stood and self.answers.balances:
            words = f"{NOT_REACHED}; {found.message}; shims or prestress might hold it: {SENSITIVE}"
        return replace(self.answers.unstable(words, motion), settlement=found)

    def _first_motion(self) -> Floats | None:
        """The first motion (n, 6) of a state on ground springs; None where there is none."""
        motions = (first_motion(self.problem, one.state) for one in self.attempts.falling)
        return next((one for one in motions if one is not None), None)

    @cached_property
    def collapse(self) -> Floats | None:
        """The collapse mechanism (n, 6); None if forces balance the loads, or if none was found."""
        self.answers.report("equilibrium", 1)
        if self.problem.statics.dry:
            nearest = self.nearest
            if nearest is None:
                nearest = nearest_mechanism(self.problem.system, stop=self.clock.late)
                self.nearest = nearest
            self.answers.iterations += nearest.iterations
            if nearest.motion is not None:
                motion = sound_mechanism(self.problem, nearest.motion)
                if motion is not None:
                    self.answers.left = nearest.force
                    return motion
            elif balanced(self.problem, nearest.force):
                self.answers.balances = True
                return None
        balance = solve_equilibrium(
            self.problem.statics,
            cone=FrictionCone.exact(),
            options=ConicOptions(gap=ANY_FORCES, time_limit_s=self.clock.left_s),
            stop=self.clock.late,
        )
        self.answers.iterations += balance.raw.iterations
        self.answers.balances = balance.raw.status is ConicStatus.SOLVED
        if self.answers.balances:
            return None
        return found_mechanism(self.problem, balance, self.clock.late)

    def _search(self) -> Result | None:
        """STABLE with a state by convex steps, with the least difference of stiffness that works.

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
            pool=self.pool,
        )
        try:
            reduce = self.options.reduce_ratio
            for state in look.states(self.options.stiffness_ratio, reduce=reduce):
                candidate = self._answering(look, state)
                if candidate is not None:
                    equal = self._with_equal_overlap(look, state) if reduce else None
                    ratio = stiffness_ratio(self.problem.statics, state)
                    best, ratio = (candidate, ratio) if equal is None else equal
                    return self.answers.sensitive(best, ratio, equal_overlap=equal is not None)
            return None
        finally:
            self.answers.iterations += look.iterations

    def _answering(self, look: StateSearch, state: CompatibleState) -> Candidate | None:
        """The state as a proof that it stands, if it is one."""
        if look.slide(state) > SLIDE_LIMIT:
            return None
        candidate = self.attempts.examine(state.motion, state.force)
        return candidate if candidate.stands else None

    def _with_equal_overlap(
        self, look: StateSearch, state: CompatibleState
    ) -> tuple[Candidate, float] | None:
        """The nearest state of eq. 5.6 and its stiffness ratio, if that is within the bound.

        Equal overlaps do not mean equal stiffnesses: these differ like the forces.
        """
        equal = look.equal_overlap(state.motion)
        ratio = stiffness_ratio(self.problem.statics, equal)
        if ratio > self.options.stiffness_ratio * ROUNDING:
            return None
        candidate = self._answering(look, equal)
        return None if candidate is None else (candidate, ratio)
