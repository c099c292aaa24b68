"""The verdict with its proof, and the analyses that it uses."""

from drystone.formulations.corner_forces import FrictionCone, FrictionRule
from drystone.formulations.equilibrium import Objective, Weights
from drystone.solvers.program import ConicProgram
from drystone.stability.check_many import check_many
from drystone.stability.check_options import CheckOptions
from drystone.stability.programs.cra import CRAOptions, solve_cra
from drystone.stability.programs.penalty import PenaltyOptions, solve_cra_penalty
from drystone.stability.programs.rbe import RBEOptions, build_rbe, build_rbe_penalty, solve_rbe
from drystone.stability.resting import try_rest
from drystone.stability.screening import PATIENT, QUICK, SMOOTH, Screening
from drystone.stability.verdict import check

__all__ = [
    "PATIENT",
    "QUICK",
    "SMOOTH",
    "CRAOptions",
    "CheckOptions",
    "ConicProgram",
    "FrictionCone",
    "FrictionRule",
    "Objective",
    "PenaltyOptions",
    "RBEOptions",
    "Screening",
    "Weights",
    "build_rbe",
    "build_rbe_penalty",
    "check",
    "check_many",
    "solve_cra",
    "solve_cra_penalty",
    "solve_rbe",
    "try_rest",
]
