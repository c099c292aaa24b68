"""Assembly planning: the order of placement, held blocks and props."""

from drystone.base.settings import hold
from drystone.base.workers import DaskWorkers, ExecutorFactory, LocalWorkers
from drystone.sequence.dataset import (
    BuiltOrder,
    Dataset,
    DatasetOptions,
    dataset,
    read_dataset,
)
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.freedom import Freedom, Interlocking, Obstacle, freedom, interlocking
from drystone.sequence.gravity_regions import GravityRegion, gravity_region
from drystone.sequence.handling import (
    GripFace,
    Handling,
    Hold,
    Placement,
    handling,
    without_robot,
)
from drystone.sequence.margins import (
    FrictionSweep,
    Margin,
    Margins,
    margins,
    sweep_friction,
)
from drystone.sequence.path_search import NoPath, PathOptions, RemovalPath, find_path
from drystone.sequence.plan_steps import Prop, Status, Step
from drystone.sequence.planner import PlanOptions, plan
from drystone.sequence.plans import Plan
from drystone.sequence.robots import Robot
from drystone.sequence.rules import Order, RemovalTest, Rules
from drystone.sequence.scaffold_items import (
    Centring,
    Clamp,
    Rope,
    ScaffoldedModel,
    ScaffoldItem,
    Strut,
    with_scaffold,
)
from drystone.sequence.scaffold_places import ScaffoldOptions, Support
from drystone.sequence.scaffolding import Scaffolding, compare_scaffolding, scaffolding
from drystone.sequence.stages import (
    Stage,
    StageAnswer,
    StageCheck,
    StagedModel,
    check_both,
    check_once,
    check_thoroughly,
)
from drystone.sequence.structure import StageAnswers, Structure
from drystone.sequence.sweeps import Pose
from drystone.sequence.turns import Turn, Turns, take_turns

__all__ = [
    "BuiltOrder",
    "Centring",
    "Clamp",
    "DaskWorkers",
    "Dataset",
    "DatasetOptions",
    "Evaluator",
    "ExecutorFactory",
    "Freedom",
    "FrictionSweep",
    "GravityRegion",
    "GripFace",
    "Handling",
    "Hold",
    "Interlocking",
    "LocalWorkers",
    "Margin",
    "Margins",
    "NoPath",
    "Obstacle",
    "Order",
    "PathOptions",
    "Placement",
    "Plan",
    "PlanOptions",
    "Pose",
    "Prop",
    "RemovalPath",
    "RemovalTest",
    "Robot",
    "Rope",
    "Rules",
    "ScaffoldItem",
    "ScaffoldOptions",
    "ScaffoldedModel",
    "Scaffolding",
    "Stage",
    "StageAnswer",
    "StageAnswers",
    "StageCheck",
    "StagedModel",
    "Status",
    "Step",
    "Structure",
    "Strut",
    "Support",
    "Turn",
    "Turns",
    "check_both",
    "check_once",
    "check_thoroughly",
    "compare_scaffolding",
    "dataset",
    "find_path",
    "freedom",
    "gravity_region",
    "handling",
    "interlocking",
    "margins",
    "plan",
    "read_dataset",
    "scaffolding",
    "sweep_friction",
    "take_turns",
    "with_scaffold",
    "without_robot",
]

hold(globals())
