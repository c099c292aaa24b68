"""Rest states for assumed contact stiffnesses, as proofs of standing or signs of falling."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError, SolverError
from drystone.base.progress import Clock
from drystone.checks import check_forces
from drystone.formulations.rest.compliance import Compliance
from drystone.formulations.rest.friction import SlipLength
from drystone.formulations.rest.interior_point import POLISH_AGAIN, find_rest
from drystone.formulations.rest.nearby import find_rest_nearby
from drystone.formulations.rest.rest_state import RestOptions, RestState, Start, start_from
from drystone.formulations.rest.same_forces import (
    FAR,
    relaxed_again,
    sliding_share,
    start_of_forces,
    unbalanced_share,
)
from drystone.results import Residuals
from drystone.stability.problem import Problem
from drystone.stability.proofs import FORCE_TOLERANCE, first_motion
from drystone.stability.screening import PATIENT, Screening

SHARPER = RestOptions(ground=1e-9, tolerance=1e-6)
"""Weaker ground for first motions: close to the limit they are slow, and weaker ground changes them
less."""

AT_REST = RestOptions(ground=1e-14, iteration_limit=30, warm_relaxation=1e-8)
"""Ground so weak that its forces are below every tolerance."""

LEAST_GROUND = replace(AT_REST, ground=1e-17)
"""For high towers. They sway so far that the ground of AT_REST carries more than a proof allows:
4e-8 of the load of a block with 400 cubes."""

FROM_FORCES = replace(AT_REST, tolerance=3e-9)
"""From the forces of another rest state: a third of what a proof allows. Measured on eleven models:
1.70 in place of 1.75 times the factorisations of the uniform stiffness, and a tenth fewer
solutions."""

NEARLY = 1e-7
"""Unbalanced share of a block at which weaker ground may still give a proof: with 400 cubes
rounding alone leaves 3e-10."""

STRAIGHT = replace(AT_REST, iteration_limit=16)
"""From nothing, where the model stands with other stiffnesses: no state on stronger ground is
needed. Measured: far from the limits of their models 8 to 13 steps lead so near that the unrelaxed
law converges. Very near the limits it takes 40, and stronger ground saves some."""

FROM_OTHER = replace(AT_REST, warm_relaxation=1e-4, stall=8, give_up=0.02)
"""From the rest state of other stiffnesses: given up early. Measured: where it converges, on walls
and domes, it takes 6 to 16 steps, from nothing 12 to 18; elsewhere it ends after 3 or 4."""

FROM_PATH = replace(AT_REST, stall=8, give_up=0.02)
"""From the last iterate of the relaxed law with uniform stiffness. With another friction law
Newton's method on the unrelaxed law converges after one to three steps there."""

SLOW = 0.35
"""Share of the merit function after two such steps from which on other normal stiffnesses begin
from nothing. Measured on 15 arches, walls, vaults and domes: 650 factorisations for all stiffnesses
in place of 667 without it, and of 717 without starts on the path."""

HALFWAY = 0.3
"""Unbalanced share of a block up to which the relaxed law begins there, where Newton's method did
not converge."""

NEARLY_RESTS = 0.01
"""Unbalanced share of a block up to which other springs begin at the rest state itself, in place of
its forces. Walls at rest slide nowhere: with every friction law they rest there at once."""

FEW_SLIDE = 0.02
"""Share of the normal force at corners that slide up to which they begin there as well. Where all
stick, the first step of Newton's method is exact. Measured on 11 models, tilted or not: up to 0.019
it takes 0 to 2 factorisations, from the forces 2 to 4; from 0.028 on up to 23, from them 3."""

SHARES = (0.0, 0.5, 1.0)
"""Steps of the stiffness, by the logarithm, from the uniform one to another. Measured on the
bridge and on vaults: of 8 rest states that were not found from the uniform one at once or from
nothing, all are found, in a tenth of the time that it takes to follow the blocks."""

LONGER = (10.0, 3.0)
"""Slip lengths, by its own, that lead to a law whose path did not converge. Chosen: each rest state
of an arch of 100 blocks near its least thickness is then four to seven steps from the last one."""

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


def _after_newton(options: RestOptions) -> RestOptions:
    """Options for a start from which Newton's method on the unrelaxed law was tried already."""
    return replace(options, polish=POLISH_AGAIN * options.warm_relaxation)


def _on_path(start: Start, same: bool) -> RestOptions:
    """Options for an iterate of the relaxed law, with the same normal stiffnesses or others."""
    below = 0.5 * (start.relaxation or 1.0)
    return replace(FROM_PATH, polish=below, slow=np.inf if same else SLOW)


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


