"""Analyses as mathematical programs, a page each: rigid-block equilibrium, penalty, coupled."""

from drystone.base.settings import hold
from drystone.formulations.corner_forces import FrictionCone as FrictionCone
from drystone.formulations.corner_forces import FrictionRule as FrictionRule
from drystone.formulations.equilibrium import Objective as Objective
from drystone.formulations.equilibrium import Weights as Weights
from drystone.programs.cra import CRAOptions as CRAOptions
from drystone.programs.cra import PenaltyOptions as PenaltyOptions
from drystone.programs.cra import solve_cra as solve_cra
from drystone.programs.cra import solve_cra_penalty as solve_cra_penalty
from drystone.programs.force_states import Forces as Forces
from drystone.programs.force_states import find_forces as find_forces
from drystone.programs.rbe import RBEOptions as RBEOptions
from drystone.programs.rbe import build_rbe as build_rbe
from drystone.programs.rbe import solve_rbe as solve_rbe
from drystone.solvers.program import ConicProgram as ConicProgram

__all__ = hold(globals())
