"""Rigid-block equilibrium: necessary for standing, not sufficient."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Unpack

from drystone.checks import check_forces
from drystone.formulations.corner_forces import FrictionCone, FrictionRule
from drystone.formulations.equilibrium import (
    EquilibriumSolution,
    Objective,
    Weights,
    solve_equilibrium,
)
from drystone.io.opening import Given, How, as_model
from drystone.results import Result, Verdict
from drystone.settings import Options, checked_call
from drystone.solvers.conic import ConicOptions, ConicStatus
from drystone.stability.problem import Clock, Problem
from drystone.stability.proofs import found_mechanism, moving_blocks

BALANCE_TOLERANCE = 1e-6
"""Residual of forces that an interior point calls balanced: what it reaches on 10,000 blocks."""

ANY_FORCES = 1e-3
"""Gap to the least forces at which to stop where any forces will do."""


@dataclass(frozen=True)
class RBEOptions(Options):
    """Options of :func:`solve_rbe`.

    Attributes
    ----------
    cone
        Exact unless a pyramid is asked for by name.
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

    @classmethod
    def feasibility(cls, cone: FrictionCone | None = None) -> RBEOptions:
        """The bare question whether any forces balance the loads; any that do are the answer.

        No form with tension follows, and the forces are as balanced as ever but not the least ones:
        about a third of the steps are saved.
        """
        exact = cone if cone is not None else FrictionCone.exact()
        return cls(cone=exact, tension=False, conic=ConicOptions(gap=ANY_FORCES))


@checked_call
def solve_rbe(
    given: Given,
    *,
    options: RBEOptions | None = None,
    stop: Callable[[], bool] | None = None,
    **how: Unpack[How],
) -> Result:
    """Do any contact forces balance the loads?

    Necessary for standing, not sufficient: it believes in prestress that nothing provides.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options
    stop
        Asked at every step; True ends the analysis with what is known, like the time limit.

    Returns
    -------
    Result
        EQUILIBRIUM_EXISTS with forces, or UNSTABLE with a checked mechanism and, in the penalised
        form, the tension that would be needed.

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
    clock = Clock(chosen.conic.time_limit_s, stop)
    problem = Problem.build(as_model(given, **how))

    def run(tension: bool) -> EquilibriumSolution:
        return solve_equilibrium(
            problem.statics,
            cone=chosen.cone,
            objective=chosen.objective,
            weights=chosen.weights,
            tension=tension,
            rule=chosen.rule,
            options=replace(chosen.conic, time_limit_s=clock.left_s),
            stop=clock.late,
        )

    solution = run(False)
    verdict, mechanism = Verdict.UNDECIDED, None
    message = f"the interior point ended with '{solution.raw.message}'"
    force = tension = residuals = None
    if solution.raw.status is ConicStatus.SOLVED:
        force = problem.force(solution.force)
        residuals = check_forces(problem.model, force)
        if max(residuals.equilibrium, residuals.tension) <= BALANCE_TOLERANCE:
            verdict, message = Verdict.EQUILIBRIUM_EXISTS, "some contact forces balance the loads"
    else:
        mechanism = found_mechanism(problem, solution, clock.late)
        if mechanism is not None:
            verdict, message = Verdict.UNSTABLE, "no contact forces can balance the loads"
        elif clock.late():
            steps = solution.raw.iterations
            message = f"{clock.reason} in the interior point (steps: {steps})"
        if chosen.tension and not clock.late():
            penalised = run(True)
            if penalised.raw.status is ConicStatus.SOLVED:
                force = problem.force(penalised.force)
                tension = problem.force(penalised.tension[:, None])[:, 0]
                residuals = check_forces(problem.model, force)
            elif clock.late():
                message += f"; {clock.reason} before the tension that it needs was known"
            elif chosen.rule is FrictionRule.NET:
                message += "; friction on the net normal force cannot balance them with tension"
    return Result(
        method="rbe",
        verdict=verdict,
        model=problem.model,
        message=message,
        force=force,
        tension=tension,
        mechanism=mechanism,
        falling=moving_blocks(problem.model.assembly, mechanism) if mechanism is not None else (),
        residuals=residuals,
        stopped=clock.reason,
        options=chosen,
        solver=solution.raw.solver,
        iterations=solution.raw.iterations,
        time_s={"solve": clock.elapsed_s},
    )
