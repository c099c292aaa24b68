"""Stability-aware design: why a structure falls, and which changes make it stand."""

from drystone.design.building.buildable import (
    Buildable,
    BuildableOptions,
    BuildNeeds,
    TriedLayout,
)
from drystone.design.building.buildable_search import make_buildable
from drystone.design.building.joint_recuts import (
    Recut,
    RecutJoint,
    RecutOptions,
    recut_joints,
)
from drystone.design.causes.diagnosed import Diagnosis, Region
from drystone.design.causes.diagnosis import DiagnosisOptions, diagnose
from drystone.design.causes.joint_motion import JointMotion, JointState
from drystone.design.causes.missing import Ballast, JointTurn, Needs, Pull
from drystone.design.causes.prop_forces import PropForce
from drystone.design.mends.bench import Tried
from drystone.design.mends.margin import DesignMargin
from drystone.design.mends.mending import Mending, mend
from drystone.design.mends.mends import Mend, MendOptions, Mends, find_mends
from drystone.design.shaping.free_moves import (
    Moves,
    block_moves,
    free_vertices,
    joint_moves,
    thickening,
)
from drystone.design.shaping.shape_options import HelpMeasure, ShapeAim, Shaped, ShapeOptions
from drystone.design.shaping.shaping import shape
from drystone.design.shaping.variables import FamilyMoves
from drystone.design.tuning.tuned_values import Parameter, Tuned, TuneTrial
from drystone.design.tuning.tuning import TuneOptions, tune
from drystone.design.wedges.sharpening import Sharpened, SharpenOptions, sharpen

__all__ = [
    "Ballast",
    "BuildNeeds",
    "Buildable",
    "BuildableOptions",
    "DesignMargin",
    "Diagnosis",
    "DiagnosisOptions",
    "FamilyMoves",
    "HelpMeasure",
    "JointMotion",
    "JointState",
    "JointTurn",
    "Mend",
    "MendOptions",
    "Mending",
    "Mends",
    "Moves",
    "Needs",
    "Parameter",
    "PropForce",
    "Pull",
    "Recut",
    "RecutJoint",
    "RecutOptions",
    "Region",
    "ShapeAim",
    "ShapeOptions",
    "Shaped",
    "SharpenOptions",
    "Sharpened",
    "Tried",
    "TriedLayout",
    "TuneOptions",
    "TuneTrial",
    "Tuned",
    "block_moves",
    "diagnose",
    "find_mends",
    "free_vertices",
    "joint_moves",
    "make_buildable",
    "mend",
    "recut_joints",
    "shape",
    "sharpen",
    "thickening",
    "tune",
]
