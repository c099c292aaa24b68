"""The verdict: a cascade that ends with forces and a motion, or with a proof that it falls."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from drystone.assembly import Assembly
from drystone.checks import check_forces
from drystone.contacts import Contacts
from drystone.formulations import compliance
from drystone.formulations.compatible import compatible_motion, improve
from drystone.formulations.compliance import Compliance
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import EquilibriumSolution, solve_equilibrium
from drystone.formulations.rest import RestOptions, RestState, find_rest
from drystone.geometry.arrays import Bools, Floats
from drystone.loads import LoadCase
from drystone.progress import Progress
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.stability.problem import Clock, Problem
from drystone.stability.proofs import (
    FALLING_SHARE,
    FORCE_TOLERANCE,
    checked_mechanism,
    free_acceleration,
    is_first_motion,
    moving_blocks,
    unpressed,
)

TRIES_LIMIT = 400
"""Corners up to which the search also starts from random parts of the corners. Chosen: a start
takes less than a tenth of a second there."""

SEARCH_LIMIT = 4000
"""Corners up to which a rest state is searched for by convex steps where sampled stiffnesses find
none. Chosen: one step takes about a second there."""

SLIDE_LIMIT = 2500.0
"""eta / eps: largest displacement by the overlap of a state that the search may answer with. The
source uses up to 1000; where two ways to slide meet a state needs a little more."""

TO_REST = RestOptions(ground=1e-7, tolerance=1e-7, iteration_limit=60)
"""A first look: with this ground a rest state leans on it by parts in a million of the load."""

SHARPER = RestOptions(ground=1e-9, tolerance=1e-6)
"""A first motion close to the limit is slow, and blurred less by weaker ground."""

AT_REST = RestOptions(ground=1e-14, iteration_limit=30, warm_relaxation=1e-6)
"""The state itself: what the ground still carries is below every tolerance."""


@dataclass(frozen=True)
class CheckOptions:
    """Options of :func:`check`.

    Attributes
    ----------
    samples
        Stiffness distributions tried beyond the uniform one, to tell robust from sensitive and to
        find a rest state where uniform stiffness has none.
    search
        Look for a rest state by convex steps where no sample has one.
    search_tries
        Random parts of the corners from which the search starts on small models.
    seed
        Of the random stiffness distributions.
    time_limit_s
        After it the answer is given from what is known by then.
    """

    samples: int = 4
    search: bool = True
    search_tries: int = 8
    seed: int = 0
    time_limit_s: float = float("inf")


def check(
    assembly: Assembly,
    contacts: Contacts,
    load: LoadCase | None = None,
    *,
    options: CheckOptions | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> Result:
    """Does the assembly stand by contact and friction alone, without prestress?

    Parameters
    ----------
    assembly
    contacts
    load
        Gravity along -z when left out.
    options
    progress
    stop
        Asked often; True ends the analysis with what is known, like the time limit.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion that pass every check; UNSTABLE with a mechanism;
        UNDECIDED with what was tried. ``samples`` tells how many of the assumed contact
        stiffnesses let it come to rest.

    Raises
    ------
    InputError
        Load or contacts of another assembly.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import arch
    >>> assembly = arch(0.15)
    >>> contacts = drystone.find_contacts(assembly, friction=0.9).contacts
    >>> drystone.check(assembly, contacts).verdict
    <Verdict.STABLE: 'stable'>
    """
    chosen = options if options is not None else CheckOptions()
    clock = Clock(chosen.time_limit_s, stop)
    return _Check(Problem.build(assembly, contacts, load), chosen, progress, clock).run()


@dataclass(frozen=True, eq=False)
class _Candidate:
    """Forces and a motion that may prove that it stands, or a state that shows it falling."""

    force: Floats
    displacement: Floats
    residuals: Residuals
    state: RestState | None = None
    springs: Compliance | None = None

    @property
    def stands(self) -> bool:
        return self.residuals.largest <= FORCE_TOLERANCE


class _Check:
    """The cascade: free fall, rest, impossibility, other stiffnesses, search, first motion."""

    def __init__(
        self, problem: Problem, options: CheckOptions, progress: Progress | None, clock: Clock
    ) -> None:
        self.problem = problem
        self.options = options
        self.progress = progress
        self.clock = clock
        self.iterations = 0
        self.checking_s = 0.0
        self.tried = 0
        self.unequal = False
        self.standing: list[_Candidate] = []
        self.falling: list[_Candidate] = []

    def run(self) -> Result:
        problem = self.problem
        if problem.statics.free_count == 0:
            return self.nothing_free()
        dropped = self.free_fall()
        if dropped is not None:
            return dropped
        self.report("rest state", 0)
        uniform = self.attempt(compliance.uniform(problem.statics))
        if not uniform.stands:
            self.report("equilibrium", 1)
            impossible = self.impossible()
            if impossible is not None:
                return impossible
        for number, sample in enumerate(self.samples()):
            self.report("stiffness samples", 2 + number)
            self.attempt(sample)
        if self.standing:
            return self.stable(uniform)
        self.report("search", 2 + self.options.samples)
        found = self.search()
        if found is not None:
            return self.sensitive(found)
        return self.first_motion()

    # -- the steps ------------------------------------------------------------------------------
    def samples(self) -> Iterator[Compliance]:
        for sample in compliance.samples(
            self.problem.statics, self.options.samples, self.options.seed
        ):
            if self.clock.late():
                return
            yield sample

    def attempt(self, springs: Compliance) -> _Candidate:
        """One stiffness distribution, followed to its end."""
        problem = self.problem
        system = problem.system
        self.tried += 1
        state = find_rest(system, springs, TO_REST, stop=self.clock.late)
        self.iterations += state.iterations
        share = problem.ground_share(state.ground)
        final = state
        if share.max() < 0.5:
            final = find_rest(system, springs, AT_REST, start=state, stop=self.clock.late)
            self.iterations += final.iterations
        candidate = replace(self.examine(final.motion, final.force), state=state, springs=springs)
        if candidate.stands:
            self.standing.append(candidate)
        elif state.converged and share.max() > 1e-4:
            self.falling.append(candidate)
        return candidate

    def examine(self, motion: Floats, force: Floats) -> _Candidate:
        """Scaled motion and forces in physical numbers, with their residuals."""
        problem = self.problem
        began = self.clock.elapsed_s
        physical = problem.force(force)
        displacement = problem.displacement(motion)
        residuals = check_forces(
            problem.assembly, problem.contacts, problem.load, physical, displacement
        )
        self.checking_s += self.clock.elapsed_s - began
        return _Candidate(physical, displacement, residuals)

    def free_fall(self) -> Result | None:
        """UNSTABLE when the loads press some blocks against nothing and the others stand.

        Contact forces answer pressing. Blocks that the loads accelerate without approaching any
        corner feel none, at whatever friction: a block between two vertical walls falls, although
        forces that nothing provides could hold it.
        """
        problem = self.problem
        assembly = problem.assembly
        acceleration = free_acceleration(problem)
        falling = unpressed(assembly, problem.contacts, acceleration)
        if not falling.any():
            return None
        others = np.flatnonzero(~falling)
        if not assembly.fixed[others].all():
            part = check(
                assembly.subset(others.tolist()),
                problem.contacts.of_blocks(others, len(assembly)),
                LoadCase(problem.load.wrench[others]),
                options=replace(self.options, time_limit_s=self.clock.left_s),
                stop=self.clock.wish,
            )
            self.iterations += part.iterations
            if part.verdict is not Verdict.STABLE:
                return None
        motion = np.where(falling[:, None], acceleration, 0.0)
        return self.answer(
            Verdict.UNSTABLE,
            "nothing presses on the blocks that fall, so nothing holds them",
            mechanism=problem.normalised(motion),
            prop=np.where(falling[:, None], -problem.load.wrench, 0.0),
            falling=tuple(int(i) for i in np.flatnonzero(falling)),
        )

    def impossible(self) -> Result | None:
        """UNSTABLE when no contact forces balance the loads, with the mechanism."""
        self.balance = solve_equilibrium(
            self.problem.statics,
            cone=FrictionCone.exact(),
            options=ConicOptions(time_limit_s=self.clock.left_s),
        )
        self.iterations += self.balance.raw.iterations
        if self.balance.raw.status is ConicStatus.SOLVED:
            return None
        mechanism = checked_mechanism(self.problem, self.balance)
        if mechanism is None:
            return None
        return self.unstable("no contact forces can balance the loads", mechanism)

    def search(self) -> _Candidate | None:
        """A state of eq. 5.6 by convex steps from the pressed corners, or from balanced forces.

        Equal overlaps are asked for: with any stiffness at any corner almost every wedge can be
        held by forces that only prestress brings about.
        """
        problem = self.problem
        statics = problem.statics
        if not self.options.search or statics.corner_count > SEARCH_LIMIT or self.clock.late():
            return None
        for motion in self.search_starts():
            if motion is None or self.clock.late():
                continue
            found = improve(statics, motion, stop=self.clock.late)
            self.iterations += found.iterations
            if not self.examine(found.motion, found.force).stands:
                continue
            self.unequal = True
            level = improve(statics, found.motion, equal_overlap=True, stop=self.clock.late)
            self.iterations += level.iterations
            slide = float(np.abs(statics.displacement(level.motion)).max())
            candidate = self.examine(level.motion, level.force)
            if candidate.stands and slide <= SLIDE_LIMIT:
                return candidate
        return None

    def search_starts(self) -> Iterator[Floats | None]:
        statics = self.problem.statics
        leaning = find_rest(
            self.problem.system,
            compliance.uniform(statics, slip=1.0),
            RestOptions(ground=1e-2, tolerance=1e-6),
            stop=self.clock.late,
        )
        self.iterations += leaning.iterations
        yield leaning.motion
        pressed = statics.displacement(leaning.motion)[:, 0] < 0.0
        for corners in (pressed, np.ones_like(pressed), *self.parts_of_corners()):
            balance = self.balanced(corners)
            yield compatible_motion(statics, balance.force) if balance is not None else None

    def parts_of_corners(self) -> Iterator[Bools]:
        """Random halves, more or less, of the corners: forces on few of them differ most."""
        count = self.problem.statics.corner_count
        if count > TRIES_LIMIT:
            return
        rng = np.random.default_rng(self.options.seed)
        for _ in range(self.options.search_tries):
            part = rng.random(count) < rng.uniform(0.4, 0.9)
            if part.any():
                yield part

    def balanced(self, corners: Bools) -> EquilibriumSolution | None:
        """Forces at some of the corners that balance the loads."""
        statics = self.problem.statics
        if corners.all():
            return self.balance if self.balance.raw.status is ConicStatus.SOLVED else None
        part = solve_equilibrium(
            statics.at_corners(corners),
            cone=FrictionCone.exact(),
            options=ConicOptions(time_limit_s=self.clock.left_s),
        )
        self.iterations += part.raw.iterations
        if part.raw.status is not ConicStatus.SOLVED:
            return None
        force = np.zeros((statics.corner_count, 3))
        force[corners] = part.force
        return replace(part, force=force)

    # -- the answers ----------------------------------------------------------------------------
    def nothing_free(self) -> Result:
        corners = self.problem.contacts.corner_count
        return self.answer(
            Verdict.STABLE,
            "every block is fixed",
            force=np.zeros((corners, 3)),
            displacement=np.zeros((len(self.problem.assembly), 6)),
            residuals=Residuals(),
        )

    def stable(self, uniform: _Candidate) -> Result:
        best = uniform if uniform.stands else self.standing[0]
        robust = len(self.standing) == self.tried
        words = (
            f"stands for all {self.tried} contact stiffnesses tried"
            if robust and self.tried > 1
            else "stands"
            if robust
            else f"stands for {len(self.standing)} of {self.tried} contact stiffnesses tried: "
            "sensitive to how the joints press"
        )
        return self.answer(
            Verdict.STABLE,
            words,
            force=best.force,
            displacement=best.displacement,
            residuals=best.residuals,
        )

    def sensitive(self, found: _Candidate) -> Result:
        return self.answer(
            Verdict.STABLE,
            f"eq. 5.6 is met, but none of {self.tried} contact stiffnesses tried leads to rest: "
            "sensitive to how the joints press",
            force=found.force,
            displacement=found.displacement,
            residuals=found.residuals,
        )

    def first_motion(self) -> Result:
        problem = self.problem
        for state in self.falling_states():
            share = problem.ground_share(state.ground)
            moving = (share > FALLING_SHARE * share.max())[:, None]
            motion = problem.mechanism(np.where(moving, state.motion, 0.0))
            if is_first_motion(problem, motion):
                return self.unstable(
                    "it starts to move: only joints of very unequal stiffness could hold it"
                    if self.unequal
                    else "forces could balance the loads, but only prestress would bring them "
                    "about: it starts to move",
                    motion,
                )
        words = "the time was up" if self.clock.late() else "more samples may help"
        return self.answer(
            Verdict.UNDECIDED,
            f"no rest state in {self.tried} stiffness distributions, and no proof that there is "
            f"none; {words}",
        )

    def falling_states(self) -> Iterator[RestState]:
        """The states on ground springs that do not come to rest, then the same on weaker ones."""
        for trial in self.falling:
            if trial.state is not None:
                yield trial.state
        for trial in self.falling:
            if trial.springs is not None and not self.clock.late():
                sharp = find_rest(self.problem.system, trial.springs, SHARPER, stop=self.clock.late)
                self.iterations += sharp.iterations
                yield sharp

    def unstable(self, message: str, mechanism: Floats) -> Result:
        """With the blocks and props of the state on ground springs where there is one."""
        problem = self.problem
        falling = moving_blocks(problem.assembly, mechanism)
        prop = force = residuals = None
        if self.falling and self.falling[0].state is not None:
            trial = self.falling[0]
            ground = self.falling[0].state.ground
            share = problem.ground_share(ground)
            chosen = problem.statics.free[share > FALLING_SHARE * share.max()]
            falling = tuple(int(i) for i in chosen)
            prop = -problem.wrench(ground)
            force, residuals = trial.force, trial.residuals
        return self.answer(
            Verdict.UNSTABLE,
            message,
            mechanism=mechanism,
            prop=prop,
            force=force,
            residuals=residuals,
            falling=falling,
        )

    def answer(self, verdict: Verdict, message: str, **found: object) -> Result:
        self.report("done", 3 + self.options.samples)
        elapsed = self.clock.elapsed_s
        return Result(
            method="check",
            verdict=verdict,
            assembly=self.problem.assembly,
            contacts=self.problem.contacts,
            load=self.problem.load,
            message=message,
            samples=Samples(self.tried, len(self.standing)),
            options=self.options,
            solver="rest state by interior points",
            iterations=self.iterations,
            time_s={"solve": elapsed - self.checking_s, "check": self.checking_s},
            **found,  # type: ignore[arg-type]
        )

    def report(self, stage: str, done: int) -> None:
        if self.progress is not None:
            self.progress(stage, done, 3 + self.options.samples)
