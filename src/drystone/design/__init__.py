"""Stability-aware design: why a structure falls, and which changes make it stand.

Each name is loaded when it is first asked for: a diagnosis needs neither shells nor plans.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from drystone.design.building.buildable import Buildable as Buildable
    from drystone.design.building.buildable import BuildableOptions as BuildableOptions
    from drystone.design.building.buildable import BuildNeeds as BuildNeeds
    from drystone.design.building.buildable import TriedLayout as TriedLayout
    from drystone.design.building.buildable_search import make_buildable as make_buildable
    from drystone.design.building.joint_recuts import Recut as Recut
    from drystone.design.building.joint_recuts import RecutJoint as RecutJoint
    from drystone.design.building.joint_recuts import RecutOptions as RecutOptions
    from drystone.design.building.joint_recuts import recut_joints as recut_joints
    from drystone.design.causes.diagnosed import Diagnosis as Diagnosis
    from drystone.design.causes.diagnosed import Region as Region
    from drystone.design.causes.diagnosis import DiagnosisOptions as DiagnosisOptions
    from drystone.design.causes.diagnosis import diagnose as diagnose
    from drystone.design.causes.joint_motion import JointMotion as JointMotion
    from drystone.design.causes.joint_motion import JointState as JointState
    from drystone.design.causes.missing import Ballast as Ballast
    from drystone.design.causes.missing import JointTurn as JointTurn
    from drystone.design.causes.missing import Needs as Needs
    from drystone.design.causes.missing import Pull as Pull
    from drystone.design.causes.prop_forces import PropForce as PropForce
    from drystone.design.mends.bench import Tried as Tried
    from drystone.design.mends.margin import DesignMargin as DesignMargin
    from drystone.design.mends.mending import Mending as Mending
    from drystone.design.mends.mending import mend as mend
    from drystone.design.mends.mends import Mend as Mend
    from drystone.design.mends.mends import MendOptions as MendOptions
    from drystone.design.mends.mends import Mends as Mends
    from drystone.design.mends.mends import find_mends as find_mends
    from drystone.design.shaping.free_moves import Moves as Moves
    from drystone.design.shaping.free_moves import block_moves as block_moves
    from drystone.design.shaping.free_moves import free_vertices as free_vertices
    from drystone.design.shaping.free_moves import joint_moves as joint_moves
    from drystone.design.shaping.free_moves import thickening as thickening
    from drystone.design.shaping.shape_options import HelpMeasure as HelpMeasure
    from drystone.design.shaping.shape_options import ShapeAim as ShapeAim
    from drystone.design.shaping.shape_options import Shaped as Shaped
    from drystone.design.shaping.shape_options import ShapeOptions as ShapeOptions
    from drystone.design.shaping.shaping import shape as shape
    from drystone.design.shaping.shared_planes import PlaneMoves as PlaneMoves
    from drystone.design.shaping.variables import FamilyMoves as FamilyMoves
    from drystone.design.tuning.tuned_values import Parameter as Parameter
    from drystone.design.tuning.tuned_values import Tuned as Tuned
    from drystone.design.tuning.tuned_values import TuneTrial as TuneTrial
    from drystone.design.tuning.tuning import TuneOptions as TuneOptions
    from drystone.design.tuning.tuning import tune as tune
    from drystone.design.wedges.sharpening import Sharpened as Sharpened
    from drystone.design.wedges.sharpening import SharpenOptions as SharpenOptions
    from drystone.design.wedges.sharpening import sharpen as sharpen

_HOME = {
    "Ballast": "causes.missing",
    "BuildNeeds": "building.buildable",
    "Buildable": "building.buildable",
    "BuildableOptions": "building.buildable",
    "DesignMargin": "mends.margin",
    "Diagnosis": "causes.diagnosed",
    "DiagnosisOptions": "causes.diagnosis",
    "FamilyMoves": "shaping.variables",
    "HelpMeasure": "shaping.shape_options",
    "JointMotion": "causes.joint_motion",
    "JointState": "causes.joint_motion",
    "JointTurn": "causes.missing",
    "Mend": "mends.mends",
    "MendOptions": "mends.mends",
    "Mending": "mends.mending",
    "Mends": "mends.mends",
    "Moves": "shaping.free_moves",
    "Needs": "causes.missing",
    "Parameter": "tuning.tuned_values",
    "PlaneMoves": "shaping.shared_planes",
    "PropForce": "causes.prop_forces",
    "Pull": "causes.missing",
    "Recut": "building.joint_recuts",
    "RecutJoint": "building.joint_recuts",
    "RecutOptions": "building.joint_recuts",
    "Region": "causes.diagnosed",
    "ShapeAim": "shaping.shape_options",
    "ShapeOptions": "shaping.shape_options",
    "Shaped": "shaping.shape_options",
    "SharpenOptions": "wedges.sharpening",
    "Sharpened": "wedges.sharpening",
    "Tried": "mends.bench",
    "TriedLayout": "building.buildable",
    "TuneOptions": "tuning.tuning",
    "TuneTrial": "tuning.tuned_values",
    "Tuned": "tuning.tuned_values",
    "block_moves": "shaping.free_moves",
    "diagnose": "causes.diagnosis",
    "find_mends": "mends.mends",
    "free_vertices": "shaping.free_moves",
    "joint_moves": "shaping.free_moves",
    "make_buildable": "building.buildable_search",
    "mend": "mends.mending",
    "recut_joints": "building.joint_recuts",
    "shape": "shaping.shaping",
    "sharpen": "wedges.sharpening",
    "thickening": "shaping.free_moves",
    "tune": "tuning.tuning",
}
"""The module that each public name lives in."""

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'drystone.design' has no attribute '{name}'")
    value = getattr(import_module(f"drystone.design.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
