"""One try: do given contact springs hold a model? And rest states without proofs of falling.

Screening levels: how thoroughly a rest state is looked for, from quick to full. A level that finds
one proves that the model stands. A level that finds none proves nothing: a more thorough level, or
the full analysis, may still find one.

==========  =====================================================================================
level       what it does
==========  =====================================================================================
NEAREST     follows the stick-slip law from a given start; ends at the first step that must be cut
QUICK       follows the stick-slip law; ends after a few steps without progress
PATIENT     follows the stick-slip law as far as :func:`drystone.check` does
==========  =====================================================================================
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Unpack

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.errors import InputError, SolverError
from drystone.base.settings import Clock, LongWork, Options, checked_call
from drystone.checks import FORCE_TOLERANCE, check_forces
from drystone.mechanics import law
from drystone.mechanics.law import Compliance, wrench_size
from drystone.mechanics.nearby import find_rest_by_rounds, find_rest_nearby, with_forces
from drystone.mechanics.rest import POLISH_AGAIN, find_rest
from drystone.mechanics.rest_state import RestOptions, RestState, Start, start_from
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.solvers.threads import one_blas_thread
from drystone.stability.problem import FALLING_SHARE, Problem, beside_supports, first_motion

AT_REST = RestOptions(ground=1e-14, iteration_limit=30, warm_relaxation=1e-8)
"""Ground so weak that its forces are below every tolerance."""

PROVED = replace(AT_REST, tolerance=3e-9)
"""A third of what a proof allows is unbalanced. Measured from the forces of other rest states, on
eleven models: 1.70 in place of 1.75 times the factorisations of the uniform stiffness, and a tenth
fewer solutions. From the path: 827 factorisations in place of 837 for all stiffnesses of eleven
models, 9 in place of 11 for one of a wall of 10,000 blocks."""

TO_REST = RestOptions(ground=1e-7, tolerance=1e-7, iteration_limit=60, end=PROVED)
"""With ground springs this weak, a structure at rest leans on them by 1e-6 of its load."""


@dataclass(frozen=True)
class Screening(Options):
    """How thoroughly :func:`try_rest` looks for a rest state.

    Attributes
    ----------
    slip_lengths : > 0, < inf
        One friction law each, tried in this order; by the local overlap. ``None`` is the stick-slip
        law.
    numerics
        Of the Newton iteration.
    patient
        Whether a state that leans on the ground springs, or has not converged, is followed on
        weaker ground springs.
    """

    slip_lengths: tuple[float | None, ...] = (None,)
    numerics: RestOptions = TO_REST
    patient: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.slip_lengths:
            raise InputError("there is no slip length", remedy="give None for the stick-slip law")

    def with_slip_lengths(self, *slip_lengths: float | None) -> Screening:
        """The same level with other friction laws."""
        return replace(self, slip_lengths=slip_lengths)


PATIENT = Screening()

QUICK = Screening(numerics=replace(TO_REST, stall=8), patient=False)
"""Measured on stages of vaults and domes: 9 of 10 that rest do so within 8 steps without progress.
Stages that fall are given up after half of the steps."""

NEAREST = replace(QUICK, numerics=replace(QUICK.numerics, warm_relaxation=1e-3, give_up=0.04))
"""Measured on stages of vaults and domes of up to 60 blocks: all 15 that rest are found, and 136
that do not rest take half of the time. In a vault of 366 blocks many that rest are missed. Without
a start it is the level QUICK."""

FEW_BLOCKS, MANY_BLOCKS = 25, 100
"""Free blocks of models whose stages are screened by NEAREST. With fewer blocks the search goes on
for so long that a missed rest state loses the best order (3 of 50 random piles of up to 8 blocks).
With more blocks a missed rest state costs a prop (a vault of 366 blocks: a sixth more props).

