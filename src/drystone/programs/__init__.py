"""Analyses as mathematical programs, a page each: rigid-block equilibrium, penalty, coupled."""

from drystone.formulations.corner_forces import FrictionCone, FrictionRule
from drystone.formulations.equilibrium import Objective, Weights
from drystone.programs.cra import CRAOptions, PenaltyOptions, solve_cra, solve_cra_penalty
from drystone.programs.force_states import Forces, find_forces
from drystone.programs.rbe import RBEOptions, build_rbe, solve_rbe
from drystone.solvers.program import ConicProgram

__all__ = [
    "CRAOptions",
    "ConicProgram",
    "Forces",
    "FrictionCone",
    "FrictionRule",
    "Objective",
    "PenaltyOptions",
    "RBEOptions",
    "Weights",
    "build_rbe",
    "find_forces",
    "solve_cra",
    "solve_cra_penalty",
    "solve_rbe",
]
