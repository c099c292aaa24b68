"""Assembly planning: in which order, what to hold, what to prop."""

from drystone.sequence.cuts import Cut, CutDesign, Trial, cut_block, design_cuts, tilted_cuts
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.insertion import Freedom, RemovalTest, freedom
from drystone.sequence.judges import check_once, check_thoroughly
from drystone.sequence.margins import (
    FrictionSweep,
    Margin,
    MarginOptions,
    Margins,
    least_buildable_friction,
    margins,
    sweep_friction,
)
from drystone.sequence.model import Model
from drystone.sequence.planner import PlanOptions, plan
from drystone.sequence.plans import Plan, Prop, Status, Step
from drystone.sequence.report import save_table, table_text
from drystone.sequence.rules import Order, Rules
from drystone.sequence.stages import Answer, Stage
from drystone.sequence.workers import DaskWorkers, ExecutorFactory, LocalWorkers

__all__ = [
    "Answer",
    "Cut",
    "CutDesign",
    "DaskWorkers",
    "Evaluator",
    "ExecutorFactory",
    "Freedom",
    "FrictionSweep",
    "LocalWorkers",
    "Margin",
    "MarginOptions",
    "Margins",
    "Model",
    "Order",
    "Plan",
    "PlanOptions",
    "Prop",
    "RemovalTest",
    "Rules",
    "Stage",
    "Status",
    "Step",
    "Trial",
    "check_once",
    "check_thoroughly",
    "cut_block",
    "design_cuts",
    "freedom",
    "least_buildable_friction",
    "margins",
    "plan",
    "save_table",
    "sweep_friction",
    "table_text",
    "tilted_cuts",
]