class Rest(NamedTuple):
    """A rest state from which another one begins.

    Attributes
    ----------
    displacement : (n, 6) [m, rad]
    same
        Whether the normal stiffnesses are the same. Newton's method on the unrelaxed law reaches
        the other one then in a few steps, or it stops soon.
    path
        The last iterate of the relaxed law before it.
    """

    displacement: Floats
    same: bool
    path: Start | None = None


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
        numerics = _after_newton(numerics) if begun else replace(numerics, give_up=0.0)
        state = self._rest(springs, numerics, start, falls)
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
        final = state if over else self._rest(springs, AT_REST, state)
        candidate = self.examine(final.motion, final.force)
        nearly = not (over or candidate.stands) and final.unbalanced < NEARLY
        if nearly and self.problem.ground_share(final.ground).max() < CLEARLY:
            final = self._rest(springs, LEAST_GROUND, final)
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
        found = self._stood(state)
        if found is None or not (onwards and self.problem.statics.dry):
            return found
        return replace(found, path=relaxed_again(self.problem.statics, springs, state))

    def attempt_from(
        self,
        springs: Compliance,
        rests: Sequence[Rest],
        *,
        lead: bool = False,
        briefly: bool = False,
    ) -> Candidate:
        """As :meth:`attempt`, first from similar rest states.

        With ``lead``, where nothing is found from nothing either, the last of them, of uniform
        stiffness, is led to these springs. ``briefly``: from those states only.
        """
        for one in rests:
            if one.same and not one.path:
                start = self.start(springs, one.displacement)
                found = self.nearby(springs, start, onwards=False)
                if found is not None:
                    return found
        if rests:
            displacement, same, path = rests[-1]
            ways: list[tuple[RestOptions, Start | None]] = []
            if path and not briefly:
                near, onwards = self._with_forces(springs, path, displacement if same else None)
                if near is not None:
                    return near
                ways = [(_on_path(onwards, same), onwards), (STRAIGHT, None)]
            from_other = _after_newton(FROM_OTHER) if same and not path else FROM_OTHER
            ways.append((from_other, self.start(springs, displacement)))
            if not path and not briefly:
                ways.append((STRAIGHT, None))
            for options, begin in ways:
                state = self._rest(springs, options, begin)
                found = self._stood(state) if state.converged else None
                if found is not None:
                    return found
            if briefly:
                self.tried += 1
                return self.examine(state.motion, state.force)
        afresh = Attempts(self.problem, self.clock)
        found = afresh.attempt(springs)
        if lead and rests and not (found.stands or rests[-1].same):
            led = self._led(springs, rests[-1].displacement)
            if led is not None:
                self.iterations += afresh.iterations
                return led
        self.add(afresh)
        if found.stands or afresh.falling or self.clock.late():
            return found
        return self._by_longer_slips(springs) or found

    def _with_forces(
        self, springs: Compliance, path: Start, rest: Floats | None
    ) -> tuple[Candidate | None, Start]:
        """The rest state that Newton's method reaches from the forces of another one.

        Where these springs nearly rest at the displacement (n, 6) [m, rad] of the other ``rest``
        state, or stick there, it begins there. With the start for the relaxed law where it does not
        converge.
        """
        system = self.problem.system
        if rest is not None:
            start = self.start(springs, rest)
            moved = system.statics.displacement(start.motion)
            nearly = unbalanced_share(system, springs, moved) <= NEARLY_RESTS
            if nearly or sliding_share(springs, moved) <= FEW_SLIDE:
                found = self.nearby(springs, start, FROM_FORCES, onwards=False)
                if found is not None or nearly:
                    return found, path
        try:
            start, steps, share = start_of_forces(system, springs, AT_REST, path)
        except SolverError:
            return None, path
        self.iterations += steps
        if share > FAR:
            return None, path
        found = self.nearby(springs, start, FROM_FORCES, onwards=False)
        return found, start if share <= HALFWAY else path

    def _by_longer_slips(self, springs: Compliance) -> Candidate | None:
        """The rest state where a path from nothing did not converge, from those of longer slips.

        With a longer slip friction changes more smoothly, and each rest state is a few steps from
        the next one.
        """
        law = springs.friction
        if not isinstance(law, SlipLength):
            return None
        state: RestState | None = None
        for factor in (*LONGER, 1.0):
            smoother = replace(springs, friction=replace(law, slip=factor * law.slip))
            state = self._rest(smoother, AT_REST, state)
            if not state.converged:
                return None
        candidate = None if state is None else self.examine(state.motion, state.force)
        if candidate is None or not candidate.stands:
            return None
        self.standing.append(candidate)
        return candidate

    def _led(self, springs: Compliance, displacement: Floats) -> Candidate | None:
        """The rest state to which one of uniform stiffness leads while the stiffness changes."""
        base = self.problem.statics.normal_stiffness
        for share in SHARES:
            between = replace(springs, normal=base ** (1.0 - share) * springs.normal**share)
            state = self._rest(between, AT_REST, self.start(between, displacement))
            candidate = self.examine(state.motion, state.force)
            if not candidate.stands:
                return None
            displacement = candidate.displacement
        return self._stood(state)

    def _stood(self, state: RestState) -> Candidate | None:
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
                yield self._rest(trial.springs, SHARPER)

    def _rest(
        self,
        springs: Compliance,
        options: RestOptions,
        start: RestState | Start | None = None,
        falls: Callable[[], bool] | None = None,
    ) -> RestState:
        system, late = self.problem.system, self.clock.late
        state = find_rest(system, springs, options, start=start, stop=late, falls=falls)
        self.iterations += state.iterations
        return state
