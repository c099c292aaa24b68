"""Rigid-block equilibrium: necessary for standing, not sufficient."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.settings import Clock, Options, checked_call
from drystone.checks import check_forces
from drystone.formulations.corner_forces import FrictionCone, FrictionRule
from drystone.formulations.equilibrium import (
    ANY_FORCES,
    EquilibriumSolution,
    Objective,
    Weights,
    build_equilibrium,
    solved,
)
from drystone.formulations.nearest_mechanism import nearest_mechanism
from drystone.io.opening import Given, How, LongHow, as_model
from drystone.mechanics.statics import Statics
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.solvers.program import ConicOptions, ConicProgram, ConicStatus
from drystone.solvers.threads import one_blas_thread
from drystone.stability.problem import (
    UNBALANCED,
    Problem,
    balanced,
    checked_mechanism,
    moving_blocks,
    sound_mechanism,
)
from drystone.stability.strength import carried, crushing_words
from drystone.stability.touching_edges import unless_more_holds

BALANCE_TOLERANCE = 1e-6
"""Residual of forces that an interior point calls balanced: what it reaches on 10,000 blocks."""

BALANCED = "some contact forces balance the loads"
NEAREST = "nearest mechanism by interior points"

STEEP = 1e3
"""Friction coefficient above which forces are also sought in the cone of this one: far above that
of any stone, and solved without loss of digits."""


@dataclass(frozen=True)
class RBEOptions(Options):
    """Options of :func:`solve_rbe`.

    Attributes
    ----------
    cone
        Friction cone; exact by default.
    objective
    weights
    tension
        Also solve the penalised form where no equilibrium without tension exists.
    rule
        Which normal force carries friction in the penalised form.
    conic
        Numerics of the interior point.
    """

    cone: FrictionCone = field(default_factory=FrictionCone.exact)
    objective: Objective = Objective.QUADRATIC
    weights: Weights = field(default_factory=Weights)
    tension: bool = True
    rule: FrictionRule = FrictionRule.PLUS
    conic: ConicOptions = field(default_factory=ConicOptions)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.objective is Objective.VERTEX and not self.cone.sides:
            raise InputError(
                "the exact cone is round, and a vertex is a corner",
                where="objective",
                remedy="give a friction pyramid: the cone octagon",
            )

    @classmethod
    def feasibility(cls, cone: FrictionCone | None = None) -> RBEOptions:
        """Options for the question whether any forces balance the loads.

        There is no form with tension, and the forces are not the least ones: this saves about a
        third of the steps.
        """
        exact = cone if cone is not None else FrictionCone.exact()
        return cls(cone=exact, tension=False, conic=ConicOptions(gap=ANY_FORCES))

    @property
    def any_forces(self) -> bool:
        """Whether any forces within the exact cone, or a mechanism, are an answer."""
        far = self.conic.gap is not None and self.conic.gap >= ANY_FORCES
        return far and not self.tension and self.cone == FrictionCone.exact()


@checked_call
def build_rbe(
    given: Given,
    *,
    options: RBEOptions | None = None,
    tension: bool = False,
    **how: Unpack[How],
) -> ConicProgram:
    """The program that :func:`solve_rbe` solves, with its matrices and named variables.

    Its numbers are dimensionless. Wrenches are divided by the mean load of a free block, moments
    also by the size of the block. ``program.value(x, "force")`` is in newtons.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options
        Cone, objective and weights matter.
    tension
        The penalised program, in which joints may pull at a cost; :func:`solve_rbe` solves it where
        no forces without tension balance the loads. It has one more variable, ``tension``: per
        corner, subtracted from the normal force.

    Returns
    -------
    ConicProgram
        Variables: ``force``, three per corner in local n, u, v; ``length``, the bound on friction,
        in the linear objective with a cost of friction. Rows: ``equilibrium``, six per free block;
        ``friction``; ``no pull`` where the cone does not say so. Corners of interfaces between two
        fixed blocks are left out.

    Raises
    ------
    InputError
        What was given cannot be made into a model.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import tower
    >>> program = drystone.programs.build_rbe(tower(2), friction=0.6)
    >>> program
    ConicProgram(12 unknowns, 18 rows, force)
    >>> program.matrix[program.rows["equilibrium"]].shape
    (6, 12)
    >>> force = program.value(program.solve().x, "force").reshape(-1, 3)
    >>> float(force[:, 0].sum().round(1))
    23544.0
    """
    statics = Problem.build(as_model(given, **how)).statics
    return _program(statics, RBEOptions.of(options), tension)


def _program(statics: Statics, options: RBEOptions, tension: bool) -> ConicProgram:
    return build_equilibrium(
        statics,
        cone=options.cone,
        objective=options.objective,
        weights=options.weights,
        tension=tension,
        rule=options.rule,
    )


@checked_call
@one_blas_thread()
def solve_rbe(
    given: Given,
    *,
    options: RBEOptions | None = None,
    **how: Unpack[LongHow],
) -> Result:
    """Do any contact forces balance the loads?

    Necessary for standing, not sufficient: the forces may include prestress that nothing causes.
    It is one program, so an ``executor`` has nothing to share.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options

    Returns
    -------
    Result
        EQUILIBRIUM_EXISTS with forces, or UNSTABLE with a checked mechanism and, in the penalised
        form, the tension that would be needed. UNDECIDED where near pairs that were not joined
        could hold it.

    Raises
    ------
    InputError
        What was given cannot be made into a model.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import h_model
    >>> drystone.solve_rbe(h_model(), friction=0.6).verdict
    <Verdict.EQUILIBRIUM_EXISTS: 'equilibrium exists'>
    """
    chosen = RBEOptions.of(options)
    clock = Clock.of(how)
    clock.limit_s = min(clock.limit_s, chosen.conic.time_limit_s)

    alone = replace(chosen, tension=False)
    any_forces = replace(alone, conic=replace(alone.conic, gap=ANY_FORCES))

    def ask(model: Model, by: RBEOptions = alone) -> Result:
        """The answer on the contacts of a model, and of what touches beside them."""
        found = _answer(model, by, clock)
        return unless_more_holds(found, partial(ask, by=by), partial(ask, by=any_forces))

    found = ask(as_model(given, **how))
    if chosen.tension and found.verdict is not Verdict.EQUILIBRIUM_EXISTS:
        found = _with_tension(found, chosen, clock)
    return replace(found, options=chosen, time_s={"solve": clock.elapsed_s})


def _answer(model: Model, chosen: RBEOptions, clock: Clock) -> Result:
    """The answer on the contacts of a model."""
    problem = Problem.build(model)
    statics = problem.statics
    # where nothing rubs many forces balance a wall, and the mechanism is sought up to 20 times as
    # long as the program takes
    if chosen.any_forces and statics.dry and statics.free_count and statics.friction.any():
        quick = _nearest(problem, chosen, clock)
        if quick is not None:
            return quick

    if problem.statics.crushing is not None and problem.statics.free_count:
        strong = _within_strength(problem, chosen, clock)
        if chosen.any_forces or strong.verdict is not Verdict.EQUILIBRIUM_EXISTS:
            return strong

    solution = _solution(problem, chosen, clock)
    verdict, mechanism = Verdict.UNDECIDED, None
    message = f"the interior point ended with '{solution.raw.message}'"
    force = residuals = None
    if solution.raw.status is ConicStatus.SOLVED:
        force = problem.force(solution.force)
        pull = None if solution.pull is None else problem.force(solution.pull[:, None])
        residuals = check_forces(problem.model, force, pull=pull)
        if max(residuals.equilibrium, residuals.tension, residuals.crushing) <= BALANCE_TOLERANCE:
            verdict, message = Verdict.EQUILIBRIUM_EXISTS, BALANCED
    else:
        mechanism = checked_mechanism(problem, solution)
        if mechanism is None and problem.statics.dry and not clock.late():
            # close to a limit, or a cone that is almost flat: a friction of 10,000 and more
            other = _nearest(problem, chosen, clock)
            exact = chosen.cone == FrictionCone.exact()
            if other is not None and other.mechanism is None and exact:
                return replace(other, iterations=other.iterations + solution.raw.iterations)
            mechanism = None if other is None else other.mechanism
        if mechanism is not None:
            verdict, message = Verdict.UNSTABLE, UNBALANCED
        elif (problem.statics.friction > STEEP).any():
            message += f"; friction of {problem.statics.friction.max():.3g} strains the numbers"
        elif clock.late():
            steps = solution.raw.iterations
            message = f"{clock.reason} in the interior point (steps: {steps})"
    return _result(
        problem, chosen, clock, verdict, message, mechanism, solution.raw.iterations,
        solution.raw.solver, stopped=clock.reason, force=force, residuals=residuals,
    )  # fmt: skip


def _solution(problem: Problem, options: RBEOptions, clock: Clock) -> EquilibriumSolution:
    """The solution of the program, in the penalised form where the options ask for it."""
    tension = options.tension
    clock.tell("forces with tension" if tension else "equilibrium", int(tension), 2)
    return solved(
        partial(_program, options=options, tension=tension),
        problem.statics,
        replace(options.conic, time_limit_s=clock.left_s),
        stop=clock.late,
        vertex=options.objective is Objective.VERTEX,
    )


def _with_tension(found: Result, options: RBEOptions, clock: Clock) -> Result:
    """The result with forces and the tension that they need, where no forces without any do."""
    problem = Problem.build(found.model)
    if clock.late() or problem.statics.crushing is not None:
        return found
    penalised, message = _solution(problem, options, clock), found.message
    if penalised.raw.status is ConicStatus.SOLVED:
        force = problem.force(penalised.force)
        tension = problem.force(penalised.tension[:, None])[:, 0]
        residuals = check_forces(problem.model, force)
        return replace(found, force=force, tension=tension, residuals=residuals)
    if clock.late():
        message += f"; {clock.reason} before the tension that it needs was known"
    elif options.rule is FrictionRule.NET:
        message += "; friction on the net normal force cannot balance them with tension"
    return replace(found, message=message, stopped=clock.reason)


def _result(
    problem: Problem,
    options: RBEOptions,
    clock: Clock,
    verdict: Verdict,
    message: str,
    mechanism: Floats | None,
    iterations: int,
    solver: str,
    **found: Any,
) -> Result:
    """The result; what falls is what its mechanism moves."""
    falling = moving_blocks(problem.model.assembly, mechanism)
    return Result(
        "rbe", verdict, problem.model, message, mechanism=mechanism, falling=falling,
        options=options, solver=solver, iterations=iterations, time_s={"solve": clock.elapsed_s},
        **found,
    )  # fmt: skip


def _within_strength(problem: Problem, options: RBEOptions, clock: Clock) -> Result:
    """The answer of the largest share of the loads that joints which crush balance."""
    found = carried(problem, options.cone, clock.late, options.any_forces)
    verdict, message = Verdict.UNDECIDED, "no forces within the strength of its joints were found"
    if found.force is not None and found.residuals.largest <= BALANCE_TOLERANCE:
        verdict, message = Verdict.EQUILIBRIUM_EXISTS, BALANCED
    elif found.mechanism is not None:
        verdict = Verdict.UNSTABLE
        known = not options.any_forces or found.share > 0.998  # to three digits
        share = found.share if known else None
        message = crushing_words(problem.model, share, found.mechanism)
    return _result(
        problem, options, clock, verdict, message, found.mechanism, found.iterations,
        "load factor within the strength by interior points", stopped=clock.reason,
        force=found.force, residuals=None if found.force is None else found.residuals,
    )  # fmt: skip


def _nearest(problem: Problem, options: RBEOptions, clock: Clock) -> Result | None:
    """The answer of the mechanism nearest to free fall; None where it proves nothing."""
    found = nearest_mechanism(problem.statics, stop=clock.late)
    mechanism = force = residuals = None
    if found.motion is not None:
        mechanism = sound_mechanism(problem, found.motion)
    else:
        friction = problem.model.contacts.friction
        if not balanced(problem, found.force) and (friction > STEEP).any():
            # forces within a narrower cone are within this one
            narrower = Problem.build(problem.model.with_friction(np.minimum(friction, STEEP)))
            found = nearest_mechanism(narrower.statics, stop=clock.late)
        if balanced(problem, found.force):
            force = problem.force(found.force)
            residuals = check_forces(problem.model, force)
    if mechanism is None and force is None:
        return None
    verdict, message = Verdict.UNSTABLE, UNBALANCED
    if mechanism is None:
        verdict, message = Verdict.EQUILIBRIUM_EXISTS, BALANCED
    return _result(
        problem, options, clock, verdict, message, mechanism, found.iterations, NEAREST,
        force=force, residuals=residuals,
    )  # fmt: skip