Plans check every stage of fewer blocks; of more, where a stage has no more help than the one before
(propped after a quick look only, a vault of 85 blocks has 17 props, not 8). With many, not every
prop is tested at all of its stages: a vault of 366 has hundreds, each in dozens of stages."""


def stage_screening(blocks: int) -> Screening:
    """The level for the stages of a model with some number of free blocks."""
    return NEAREST if FEW_BLOCKS <= blocks <= MANY_BLOCKS else QUICK


LEAST_GROUND = replace(AT_REST, ground=1e-17)
"""For high towers. They sway so far that the ground of AT_REST carries more than a proof allows:
4e-8 of the load of a block with 400 cubes."""

SHARPER = RestOptions(ground=1e-9, tolerance=1e-6)
"""Weaker ground for first motions: close to the limit they are slow, and weaker ground changes them
less."""

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

LIKE = 0.25
"""Change of what blocks miss at first, by itself, with which they fall as blocks did that were
followed. Measured on 144 parts of walls, vaults and a bridge: each falls when it is followed."""

SHORTER_SLIPS = (10.0, 1.0, 0.1)
"""Slip lengths of smooth laws that lead to another one, by the local overlap. Measured on an arch
with a tie and an overhang with a prop, near their limits: from that of 10.0 two of four rest states
are found, from that of 1.0 three, from that of 0.1 all."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """Forces and a motion that may prove that the model stands.

    Attributes
    ----------
    force : (k, 3) [N]
    displacement : (n, 6) [m, rad]
    residuals
    steps
        Newton steps so far.
    falling
        The state on ground springs that lean on, where it does not stand.
    """

    force: Floats
    displacement: Floats
    residuals: Residuals
    steps: int = 0
    falling: RestState | None = None

    @property
    def stands(self) -> bool:
        """Whether every residual is small enough for a proof."""
        return self.residuals.largest <= FORCE_TOLERANCE


class Attempt:
    """The try of one stiffness distribution.

    Parameters
    ----------
    problem, springs
    late
        Asked often; True ends the iteration with the present state.

    Attributes
    ----------
    last
        Where the last try near a start has ended.
    """

    last: RestState

    def __init__(self, problem: Problem, springs: Compliance, late: Callable[[], bool]) -> None:
        self.problem = problem
        self.springs = springs
        self.late = late
        self.steps = 0

    def begun_at(
        self,
        displacement: Floats,
        screening: Screening = PATIENT,
        hopeless: Callable[[], bool] = bool,
    ) -> Candidate | None:
        """The rest state near displacements (n, 6) [m, rad] of a similar model, if there is one.

        A level that is not patient also follows the relaxed law from there; where ``hopeless`` it
        does this alone, as the level NEAREST.

        Raises
        ------
        InputError
            They have another shape, or are not finite.
        """
        start = self._start(displacement)
        unlikely = screening != NEAREST and not screening.patient and hopeless()
        found = None if unlikely else self._near(start)
        if found is not None or screening.patient:
            return found
        numerics = (NEAREST if unlikely else screening).numerics
        # Newton's method on the unrelaxed law was tried there, or is unlikely to help
        return self._followed(
            replace(numerics, polish=POLISH_AGAIN * numerics.warm_relaxation), screening, start
        )

    def begun_to_fall(
        self, displacement: Floats, missing: Floats
    ) -> tuple[Floats, Candidate] | None:
        """The first motion (n, 6), and its state, of blocks that begin to fall as in another model.

        Parameters
        ----------
        displacement : (n, 6) [m, rad]
            The rest state of a similar model.
        missing : (n, 6) [N, N m]
            What the blocks missed there: little where they rested, zero of other blocks.
        """
        problem, statics, start = self.problem, self.problem.statics, self._start(displacement)
        missed = statics.scaled_wrench(missing)
        leaning = -missed / (TO_REST.ground * statics.mass_matrix)
        there = missed.any(axis=1, keepdims=True)
        begin = Start(np.where(there, leaning, start.motion), start.normal)
        state = find_rest_nearby(statics, self.springs, TO_REST, begin, self.late)
        if not state.converged:  # by way of the relaxed law
            state = self._find(NEAREST.numerics, begin)
        if not state.converged or (self._falling(state.ground) != self._falling(missed)).any():
            return None
        if wrench_size(state.ground + missed).max() > LIKE * wrench_size(missed).max():
            return None
        motion = first_motion(problem, state)
        return None if motion is None else (motion, replace(self._examined(state), falling=state))

    def _falling(self, ground: Floats) -> Bools:
        """The free blocks (n,) that lean on the ground springs with wrenches (n, 6), as falling."""
        share = self.problem.ground_share(ground)
        return share > FALLING_SHARE * share.max()

    def with_forces_of(self, rest: Candidate) -> Candidate | None:
        """The rest state from the forces of one with other springs, if there is one near."""
        statics = self.problem.statics
        motion = statics.scaled_motion(rest.displacement, statics.mean_length)
        start = self._with_forces(rest.force, motion)
        return None if start is None else self._by_rounds(start)

    def _from_closed(self) -> Candidate | None:
        """The rest state near where no corner opens or slips, if few steps lead there.

        Measured: 221 of 347 models that stand do so near it, with 520 factorisations in place of
        1,744 and a third of the time; none of 211 others does. Walls of 400 and 2,000 blocks take
        one and two factorisations in place of 14 and 9.
        """
        pressed = np.zeros((self.problem.model.contacts.corner_count, 3))
        pressed[:, 0] = self.problem.statics.force_unit
        start = self._with_forces(pressed, np.zeros_like(self.problem.statics.load))
        return None if start is None or self.late() else self._near(start, hurried=True)

    def _from_elsewhere(
        self, ended: Candidate, balance: Callable[[], Floats | None] | None
    ) -> Candidate | None:
        """The rest state from forces (k, 3) [N] that balance the loads, or where a path ended."""
        statics, found = self.problem.statics, self.from_balance(balance and balance())
        motion = statics.scaled_motion(ended.displacement, statics.mean_length)
        normal = ended.force[self.problem.corners, 0] / statics.force_unit
        return found or self._by_rounds(Start(motion, np.maximum(normal, 0.0)))

    def from_balance(self, force: Floats | None) -> Candidate | None:
        """The rest state that rounds from balancing forces (k, 3) [N] lead to, if there is one."""
        if force is None:
            return None
        start = self._with_forces(force, np.zeros_like(self.problem.statics.load))
        return None if start is None else self._by_rounds(start)

    def _by_rounds(self, start: Start) -> Candidate | None:
        """The rest state that rounds with given friction lead to, if there is one."""
        state = find_rest_by_rounds(self.problem.statics, self.springs, PROVED, start, self.late)
        self.steps += state.iterations
        return self._proved(state)

    def _with_forces(self, force: Floats, motion: Floats) -> Start | None:
        """A start with forces (k, 3) [N] at a scaled motion (n, 6), if there is one."""
        self.steps += 1
        scaled = force[self.problem.corners] / self.problem.statics.force_unit
        try:
            return with_forces(self.problem.statics, self.springs, PROVED, scaled, motion)
        except SolverError:
            return None

    def _near(self, start: Start, hurried: bool = False) -> Candidate | None:
        """The rest state that Newton's method on the unrelaxed law reaches, if there is one."""
        statics = self.problem.statics
        state = find_rest_nearby(statics, self.springs, PROVED, start, self.late, hurried)
        self.last = state
        self.steps += state.iterations if state.converged else 0
        return self._proved(state)

    def _proved(self, state: RestState) -> Candidate | None:
        """A state in physical numbers, where it has converged and stands."""
        found = self._examined(state) if state.converged else None
        return found if found is not None and found.stands else None

    def from_nothing(
        self,
        screening: Screening = PATIENT,
        falls: Callable[[], bool] | None = None,
        balance: Callable[[], Floats | None] | None = None,
    ) -> Candidate:
        """Follow the springs to rest, on ground springs that are made weaker.

        Parameters
        ----------
        screening
        falls
            Whether it falls with every stiffness; called where the ground carries a large share,
            and where the first path makes no progress or does not converge.
        balance
            Any forces (k, 3) [N] that balance the loads, if they are known. Where that path does
            not converge, rounds with given friction begin with them.
        """
        # at the beginning of a path steps are often reduced
        numerics = replace(screening.numerics, give_up=0.0)
        found = self._from_closed() or self._followed(numerics, screening, falls=falls)
        if found.stands or found.falling is not None or not screening.patient or self.late():
            return found
        if falls is not None and falls():
            return found
        return self._from_elsewhere(found, balance) or self._by_shorter_slips() or found

    def falling(self) -> RestState:
        """The state on weak ground springs, from nothing, of what falls slowly."""
        return self._find(SHARPER)

    def _by_shorter_slips(self) -> Candidate | None:
        """The rest state where the path does not converge, from those of smooth friction laws.

        A smooth law is followed more easily. Each rest state is a few steps from the one before.
        """
        state: RestState | None = None
        for slip in SHORTER_SLIPS:
            smooth = law.uniform(self.problem.statics, slip=slip)
            alike = replace(smooth, normal=self.springs.normal, most=self.springs.most)
            state = self._find(AT_REST, state, springs=alike)
            if slip == SHORTER_SLIPS[0] and not state.converged:
                return None
        found = self._examined(self._find(AT_REST, state))
        return found if found.stands else None

    def _followed(
        self,
        numerics: RestOptions,
        screening: Screening,
        start: Start | None = None,
        falls: Callable[[], bool] | None = None,
    ) -> Candidate:
        state = self._find(numerics, start, falls)
        most = self.problem.ground_share(state.ground).max()
        over = self._is_over(state, most, screening, falls)
        final = state if over or state.ended else self._find(AT_REST, state)
        found = self._examined(final)
        if state.ended and not (over or found.stands):
            final = self._find(AT_REST, state)
            found = self._examined(final)
        nearly = not (over or found.stands) and final.unbalanced < NEARLY
        if nearly and self.problem.ground_share(final.ground).max() < CLEARLY:
            found = self._examined(self._find(LEAST_GROUND, final))
        fallen = state.converged and most > FALLS_FROM and not found.stands
        return replace(found, falling=state if fallen else None)

    def _is_over(
        self,
        state: RestState,
        most: float,
        screening: Screening,
        falls: Callable[[], bool] | None,
    ) -> bool:
        """Whether weaker ground springs would not help."""
        rests = state.converged and most < CLEARLY
        if most >= 0.5 or not (screening.patient or rests):
            return True
        if state.converged and most >= CLEARLY and first_motion(self.problem, state) is not None:
            # high towers load this ground as much, and reach a rest state on weaker ground
            return True
        # weaker ground helps hardly ever then: in none of 47 piles, arches and domes
        return not rests and falls is not None and falls()

    def _start(self, displacement: Floats) -> Start:
        count = len(self.problem.model.assembly)
        if np.shape(displacement) != (count, 6) or not np.isfinite(displacement).all():
            raise InputError(f"the start must hold {count} times six finite numbers", where="start")
        statics = self.problem.statics
        motion = statics.scaled_motion(np.asarray(displacement), statics.mean_length)
        return start_from(self.problem.statics, self.springs, motion)

    def _find(
        self,
        options: RestOptions,
        start: RestState | Start | None = None,
        falls: Callable[[], bool] | None = None,
        springs: Compliance | None = None,
    ) -> RestState:
        """A state on ground springs, with the springs of the try or others."""
        chosen = self.springs if springs is None else springs
        state = find_rest(
            self.problem.statics, chosen, options, start=start, stop=self.late, falls=falls
        )
        self.steps += state.iterations
        return state

    def _examined(self, state: RestState) -> Candidate:
        """A state in physical numbers, with its residuals."""
        force = self.problem.force(state.force)
        displacement = self.problem.displacement(state.motion)
        residuals = check_forces(self.problem.model, force, displacement)
        return Candidate(force, displacement, residuals, self.steps)


