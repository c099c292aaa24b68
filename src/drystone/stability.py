"""Does it stand? The verdict with its proof."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from drystone.assembly import Assembly
from drystone.checks import block_speed, check_forces, corner_motion, mechanism_defects
from drystone.contacts import Contacts
from drystone.formulations import rest
from drystone.formulations.equilibrium import (
    EquilibriumSolution,
    FrictionCone,
    FrictionRule,
    Objective,
    Weights,
    solve_equilibrium,
)
from drystone.formulations.friction import StickSlip
from drystone.geometry.arrays import Bools, Floats
from drystone.loads import LoadCase
from drystone.progress import Progress
from drystone.results import Residuals, Result, Samples, Verdict
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.statics import Statics, build_statics

FORCE_TOLERANCE = 1e-8
"""Largest residual of a claim of equilibrium, dimensionless."""

MECHANISM_TOLERANCE = 1e-6
"""Largest closing of a gap in a claimed mechanism, by the speed of its blocks."""

WITNESS_TOLERANCE = 1e-5
"""The same for a first motion, which the compliance of the contacts blurs by about the weakness of
the ground springs, 1e-7."""

FALLING_SHARE = 1e-3
"""A block falls when the ground springs carry more of its load than this share of the largest."""


@dataclass(frozen=True)
class CheckOptions:
    """Options of :func:`check`.

    Attributes
    ----------
    samples
        Stiffness distributions tried beyond the uniform one, to tell robust from sensitive and to
        find a rest state where uniform stiffness has none.
    seed
        Of the random stiffness distributions.
    time_limit_s
    """

    samples: int = 4
    seed: int = 0
    time_limit_s: float = float("inf")


@dataclass(frozen=True)
class RBEOptions:
    """Options of :func:`solve_rbe`; see :mod:`drystone.formulations.equilibrium`.

    Attributes
    ----------
    cone
        Exact unless a pyramid is asked for by name.
    objective
    weights
    tension
        Also solve the penalised form where no equilibrium without tension exists.
    rule
    conic
        Numerics of the interior point.
    """

    cone: FrictionCone = field(default_factory=FrictionCone.exact)
    objective: Objective = Objective.QUADRATIC
    weights: Weights = field(default_factory=Weights)
    tension: bool = True
    rule: FrictionRule = FrictionRule.PLUS
    conic: ConicOptions = field(default_factory=ConicOptions)


@dataclass(frozen=True, eq=False)
class _Problem:
    """A model with the interfaces between two fixed blocks left out, and the way back."""

    assembly: Assembly
    contacts: Contacts
    load: LoadCase
    active: Bools
    corners: Bools
    statics: Statics

    @classmethod
    def build(cls, assembly: Assembly, contacts: Contacts, load: LoadCase | None) -> _Problem:
        case = load if load is not None else LoadCase.gravity(assembly)
        fixed = assembly.fixed
        active = ~(fixed[contacts.block_a] & fixed[contacts.block_b])
        part = contacts if active.all() else contacts.select(active)
        statics = build_statics(assembly, part, case)
        return cls(assembly, contacts, case, active, active[contacts.interface], statics)

    def force(self, scaled: Floats) -> Floats:
        """Physical corner forces (k, 3) of all corners."""
        out = np.zeros((self.contacts.corner_count, scaled.shape[1]))
        out[self.corners] = self.statics.physical_force(scaled)
        return out

    def motion(self, scaled: Floats) -> Floats:
        """Physical motion (n, 6), the largest speed of a block being the mean size of a block."""
        length = self.statics.mean_length
        moved = self.statics.physical_motion(scaled, len(self.assembly), length)
        speed = float(block_speed(self.assembly, moved).max(initial=0.0))
        return moved * (length / speed) if speed > 0.0 else moved


def check(
    assembly: Assembly,
    contacts: Contacts,
    load: LoadCase | None = None,
    *,
    options: CheckOptions | None = None,
    progress: Progress | None = None,
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

    Returns
    -------
    Result
        STABLE with forces and a compatible motion that pass every check; UNSTABLE with a mechanism;
        UNDECIDED with what was tried.

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
    return _Check(_Problem.build(assembly, contacts, load), chosen, progress).run()


@dataclass(frozen=True, eq=False)
class _Trial:
    """One stiffness distribution, followed to its end."""

    state: rest.RestState
    stands: bool
    falls: bool
    force: Floats
    displacement: Floats
    residuals: Residuals


class _Check:
    """The cascade: rest, impossibility, more rest states, first motion."""

    def __init__(self, problem: _Problem, options: CheckOptions, progress: Progress | None) -> None:
        self.problem = problem
        self.options = options
        self.progress = progress
        self.began = time.perf_counter()
        self.iterations = 0
        self.checking = 0.0
        self.standing: list[_Trial] = []
        self.falling: list[_Trial] = []
        self.tried = 0

    def late(self) -> bool:
        return time.perf_counter() - self.began > self.options.time_limit_s

    def run(self) -> Result:
        problem = self.problem
        total = 2 + self.options.samples
        if problem.statics.free_count == 0:
            return self.answer(
                Verdict.STABLE,
                "every block is fixed",
                force=problem.force(np.zeros((problem.statics.corner_count, 3))),
                displacement=np.zeros((len(problem.assembly), 6)),
                residuals=Residuals(),
            )
        dropped = self.free_fall()
        if dropped is not None:
            return dropped
        compliances = self.compliances()
        uniform = self.attempt(next(compliances))
        self.report("rest state", 1, total)
        infeasible = None
        if not uniform.stands:
            infeasible = self.impossible()
            self.report("equilibrium", 2, total)
            if infeasible is not None:
                return infeasible
        for done, compliance in enumerate(compliances):
            if self.late():
                break
            self.attempt(compliance)
            self.report("stiffness samples", 2 + done, total)
        self.report("done", total, total)
        if self.standing:
            return self.stable(uniform)
        return self.fallen()

    def report(self, stage: str, done: int, total: int) -> None:
        if self.progress is not None:
            self.progress(stage, min(done, total), total)

    def compliances(self) -> Iterator[rest.Compliance]:
        """Uniform stiffness first, then smooth slip of several lengths, then random ones."""
        statics = self.problem.statics
        yield rest.uniform_compliance(statics)
        rng = np.random.default_rng(self.options.seed)
        base = rest.normal_stiffness(statics)
        slips = (1.0, 10.0, 0.1, 100.0)
        for number in range(self.options.samples):
            if number % 2 == 0 and number // 2 < len(slips):
                yield rest.uniform_compliance(statics, slip=slips[number // 2])
            else:
                joints = int(statics.interface.max(initial=-1)) + 1
                factor = 10.0 ** rng.uniform(-2.0, 2.0, joints)
                ratio = 10.0 ** rng.uniform(-2.0, 0.0, joints)
                normal = base * factor[statics.interface]
                tangential = normal * ratio[statics.interface]
                yield rest.Compliance(normal, StickSlip(statics.friction, tangential))

    def attempt(self, compliance: rest.Compliance) -> _Trial:
        statics = self.problem.statics
        self.tried += 1
        loose = rest.RestOptions(ground=1e-7, tolerance=1e-7, iteration_limit=60)
        state = rest.find_rest(statics, compliance, loose, stop=self.late)
        self.iterations += state.iterations
        share = _ground_share(statics, state)
        final = state
        if share.max() < 0.5:
            tight = rest.RestOptions(ground=1e-14, iteration_limit=30, warm_relaxation=1e-6)
            final = rest.find_rest(statics, compliance, tight, start=state, stop=self.late)
            self.iterations += final.iterations
        started = time.perf_counter()
        force = self.problem.force(final.force)
        displacement = statics.physical_motion(
            final.motion, len(self.problem.assembly), statics.mean_length
        )
        residuals = check_forces(
            self.problem.assembly, self.problem.contacts, self.problem.load, force, displacement
        )
        self.checking += time.perf_counter() - started
        stands = residuals.largest <= FORCE_TOLERANCE
        falls = not stands and state.converged and share.max() > 1e-4
        trial = _Trial(final if stands else state, stands, falls, force, displacement, residuals)
        if stands:
            self.standing.append(trial)
        elif falls:
            self.falling.append(trial)
        return trial

    def free_fall(self) -> Result | None:
        """UNSTABLE when the loads press some blocks against nothing and the others stand.

        Contact forces answer pressing. Blocks that the loads accelerate without approaching any
        corner feel none, at whatever friction: a block between two vertical walls falls, although
        forces that nothing provides could hold it.
        """
        problem = self.problem
        assembly = problem.assembly
        acceleration = np.zeros((len(assembly), 6))
        acceleration[problem.statics.free] = problem.load.wrench[problem.statics.free]
        acceleration[:, :3] /= assembly.mass[:, None]
        acceleration[:, 3:] /= (assembly.mass * assembly.size**2)[:, None]
        falling = unpressed(assembly, problem.contacts, acceleration)
        if not falling.any():
            return None
        others = np.flatnonzero(~falling)
        if not assembly.fixed[others].all():
            part = check(
                assembly.subset(others.tolist()),
                problem.contacts.of_blocks(others, len(assembly)),
                LoadCase(problem.load.wrench[others]),
                options=replace(self.options, samples=1),
            )
            self.iterations += part.iterations
            if part.verdict is not Verdict.STABLE:
                return None
        motion = np.where(falling[:, None], acceleration, 0.0)
        speed = float(block_speed(assembly, motion).max())
        return self.answer(
            Verdict.UNSTABLE,
            "nothing presses on these blocks, so nothing holds them: they fall freely",
            mechanism=motion * (problem.statics.mean_length / speed),
            prop=np.where(falling[:, None], -problem.load.wrench, 0.0),
            falling=tuple(int(i) for i in np.flatnonzero(falling)),
        )

    def impossible(self) -> Result | None:
        """UNSTABLE when no contact forces balance the loads, with the mechanism."""
        problem = self.problem
        left = self.options.time_limit_s - (time.perf_counter() - self.began)
        solution = solve_equilibrium(
            problem.statics, cone=FrictionCone.exact(), options=ConicOptions(time_limit_s=left)
        )
        self.iterations += solution.raw.iterations
        if solution.raw.status is not ConicStatus.INFEASIBLE:
            return None
        mechanism = checked_mechanism(problem, solution)
        if mechanism is None:
            return None
        return self.unstable(
            "no contact forces can balance the loads", mechanism, self.falling[-1:] or None
        )

    def stable(self, uniform: _Trial) -> Result:
        best = uniform if uniform.stands else self.standing[0]
        robust = len(self.standing) == self.tried
        words = (
            "stands whatever contact stiffness was tried"
            if robust
            else f"stands for {len(self.standing)} of {self.tried} contact stiffnesses tried"
        )
        return self.answer(
            Verdict.STABLE,
            words,
            force=best.force,
            displacement=best.displacement,
            residuals=best.residuals,
        )

    def fallen(self) -> Result:
        problem = self.problem
        if self.falling:
            trial = self.falling[0]
            share = _ground_share(problem.statics, trial.state)
            moving = (share > FALLING_SHARE * share.max())[:, None]
            motion = problem.motion(np.where(moving, trial.state.motion, 0.0))
            if witness_defect(problem, motion) <= WITNESS_TOLERANCE:
                return self.unstable(
                    "some forces balance the loads, but only with prestress: "
                    "released, it starts to move",
                    motion,
                    [trial],
                )
        return self.answer(
            Verdict.UNDECIDED,
            f"no rest state in {self.tried} stiffness distributions, and no proof that there "
            "is none; more samples may help",
        )

    def unstable(self, message: str, mechanism: Floats, trials: list[_Trial] | None) -> Result:
        problem = self.problem
        if trials:
            share = _ground_share(problem.statics, trials[0].state)
            falling = problem.statics.free[share > FALLING_SHARE * share.max()]
            prop = -problem.statics.physical_wrench(trials[0].state.ground, len(problem.assembly))
            force, residuals = trials[0].force, trials[0].residuals
        else:
            speed = block_speed(problem.assembly, mechanism)
            falling = np.flatnonzero(speed > FALLING_SHARE * speed.max())
            prop, force, residuals = None, None, None
        return self.answer(
            Verdict.UNSTABLE,
            message,
            mechanism=mechanism,
            prop=prop,
            force=force,
            residuals=residuals,
            falling=tuple(int(i) for i in falling),
        )

    def answer(self, verdict: Verdict, message: str, **found: object) -> Result:
        elapsed = time.perf_counter() - self.began
        return Result(
            method="check",
            verdict=verdict,
            assembly=self.problem.assembly,
            contacts=self.problem.contacts,
            load=self.problem.load,
            message=message,
            samples=Samples(self.tried, len(self.standing)),
            options=self.options,
            solver="drystone rest",
            iterations=self.iterations,
            time_s={"solve": elapsed - self.checking, "check": self.checking},
            **found,  # type: ignore[arg-type]
        )


def _ground_share(statics: Statics, state: rest.RestState) -> Floats:
    """Share of each block's load that the ground springs carry."""
    size = np.linalg.norm(state.ground[:, :3], axis=1) + np.linalg.norm(state.ground[:, 3:], axis=1)
    load = np.linalg.norm(statics.load, axis=1)
    return size / np.where(load > 0.0, load, 1.0)


