"""Rest states for assumed contact stiffnesses, as proofs of standing or signs of falling."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.progress import Clock
from drystone.checks import check_forces
from drystone.formulations.rest.compliance import Compliance
from drystone.formulations.rest.interior_point import POLISH_AGAIN, find_rest
from drystone.formulations.rest.nearby import find_rest_nearby
from drystone.formulations.rest.rest_state import RestOptions, RestState, Start, start_from
from drystone.formulations.rest.same_forces import relaxed_again
from drystone.results import Residuals
from drystone.stability.problem import Problem
from drystone.stability.proofs import FORCE_TOLERANCE, first_motion
from drystone.stability.screening import AT_REST, PATIENT, Screening

SHARPER = RestOptions(ground=1e-9, tolerance=1e-6)
"""Weaker ground for first motions: close to the limit they are slow, and weaker ground changes them
less."""

LEAST_GROUND = replace(AT_REST, ground=1e-17)
"""For high towers. They sway so far that the ground of AT_REST carries more than a proof allows:
4e-8 of the load of a block with 400 cubes."""

NEARLY = 1e-7
"""Unbalanced share of a block at which weaker ground may still give a proof: with 400 cubes
rounding alone leaves 3e-10."""

FALLS_FROM = 1e-4
"""Share of a block's load on the ground from which on it falls."""

CLEARLY = 1e-3
"""Share of a block's load on the ground from which on a screening level that is not patient ends,
and weaker ground is not tried where the state is a first motion. Measured: walls, domes and vaults
of up to 2,000 blocks at rest, tilted or not, 5e-5 at most; thin lunes at rest 2e-4; structures
beyond their limit 4e-3 or more. Towers of 200 blocks and more reach 4e-3 although they stand."""

MUCH = 1e-2
"""Share of a block's load on the ground from which on equilibrium is tested before weaker ground is
tried: more than in any structure that stands."""


def after_newton(options: RestOptions) -> RestOptions:
    """Options for a start from which Newton's method on the unrelaxed law was tried already."""
    return replace(options, polish=POLISH_AGAIN * options.warm_relaxation)


@dataclass(frozen=True, eq=False)
class Candidate:
    """Forces and a motion that may prove that the model stands.

    Attributes
    ----------
    force : (k, 3) [N]
    displacement : (n, 6) [m, rad]
    residuals
    path
        The last iterate of the relaxed law before it, or such an iterate at it, from which similar
        springs may begin.
    """

    force: Floats
    displacement: Floats
    residuals: Residuals
    path: Start | None = None

    @property
    def stands(self) -> bool:
        """Whether every residual is small enough for a proof."""
        return self.residuals.largest <= FORCE_TOLERANCE


@dataclass(frozen=True, eq=False)
class Falling:
    """A state with forces in the ground springs, and its contact stiffnesses.

    Attributes
    ----------
    state
    springs
    force : (k, 3) [N]
    residuals
    """

    state: RestState
    springs: Compliance
    force: Floats
    residuals: Residuals

    @property
    def ground(self) -> Floats:
        """(n, 6) scaled wrench of the ground springs."""
        return self.state.ground


@dataclass(eq=False)
class Record:
    """What came of some tries.

    Attributes
    ----------
    standing, falling
        Tries that prove that it stands, and tries that show that it falls; other tries have no
        result.
    stalled : (n, 6) each
        Scaled motions at which the iteration ended without converging although the ground springs
        carried less than a thousandth of the load. The search starts from them.
    tried
        Number of stiffness distributions, without interrupted ones.
    iterations
        Newton steps so far.
    checking_s : [s]
        Time spent on residuals.
    """

    standing: list[Candidate] = field(default_factory=list)
    falling: list[Falling] = field(default_factory=list)
    stalled: list[Floats] = field(default_factory=list)
    tried: int = 0
    iterations: int = 0
    checking_s: float = 0.0

    def add(self, other: Record) -> None:
        """Add what came of further tries."""
        for each in fields(Record):
            setattr(self, each.name, getattr(self, each.name) + getattr(other, each.name))


