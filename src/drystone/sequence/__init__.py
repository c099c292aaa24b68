"""Assembly planning: in which order, what to hold, what to prop."""

from drystone.sequence.evaluation import Evaluator, LocalWorkers
from drystone.sequence.insertion import Freedom, RemovalTest, freedom
from drystone.sequence.plan import Plan, Prop, Status, Step
from drystone.sequence.planner import PlanOptions, plan
from drystone.sequence.rules import Order, Rules
from drystone.sequence.stages import Answer, Model, Stage, check_once, check_thoroughly

__all__ = [
    "Answer",
    "Evaluator",
    "Freedom",
    "LocalWorkers",
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
    "check_once",
    "check_thoroughly",
    "freedom",
    "plan",
]