@checked_call
@one_blas_thread()
def try_rest(
    given: Model | Problem,
    *,
    screening: Screening = PATIENT,
    start: Floats | None = None,
    hopeless: Callable[[], bool] = bool,
    **work: Unpack[LongWork],
) -> Result:
    """Look for a rest state with uniform contact stiffness.

    This is the cheapest proof that a model stands. It never shows that a model falls: use
    :func:`drystone.check` for that. Each friction law is tried after the one before, so an
    ``executor`` has nothing to share.

    Parameters
    ----------
    given
        A model, or the problem that was built of it.
    screening
        How thoroughly to look. The first friction law that leads to rest is the answer.
    start : (n, 6) [m, rad]
        ``displacement`` of the rest state of a similar model with the same blocks. The first law
        begins there, which halves the steps where few blocks differ. The size of the motion does
        not matter. A patient level that finds nothing from the start also begins from nothing.
    hopeless
        Asked of a level that is not patient: whether to look from the start as the level NEAREST
        only.

    Returns
    -------
    Result
        STABLE with forces and a compatible motion, or UNDECIDED. ``falling`` are then the blocks
        that fall with the last law, if there are any.

    Raises
    ------
    InputError
        The start has another shape.
    """
    clock = Clock.of(work)
    clock.tell("rest state", 0, 1)
    problem = Problem.of(given)
    model = problem.model
    if model.contacts.brittle:  # mortar that cracks holds nothing that stands on springs alone
        problem = Problem.build(model.cracked())
    tried: tuple[Candidate, ...] = ()
    falling: tuple[int, ...] = ()
    if problem.statics.free_count == 0:
        force, motion = (
            np.zeros((model.contacts.corner_count, 3)),
            np.zeros((len(model.assembly), 6)),
        )
        found, message = Candidate(force, motion, Residuals()), "every block is fixed"
    elif _falls_freely(problem):
        found, message = Candidate(np.zeros(0), np.zeros(0), Residuals(equilibrium=np.inf)), ""
    else:
        tried = tuple(_by_each_law(problem, screening, start, hopeless, clock.late))
        found, message = tried[-1], "stands"
    if not found.stands:
        message = "no rest state was found; nothing shows that it falls"
        leaning = [one.falling for one in tried if one.falling is not None]
        for state in leaning[-1:]:
            share = problem.ground_share(state.ground)
            chosen = problem.statics.free[share > FALLING_SHARE * share.max()]
            falling = tuple(int(i) for i in chosen)
    stands = found.stands
    ended = sum(one.stands or one.falling is not None or not clock.late() for one in tried)
    return Result(
        method="rest",
        verdict=Verdict.STABLE if stands else Verdict.UNDECIDED,
        model=model,
        message=message,
        falling=falling,
        samples=Samples(ended, sum(one.stands for one in tried)),
        force=found.force if stands else None,
        displacement=found.displacement if stands else None,
        residuals=found.residuals if stands else None,
        stopped=clock.reason,
        solver="rest state by interior points",
        iterations=sum(one.steps for one in tried),
        time_s={"solve": clock.elapsed_s},
    )


def _by_each_law(
    problem: Problem,
    screening: Screening,
    start: Floats | None,
    hopeless: Callable[[], bool],
    late: Callable[[], bool],
) -> Iterator[Candidate]:
    """What each friction law of a level comes to, up to the first that leads to rest."""
    for slip in screening.slip_lengths:
        attempt = Attempt(problem, law.uniform(problem.statics, slip=slip), late)
        found = None if start is None else attempt.begun_at(start, screening, hopeless)
        start = None
        found = attempt.from_nothing(screening) if found is None else found
        yield found
        if found.stands:
            return


def _falls_freely(problem: Problem) -> bool:
    """Whether nothing presses on some blocks beside supports."""
    model, falling = problem.model, problem.unpressed
    return bool(falling.any()) and beside_supports(model.assembly, model.contacts, falling)