def unpressed(assembly: Assembly, contacts: Contacts, acceleration: Floats) -> Bools:
    """The largest set (n,) of free blocks whose free motion approaches no corner.

    Parameters
    ----------
    acceleration : (n, 6)
        Of each block under its load alone; blocks outside the set rest.
    """
    falling = ~assembly.fixed & (block_speed(assembly, acceleration) > 0.0)
    a = contacts.block_a[contacts.interface]
    b = contacts.block_b[contacts.interface]
    while falling.any():
        motion = np.where(falling[:, None], acceleration, 0.0)
        speed = block_speed(assembly, motion)
        reach = np.maximum(speed[a], speed[b])
        approach = corner_motion(assembly, contacts, motion)[:, 0] < -1e-12 * reach
        pressed = np.zeros(len(assembly), dtype=bool)
        pressed[a[approach]] = pressed[b[approach]] = True
        if not (falling & pressed).any():
            break
        falling &= ~pressed
    return falling


def witness_defect(problem: _Problem, motion: Floats) -> float:
    """How fast gaps close in a first motion (0: not at all), by the speed of the blocks."""
    closing = replace(problem.contacts, friction=np.zeros(problem.contacts.count))
    return mechanism_defects(problem.assembly, closing, problem.load, motion)[0]


def checked_mechanism(problem: _Problem, solution: EquilibriumSolution) -> Floats | None:
    """The multiplier as a physical mechanism, if it passes the check."""
    motion = problem.motion(solution.multiplier)
    violation, power = mechanism_defects(problem.assembly, problem.contacts, problem.load, motion)
    return motion if violation <= MECHANISM_TOLERANCE and power > 1e-9 else None