class Attempts(Record):
    """The tries on one model and their results."""

    def __init__(self, problem: Problem, clock: Clock) -> None:
        super().__init__()
        self.problem = problem
        self.clock = clock

    def attempt(
        self,
        springs: Compliance,
        screening: Screening = PATIENT,
        *,
        again: bool = False,
        start: Start | None = None,
        falls: Callable[[], bool] | None = None,
        much: float = MUCH,
    ) -> Candidate:
        """Follow one stiffness distribution to rest.

        Parameters
        ----------
        springs, screening
        again
            Whether it does not count as tried.
        start
            From which Newton's method on the unrelaxed law does not converge.
        falls
            Whether it falls with every stiffness; called where the ground carries a large share,
            and where the first path makes no progress or does not converge.
        much
            That share.
        """
        numerics = screening.numerics
        # at the beginning of a path steps are often reduced
        begun = start is not None
        numerics = after_newton(numerics) if begun else replace(numerics, give_up=0.0)
        state = self.find(springs, numerics, start, falls)
        share = self.problem.ground_share(state.ground)
        most = share.max()
        rests = state.converged and most < CLEARLY
        over = most >= 0.5 or not (screening.patient or rests)
        if not over and state.converged and most >= CLEARLY:
            # high towers load this ground as much, and reach a rest state on weaker ground
            over = first_motion(self.problem, state) is not None
        if not over and falls is not None and (most >= much or not state.converged):
            # weaker ground helps hardly ever then: in none of 47 piles, arches and domes
            over = falls()
        final = state if over or state.ended else self.find(springs, AT_REST, state)
        candidate = self.examine(final.motion, final.force)
        if state.ended and not (over or candidate.stands):
            final = self.find(springs, AT_REST, state)
            candidate = self.examine(final.motion, final.force)
        nearly = not (over or candidate.stands) and final.unbalanced < NEARLY
        if nearly and self.problem.ground_share(final.ground).max() < CLEARLY:
            final = self.find(springs, LEAST_GROUND, final)
            candidate = self.examine(final.motion, final.force)
        falling = state.converged and most > FALLS_FROM
        if not again and (candidate.stands or falling or not self.clock.late()):
            self.tried += 1
        if candidate.stands:
            candidate = replace(candidate, path=state.before)
            self.standing.append(candidate)
        elif falling:
            self.falling.append(Falling(state, springs, candidate.force, candidate.residuals))
        elif min(most, self.problem.ground_share(final.ground).max()) < CLEARLY:
            self.stalled.append(state.motion)
            if not over:
                self.stalled.append(final.motion)
        return candidate

    def start(self, springs: Compliance, displacement: Floats) -> Start:
        """A start at displacements (n, 6) [m, rad], such as those of a similar model.

        Raises
        ------
        InputError
            They have another shape, or are not finite.
        """
        count = len(self.problem.model.assembly)
        if np.shape(displacement) != (count, 6) or not np.isfinite(displacement).all():
            raise InputError(f"the start must hold {count} times six finite numbers", where="start")
        statics = self.problem.statics
        motion = statics.scaled_motion(np.asarray(displacement), statics.mean_length)
        return start_from(self.problem.system, springs, motion)

    def nearby(
        self,
        springs: Compliance,
        start: Start,
        options: RestOptions = AT_REST,
        *,
        onwards: bool = True,
    ) -> Candidate | None:
        """The rest state near a start, if there is one and it stands.

        With ``onwards``, other springs may begin on its path.
        """
        state = find_rest_nearby(self.problem.system, springs, options, start, self.clock.late)
        if state is None:
            return None
        self.iterations += state.iterations
        found = self.stood(state)
        if found is None or not (onwards and self.problem.statics.dry):
            return found
        return replace(found, path=relaxed_again(self.problem.statics, springs, state))

    def stood(self, state: RestState) -> Candidate | None:
        """A state counted as a rest state that was found, if it is one."""
        candidate = self.examine(state.motion, state.force)
        if not candidate.stands:
            return None
        self.tried += 1
        self.standing.append(candidate)
        return candidate

    def examine(self, motion: Floats, force: Floats) -> Candidate:
        """Scaled motion and forces in physical numbers, with their residuals."""
        problem = self.problem
        began = self.clock.elapsed_s
        physical = problem.force(force)
        displacement = problem.displacement(motion)
        residuals = check_forces(problem.model, physical, displacement)
        self.checking_s += self.clock.elapsed_s - began
        return Candidate(physical, displacement, residuals)

    def falling_states(self) -> Iterator[RestState]:
        """The states on ground springs without rest, then the same on weaker springs."""
        for trial in self.falling:
            yield trial.state
        for trial in self.falling:
            if not self.clock.late():
                yield self.find(trial.springs, SHARPER)

    def find(
        self,
        springs: Compliance,
        options: RestOptions,
        start: RestState | Start | None = None,
        falls: Callable[[], bool] | None = None,
    ) -> RestState:
        """A state on ground springs."""
        system, late = self.problem.system, self.clock.late
        state = find_rest(system, springs, options, start=start, stop=late, falls=falls)
        self.iterations += state.iterations
        return state