def solve_rbe(
    assembly: Assembly,
    contacts: Contacts,
    load: LoadCase | None = None,
    *,
    options: RBEOptions | None = None,
) -> Result:
    """Rigid-block equilibrium: do any contact forces balance the loads?

    Necessary for standing, not sufficient: RBE believes in prestress that nothing provides.

    Parameters
    ----------
    assembly
    contacts
    load
        Gravity along -z when left out.
    options

    Returns
    -------
    Result
        EQUILIBRIUM_EXISTS with forces, or UNSTABLE with a checked mechanism and, in the
        penalised form, the tension that would be needed.
    """
    chosen = options if options is not None else RBEOptions()
    began = time.perf_counter()
    problem = _Problem.build(assembly, contacts, load)

    def run(tension: bool) -> EquilibriumSolution:
        return solve_equilibrium(
            problem.statics,
            cone=chosen.cone,
            objective=chosen.objective,
            weights=chosen.weights,
            tension=tension,
            rule=chosen.rule,
            options=chosen.conic,
        )

    solution = run(False)
    verdict, message, mechanism = Verdict.UNDECIDED, solution.raw.message, None
    force = tension = residuals = None
    if solution.raw.status is ConicStatus.SOLVED:
        force = problem.force(solution.force)
        residuals = check_forces(assembly, contacts, problem.load, force)
        if residuals.equilibrium <= 1e-6 and residuals.tension <= 1e-6:
            verdict, message = Verdict.EQUILIBRIUM_EXISTS, "some contact forces balance the loads"
    elif solution.raw.status is ConicStatus.INFEASIBLE:
        mechanism = checked_mechanism(problem, solution)
        if mechanism is not None:
            verdict, message = Verdict.UNSTABLE, "no contact forces can balance the loads"
        if chosen.tension:
            penalised = run(True)
            if penalised.raw.status is ConicStatus.SOLVED:
                force = problem.force(penalised.force)
                tension = problem.force(penalised.tension[:, None])[:, 0]
                residuals = check_forces(assembly, contacts, problem.load, force)
    falling: tuple[int, ...] = ()
    if mechanism is not None:
        speed = block_speed(assembly, mechanism)
        falling = tuple(int(i) for i in np.flatnonzero(speed > FALLING_SHARE * speed.max()))
    return Result(
        method="rbe",
        verdict=verdict,
        assembly=assembly,
        contacts=contacts,
        load=problem.load,
        message=message,
        force=force,
        tension=tension,
        mechanism=mechanism,
        falling=falling,
        residuals=residuals,
        options=chosen,
        solver=solution.raw.solver,
        iterations=solution.raw.iterations,
        time_s={"solve": time.perf_counter() - began},
    )
